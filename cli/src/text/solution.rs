//! A frame for a person at a machine.

pub(super) use touchref::io::words::{condition, fixture, length_decimals, probe};
use touchref::io::{
    SolutionRecord,
    solution::{DialectNote, ResidualRecord, RootRecord},
    words::{counted, in_words, left_out, loss, note, touches, unknowns},
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
