//! The built-in solvers of touchref: one file a plugin.

use touchref_core::SolverPlugin;

/// Every solver of this crate, for programs whose linker drops what was registered.
pub static ALL: &[&SolverPlugin] = &[];
