//! Where to touch, for people.

use touchref::analysis::planning::REDUNDANCY_ROUNDING;

use super::{
    Look,
    number::{decimals, fixed, short, short_or_dash},
    sheet::{BAD, GOOD, Sheet},
    solution::{condition, fixture, length_decimals, probe},
};
use crate::{
    commands::plan::{NextRecord, NextTouch, PlanRecord},
    planning::PlaceRecord,
};

/// Digits of a direction.
const DIRECTION_DIGITS: usize = 4;

/// The touches, what they promise, and what others would.
pub(crate) fn plan(record: &PlanRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    let units = record.units;
    let promise = match record.worst {
        Some(worst) => format!(
            "{} touches; at the worst point of use the frame will be sure to {} {units} along its worst direction, {} \
             {units} expanded (95 %, k = {}).",
            record.touches.len(),
            short(worst),
            short(record.coverage_factor * worst),
            fixed(record.coverage_factor, 2)
        ),
        None => format!(
            "{} touches; no sigma is stated, so uncertainties are told in standard deviations of one touch.",
            record.touches.len()
        ),
    };
    sheet.verdict(GOOD, "Planned.", &promise);
    sheet.heading(&format!("Touches, in fixture coordinates ({units})"));
    touches(&mut sheet, record);
    if record.touches.iter().any(|touch| touch.place.parent.is_some()) {
        sheet.heading(&format!("Expected in the parent ({units})"));
        in_parent(&mut sheet, record);
    }
    sheet.heading(&format!("Uncertainty at the points of use ({units})"));
    points(&mut sheet, record);
    sheet.heading("Beside other layouts of as many touches");
    sheet.prose(&format!(
        "worst case over that of the plan: naive {}, median of random {}",
        times(record.naive_over_plan),
        times(record.random_median_over_plan)
    ));
    sheet.heading("What it rests on");
    basis(&mut sheet, record);
    sheet.finish()
}

fn times(ratio: Option<f64>) -> String {
    ratio.map_or_else(
        || "none (it leaves a motion free, or is out of reach)".to_owned(),
        |ratio| format!("{} times", short(ratio)),
    )
}

fn touches(sheet: &mut Sheet, record: &PlanRecord) {
    let digits = length_decimals(record.units);
    let header = ["touch", "surface", "contact", "tip centre", "approach", "redundancy"].map(str::to_owned);
    let rows = record.touches.iter().map(|touch| {
        let PlaceRecord { surface, contact, tip, approach, .. } = &touch.place;
        vec![
            touch.index.to_string(),
            surface.clone(),
            triple(contact, digits),
            triple(tip, digits),
            triple(approach, DIRECTION_DIGITS),
            fixed(touch.redundancy, 2),
        ]
    });
    sheet.table(&header, rows.collect(), &[5]);
}

fn in_parent(sheet: &mut Sheet, record: &PlanRecord) {
    let digits = length_decimals(record.units);
    let header = ["touch", "surface", "tip centre", "approach"].map(str::to_owned);
    let rows = record.touches.iter().filter_map(|touch| {
        let parent = touch.place.parent.as_ref()?;
        let (tip, approach) = (triple(&parent.tip, digits), triple(&parent.approach, DIRECTION_DIGITS));
        Some(vec![touch.index.to_string(), touch.place.surface.clone(), tip, approach])
    });
    sheet.table(&header, rows.collect(), &[]);
}

fn points(sheet: &mut Sheet, record: &PlanRecord) {
    let header = ["point", "standard", "expanded (95 %)", "in sigmas"].map(str::to_owned);
    let rows = record.points.iter().map(|point| {
        let digits = decimals(point.u, length_decimals(record.units));
        let told = |factor: f64| point.u.map_or_else(|| "-".to_owned(), |u| fixed(factor * u, digits));
        vec![
            triple(&point.at, length_decimals(record.units)),
            told(1.0),
            told(record.coverage_factor),
            short(point.u_over_sigma),
        ]
    });
    sheet.table(&header, rows.collect(), &[1, 2, 3]);
}

fn basis(sheet: &mut Sheet, record: &PlanRecord) {
    let second = match record.trust.second_minimum.as_ref().and_then(|second| second.chi_square) {
        Some(chi_square) => format!(" The next best frame has a chi-square of {}.", short(chi_square)),
        None => String::new(),
    };
    sheet.prose(&format!("one frame stands. {}{second}", condition(&record.trust, record.units)));
    if record.approach_needed {
        sheet.prose("tell the approach directions with the touches: without them another frame fits as well");
    }
    let least = record.least_redundancy;
    let unchecked = record.touches.iter().filter(|touch| touch.redundancy < least - REDUNDANCY_ROUNDING);
    let unchecked = unchecked.map(|touch| touch.index.to_string()).collect::<Vec<_>>().join(", ");
    if unchecked.is_empty() {
        sheet.prose(&format!("every touch is checked by the others: redundancy {least} or more"));
    } else {
        sheet.prose(&format!(
            "the count of touches does not allow every redundancy number to be {least}; not checked so far: touch {unchecked}"
        ));
    }
    sheet.prose(&format!("fixture {}", fixture(&record.fixture, sheet.plus_minus())));
    sheet.prose(&probe(&record.probe, sheet.plus_minus(), record.units));
}

/// The touch to make next.
pub(crate) fn next(record: &NextRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    let (units, next) = (record.units, &record.next);
    if next.effect == "separates" {
        let rest = format!(
            "{} frames fit the touches. What this one reads differs between any two of them by {} standard deviations or \
             more.",
            next.frames,
            short_or_dash(next.sigmas)
        );
        sheet.verdict(BAD, "Ambiguous.", &rest);
    } else {
        let rest = format!(
            "With one more touch the standard uncertainty at the worst point of use goes from {} to {} {units}.",
            short_or_dash(next.worst_before),
            short_or_dash(next.worst_after)
        );
        sheet.verdict(GOOD, "One frame fits.", &rest);
    }
    sheet.heading("Touch next");
    sheet.prose(&place(next, units));
    sheet.finish()
}

/// Where a touch is to be made, as a sentence.
pub(crate) fn place(next: &NextTouch, units: &str) -> String {
    let digits = length_decimals(units);
    let PlaceRecord { surface, contact, approach, parent, .. } = &next.place;
    let expected = parent.as_ref().map_or(String::new(), |parent| {
        format!(
            "; in the parent tip centre ({}), approach ({})",
            commas(&parent.tip, digits),
            commas(&parent.approach, DIRECTION_DIGITS)
        )
    });
    format!(
        "`{surface}` at ({}) {units} of the fixture, approach ({}){expected}",
        commas(contact, digits),
        commas(approach, DIRECTION_DIGITS)
    )
}

fn triple(numbers: &[f64; 3], digits: usize) -> String {
    numbers.map(|v| fixed(v, digits)).join("  ")
}

fn commas(numbers: &[f64; 3], digits: usize) -> String {
    numbers.map(|v| fixed(v, digits)).join(", ")
}
