//! `report`: a result as one HTML page.

use std::path::PathBuf;

use touchref::{
    Registry,
    io::{Input, SolutionRecord},
    report::{Options, page},
};

use crate::{
    failure::Failure,
    output::{Output, write_file},
    points::PointArgs,
};

/// Write a result as one HTML page for the record: verdict, view in three dimensions, charts, budget, every dialect
///
/// RESULT is what `locate --format json` printed; a refusal has no frame to report. The page is one file that opens in any
/// browser, uses no network, prints to A4, and is readable without JavaScript. It shows the touches as measured with their
/// SHA-256.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref report after.json -o report.html\n\
\x20 touchref report after.json --at 300,0,0 --title \"Cell 4\" -o report.html")]
pub(crate) struct Args {
    /// Result file; - for standard input
    #[arg(value_name = "RESULT")]
    result: PathBuf,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    points: PointArgs,
    /// Title of the page [default: names the fixture]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Words for the record, as who measured when; may be repeated
    #[arg(long = "note", value_name = "TEXT")]
    notes: Vec<String>,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let record = SolutionRecord::read(&Input::from(self.result))?;
        let options = Options { title: self.title, notes: self.notes, points: self.points.points() };
        let page = page(&record, registry, &options)?;
        match &self.output {
            Some(path) => {
                write_file(path, |output| output.write_all(page.as_bytes())).map(|()| Output::nothing())
            }
            None => Ok(Output::bytes(page)),
        }
    }
}
