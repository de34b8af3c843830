//! How often is a frame right, refused, or wrong? Simulated measurements, solved and held against the truth.
//!
//! The truth differs from what the solver is told by all that is stated as uncertain: each trial draws the noise of the
//! touches, the uncertain parameters of the fixture and the tip radius anew.

use std::{collections::BTreeMap, sync::LazyLock};

use nalgebra::Matrix6;
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use rayon::prelude::*;
use thiserror::Error;
use touchref_core::{
    Fixture, FixturePlugin, Frame, ParameterError, Parameters, Probe, Problem, SolveError, Solver, Touch,
    TouchError, Value, statistics::chi_square_level,
};

use crate::{
    estimate::{Estimate, Ratio, Share, rate_at_most},
    simulation::{Layout, check_surfaces, generator, random_frame, random_layout, reading, turned},
};

/// Chance at which an accepted frame counts as wrong: its true error lies outside its own stated covariance.
pub const WRONG_LEVEL: f64 = 1e-9;

/// Squared errors of a frame, in its own covariance, that a true covariance exceeds with the chance of a wrong one and
/// with 5 %; by the number of the frame's unknowns.
static LEVELS: LazyLock<[[f64; 2]; 7]> = LazyLock::new(|| {
    std::array::from_fn(|unknowns| {
        [WRONG_LEVEL, 0.05].map(|chance| chi_square_level(chance, unknowns.max(1)))
    })
});

/// Trials that one thread works through before it takes the next; results do not depend on it, nor on the threads.
const CHUNK: u64 = 256;
/// Chunks whose outcomes wait at once to be added up.
const BLOCK: u64 = 256;

/// Where a study touches the fixture.
#[derive(Debug, Clone, PartialEq)]
pub enum StudyLayout {
    /// The same contact points in every trial (fixture coordinates).
    Fixed(Layout),
    /// So many touches on each surface, uniform over its reachable part, anew in every trial.
    Random(Vec<usize>),
    /// The touches of a measurement again in every trial, as they met the fixture where it stood: contact points,
    /// approach, and noise where a touch states its own.
    Measured {
        /// The touches as measured, in the parent.
        touches: Vec<Touch>,
        /// Where the fixture stood.
        frame: Frame,
    },
}

/// A series of simulated measurements, each at a frame of its own.
#[derive(Debug)]
pub struct Study<'a> {
    /// The fixture as the solver knows it.
    pub fixture: &'a dyn Fixture,
    /// Its plugin, which builds the fixture as it truly is in a trial: uncertain parameters differ from the known ones
    /// by normal errors of their standard uncertainties.
    pub plugin: &'a FixturePlugin,
    /// The solver.
    pub solver: &'a dyn Solver,
    /// Where it is touched.
    pub layout: StudyLayout,
    /// What the solver is told of the probe. Its sigma is that of the simulated noise; the true tip radius differs by a
    /// normal error of its standard uncertainty.
    pub probe: Probe,
    /// Frames lie within this distance of the parent's origin along each axis. Results do not depend on it, short of
    /// rounding.
    pub reach: f64,
    /// The same seed gives the same study, whatever the number of threads.
    pub seed: u64,
    /// How many measurements.
    pub trials: u64,
}

/// Why there is no study.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// Neither the probe nor the touches state a sigma.
    #[error("no sigma is stated, so there is no noise to simulate")]
    NoSigma,
    /// The probe's numbers, or the touches, do not make a problem.
    #[error(transparent)]
    Touches(#[from] TouchError),
    /// An uncertain parameter, drawn, is none that the fixture can have.
    #[error("the true fixture of trial {trial} cannot be built: {error}")]
    Fixture {
        /// Which trial, from 0.
        trial: u64,
        /// What is wrong with the parameter.
        error: ParameterError,
    },
    /// The solver cannot do this in any trial: too few touches, or a fixture that is none for it.
    #[error(transparent)]
    Unsuitable(SolveError),
}

/// What came of a study.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StudyOutcome {
    /// How many measurements were made.
    pub trials: u64,
    /// Frames handed out.
    pub accepted: u64,
    /// Frames handed out whose true error lies outside their own stated covariance at [`WRONG_LEVEL`].
    pub wrong: u64,
    /// Refusals by code.
    pub refused: BTreeMap<&'static str, u64>,
    /// Largest squared error of an accepted frame, in its own covariance.
    pub worst: f64,
    /// Sum of the squared errors of the accepted frames.
    nees: f64,
    /// Accepted frames within their own 95 % region.
    within_95: u64,
    /// Squared errors over the Cramer-Rao bound: translation and rotation.
    over_bound: [Ratio; 2],
}

impl StudyOutcome {
    /// Mean squared error of the accepted frames in their own covariance: 6 when that is true. `None` where none was
    /// accepted.
    #[must_use]
    pub fn nees_mean(&self) -> Option<Estimate> {
        /// Variance of a chi-square variable with six degrees of freedom.
        const VARIANCE: f64 = 12.0;
        let accepted = self.accepted as f64;
        (self.accepted > 0).then(|| Estimate { value: self.nees / accepted, u: (VARIANCE / accepted).sqrt() })
    }

    /// Part of the accepted frames within their own 95 % region. `None` where none was accepted.
    #[must_use]
    pub fn coverage_95(&self) -> Option<Estimate> {
        let accepted = self.accepted as f64;
        (self.accepted > 0)
            .then(|| Estimate { value: self.within_95 as f64 / accepted, u: (0.05 * 0.95 / accepted).sqrt() })
    }

    /// Root mean square error of the accepted frames over the Cramer-Rao bound: translation of the origin, and
    /// rotation. `None` where fewer than two were accepted.
    ///
    /// The bound is that with known geometry: 1 for an efficient solver, more where dimensions or the tip radius are
    /// uncertain, or where a solver does not use what is known of them.
    #[must_use]
    pub fn rms_over_bound(&self) -> Option<[Estimate; 2]> {
        let [translation, rotation] = self.over_bound.map(|ratio| ratio.root());
        Some([translation?, rotation?])
    }

    /// Part of all measurements of which a frame was handed out.
    #[must_use]
    pub fn accepted_share(&self) -> Option<Share> {
        Share::of(self.accepted, self.trials)
    }

    /// The part of accepted frames that are wrong is below this, with 95 % confidence: "rule of three", where none
    /// was. `None` where none was accepted.
    #[must_use]
    pub fn wrong_at_most(&self) -> Option<f64> {
        rate_at_most(self.wrong, self.accepted)
    }

    fn add(&mut self, other: Self) {
        self.trials += other.trials;
        self.accepted += other.accepted;
        self.wrong += other.wrong;
        self.worst = self.worst.max(other.worst);
        self.nees += other.nees;
        self.within_95 += other.within_95;
        for (sum, part) in self.over_bound.iter_mut().zip(other.over_bound) {
            *sum += part;
        }
        for (code, count) in other.refused {
            *self.refused.entry(code).or_default() += count;
        }
    }
}

impl Study<'_> {
    /// Standard deviation of one touch: the probe's, or the root mean square where measured touches state their own.
    ///
    /// # Errors
    /// [`StudyError::NoSigma`]; [`StudyError::Touches`] when measured touches do not make a problem.
    pub fn sigma(&self) -> Result<f64, StudyError> {
        let sigma = match &self.layout {
            StudyLayout::Fixed(_) | StudyLayout::Random(_) => self.probe.sigma,
            StudyLayout::Measured { touches, .. } => {
                Problem::new(self.fixture, touches, self.probe)?.reference_sigma()
            }
        };
        sigma.ok_or(StudyError::NoSigma)
    }

    /// How many touches each surface gets, in the fixture's order.
    #[must_use]
    pub fn touches_per_surface(&self) -> Vec<usize> {
        let touched: Vec<usize> = match &self.layout {
            StudyLayout::Fixed(layout) => layout.iter().map(|(surface, _)| *surface).collect(),
            StudyLayout::Random(counts) => return counts.clone(),
            StudyLayout::Measured { touches, .. } => touches.iter().map(|touch| touch.surface).collect(),
        };
        let surfaces = 0..self.fixture.surfaces().len();
        surfaces.map(|surface| touched.iter().filter(|of| **of == surface).count()).collect()
    }

    /// Makes all measurements, on all threads.
    ///
    /// # Errors
    /// The first [`StudyError`].
    pub fn run(&self) -> Result<StudyOutcome, StudyError> {
        self.run_with(&|| ())
    }

    /// The same; calls `progress` after every measurement, from any thread.
    ///
    /// # Errors
    /// The first [`StudyError`].
    pub fn run_with(&self, progress: &(dyn Fn() + Sync)) -> Result<StudyOutcome, StudyError> {
        self.sigma()?;
        let mut all = StudyOutcome::default();
        let mut first = 0;
        while first < self.trials {
            let last = self.trials.min(first.saturating_add(BLOCK * CHUNK));
            let chunks = (last - first).div_ceil(CHUNK);
            let outcomes: Vec<Result<StudyOutcome, StudyError>> = (0..chunks)
                .into_par_iter()
                .map(|chunk| {
                    let start = first + chunk * CHUNK;
                    let mut outcome = StudyOutcome::default();
                    for trial in start..last.min(start.saturating_add(CHUNK)) {
                        self.one(trial, &mut outcome)?;
                        progress();
                    }
                    Ok(outcome)
                })
                .collect();
            // In the order of the trials: sums of floating point numbers depend on it.
            for outcome in outcomes {
                all.add(outcome?);
            }
            first = last;
        }
        Ok(all)
    }

    /// The touches of one trial, and the true frame.
    ///
    /// # Errors
    /// [`StudyError::Fixture`], where an uncertain parameter was drawn out of its range; [`StudyError::Touches`], where the
    /// layout touches a surface that the fixture does not have.
    pub fn measurement(&self, trial: u64) -> Result<(Vec<Touch>, Frame), StudyError> {
        let mut rng = generator(self.seed, trial);
        let drawn = self.true_fixture(trial, &mut rng)?;
        let fixture = drawn.as_deref().unwrap_or(self.fixture);
        let tip_radius = drawn_from(self.probe.tip_radius, self.probe.tip_radius_u, &mut rng);
        let at_contacts = |layout: &Layout| {
            layout.iter().map(|(surface, contact)| Touch::new(*surface, *contact)).collect::<Vec<_>>()
        };
        let planned = match &self.layout {
            StudyLayout::Fixed(layout) => at_contacts(layout),
            StudyLayout::Random(counts) => at_contacts(&random_layout(fixture, counts, &mut rng)),
            StudyLayout::Measured { touches, frame } => {
                let to_fixture = frame.rotation.inverse();
                let planned = |touch: &Touch| turned(touch, frame.to_fixture(&touch.at), &to_fixture);
                touches.iter().map(planned).collect()
            }
        };
        check_surfaces(fixture, planned.iter().map(|touch| touch.surface))?;
        let truth = random_frame(self.reach, &mut rng);
        let sigma = self.probe.sigma.unwrap_or(0.0);
        let read = |touch: &Touch| reading(fixture, touch, &truth, tip_radius, sigma, &mut rng);
        Ok((planned.iter().map(read).collect(), truth))
    }

    /// The fixture as it truly is in a trial; `None` where it is what it is known to be.
    fn true_fixture(&self, trial: u64, rng: &mut impl Rng) -> Result<Option<Box<dyn Fixture>>, StudyError> {
        let known = self.fixture.parameters();
        let drawn = drawn_parameters(known, Drawn::Exact, rng);
        if drawn == *known {
            return Ok(None);
        }
        self.plugin.build(&drawn).map(Some).map_err(|error| StudyError::Fixture { trial, error })
    }

    fn one(&self, trial: u64, outcome: &mut StudyOutcome) -> Result<(), StudyError> {
        let (touches, truth) = self.measurement(trial)?;
        let problem = Problem::new(self.fixture, &touches, self.probe)?;
        outcome.trials += 1;
        let solution = match self.solver.solve(&problem) {
            Ok(solution) => solution,
            // These do not depend on the draw: there is nothing to count.
            Err(error @ (SolveError::TooFewTouches { .. } | SolveError::Unsupported { .. })) => {
                return Err(StudyError::Unsuitable(error));
            }
            Err(refusal) => {
                *outcome.refused.entry(refusal.code()).or_default() += 1;
                return Ok(());
            }
        };
        // A frame without a covariance, or that is no number, is as wrong as one can be.
        let squared = solution.squared_distance(&truth).filter(|v| v.is_finite()).unwrap_or(f64::INFINITY);
        outcome.accepted += 1;
        let [wrong, region_95] = LEVELS[problem.unknowns()];
        outcome.wrong += u64::from(squared > wrong);
        outcome.within_95 += u64::from(squared <= region_95);
        outcome.worst = outcome.worst.max(squared);
        outcome.nees += squared;
        if let Some(bound) = cramer_rao(&problem, &truth) {
            let freedom = self.fixture.freedom();
            let wanted = freedom.nearest(&truth, &solution.frame);
            let error = freedom.without(&solution.frame.twist_to(&wanted).into());
            for (ratio, rows) in outcome.over_bound.iter_mut().zip([0..3, 3..6]) {
                let squared_error = rows.clone().map(|k| error[k] * error[k]).sum();
                ratio.add(squared_error, rows.map(|k| bound[(k, k)]).sum());
            }
        }
        Ok(())
    }
}

/// A true value that is known as `value` with the standard uncertainty `u`.
pub(crate) fn drawn_from(value: f64, u: f64, rng: &mut impl Rng) -> f64 {
    // What is exact takes no number from the generator.
    if u > 0.0 { value + u * rng.sample::<f64, _>(StandardNormal) } else { value }
}

/// How sure drawn parameters are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Drawn {
    /// They are the true ones.
    Exact,
    /// They could have been stated in the place of the known ones, as uncertain as these.
    AsStated,
}

/// Parameters as they may be: each uncertain number drawn, those in tables, too.
pub(crate) fn drawn_parameters(known: &Parameters, drawn_as: Drawn, rng: &mut impl Rng) -> Parameters {
    known.iter().fold(Parameters::new(), |drawn, (name, value)| match value {
        Value::Number { value, u } if *u > 0.0 => {
            let value = drawn_from(*value, *u, rng);
            let u = if drawn_as == Drawn::Exact { 0.0 } else { *u };
            drawn.with(name, Value::Number { value, u })
        }
        Value::Tables(tables) => {
            let of_table = |table| drawn_parameters(table, drawn_as, rng);
            let tables: Vec<Parameters> = tables.iter().map(of_table).collect();
            drawn.with(name, tables)
        }
        other => drawn.with(name, other.clone()),
    })
}

/// The least covariance that any unbiased estimate of the frame can have, its dimensions and the tip radius known;
/// along the fixture's axes, about its origin, and zero along what the fixture leaves free. `None` for a layout that leaves
/// another motion free.
fn cramer_rao(problem: &Problem<'_>, truth: &Frame) -> Option<Matrix6<f64>> {
    let freedom = problem.fixture().freedom();
    // What is free has nothing to do with the rest.
    let held = |k: usize| f64::from(u8::from(freedom.is_free(k)));
    let held = Matrix6::from_fn(|i, j| if i == j { held(i) } else { 0.0 });
    let mut information = held;
    for index in 0..problem.touches().len() {
        let contact = problem.contact(truth, index);
        let row = freedom.without(&contact.gradient().into()).transpose() / contact.sigma;
        information += row.transpose() * row;
    }
    information.cholesky().map(|cholesky| cholesky.inverse() - held)
}
