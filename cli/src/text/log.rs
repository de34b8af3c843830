//! The points of a machine's log, for people.

use super::{Look, sheet::Sheet};
use crate::commands::log::{LogRecord, PointRecord};

/// Each point by row, and what is known of all.
pub(crate) fn log(record: &LogRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    sheet.heading(&format!("{}, read as {}", record.file, record.format));
    let header = ["row", "name", "line", "x", "y", "z", "unit", "base", "tool"].map(str::to_owned);
    let rows = record.points.iter().map(|point| row(record, point));
    sheet.table(&header, rows.collect(), &[0, 2, 3, 4, 5]);
    for point in &record.points {
        if let Some(reason) = &point.unusable {
            sheet.prose(&format!("row {} (line {}): {reason}", point.row, point.line));
        }
    }
    if let Some(frame) = record.frame {
        sheet.prose(&format!("positions are in {frame}"));
    }
    sheet.finish()
}

fn row(record: &LogRecord, point: &PointRecord) -> Vec<String> {
    let or_dash = |text: Option<&str>| text.unwrap_or("-").to_owned();
    let coordinate = |axis: usize| point.at.map_or_else(|| "-".to_owned(), |at| at[axis].to_string());
    vec![
        point.row.to_string(),
        or_dash(point.name.as_deref()),
        point.line.to_string(),
        coordinate(0),
        coordinate(1),
        coordinate(2),
        or_dash(point.units.or(record.units)),
        or_dash(point.base.as_deref()),
        or_dash(point.tool.as_deref()),
    ]
}
