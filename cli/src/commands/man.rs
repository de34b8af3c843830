//! `man`: manual pages from the definition of the command line.

use std::{fs, path::PathBuf};

use clap::CommandFactory;

use crate::{args::Cli, failure::Failure, output::Output};

/// Print the manual page, or write the pages of every subcommand into a folder
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref man\n\
\x20 touchref man pages")]
pub(crate) struct Args {
    /// The folder
    #[arg(value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    folder: Option<PathBuf>,
}

impl Args {
    pub(crate) fn run(self) -> Result<Output, Failure> {
        match self.folder {
            None => {
                let mut page = Vec::new();
                clap_mangen::Man::new(Cli::command())
                    .render(&mut page)
                    .map_err(|error| Failure::writing("the manual page", &error))?;
                Ok(Output::bytes(page))
            }
            Some(folder) => {
                fs::create_dir_all(&folder)
                    .and_then(|()| clap_mangen::generate_to(Cli::command(), &folder))
                    .map_err(|error| Failure::writing(folder.display(), &error))?;
                Ok(Output::nothing())
            }
        }
    }
}
