//! What a store holds, for people.

use super::{Look, number::fixed, sheet::Sheet, solution::length_decimals};
use crate::commands::history::{HistoryRecord, ResultRecord};

/// The results, one a line.
pub(crate) fn history(record: &HistoryRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    sheet.heading(&format!("Results in {}", record.file));
    if record.results.is_empty() {
        sheet.prose("none that are wanted");
        return sheet.finish();
    }
    let named = record.results.iter().any(|result| result.name.is_some());
    let shown = |mut row: Vec<String>| {
        if !named {
            row.remove(2);
        }
        row
    };
    let header = ["", "time (UTC)", "name", "measurement", "fixture", "status", "origin"].map(str::to_owned);
    let rows = record.results.iter().map(|result| shown(row(result))).collect();
    sheet.table(&shown(header.to_vec()), rows, &[0]);
    sheet.finish()
}

fn row(result: &ResultRecord) -> Vec<String> {
    let digits = length_decimals(&result.units);
    let origin = result.origin.map(|origin| origin.map(|v| fixed(v, digits)).join(" "));
    vec![
        result.number.to_string(),
        // To the second.
        result.time.split('.').next().unwrap_or_default().replace('T', " "),
        result.name.clone().unwrap_or_default(),
        result.measurement.clone(),
        result.fixture.clone(),
        result.status.clone(),
        origin.map_or_else(|| "-".to_owned(), |origin| format!("{origin} {}", result.units)),
    ]
}
