//! Why there is no frame: every refusal with the measured value and the bound it missed.

use thiserror::Error;

use crate::{Motion, Observability, RootReport, Trust};

/// A list of touches that is no measurement.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TouchError {
    /// No surface of the fixture has this name.
    #[error("the fixture has no surface `{name}`; it has {}", known.join(", "))]
    UnknownSurface {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<String>,
        /// The nearest of them.
        nearest: Option<String>,
    },
    /// A touch refers to a surface index that the fixture does not have.
    #[error("touch {index} is on surface number {surface}, but the fixture has {surfaces} surfaces")]
    NoSuchSurface {
        /// Which touch, from 0.
        index: usize,
        /// The surface index it has.
        surface: usize,
        /// How many surfaces there are.
        surfaces: usize,
    },
    /// A number of a touch is not finite, or a sigma is not positive.
    #[error("touch {index}: {what} is {value}; expected {expected}")]
    BadNumber {
        /// Which touch, from 0.
        index: usize,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// A number of the probe is not finite or out of range.
    #[error("the probe's {what} is {value}; expected {expected}")]
    BadProbe {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// Some touches state how sure they are, others do not, and the probe does not either.
    #[error("touch {index} has no sigma although others have one, and the probe states none")]
    SigmaMissing {
        /// The first touch without.
        index: usize,
    },
    /// There are no touches at all.
    #[error("there are no touches")]
    Empty,
}

/// Why a solver gives no frame.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SolveError {
    /// Some surface has fewer touches than any alternative needs.
    #[error("too few touches: {missing}")]
    TooFewTouches {
        /// What is missing, in words.
        missing: String,
    },
    /// The touches contradict the fixture, so that some label or number must be wrong.
    #[error("{problem}")]
    InvalidTouches {
        /// What is wrong, in words.
        problem: String,
        /// What to do about it.
        help: String,
        /// The touches concerned, from 0.
        touches: Vec<usize>,
    },
    /// The layout of the touches leaves a motion free.
    #[error("the layout of the touches leaves a motion free: {}; {} is {:.1e}, bound {:.0e}", .0.free, .0.quantity, .0.value, .0.bound)]
    Degenerate(Box<Degenerate>),
    /// More than one frame fits within the noise.
    #[error("{}", .0.message)]
    Ambiguous(Box<Refusal>),
    /// No frame fits within the noise.
    #[error("{}", .0.message)]
    Inconsistent(Box<Refusal>),
    /// The frame fits, but its stated uncertainty would not be true.
    #[error("{}", .0.message)]
    NotValidated(Box<Refusal>),
    /// An iteration did not settle.
    #[error("not converged after {iterations} iterations: the last step was {step:.3e}, bound {bound:.1e}")]
    NotConverged {
        /// How many iterations were made.
        iterations: usize,
        /// Length of the last step, in standard deviations.
        step: f64,
        /// The bound it should have gone below.
        bound: f64,
    },
    /// This solver cannot solve problems of this kind.
    #[error("solver `{solver}` cannot do this: {reason}")]
    Unsupported {
        /// The solver.
        solver: &'static str,
        /// Why not, and what can.
        reason: String,
    },
}

impl From<TouchError> for SolveError {
    /// Touches that were made into a problem on the way to a frame are no measurement.
    fn from(error: TouchError) -> Self {
        let help = "correct the touches".to_owned();
        Self::InvalidTouches { problem: error.to_string(), help, touches: Vec::new() }
    }
}

impl SolveError {
    /// The code by which programs know the refusal (`ambiguous`, `degenerate`, ...).
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::TooFewTouches { .. } => "too-few-touches",
            Self::InvalidTouches { .. } => "invalid-input",
            Self::Degenerate(_) => "degenerate",
            Self::Ambiguous(_) => "ambiguous",
            Self::Inconsistent(_) => "inconsistent",
            Self::NotValidated(_) => "not-validated",
            Self::NotConverged { .. } => "not-converged",
            Self::Unsupported { .. } => "unsupported",
        }
    }

    /// Whether the input is wrong (`true`), or sound without giving a frame to trust (`false`).
    #[must_use]
    pub fn is_input_error(&self) -> bool {
        matches!(self, Self::TooFewTouches { .. } | Self::InvalidTouches { .. } | Self::Unsupported { .. })
    }

    /// What to do about it, in words.
    #[must_use]
    pub fn help(&self) -> &str {
        match self {
            Self::TooFewTouches { .. } => {
                "add the missing touches; `touchref describe` tells the layout a fixture needs"
            }
            Self::InvalidTouches { help, .. } => help,
            Self::Degenerate(details) => &details.help,
            Self::Ambiguous(refusal) | Self::Inconsistent(refusal) | Self::NotValidated(refusal) => {
                &refusal.help
            }
            Self::NotConverged { .. } => {
                "check the labels and units of the touches, or give an approximate frame"
            }
            Self::Unsupported { .. } => "`touchref list solvers` tells what there is",
        }
    }

    /// What was found on the way to the refusal, where something was.
    #[must_use]
    pub fn refusal(&self) -> Option<&Refusal> {
        match self {
            Self::Ambiguous(refusal) | Self::Inconsistent(refusal) | Self::NotValidated(refusal) => {
                Some(refusal)
            }
            _ => None,
        }
    }
}

/// A layout that leaves a motion free.
#[derive(Debug, Clone, PartialEq)]
pub struct Degenerate {
    /// How many of the unknowns the touches determine.
    pub rank: usize,
    /// How many unknowns there are.
    pub unknowns: usize,
    /// What shows it: "smallest over largest singular value", say.
    pub quantity: &'static str,
    /// Its value.
    pub value: f64,
    /// The bound on the wrong side of which it lies.
    pub bound: f64,
    /// The motion that is free.
    pub free: Motion,
    /// What to do about it.
    pub help: String,
}

/// A refusal after candidates were found: all that is known of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// What is wrong, with the measured value and the bound.
    pub message: String,
    /// What to do about it.
    pub help: String,
    /// The touches concerned, from 0, where it is about some of them.
    pub touches: Vec<usize>,
    /// Every root, with why it is out; survivors first.
    pub roots: Vec<RootReport>,
    /// The margin in which a frame would have stood.
    pub trust: Trust,
    /// What the touches see at the best candidate.
    pub observability: Option<Observability>,
}
