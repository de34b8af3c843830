//! What touches are worth: simulated measurements, and studies of how often a frame is right, refused or wrong.

pub mod estimate;
pub mod simulation;
pub mod study;

pub use estimate::{Estimate, Share};
pub use simulation::{Layout, contacts, random_frame, random_layout, simulate};
pub use study::{Study, StudyError, StudyLayout, StudyOutcome};
