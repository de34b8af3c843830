//! Where placements come from.

use touchref_core::Warning;
use touchref_io::InputError;

use crate::{NameType, placement::Placement};

/// A table of touches, read placement by placement.
pub trait Source: Send {
    /// What placements are called in it.
    fn names(&self) -> NameType;

    /// The next placement; `None` at the end.
    ///
    /// # Errors
    /// What is wrong with the table, and where. What is wrong with a touch is in its placement.
    fn next_placement(&mut self) -> Result<Option<Placement>, InputError>;

    /// How many rows it has, as far as that is known without reading them.
    fn rows(&self) -> Option<u64> {
        None
    }

    /// What the user should know of the table: columns that are not used.
    fn warnings(&self) -> &[Warning] {
        &[]
    }
}
