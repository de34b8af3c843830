//! `log`: the points of a machine's log, to say in a measurement which is a touch of what.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use schemars::JsonSchema;
use serde::Serialize;
use touchref::io::{
    Input, InputError, Units,
    log::{self, Column, Columns, Importer, LoggedPoint, MachineLog, Position},
    schema,
};

use crate::{args::Format, failure::Failure, output::Output, text};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.log/1";

/// List the points of a machine's log by row, name and line
///
/// A section `[log]` of a measurement says which of them is a touch of which surface; `touchref describe FORMAT` shows
/// one.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref log examples/logs/probe.dat --from kuka-dat\n\
\x20 touchref log examples/logs/export.csv --from csv --columns \"X [mm],Y [mm],Z [mm]\"")]
pub(crate) struct Args {
    /// The log, or - for standard input
    #[arg(value_name = "LOG")]
    file: PathBuf,
    /// Format of the log; `touchref list logs` tells them
    #[arg(long, value_name = "FORMAT", value_parser = importers())]
    from: &'static Importer,
    /// Columns of the position in a table, by name or by number from 1, as X,Y,Z
    #[arg(long, value_name = "X,Y,Z", value_parser = columns)]
    columns: Option<Columns>,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

fn importers() -> impl TypedValueParser<Value = &'static Importer> {
    PossibleValuesParser::new(log::ALL.iter().map(|importer| importer.name))
        .map(|name| log::find(&name).unwrap_or(&log::ALL[0]))
}

fn columns(text: &str) -> Result<Columns, String> {
    const EXPECTED: &str = "expected three columns, as X,Y,Z or 1,2,3";
    let names: Vec<&str> = text.split(',').map(str::trim).collect();
    let [x, y, z] = names.as_slice() else { return Err(EXPECTED.to_owned()) };
    let numbers: Vec<usize> = names.iter().filter_map(|name| name.parse().ok()).collect();
    Ok(Columns::of(match numbers.as_slice() {
        [x, y, z] if numbers.iter().all(|number| *number > 0) => [*x, *y, *z].map(Column::Numbered),
        _ => [*x, *y, *z].map(|name| Column::Named(name.to_owned())),
    }))
}

/// The JSON of `log`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LogRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The log.
    pub(crate) file: String,
    /// Its format.
    pub(crate) format: &'static str,
    /// Unit of the positions; `null` where a measurement is to state it.
    #[schemars(schema_with = "schema::units_or_null")]
    pub(crate) units: Option<&'static str>,
    /// What they are always relative to; `null` where a point tells it, or a measurement is to state it.
    pub(crate) frame: Option<&'static str>,
    /// Its points, in its order.
    pub(crate) points: Vec<PointRecord>,
}

/// One point of a log.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PointRecord {
    /// Which point, from 1.
    pub(crate) row: usize,
    /// What the program calls it.
    pub(crate) name: Option<String>,
    /// Line of the log, from 1.
    pub(crate) line: usize,
    /// Where it is; `null` where it has no position.
    pub(crate) at: Option<[f64; 3]>,
    /// Unit of its position, where the log tells it.
    #[schemars(schema_with = "schema::units_or_null")]
    pub(crate) units: Option<&'static str>,
    /// What its position is relative to, where the log tells it.
    pub(crate) base: Option<String>,
    /// The tool that was active, where the log tells it.
    pub(crate) tool: Option<String>,
    /// Why it has no position.
    pub(crate) unusable: Option<String>,
}

impl PointRecord {
    fn new(index: usize, point: &LoggedPoint) -> Self {
        let (at, unusable) = match &point.position {
            Position::At(at) => (Some([at.x, at.y, at.z]), None),
            Position::Unusable(fault) | Position::Empty(fault) => (None, Some(fault.message().to_owned())),
        };
        Self {
            row: index + 1,
            name: point.name.clone(),
            line: point.line,
            at,
            units: point.units.map(Units::name),
            base: point.base.clone(),
            tool: point.tool.clone(),
            unusable,
        }
    }
}

impl Args {
    pub(crate) fn run(self) -> Result<Output, Failure> {
        if self.from.takes_columns() != self.columns.is_some() {
            let message = if self.columns.is_some() {
                format!("format `{}` knows its columns", self.from.name)
            } else {
                format!("format `{}` needs the columns of the position", self.from.name)
            };
            let error = InputError::new("invalid-input", message).with_key("columns");
            return Err(error.with_help("--columns X,Y,Z goes with `--from csv`").into());
        }
        let input = Input::from(self.file);
        let log = MachineLog::read(self.from, &input, self.columns.as_ref())?;
        let record = LogRecord {
            schema: SCHEMA,
            file: input.name(),
            format: self.from.name,
            units: self.from.units.map(Units::name),
            frame: self.from.frame,
            points: log
                .points()
                .iter()
                .enumerate()
                .map(|(index, point)| PointRecord::new(index, point))
                .collect(),
        };
        Ok(Output::in_form(self.format, &record, &[], text::log))
    }
}
