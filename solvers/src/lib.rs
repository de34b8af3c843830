//! The built-in solvers of touchref: one file a plugin.

pub(crate) mod acceptance;
pub mod closed_form;
pub(crate) mod levenberg_marquardt;
pub(crate) mod model;
pub(crate) mod words;

use touchref_core::SolverPlugin;

pub use closed_form::ClosedFormSolver;

/// Every solver of this crate, for programs whose linker drops what was registered.
pub static ALL: &[&SolverPlugin] = &[&closed_form::PLUGIN];
