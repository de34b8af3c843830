//! What touches are worth: simulated measurements, and studies of how often a frame is right, refused or wrong; reference
//! data with a known answer; and what a plugin must keep of what the traits promise. How uncertainty propagates, and the
//! published examples that gauge it.

pub mod conformance;
pub mod drift;
pub mod estimate;
pub mod gauge;
pub mod linear;
pub mod planning;
pub mod propagation;
pub mod reference;
pub mod reliability;
pub mod simulation;
pub mod study;
pub mod uncertainty;

pub use estimate::{Estimate, Share};
pub use linear::{Linear, Observation};
pub use planning::{Plan, PlanError, Planner};
pub use reliability::{Reliability, ReliabilityError, Test};
pub use simulation::{Layout, contacts, random_frame, random_layout, simulate};
pub use study::{Study, StudyError, StudyLayout, StudyOutcome};
pub use uncertainty::{Uncertainty, UncertaintyError};
