//! `export`: a result in the form that another program reads.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use touchref::{
    Registry,
    io::{
        Input, SolutionRecord,
        export::{self, Exporter},
    },
};

use crate::{
    failure::Failure,
    output::{Output, write_file},
};

/// Write a result in the form that another program reads
///
/// The result is what `locate --format json` prints; a refusal has no frame, and cannot be exported. The same result gives
/// the same bytes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref export after.json --to qif -o result.qif")]
pub(crate) struct Args {
    /// Result file, or - for standard input
    #[arg(value_name = "RESULT")]
    result: PathBuf,
    /// Form
    #[arg(long, value_name = "FORM", value_parser = exporters())]
    to: &'static Exporter,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

fn exporters() -> impl TypedValueParser<Value = &'static Exporter> {
    let forms = export::ALL.iter().map(|exporter| PossibleValue::new(exporter.name).help(exporter.summary));
    PossibleValuesParser::new(forms.collect::<Vec<_>>())
        .map(|name| export::find(&name).unwrap_or(&export::ALL[0]))
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let record = SolutionRecord::read(&Input::from(self.result))?;
        let fixture = record.fixture.build(registry)?;
        let bytes = (self.to.write)(&record, &*fixture)?;
        match &self.output {
            Some(path) => {
                write_file(path, |output| output.write_all(&bytes))?;
                Ok(Output::nothing())
            }
            None => Ok(Output::bytes(bytes)),
        }
    }
}
