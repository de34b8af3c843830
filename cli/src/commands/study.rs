//! `study`: how often a frame would be right, refused or wrong.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use touchref::{
    Registry, Solver,
    analysis::{Estimate, Study, StudyError, StudyLayout, StudyOutcome},
    io::{
        InputError, Units, schema,
        solution::{FixtureRecord, ProbeRecord},
    },
};

use crate::{
    args::Format,
    failure::Failure,
    layout::{LayoutArgs, LayoutKind},
    output::{Output, progress},
    setup::{MeasurementArgs, Setup, SolverArgs, ThreadArgs, no_sigma, solve},
    text,
};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.study/1";

/// True frames have their origin within so many sizes of the fixture from the parent's along each axis. Results do not
/// depend on it, short of rounding.
const REACH_IN_SIZES: f64 = 10.0;

/// Tell how often a frame would be right, refused or wrong: simulated measurements, located and held against the truth
///
/// Each trial puts the fixture at a random frame, draws all that is uncertain (touches, and the fixture's parameters and
/// the tip radius where they state an uncertainty), locates it and compares. A frame is wrong when its true error lies
/// outside its own stated covariance at the 1e-9 level (chi-square above 53.34 with six degrees of freedom).
/// Exit status 0: the study was made, whatever came of it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref study examples/cube.toml --trials 1000\n\
\x20 touchref study examples/nederbragt-ravani.toml --layout random --trials 500")]
pub(crate) struct Args {
    #[command(flatten)]
    measurement: MeasurementArgs,
    #[command(flatten)]
    solver: SolverArgs,
    /// How many measurements are simulated
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(1..))]
    trials: u64,
    /// Seed: the same seed gives the same study, whatever the number of threads
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    layout: LayoutArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// The JSON of `study`. Where a number does not exist, as no frame was accepted, it is `null`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StudyRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The fixture.
    pub(crate) fixture: FixtureRecord,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    pub(crate) units: &'static str,
    /// The probe as used.
    pub(crate) probe: ProbeRecord,
    /// Name of the solver.
    pub(crate) solver: &'static str,
    /// Where the fixture is touched: `nominal`, `random` or `measurement`.
    #[schemars(extend("enum" = ["nominal", "random", "measurement"]))]
    pub(crate) layout: &'static str,
    /// By the surface's name.
    pub(crate) touches_per_surface: serde_json::Map<String, serde_json::Value>,
    /// Standard deviation of one touch.
    pub(crate) sigma: f64,
    /// Of the random numbers.
    pub(crate) seed: u64,
    /// Simulated measurements.
    pub(crate) trials: u64,
    /// Of these with a frame.
    pub(crate) accepted: u64,
    /// Part of the trials.
    pub(crate) accepted_rate: Option<f64>,
    /// The interval in which it lies with 95 % confidence.
    pub(crate) accepted_rate_95: Option<[f64; 2]>,
    /// Of these with a true error outside their covariance at the 1e-9 level.
    pub(crate) wrong: u64,
    /// Of the accepted, with 95 % confidence.
    pub(crate) wrong_rate_at_most: Option<f64>,
    /// The others, by the code of the refusal.
    pub(crate) refused: BTreeMap<&'static str, u64>,
    /// Of each frame; the expected squared error in a true covariance.
    pub(crate) unknowns: usize,
    /// Mean squared error of the frames in their covariance; `unknowns` where that is true.
    pub(crate) nees_mean: Option<f64>,
    /// Standard uncertainties have the name of what they belong to, and `_u`.
    pub(crate) nees_mean_u: Option<f64>,
    /// Part of the accepted whose 95 % region holds the truth.
    pub(crate) coverage_95: Option<f64>,
    /// Its standard uncertainty.
    pub(crate) coverage_95_u: Option<f64>,
    /// Errors over the least that is possible.
    pub(crate) rms_over_bound: OverBound,
    /// Their standard uncertainties.
    pub(crate) rms_over_bound_u: OverBound,
}

/// Root mean square errors over the Cramer-Rao bound with known dimensions and tip radius.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct OverBound {
    /// Of the translation.
    pub(crate) translation: Option<f64>,
    /// Of the rotation.
    pub(crate) rotation: Option<f64>,
}

impl OverBound {
    fn new(outcome: &StudyOutcome, number: fn(Estimate) -> f64) -> Self {
        let [translation, rotation] =
            outcome.rms_over_bound().map_or([None; 2], |both| both.map(|estimate| Some(number(estimate))));
        Self { translation, rotation }
    }
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let solver = self.solver.build(registry, &[])?;
        let setup = self.measurement.load(registry)?;
        let kind = self.layout.kind(&setup);
        let study = Study {
            fixture: &*setup.fixture,
            plugin: setup.measurement.plugin(registry)?,
            solver: &*solver,
            layout: self.touched(kind, &setup, &*solver)?,
            probe: setup.measurement.probe,
            reach: REACH_IN_SIZES * setup.fixture.size(),
            seed: self.seed,
            trials: self.trials,
        };
        let told = |error| failure(error, &setup);
        let sigma = study.sigma().map_err(told)?;
        let threads = self.threads.pool()?;
        let bar = progress(self.trials);
        let outcome = threads.install(|| study.run_with(&|| bar.inc(1)));
        drop(bar);
        let outcome = outcome.map_err(told)?;
        let record = StudyRecord::new(&study, kind, sigma, setup.measurement.units, &outcome);
        let output = Output::in_form(self.format, &record, &[], text::study);
        Ok(output.with_notes(setup.warnings().iter().map(|warning| format!("warning: {}", warning.message))))
    }

    /// Where the fixture is touched.
    fn touched(&self, kind: LayoutKind, setup: &Setup, solver: &dyn Solver) -> Result<StudyLayout, Failure> {
        Ok(match kind {
            LayoutKind::Nominal => StudyLayout::Fixed(setup.fixture.nominal_layout()),
            LayoutKind::Random => StudyLayout::Random(self.layout.counts(setup)?),
            LayoutKind::Measurement => {
                let problem = setup.problem()?;
                // A frame of which nobody knows how sure it is needs no looking for.
                problem.reference_sigma().ok_or_else(no_sigma)?;
                let frame = solve(setup, solver, None)?.frame;
                StudyLayout::Measured { touches: problem.touches().to_vec(), frame }
            }
        })
    }
}

fn failure(error: StudyError, setup: &Setup) -> Failure {
    let message = error.to_string();
    match error {
        StudyError::NoSigma => no_sigma().into(),
        StudyError::Touches(error) => InputError::from(error).into(),
        StudyError::Unsuitable(error) => setup.refused(error).into(),
        StudyError::Fixture { error, .. } => InputError::new("invalid-input", message)
            .with_key(format!("fixture.{}", error.name))
            .with_help("its stated uncertainty reaches beyond what the fixture can have: state a smaller one")
            .into(),
        _ => InputError::new("invalid-input", message).into(),
    }
}

impl StudyRecord {
    fn new(study: &Study<'_>, layout: LayoutKind, sigma: f64, units: Units, outcome: &StudyOutcome) -> Self {
        let (value, u) = (|estimate: Estimate| estimate.value, |estimate: Estimate| estimate.u);
        let (accepted, nees, coverage) =
            (outcome.accepted_share(), outcome.nees_mean(), outcome.coverage_95());
        let surfaces = study.fixture.surfaces().iter().map(|surface| surface.name.clone());
        Self {
            schema: SCHEMA,
            fixture: FixtureRecord::new(study.fixture.kind(), study.fixture.parameters()),
            units: units.name(),
            probe: ProbeRecord::from(&study.probe),
            solver: study.solver.name(),
            layout: layout.name(),
            touches_per_surface: surfaces
                .zip(study.touches_per_surface().into_iter().map(Into::into))
                .collect(),
            sigma,
            seed: study.seed,
            trials: outcome.trials,
            accepted: outcome.accepted,
            accepted_rate: accepted.map(|share| share.value),
            accepted_rate_95: accepted.map(|share| [share.low, share.high]),
            wrong: outcome.wrong,
            wrong_rate_at_most: outcome.wrong_at_most(),
            refused: outcome.refused.clone(),
            unknowns: 6 - study.fixture.freedom().count(),
            nees_mean: nees.map(value),
            nees_mean_u: nees.map(u),
            coverage_95: coverage.map(value),
            coverage_95_u: coverage.map(u),
            rms_over_bound: OverBound::new(outcome, value),
            rms_over_bound_u: OverBound::new(outcome, u),
        }
    }
}
