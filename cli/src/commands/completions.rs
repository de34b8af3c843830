//! `completions`: completion of the command line in a shell.

use clap::{Arg, Command, CommandFactory, builder::PossibleValuesParser};
use clap_complete::Shell;
use touchref::{Registry, io::log};

use crate::{args::Cli, output::Output};

/// Print a completion script for a shell
///
/// It completes names of fixtures, solvers and dialects as this binary has them.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref completions bash")]
pub(crate) struct Args {
    /// The shell
    shell: Shell,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Output {
        let mut command = Cli::command().mut_subcommands(|subcommand| with_names(subcommand, registry));
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut command, "touchref", &mut script);
        Output::bytes(script)
    }
}

/// A subcommand whose arguments know the names that they take. On a command line they take any: a wrong one is told with
/// the nearest, as in a file.
fn with_names(subcommand: Command, registry: &Registry) -> Command {
    let fixtures: Vec<&'static str> = registry.fixtures().iter().map(|plugin| plugin.name).collect();
    let solvers: Vec<&'static str> = registry.solvers().iter().map(|plugin| plugin.name).collect();
    let dialects: Vec<&'static str> = registry.dialects().iter().map(|plugin| plugin.name).collect();
    let logs: Vec<&'static str> = log::ALL.iter().map(|importer| importer.name).collect();
    let describes = subcommand.get_name() == "describe";
    subcommand.mut_args(|arg: Arg| {
        let names = match arg.get_id().as_str() {
            "fixture" => fixtures.clone(),
            "solver" => solvers.clone(),
            "dialects" => dialects.clone(),
            "name" if describes => [&fixtures, &solvers, &dialects, &logs].map(Vec::as_slice).concat(),
            _ => return arg,
        };
        arg.value_parser(PossibleValuesParser::new(names))
    })
}
