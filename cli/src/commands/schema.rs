//! `schema`: JSON Schema of what is read and printed.

use std::io;

use schemars::SchemaGenerator;
use touchref::{
    Registry,
    io::{
        CalibrationRecord, ErrorRecord, InputError, SolutionRecord, calibration, refusal, schema, solution,
        write::json,
    },
};

use super::{
    batch, compare, describe, element, gauge, guide, history, list, log, plan, reliability, study,
    uncertainty,
};
use crate::{
    failure::Failure,
    output::Output,
    text::{self, Look},
};

/// Print the JSON Schema (draft 2020-12) of a measurement file or of a result; without a name list them
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref schema\n\
\x20 touchref schema solution")]
pub(crate) struct Args {
    /// What is described, as `measurement` or `solution`
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// What there is a schema of.
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    /// What reads or prints it.
    pub(crate) summary: &'static str,
    schema: fn(&Registry) -> serde_json::Value,
}

const fn entry(
    name: &'static str,
    summary: &'static str,
    schema: fn(&Registry) -> serde_json::Value,
) -> Entry {
    Entry { name, summary, schema }
}

/// All of them: those that other programs need first.
pub(crate) const ALL: &[Entry] = &[
    entry(
        "measurement",
        "a measurement file, TOML or JSON, with the fixtures of this program",
        schema::measurement,
    ),
    entry("solution", "what `locate` prints of a frame", |_| schema::of::<SolutionRecord>(solution::SCHEMA)),
    entry("error", "what any command prints where there is no result", |_| {
        schema::of::<ErrorRecord>(refusal::SCHEMA)
    }),
    entry("batch", "what `batch` prints", |_| schema::of::<batch::BatchRecord>(batch::SCHEMA)),
    entry("calibration", "what `calibrate` prints", |_| schema::of::<CalibrationRecord>(calibration::SCHEMA)),
    entry("comparison", "what `compare` prints", |_| {
        schema::of::<compare::ComparisonRecord>(compare::SCHEMA)
    }),
    entry("describe", "what `describe` prints", |_| schema::of::<describe::Description>(describe::SCHEMA)),
    entry("element", "what `element` prints", |_| schema::of::<element::ElementRecord>(element::SCHEMA)),
    entry("gauge", "what `gauge` prints", |_| schema::of::<gauge::GaugeRecord>(gauge::SCHEMA)),
    entry("guide", "what `guide` prints, an object a line", |_| schema::of::<guide::Answer>(guide::SCHEMA)),
    entry("history", "what `history` prints", |_| schema::of::<history::HistoryRecord>(history::SCHEMA)),
    entry("list", "what `list` prints", |_| schema::of::<list::Listing>(list::SCHEMA)),
    entry("log", "what `log` prints", |_| schema::of::<log::LogRecord>(log::SCHEMA)),
    entry("plan", "what `plan` prints, of a layout or of the next touch", |_| {
        let records: [fn(&mut SchemaGenerator) -> _; 2] = [
            SchemaGenerator::subschema_for::<plan::PlanRecord>,
            SchemaGenerator::subschema_for::<plan::NextRecord>,
        ];
        schema::any_of(plan::SCHEMA, &records)
    }),
    entry("reliability", "what `reliability` prints", |_| {
        schema::of::<reliability::ReliabilityRecord>(reliability::SCHEMA)
    }),
    entry("study", "what `study` prints", |_| schema::of::<study::StudyRecord>(study::SCHEMA)),
    entry("uncertainty", "what `uncertainty` prints", |_| {
        schema::of::<uncertainty::UncertaintyRecord>(uncertainty::SCHEMA)
    }),
];

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let Some(name) = &self.name else {
            return Ok(Output::bytes(text::schemas(ALL, Look::of(&io::stdout()))));
        };
        let Some(entry) = ALL.iter().find(|entry| entry.name == name) else {
            let known = ALL.iter().map(|entry| entry.name);
            return Err(InputError::unknown("unknown-name", "schema", name, known).with_key("name").into());
        };
        Ok(Output::bytes(json(&(entry.schema)(registry))))
    }
}
