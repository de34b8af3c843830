//! A frame in the words of the machine that will use it.

use touchref_core::Frame;

use crate::{InputError, Units};

/// What one robot, CNC or ROS user pastes; add one to [`ALL`].
#[derive(Debug, Clone, Copy)]
pub struct Dialect {
    /// The name that `--dialect` takes.
    pub name: &'static str,
    /// What it is for, in one line.
    pub summary: &'static str,
    /// Writes the frame of a measurement in this unit.
    pub literal: fn(&Frame, Units) -> String,
}

/// Every dialect, sorted by name.
pub static ALL: &[Dialect] = &[];

/// The dialect of that name.
///
/// # Errors
/// `unknown-dialect`, with the nearest known name.
pub fn find(name: &str) -> Result<&'static Dialect, InputError> {
    let known = ALL.iter().map(|dialect| dialect.name);
    ALL.iter()
        .find(|dialect| dialect.name == name)
        .ok_or_else(|| InputError::unknown("unknown-dialect", "dialect", name, known))
}
