//! `locate`: from touches to the frame.

use std::path::PathBuf;

use touchref::{
    Dialect, Literal, Registry, Solution,
    io::{
        InputError, SolutionRecord, dialect,
        history::{self, Entry, History},
        solution::StepRecord,
        write::json,
    },
    solvers::refinement::Progress,
};

use crate::{
    args::Format,
    failure::Failure,
    output::{Output, Verbosity, note, verbosity},
    setup::{FULL_MARGIN, MeasurementArgs, NearArgs, Setup, SolverArgs, solve},
    text,
};

/// Find the frame of a fixture from touches on it
///
/// Prints a frame only when it passed its checks (exit status 0). Otherwise it says why there is none to trust (1), or
/// what is wrong with the input (2). With --record the result is kept before it is printed; what cannot be kept is not
/// printed, either (2).
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref locate examples/nederbragt-ravani.toml\n\
\x20 touchref locate examples/three-sphere.toml --dialect kuka --dialect matrix\n\
\x20 touchref locate examples/cube.toml --format json\n\
\x20 touchref locate examples/logs/kuka.toml --verbose")]
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
    /// Store in which the result is kept, a frame or a refusal; made where there is none
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// What the result is called in the store
    #[arg(long, value_name = "NAME", requires = "record")]
    name: Option<String>,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let found = self.dialects.iter().map(|name| Ok((name, dialect::find(registry, name)?)));
        let dialects = found.collect::<Result<Vec<_>, InputError>>()?;
        let solver = self.solver.build(registry, &FULL_MARGIN)?;
        let near = self.near.frame()?;
        // A store that cannot be written is better known before the work than after it.
        let store = self.record.as_deref().map(History::append_to).transpose();
        let mut store = store.map_err(|error| error.with_key("record"))?;
        let setup = self.measurement.load(registry)?;
        let told = solve(&setup, &*solver, near).and_then(|solution| record(&setup, &solution, &dialects));
        let record = match told {
            Ok(record) => record,
            Err(failure) => {
                if let (Some(store), Failure::Refused(_) | Failure::Untold(_)) = (&mut store, &failure) {
                    let record = failure.record();
                    append(store, &self.entry(&setup, &record.error.code, None, json(&record)))?;
                }
                return Err(failure);
            }
        };
        if let Some(store) = &mut store {
            let origin = Some(record.frame.origin);
            append(store, &self.entry(&setup, history::OK, origin, json(&record)))?;
        }
        Ok(Output::in_form(self.format, &record, &record.warnings, text::solution))
    }

    fn entry(&self, setup: &Setup, status: &str, origin: Option<[f64; 3]>, json: String) -> Entry {
        Entry {
            name: self.name.clone(),
            measurement: self.measurement.origin(),
            fixture: setup.measurement.kind.clone(),
            status: status.to_owned(),
            units: setup.measurement.units.name().to_owned(),
            origin,
            json,
        }
    }
}

/// Keeps a result, and tells its number.
///
/// Where that fails there is no result at all: who asks for a record relies on it, and a frame on standard output with
/// status 0 would say that there is one.
fn append(store: &mut History, entry: &Entry) -> Result<(), InputError> {
    let number = store.append(entry)?;
    note(&format!("recorded as {number} in {}\n", store.file()));
    Ok(())
}

fn record(
    setup: &Setup,
    solution: &Solution,
    dialects: &[(&String, Box<dyn Dialect>)],
) -> Result<SolutionRecord, Failure> {
    let mut record = setup.record(solution)?;
    if let (Verbosity::Verbose, Some(iteration)) = (verbosity(), &mut record.iteration) {
        iteration.history = Some(setup.history(solution)?.iter().map(step).collect());
    }
    let touched: Vec<_> = setup.touches()?.touches.iter().map(|touch| touch.at).collect();
    for (name, dialect) in dialects {
        let units = setup.measurement.units;
        record.tell(name, &Literal::new(name, &**dialect, &solution.frame, units, &touched)?);
    }
    Ok(record)
}

fn step(progress: &Progress) -> StepRecord {
    let Progress { chi_square, gradient, step, damping, taken } = *progress;
    let number = |value: f64| Some(value).filter(|value| value.is_finite());
    StepRecord {
        chi_square: number(chi_square),
        gradient: number(gradient),
        step: number(step),
        damping: number(damping),
        taken,
    }
}
