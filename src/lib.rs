//! touchref

pub use touchref_analysis as analysis;
pub use touchref_core::*;
pub use touchref_fixtures as fixtures;
pub use touchref_io as io;
pub use touchref_solvers as solvers;

/// Every plugin that is linked in: the built-in ones, and those that other crates registered.
///
/// # Errors
/// [`RegistryError::Duplicate`] when two plugins of one kind have one name.
pub fn registry() -> Result<Registry, RegistryError> {
    Registry::linked(fixtures::ALL, solvers::ALL)
}
