//! Touches from the logs of machines: robot programs with taught points, probing logs of CNCs, CMM output, tables.
//!
//! An [`Importer`] finds the points of a log, each with what the log tells of it: its name, unit, frame and tool. Which
//! of them is a touch of which surface is stated in the measurement (see [`LogSource`]). Nothing is guessed: a format is
//! named, never recognised; what a log does not tell is to be stated; a missed probe, a register without a value or
//! another frame is an error with its line.
//!
//! A robot's or a CNC's position is that of its tool centre point or its probe's ball: the **tip centre**, when the
//! tool was measured to the centre of the ball.

use std::ops::Range;

use nalgebra::{Point3, Unit, Vector3};

use crate::{Input, InputError, Units, source::Source};

mod abb;
mod columns;
mod dmis;
mod fanuc;
mod grbl;
mod kuka;
mod linuxcnc;
mod mapping;
mod scan;
mod ur;

pub use columns::{Column, Columns};
pub use mapping::LogSource;

/// One format of logs; add one to [`ALL`].
#[derive(Debug, Clone, Copy)]
pub struct Importer {
    /// The name that a measurement states.
    pub name: &'static str,
    /// What it reads, in one line.
    pub summary: &'static str,
    /// What is a point, what it is called, and what is refused.
    pub about: &'static str,
    /// Endings of the files it is for, to help where no format is stated; never to choose one.
    pub extensions: &'static [&'static str],
    /// Unit of its numbers, where the format has one.
    pub units: Option<Units>,
    /// What its positions are relative to, where that is always the same.
    pub frame: Option<&'static str>,
    /// Where the format is told.
    pub reference: &'static str,
    /// Whether its positions are those of a tool centre point, and not perhaps contact points.
    pub tip_centres: bool,
    reader: Reader,
}

impl PartialEq for Importer {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Importer {
    /// Whether it reads a table whose columns the measurement names.
    #[must_use]
    pub fn takes_columns(&self) -> bool {
        matches!(self.reader, Reader::Table(_))
    }
}

/// How the points of a text are found.
#[derive(Debug, Clone, Copy)]
enum Reader {
    /// Every text may have points.
    Program(fn(&str) -> Vec<LoggedPoint>),
    /// Some texts are not of this format.
    Record(fn(&Source) -> Result<Vec<LoggedPoint>, InputError>),
    /// In a table whose columns the measurement names.
    Table(fn(&Source, &Columns) -> Result<Vec<LoggedPoint>, InputError>),
}

/// Every importer, sorted by name.
pub static ALL: &[Importer] = &[
    abb::IMPORTER,
    columns::IMPORTER,
    dmis::IMPORTER,
    fanuc::PROGRAM,
    fanuc::REGISTERS,
    grbl::IMPORTER,
    kuka::IMPORTER,
    linuxcnc::IMPORTER,
    ur::RECORD,
    ur::SCRIPT,
];

/// The importer of that name.
///
/// # Errors
/// `unknown-log`, with the nearest known name.
pub fn find(name: &str) -> Result<&'static Importer, InputError> {
    let known = ALL.iter().map(|importer| importer.name);
    ALL.iter()
        .find(|importer| importer.name == name)
        .ok_or_else(|| InputError::unknown("unknown-log", "log format", name, known))
}

/// A point of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct LoggedPoint {
    /// What the program calls it.
    pub name: Option<String>,
    /// Where it is.
    pub position: Position,
    /// Unit of its numbers, where the log tells it.
    pub units: Option<Units>,
    /// Direction in which the probe moved.
    pub approach: Option<Unit<Vector3<f64>>>,
    /// What the position is relative to, where the log tells it.
    pub base: Option<String>,
    /// The tool that was active, where the log tells it.
    pub tool: Option<String>,
    /// Line of the log, from 1.
    pub line: usize,
    span: Range<usize>,
}

/// What a log says of where a point is.
#[derive(Debug, Clone, PartialEq)]
pub enum Position {
    /// Here, in the log's unit.
    At(Point3<f64>),
    /// Something that is no position: a missed probe, joint angles, a number that is none. Not to be mapped, and to be
    /// ignored by name or row.
    Unusable(Fault),
    /// Nothing yet: not to be mapped; there is nothing to ignore.
    Empty(Fault),
}

/// Why a point has no position, and where that stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    message: String,
    span: Range<usize>,
}

impl Fault {
    fn new(message: impl Into<String>, span: Range<usize>) -> Self {
        Self { message: message.into(), span }
    }

    /// What is wrong.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl LoggedPoint {
    /// A point that stands there; nothing else is known of it.
    fn new(name: Option<String>, span: Range<usize>, position: Result<Point3<f64>, Fault>) -> Self {
        let position = position.map_or_else(Position::Unusable, Position::At);
        Self { name, position, units: None, approach: None, base: None, tool: None, line: 0, span }
    }

    /// Sets its base or tool to the number that stands there.
    fn set_number(
        &mut self,
        text: &str,
        key: &str,
        span: Range<usize>,
        which: fn(&mut Self) -> &mut Option<String>,
    ) {
        let value = &text[span.clone()];
        if let Ok(number) = value.parse::<u32>() {
            *which(self) = Some(number.to_string());
        } else {
            self.refuse(format!("{key} is `{value}`; expected a number, 0 or more"), span);
        }
    }

    /// Takes its position away.
    fn refuse(&mut self, message: impl Into<String>, span: Range<usize>) {
        if matches!(self.position, Position::At(_)) {
            self.position = Position::Unusable(Fault::new(message, span));
        }
    }
}

/// The points of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineLog {
    source: Source,
    points: Vec<LoggedPoint>,
}

impl MachineLog {
    /// Reads a log; `columns` are those of a table whose format leaves them open.
    ///
    /// # Errors
    /// A file that cannot be read, or is not of that format; `too-few-touches` when it has no points; `missing-key` and
    /// `unknown-key` for `columns`.
    pub fn read(importer: &Importer, input: &Input, columns: Option<&Columns>) -> Result<Self, InputError> {
        Self::of(importer, Source::read(input)?, columns)
    }

    /// Reads the text of a log that messages call `name`.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn from_text(
        importer: &Importer,
        name: &str,
        text: &str,
        columns: Option<&Columns>,
    ) -> Result<Self, InputError> {
        Self::of(importer, Source::new(name, text), columns)
    }

    fn of(importer: &Importer, source: Source, columns: Option<&Columns>) -> Result<Self, InputError> {
        let mut points = match (importer.reader, columns) {
            (Reader::Program(read), None) => read(source.text()),
            (Reader::Record(read), None) => read(&source)?,
            (Reader::Table(read), Some(columns)) => read(&source, columns)?,
            (Reader::Table(_), None) => {
                return Err(InputError::new("missing-key", format!("`{}` needs `columns`", importer.name))
                    .with_key("columns")
                    .with_help(
                        "say which columns hold the position: columns = { at = [\"X\", \"Y\", \"Z\"] }",
                    ));
            }
            (Reader::Program(_) | Reader::Record(_), Some(_)) => {
                let message = format!("a log of format `{}` has no `columns`", importer.name);
                return Err(InputError::new("unknown-key", message).with_key("columns"));
            }
        };
        if points.is_empty() {
            let message = format!("{} has no points of format `{}`", source.name(), importer.name);
            return Err(InputError::new("too-few-touches", message)
                .with_file(source.name())
                .with_help(importer.about));
        }
        let (mut line, mut counted) = (1, 0);
        for point in &mut points {
            // Points come in the order of the text.
            let start = point.span.start.max(counted);
            line += source.text()[counted..start].matches('\n').count();
            (counted, point.line) = (start, line);
        }
        Ok(Self { source, points })
    }

    /// Its points, in the order of the text.
    #[must_use]
    pub fn points(&self) -> &[LoggedPoint] {
        &self.points
    }

    /// An error at a point.
    fn error(&self, point: &LoggedPoint, message: impl Into<String>) -> InputError {
        InputError::new("invalid-input", message).at(self.source.place(point.span.clone()))
    }

    /// The error of a fault.
    fn fault(&self, fault: &Fault) -> InputError {
        InputError::new("invalid-input", fault.message.clone()).at(self.source.place(fault.span.clone()))
    }
}

#[cfg(test)]
mod tests;
