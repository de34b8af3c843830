//! What many placements of one fixture tell of its sizes and of the probe.

use nalgebra::DMatrix;

use crate::{Adjustment, Covariance, Frame, Iteration, Residual, SigmaSource};

/// Parameters shared by many placements of one fixture, and the frame of each placement.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The shared parameters, in the order in which they were asked for.
    pub parameters: Vec<Adjustment>,
    /// Their covariance, in that order; lengths and degrees, as their values.
    pub covariance: DMatrix<f64>,
    /// The placements, in input order.
    pub placements: Vec<Placement>,
    /// Standard deviation of one touch: the root mean square of the stated ones, or that of the residuals.
    pub sigma: f64,
    /// Where that came from.
    pub sigma_source: SigmaSource,
    /// Root mean square of all residuals.
    pub rms: f64,
    /// Squared misfit of all touches and of the stated nominal values; `None` where no sigma is stated.
    pub chi_square: Option<f64>,
    /// Touches and stated nominal values less unknowns.
    pub degrees_of_freedom: usize,
    /// Chance of a larger [`chi_square`](Self::chi_square); `None` without one or without degrees of freedom.
    pub p_value: Option<f64>,
    /// How the iteration ended.
    pub iteration: Iteration,
}

impl Calibration {
    /// Correlations of the parameters: their covariance over the product of their uncertainties.
    #[must_use]
    pub fn correlations(&self) -> DMatrix<f64> {
        let u = |i: usize| self.covariance[(i, i)].sqrt();
        self.covariance.map_with_location(|i, j, covariance| covariance / (u(i) * u(j)))
    }
}

/// One placement of the fixture.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Its frame in the parent.
    pub frame: Frame,
    /// Covariance of that, the uncertainty of the shared parameters included.
    pub covariance: Covariance,
    /// Squared misfit of its touches; `None` where no sigma is stated.
    pub chi_square: Option<f64>,
    /// Per touch, in input order.
    pub residuals: Vec<Residual>,
}
