//! Coverage: factors, intervals, and whether one interval is as good as another.

use touchref_core::statistics::{chi_square_level, normal_quantile, student_factor};

use super::{PropagationError, check_digits, check_probability};

/// Which of all intervals that hold a probability.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interval {
    /// As much probability below as above (JCGM 101:2008, 7.7.2).
    #[default]
    Symmetric,
    /// The shortest one (JCGM 101:2008, 7.7.3).
    Shortest,
}

impl Interval {
    /// The interval of this probability among sorted values; `None` where they are too few to tell it.
    pub(super) fn of(self, sorted: &[f64], probability: f64) -> Option<[f64; 2]> {
        let count = sorted.len();
        let within = values_within(count, probability);
        if within == 0 || within >= count {
            return None;
        }
        let first = match self {
            // From the value of rank (M - q) / 2, or (M - q + 1) / 2, as ranks count from 1.
            Self::Symmetric => (count - within).div_ceil(2) - 1,
            Self::Shortest => (0..count - within).min_by(|a, b| {
                let length = |first: usize| sorted[first + within] - sorted[first];
                length(*a).total_cmp(&length(*b))
            })?,
        };
        Some([sorted[first], sorted[first + within]])
    }
}

/// How many steps from value to value an interval of this probability takes (JCGM 101:2008, 7.7.1).
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of the count")]
fn values_within(count: usize, probability: f64) -> usize {
    (probability * count as f64 + 0.5).floor() as usize
}

/// Coverage factor of a probability from Student's distribution (GUM G.3.2); infinite degrees of freedom make it the normal
/// one's. Others that are no whole number are cut to the next lower one, as the GUM has it (G.4.1, note 1).
///
/// # Errors
/// [`PropagationError::Probability`].
pub fn coverage_factor(probability: f64, degrees_of_freedom: f64) -> Result<f64, PropagationError> {
    /// Effective degrees of freedom are as good as derivatives are: a whole number that rounding left just below is it.
    const ROUNDING: f64 = 1e-8;
    check_probability(probability)?;
    let whole = (degrees_of_freedom * (1.0 + ROUNDING)).floor().max(1.0);
    Ok(student_factor(probability, whole))
}

/// Half-axes, in standard uncertainties, of the ellipsoid that holds so many normal quantities together with this
/// probability (JCGM 102:2011, 6.5.3).
///
/// # Errors
/// [`PropagationError::Probability`]; [`PropagationError::NoOutputs`].
pub fn ellipsoid_factor(probability: f64, outputs: usize) -> Result<f64, PropagationError> {
    check_probability(probability)?;
    if outputs == 0 {
        return Err(PropagationError::NoOutputs);
    }
    Ok(chi_square_level(1.0 - probability, outputs).sqrt())
}

/// Half-edges, in standard uncertainties, of the box that holds so many normal quantities together with at least this
/// probability, however they are correlated: Bonferroni's (JCGM 102:2011, 6.5.4).
///
/// # Errors
/// [`PropagationError::Probability`]; [`PropagationError::NoOutputs`].
pub fn box_factor(probability: f64, outputs: usize) -> Result<f64, PropagationError> {
    check_probability(probability)?;
    if outputs == 0 {
        return Err(PropagationError::NoOutputs);
    }
    Ok(-normal_quantile((1.0 - probability) / (2.0 * outputs as f64)))
}

/// Half a unit of the last of so many significant digits of the standard uncertainty `u` (JCGM 101:2008, 7.9.2); 0 for 0.
///
/// # Errors
/// [`PropagationError::Digits`].
pub fn numerical_tolerance(u: f64, digits: u32) -> Result<f64, PropagationError> {
    check_digits(digits)?;
    if u == 0.0 || !u.is_finite() {
        return Ok(u.abs());
    }
    // The number as it would be written decides: 0.0999 has two digits as 0.10.
    let written = format!("{:.*e}", digits as usize - 1, u.abs());
    let exponent =
        written.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()).unwrap_or(0);
    Ok(0.5 * 10.0_f64.powi(exponent - digits.cast_signed() + 1))
}

/// Whether the interval of the first-order result is that of the Monte Carlo result (JCGM 101:2008, clause 8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Validation {
    /// Numerical tolerance: by so much the ends may differ.
    pub tolerance: f64,
    /// By how much the low ends differ.
    pub low: f64,
    /// By how much the high ends differ.
    pub high: f64,
}

impl Validation {
    /// Compares the ends of two intervals of the same probability; `u` is the standard uncertainty, of which `digits`
    /// (1 or 2) count.
    ///
    /// # Errors
    /// [`PropagationError::Digits`].
    pub fn new(
        first_order: [f64; 2],
        monte_carlo: [f64; 2],
        u: f64,
        digits: u32,
    ) -> Result<Self, PropagationError> {
        Ok(Self {
            tolerance: numerical_tolerance(u, digits)?,
            low: (first_order[0] - monte_carlo[0]).abs(),
            high: (first_order[1] - monte_carlo[1]).abs(),
        })
    }

    /// Both ends agree.
    #[must_use]
    pub fn validated(&self) -> bool {
        self.low <= self.tolerance && self.high <= self.tolerance
    }
}
