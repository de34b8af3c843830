//! A frame for a person at a machine.

use touchref::io::{
    SolutionRecord,
    solution::{DialectNote, FixtureRecord, ProbeRecord, ResidualRecord, RootRecord, TrustRecord},
};

use super::{
    Look,
    number::{decimals, fixed, short, short_or_dash},
    sheet::{BAD, GOOD, Sheet},
};

/// The frame, how far it can be trusted, and what it rests on.
pub(crate) fn solution(record: &SolutionRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    sheet.verdict(GOOD, "Frame found.", &condition(&record.trust, &record.units));
    for touch in record.touches.iter().filter(|touch| touch.excluded) {
        sheet.gap();
        sheet.verdict(BAD, "A touch is left out as bad.", &left_out(touch, &record.units));
    }
    frame(&mut sheet, record);
    basis(&mut sheet, record);
    if !record.roots.is_empty() {
        sheet.heading("Frames that the equations allow");
        roots(&mut sheet, &record.roots, &record.units);
    }
    residuals(&mut sheet, &record.touches, &record.units);
    for (dialect, literal) in &record.dialects {
        sheet.heading(&format!("For {dialect}"));
        sheet.exact(literal);
        if let Some(note) = record.dialect_notes.get(dialect) {
            note_of_dialect(&mut sheet, note);
            sheet.prose(&loss(note, &record.units));
        }
    }
    sheet.finish()
}

/// What the numbers of a literal mean.
pub(super) fn note_of_dialect(sheet: &mut Sheet, note: &DialectNote) {
    sheet.prose(&format!("relative to: {}", note.parent));
    sheet.prose(&format!("numbers: {}; {}", note.units, note.digits));
    sheet.prose(&format!("rotation: {}", note.convention));
    sheet.prose(&format!("use: {}", note.usage));
}

/// What the literal loses, in words.
fn loss(note: &DialectNote, units: &str) -> String {
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

/// Which touch is left out, and how far off it is, as a sentence.
fn left_out(touch: &ResidualRecord, units: &str) -> String {
    let id = touch.id.as_ref().map_or(String::new(), |id| format!(" `{id}`"));
    format!(
        "Touch {}{id} lies {} {units} off `{}`, {} of its standard deviations.",
        touch.index,
        short_or_dash(touch.residual),
        touch.surface,
        short_or_dash(touch.normalized)
    )
}

/// The condition under which a frame stands, as a sentence.
pub(super) fn condition(trust: &TrustRecord, units: &str) -> String {
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
pub(super) fn length_decimals(units: &str) -> usize {
    match units {
        "um" => 0,
        "m" => 6,
        "in" => 4,
        _ => 3,
    }
}

fn frame(sheet: &mut Sheet, record: &SolutionRecord) {
    const AXIS_DIGITS: usize = 6;
    let units = &record.units;
    sheet.heading(&format!("Frame of {} in the parent ({units})", record.fixture.kind));
    let deviations: Option<[f64; 6]> =
        record.covariance.as_ref().map(|c| std::array::from_fn(|i| c.matrix[i][i].max(0.0).sqrt()));
    let header = ["", "x", "y", "z"].map(str::to_owned);
    let row = |name: &str, values: [String; 3]| {
        let [x, y, z] = values;
        vec![name.to_owned(), x, y, z]
    };
    let smallest = deviations.and_then(|d| d[..3].iter().copied().filter(|u| *u > 0.0).reduce(f64::min));
    let digits = decimals(smallest, length_decimals(units));
    let mut rows = vec![row("origin", record.frame.origin.map(|v| fixed(v, digits)))];
    if let Some([x, y, z, rx, ry, rz]) = deviations {
        let plus_minus = sheet.plus_minus();
        rows.push(row(&format!("  {plus_minus} standard"), [x, y, z].map(|u| fixed(u, digits))));
        let turns = [rx, ry, rz].map(f64::to_degrees);
        let least = turns.iter().copied().filter(|u| *u > 0.0).reduce(f64::min);
        let digits = decimals(least, 4);
        rows.push(row(&format!("turn {plus_minus} (deg)"), turns.map(|u| fixed(u, digits))));
    }
    for (name, axis) in
        [("X axis", record.frame.x_axis), ("Y axis", record.frame.y_axis), ("Z axis", record.frame.z_axis)]
    {
        rows.push(row(name, axis.map(|v| fixed(v, AXIS_DIGITS))));
    }
    sheet.table(&header, rows, &[1, 2, 3]);
    let quaternion = record.frame.quaternion_xyzw.map(|v| fixed(v, 8)).join("  ");
    sheet.prose(&format!("quaternion x y z w: {quaternion}"));
}

fn basis(sheet: &mut Sheet, record: &SolutionRecord) {
    let units = &record.units;
    sheet.heading("What it rests on");
    sheet.prose(&format!(
        "{}, solver {}; {}",
        touches(&record.touches),
        record.solver,
        probe(&record.probe, sheet.plus_minus(), units)
    ));
    sheet.prose(&format!("fixture {}", fixture(&record.fixture, sheet.plus_minus())));
    let misfit = match (record.chi_square, record.p_value) {
        (Some(chi_square), Some(p)) => format!("chi-square {}, p = {}", short(chi_square), short(p)),
        (Some(chi_square), None) => format!("chi-square {}", short(chi_square)),
        (None, _) => "no chi-square, as no sigma is stated".to_owned(),
    };
    sheet.prose(&format!(
        "misfit: rms {} {units}, {misfit}, {} beyond the {} unknowns",
        short_or_dash(record.rms),
        counted(record.degrees_of_freedom, "touch", "touches"),
        in_words(unknowns(record)),
    ));
    if let Some(covariance) = &record.covariance {
        let source = if covariance.sigma_source == "given" { "as stated" } else { "from the residuals" };
        let sigma = short_or_dash(covariance.sigma);
        sheet.prose(&format!("uncertainties: standard, for a sigma of {sigma} {units} ({source})"));
    }
    for adjusted in &record.adjustments {
        let plus_minus = sheet.plus_minus();
        sheet.prose(&format!(
            "{} moved from {} {plus_minus} {} to {} {plus_minus} {}: by {} of its standard uncertainty",
            adjusted.name,
            short_or_dash(adjusted.nominal),
            short_or_dash(adjusted.nominal_u),
            short_or_dash(adjusted.value),
            short_or_dash(adjusted.u),
            short_or_dash(adjusted.moved),
        ));
    }
    sheet.prose(&format!(
        "seen by the touches: {} of {} motions, condition {}; weakest is a {}",
        record.observability.rank,
        unknowns(record),
        short_or_dash(record.observability.condition),
        record.observability.weakest
    ));
}

/// How many unknowns the frame has: six, less what the fixture leaves free.
fn unknowns(record: &SolutionRecord) -> usize {
    6_usize.saturating_sub(record.free.len())
}

/// A small number.
fn in_words(count: usize) -> &'static str {
    ["no", "one", "two", "three", "four", "five", "six"].get(count).copied().unwrap_or("many")
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// How many there are, and of these how many are used.
fn touches(touches: &[ResidualRecord]) -> String {
    let used = touches.iter().filter(|touch| !touch.excluded).count();
    if used == touches.len() {
        format!("{used} touches")
    } else {
        format!("{used} of {} touches", touches.len())
    }
}

/// Sigma and tip radius.
pub(super) fn probe(probe: &ProbeRecord, plus_minus: &str, units: &str) -> String {
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
pub(super) fn fixture(fixture: &FixtureRecord, plus_minus: &str) -> String {
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

/// A table of roots: where, which dimensions they imply, and what became of them.
pub(super) fn roots(sheet: &mut Sheet, roots: &[RootRecord], units: &str) {
    const FEWEST: usize = 4;
    let names: Vec<&String> = roots.first().map_or(Vec::new(), |root| root.measures.keys().collect());
    let measured = |root: &RootRecord, name: &str| {
        (
            root.measures.get(name).and_then(serde_json::Value::as_f64),
            root.measures_u.get(name).and_then(serde_json::Value::as_f64),
        )
    };
    let uncertain = |name: &str| roots.iter().any(|root| measured(root, name).1.is_some());
    let plus_minus = sheet.plus_minus();
    let mut header = vec![String::new()];
    for name in &names {
        header.push((*name).clone());
        if uncertain(name) {
            header.push(plus_minus.to_owned());
        }
    }
    header.extend(["misfit".to_owned(), format!("origin ({units})"), String::new()]);
    let right: Vec<usize> = (1..header.len() - 2).collect();
    let rows = roots.iter().map(|root| {
        let mut row = vec![if root.selected { "*" } else { "" }.to_owned()];
        for name in &names {
            let (value, u) = measured(root, name);
            let digits = decimals(u, FEWEST);
            row.push(value.map_or_else(|| "-".to_owned(), |value| fixed(value, digits)));
            if uncertain(name) {
                row.push(u.map_or_else(|| "-".to_owned(), |u| fixed(u, digits)));
            }
        }
        row.push(short_or_dash(root.misfit));
        let origin = root.frame.origin.map(|v| fixed(v, length_decimals(units)));
        row.extend([origin.join(" "), root.reason.clone()]);
        row
    });
    sheet.table(&header, rows.collect(), &right);
}

/// What there is to say of a touch.
fn note(touch: &ResidualRecord) -> &'static str {
    match (touch.excluded, touch.label_found) {
        (true, false) => "left out",
        (true, true) => "left out; surface found",
        (false, true) => "surface found",
        (false, false) => "",
    }
}

fn residuals(sheet: &mut Sheet, touches: &[ResidualRecord], units: &str) {
    sheet.heading("Residuals");
    let ids = touches.iter().any(|touch| touch.id.is_some());
    let sigmas = touches.iter().any(|touch| touch.normalized.is_some());
    let largest = touches.iter().filter_map(|touch| touch.residual).fold(0.0, |a: f64, b| a.max(b.abs()));
    let digits = decimals(Some(largest), length_decimals(units));
    let mut header = vec!["touch".to_owned()];
    header.extend(ids.then(|| "id".to_owned()));
    header.extend(["surface".to_owned(), format!("residual ({units})")]);
    header.extend(sigmas.then(|| "in sigmas".to_owned()));
    let notes = touches.iter().any(|touch| touch.excluded || touch.label_found);
    header.extend(notes.then(String::new));
    let first_number = if ids { 3 } else { 2 };
    let rows = touches.iter().map(|touch| {
        let mut row = vec![touch.index.to_string()];
        row.extend(ids.then(|| touch.id.clone().unwrap_or_default()));
        row.push(touch.surface.clone());
        row.push(touch.residual.map_or_else(|| "-".to_owned(), |v| fixed(v, digits)));
        row.extend(sigmas.then(|| touch.normalized.map_or_else(|| "-".to_owned(), |v| fixed(v, 2))));
        row.extend(notes.then(|| note(touch).to_owned()));
        row
    });
    sheet.table(&header, rows.collect(), &[first_number, first_number + 1]);
}
