//! How far touches check each other: which error of one would be noticed, what it does to the frame when it is not, and for
//! which other it would be taken.
//!
//! W. Baarda, A testing procedure for use in geodetic networks (1968). With the redundancy matrix `Q` of the
//! [linear model](crate::linear), an error of `d` standard deviations in observation `i` makes its test value
//! `w_i = v_i / sqrt(Q_ii)`, standard normal for sound observations, `d sqrt(Q_ii)` on average. It is noticed with the
//! wanted power when that is `delta_0`, the critical value and the power's own quantile. The test value of another
//! observation `j` then is `rho_ij delta_0`, with `rho_ij = Q_ij / sqrt(Q_ii Q_jj)`; where `rho` is one, no test tells the
//! two apart.

use nalgebra::Vector6;
use statrs::distribution::{ContinuousCDF, Normal};
use thiserror::Error;
use touchref_core::{Frame, Problem, statistics::normal_quantile};

use crate::linear::{Linear, Observation};

/// Redundancy below which an observation is checked by nothing but rounding.
const UNCHECKED: f64 = 1e-9;
/// Two test values whose correlation is this near to one are one: what rounding leaves of the redundancy matrix.
const ALIKE: f64 = 1e-6;
/// Chance of being taken for another from which on that other is told.
const CONFUSED: f64 = 0.05;

/// Why there is no reliability.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ReliabilityError {
    /// The touches leave a motion free.
    #[error("the touches leave a motion free")]
    Degenerate,
    /// No sigma is stated, so that no error is large or small.
    #[error("no sigma is stated, and without one no error is large or small")]
    NoSigma,
}

/// The test of one observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Test {
    /// Chance at which a sound observation is called bad, in `(0, 1)`.
    pub alpha: f64,
    /// Chance at which an error of the smallest detectable size is noticed, in `(0, 1)`.
    pub power: f64,
}

impl Default for Test {
    /// As is the custom in geodesy: 0.001 and 0.80.
    fn default() -> Self {
        Self { alpha: 0.001, power: 0.80 }
    }
}

impl Test {
    /// A test value beyond this, of either sign, calls an observation bad.
    #[must_use]
    pub fn critical_value(&self) -> f64 {
        normal_quantile(1.0 - 0.5 * self.alpha)
    }

    /// The mean test value of an observation whose error is noticed with the wanted power: `delta_0`.
    #[must_use]
    pub fn noncentrality(&self) -> f64 {
        self.critical_value() + normal_quantile(self.power)
    }
}

/// How far the observations of a measurement check each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Reliability {
    /// The test.
    pub test: Test,
    /// The touches in input order, then what is stated of uncertain sizes and of the tip.
    pub observations: Vec<Checked>,
}

/// How far the others check one observation.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// Which one.
    pub observation: Observation,
    /// Its standard deviation: a length, or radians.
    pub sigma: f64,
    /// Its redundancy number, from 0 (unchecked) to 1.
    pub redundancy: f64,
    /// What there is to say of it, if it is checked at all.
    pub check: Option<Check>,
    /// How the frame moves with its error, per unit of that: `x y z rx ry rz` along the parent's axes about the origin.
    pub influence: Vector6<f64>,
}

/// The check of one observation by the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Its test value: the residual over that residual's own standard deviation.
    pub test_value: f64,
    /// The smallest error that is noticed with the test's power; in the unit of its sigma.
    pub smallest_detectable: f64,
    /// What its error seems to be, if it alone has one.
    pub apparent_error: f64,
    /// Observations for which an error of the smallest detectable size may be taken, likeliest first.
    pub confusions: Vec<Confusion>,
}

/// An observation that may be called bad in the place of another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Confusion {
    /// Which one, by its place among the observations.
    pub with: usize,
    /// Chance that its test value is the larger one.
    pub chance: f64,
    /// Whether no test can ever tell the two apart.
    pub always: bool,
}

impl Checked {
    /// How the frame moves with an error of the smallest detectable size, which goes unnoticed as often as the test's
    /// power leaves; `None` where an error of any size does.
    #[must_use]
    pub fn undetected_shift(&self) -> Option<Vector6<f64>> {
        self.check.as_ref().map(|check| self.influence * check.smallest_detectable)
    }

    /// How the frame moves when this observation is left out; `None` where nothing else tells what it tells.
    #[must_use]
    pub fn shift_without(&self) -> Option<Vector6<f64>> {
        self.check.as_ref().map(|check| self.influence * -check.apparent_error)
    }
}

impl Reliability {
    /// Of a measurement at its maximum-likelihood `frame`.
    ///
    /// # Errors
    /// [`ReliabilityError`].
    pub fn of(problem: &Problem<'_>, frame: &Frame, test: Test) -> Result<Self, ReliabilityError> {
        if problem.reference_sigma().is_none() {
            return Err(ReliabilityError::NoSigma);
        }
        let linear = Linear::at(problem, frame).ok_or(ReliabilityError::Degenerate)?;
        let checked = linear.observations().iter().enumerate();
        let observations = checked.map(|(index, &observation)| {
            let sigma = linear.sigmas()[index];
            Checked {
                observation,
                sigma,
                redundancy: linear.redundancy()[(index, index)].clamp(0.0, 1.0),
                check: check(&linear, index, test),
                influence: linear.sensitivity(index) / sigma,
            }
        });
        Ok(Self { test, observations: observations.collect() })
    }
}

fn check(linear: &Linear, index: usize, test: Test) -> Option<Check> {
    let q = linear.redundancy();
    let redundancy = q[(index, index)];
    if redundancy < UNCHECKED {
        return None;
    }
    let noncentrality = test.noncentrality();
    let others =
        (0..linear.observations().len()).filter(|other| *other != index && q[(*other, *other)] >= UNCHECKED);
    let confusion = |with: usize| {
        let correlation = (q[(index, with)] / (redundancy * q[(with, with)]).sqrt()).abs();
        let always = correlation > 1.0 - ALIKE;
        Confusion { with, chance: if always { 0.5 } else { confused(noncentrality, correlation) }, always }
    };
    let mut confusions: Vec<Confusion> =
        others.map(confusion).filter(|told| told.chance > CONFUSED).collect();
    confusions.sort_by(|a, b| b.chance.total_cmp(&a.chance));
    let sigma = linear.sigmas()[index];
    let residual = linear.residuals()[index];
    Some(Check {
        test_value: residual / redundancy.sqrt(),
        smallest_detectable: noncentrality / redundancy.sqrt() * sigma,
        apparent_error: residual / redundancy * sigma,
        confusions,
    })
}

/// Chance that of two test values the other is the larger: one has the mean `noncentrality`, the other so much of that as
/// they are correlated.
///
/// Sum and difference of the two are independent, and the other one is larger just when their signs differ.
fn confused(noncentrality: f64, correlation: f64) -> f64 {
    let normal = Normal::standard();
    let [difference, sum] =
        [1.0 - correlation, 1.0 + correlation].map(|part| noncentrality * (0.5 * part).sqrt());
    normal.sf(difference) * normal.cdf(sum) + normal.cdf(difference) * normal.sf(sum)
}
