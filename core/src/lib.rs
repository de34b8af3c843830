//! Core of touchref: surfaces, touches, frames, the [`Fixture`], [`Solver`] and [`Dialect`] traits, and the plugin [`Registry`].
//!
//! Depend on the facade crate `touchref` to use the built-in plugins; depend on this crate to write one.
//!
//! Units: one consistent length unit, whatever it is; angles in radians. Frames: a [`Frame`] maps fixture
//! coordinates into the parent, the frame in which the touches are expressed.

pub mod calibration;
pub mod dialect;
pub mod error;
pub mod fixture;
pub mod frame;
pub mod freedom;
pub mod observability;
pub mod parameters;
pub mod registry;
pub mod solver;
pub mod statistics;
pub mod surface;
pub mod together;
pub mod touch;
pub mod units;
pub mod unknown;

pub use calibration::{Calibration, Placement};
pub use dialect::{Convention, Dialect, DialectError, Literal, Loss, Lost, Omission};
pub use error::{Degenerate, Refusal, SolveError, TouchError};
pub use fixture::{
    ClosedForm, Dimension, Fixture, MAX_DIMENSIONS, MAX_MEASURES, Quantity, Requirement, Root, RootKind,
};
pub use frame::{Frame, Twist, direction};
pub use freedom::Freedom;
pub use observability::{Motion, Observability, RANK_TOLERANCE};
pub use parameters::{Fault, ParameterError, ParameterKind, ParameterSpec, Parameters, TableSpec, Value};
pub use registry::{
    DialectEntry, DialectPlugin, FixtureEntry, FixturePlugin, Plugin, Registry, RegistryError, SolverEntry,
    SolverPlugin,
};
pub use solver::{
    Adjustment, Contact, Covariance, Iteration, Limit, Measure, MinimumReport, Problem, Residual, RootReport,
    SearchReport, SecondMinimum, SigmaSource, Solution, Solver, Trust, Warning,
};
pub use surface::{Extent, Proximity, Shape, Surface};
pub use together::{Certain, Rule, Together};
pub use touch::{Noise, Probe, Touch};
pub use units::Units;
pub use unknown::{Stated, Unknown};

/// Used by the registration macros.
#[doc(hidden)]
pub use inventory;
