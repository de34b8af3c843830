//! touchref turns a handful of labelled probe touches on a reference fixture into the fixture's 6-DoF frame, says how
//! far that frame can be trusted, and refuses, with reasons, where it cannot.
//!
//! # From touches to a frame
//!
//! A robot or a machine touches a fixture of known geometry and writes down, for each touch, which surface it met and
//! where the centre of the tip was. Here is the worked example of Nederbragt and Ravani: four touches on a cylinder of
//! radius 1, three on a plane at 45 degrees to its axis.
//!
//! ```
//! use touchref::prelude::*;
//!
//! let registry = touchref::registry()?;
//! let fixture = registry
//!     .fixture("cylinder-plane")?
//!     .build(&Parameters::new().with("radius", 1.0).with("angle_deg", 45.0))?;
//!
//! let touches = [
//!     fixture.touch("cylinder", [2.9270, 2.0000, 1.6250])?,
//!     fixture.touch("cylinder", [1.7750, 2.8000, 1.4438])?,
//!     fixture.touch("cylinder", [1.3730, 2.6000, 3.1166])?,
//!     fixture.touch("cylinder", [3.5270, 3.2000, 3.1082])?,
//!     fixture.touch("plane", [2.8250, 2.4000, 4.0395])?,
//!     fixture.touch("plane", [3.9020, 5.2000, 4.0353])?,
//!     fixture.touch("plane", [2.0480, 5.2000, 4.7853])?,
//! ];
//! // The touches are surface points (tip radius 0), good to half a unit of their last digit.
//! let probe = Probe { sigma: Some(0.00005), ..Probe::default() };
//!
//! let solver = registry.solver("closed-form")?.build(&Parameters::new())?;
//! let solution = solver.solve(&Problem::new(&*fixture, &touches, probe)?)?;
//!
//! let origin = solution.frame.origin;
//! assert!((origin.x - 2.9).abs() < 2e-4 && (origin.y - 3.8).abs() < 2e-4 && (origin.z - 4.2249).abs() < 2e-4);
//! // Four frames satisfy the equations; the known radius chooses.
//! assert_eq!(solution.roots.len(), 4);
//! assert!(solution.roots.iter().filter(|root| root.selected).count() == 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How far to trust it
//!
//! [`Solution::covariance`] is the frame's 6x6 covariance; its type says in which order, along which axes and about
//! which point. [`Solution::trust`] is the margin: the frame is consistent, the only one, and its covariance true, as
//! long as the standard deviation of one touch lies between [`Trust::from_sigma`] and [`Trust::up_to_sigma`]. Where no
//! sigma is stated there is no covariance to state either without redundancy, and that interval is the whole answer.
//!
//! ```
//! # use touchref::prelude::*;
//! # let registry = touchref::registry()?;
//! # let parameters = Parameters::new().with("radius", 1.0).with("angle_deg", 45.0);
//! # let fixture = registry.fixture("cylinder-plane")?.build(&parameters)?;
//! # let at = |s: &str, p: [f64; 3]| fixture.touch(s, p);
//! # let touches = [at("cylinder", [2.9270, 2.0, 1.6250])?, at("cylinder", [1.7750, 2.8, 1.4438])?,
//! #     at("cylinder", [1.3730, 2.6, 3.1166])?, at("cylinder", [3.5270, 3.2, 3.1082])?,
//! #     at("plane", [2.8250, 2.4, 4.0395])?, at("plane", [3.9020, 5.2, 4.0353])?, at("plane", [2.0480, 5.2, 4.7853])?];
//! # let solver = registry.solver("closed-form")?.build(&Parameters::new())?;
//! // The same touches, but the probe is good to 0.1 only: more than one frame would do.
//! let rough = Probe { sigma: Some(0.1), ..Probe::default() };
//! let refusal = solver.solve(&Problem::new(&*fixture, &touches, rough)?).unwrap_err();
//! assert_eq!(refusal.code(), "ambiguous");
//! println!("{refusal}\n{}", refusal.help());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A refusal is a [`SolveError`]: too few touches, a layout that leaves a motion free (told in words), no frame or
//! several within the noise, or an uncertainty that would not be true. There is no frame in it to take by mistake.
//!
//! # What is where
//!
//! | crate | what |
//! |---|---|
//! | [`touchref_core`] (re-exported here) | [`Frame`], [`Touch`], [`Surface`], [`Fixture`], [`Solver`], [`Solution`], [`Registry`] |
//! | [`fixtures`] | one file a fixture |
//! | [`solvers`] | one file a solver |
//! | [`analysis`] | simulated measurements, studies of how often a frame is right, refused or wrong, reference data; propagation of uncertainty |
//! | [`conformance`] | does a plugin keep what the traits promise? |
//! | [`report`] | a result as one page that opens by itself, and its picture |
//! | `batch`, a feature of that name | many placements at once, from Arrow to Arrow; CSV, NDJSON, Parquet |
//! | [`locate`] | from a measurement to its result or refusal, as the command line gives it |
//! | [`io`] | measurement files, touch tables, results as JSON, frames in the words of machines |
//!
//! The command line `touchref` is the package `touchref-cli`, a library too: link your own plugins into a binary of a
//! few lines.
//!
//! # Your own fixture
//!
//! A fixture is one file: a type that implements [`Fixture`], a `static` [`FixturePlugin`] that describes it, and
//! [`register_fixture!`]. Every solver then works with it, and no other file changes. CONTRIBUTING shows one, worked;
//! [`conformance`] is the suite that tells whether it keeps what the traits promise.
//!
//! # Limits
//!
//! - Surfaces are ideal: form errors count as noise, so state a sigma that covers them.
//! - A frame is that of the moment of touching; nothing notices when the fixture is bumped later.
//! - Seven touches are one more than unknowns: a bad touch may be noticed, but never told which. Nine may tell
//!   ([`solvers::robust`]).
//! - Acceptance is a matter of measured rates, not of proof: [`analysis::Study`], `touchref study` and
//!   `cargo run --release --example acceptance_study` measure them.

pub use touchref_analysis as analysis;
pub use touchref_analysis::conformance;
#[cfg(feature = "batch")]
pub use touchref_batch as batch;
pub use touchref_core::*;
pub use touchref_fixtures as fixtures;
pub use touchref_io as io;
pub use touchref_report as report;
pub use touchref_solvers as solvers;

pub mod locate;

/// What a program that locates fixtures needs.
pub mod prelude {
    pub use touchref_core::{
        Fixture, Frame, Parameters, Probe, Problem, Solution, SolveError, Solver, Touch,
    };
}

/// Every plugin that is linked in: the built-in ones, and those that other crates registered.
///
/// A snapshot: build it when it is needed, after all libraries are loaded.
///
/// # Errors
/// [`RegistryError::Duplicate`] when two plugins of one kind have one name.
pub fn registry() -> Result<Registry, RegistryError> {
    Registry::linked(fixtures::ALL, solvers::ALL, io::dialect::ALL)
}

/// The examples of CONTRIBUTING.md compile and run.
#[cfg(doctest)]
#[doc = include_str!("../CONTRIBUTING.md")]
struct Contributing;
