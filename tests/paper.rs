//! The worked example of Nederbragt and Ravani: four roots, and the known radius chooses.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use touchref::{Frame, Probe, Problem, SigmaSource, Touch};

const CYLINDER: [[f64; 3]; 4] =
    [[2.9270, 2.0, 1.6250], [1.7750, 2.8, 1.4438], [1.3730, 2.6, 3.1166], [3.5270, 3.2, 3.1082]];
const PLANE: [[f64; 3]; 3] = [[2.8250, 2.4, 4.0395], [3.9020, 5.2, 4.0353], [2.0480, 5.2, 4.7853]];
/// Direction (its z set to one) and radius of each root, recomputed at higher precision from the printed touches.
const ROOTS: [[f64; 3]; 4] = [
    [0.40453, 0.80905, 0.99998],
    [2.24563, 0.08553, 1.07214],
    [-0.38012, 0.11268, 1.14736],
    [-0.22229, -0.89460, 1.17816],
];

fn touches() -> Vec<Touch> {
    let fixture = support::cylinder_plane(1.0, 45.0);
    let on = |name: &str, at: &[[f64; 3]]| -> Vec<Touch> {
        at.iter().map(|at| fixture.touch(name, *at).unwrap()).collect()
    };
    [on("cylinder", &CYLINDER), on("plane", &PLANE)].concat()
}

/// Touches are printed with four decimals.
const PROBE: Probe = Probe { tip_radius: 0.0, tip_radius_u: 0.0, sigma: Some(5e-5) };

/// The answer that the paper prints, for what the printed touches are worth.
fn assert_the_papers(frame: &Frame) {
    const ORIGIN: f64 = 2e-4;
    const AXIS: f64 = 1e-4;
    for (got, want) in frame.origin.iter().zip([2.9, 3.8, 4.2249]) {
        assert!((got - want).abs() < ORIGIN, "{}", frame.origin);
    }
    for (got, want) in frame.axis(2).iter().zip([0.3, 0.6, 0.7416]) {
        assert!((got - want).abs() < AXIS, "{}", frame.axis(2));
    }
}

#[test]
fn least_squares_finds_the_papers_frame() {
    let (fixture, touches) = (support::cylinder_plane(1.0, 45.0), touches());
    for sigma in [PROBE.sigma, None] {
        let problem = Problem::new(&*fixture, &touches, Probe { sigma, ..PROBE }).unwrap();
        let solution = support::solver("least-squares").solve(&problem).unwrap();
        assert_the_papers(&solution.frame);
        assert_eq!((solution.roots.len(), solution.degrees_of_freedom), (ROOTS.len(), 1));
    }
}

#[test]
fn the_papers_frame_and_its_four_roots() {
    let (fixture, touches) = (support::cylinder_plane(1.0, 45.0), touches());
    let problem = Problem::new(&*fixture, &touches, PROBE).unwrap();
    let solution = support::solver("closed-form").solve(&problem).unwrap();
    assert_the_papers(&solution.frame);
    assert_eq!(solution.roots.len(), ROOTS.len());
    for [x, y, radius] in ROOTS {
        let root = solution.roots.iter().find(|root| (root.measures[0].value - radius).abs() < 1e-4);
        let root = root.unwrap_or_else(|| panic!("no root of radius {radius}"));
        let z = root.frame.axis(2);
        assert!((z.x / z.z - x).abs() < 1e-4 && (z.y / z.z - y).abs() < 1e-4, "{z}");
        assert_eq!(root.selected, (radius - 1.0).abs() < 1e-3, "{}", root.reason);
        assert_eq!(root.selected, root.frame == solution.frame);
    }
    assert_eq!(solution.degrees_of_freedom, 1);
    assert_eq!(solution.covariance.unwrap().sigma_source, SigmaSource::Given);
}

#[test]
fn without_a_sigma_the_answer_is_conditional() {
    let (fixture, touches) = (support::cylinder_plane(1.0, 45.0), touches());
    let problem = Problem::new(&*fixture, &touches, Probe::default()).unwrap();
    let solution = support::solver("closed-form").solve(&problem).unwrap();
    let trust = &solution.trust;
    // Printed with four decimals, so a touch is good to 3e-5: within the interval.
    assert!(trust.from_sigma < 3e-5 && 3e-5 < trust.up_to_sigma, "{trust:?}");
    assert_eq!((trust.sigma, solution.chi_square, solution.p_value), (None, None, None));
    assert!(solution.roots.iter().all(|root| root.misfit.is_none()));
    assert!(solution.warnings.iter().any(|warning| warning.code == "no-sigma"));
}
