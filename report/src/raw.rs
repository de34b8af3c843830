//! The touches as measured, as one text that has a hash.

use data_encoding::HEXLOWER;
use sha2::{Digest, Sha256};
use touchref_io::{measurement::UNLABELLED, solution::ResidualRecord};

/// The touches as a table that touchref reads, and the SHA-256 of that text.
#[derive(Debug)]
pub(crate) struct Raw {
    /// UTF-8; every line ends with a line feed.
    pub(crate) text: String,
    /// In hexadecimal digits.
    pub(crate) sha256: String,
}

/// Columns that belong together, and what a touch has in them.
type Columns = (&'static [&'static str], fn(&ResidualRecord) -> Option<Vec<String>>);

/// Every column. Those of which no touch has anything are left out.
const COLUMNS: [Columns; 5] = [
    (&["surface", "x", "y", "z"], |touch| {
        let surface = if touch.label_found { UNLABELLED.to_owned() } else { plain(&touch.surface) };
        Some([surface].into_iter().chain(numbers(touch.at?)).collect())
    }),
    (&["id"], |touch| Some(vec![plain(touch.id.as_deref()?)])),
    (&["sigma"], |touch| Some(numbers([touch.sigma?]))),
    (&["i", "j", "k"], |touch| Some(numbers(touch.approach?))),
    (&["cov_x_x", "cov_x_y", "cov_x_z", "cov_y_y", "cov_y_z", "cov_z_z"], |touch| {
        let c = touch.covariance?;
        Some(numbers([c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]]))
    }),
];

impl Raw {
    /// `None` where a touch does not tell where it was.
    pub(crate) fn of(touches: &[ResidualRecord]) -> Option<Self> {
        if touches.iter().any(|touch| touch.at.is_none()) {
            return None;
        }
        let there = |columns: &&Columns| touches.iter().any(|touch| columns.1(touch).is_some());
        let groups: Vec<&Columns> = COLUMNS.iter().filter(there).collect();
        let mut table = csv::Writer::from_writer(Vec::new());
        let header = groups.iter().flat_map(|(names, _)| names.iter().map(|name| (*name).to_owned()));
        table.write_record(header).ok()?;
        for touch in touches {
            let fields = groups.iter().flat_map(|(names, values)| {
                values(touch).unwrap_or_else(|| vec![String::new(); names.len()])
            });
            table.write_record(fields).ok()?;
        }
        let text = String::from_utf8(table.into_inner().ok()?).ok()?;
        let sha256 = HEXLOWER.encode(&Sha256::digest(&text));
        Some(Self { text, sha256 })
    }
}

/// With the digits that round-trip.
fn numbers(values: impl IntoIterator<Item = f64>) -> Vec<String> {
    values.into_iter().map(|value| value.to_string()).collect()
}

/// Without control characters, which a page would not show as they are.
fn plain(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}
