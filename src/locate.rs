//! From a measurement to what is told of its frame: what the command line's `locate` does, for a program to call.
//!
//! ```
//! use std::path::Path;
//! use touchref::{io::Measurement, locate::{Setup, locating_solver}, Parameters};
//!
//! let registry = touchref::registry()?;
//! let text = std::fs::read_to_string("examples/nederbragt-ravani.toml")?;
//! let measurement = Measurement::from_text("measurement", &text, Path::new("examples"))?;
//! let setup = Setup::new(measurement, &registry)?;
//! let solver = locating_solver(&registry, None, &Parameters::new())?;
//! match setup.solve(&*solver, None) {
//!     Ok(solution) => println!("{}", serde_json::to_string(&setup.record(&solution)?)?),
//!     Err(failure) => println!("{}", serde_json::to_string(&failure.record())?),
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::cell::OnceCell;

use thiserror::Error;
use touchref_core::{
    DialectError, Fault, Fixture, Frame, Parameters, Problem, Registry, Solution, SolveError, Solver,
    SolverPlugin, Value, Warning,
};
use touchref_io::{
    ErrorRecord, InputError, Measurement, SolutionRecord, TouchRecord, TouchSource, Touches, Units,
    solution::{Context, WarningRecord},
};
use touchref_solvers::{
    labelling::{self, Tip},
    refinement::{Progress, retrace},
    robust,
};

/// The solver that is taken where it is linked in, and the one taken elsewhere.
const DEFAULT_SOLVERS: [&str; 2] = ["least-squares", "closed-form"];

/// One frame may take its time: how far it stands is told as far as it does. For [`build_solver`].
pub const FULL_MARGIN: [(&str, &str); 1] = [("margin", "full")];

/// The solver of this name, or the one that is taken where none is named.
///
/// # Errors
/// `unknown-solver`, with the nearest name.
pub fn solver_plugin(registry: &Registry, name: Option<&str>) -> Result<&'static SolverPlugin, InputError> {
    let linked = |name: &&str| registry.solver(name).is_ok();
    let name = name.or_else(|| DEFAULT_SOLVERS.into_iter().find(linked)).unwrap_or(DEFAULT_SOLVERS[0]);
    registry.solver(name).map_err(|error| InputError::from(error).with_key("solver"))
}

/// Builds a solver. Of `presets`, the parameters that it has take these words where `given` has no others.
///
/// # Errors
/// `unknown-key`, `missing-key` or `invalid-input` for the first parameter that is wrong.
pub fn build_solver(
    plugin: &SolverPlugin,
    presets: &[(&str, &str)],
    given: &Parameters,
) -> Result<Box<dyn Solver>, InputError> {
    let mut parameters = given.clone();
    for (name, word) in presets {
        if plugin.parameters.iter().any(|spec| spec.name == *name) && given.get(name).is_none() {
            parameters.set(name, Value::from(*word));
        }
    }
    plugin.build(&parameters).map_err(|error| {
        let code = match error.fault {
            Fault::Unknown => "unknown-key",
            Fault::Missing => "missing-key",
            Fault::Wrong => "invalid-input",
        };
        InputError::new(code, format!("solver `{}`: {error}", plugin.name))
            .with_nearest(error.nearest.as_deref())
            .with_key(error.name.clone())
    })
}

/// The solver of this name with these parameters as `locate` takes it: with the [full margin](FULL_MARGIN).
///
/// # Errors
/// As [`solver_plugin`] and [`build_solver`].
pub fn locating_solver(
    registry: &Registry,
    name: Option<&str>,
    parameters: &Parameters,
) -> Result<Box<dyn Solver>, InputError> {
    build_solver(solver_plugin(registry, name)?, &FULL_MARGIN, parameters)
}

/// A measurement with its fixture built.
#[derive(Debug)]
pub struct Setup {
    /// The measurement.
    pub measurement: Measurement,
    /// Its fixture.
    pub fixture: Box<dyn Fixture>,
    /// The touches, once they are read: standard input gives them only once.
    touches: OnceCell<Touches>,
}

impl Setup {
    /// Builds the fixture of a measurement.
    ///
    /// # Errors
    /// As [`Measurement::fixture`].
    pub fn new(measurement: Measurement, registry: &Registry) -> Result<Self, InputError> {
        let fixture = measurement.fixture(registry)?;
        Ok(Self { measurement, fixture, touches: OnceCell::new() })
    }

    /// Whether the measurement has touches, or names a table of them.
    #[must_use]
    pub fn has_touches(&self) -> bool {
        self.measurement.touches != TouchSource::Absent
    }

    /// The measurement's touches, their surfaces found.
    ///
    /// # Errors
    /// As [`Measurement::touches`].
    pub fn touches(&self) -> Result<&Touches, InputError> {
        if let Some(touches) = self.touches.get() {
            return Ok(touches);
        }
        let touches = self.measurement.touches(&*self.fixture)?;
        Ok(self.touches.get_or_init(|| touches))
    }

    /// What the user should know of the touches, as far as they are read.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        self.touches.get().map_or(&[], |touches| &touches.warnings)
    }

    /// The measurement for a solver.
    ///
    /// # Errors
    /// What is wrong with the touches.
    pub fn problem(&self) -> Result<Problem<'_>, InputError> {
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
                .map_err(|error| Failure::from(self.refused_of(error, records, String::new())))
        })?;
        let _ = self.touches.set(touches);
        Ok(())
    }

    /// Solves for the frame, expected near `near` if that is given. Only `robust` finds the surfaces that touches leave
    /// open.
    ///
    /// # Errors
    /// What is wrong with the touches, or why there is no frame to trust.
    pub fn solve(&self, solver: &dyn Solver, near: Option<Frame>) -> Result<Solution, Failure> {
        if solver.name() == robust::PLUGIN.name {
            self.label()?;
        }
        let problem = self.problem()?;
        let problem = near.map_or(problem, |frame| problem.near(frame));
        Ok(solver.solve(&problem).map_err(|error| self.refused(error))?)
    }

    /// What each step did that led to a solution.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn history(&self, solution: &Solution) -> Result<Vec<Progress>, Failure> {
        Ok(retrace(&self.problem()?, solution).map_err(|error| self.refused(error))?)
    }

    /// A refusal, with the touches it is about.
    #[must_use]
    pub fn refused(&self, error: SolveError) -> Refused {
        match self.touches.get() {
            Some(touches) => self.refused_of(error, &touches.records, touches.file.clone()),
            None => self.refused_of(error, &[], String::new()),
        }
    }

    fn refused_of(&self, error: SolveError, touches: &[TouchRecord], file: String) -> Refused {
        Refused { error, units: self.measurement.units, touches: touches.to_vec(), file }
    }

    /// What a result repeats of the measurement.
    ///
    /// # Errors
    /// What is wrong with the touches.
    pub fn context(&self) -> Result<Context<'_>, InputError> {
        Ok(Context {
            kind: self.fixture.kind(),
            parameters: self.fixture.parameters(),
            units: self.measurement.units,
            probe: &self.measurement.probe,
            touches: &self.touches()?.records,
        })
    }

    /// The result of a solution, still without dialects.
    ///
    /// # Errors
    /// What is wrong with the touches.
    pub fn record(&self, solution: &Solution) -> Result<SolutionRecord, InputError> {
        let mut record = SolutionRecord::new(&self.context()?, solution);
        record.warnings.extend(self.warnings().iter().map(WarningRecord::from));
        Ok(record)
    }
}

/// A solver's refusal, with the touches it is about.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{error}")]
pub struct Refused {
    /// Why there is no frame.
    pub error: SolveError,
    /// Unit of every length.
    pub units: Units,
    /// The touches of the measurement.
    pub touches: Vec<TouchRecord>,
    /// The file of the touches.
    pub file: String,
}

impl Refused {
    /// For programs.
    #[must_use]
    pub fn record(&self) -> ErrorRecord {
        let mut record = ErrorRecord::of_refusal(&self.error, self.units, &self.touches);
        // Suspects are no place in the input.
        if let (true, [touch, ..]) = (self.error.is_input_error(), record.error.findings.touches.as_slice()) {
            record.error.place.line = touch.line;
            record.error.place.file = Some(self.file.clone());
        }
        record
    }
}

/// Why there is no frame, or why it is not told.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Failure {
    /// An input or an argument is wrong.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A solver gives no frame.
    #[error(transparent)]
    Refused(Box<Refused>),
    /// A frame was found, but cannot be told in a dialect that was asked for.
    #[error(transparent)]
    Untold(#[from] DialectError),
}

impl From<Refused> for Failure {
    fn from(refused: Refused) -> Self {
        Self::Refused(Box::new(refused))
    }
}

impl Failure {
    /// The exit status: 1 where sound input gives no frame to trust, 2 where input is wrong.
    #[must_use]
    pub fn status(&self) -> u8 {
        match self {
            Self::Refused(refused) if !refused.error.is_input_error() => 1,
            Self::Untold(_) => 1,
            _ => 2,
        }
    }

    /// For programs.
    #[must_use]
    pub fn record(&self) -> ErrorRecord {
        match self {
            Self::Input(error) => error.into(),
            Self::Refused(refused) => refused.record(),
            Self::Untold(error) => error.into(),
        }
    }
}
