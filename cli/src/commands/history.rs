//! `history`: what `locate --record` has kept.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use clap::ValueEnum;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use touchref::io::{
    ErrorRecord, InputError, SolutionRecord,
    history::{self, Entry, History, Recorded, Selection},
    schema,
};

use crate::{
    failure::Failure,
    output::{Output, write_file},
    text::{self, Look},
};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.history/1";

/// List the results that `locate --record` has kept, or write them as result files
///
/// Times are UTC: 2026-01-31, 2026-01-31T12:00, 2026-01-31T12:00:00Z.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref history cell.db --last 10\n\
\x20 touchref history cell.db --export results")]
pub(crate) struct Args {
    /// Store
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    selection: SelectionArgs,
    /// Form of the list
    #[arg(long, value_enum, default_value_t)]
    format: ListFormat,
    /// Instead of listing, write each frame to this folder, as the result file NUMBER.json
    #[arg(long, value_name = "FOLDER", conflicts_with = "format", value_hint = clap::ValueHint::DirPath)]
    export: Option<PathBuf>,
}

/// Which results of a store are wanted.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct SelectionArgs {
    /// Only so many of the last results in the store
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    last: Option<u32>,
    /// Only results recorded at this time or later
    #[arg(long, value_name = "TIME")]
    since: Option<String>,
    /// Only results recorded before this time
    #[arg(long, value_name = "TIME")]
    until: Option<String>,
    /// Only results of this name
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Only results of this kind of fixture
    #[arg(long, value_name = "KIND")]
    fixture: Option<String>,
}

impl SelectionArgs {
    /// The same for a store.
    pub(crate) fn selection(&self) -> Selection {
        let Self { last, since, until, name, fixture } = self;
        Selection {
            last: *last,
            since: since.clone(),
            until: until.clone(),
            name: name.clone(),
            fixture: fixture.clone(),
            ..Selection::default()
        }
    }

    /// Whether all results are wanted.
    pub(crate) fn is_all(&self) -> bool {
        self.selection() == Selection::default()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum ListFormat {
    /// For people.
    #[default]
    Text,
    /// For programs, with the results themselves.
    Json,
    /// One row a result.
    Csv,
}

/// The JSON of `history`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct HistoryRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The store.
    pub(crate) file: String,
    /// The results, in the order of time.
    pub(crate) results: Vec<ResultRecord>,
}

/// What `locate` prints.
fn printed(generator: &mut SchemaGenerator) -> Schema {
    let [frame, refusal] =
        [generator.subschema_for::<SolutionRecord>(), generator.subschema_for::<ErrorRecord>()];
    json_schema!({ "anyOf": [frame, refusal] })
}

/// One result in a store.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ResultRecord {
    /// By which the store knows it, from 1.
    pub(crate) number: i64,
    /// When it was recorded, UTC.
    pub(crate) time: String,
    /// What the user calls it.
    pub(crate) name: Option<String>,
    /// Where the measurement came from.
    pub(crate) measurement: String,
    /// Kind of the fixture.
    pub(crate) fixture: String,
    /// `ok`, or the code of the refusal.
    pub(crate) status: String,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    pub(crate) units: String,
    /// The fixture's origin in the parent; `null` for a refusal.
    pub(crate) origin: Option<[f64; 3]>,
    /// As `locate` printed it: `touchref.solution/1` or `touchref.error/1`.
    #[schemars(schema_with = "printed")]
    result: serde_json::Value,
}

impl ResultRecord {
    fn new(recorded: &Recorded) -> Self {
        let Recorded { number, time, entry } = recorded.clone();
        Self {
            number,
            time,
            name: entry.name,
            measurement: entry.measurement,
            fixture: entry.fixture,
            status: entry.status,
            units: entry.units,
            origin: entry.origin,
            result: serde_json::from_str(&entry.json).unwrap_or_default(),
        }
    }
}

impl Args {
    pub(crate) fn run(self) -> Result<Output, Failure> {
        let recorded = History::open(&self.file)?.select(&self.selection.selection())?;
        if let Some(folder) = &self.export {
            return export(folder, &recorded);
        }
        if self.format == ListFormat::Csv {
            let table = csv(&recorded).map_err(|error| Failure::writing("the table", &error.into()))?;
            return Ok(Output::bytes(table));
        }
        let record = HistoryRecord {
            schema: SCHEMA,
            file: self.file.display().to_string(),
            results: recorded.iter().map(ResultRecord::new).collect(),
        };
        Ok(match self.format {
            ListFormat::Json => Output::json(&record),
            _ => Output::bytes(text::history(&record, Look::of(&io::stdout()))),
        })
    }
}

/// Writes every frame to a file of its own.
fn export(folder: &Path, recorded: &[Recorded]) -> Result<Output, Failure> {
    fs::create_dir_all(folder).map_err(|error| Failure::writing(folder.display(), &error))?;
    let frames = || recorded.iter().filter(|recorded| recorded.entry.status == history::OK);
    for Recorded { number, entry, .. } in frames() {
        let path = folder.join(format!("{number:06}.json"));
        write_file(&path, |file| file.write_all(entry.json.as_bytes()))?;
    }
    let (written, refusals) = (frames().count(), recorded.len() - frames().count());
    let told = match refusals {
        0 => format!("{written} result files written to {}", folder.display()),
        _ => format!("{written} result files written to {}, refusals left out: {refusals}", folder.display()),
    };
    Ok(Output::nothing().with_notes([told]))
}

/// One row a result, numbers with the digits that round-trip.
fn csv(recorded: &[Recorded]) -> csv::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let columns = ["number", "time", "name", "measurement", "fixture", "status", "units", "x", "y", "z"];
    table.write_record(columns)?;
    for Recorded { number, time, entry } in recorded {
        let Entry { name, measurement, fixture, status, units, origin, .. } = entry;
        let origin = origin.map_or([None; 3], |origin| origin.map(Some));
        table.serialize((number, time, name, measurement, fixture, status, units, origin))?;
    }
    table.into_inner().map_err(|error| error.into_error().into())
}

/// Reads results of a store for another command, refusals left out.
pub(crate) fn frames(file: &Path, selection: Selection) -> Result<Vec<Recorded>, InputError> {
    History::open(file)?.select(&Selection { status: Some(history::OK.to_owned()), ..selection })
}
