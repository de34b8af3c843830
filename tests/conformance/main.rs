//! Every plugin that is linked in keeps what the traits promise; and the suite that says so can fail.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod broken_fixture;
mod broken_solver;

#[path = "../support/mod.rs"]
mod support;

use touchref::{
    Parameters,
    conformance::{Report, Suite},
    registry,
};

/// Fixtures are quick.
const FIXTURE_SUITE: Suite = Suite { trials: 200, seed: 2 };

/// Panics with every report that has a failure.
fn assert_all_passed(reports: &[Report]) {
    assert!(!reports.is_empty());
    for report in reports {
        println!("{report}");
    }
    let failed: Vec<String> =
        reports.iter().filter(|report| !report.failed().is_empty()).map(ToString::to_string).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn every_fixture_keeps_its_promises() {
    let mut reports = Vec::new();
    for plugin in registry().unwrap().fixtures() {
        for parameters in support::settings(plugin.name) {
            reports.push(FIXTURE_SUITE.fixture(plugin, &parameters));
        }
    }
    assert_all_passed(&reports);
}

#[test]
fn every_solver_keeps_its_promises_with_every_fixture() {
    let registry = registry().unwrap();
    let mut reports = Vec::new();
    for solver in registry.solvers() {
        for fixture in registry.fixtures() {
            let claim = support::claim(solver.name);
            let all = support::settings(fixture.name);
            // A search everywhere takes a thousand times as long as one that the fixture leads.
            let (suite, settings) = match (solver.name, fixture.name) {
                // It makes dozens of them: tests/composite.rs.
                ("robust", "composite") => continue,
                ("global", _) | (_, "composite") => (Suite { trials: 4, seed: 1 }, 1),
                _ => (Suite::default(), all.len()),
            };
            for parameters in &all[..settings] {
                reports.push(suite.solver((solver, &Parameters::new()), claim, (fixture, parameters)));
            }
        }
    }
    assert_all_passed(&reports);
}

/// A report prints every check by name, and panics with what failed.
#[test]
fn a_report_says_what_failed() {
    let plugin = registry().unwrap().fixture("cylinder-plane").unwrap();
    let report = Suite::default().fixture(plugin, &Parameters::new());
    // The radius must be given.
    assert_eq!(report.failed(), ["build"]);
    let told = report.to_string();
    assert!(told.contains("FAILED") && told.contains("`radius` is missing"), "{told}");
    let panic = std::panic::catch_unwind(|| report.assert_passed()).unwrap_err();
    assert_eq!(panic.downcast_ref::<String>().unwrap(), &told);
}

/// The same suite gives the same report, another seed another one.
#[test]
fn a_report_is_repeatable() {
    let plugin = registry().unwrap().fixture("cylinder-plane").unwrap();
    let parameters = Parameters::new().with("radius", 20.0);
    let suite = Suite { trials: 5, seed: 3 };
    let report = suite.fixture(plugin, &parameters);
    assert_eq!(report, suite.fixture(plugin, &parameters));
    assert_ne!(report, Suite { seed: 4, ..suite }.fixture(plugin, &parameters));
}
