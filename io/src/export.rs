//! Results in the forms that other programs read: one file a form.

use touchref_core::Fixture;

use crate::{InputError, SolutionRecord};

mod qif;
mod xml;

/// A form in which a result is written; add one to [`ALL`].
#[derive(Debug, Clone, Copy)]
pub struct Exporter {
    /// By which it is asked for.
    pub name: &'static str,
    /// What it is, in one line.
    pub summary: &'static str,
    /// Writes a result of this fixture, built from the result's own parameters.
    pub write: fn(&SolutionRecord, &dyn Fixture) -> Result<Vec<u8>, InputError>,
}

/// Every form, sorted by name.
pub static ALL: &[Exporter] = &[qif::EXPORTER];

/// The form of that name.
///
/// # Errors
/// `unknown-name`, with the nearest known name.
pub fn find(name: &str) -> Result<&'static Exporter, InputError> {
    let known = ALL.iter().map(|exporter| exporter.name);
    ALL.iter()
        .find(|exporter| exporter.name == name)
        .ok_or_else(|| InputError::unknown("unknown-name", "form", name, known))
}
