//! What touches are worth: simulation of measurements.
//!
//! Uncertainty, reliability, planning and drift build on it.

pub mod simulation;

pub use simulation::{Layout, random_frame, random_layout, simulate};
