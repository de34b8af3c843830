//! The verdict in words: found, how sure, as long as what holds, and what was not believed.

use std::collections::BTreeMap;

use touchref_core::observability::direction_in_words;
use touchref_io::{
    number::{decimals, fixed, short, short_or_dash},
    words::{condition, counted, in_words, left_out, length_decimals, unknowns},
};

use crate::subject::{Influence, Observed, PROBABILITY, Subject};

/// What a reader should take away before any table.
pub(crate) struct Verdict {
    pub(crate) headline: String,
    /// Whether there is nothing to mind.
    pub(crate) sound: bool,
    /// Questions and their answers.
    pub(crate) answers: Vec<(&'static str, String)>,
}

/// Below this chance touches that are sound seldom fit so badly.
const SELDOM: f64 = 0.05;

impl Verdict {
    pub(crate) fn of(subject: &Subject<'_>, influences: &Result<Vec<Influence>, String>) -> Self {
        let record = subject.record;
        let mut answers = vec![("Where it is", place(subject)), ("How sure that is", sureness(subject))];
        answers.push(("When it stands", margin(subject)));
        answers.push(("Do the touches agree", agreement(subject)));
        let excluded: Vec<_> = record.touches.iter().filter(|touch| touch.excluded).collect();
        if !excluded.is_empty() {
            let told =
                excluded.iter().map(|touch| left_out(touch, &record.units)).collect::<Vec<_>>().join(" ");
            answers.push((
                "What is left out",
                format!("{told} The frame does not rest on it: find out why before the frame is used."),
            ));
        }
        answers.push(("What else was possible", alternatives(subject)));
        answers.push(("What the touches see least", weakest(subject)));
        if let Some(told) = influences.as_ref().ok().and_then(|all| unchecked(all)) {
            answers.push(("What nothing checks", told));
        }
        if !record.free.is_empty() {
            answers.push(("What is left free", freedom(&record.free)));
        }
        let found: Vec<_> = record.touches.iter().filter(|touch| touch.label_found).collect();
        if !found.is_empty() {
            let told = found.iter().map(|touch| format!("touch {} on `{}`", touch.index, touch.surface));
            let told = told.collect::<Vec<_>>().join(", ");
            answers.push((
                "What was found out",
                format!(
                    "The measurement leaves open which surface was touched; only one labelling fits: {told}."
                ),
            ));
        }
        let within = record.trust.sigma.map(|sigma| {
            record.trust.from_sigma.is_none_or(|from| from <= sigma)
                && record.trust.up_to_sigma.is_none_or(|to| sigma <= to)
        });
        let headline = match (excluded.len(), &subject.covariance, within) {
            (_, _, Some(false)) => {
                "Frame found, but its stated sigma is outside the margin in which it stands.".to_owned()
            }
            (1, _, _) => format!("Frame found without touch {}, which is held for bad.", excluded[0].index),
            (2.., _, _) => format!("Frame found without {} touches, which are held for bad.", excluded.len()),
            (0, None, _) => "Frame found; how sure it is cannot be told.".to_owned(),
            (0, Some(_), None) => "Frame found, on a condition.".to_owned(),
            (0, Some(_), Some(true)) => "Frame found; it passed its checks.".to_owned(),
        };
        let likely = record.p_value.is_none_or(|p| p >= SELDOM);
        let sound = within == Some(true) && excluded.is_empty() && subject.covariance.is_some() && likely;
        Self { headline, sound, answers }
    }
}

fn place(subject: &Subject<'_>) -> String {
    let units = subject.units.name();
    let u = subject.spread_of_point(&nalgebra::Point3::origin()).map(|spread| spread.along_axes());
    let least = u.and_then(|u| u.into_iter().filter(|u| *u > 0.0).reduce(f64::min));
    let digits = decimals(least, length_decimals(units));
    let [x, y, z] = subject.record.frame.origin.map(|v| fixed(v, digits));
    format!(
        "The origin of the fixture ({}) is at x {x}, y {y}, z {z} {units} in the frame in which the touches are told.",
        subject.record.fixture.kind
    )
}

fn sureness(subject: &Subject<'_>) -> String {
    let units = subject.units.name();
    let origin = nalgebra::Point3::origin();
    let (Some(covariance), Some(place), Some(turn)) =
        (&subject.covariance, subject.spread_of_point(&origin), subject.spread_of_turn())
    else {
        return "That cannot be told: no sigma is stated, and no touch beyond the unknowns tells it. State the standard \
                deviation of one touch, or touch more, and locate again."
            .to_owned();
    };
    let factor = subject.coverage_factor();
    let along = |direction| {
        let told = direction_in_words(&*subject.fixture, &subject.frame, direction);
        if told.starts_with(|c: char| c.is_ascii_digit()) { format!("a direction {told}") } else { told }
    };
    let (u, direction) = place.worst();
    let (turn, axis) = turn.worst();
    let sigma = covariance.sigma.is_finite().then(|| format!("{} {units}", short(covariance.sigma)));
    let sigma = sigma.unwrap_or_else(|| "a size that the result does not tell".to_owned());
    let source = match subject.degrees_of_freedom() {
        None => "as stated".to_owned(),
        Some(degrees) => format!(
            "as the residuals tell it, with {}",
            counted(degrees, "degree of freedom", "degrees of freedom")
        ),
    };
    format!(
        "At {} % coverage the origin is known to \u{b1}{} {units} where it is known least, along {}; the orientation to \
         \u{b1}{} degrees, about {}. This rests on a sigma of one touch of {sigma}, {source} (coverage factor {}).",
        short(100.0 * PROBABILITY),
        short(factor * u),
        along(&direction),
        short((factor * turn).to_degrees()),
        along(&axis),
        fixed(factor, 2),
    )
}

fn margin(subject: &Subject<'_>) -> String {
    let trust = &subject.record.trust;
    let told = condition(trust, subject.units.name());
    match (trust.sigma, trust.up_to_sigma) {
        (Some(sigma), Some(to)) if sigma > 0.0 && to > sigma => {
            format!("{told} The noise could be {} times larger before that.", short(to / sigma))
        }
        (None, _) => format!(
            "{told} Whether it does is for you to say: state it, and locate again for a plain answer."
        ),
        _ => told,
    }
}

fn agreement(subject: &Subject<'_>) -> String {
    let record = subject.record;
    let units = subject.units.name();
    let unknowns = in_words(unknowns(record));
    let beyond = counted(record.degrees_of_freedom, "touch", "touches");
    match (record.degrees_of_freedom, record.chi_square, record.p_value) {
        (0, ..) => format!(
            "There are as many touches as unknowns ({unknowns}): any touches would fit, and nothing checks them."
        ),
        (_, Some(chi_square), Some(p)) => {
            let often = format!(
                "noise of the stated size alone makes them fit this badly or worse in {} % of measurements (chi-square {}, \
                 p = {})",
                short(100.0 * p),
                short(chi_square),
                short(p)
            );
            let told = format!("{beyond} beyond the {unknowns} unknowns: {often}.");
            if p < SELDOM {
                format!("Hardly, with {told} Look at the largest residual, and at the stated sigma.")
            } else {
                format!("Yes, with {told}")
            }
        }
        _ => format!(
            "They miss their surfaces by {} {units} (rms), with {beyond} beyond the {unknowns} unknowns. Whether that is much only \
             a stated sigma could tell.",
            short_or_dash(record.rms)
        ),
    }
}

fn alternatives(subject: &Subject<'_>) -> String {
    /// More reasons than this do not read well.
    const MOST_REASONS: usize = 3;
    let record = subject.record;
    let rejected: Vec<_> = record.roots.iter().filter(|root| !root.selected).collect();
    let told = if record.roots.is_empty() {
        "No list of other frames is part of this result.".to_owned()
    } else if rejected.is_empty() {
        "Only this frame satisfies the equations.".to_owned()
    } else {
        let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
        for root in &rejected {
            *reasons.entry(root.reason.as_str()).or_default() += 1;
        }
        let reasons = reasons.iter().map(|(reason, count)| match count {
            1 => (*reason).to_owned(),
            count => format!("{reason} ({count} of them)"),
        });
        let reasons = if reasons.len() > MOST_REASONS {
            "each for a reason of its own, which stands in the table".to_owned()
        } else {
            reasons.collect::<Vec<_>>().join("; ")
        };
        let all = counted(record.roots.len(), "frame", "frames");
        format!("{all} satisfy the equations or nearly so; {} rejected: {reasons}.", are(rejected.len()))
    };
    let best =
        rejected.iter().filter_map(|root| root.misfit).reduce(f64::min).map_or(String::new(), |misfit| {
            format!(" The best of these is off by {} standard deviations.", short(misfit))
        });
    let second = record.trust.second_minimum.as_ref().and_then(|second| second.chi_square);
    let second = second.map_or(String::new(), |second| {
        let own = record.chi_square.map_or(String::new(), |own| format!(" (this one: {})", short(own)));
        format!(" The next best frame of all has a chi-square of {}{own}.", short(second))
    });
    told + &best + &second
}

fn are(count: usize) -> String {
    if count == 1 { "1 is".to_owned() } else { format!("{count} are") }
}

fn weakest(subject: &Subject<'_>) -> String {
    let seen = &subject.record.observability;
    format!(
        "A {}. The touches determine {} of {} motions; condition {}.",
        seen.weakest,
        seen.rank,
        unknowns(subject.record),
        seen.condition.map_or_else(|| "unbounded".to_owned(), short)
    )
}

/// The touches that no other checks, if there are any.
fn unchecked(influences: &[Influence]) -> Option<String> {
    let touches = influences.iter().filter_map(|influence| match influence.of {
        Observed::Touch(index) if influence.left_out.is_none() => Some(index.to_string()),
        _ => None,
    });
    let touches: Vec<String> = touches.collect();
    let what = match touches.len() {
        0 => return None,
        1 => format!("touch {}", touches[0]),
        count if count == influences.len() => "any touch".to_owned(),
        _ => format!("touches {}", touches.join(", ")),
    };
    Some(format!(
        "No other touch checks {what}: an error there, of any size, goes into the frame without a trace."
    ))
}

fn freedom(free: &[String]) -> String {
    let told = free.iter().map(|motion| match motion.strip_prefix('r') {
        Some(axis) => format!("the turn about the fixture's {} axis", axis.to_uppercase()),
        None => format!("the slide along the fixture's {} axis", motion.to_uppercase()),
    });
    format!(
        "No touch can see {}: there the frame stands as near the parent's axes, or the expected frame, as it goes, and its \
         uncertainty says nothing of it.",
        told.collect::<Vec<_>>().join(", ")
    )
}
