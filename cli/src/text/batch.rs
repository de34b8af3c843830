//! What became of many placements, for people.

use touchref::batch::OK;

use super::{Look, number::short, sheet::Sheet};
use crate::commands::batch::BatchRecord;

/// How many have a frame, and why the others have none.
pub(crate) fn batch(record: &BatchRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    let located = record.status.get(OK).copied().unwrap_or(0);
    sheet.heading(&format!("{located} of {} placements located, in {}", record.placements, record.output));
    let rows = record.status.iter().map(|(status, count)| {
        let percent = 100.0 * *count as f64 / record.placements as f64;
        vec![(*status).to_owned(), count.to_string(), short(percent)]
    });
    sheet.table(&["status", "placements", "%"].map(str::to_owned), rows.collect(), &[1, 2]);
    sheet.finish()
}
