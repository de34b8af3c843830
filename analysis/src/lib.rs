//! What touches are worth: simulated measurements, and studies of how often a frame is right, refused or wrong.

pub mod conformance;
pub mod reference;
pub mod simulation;
pub mod study;

pub use simulation::{Layout, random_frame, random_layout, simulate};
pub use study::{Study, StudyLayout, StudyOutcome};
