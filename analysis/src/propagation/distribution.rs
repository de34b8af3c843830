//! What is known of input quantities: the distributions of JCGM 101:2008, clause 6.4.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use rand::{Rng, RngExt};
use rand_distr::{StandardNormal, StudentT};

use super::PropagationError;

/// Part of the largest eigenvalue by which rounding may leave another one negative.
const ROUNDING: f64 = 1e-12;

/// The distribution of one quantity; what is built is valid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distribution {
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Normal { mean: f64, u: f64 },
    Student { location: f64, scale: f64, degrees_of_freedom: f64, standard: StudentT<f64> },
    Trapezoidal { middle: f64, half_width: f64, top: f64 },
    Arcsine { middle: f64, half_width: f64 },
    CurvilinearTrapezoid { middle: f64, half_width: f64, limit_half_width: f64 },
}

impl Distribution {
    /// Normal, of this mean and standard uncertainty (6.4.7).
    ///
    /// # Errors
    /// [`PropagationError::Distribution`], for this and for all others: parameters that are not finite, or out of range.
    pub fn normal(mean: f64, u: f64) -> Result<Self, PropagationError> {
        let needs = "a finite mean and a finite standard uncertainty above 0";
        Self::new("normal", needs, mean.is_finite() && positive(u), || Some(Kind::Normal { mean, u }))
    }

    /// Student's with these degrees of freedom, scaled and shifted (6.4.9): its standard uncertainty is `scale` times
    /// `sqrt(nu / (nu - 2))`.
    ///
    /// # Errors
    /// See [`Self::normal`].
    pub fn student(location: f64, scale: f64, degrees_of_freedom: f64) -> Result<Self, PropagationError> {
        let needs = "a finite location, a finite scale above 0 and finite degrees of freedom above 0";
        let valid = location.is_finite() && positive(scale) && positive(degrees_of_freedom);
        Self::new("Student", needs, valid, || {
            let standard = StudentT::new(degrees_of_freedom).ok()?;
            Some(Kind::Student { location, scale, degrees_of_freedom, standard })
        })
    }

    /// Rectangular between limits (6.4.2).
    ///
    /// # Errors
    /// See [`Self::normal`].
    pub fn rectangular(low: f64, high: f64) -> Result<Self, PropagationError> {
        Self::trapezoidal(low, high, 1.0)
    }

    /// Triangular between limits (6.4.5).
    ///
    /// # Errors
    /// See [`Self::normal`].
    pub fn triangular(low: f64, high: f64) -> Result<Self, PropagationError> {
        Self::trapezoidal(low, high, 0.0)
    }

    /// Trapezoidal between limits; `top` is the length of its top in parts of its base, from 0 to 1 (6.4.4).
    ///
    /// # Errors
    /// See [`Self::normal`].
    pub fn trapezoidal(low: f64, high: f64, top: f64) -> Result<Self, PropagationError> {
        let needs = "finite limits, the low one below the high one, and a top between 0 and 1";
        let (middle, half_width) = middle(low, high);
        let valid = positive(half_width) && (0.0..=1.0).contains(&top);
        Self::new("trapezoidal", needs, valid, || Some(Kind::Trapezoidal { middle, half_width, top }))
    }

    /// Arcsine between limits: what a sine of unknown phase does (6.4.6).
    ///
    /// # Errors
    /// See [`Self::normal`].
    pub fn arcsine(low: f64, high: f64) -> Result<Self, PropagationError> {
        let (middle, half_width) = middle(low, high);
        let needs = "finite limits, the low one below the high one";
        Self::new("arcsine", needs, positive(half_width), || Some(Kind::Arcsine { middle, half_width }))
    }

    /// Rectangular between limits that are known within plus or minus `limit_half_width` only, both about the same
    /// middle: a curvilinear trapezoid (6.4.3).
    ///
    /// # Errors
    /// See [`Self::normal`].
    pub fn curvilinear_trapezoid(
        low: f64,
        high: f64,
        limit_half_width: f64,
    ) -> Result<Self, PropagationError> {
        let (middle, half_width) = middle(low, high);
        let needs = "finite limits, the low one below the high one, known to less than half their distance";
        let valid = positive(limit_half_width) && limit_half_width < half_width && half_width.is_finite();
        Self::new("curvilinear trapezoid", needs, valid, || {
            Some(Kind::CurvilinearTrapezoid { middle, half_width, limit_half_width })
        })
    }

    fn new(
        kind: &'static str,
        needs: &'static str,
        valid: bool,
        build: impl FnOnce() -> Option<Kind>,
    ) -> Result<Self, PropagationError> {
        let built = if valid { build() } else { None };
        built.map(|kind| Self { kind }).ok_or(PropagationError::Distribution { kind, needs })
    }

    /// Expectation; where that does not exist (Student's with one degree of freedom or fewer), the centre.
    #[must_use]
    pub fn mean(&self) -> f64 {
        match self.kind {
            Kind::Normal { mean: middle, .. }
            | Kind::Student { location: middle, .. }
            | Kind::Trapezoidal { middle, .. }
            | Kind::Arcsine { middle, .. }
            | Kind::CurvilinearTrapezoid { middle, .. } => middle,
        }
    }

    /// Standard deviation; infinite for Student's with two degrees of freedom or fewer.
    #[must_use]
    pub fn standard_uncertainty(&self) -> f64 {
        match self.kind {
            Kind::Normal { u, .. } => u,
            Kind::Student { scale, degrees_of_freedom: nu, .. } => {
                if nu > 2.0 {
                    scale * (nu / (nu - 2.0)).sqrt()
                } else {
                    f64::INFINITY
                }
            }
            Kind::Trapezoidal { half_width, top, .. } => half_width * ((1.0 + top * top) / 6.0).sqrt(),
            Kind::Arcsine { half_width, .. } => half_width / 2.0_f64.sqrt(),
            Kind::CurvilinearTrapezoid { half_width, limit_half_width: d, .. } => {
                (half_width * half_width / 3.0 + d * d / 9.0).sqrt()
            }
        }
    }

    /// One draw.
    pub fn sample(&self, rng: &mut impl Rng) -> f64 {
        match self.kind {
            Kind::Normal { mean, u } => mean + u * rng.sample::<f64, _>(StandardNormal),
            Kind::Student { location, scale, standard, .. } => location + scale * rng.sample(standard),
            // The sum of two rectangular quantities, one of them the length of the top.
            Kind::Trapezoidal { middle, half_width, top } => {
                middle + 0.5 * half_width * ((1.0 + top) * symmetric(rng) + (1.0 - top) * symmetric(rng))
            }
            Kind::Arcsine { middle, half_width } => middle + half_width * (TAU * rng.random::<f64>()).sin(),
            Kind::CurvilinearTrapezoid { middle, half_width, limit_half_width } => {
                let half_width = half_width + limit_half_width * symmetric(rng);
                middle + half_width * symmetric(rng)
            }
        }
    }
}

fn positive(number: f64) -> bool {
    number.is_finite() && number > 0.0
}

/// The middle between limits, and half their distance.
fn middle(low: f64, high: f64) -> (f64, f64) {
    (low + 0.5 * (high - low), 0.5 * (high - low))
}

/// Rectangular between -1 and 1.
fn symmetric(rng: &mut impl Rng) -> f64 {
    2.0 * rng.random::<f64>() - 1.0
}

/// Several quantities, normal together (6.4.8).
#[derive(Debug, Clone, PartialEq)]
pub struct MultivariateNormal {
    mean: DVector<f64>,
    /// Its product with its own transpose is the covariance.
    root: DMatrix<f64>,
}

impl MultivariateNormal {
    /// Of these means and this covariance; quantities may depend on each other entirely.
    ///
    /// # Errors
    /// [`PropagationError::Distribution`], for a mean that is not finite; [`PropagationError::Matrix`], for a matrix that
    /// is no covariance of so many quantities.
    pub fn new(mean: DVector<f64>, covariance: &DMatrix<f64>) -> Result<Self, PropagationError> {
        if mean.is_empty() || mean.iter().any(|value| !value.is_finite()) {
            let (kind, needs) = ("multivariate normal", "a finite mean of each quantity");
            return Err(PropagationError::Distribution { kind, needs });
        }
        let root = square_root(covariance, mean.len(), "covariance")?;
        Ok(Self { mean, root })
    }

    /// How many quantities.
    #[must_use]
    pub fn quantities(&self) -> usize {
        self.mean.len()
    }

    /// One draw of all of them.
    pub fn sample(&self, rng: &mut impl Rng) -> DVector<f64> {
        let standard = DVector::from_fn(self.mean.len(), |_, _| rng.sample(StandardNormal));
        &self.mean + &self.root * standard
    }
}

/// A matrix whose product with its own transpose is this one.
///
/// # Errors
/// [`PropagationError::Matrix`], unless it is of this size, finite, symmetric and positive semidefinite.
pub(super) fn square_root(
    matrix: &DMatrix<f64>,
    size: usize,
    name: &'static str,
) -> Result<DMatrix<f64>, PropagationError> {
    let wrong = PropagationError::Matrix { name, size, more: "" };
    if matrix.shape() != (size, size) || matrix.iter().any(|value| !value.is_finite()) {
        return Err(wrong);
    }
    let rounding = ROUNDING * matrix.amax();
    if (matrix - matrix.transpose()).amax() > rounding {
        return Err(wrong);
    }
    // Unlike Cholesky's it exists for singular matrices, too.
    let eigen = matrix.clone().symmetric_eigen();
    let size = f64::max(1.0, size as f64);
    if eigen.eigenvalues.iter().any(|value| *value < -size * rounding) {
        return Err(wrong);
    }
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    Ok(eigen.eigenvectors * DMatrix::from_diagonal(&roots))
}
