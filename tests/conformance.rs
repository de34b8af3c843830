//! Every plugin that is linked in keeps what the traits promise; and the suite that says so can fail.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

use touchref::{Parameters, conformance::Suite, registry};

fn settings(kind: &str) -> Vec<Parameters> {
    let of = Parameters::new;
    match kind {
        "cylinder-plane" => {
            let radius = || of().with("radius", 20.0);
            vec![
                radius().with("angle_deg", 45.0),
                radius().with("bore", true),
                radius().with("cylinder_side", "front"),
                radius().with("angle_deg", 30.0),
            ]
        }
        "three-sphere" => vec![of().with("radius", 12.7).with("ab", 100.0).with("bc", 110.0).with("ca", 90.0)],
        "cube" => vec![of().with("edge", 50.0)],
        _ => vec![of()],
    }
}

#[test]
fn every_fixture_keeps_its_promises() {
    let mut all = true;
    for plugin in registry().unwrap().fixtures() {
        for parameters in settings(plugin.name) {
            let t = std::time::Instant::now();
            let report = Suite { trials: std::env::var("TRIALS").map_or(40, |t| t.parse().unwrap()), ..Suite::default() }.fixture(plugin, &parameters);
            println!("{report}{:?}", t.elapsed());
            all &= report.failed().is_empty();
        }
    }
    assert!(all);
}

#[test]
fn every_solver_keeps_its_promises() {
    let mut all = true;
    let registry = registry().unwrap();
    for solver in registry.solvers() {
    for plugin in registry.fixtures() {
        for parameters in settings(plugin.name) {
            let t = std::time::Instant::now();
            let suite = Suite { trials: std::env::var("TRIALS").map_or(40, |t| t.parse().unwrap()), ..Suite::default() };
            let report = suite.solver((solver, &Parameters::new()), touchref::conformance::Claim::LeastSquaresMeasured, (plugin, &parameters));
            println!("{report}{:?}", t.elapsed());
            all &= report.failed().is_empty();
        }
    }
    }
    assert!(all);
}
