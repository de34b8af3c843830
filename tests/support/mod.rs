//! What the whole-library tests and benches share: layouts, and methods that share no code with the library.

// Each test uses its own part; a test may panic.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

pub mod companion;

use touchref::{Fixture, Parameters, Solver, conformance::Claim};

/// A built-in fixture, by name, through the registry.
pub fn fixture(kind: &str, parameters: &Parameters) -> Box<dyn Fixture> {
    touchref::registry().unwrap().fixture(kind).unwrap().build(parameters).unwrap()
}

/// `cylinder-plane` of this radius and angle, a pin, the cylinder behind the plane.
pub fn cylinder_plane(radius: f64, angle_deg: f64) -> Box<dyn Fixture> {
    fixture("cylinder-plane", &Parameters::new().with("radius", radius).with("angle_deg", angle_deg))
}

/// A built-in solver, by name, through the registry.
pub fn solver(name: &str) -> Box<dyn Solver> {
    touchref::registry().unwrap().solver(name).unwrap().build(&Parameters::new()).unwrap()
}

/// Parameters with which a fixture of this kind is tried: sensible ones for the kinds that are known, their defaults for
/// others.
pub fn settings(kind: &str) -> Vec<Parameters> {
    let new = Parameters::new;
    match kind {
        "cylinder-plane" => {
            let radius = || new().with("radius", 20.0);
            let bore = radius().with("bore", true);
            let front = radius().with("cylinder_side", "front");
            vec![radius(), bore, front, radius().with("angle_deg", 30.0)]
        }
        "three-sphere" => {
            let sides = || new().with("ab", 100.0).with("bc", 110.0).with("ca", 90.0);
            vec![sides().with("radius", 12.7), sides().with("radii", [10.0, 12.7, 15.0])]
        }
        "cube" => vec![new().with("edge", 50.0)],
        _ => vec![new()],
    }
}

/// Which frame of redundant touches a solver of this name says it finds.
pub fn claim(solver: &str) -> Claim {
    match solver {
        "least-squares" | "robust" => Claim::LeastSquares,
        "closed-form" => Claim::LeastSquaresMeasured,
        _ => Claim::Other,
    }
}
