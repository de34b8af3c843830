//! The `touchref` command: the command line with the built-in plugins.

use std::process::ExitCode;

fn main() -> ExitCode {
    touchref_cli::run(touchref::registry(), std::env::args_os())
}
