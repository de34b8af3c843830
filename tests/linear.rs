//! The linear model of a measurement against the solver that it describes: errors are put into touches and stated sizes,
//! and the frame is found anew.

#![allow(clippy::unwrap_used)] // A test may panic.

mod support;

use touchref::{
    Fixture, Frame, Probe, Problem, Solution, Touch, Unknown,
    analysis::{
        Linear, Observation,
        simulation::{generator, random_frame, random_layout, simulate},
    },
};

const SIGMA: f64 = 0.01;
/// Errors that are put in, in standard deviations: second-order terms are 1e-3 of that times the noise over the size.
const ERROR: f64 = 1e-2;
/// Part of the largest sensitivity: residuals of 1e-3 of the radii bend distances by as much.
const TOLERANCE: f64 = 5e-3;

fn solved(fixture: &dyn Fixture, touches: &[Touch], probe: Probe, near: &Frame) -> Solution {
    let problem = Problem::new(fixture, touches, probe).unwrap().near(*near);
    support::solver("least-squares").solve(&problem).unwrap()
}

#[test]
fn sensitivities_are_those_of_the_solver() {
    let cases: [(&str, &[usize]); 4] = [
        ("cylinder-plane", &[6, 5]),
        ("three-sphere", &[4, 4, 5]),
        ("cube", &[4, 0, 3, 0, 4, 0]),
        ("composite", &[4, 3, 2]),
    ];
    for (kind, counts) in cases {
        let parameters = support::uncertain(kind);
        let fixture = support::fixture(kind, &parameters);
        let mut rng = generator(404, 0);
        let layout = random_layout(&*fixture, counts, &mut rng);
        let truth = random_frame(100.0, &mut rng);
        let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.004, sigma: Some(SIGMA) };
        let touches = simulate(&*fixture, &layout, &truth, &probe, SIGMA, &mut rng);
        let solution = solved(&*fixture, &touches, probe, &truth);
        let problem = Problem::new(&*fixture, &touches, probe).unwrap();
        let linear = Linear::at(&problem, &solution.frame).unwrap();

        let covariance = solution.covariance.unwrap().matrix;
        let apart = (linear.covariance() - covariance).abs().max() / covariance.abs().max();
        assert!(apart < TOLERANCE, "{kind}: {apart}");

        for (index, observation) in linear.observations().iter().enumerate() {
            let error = ERROR * linear.sigmas()[index];
            let (mut erring, mut erring_probe, mut parameters) = (touches.clone(), probe, parameters.clone());
            match observation {
                Observation::Touch(touch) => {
                    let normal = solution.frame.rotation * problem.contact(&solution.frame, *touch).normal;
                    erring[*touch].at += normal * error;
                }
                Observation::Stated(Unknown::TipRadius) => erring_probe.tip_radius += error,
                Observation::Stated(what @ Unknown::Dimension(_)) => {
                    let stated = what.stated(&*fixture, &probe);
                    let value = (stated.nominal + error) * stated.scale;
                    parameters.set_number(&stated.name, value, stated.u * stated.scale);
                }
            }
            let fixture = support::fixture(kind, &parameters);
            let found = solved(&*fixture, &erring, erring_probe, &solution.frame);
            let seen = solution.frame.error_to(&found.frame) / ERROR;
            let told = linear.sensitivity(index);
            let scales = covariance.diagonal().map(f64::sqrt);
            let apart = (seen - told).component_div(&scales).abs().max();
            assert!(apart < TOLERANCE, "{kind}, {observation:?}: {apart} {seen} {told}");
            if let Observation::Touch(touch) = observation {
                // What the residuals show of the error.
                let by = found.residuals[*touch].normalized.unwrap()
                    - solution.residuals[*touch].normalized.unwrap();
                assert!(
                    (by / ERROR - linear.redundancy()[(index, index)]).abs() < TOLERANCE,
                    "{kind} {index}"
                );
                let residual = solution.residuals[*touch].normalized.unwrap();
                assert!((linear.residuals()[index] - residual).abs() < TOLERANCE, "{kind} {index}");
            }
        }
        // Each size is one unknown and one observation more.
        let spare = touches.len() - problem.unknowns();
        assert!((linear.redundancy().trace() - spare as f64).abs() < 1e-9, "{kind}");
    }
}

#[test]
fn what_is_not_seen_has_no_linear_model() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };
    let mut rng = generator(405, 0);
    let truth = random_frame(100.0, &mut rng);
    // A cylinder alone leaves a spin and a slide free.
    let layout = random_layout(&*fixture, &[8, 0], &mut rng);
    let touches = simulate(&*fixture, &layout, &truth, &probe, 0.0, &mut rng);
    let problem = Problem::new(&*fixture, &touches, probe).unwrap();
    assert_eq!(Linear::at(&problem, &truth), None);
    let few = Problem::new(&*fixture, &touches[..5], probe).unwrap();
    assert_eq!(Linear::at(&few, &truth), None);
}
