//! How far touches check each other, for people.

use super::{
    Look,
    number::{decimals, fixed, short, short_or_dash},
    sheet::{BAD, GOOD, Sheet},
    solution::{fixture, length_decimals, probe},
};
use crate::commands::reliability::{ObservationRecord, ReliabilityRecord, WEAK};

/// What is checked, and what an error does that is not noticed.
pub(crate) fn reliability(record: &ReliabilityRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    verdict(&mut sheet, &record.observations);
    sheet.heading(&format!("Checks of touches and stated sizes ({}, degrees)", record.units));
    checks(&mut sheet, record);
    sheet.prose(&format!(
        "redundancy: the part of an error that the others see. Smallest detectable: the error that is noticed {} % of the \
         time; test values beyond {} are called bad, sound ones at a chance of {}.",
        short(100.0 * record.power),
        fixed(record.critical_value, 2),
        record.alpha
    ));
    sheet.heading(&format!("What they do to the frame ({})", record.units));
    shifts(&mut sheet, record);
    sheet.heading("Which are taken for each other");
    confusions(&mut sheet, record);
    sheet.heading("What it rests on");
    sheet.prose(&format!("fixture {}", fixture(&record.fixture, sheet.plus_minus())));
    sheet.prose(&probe(&record.probe, sheet.plus_minus(), record.units));
    sheet.finish()
}

fn verdict(sheet: &mut Sheet, observations: &[ObservationRecord]) {
    let named = |wanted: &dyn Fn(&ObservationRecord) -> bool| {
        let names =
            observations.iter().filter(|of| of.index.is_some() && wanted(of)).map(ObservationRecord::name);
        names.collect::<Vec<_>>()
    };
    let unchecked = named(&|of| of.smallest_detectable.is_none());
    let weak = named(&|of| of.smallest_detectable.is_some() && of.redundancy < WEAK);
    if unchecked.is_empty() && weak.is_empty() {
        sheet.verdict(GOOD, "Every touch is checked by the others.", "");
    }
    if !unchecked.is_empty() {
        let rest =
            format!("{}. An error of any size goes into the frame without a trace.", unchecked.join(", "));
        sheet.verdict(BAD, "No other touch checks", &rest);
    }
    if !weak.is_empty() {
        let rest = format!("{}: less than {WEAK} of an error shows.", weak.join(", "));
        sheet.verdict(BAD, "Weakly checked:", &rest);
    }
}

fn checks(sheet: &mut Sheet, record: &ReliabilityRecord) {
    let header = ["", "sigma", "redundancy", "test value", "smallest detectable"].map(str::to_owned);
    let rows = record.observations.iter().map(|of| {
        vec![
            of.name(),
            short(of.sigma),
            fixed(of.redundancy, 3),
            of.test_value.map_or_else(|| "-".to_owned(), |value| fixed(value, 2)),
            of.smallest_detectable.map_or_else(|| "any goes unnoticed".to_owned(), short),
        ]
    });
    sheet.table(&header, rows.collect(), &[1, 2, 3, 4]);
}

fn shifts(sheet: &mut Sheet, record: &ReliabilityRecord) {
    let point = |at: &[f64; 3]| format!("at {}", at.map(short).join(","));
    let points = record.points.iter().map(point);
    let header =
        [String::new(), "when".to_owned()].into_iter().chain(points).chain(["turn (deg)".to_owned()]);
    let header: Vec<String> = header.collect();
    let fewest = length_decimals(record.units);
    let mut rows = Vec::new();
    for of in &record.observations {
        for (when, shift) in [("error unnoticed", &of.undetected), ("left out", &of.left_out)] {
            let Some(shift) = shift else { continue };
            let turn = shift.motion[3..].iter().map(|v| v * v).sum::<f64>().sqrt().to_degrees();
            let at = shift
                .at_points
                .iter()
                .map(|moved| fixed(*moved, decimals(Some(*moved), fewest).min(fewest + 2)));
            let row = [of.name(), when.to_owned()].into_iter().chain(at).chain([short_or_dash(Some(turn))]);
            rows.push(row.collect());
        }
    }
    let right: Vec<usize> = (2..header.len()).collect();
    sheet.table(&header, rows, &right);
}

fn confusions(sheet: &mut Sheet, record: &ReliabilityRecord) {
    let mut any = false;
    for of in &record.observations {
        if of.confused_with.is_empty() {
            continue;
        }
        any = true;
        let told = of.confused_with.iter().map(|confusion| {
            let other = record.observations[confusion.with].name();
            if confusion.always {
                format!("{other} (always)")
            } else {
                format!("{other} ({} %)", fixed(100.0 * confusion.chance, 0))
            }
        });
        sheet.prose(&format!("an error of {}: {}", of.name(), told.collect::<Vec<_>>().join(", ")));
    }
    if !any {
        sheet.prose("none: the error of each stands out as its own");
    }
}
