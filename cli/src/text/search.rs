//! How a frame was found, for people.

use std::time::Duration;

use touchref::{SearchReport, Solution, solvers::refinement::Progress};

use super::{
    Look,
    number::{fixed, short},
    sheet::Sheet,
    solution::length_decimals,
};

/// From where frames were looked for, which minima there are, and the steps that led to the one accepted.
pub(crate) fn search(
    solution: &Solution,
    history: &[Progress],
    took: Duration,
    units: &str,
    look: Look,
) -> String {
    let mut sheet = Sheet::new(look);
    sheet.heading(&format!("How solver {} found the frame", solution.solver));
    sheet.prose(&format!("in {} ms", short(1e3 * took.as_secs_f64())));
    if let Some(search) = &solution.search {
        minima(&mut sheet, search, solution, units);
    }
    if history.is_empty() {
        sheet.prose("no iteration: the frame is a root of the fixture's equations");
    } else {
        steps(&mut sheet, history, solution);
    }
    sheet.finish()
}

/// What the squared misfit is called.
fn misfit(solution: &Solution) -> String {
    if solution.chi_square.is_some() { "chi-square" } else { "squared residuals" }.to_owned()
}

fn minima(sheet: &mut Sheet, search: &SearchReport, solution: &Solution, units: &str) {
    const DEGREES_DIGITS: usize = 3;
    let (starts, found) = (search.starts, search.minima.len());
    sheet.prose(&format!("starts: {starts}; distinct minima of the misfit: {found}"));
    let origin = format!("origin ({units})");
    let header = ["", &misfit(solution), "steps", &origin, "turned by (deg)", ""].map(str::to_owned);
    let rows = search.minima.iter().map(|minimum| {
        let turned = solution.frame.twist_to(&minimum.frame).rotation.norm().to_degrees();
        let origin = <[f64; 3]>::from(minimum.frame.origin).map(|v| fixed(v, length_decimals(units)));
        vec![
            if minimum.selected { "*" } else { "" }.to_owned(),
            short(minimum.chi_square),
            minimum.steps.to_string(),
            origin.join(" "),
            fixed(turned, DEGREES_DIGITS),
            minimum.objection.clone().unwrap_or_default(),
        ]
    });
    sheet.table(&header, rows.collect(), &[1, 2, 4]);
}

fn steps(sheet: &mut Sheet, history: &[Progress], solution: &Solution) {
    let ended = solution.iteration.map_or("", |iteration| iteration.stopped_by);
    sheet.prose(&format!("steps to the frame: {}, ended by `{ended}`", history.len()));
    let header = ["step", &misfit(solution), "gradient", "length", "damping", ""].map(str::to_owned);
    let rows = history.iter().enumerate().map(|(index, step)| {
        vec![
            (index + 1).to_string(),
            format!("{:.6e}", step.chi_square),
            format!("{:.1e}", step.gradient),
            format!("{:.1e}", step.step),
            format!("{:.0e}", step.damping),
            if step.taken { "" } else { "not taken" }.to_owned(),
        ]
    });
    sheet.table(&header, rows.collect(), &[0, 1, 2, 3, 4]);
}
