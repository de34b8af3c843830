//! `locate`: from touches to the frame.

use std::io;

use touchref::{
    Literal, Registry,
    io::{InputError, SolutionRecord, dialect, solution::WarningRecord},
};

use crate::{
    args::Format,
    failure::Failure,
    output::Output,
    setup::{MeasurementArgs, NearArgs, SolverArgs},
    text::{self, Look},
};

/// One frame may take its time: how far it stands is told as far as it does.
const TRUST: [(&str, &str); 1] = [("margin", "full")];

/// Find the frame of a fixture from touches on it
///
/// Prints a frame only when it passed its checks (exit status 0). Otherwise it says why there is none to trust (1), or
/// what is wrong with the input (2).
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    measurement: MeasurementArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    near: NearArgs,
    /// Also print the frame in the words of a machine, as `kuka` or `euler:zyx:intrinsic:deg`; may be repeated
    #[arg(long = "dialect", value_name = "NAME")]
    dialects: Vec<String>,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let found = self.dialects.iter().map(|name| match dialect::find(registry, name) {
            Ok(dialect) => Ok((name, dialect)),
            Err(error) => Err(error.with_key("dialect")),
        });
        let dialects = found.collect::<Result<Vec<_>, InputError>>()?;
        let solver = self.solver.build(registry, &TRUST)?;
        let near = self.near.frame()?;
        let setup = self.measurement.load(registry)?;
        let solution = setup.solve(&*solver, near)?;

        let mut record = SolutionRecord::new(&setup.context()?, &solution);
        record.warnings.extend(setup.warnings().iter().map(WarningRecord::from));
        let touched: Vec<_> = setup.touches()?.touches.iter().map(|touch| touch.at).collect();
        for (name, dialect) in &dialects {
            let units = setup.measurement.units;
            record.tell(name, &Literal::new(name, &**dialect, &solution.frame, units, &touched)?);
        }
        Ok(match self.format {
            Format::Json => Output::json(&record),
            Format::Text => Output::bytes(text::solution(&record, Look::of(&io::stdout())))
                .with_notes(record.warnings.iter().map(|warning| format!("warning: {}", warning.message))),
        })
    }
}
