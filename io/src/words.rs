//! What results say, in words.

use crate::{
    number::{fixed, short, short_or_dash},
    solution::{DialectNote, FixtureRecord, ProbeRecord, ResidualRecord, SolutionRecord, TrustRecord},
};

/// The condition under which a frame stands, as a sentence.
#[must_use]
pub fn condition(trust: &TrustRecord, units: &str) -> String {
    let range = match (trust.from_sigma.filter(|from| *from > 0.0), trust.up_to_sigma) {
        (Some(from), Some(to)) => format!("lies between {} and {} {units}", short(from), short(to)),
        (None, Some(to)) => format!("is below {} {units}", short(to)),
        (Some(from), None) => format!("is above {} {units}", short(from)),
        (None, None) => return "Nothing limits the standard deviation of one touch.".to_owned(),
    };
    let stated = match trust.sigma {
        Some(sigma) => format!("stated is {} {units}", short(sigma)),
        None => "none is stated".to_owned(),
    };
    let above = match (trust.up_to_sigma, trust.limited_by.as_str()) {
        (None, _) | (_, "none") => "",
        (_, "ambiguity") => " Above that a second frame fits within the noise.",
        (_, "curvature" | "rise") => " Above that its stated uncertainty is not true.",
        _ => " Above that the search for other frames is not complete.",
    };
    format!("It stands if the standard deviation of one touch {range}; {stated}.{above}")
}

/// Fewest digits after the point of a length: what a controller shows.
#[must_use]
pub fn length_decimals(units: &str) -> usize {
    match units {
        "um" => 0,
        "m" => 6,
        "in" => 4,
        _ => 3,
    }
}

/// A touch and its residual.
#[must_use]
pub fn touch(touch: &ResidualRecord, units: &str) -> String {
    let id = touch.id.as_ref().map_or(String::new(), |id| format!(" `{id}`"));
    let residual = touch
        .residual
        .map_or("no residual".to_owned(), |length| format!("residual {} {units}", short(length)));
    let sigmas = touch.normalized.map_or(String::new(), |sigmas| format!(", {} sigmas", fixed(sigmas, 2)));
    let note = match note(touch) {
        "" => String::new(),
        note => format!("; {note}"),
    };
    format!("touch {}{id} on `{}`: {residual}{sigmas}{note}", touch.index, touch.surface)
}

/// Which touch is left out, and how far off it is, as a sentence.
#[must_use]
pub fn left_out(touch: &ResidualRecord, units: &str) -> String {
    let id = touch.id.as_ref().map_or(String::new(), |id| format!(" `{id}`"));
    format!(
        "Touch {}{id} lies {} {units} off `{}`, {} of its standard deviations.",
        touch.index,
        short_or_dash(touch.residual),
        touch.surface,
        short_or_dash(touch.normalized)
    )
}

/// What the literal loses, in words.
#[must_use]
pub fn loss(note: &DialectNote, units: &str) -> String {
    let why = match &note.leaves_out {
        Some(what) => format!("rounding and the {what} that is left out"),
        None => "rounding".to_owned(),
    };
    format!(
        "read back, it differs from the frame by at most {} {units} at the touches, by {why} (the farthest touch is {} \
         {units} from the origin)",
        short(note.rounding_loss),
        short(note.farthest_touch)
    )
}

/// Sigma and tip radius.
#[must_use]
pub fn probe(probe: &ProbeRecord, plus_minus: &str, units: &str) -> String {
    let sigma = match probe.sigma {
        Some(sigma) => format!("sigma {} {units}", short(sigma)),
        None => "no sigma of the probe".to_owned(),
    };
    let tip = match (probe.tip_radius, probe.tip_radius_u) {
        (0.0, 0.0) => "tip radius 0: surface points".to_owned(),
        (radius, 0.0) => format!("tip radius {radius} {units}"),
        (radius, u) => format!("tip radius {radius} {plus_minus} {u} {units}"),
    };
    format!("{sigma}, {tip}")
}

/// Kind and parameters.
#[must_use]
pub fn fixture(fixture: &FixtureRecord, plus_minus: &str) -> String {
    let given =
        fixture.parameters.iter().filter(|(_, value)| value.as_array().is_none_or(|list| !list.is_empty()));
    let parameters = given.map(|(name, value)| match (value, value.get("value"), value.get("u")) {
        (_, Some(number), Some(u)) => format!("{name} = {number} {plus_minus} {u}"),
        (serde_json::Value::String(word), ..) => format!("{name} = {word}"),
        (serde_json::Value::Array(tables), ..) if tables.iter().all(serde_json::Value::is_object) => {
            let told = |table: &serde_json::Value| {
                let word = |key: &str| {
                    table.get(key).and_then(serde_json::Value::as_str).unwrap_or_default().to_owned()
                };
                format!("{} ({})", word("name"), word("type"))
            };
            format!("{name} = {}", tables.iter().map(told).collect::<Vec<_>>().join(", "))
        }
        (other, ..) => format!("{name} = {other}"),
    });
    let list = parameters.collect::<Vec<_>>().join(", ");
    if list.is_empty() { fixture.kind.clone() } else { format!("{}: {list}", fixture.kind) }
}

/// How many unknowns the frame has: six, less what the fixture leaves free.
#[must_use]
pub fn unknowns(record: &SolutionRecord) -> usize {
    6_usize.saturating_sub(record.free.len())
}

/// A small number.
#[must_use]
pub fn in_words(count: usize) -> &'static str {
    ["no", "one", "two", "three", "four", "five", "six"].get(count).copied().unwrap_or("many")
}

/// So many of a thing, in the right number.
#[must_use]
pub fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// How many there are, and of these how many are used.
#[must_use]
pub fn touches(touches: &[ResidualRecord]) -> String {
    let used = touches.iter().filter(|touch| !touch.excluded).count();
    if used == touches.len() {
        format!("{used} touches")
    } else {
        format!("{used} of {} touches", touches.len())
    }
}

/// What there is to say of a touch.
#[must_use]
pub fn note(touch: &ResidualRecord) -> &'static str {
    match (touch.excluded, touch.label_found) {
        (true, false) => "left out",
        (true, true) => "left out; surface found",
        (false, true) => "surface found",
        (false, false) => "",
    }
}
