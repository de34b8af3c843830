//! The built-in solvers of touchref: one file a plugin.
//!
//! # When a frame is accepted
//!
//! The squared misfit at the true frame follows chi-square with one degree of freedom per touch, whatever the geometry.
//! So the frames below a level are an exact confidence set, and each connected piece of that set holds a local minimum
//! of the misfit. A solver therefore looks for **every** minimum (the fixture's
//! [`candidates`](touchref_core::ClosedForm::candidates) are starts wherever the noise does not rule a frame out; without a closed form, a cover of all frames), and
//! accepts the best one when
//!
//! | condition | else refused as |
//! |---|---|
//! | no motion is free: singular values of the scaled Jacobian, and of the root's own | `degenerate` |
//! | its chi-square is below the 1e-3 level for touches less six degrees of freedom | `inconsistent` |
//! | no other minimum lies below the 1e-6 level | `ambiguous` |
//! | the search for minima is complete: the plane's normal is known to 0.1 rad | `degenerate`, `not-validated` |
//! | the relative curvature is below 0.3: Frobenius norm of the residuals' second derivative, in standard deviations, in coordinates in which the covariance is the identity | `not-validated` |
//! | 7.3 standard deviations along the weakest motion (the 1e-9 level of six degrees of freedom) the misfit has risen by 0.55 to 3 times what the covariance predicts | `not-validated` |
//!
//! Each condition scales with the noise, so each has a sigma at which it gives way. These bounds are
//! [`Trust::from_sigma`](touchref_core::Trust::from_sigma) and
//! [`Trust::up_to_sigma`](touchref_core::Trust::up_to_sigma): where a sigma is stated it must lie between them, and where
//! none is stated they are the answer.
//!
//! [`robust`] holds hypotheses about bad touches and wrong labels against the same levels.

pub(crate) mod acceptance;
pub mod bundle;
pub mod closed_form;
pub(crate) mod cover;
pub mod element;
pub mod global;
pub mod labelling;
pub mod least_squares;
pub(crate) mod levenberg_marquardt;
pub(crate) mod model;
pub mod refinement;
pub mod robust;
pub(crate) mod words;

use touchref_core::SolverPlugin;

pub use acceptance::Margin;
pub use closed_form::ClosedFormSolver;
pub use global::Global;
pub use least_squares::LeastSquares;
pub use model::{Extra, MAX_EXTRAS, Unknowns, uncertain};
pub use refinement::refine;
pub use robust::Robust;

/// Every solver of this crate, for programs whose linker drops what was registered.
pub static ALL: &[&SolverPlugin] =
    &[&closed_form::PLUGIN, &global::PLUGIN, &least_squares::PLUGIN, &robust::PLUGIN];
