//! How often is a frame right, refused, or wrong? Simulated measurements, solved and held against the truth.

use std::collections::BTreeMap;

use nalgebra::{Matrix6, RowVector6};
use rayon::prelude::*;
use touchref_core::{Fixture, Frame, Probe, Problem, Solver, TouchError, statistics::chi_square_level};

use crate::simulation::{Layout, generator, random_frame, random_layout, simulate};

/// Chance at which an accepted frame counts as wrong: its true error lies outside its own stated covariance.
pub const WRONG_LEVEL: f64 = 1e-9;

/// Trials that one thread works through before it takes the next; results do not depend on it, nor on the threads.
const CHUNK: u64 = 256;

/// Where a study touches the fixture.
#[derive(Debug, Clone, PartialEq)]
pub enum StudyLayout {
    /// The same contact points in every trial (fixture coordinates).
    Fixed(Layout),
    /// So many touches on each surface, uniform over its reachable part, anew in every trial.
    Random(Vec<usize>),
}

/// A series of simulated measurements, each at a frame of its own.
#[derive(Debug)]
pub struct Study<'a> {
    /// The fixture.
    pub fixture: &'a dyn Fixture,
    /// The solver.
    pub solver: &'a dyn Solver,
    /// Where it is touched.
    pub layout: StudyLayout,
    /// What the solver is told of the probe; its sigma is that of the simulated noise.
    pub probe: Probe,
    /// Frames lie within this distance of the parent's origin along each axis.
    pub reach: f64,
    /// The same seed gives the same study, whatever the number of threads.
    pub seed: u64,
    /// How many measurements.
    pub trials: u64,
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
    /// Sums of squares: translation and rotation errors, and what the Cramer-Rao bound predicts for them.
    errors: [f64; 2],
    bounds: [f64; 2],
}

impl StudyOutcome {
    /// Mean squared error of the accepted frames in their own covariance: 6 when it is true.
    #[must_use]
    pub fn nees_mean(&self) -> f64 {
        self.nees / self.accepted as f64
    }

    /// Part of the accepted frames within their own 95 % region.
    #[must_use]
    pub fn coverage_95(&self) -> f64 {
        self.within_95 as f64 / self.accepted as f64
    }

    /// Root mean square error of the accepted frames over the Cramer-Rao bound with known geometry: translation of the
    /// origin, and rotation.
    #[must_use]
    pub fn rms_over_bound(&self) -> [f64; 2] {
        [0, 1].map(|i| (self.errors[i] / self.bounds[i]).sqrt())
    }

    fn add(&mut self, other: Self) {
        self.trials += other.trials;
        self.accepted += other.accepted;
        self.wrong += other.wrong;
        self.worst = self.worst.max(other.worst);
        self.nees += other.nees;
        self.within_95 += other.within_95;
        for i in 0..2 {
            self.errors[i] += other.errors[i];
            self.bounds[i] += other.bounds[i];
        }
        for (code, count) in other.refused {
            *self.refused.entry(code).or_default() += count;
        }
    }
}

impl Study<'_> {
    /// Makes all measurements, on all threads.
    ///
    /// # Errors
    /// [`TouchError`] when the probe's numbers, or the layout, do not make a problem.
    pub fn run(&self) -> Result<StudyOutcome, TouchError> {
        let chunks: Vec<u64> = (0..self.trials).step_by(usize::try_from(CHUNK).unwrap_or(1)).collect();
        let outcomes: Vec<Result<StudyOutcome, TouchError>> = chunks
            .into_par_iter()
            .map(|first| {
                let mut outcome = StudyOutcome::default();
                for trial in first..(first + CHUNK).min(self.trials) {
                    self.one(trial, &mut outcome)?;
                }
                Ok(outcome)
            })
            .collect();
        // In the order of the trials: sums of floating point numbers depend on it.
        let mut all = StudyOutcome::default();
        for outcome in outcomes {
            all.add(outcome?);
        }
        Ok(all)
    }

    /// The touches of one trial, and the true frame.
    #[must_use]
    pub fn measurement(&self, trial: u64) -> (Vec<touchref_core::Touch>, Frame) {
        let mut rng = generator(self.seed, trial);
        let random;
        let layout = match &self.layout {
            StudyLayout::Fixed(layout) => layout,
            StudyLayout::Random(counts) => {
                random = random_layout(self.fixture, counts, &mut rng);
                &random
            }
        };
        let truth = random_frame(self.reach, &mut rng);
        let sigma = self.probe.sigma.unwrap_or(0.0);
        (simulate(self.fixture, layout, &truth, &self.probe, sigma, &mut rng), truth)
    }

    fn one(&self, trial: u64, outcome: &mut StudyOutcome) -> Result<(), TouchError> {
        let (touches, truth) = self.measurement(trial);
        let problem = Problem::new(self.fixture, &touches, self.probe)?;
        outcome.trials += 1;
        let solution = match self.solver.solve(&problem) {
            Ok(solution) => solution,
            Err(refusal) => {
                *outcome.refused.entry(refusal.code()).or_default() += 1;
                return Ok(());
            }
        };
        let error = solution.frame.error_to(&truth);
        let squared = solution.squared_distance(&truth).unwrap_or(f64::INFINITY);
        outcome.accepted += 1;
        outcome.wrong += u64::from(squared > chi_square_level(WRONG_LEVEL, 6));
        outcome.within_95 += u64::from(squared <= chi_square_level(0.05, 6));
        outcome.worst = outcome.worst.max(squared);
        outcome.nees += squared;
        if let Some(bound) = cramer_rao(&problem, &truth) {
            for (i, rows) in [0..3, 3..6].into_iter().enumerate() {
                outcome.errors[i] += rows.clone().map(|k| error[k] * error[k]).sum::<f64>();
                outcome.bounds[i] += rows.map(|k| bound[(k, k)]).sum::<f64>();
            }
        }
        Ok(())
    }
}

/// The least covariance that any unbiased estimate of the frame can have, its dimensions known; along the fixture's
/// axes, about its origin. `None` for a layout that leaves a motion free.
fn cramer_rao(problem: &Problem<'_>, truth: &Frame) -> Option<Matrix6<f64>> {
    let mut information = Matrix6::zeros();
    for index in 0..problem.touches().len() {
        let contact = problem.contact(truth, index);
        let row = RowVector6::from_row_slice(&contact.gradient()) / contact.sigma;
        information += row.transpose() * row;
    }
    information.cholesky().map(|cholesky| cholesky.inverse())
}
