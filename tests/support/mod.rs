//! What the whole-library tests and benches share: layouts, and methods that share no code with the library.

// Each test uses its own part; a test may panic.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

pub mod certify;
pub mod companion;

use touchref::{
    Fixture, Frame, Parameters, Problem, Solver, Value, conformance::Claim, solvers::refinement::refine,
};

/// A built-in fixture, by name, through the registry.
pub fn fixture(kind: &str, parameters: &Parameters) -> Box<dyn Fixture> {
    touchref::registry().unwrap().fixture(kind).unwrap().build(parameters).unwrap()
}

/// `cylinder-plane` of this radius and angle, a pin, the cylinder behind the plane.
pub fn cylinder_plane(radius: f64, angle_deg: f64) -> Box<dyn Fixture> {
    fixture("cylinder-plane", &Parameters::new().with("radius", radius).with("angle_deg", angle_deg))
}

/// How many measurements are simulated: as many as the environment's `TRIALS` says, else `few`.
pub fn trials(few: u64) -> u64 {
    std::env::var("TRIALS").ok().and_then(|text| text.parse().ok()).unwrap_or(few)
}

/// The maximum-likelihood frame that `start` leads to.
pub fn refined(problem: &Problem<'_>, start: &Frame) -> Frame {
    refine(problem, start).unwrap().unknowns.frame
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
        "composite" => vec![v_block()],
        _ => vec![new()],
    }
}

/// Parameters whose sizes are uncertain, by their standard uncertainties.
pub fn uncertain(kind: &str) -> Parameters {
    let known = |value, u| Value::Number { value, u };
    match kind {
        "cylinder-plane" => {
            Parameters::new().with("radius", known(20.0, 0.02)).with("angle_deg", known(45.0, 0.05))
        }
        "three-sphere" => Parameters::new()
            .with("ab", known(100.0, 0.01))
            .with("bc", known(110.0, 0.02))
            .with("ca", 90.0)
            .with("radius", known(12.7, 0.005)),
        "cube" => Parameters::new().with("edge", known(50.0, 0.03)),
        _ => settings(kind).remove(0),
    }
}

/// A table of `composite`.
fn surface(kind: &str, name: &str) -> Parameters {
    Parameters::new().with("type", kind).with("name", name)
}

/// A V-block with an end stop: X along the groove, Z up.
pub fn v_block() -> Parameters {
    let plane = |name, normal: [f64; 3]| {
        let at = if name == "stop" { [0.0, 0.0, 20.0] } else { [40.0, -10.0 * normal[1], 10.0] };
        surface("plane", name).with("point", at).with("normal", normal).with("within", 25.0)
    };
    let planes =
        [plane("left", [0.0, -1.0, 1.0]), plane("right", [0.0, 1.0, 1.0]), plane("stop", [1.0, 0.0, 0.0])];
    Parameters::new().with("surface", planes.to_vec())
}

/// A bore with a face at each end: everything but its spin.
pub fn bore_with_two_faces() -> Parameters {
    let bore = surface("cylinder", "bore").with("point", [0.0; 3]).with("axis", [0.0, 0.0, 1.0]);
    let bore = bore.with("radius", 15.0).with("bore", true).with("from", -35.0).with("to", -5.0);
    let face = |name, height, up| {
        surface("plane", name)
            .with("point", [0.0, 0.0, height])
            .with("normal", [0.0, 0.0, up])
            .with("within", 30.0)
    };
    let all = vec![bore, face("top", 0.0, 1.0), face("bottom", -40.0, -1.0)];
    Parameters::new().with("surface", all).with("free", &["rz"][..])
}

/// Which frame of redundant touches a solver of this name says it finds.
pub fn claim(solver: &str) -> Claim {
    match solver {
        "least-squares" | "global" | "robust" => Claim::LeastSquares,
        "closed-form" => Claim::LeastSquaresMeasured,
        _ => Claim::Other,
    }
}
