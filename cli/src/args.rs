//! The definition of the command line: what may be typed.

use std::ffi::OsString;

use clap::{Parser, Subcommand, ValueEnum};
use touchref::Registry;

use crate::{
    commands,
    failure::Failure,
    output::{Output, Verbosity},
};

/// From labelled probe touches on a reference fixture to its frame, with its uncertainty.
///
/// Exit status: 0 a frame that passed its checks; 1 the input is sound but gives no frame to trust; 2 the input or the
/// call is wrong.
#[derive(Debug, Parser)]
#[command(name = "touchref", version, propagate_version = true, max_term_width = 110)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print nothing on standard error but errors: no warnings, no progress
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Tell on standard error how a frame was found: every start, minimum and step
    #[arg(short, long, global = true)]
    verbose: bool,
}

impl Cli {
    /// What is wanted on standard error besides errors.
    pub(crate) fn verbosity(&self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        }
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Locate(commands::locate::Args),
    List(commands::list::Args),
    Describe(commands::describe::Args),
    Simulate(commands::simulate::Args),
    Study(commands::study::Args),
    Plan(commands::plan::Args),
    Guide(commands::guide::Args),
    Uncertainty(commands::uncertainty::Args),
    Reliability(commands::reliability::Args),
    Element(commands::element::Args),
    Calibrate(commands::calibrate::Args),
    Batch(commands::batch::Args),
    Gauge(commands::gauge::Args),
    Log(commands::log::Args),
    Compare(commands::compare::Args),
    History(commands::history::Args),
    Export(commands::export::Args),
    Schema(commands::schema::Args),
    Report(commands::report::Args),
    Completions(commands::completions::Args),
    Man(commands::man::Args),
}

impl Command {
    /// Does what was typed.
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        match self {
            Self::Locate(args) => args.run(registry),
            Self::List(args) => Ok(args.run(registry)),
            Self::Describe(args) => args.run(registry),
            Self::Simulate(args) => args.run(registry),
            Self::Study(args) => args.run(registry),
            Self::Plan(args) => args.run(registry),
            Self::Guide(args) => args.run(registry),
            Self::Uncertainty(args) => args.run(registry),
            Self::Reliability(args) => args.run(registry),
            Self::Element(args) => args.run(),
            Self::Calibrate(args) => args.run(registry),
            Self::Batch(args) => args.run(registry),
            Self::Gauge(args) => args.run(),
            Self::Log(args) => args.run(),
            Self::Compare(args) => args.run(registry),
            Self::History(args) => args.run(),
            Self::Export(args) => args.run(registry),
            Self::Schema(args) => args.run(registry),
            Self::Report(args) => args.run(registry),
            Self::Completions(args) => Ok(args.run(registry)),
            Self::Man(args) => args.run(),
        }
    }
}

/// In which form a result is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum Format {
    /// For people.
    #[default]
    Text,
    /// For programs.
    Json,
}

/// Whether the arguments ask for JSON, as far as can be told without parsing them.
pub(crate) fn asks_for_json(args: &[OsString]) -> bool {
    let mut before_end = args.iter().take_while(|arg| *arg != "--").peekable();
    while let Some(arg) = before_end.next() {
        let separate = arg == "--format" && before_end.peek().is_some_and(|value| *value == "json");
        if separate || arg == "--format=json" {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn everything_that_may_be_typed_is_explained() {
        for subcommand in Cli::command().get_subcommands() {
            let name = subcommand.get_name();
            assert!(subcommand.get_about().is_some(), "{name}");
            let examples = subcommand.get_after_help().map(ToString::to_string).unwrap_or_default();
            assert!(examples.contains(&format!("touchref {name}")), "{name} has no example");
            for arg in subcommand.get_arguments() {
                assert!(arg.get_help().is_some(), "{name}: {}", arg.get_id());
            }
        }
    }

    #[test]
    fn json_is_seen_in_any_arguments() {
        let asks = |args: &[&str]| asks_for_json(&args.iter().map(OsString::from).collect::<Vec<_>>());
        assert!(asks(&["touchref", "lcate", "--format", "json"]));
        assert!(asks(&["touchref", "--format=json", "--what"]));
        assert!(!asks(&["touchref", "locate", "--format", "text", "json"]));
        assert!(!asks(&["touchref", "locate", "--", "--format=json"]));
    }
}
