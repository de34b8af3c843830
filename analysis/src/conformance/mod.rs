//! Does a plugin keep what the traits promise? The suite that the built-in plugins pass, for everyone's.
//!
//! [`Suite::fixture`] and [`Suite::solver`] return a [`Report`], and [`Report::assert_passed`], in a test of the crate
//! that has the plugin, is all: CONTRIBUTING shows it.
//!
//! Everything is seeded, so that a report can be had again, whatever the number of threads. A check that panics has
//! failed, and the report says with which words; so a plugin under test needs `panic = "unwind"`, Rust's default. One that
//! never returns is waited for.
//!
//! # What is checked of a fixture
//!
//! | check | promise |
//! |---|---|
//! | `description` | the plugin says what the fixture is: its name, surfaces, size |
//! | `parameters` | they are documented and checked; rebuilt from its own, the fixture is the same |
//! | `requirement` | it names enough touches for six unknowns, and says which are missing |
//! | `surfaces` | normals are unit and the gradient of distance; what can be reached lies on the surface |
//! | `nominal-layout` | it lies on the surfaces, is enough, and sees all six motions well |
//! | `dimensions` | they are parameters; shapes and gradients follow them |
//! | `unit` | all lengths times 25.4 make the same fixture 25.4 times as large |
//! | `roots` | the true frame is among the roots of exact touches, with its dimensions, whatever the tip |
//! | `invariance` | the roots depend neither on the order of touches nor on where the parent stands nor on the unit |
//! | `candidates` | under noise a candidate lies in the basin of the true frame's minimum |
//! | `objection` | nothing is said against the true frame of sound touches |
//! | `wild-touches` | no touches, however absurd, make it panic or give a root that is not finite |
//! | `null-space` | touches with residuals in the null space have the design frame as their minimum: [`crate::reference`] |
//!
//! # What is checked of a solver, with a fixture
//!
//! | check | promise |
//! |---|---|
//! | `description` | it goes by its plugin's name; parameters are documented and checked |
//! | `exact` | exact touches give the right frame or a refusal, and the nominal layout a frame |
//! | `noisy` | no accepted frame is outside its own covariance, which is symmetric, positive and true on average |
//! | `account` | residuals, chi-square, p-value, trust and roots agree with the frame and with each other |
//! | `invariance` | the outcome depends neither on the order of touches nor on where the parent stands nor on the unit |
//! | `refusals` | too few touches, and layouts that leave a motion free, are refused; refusals say why and what to do |
//! | `no-sigma` | without a sigma nothing is told that would need one |
//! | `wild-touches` | no touches, however absurd, make it panic or give a frame that is not finite |
//! | `null-space` | the frame of reference data comes back to rounding, for a solver that [claims](Claim) least squares |

mod case;
mod fixture;
mod solver;

use std::{
    fmt,
    panic::{AssertUnwindSafe, catch_unwind},
};

use rayon::prelude::*;
use touchref_core::{FixturePlugin, Parameters, SolverPlugin};

/// What a check found: in words, what was tried and how well it went, or what is wrong.
type Finding = Result<String, String>;

/// A check of a subject, by its name.
type Promise<S> = (&'static str, fn(&S) -> Finding);

/// Ends a check, with words, where a promise is not kept.
macro_rules! ensure {
    ($holds:expr, $($words:tt)+) => {{
        // A comparison with NaN does not hold.
        let holds: bool = $holds;
        if !holds {
            return Err(format!($($words)+));
        }
    }};
}
pub(crate) use ensure;

/// How much is tried.
///
/// By default a fixture, or a solver with a fixture, takes about a second in a test build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Suite {
    /// Random measurements for each check.
    pub trials: u64,
    /// The same seed gives the same measurements.
    pub seed: u64,
}

impl Default for Suite {
    fn default() -> Self {
        Self { trials: 20, seed: 1 }
    }
}

/// Which frame of redundant touches a solver says it finds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// The least-squares frame, the dimensions being what the fixture says.
    LeastSquares,
    /// The least-squares frame, the dimensions that the closed form [measures](touchref_core::ClosedForm::measured)
    /// being what the touches say.
    LeastSquaresMeasured,
    /// Another, as that of a robust estimate: reference data are not held against it.
    Other,
}

impl Suite {
    /// Checks a fixture, built from these parameters.
    #[must_use]
    pub fn fixture(&self, plugin: &FixturePlugin, parameters: &Parameters) -> Report {
        let subject = format!("fixture `{}`", plugin.name);
        fixture::Subject::new(*self, plugin, parameters).map_or_else(
            |error| Report::cannot_be_built(&subject, error),
            |built| Report::of(&subject, &fixture::checks(), &built),
        )
    }

    /// Checks a solver, built from its parameters, with a fixture, built from its own.
    #[must_use]
    pub fn solver(
        &self,
        (solver, solver_parameters): (&SolverPlugin, &Parameters),
        claim: Claim,
        (fixture, fixture_parameters): (&FixturePlugin, &Parameters),
    ) -> Report {
        let subject = format!("solver `{}` with fixture `{}`", solver.name, fixture.name);
        let built = fixture::Subject::new(*self, fixture, fixture_parameters)
            .and_then(|fixture| solver::Subject::new(solver, solver_parameters, claim, fixture));
        built.map_or_else(
            |error| Report::cannot_be_built(&subject, error),
            |built| Report::of(&subject, &solver::checks(&built), &built),
        )
    }
}

/// What the suite found; prints as a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// What was checked, in words.
    pub subject: String,
    /// The checks, in their order.
    pub checks: Vec<Check>,
}

/// One promise.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Its name: see [the module](self).
    pub name: &'static str,
    /// What was tried and how well it went, or what is wrong.
    pub outcome: Result<String, String>,
}

impl Report {
    fn of<S: Sync>(subject: &str, checks: &[Promise<S>], built: &S) -> Self {
        let checks = checks.par_iter().map(|(name, check)| Check {
            name,
            outcome: without_panic(|| check(built)).and_then(|finding| finding),
        });
        Self { subject: subject.to_owned(), checks: checks.collect() }
    }

    fn cannot_be_built(subject: &str, error: String) -> Self {
        Self { subject: subject.to_owned(), checks: vec![Check { name: "build", outcome: Err(error) }] }
    }

    /// Names of the promises that are not kept.
    #[must_use]
    pub fn failed(&self) -> Vec<&'static str> {
        let failed = self.checks.iter().filter(|check| check.outcome.is_err());
        failed.map(|check| check.name).collect()
    }

    /// Panics with the whole report where a promise is not kept.
    #[track_caller]
    pub fn assert_passed(&self) {
        assert!(self.failed().is_empty(), "{self}");
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.checks.iter().map(|check| check.name.len()).max().unwrap_or(0);
        writeln!(f, "{}", self.subject)?;
        for Check { name, outcome } in &self.checks {
            let (verdict, words) = match outcome {
                Ok(words) => ("passed", words),
                Err(words) => ("FAILED", words),
            };
            writeln!(f, "  {name:width$}  {verdict}  {words}")?;
        }
        Ok(())
    }
}

/// What `run` returns; where it panics, the words of that.
fn without_panic<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(run)).map_err(|payload| {
        let words = payload.downcast_ref::<&str>().map(ToString::to_string);
        let words = words.or_else(|| payload.downcast_ref::<String>().cloned());
        format!("panicked: {}", words.unwrap_or_else(|| "without words".to_owned()))
    })
}
