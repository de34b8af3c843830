//! The command line of touchref as a library, so that a binary with plugins of its own is a few lines:
//!
//! ```no_run
//! use my_fixtures as _; // registers its fixtures with `touchref::register_fixture!`
//! # mod my_fixtures {}
//!
//! fn main() -> std::process::ExitCode {
//!     touchref_cli::run(touchref::registry(), std::env::args_os())
//! }
//! ```
//!
//! Each subcommand is a file that turns what was typed into what is to be printed; `output` alone prints. Results go
//! to standard output, everything else to standard error; exit status 0 is a frame that passed its checks, 1 sound
//! input without a frame to trust, 2 input or a call that is wrong.

mod args;
mod commands;
mod failure;
mod layout;
mod output;
mod planning;
mod points;
mod samples;
mod setup;
mod text;

use std::{ffi::OsString, process::ExitCode};

use clap::Parser;
use touchref::{Registry, RegistryError};

use crate::{args::Cli, failure::Failure, output::Output};

/// Runs the command line: parses `args` (the first is the program's name), does what they say and prints it.
///
/// Takes the registry as [`touchref::registry()`] gives it: a name that two plugins share is told like any other error.
pub fn run(registry: Result<Registry, RegistryError>, args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let args: Vec<OsString> = args.into_iter().collect();
    // Known even when the rest of the arguments is wrong, so that a program gets the error in its language.
    let json = args::asks_for_json(&args);
    output::set_verbosity(output::Verbosity::Normal);
    let outcome = registry.map_err(Failure::from).and_then(|registry| execute(&registry, args));
    ExitCode::from(output::print(outcome, json))
}

fn execute(registry: &Registry, args: Vec<OsString>) -> Result<Output, Failure> {
    let cli = Cli::try_parse_from(args)?;
    output::set_verbosity(cli.verbosity());
    cli.command.run(registry)
}
