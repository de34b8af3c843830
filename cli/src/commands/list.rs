//! `list`: what there is by name.

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;
use touchref::{Plugin, Registry, io::log};

use crate::{args::Format, output::Output, text};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.list/1";

/// List the fixtures, solvers, dialects and formats of logs there are
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref list\n\
\x20 touchref list dialects")]
pub(crate) struct Args {
    /// Only these
    #[arg(value_enum)]
    what: Option<What>,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// The module that every importer of logs comes from.
pub(crate) const LOG_ORIGIN: &str = "touchref_io::log";

/// What can be listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    Fixtures,
    Solvers,
    Dialects,
    Logs,
}

/// The JSON of `list`: only what was asked for.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Listing {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// Fixtures, sorted by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) fixtures: Option<Vec<Item>>,
    /// Solvers, sorted by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) solvers: Option<Vec<Item>>,
    /// Dialects, sorted by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) dialects: Option<Vec<Item>>,
    /// Formats of logs, sorted by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) logs: Option<Vec<Item>>,
}

/// One thing by name.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Item {
    /// By which it is called.
    pub(crate) name: &'static str,
    /// What it is, in one line.
    pub(crate) summary: &'static str,
    /// Crate and module it comes from.
    origin: &'static str,
}

impl Item {
    fn of(plugin: &'static impl Plugin) -> Self {
        Self { name: plugin.name(), summary: plugin.summary(), origin: plugin.origin() }
    }
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Output {
        let wanted = |what| self.what.is_none_or(|only| only == what);
        let of_log = |importer: &'static log::Importer| Item {
            name: importer.name,
            summary: importer.summary,
            origin: LOG_ORIGIN,
        };
        let listing = Listing {
            schema: SCHEMA,
            fixtures: wanted(What::Fixtures)
                .then(|| registry.fixtures().iter().map(|p| Item::of(*p)).collect()),
            solvers: wanted(What::Solvers).then(|| registry.solvers().iter().map(|p| Item::of(*p)).collect()),
            dialects: wanted(What::Dialects)
                .then(|| registry.dialects().iter().map(|p| Item::of(*p)).collect()),
            logs: wanted(What::Logs).then(|| log::ALL.iter().map(of_log).collect()),
        };
        Output::in_form(self.format, &listing, &[], text::listing)
    }
}
