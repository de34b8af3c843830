//! Where the guide stands, for people: one line an answer.

use super::{number::short, plan::place};
use crate::commands::guide::{Answer, Undone};

/// An answer as one line.
pub(crate) fn answer(answer: &Answer) -> String {
    let mut sentences: Vec<String> = answer.undone.iter().map(undone).collect();
    sentences.push(beginning(answer));
    let next = answer.next.as_ref().map(|next| place(next, answer.units));
    match answer.state {
        "error" => {
            let error = answer.error.as_ref().map_or("", |error| error.message.as_str());
            return format!("line {} is skipped: {error}", answer.line.unwrap_or_default());
        }
        "unfinished" => {
            let missing = answer.missing.as_ref().map_or_else(
                || "the frame is not as sure as it should be".to_owned(),
                |missing| format!("too few touches: {missing}"),
            );
            return format!("The touches ended before the frame was found: {missing}.");
        }
        "free" => sentences.extend([free(answer)]),
        "located" => sentences.push(format!("one frame fits, {}", sure(answer))),
        "done" => {
            sentences.push(format!("one frame fits, {}", sure(answer)));
            sentences.push("Done.".to_owned());
        }
        _ => sentences.extend(refused(answer)),
    }
    if let Some(place) = next {
        let effect = answer.next.as_ref().and_then(|next| match (next.sigmas, next.worst_after) {
            (Some(sigmas), _) => {
                Some(format!(" (its readings differ by {} standard deviations)", short(sigmas)))
            }
            _ => None,
        });
        sentences.push(format!("Touch next: {place}{}.", effect.unwrap_or_default()));
    }
    sentences.join(" ")
}

/// What was taken back.
fn undone(undone: &Undone) -> String {
    match (undone.touch, &undone.surface) {
        (Some(touch), Some(surface)) => format!("touch {touch} on `{surface}` is taken back;"),
        _ => "there was no touch to take back;".to_owned(),
    }
}

fn beginning(answer: &Answer) -> String {
    match (answer.touch, &answer.surface) {
        (Some(touch), Some(surface)) => format!("touch {touch} on `{surface}`:"),
        _ => "no touch yet:".to_owned(),
    }
}

/// What is free, and what is missing.
fn free(answer: &Answer) -> String {
    let missing = answer.missing.as_ref().map_or(String::new(), |missing| format!(" Needed: {missing}."));
    let told = match answer.free.len() {
        0 if answer.touches == 0 => format!("all {} motions are free.", answer.unknowns),
        0 => "no motion is free to first order.".to_owned(),
        count => format!("{count} of {} motions free: {}.", answer.unknowns, answer.free.join("; ")),
    };
    told + &missing
}

/// How sure the frame is.
fn sure(answer: &Answer) -> String {
    let Some(expanded) = answer.expanded else { return "how sure it is no sigma tells.".to_owned() };
    let target = answer.target.map_or(String::new(), |target| format!(", the target is {}", short(target)));
    format!("sure to {} {} (95 %) at the worst point of use{target}.", short(expanded), answer.units)
}

/// Why there is no frame, and what to do.
fn refused(answer: &Answer) -> Vec<String> {
    let Some(error) = &answer.error else { return Vec::new() };
    let help = match answer.state {
        "inconsistent" => "Touch there again, or `undo` it.".to_owned(),
        _ if answer.free.is_empty() => String::new(),
        _ => format!("Free: {}.", answer.free.join("; ")),
    };
    let told = [format!("{}.", error.message), help];
    told.into_iter().filter(|sentence| !sentence.is_empty()).collect()
}
