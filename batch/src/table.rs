//! Tables of touches and of frames as files: CSV, NDJSON and Parquet.

use std::{io::Write, path::Path};

use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use touchref_core::{Fixture, Units, parameters::nearest};
use touchref_io::{Input, InputError};

pub use crate::source::Source;

mod csv;
mod ndjson;
mod parquet;

/// A form of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Comma-separated values, `.csv`; touches also with semicolons or tabs.
    Csv,
    /// JSON, one object a line, `.ndjson` or `.jsonl`.
    Ndjson,
    /// Apache Parquet, `.parquet`.
    Parquet,
}

/// The forms by what their files' names end in.
const ENDINGS: [(&str, Form); 6] = [
    ("csv", Form::Csv),
    ("tsv", Form::Csv),
    ("txt", Form::Csv),
    ("ndjson", Form::Ndjson),
    ("jsonl", Form::Ndjson),
    ("parquet", Form::Parquet),
];

impl Form {
    /// The form that a file has by its name.
    ///
    /// # Errors
    /// `invalid-input` for another ending.
    pub fn of(path: &Path) -> Result<Self, InputError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let known = ENDINGS.iter().find(|(known, _)| known.eq_ignore_ascii_case(ending));
        known.map(|(_, form)| *form).ok_or_else(|| {
            let file = path.display().to_string();
            InputError::new("invalid-input", format!("the name {file} does not tell what form the table has"))
                .with_file(&file)
                .with_nearest(nearest(ending, ENDINGS.iter().map(|(known, _)| *known)))
                .with_help("end it in .csv, .ndjson or .parquet")
        })
    }
}

/// Opens a table of touches of a fixture, whose lengths are in `units`.
///
/// # Errors
/// A file that cannot be read, that has another form, or whose columns are missing, misspelt, of a wrong type or in another
/// unit.
pub fn open<'a>(
    input: &Input,
    form: Form,
    fixture: &'a dyn Fixture,
    units: Units,
) -> Result<Box<dyn Source + 'a>, InputError> {
    Ok(match form {
        Form::Csv => Box::new(csv::Touches::open(input, fixture, units)?),
        Form::Ndjson => Box::new(ndjson::Touches::open(input, fixture, units)?),
        Form::Parquet => Box::new(parquet::Touches::open(input, fixture, units)?),
    })
}

/// A table of frames that is written, a record batch at a time.
pub trait Sink: Send {
    /// Writes some frames.
    ///
    /// # Errors
    /// Those of the writer behind it.
    fn write(&mut self, frames: &RecordBatch) -> std::io::Result<()>;

    /// Writes what is to stand at the end.
    ///
    /// # Errors
    /// Those of the writer behind it.
    fn finish(self: Box<Self>) -> std::io::Result<()>;
}

/// A table of frames of this form with these columns.
///
/// # Errors
/// Those of the writer.
pub fn create<'w>(
    form: Form,
    schema: &SchemaRef,
    writer: impl Write + Send + 'w,
) -> std::io::Result<Box<dyn Sink + 'w>> {
    Ok(match form {
        Form::Csv => Box::new(csv::Frames::new(writer)),
        Form::Ndjson => Box::new(ndjson::Frames::new(writer)),
        Form::Parquet => Box::new(parquet::Frames::new(schema, writer)?),
    })
}
