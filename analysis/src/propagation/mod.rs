//! Propagation of distributions: from what is known of input quantities to estimates, uncertainties and coverage
//! intervals of output quantities.
//!
//! - [`FirstOrder`]: the law of propagation of uncertainty (GUM, JCGM 100:2008, clause 5 and annex G; for several
//!   outputs JCGM 102:2011, clause 6);
//! - [`MonteCarlo`]: draws of the inputs go through the model itself (JCGM 101:2008, clause 7; JCGM 102:2011, clause 7);
//! - [`Validation`]: whether the first is true by the second (JCGM 101:2008, clause 8).

mod coverage;
mod distribution;
mod first_order;
mod monte_carlo;

use thiserror::Error;

pub use coverage::{
    Interval, Validation, box_factor, coverage_factor, ellipsoid_factor, numerical_tolerance,
};
pub use distribution::{Distribution, MultivariateNormal};
pub use first_order::{FirstOrder, Input, Propagation};
pub use monte_carlo::{Draw, MonteCarlo, Numerical, Output, Propagated, Trials};

/// Why there is nothing to tell of the outputs.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PropagationError {
    /// There is no output quantity.
    #[error("there is no output quantity to propagate to")]
    NoOutputs,
    /// A coverage probability is none.
    #[error("a coverage probability lies between 0 and 1, not {0}")]
    Probability(f64),
    /// So many significant digits are none, or more than an uncertainty has.
    #[error("an uncertainty has 1 to 9 significant digits, not {0}")]
    Digits(u32),
    /// A distribution cannot have these parameters.
    #[error("a {kind} distribution needs {needs}")]
    Distribution {
        /// Which.
        kind: &'static str,
        /// What its parameters must keep.
        needs: &'static str,
    },
    /// An input has an estimate, an uncertainty or degrees of freedom that are none.
    #[error(
        "input {index} needs a finite estimate, a finite standard uncertainty of 0 or more, and more than 0 degrees of \
         freedom"
    )]
    Input {
        /// Which, from 0.
        index: usize,
    },
    /// A matrix is no covariance or correlation matrix of these quantities.
    #[error("the {name} matrix must be {size} by {size}, finite, symmetric and positive semidefinite{more}")]
    Matrix {
        /// Covariance or correlation.
        name: &'static str,
        /// Rows it must have.
        size: usize,
        /// What else is asked of it.
        more: &'static str,
    },
    /// Inputs are correlated, and what was asked for is known for independent ones only.
    #[error("terms of higher order are known for independent inputs only")]
    Correlated,
    /// The model has no value, or no finite derivative, at the estimates.
    #[error("the model has no finite value or derivative for output {output} at the estimates of the inputs")]
    NotDifferentiable {
        /// Which, from 0.
        output: usize,
    },
    /// More trials are needed to tell an interval of this probability.
    #[error("{trials} trials are too few: a {probability} coverage interval needs {least}")]
    TooFewTrials {
        /// Those asked for.
        trials: u64,
        /// The fewest that do.
        least: u64,
        /// Of the interval.
        probability: f64,
    },
    /// A trial gave a value that is no number.
    #[error("trial {trial} gave output {output} a value that is not finite")]
    NotFinite {
        /// Which, from 0.
        trial: u64,
        /// Which, from 0.
        output: usize,
    },
    /// Too many trials had no value.
    #[error("{failed} of {trials} trials had no value: too few are left to tell an interval")]
    TooManyFailed {
        /// Trials without a value.
        failed: u64,
        /// All trials.
        trials: u64,
    },
}

/// # Errors
/// [`PropagationError::Probability`], unless it lies between 0 and 1.
fn check_probability(probability: f64) -> Result<(), PropagationError> {
    if probability > 0.0 && probability < 1.0 {
        Ok(())
    } else {
        Err(PropagationError::Probability(probability))
    }
}

/// # Errors
/// [`PropagationError::Digits`].
fn check_digits(digits: u32) -> Result<(), PropagationError> {
    if (1..=9).contains(&digits) { Ok(()) } else { Err(PropagationError::Digits(digits)) }
}
