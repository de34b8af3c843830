//! How sure a frame is where it is used, and where that comes from: to first order, and by [draws](Draws) of all that is
//! uncertain.
//!
//! Touches err by their own noise; tip radius and sizes of the fixture err in all touches at once. Both are errors of
//! [observations](crate::linear) that are independent of each other, so variances add up: what each source contributes is
//! told, and the shares sum to one.
//!
//! Where no sigma is stated the residuals tell it, with few degrees of freedom: the coverage factor is then that of
//! Student's distribution (GUM G.3). All variances are in proportion to it, so that this is exact.

mod draws;

use nalgebra::{Matrix3, Matrix3x6, Matrix6, Point3, Vector3};
use thiserror::Error;
use touchref_core::{Frame, Problem, SigmaSource, Unknown, statistics::student_factor};

pub use self::draws::{Draws, Estimator};
use crate::linear::{Linear, Observation, lever};

/// Why no uncertainty can be stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum UncertaintyError {
    /// The touches leave a motion free.
    #[error("the touches leave a motion free")]
    Degenerate,
    /// No sigma is stated, and no touch is left to tell it.
    #[error("no sigma is stated, and no touch beyond the unknowns tells it")]
    NoSigma,
}

/// Uncertainty of a frame, to first order.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    linear: Linear,
    /// By which variances of touches are multiplied: 1 where a sigma is stated.
    variance: f64,
    degrees_of_freedom: Option<usize>,
    /// Where each observation's error comes from.
    sources: Vec<Source>,
}

/// Where errors come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Noise of the touches on a surface, by its index.
    Touches(usize),
    /// What is stated of a size or of the tip: common to all touches.
    Stated(Unknown),
}

/// What a source contributes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contribution {
    /// The source.
    pub source: Source,
    /// Its part of the covariance: all parts sum to the whole.
    pub spread: Spread,
}

/// Covariance of three numbers along the parent's axes: of a point's place, or of a small turn (radians).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread(pub Matrix3<f64>);

impl Spread {
    /// Standard uncertainty along a direction of unit length.
    #[must_use]
    pub fn along(&self, direction: &Vector3<f64>) -> f64 {
        direction.dot(&(self.0 * direction)).max(0.0).sqrt()
    }

    /// Standard uncertainties along the parent's axes.
    #[must_use]
    pub fn along_axes(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.0[(k, k)].max(0.0).sqrt())
    }

    /// The largest standard uncertainty, and the direction it has.
    #[must_use]
    pub fn worst(&self) -> (f64, Vector3<f64>) {
        let eigen = self.0.symmetric_eigen();
        let worst = eigen.eigenvalues.imax();
        (eigen.eigenvalues[worst].max(0.0).sqrt(), eigen.eigenvectors.column(worst).into_owned())
    }
}

impl Uncertainty {
    /// Of the maximum-likelihood `frame` of a measurement.
    ///
    /// # Errors
    /// [`UncertaintyError`], where there is none to state.
    pub fn of(problem: &Problem<'_>, frame: &Frame) -> Result<Self, UncertaintyError> {
        let linear = Linear::at(problem, frame).ok_or(UncertaintyError::Degenerate)?;
        let (variance, degrees_of_freedom) = if problem.reference_sigma().is_some() {
            (1.0, None)
        } else {
            let spare = problem.touches().len().saturating_sub(problem.unknowns());
            if spare == 0 {
                return Err(UncertaintyError::NoSigma);
            }
            (linear.residuals().norm_squared() / spare as f64, Some(spare))
        };
        let source = |observation: &Observation| match *observation {
            Observation::Touch(index) => Source::Touches(problem.touches()[index].surface),
            Observation::Stated(unknown) => Source::Stated(unknown),
        };
        let sources = linear.observations().iter().map(source).collect();
        Ok(Self { linear, variance, degrees_of_freedom, sources })
    }

    /// The frame.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        self.linear.frame()
    }

    /// Covariance of the frame: `x y z rx ry rz` along the parent's axes about its origin.
    #[must_use]
    pub fn covariance(&self) -> Matrix6<f64> {
        self.linear.covariance() * self.variance
    }

    /// Degrees of freedom of the standard uncertainties; `None` where they are as sure as what is stated.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> Option<usize> {
        self.degrees_of_freedom
    }

    /// Standard deviation of a touch as the residuals tell it, where no sigma is stated; else 1.
    #[must_use]
    pub fn sigma_of_residuals(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Where the sigma of the touches comes from.
    #[must_use]
    pub fn sigma_source(&self) -> SigmaSource {
        if self.degrees_of_freedom.is_some() { SigmaSource::Residuals } else { SigmaSource::Given }
    }

    /// By which a standard uncertainty is multiplied for an interval that covers with this probability, in `(0, 1)`.
    #[must_use]
    pub fn coverage_factor(&self, probability: f64) -> f64 {
        let degrees = self.degrees_of_freedom.map_or(f64::INFINITY, |degrees| degrees as f64);
        student_factor(probability, degrees)
    }

    /// Uncertainty of the place of a point that moves with the fixture, in fixture coordinates.
    #[must_use]
    pub fn of_point(&self, point: &Point3<f64>) -> Spread {
        self.seen_through(&lever(self.frame(), point))
    }

    /// Uncertainty of the frame's rotation, as a rotation vector.
    #[must_use]
    pub fn of_turn(&self) -> Spread {
        self.seen_through(&turn())
    }

    /// What each source contributes to the uncertainty of a point: surfaces that are touched in the fixture's order, then
    /// sizes, then the tip.
    #[must_use]
    pub fn budget_of_point(&self, point: &Point3<f64>) -> Vec<Contribution> {
        self.budget(&lever(self.frame(), point))
    }

    /// What each source contributes to the uncertainty of the rotation.
    #[must_use]
    pub fn budget_of_turn(&self) -> Vec<Contribution> {
        self.budget(&turn())
    }

    fn seen_through(&self, lever: &Matrix3x6<f64>) -> Spread {
        Spread(lever * self.covariance() * lever.transpose())
    }

    fn budget(&self, lever: &Matrix3x6<f64>) -> Vec<Contribution> {
        let mut budget: Vec<Contribution> = Vec::new();
        for (index, &source) in self.sources.iter().enumerate() {
            let moved = lever * self.linear.sensitivity(index);
            let part = moved * moved.transpose() * self.variance;
            match budget.iter_mut().find(|known| known.source == source) {
                Some(known) => known.spread.0 += part,
                None => budget.push(Contribution { source, spread: Spread(part) }),
            }
        }
        budget.sort_by_key(|contribution| match contribution.source {
            Source::Touches(surface) => (0, surface),
            Source::Stated(Unknown::Dimension(index)) => (1, index),
            Source::Stated(Unknown::TipRadius) => (2, 0),
        });
        budget
    }
}

/// The rotation of a frame, of its six motions.
fn turn() -> Matrix3x6<f64> {
    let mut turn = Matrix3x6::zeros();
    turn.fixed_columns_mut::<3>(3).copy_from(&Matrix3::identity());
    turn
}

impl Source {
    /// What it is, in words.
    #[must_use]
    pub fn in_words(&self, problem: &Problem<'_>) -> String {
        match self {
            Self::Touches(surface) => format!("touches on `{}`", problem.fixture().surfaces()[*surface].name),
            Self::Stated(unknown) => unknown.stated(problem.fixture(), problem.probe()).name.into_owned(),
        }
    }
}
