//! Many placements of one fixture: touches in, frames out.
//!
//! [`Locator`] is a function from Arrow to Arrow, which is what engines for large tables call: rows of touches with a
//! column `placement` become one row a placement, with its frame and covariance or the code of its refusal. `table`, with the
//! feature `files`, reads touches from CSV, NDJSON and Parquet and writes frames to them, in bounded memory.
//!
//! Nothing is guessed here either: a column that is misspelt, of a wrong type or in another unit is an error of the table;
//! a touch that is wrong makes a refusal of its placement, and of no other.

mod columns;
mod frames;
mod locator;
mod placement;
mod source;
#[cfg(feature = "files")]
pub mod table;
mod touch;

use arrow_schema::DataType;

pub use columns::UNITS_KEY;
pub use frames::OK;
pub use locator::{Counts, Located, Locator, Refusal, Stream};
pub use placement::{Name, Placement};
pub use source::Source;

/// What placements are called in a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NameType {
    /// By texts.
    Text,
    /// By numbers.
    Integer,
}

impl NameType {
    fn data_type(self) -> DataType {
        match self {
            Self::Text => DataType::Utf8,
            Self::Integer => DataType::Int64,
        }
    }
}
