//! What was measured, from the arguments that every subcommand on a measurement shares.

use std::{cell::OnceCell, path::PathBuf, time::Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};
use touchref::{
    Fixture, Frame, Parameters, Problem, Registry, Solution, SolveError, Solver, SolverPlugin, Warning,
    io::{
        Input, InputError, Measurement, TouchRecord, TouchSource, Touches, Units, parameter, read_frame,
        solution::Context,
    },
    solvers::{
        labelling::{self, Tip},
        refinement::{Progress, retrace},
        robust,
    },
};

use crate::{
    failure::{Failure, Refused},
    output::{Verbosity, note_on_the_way, verbosity, working},
    text,
};

/// The solver that is taken where it is linked in, and the one taken elsewhere.
const DEFAULT_SOLVERS: [&str; 2] = ["least-squares", "closed-form"];

/// One frame may take its time: how far it stands is told as far as it does. For [`SolverArgs::build`].
pub(crate) const FULL_MARGIN: [(&str, &str); 1] = [("margin", "full")];

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

/// A measurement with its fixture built.
#[derive(Debug)]
pub(crate) struct Setup {
    pub(crate) measurement: Measurement,
    pub(crate) fixture: Box<dyn Fixture>,
    /// The touches, once they are read: standard input gives them only once.
    touches: OnceCell<Touches>,
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
        let fixture = measurement.fixture(registry)?;
        Ok(Setup { measurement, fixture, touches: OnceCell::new() })
    }
}

impl SolverArgs {
    /// Builds the solver. Of `presets`, the parameters that it has take these values where no argument gives others.
    pub(crate) fn build(
        &self,
        registry: &Registry,
        presets: &[(&str, &str)],
    ) -> Result<Box<dyn Solver>, InputError> {
        let plugin = match &self.solver {
            Some(name) => {
                registry.solver(name).map_err(|error| InputError::from(error).with_key("solver"))?
            }
            None => default_solver(registry)?,
        };
        let mut parameters = Parameters::new();
        let known = |(name, _): &&(&str, &str)| plugin.parameters.iter().any(|spec| spec.name == *name);
        let presets = presets.iter().filter(known).map(|(name, text)| (*name, *text));
        let given = self.solver_parameters.iter().map(|(name, text)| (name.as_str(), text.as_str()));
        for (name, text) in presets.chain(given) {
            let solver = format!("solver `{}`", plugin.name);
            parameters.set(name, parameter::from_argument(&solver, plugin.parameters, name, text)?);
        }
        plugin.build(&parameters).map_err(|error| {
            InputError::new("invalid-input", format!("solver `{}`: {error}", plugin.name))
                .with_key(error.name.clone())
        })
    }
}

/// The solver that is taken where none is named.
fn default_solver(registry: &Registry) -> Result<&'static SolverPlugin, InputError> {
    let linked = |name: &&str| registry.solver(name).is_ok();
    let name = DEFAULT_SOLVERS.into_iter().find(linked).unwrap_or(DEFAULT_SOLVERS[0]);
    Ok(registry.solver(name)?)
}

impl Setup {
    /// Whether the measurement has touches, or names a table of them.
    pub(crate) fn has_touches(&self) -> bool {
        self.measurement.touches != TouchSource::Absent
    }

    /// The measurement's touches, their surfaces found.
    pub(crate) fn touches(&self) -> Result<&Touches, InputError> {
        if let Some(touches) = self.touches.get() {
            return Ok(touches);
        }
        let touches = self.measurement.touches(&*self.fixture)?;
        Ok(self.touches.get_or_init(|| touches))
    }

    /// What the user should know of the touches, as far as they are read.
    pub(crate) fn warnings(&self) -> &[Warning] {
        self.touches.get().map_or(&[], |touches| &touches.warnings)
    }

    /// The measurement for a solver.
    pub(crate) fn problem(&self) -> Result<Problem<'_>, InputError> {
        Ok(Problem::new(&*self.fixture, &self.touches()?.touches, self.measurement.probe)?)
    }

    /// Reads the touches, and finds the surfaces of those that do not say on which they are.
    fn label(&self) -> Result<(), Failure> {
        if self.touches.get().is_some() {
            return Ok(());
        }
        let touches = self.measurement.touches_labelled_by(&*self.fixture, |records, surfaces| {
            let tips: Vec<Tip> = records
                .iter()
                .zip(surfaces)
                .map(|(record, surface)| {
                    let TouchRecord { at, noise, approach, .. } = *record;
                    Tip { surface: *surface, at, noise, approach }
                })
                .collect();
            labelling::label(&*self.fixture, &tips, self.measurement.probe)
                .map_err(|error| self.refused_of(error, records, String::new()))
        })?;
        let _ = self.touches.set(touches);
        Ok(())
    }

    /// Solves for the frame, expected near `near` if that is given.
    pub(crate) fn solve(&self, solver: &dyn Solver, near: Option<Frame>) -> Result<Solution, Failure> {
        let (began, working) = (Instant::now(), working("looking for every frame"));
        if solver.name() == robust::PLUGIN.name {
            self.label()?;
        }
        let problem = self.problem()?;
        let problem = near.map_or(problem, |frame| problem.near(frame));
        let solution = solver.solve(&problem).map_err(|error| self.refused(error));
        drop(working);
        let (solution, took) = (solution?, began.elapsed());
        if verbosity() == Verbosity::Verbose {
            let history = self.history(&solution)?;
            let units = self.measurement.units.name();
            note_on_the_way(|look| text::search(&solution, &history, took, units, look));
        }
        Ok(solution)
    }

    /// What each step did that led to a solution.
    pub(crate) fn history(&self, solution: &Solution) -> Result<Vec<Progress>, Failure> {
        retrace(&self.problem()?, solution).map_err(|error| self.refused(error))
    }

    /// A refusal, with the touches it is about.
    pub(crate) fn refused(&self, error: SolveError) -> Failure {
        match self.touches.get() {
            Some(touches) => self.refused_of(error, &touches.records, touches.file.clone()),
            None => self.refused_of(error, &[], String::new()),
        }
    }

    fn refused_of(&self, error: SolveError, touches: &[TouchRecord], file: String) -> Failure {
        let units = self.measurement.units;
        Failure::Refused(Box::new(Refused { error, units, touches: touches.to_vec(), file }))
    }

    /// What a result repeats of the measurement.
    pub(crate) fn context(&self) -> Result<Context<'_>, InputError> {
        Ok(Context {
            kind: self.fixture.kind(),
            parameters: self.fixture.parameters(),
            units: self.measurement.units,
            probe: &self.measurement.probe,
            touches: &self.touches()?.records,
        })
    }
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
