//! Touch tables: one line a touch, read one at a time, so that a table may be of any length.
//!
//! A header names the columns: `surface`, `x`, `y`, `z`, and where known `id`, `sigma`, `i`, `j`, `k` (the direction
//! in which the probe moved) and `placement`. Fields are separated by commas, semicolons or tabs, whichever the
//! header has; with semicolons a decimal comma is accepted. Lines that begin with `#` are comments. A touch whose surface
//! is not known has [`UNLABELLED`] there, or nothing. A column `units` states the unit of each row: there is one in a table.

use std::io::{self, BufRead, Read};

use nalgebra::{Point3, Vector3};
use touchref_core::{Noise, Units, Warning, direction, parameters::nearest};

use crate::{
    Input, InputError, TouchRecord,
    measurement::UNLABELLED,
    source::{Excerpt, Place, not_utf8},
};

pub(crate) mod line;

use line::{Fields, Line};

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Surface,
    At(usize),
    Id,
    Sigma,
    Approach(usize),
    Placement,
    Units,
    Ignored,
}

/// Every column there is, by the name in the header.
const COLUMNS: &[(&str, Column)] = &[
    ("surface", Column::Surface),
    ("x", Column::At(0)),
    ("y", Column::At(1)),
    ("z", Column::At(2)),
    ("id", Column::Id),
    ("sigma", Column::Sigma),
    ("i", Column::Approach(0)),
    ("j", Column::Approach(1)),
    ("k", Column::Approach(2)),
    ("placement", Column::Placement),
    ("units", Column::Units),
];

/// Reads a touch table row by row; an iterator over its touches.
///
/// After an error nothing more is read.
pub struct TableReader {
    lines: Lines,
    fields: Fields,
    columns: Vec<Column>,
    header: Vec<String>,
    /// The names that surfaces may have; any, and no column for them, where there are none.
    surfaces: Option<Vec<String>>,
    /// The unit that a row may state: that of the measurement, or of the first row that states one.
    units: Option<Units>,
    warnings: Vec<Warning>,
    decimal_comma: bool,
    finished: bool,
}

/// A row of a table of many placements.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedRow {
    /// The placement it belongs to.
    pub placement: String,
    /// Its line, from 1.
    pub line: usize,
    /// Its touch, or what is wrong with it.
    pub touch: Result<TouchRecord, InputError>,
}

impl std::fmt::Debug for TableReader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TableReader").field("file", &self.lines.name).finish_non_exhaustive()
    }
}

impl TableReader {
    /// Opens a table and reads its header; `surfaces` are the names that its touches may have.
    ///
    /// # Errors
    /// A file that cannot be read, and a header that lacks a column, has one twice, or one that is misspelt.
    pub fn open(input: &Input, surfaces: &[&str]) -> Result<Self, InputError> {
        Self::new(input.open()?, &input.name(), surfaces)
    }

    /// Opens a table of points: its surfaces may have any names, or none.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn of_points(input: &Input) -> Result<Self, InputError> {
        Self::with(input.open()?, &input.name(), None)
    }

    /// The same from any reader; messages call it `name`.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn new(reader: Box<dyn BufRead + Send>, name: &str, surfaces: &[&str]) -> Result<Self, InputError> {
        Self::with(reader, name, Some(surfaces.iter().map(|name| (*name).to_owned()).collect()))
    }

    fn with(
        reader: Box<dyn BufRead + Send>,
        name: &str,
        surfaces: Option<Vec<String>>,
    ) -> Result<Self, InputError> {
        let mut lines = Lines { reader, name: name.to_owned(), number: 0, offset: 0 };
        let Some(header) = lines.next_line()? else {
            return Err(InputError::new("invalid-input", "the touch table is empty")
                .with_file(name)
                .with_help("its first line names the columns: surface,x,y,z"));
        };
        let delimiter = delimiter_of(&header.text);
        let mut fields = Fields::new(delimiter);
        fields.split(&header)?;
        let mut reader = Self {
            decimal_comma: delimiter == b';',
            columns: Vec::new(),
            header: (0..fields.len()).map(|index| fields.get(index).to_owned()).collect(),
            surfaces,
            units: None,
            warnings: Vec::new(),
            finished: false,
            lines,
            fields,
        };
        reader.read_header(&header)?;
        Ok(reader)
    }

    /// A table whose rows come one at a time, under this header: [`row`](Self::row) reads each.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn of_rows(header: &str, name: &str, surfaces: &[&str]) -> Result<Self, InputError> {
        Self::new(Box::new(io::Cursor::new(header.to_owned())), name, surfaces)
    }

    /// The same table, every row that states a unit having to state this one.
    #[must_use]
    pub fn in_units(self, units: Units) -> Self {
        Self { units: Some(units), ..self }
    }

    /// Reads the next row of a table of many placements; `None` at its end.
    ///
    /// # Errors
    /// A line of which not even the placement can be read. What else is wrong with a row concerns its placement only,
    /// and is in the row.
    pub fn next_placed(&mut self) -> Result<Option<PlacedRow>, InputError> {
        let column = self.require_placements()?;
        let Some(line) = self.lines.next_line()? else { return Ok(None) };
        let touch = self.read_row(&line);
        if self.fields.len() != self.columns.len() {
            // A line that is cut otherwise than the header may have anything under `placement`.
            return touch.map(|_| None);
        }
        match self.fields.get(column) {
            "" => Err(self.wrong(&line, column, "the name of a placement")),
            name => Ok(Some(PlacedRow { placement: name.to_owned(), line: line.number, touch })),
        }
    }

    /// Which column names the placements, from 0.
    ///
    /// # Errors
    /// `missing-column`.
    pub fn require_placements(&self) -> Result<usize, InputError> {
        self.columns.iter().position(|column| *column == Column::Placement).ok_or_else(|| {
            InputError::new("missing-column", "column `placement` is missing")
                .with_file(&self.lines.name)
                .with_key("placement")
                .with_help("it names the placement to which a touch belongs")
        })
    }

    /// Reads a row that stands at line `number` of the input, from 1. An error keeps no row from being read later.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn row(&mut self, number: usize, text: &str) -> Result<TouchRecord, InputError> {
        let line = Line { file: self.lines.name.clone(), number, offset: 0, text: text.to_owned() };
        self.read_row(&line)
    }

    /// What the user should know of the table: columns that are not used.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    fn read_header(&mut self, line: &Line) -> Result<(), InputError> {
        if self.header.iter().any(|name| name.replace(',', ".").parse::<f64>().is_ok()) {
            return Err(InputError::new(
                "missing-column",
                "the table begins with numbers instead of a header",
            )
            .with_help("its first line names the columns: surface,x,y,z")
            .at(line.place()));
        }
        for index in 0..self.header.len() {
            let name = &self.header[index];
            let known = COLUMNS.iter().find(|(column, _)| column == name).map(|(_, column)| *column);
            if let Some(column) = known {
                if self.columns.contains(&column) {
                    let error = InputError::new("invalid-input", format!("column `{name}` is there twice"));
                    return Err(error.with_key(name.clone()).at(self.fields.place(line, index)));
                }
            } else if name.is_empty() {
                let error = InputError::new("invalid-input", format!("column {} has no name", index + 1));
                return Err(error.at(self.fields.place(line, index)));
            } else if let Some(near) = nearest_column(name) {
                return Err(InputError::new("unknown-column", format!("column `{name}` is not known"))
                    .with_nearest(Some(near))
                    .with_key(name.clone())
                    .at(self.fields.place(line, index)));
            } else {
                let message = format!("column `{name}` of {} is not used", self.lines.name);
                self.warnings.push(Warning { code: "ignored-column", message });
            }
            self.columns.push(known.unwrap_or(Column::Ignored));
        }
        let has = |column| self.columns.contains(&column);
        let approach = (0..3).any(|axis| has(Column::Approach(axis)));
        let missing = COLUMNS.iter().find(|(_, column)| match column {
            Column::Surface => self.surfaces.is_some() && !has(*column),
            Column::At(_) => !has(*column),
            Column::Approach(_) => approach && !has(*column),
            _ => false,
        });
        match missing {
            None => Ok(()),
            Some((name, column)) => {
                let help = if matches!(column, Column::Approach(_)) {
                    "the approach direction takes all three of i, j, k, or none"
                } else {
                    "the first line names the columns: surface,x,y,z"
                };
                Err(InputError::new("missing-column", format!("column `{name}` is missing"))
                    .with_key(*name)
                    .with_help(help)
                    .at(line.place()))
            }
        }
    }

    fn read_row(&mut self, line: &Line) -> Result<TouchRecord, InputError> {
        self.fields.split(line)?;
        if self.fields.len() != self.columns.len() {
            let (found, expected) = (self.fields.len(), self.columns.len());
            let message = format!("this line has {found} fields; the header has {expected} columns");
            let help =
                "decimal commas need semicolons between the fields; text that holds a delimiter needs quotes";
            return Err(InputError::new("invalid-input", message).with_help(help).at(line.place()));
        }
        let mut record = TouchRecord { line: Some(line.number), ..TouchRecord::new("", Point3::origin()) };
        let mut approach = Vector3::zeros();
        let mut approach_fields = 0;
        for index in 0..self.columns.len() {
            let text = self.fields.get(index);
            match self.columns[index] {
                Column::Surface => record.surface = self.surface(line, index)?,
                Column::At(axis) => record.at[axis] = self.number(line, index)?,
                Column::Sigma if !text.is_empty() => record.noise = Noise::Sigma(self.sigma(line, index)?),
                Column::Approach(axis) if !text.is_empty() => {
                    approach[axis] = self.number(line, index)?;
                    approach_fields += 1;
                }
                Column::Id if !text.is_empty() => record.id = Some(text.to_owned()),
                Column::Placement if !text.is_empty() => record.placement = Some(text.to_owned()),
                Column::Units => self.check_units(line, index)?,
                _ => {}
            }
        }
        if approach_fields > 0 {
            record.approach = Some(approach).filter(|_| approach_fields == 3).and_then(direction);
            if record.approach.is_none() {
                let message = if approach_fields == 3 {
                    "the approach direction i, j, k is zero"
                } else {
                    "the approach direction takes all three of i, j, k, or none"
                };
                return Err(InputError::new("invalid-input", message).with_key("i").at(line.place()));
            }
        }
        Ok(record)
    }

    fn surface(&self, line: &Line, index: usize) -> Result<String, InputError> {
        let name = self.fields.get(index);
        if self.surfaces.is_some() && name.is_empty() {
            return Ok(UNLABELLED.to_owned());
        }
        let Some(surfaces) = self
            .surfaces
            .as_ref()
            .filter(|known| name != UNLABELLED && !known.iter().any(|known| known == name))
        else {
            return Ok(name.to_owned());
        };
        let message = format!("the fixture has no surface `{name}`; it has {}", surfaces.join(", "));
        Err(InputError::new("unknown-surface", message)
            .with_nearest(nearest(name, surfaces.iter().map(String::as_str)))
            .with_key("surface")
            .at(self.fields.place(line, index)))
    }

    fn check_units(&mut self, line: &Line, index: usize) -> Result<(), InputError> {
        let stated = Units::from_name(self.fields.get(index))
            .ok_or_else(|| self.wrong(line, index, &format!("one of {}", Units::names())))?;
        match *self.units.get_or_insert(stated) {
            units if units == stated => Ok(()),
            units => {
                Err(self.wrong(line, index, &format!("`{units}`, as before: lengths are not converted")))
            }
        }
    }

    fn sigma(&self, line: &Line, index: usize) -> Result<f64, InputError> {
        let sigma = self.number(line, index)?;
        if sigma > 0.0 { Ok(sigma) } else { Err(self.wrong(line, index, "a length > 0")) }
    }

    fn number(&self, line: &Line, index: usize) -> Result<f64, InputError> {
        let text = self.fields.get(index);
        decimal(text, self.decimal_comma).ok_or_else(|| self.wrong(line, index, "a finite number"))
    }

    fn wrong(&self, line: &Line, index: usize, expected: &str) -> InputError {
        let text: String = self.fields.get(index).chars().take(60).collect();
        let column = &self.header[index];
        let found = if text.is_empty() { "empty".to_owned() } else { format!("`{text}`") };
        InputError::new(
            "invalid-input",
            format!("line {}, column `{column}` is {found}; expected {expected}", line.number),
        )
        .with_key(column.clone())
        .labelled(format!("expected {expected}"))
        .at(self.fields.place(line, index))
    }
}

impl Iterator for TableReader {
    type Item = Result<TouchRecord, InputError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.finished {
            return None;
        }
        let row = match self.lines.next_line() {
            Ok(None) => None,
            Ok(Some(line)) => Some(self.read_row(&line)),
            Err(error) => Some(Err(error)),
        };
        self.finished = !matches!(row, Some(Ok(_)));
        row
    }
}

/// The known column that a name was most likely meant to be.
///
/// The names of one or two letters are near to too much: only another case or a unit behind them counts (`X`,
/// `x_mm`, `x [mm]`).
#[must_use]
pub fn nearest_column(name: &str) -> Option<&'static str> {
    let lower = name.to_lowercase();
    let stem = lower.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("");
    let names = || COLUMNS.iter().map(|(name, _)| *name);
    names().find(|known| *known == stem).or_else(|| nearest(&lower, names().filter(|known| known.len() > 2)))
}

/// The delimiter of a header: whichever of the three it has most of.
fn delimiter_of(header: &str) -> u8 {
    let count = |delimiter: u8| header.bytes().filter(|byte| *byte == delimiter).count();
    // At equal counts the last is taken: the comma, which also stands for a header of one column.
    [b';', b'\t', b','].into_iter().max_by_key(|delimiter| count(*delimiter)).unwrap_or(b',')
}

/// A finite number, perhaps with a decimal comma.
pub(crate) fn decimal(text: &str, decimal_comma: bool) -> Option<f64> {
    let number = if decimal_comma && !text.contains('.') {
        text.replacen(',', ".", 1).parse::<f64>()
    } else {
        text.parse::<f64>()
    };
    number.ok().filter(|value| value.is_finite())
}

/// The lines of an input that are neither blank nor comments.
struct Lines {
    reader: Box<dyn BufRead + Send>,
    name: String,
    number: usize,
    offset: usize,
}

impl Lines {
    /// The longest line read, in bytes: more is not a touch.
    const LONGEST: u64 = 1 << 16;

    fn next_line(&mut self) -> Result<Option<Line>, InputError> {
        loop {
            let mut bytes = Vec::new();
            let read = self.reader.by_ref().take(Self::LONGEST + 1).read_until(b'\n', &mut bytes);
            let length = read.map_err(|error| {
                InputError::new("unreadable", format!("cannot read {}: {error}", self.name))
                    .with_file(&self.name)
            })?;
            if length == 0 {
                return Ok(None);
            }
            let (number, mut offset) = (self.number + 1, self.offset);
            self.number = number;
            self.offset += length;
            let mut content = bytes.as_slice();
            if number == 1 && content.starts_with("\u{feff}".as_bytes()) {
                content = &content[3..];
                offset += 3;
            }
            let line = |text: &str| Line {
                file: self.name.clone(),
                number,
                offset,
                text: text.trim_end_matches(['\n', '\r']).to_owned(),
            };
            if bytes.len() as u64 > Self::LONGEST {
                let message = format!("line {number} is longer than {} KiB", Self::LONGEST >> 10);
                let start = line(&String::from_utf8_lossy(&content[..content.len().min(60)]));
                return Err(InputError::new("invalid-input", message)
                    .with_help("a touch table is text with one line a touch")
                    .at(start.place()));
            }
            let line = match std::str::from_utf8(content) {
                Ok(text) => line(text),
                Err(error) => {
                    let good = line(&String::from_utf8_lossy(&content[..error.valid_up_to()]));
                    let end = good.text.len();
                    return Err(not_utf8(content).at(good.place_of(end..end)));
                }
            };
            let start = line.text.trim_start();
            if !start.is_empty() && !start.starts_with('#') {
                return Ok(Some(line));
            }
        }
    }
}

impl Line {
    /// The place of the line as a whole.
    pub(crate) fn place(&self) -> Place {
        Place { column: None, ..self.place_of(0..self.text.len()) }
    }

    /// The place of a span of its bytes.
    fn place_of(&self, span: std::ops::Range<usize>) -> Place {
        Place {
            file: self.file.clone(),
            line: self.number,
            column: Some(self.text[..span.start].chars().count() + 1),
            offset: self.offset + span.start,
            length: span.len(),
            excerpt: Excerpt::new(&self.file, self.number - 1, &self.text, span),
        }
    }
}

#[cfg(test)]
mod tests;
