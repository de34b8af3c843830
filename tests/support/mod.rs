//! What the whole-library tests and benches share: layouts, and methods that share no code with the library.

// Each test uses its own part; a test may panic.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

pub mod companion;

use touchref::{Fixture, Parameters, Solver};

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
