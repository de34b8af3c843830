//! Whether the fixture has moved, for people.

use super::{
    Look,
    number::{decimals, fixed, short, short_or_dash},
    sheet::{BAD, GOOD, Sheet},
    solution::{fixture, length_decimals},
};
use crate::commands::compare::{ChangeRecord, ComparisonRecord, SignificanceRecord, Uncertain};

/// Whether it has moved, how far, and what it rests on.
pub(crate) fn comparison(record: &ComparisonRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    verdict(&mut sheet, record);
    // Of a series the first that has moved is of interest, else the last.
    let told = record.first_moved.unwrap_or(record.comparisons.len().saturating_sub(1));
    if let Some(change) = record.comparisons.get(told) {
        motion(&mut sheet, record, change);
    }
    if record.comparisons.len() > 1 {
        series(&mut sheet, record);
    }
    sheet.heading("What it rests on");
    basis(&mut sheet, record);
    sheet.finish()
}

fn verdict(sheet: &mut Sheet, record: &ComparisonRecord) {
    if let Some(agreement) = record.baseline.agreement.as_ref().filter(|agreement| agreement.exceeded) {
        let told = format!("its results are not of one frame: {}.", distance(agreement));
        sheet.verdict(BAD, "The baseline has moved:", &told);
        return;
    }
    if let Some(change) = record.first_moved.and_then(|first| record.comparisons.get(first)) {
        let words = change.words.as_ref().map_or(String::new(), |words| format!("It is mostly a {words}."));
        let told = format!("{}: {}. {words}", change.result, distance(&change.significance));
        sheet.verdict(BAD, "The fixture has moved.", &told);
        if let Some(explained) = explanation(change) {
            sheet.prose(&explained);
        }
        return;
    }
    let told = match record.comparisons.as_slice() {
        [change] => format!("{}.", distance(&change.significance)),
        changes => format!("None of {} results is beyond its limit.", changes.len()),
    };
    sheet.verdict(GOOD, "Nothing has moved.", &told);
}

/// The distance beside its limit.
fn distance(significance: &SignificanceRecord) -> String {
    format!(
        "squared distance {}, limit {}, p = {}",
        short(significance.squared_distance),
        short(significance.limit),
        short_or_dash(significance.p_value)
    )
}

/// What explains a motion, as a sentence; a name only where all others are excluded.
fn explanation(change: &ChangeRecord) -> Option<String> {
    let name = |surface: &Option<String>| match surface {
        Some(surface) => format!("only `{surface}` has moved on the fixture"),
        None => "the fixture has moved as a whole".to_owned(),
    };
    let all = change.explanations.as_ref()?;
    let explaining: Vec<String> =
        all.iter().filter(|one| one.explains).map(|one| name(&one.surface)).collect();
    Some(match explaining.as_slice() {
        [] => "What has moved is neither the fixture as a whole nor one surface alone.".to_owned(),
        [one] => format!("By the touches, {one}; nothing else explains them."),
        several => format!("The touches cannot tell apart whether {}.", several.join(", or ")),
    })
}

fn motion(sheet: &mut Sheet, record: &ComparisonRecord, change: &ChangeRecord) {
    let units = &record.units;
    sheet.heading(&format!("Motion to {}, along the parent's axes", change.result));
    let plus_minus = sheet.plus_minus();
    let header = ["", "x", "y", "z", "length", plus_minus].map(str::to_owned);
    let u = |k: usize| change.covariance[k][k].max(0.0).sqrt();
    let row = |name: String, values: [f64; 3], total: Option<Uncertain>, digits: usize| {
        let mut row = vec![name];
        row.extend(values.map(|v| fixed(v, digits)));
        row.extend(total.map_or([String::new(), String::new()], |Uncertain { value, u }| {
            [fixed(value, digits), fixed(u, digits)]
        }));
        row
    };
    let least = |of: [f64; 3]| of.into_iter().filter(|u| *u > 0.0).reduce(f64::min);
    let (shift_u, turn_u) = ([0, 1, 2].map(u), [3, 4, 5].map(|k| u(k).to_degrees()));
    let digits = decimals(least(shift_u), length_decimals(units));
    let degrees = decimals(least(turn_u), 4);
    let turn = change.motion.rotation.map(f64::to_degrees);
    let mut rows = vec![
        row(format!("origin ({units})"), change.motion.translation, Some(change.shift), digits),
        row(format!("  {plus_minus} standard"), shift_u, None, digits),
        row("turn (deg)".to_owned(), turn, Some(change.turn_deg), degrees),
        row(format!("  {plus_minus} standard"), turn_u, None, degrees),
    ];
    // The origin is told already.
    for point in change.points.iter().filter(|point| point.at.iter().any(|v| *v != 0.0)) {
        let name = format!("({}) ({units})", point.at.map(short).join(", "));
        rows.push(row(name, point.moved, Some(point.distance), digits));
    }
    sheet.table(&header, rows, &[1, 2, 3, 4, 5]);
}

fn series(sheet: &mut Sheet, record: &ComparisonRecord) {
    sheet.heading("Results in order");
    let turn = "turn (deg)".to_owned();
    let mut header = vec!["result".to_owned(), "time (UTC)".to_owned()];
    header.extend(["squared distance", "limit", "p"].map(str::to_owned));
    header.extend([format!("shift ({})", record.units), turn, String::new()]);
    let dated = record.comparisons.iter().any(|change| change.time.is_some());
    let shown = |mut row: Vec<String>| {
        if !dated {
            row.remove(1);
        }
        row
    };
    let rows = record.comparisons.iter().map(|change| {
        let significance = &change.significance;
        shown(vec![
            change.result.clone(),
            change.time.clone().unwrap_or_default(),
            fixed(significance.squared_distance, 2),
            fixed(significance.limit, 2),
            short_or_dash(significance.p_value),
            short(change.shift.value),
            short(change.turn_deg.value),
            if significance.exceeded { "moved" } else { "" }.to_owned(),
        ])
    });
    let rows = rows.collect();
    let first = if dated { 2 } else { 1 };
    sheet.table(&shown(header), rows, &[first, first + 1, first + 2, first + 3, first + 4]);
    sheet.prose(&format!(
        "a fixture that stands still is beyond its limit in one result with a chance of {}, in any of {} with at most {}",
        short(record.alpha),
        record.comparisons.len(),
        short(record.alpha_of_series)
    ));
}

fn basis(sheet: &mut Sheet, record: &ComparisonRecord) {
    let baseline = match record.baseline.results.as_slice() {
        [one] => format!("held against {one}"),
        several => format!("held against the mean of {}", several.join(", ")),
    };
    let agreement = record.baseline.agreement.as_ref();
    let agreement = agreement.map_or(String::new(), |agreement| format!(" ({})", distance(agreement)));
    sheet.prose(&format!("{baseline}{agreement}"));
    sheet.prose(&format!("fixture {}", fixture(&record.fixture, sheet.plus_minus())));
    if let Some(change) = record.comparisons.first() {
        let SignificanceRecord { degrees_of_freedom, degrees_of_freedom_of_noise, .. } = &change.significance;
        let law = match degrees_of_freedom_of_noise {
            None => format!("chi-square with {degrees_of_freedom} degrees of freedom"),
            Some(of_noise) => {
                format!(
                    "{degrees_of_freedom} times F with {degrees_of_freedom} and {of_noise} degrees of freedom"
                )
            }
        };
        sheet
            .prose(&format!("if nothing moved the squared distance is {law}; alpha {}", short(record.alpha)));
    }
    if !record.common.is_empty() {
        sheet.prose(&format!("the same error in all results: {}", record.common.join(", ")));
    }
}
