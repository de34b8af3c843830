//! What was measured, from the arguments that every subcommand on a measurement shares.

use std::{path::PathBuf, time::Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};
pub(crate) use touchref::locate::{FULL_MARGIN, Setup};
use touchref::{
    Frame, Parameters, Registry, Solution, Solver,
    io::{Input, InputError, Measurement, TouchSource, Units, parameter, read_frame},
    locate::{build_solver, solver_plugin},
};

use crate::{
    failure::Failure,
    output::{Verbosity, note_on_the_way, verbosity, working},
    text,
};

/// A measurement file, or what would stand in one; arguments take the place of what the file says.
#[derive(Debug, clap::Args)]
pub(crate) struct MeasurementArgs {
    /// Measurement file (TOML or JSON), or - for standard input
    #[arg(value_name = "MEASUREMENT", required_unless_present = "fixture", conflicts_with = "fixture")]
    file: Option<PathBuf>,
    /// Kind of the fixture, instead of a measurement file
    #[arg(long, value_name = "KIND")]
    fixture: Option<String>,
    /// Parameter of the fixture, as `radius=15`, `radius=15+-0.002`, `radii=[12,12,15]`; may be repeated
    #[arg(short, long = "parameter", value_name = "NAME=VALUE", value_parser = name_and_value)]
    parameters: Vec<(String, String)>,
    /// Touch table (CSV), or - for standard input
    #[arg(long, value_name = "TABLE")]
    touches: Option<PathBuf>,
    /// Unit of every length, where no file states it [default: mm]
    #[arg(long, value_name = "UNIT", value_parser = units(), conflicts_with = "file")]
    units: Option<Units>,
    /// Radius of the probe tip, as `1.5` or `1.5+-0.001`; 0 where touches are surface points
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    tip_radius: Option<String>,
    /// Standard deviation of one touch along the normal
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    sigma: Option<f64>,
}

/// Where the frame is expected.
#[derive(Debug, clap::Args)]
pub(crate) struct NearArgs {
    /// Frame near which the answer is expected: x,y,z,qx,qy,qz,qw or a result file
    #[arg(long, value_name = "FRAME", allow_hyphen_values = true, value_hint = clap::ValueHint::FilePath)]
    near: Option<String>,
}

/// More threads than any machine has use for.
const MOST_THREADS: i64 = 1024;

/// How many threads work.
#[derive(Debug, clap::Args)]
pub(crate) struct ThreadArgs {
    /// Threads to work on [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
}

impl ThreadArgs {
    /// As many threads as were asked for.
    pub(crate) fn pool(&self) -> Result<ThreadPool, InputError> {
        // Without a number rayon takes that of the processors, or of RAYON_NUM_THREADS.
        let threads = ThreadPoolBuilder::new().num_threads(self.threads.map_or(0, usize::from)).build();
        threads.map_err(|error| {
            InputError::new("invalid-input", format!("cannot start the threads: {error}"))
                .with_key("threads")
                .with_help("give a smaller --threads")
        })
    }
}

impl NearArgs {
    /// The frame, if one is given.
    pub(crate) fn frame(&self) -> Result<Option<Frame>, InputError> {
        self.near.as_deref().map(read_frame).transpose().map_err(|error| error.with_key("near"))
    }
}

/// Which solver is taken.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct SolverArgs {
    /// Solver [default: least-squares]
    #[arg(long, value_name = "NAME")]
    solver: Option<String>,
    /// Parameter of the solver, as `margin=full`; may be repeated
    #[arg(long = "solver-parameter", value_name = "NAME=VALUE", value_parser = name_and_value)]
    solver_parameters: Vec<(String, String)>,
}

pub(crate) fn name_and_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected NAME=VALUE".to_owned()),
    }
}

fn units() -> impl clap::builder::TypedValueParser<Value = Units> {
    use clap::builder::{PossibleValuesParser, TypedValueParser as _};
    PossibleValuesParser::new(Units::ALL.map(Units::name))
        .map(|name| Units::from_name(&name).unwrap_or(Units::Millimetre))
}

impl MeasurementArgs {
    /// Whether the measurement or its touches come from standard input.
    pub(crate) fn reads_stdin(&self) -> bool {
        [&self.file, &self.touches]
            .into_iter()
            .flatten()
            .any(|path| Input::from(path.clone()) == Input::Stdin)
    }

    /// Where the measurement comes from, for people.
    pub(crate) fn origin(&self) -> String {
        match (&self.file, &self.touches) {
            (Some(input), _) | (None, Some(input)) => Input::from(input.clone()).name(),
            (None, None) => "arguments".to_owned(),
        }
    }

    /// Reads the measurement file, puts the arguments over it and builds the fixture.
    pub(crate) fn load(&self, registry: &Registry) -> Result<Setup, InputError> {
        let touches = self.touches.clone().map(Input::from);
        let file = self.file.clone().map(Input::from);
        if (&file, &touches) == (&Some(Input::Stdin), &Some(Input::Stdin)) {
            let message = "both the measurement and the touch table are to come from standard input";
            return Err(InputError::new("invalid-input", message)
                .with_key("touches")
                .with_help("give one of them as a file"));
        }
        let mut measurement = match (&file, &self.fixture) {
            (Some(file), _) => Measurement::read(file)?,
            (None, kind) => {
                Measurement::new(kind.as_deref().unwrap_or_default(), self.units.unwrap_or(Units::Millimetre))
            }
        };
        let plugin = measurement.plugin(registry)?;
        for (name, text) in &self.parameters {
            measurement.set_parameter(plugin, name, text)?;
        }
        if let Some(input) = touches {
            measurement.touches = TouchSource::Table(input);
        }
        if let Some(text) = &self.tip_radius {
            measurement.set_tip_radius(text)?;
        }
        if let Some(sigma) = self.sigma {
            measurement.set_sigma(sigma)?;
        }
        Setup::new(measurement, registry)
    }
}

impl SolverArgs {
    /// Builds the solver. Of `presets`, the parameters that it has take these values where no argument gives others.
    pub(crate) fn build(
        &self,
        registry: &Registry,
        presets: &[(&str, &str)],
    ) -> Result<Box<dyn Solver>, InputError> {
        let plugin = solver_plugin(registry, self.solver.as_deref())?;
        let mut parameters = Parameters::new();
        for (name, text) in &self.solver_parameters {
            let solver = format!("solver `{}`", plugin.name);
            parameters.set(name, parameter::from_argument(&solver, plugin.parameters, name, text)?);
        }
        build_solver(plugin, presets, &parameters)
    }
}

/// Solves for the frame, expected near `near` if that is given; tells that it works, and on demand how.
pub(crate) fn solve(setup: &Setup, solver: &dyn Solver, near: Option<Frame>) -> Result<Solution, Failure> {
    let (began, working) = (Instant::now(), working("looking for every frame"));
    let solution = setup.solve(solver, near);
    drop(working);
    let (solution, took) = (solution?, began.elapsed());
    if verbosity() == Verbosity::Verbose {
        let history = setup.history(&solution)?;
        let units = setup.measurement.units.name();
        note_on_the_way(|look| text::search(&solution, &history, took, units, look));
    }
    Ok(solution)
}

/// No sigma where noise is to be simulated.
pub(crate) fn no_sigma() -> InputError {
    missing_sigma("no sigma is stated, so there is no noise to simulate".to_owned())
}

/// No sigma where one is needed.
pub(crate) fn missing_sigma(message: String) -> InputError {
    InputError::new("missing-key", message)
        .with_key("probe.sigma")
        .with_help("give --sigma S, or `sigma` under [probe]")
}
