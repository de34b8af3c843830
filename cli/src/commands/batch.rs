//! `batch`: the frames of many placements, from a table to a table.

use std::{collections::BTreeMap, io, path::PathBuf};

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;
use touchref::{
    Registry,
    batch::{
        Counts, Locator,
        table::{self, Form},
    },
    io::{
        Input, InputError, Measurement, schema,
        solution::{FixtureRecord, ProbeRecord, WarningRecord},
    },
};

use crate::{
    args::Format,
    failure::Failure,
    output::{NewFile, Output, progress, progress_without_end},
    setup::{NearArgs, SolverArgs, ThreadArgs},
    text,
};

/// Locate many placements of one fixture: a table of touches with a column `placement` becomes a table of frames
///
/// The rows of a placement stand together. Each placement becomes one row, in the table's order: with its frame and covariance,
/// or with the code of its refusal as status and no numbers. The output is there whole or not at all.
/// Exit status: 0 when every placement has its row, whatever its status; 2 when the table is wrong other than in single
/// touches.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref batch placements.csv --measurement examples/cube.toml -o frames.csv")]
pub(crate) struct Args {
    /// Table of touches (.csv, .ndjson, .parquet), or - for standard input
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// Measurement file: fixture, units and probe; its touches are not used
    #[arg(long, value_name = "MEASUREMENT")]
    measurement: PathBuf,
    /// Where the frames go, in the form that its name tells: .csv, .ndjson or .parquet
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Form of the table of touches, where its name does not tell it [default for standard input: csv]
    #[arg(long, value_name = "FORM", value_enum)]
    input_form: Option<InputForm>,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    near: NearArgs,
    /// Locate plain placements many at once, in the vectors of the processor: the same frames to a millionth of their standard
    /// deviations, not to the bit
    #[arg(long)]
    fast: bool,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Form of the summary
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum InputForm {
    Csv,
    Ndjson,
    Parquet,
}

impl From<InputForm> for Form {
    fn from(form: InputForm) -> Self {
        match form {
            InputForm::Csv => Self::Csv,
            InputForm::Ndjson => Self::Ndjson,
            InputForm::Parquet => Self::Parquet,
        }
    }
}

/// What [`BatchRecord`] states.
pub(super) const SCHEMA: &str = "touchref.batch/1";

/// The JSON of `batch`: what became of how many placements.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct BatchRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The fixture.
    fixture: FixtureRecord,
    /// Name of the solver.
    solver: &'static str,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    units: &'static str,
    /// The probe as used.
    probe: ProbeRecord,
    /// The table of frames.
    pub(crate) output: String,
    /// How many there were.
    pub(crate) placements: u64,
    /// How many by status: `ok`, or the code of the refusal.
    pub(crate) status: BTreeMap<&'static str, u64>,
    /// What the user should know although the table is there.
    warnings: Vec<WarningRecord>,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let solver = self.solver.build(registry, &[])?;
        let near = self.near.frame()?;
        let (input, file) = (Input::from(self.table.clone()), Input::from(self.measurement.clone()));
        if (&input, &file) == (&Input::Stdin, &Input::Stdin) {
            let message = "both the measurement and the touch table are to come from standard input";
            return Err(InputError::new("invalid-input", message)
                .with_key("measurement")
                .with_help("give one of them as a file")
                .into());
        }
        let form = match (self.input_form, &input) {
            (Some(form), _) => form.into(),
            (None, Input::Stdin) => Form::Csv,
            (None, Input::File(path)) => Form::of(path)?,
        };
        let output_form = Form::of(&self.output).map_err(|error| error.with_key("output"))?;
        let measurement = Measurement::read(&file)?;
        let fixture = measurement.fixture(registry)?;
        let locator = Locator {
            fixture: &*fixture,
            solver: &*solver,
            probe: measurement.probe,
            units: measurement.units,
            near,
            fast: self.fast,
        };
        let mut source = table::open(&input, form, &*fixture, measurement.units)?;
        let bar = source.rows().map_or_else(progress_without_end, progress);
        let unwritable = |error: io::Error| Failure::writing(self.output.display(), &error);
        let mut new = NewFile::create(&self.output).map_err(unwritable)?;
        let schema = locator.schema(source.names());
        let mut frames = table::create(output_form, &schema, new.writer()).map_err(unwritable)?;
        let pool = self.threads.pool()?;
        let counts = pool.install(|| {
            locator.run(&mut *source, &mut |located| {
                bar.inc(located.rows);
                frames.write(&located.frames).map_err(unwritable)
            })
        });
        drop(bar);
        let counts = counts?;
        if counts.placements() == 0 {
            let error = InputError::new("too-few-touches", "the table has columns but no touches");
            return Err(error.with_file(&input.name()).into());
        }
        frames.finish().map_err(unwritable)?;
        new.keep().map_err(unwritable)?;
        let warnings: Vec<WarningRecord> = source.warnings().iter().map(WarningRecord::from).collect();
        let record = self.record(&locator, &measurement, counts, warnings);
        Ok(Output::in_form(self.format, &record, &record.warnings, text::batch))
    }

    fn record(
        &self,
        locator: &Locator<'_>,
        measurement: &Measurement,
        counts: Counts,
        warnings: Vec<WarningRecord>,
    ) -> BatchRecord {
        BatchRecord {
            schema: SCHEMA,
            fixture: FixtureRecord::new(locator.fixture.kind(), locator.fixture.parameters()),
            solver: locator.solver.name(),
            units: measurement.units.name(),
            probe: ProbeRecord::from(&measurement.probe),
            output: self.output.display().to_string(),
            placements: counts.placements(),
            status: counts.0,
            warnings,
        }
    }
}
