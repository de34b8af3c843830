//! `completions`: completion of the command line in a shell.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::{args::Cli, output::Output};

/// Print a completion script for a shell
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The shell
    shell: Shell,
}

impl Args {
    pub(crate) fn run(self) -> Output {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "touchref", &mut script);
        Output::bytes(script)
    }
}
