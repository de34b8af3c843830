//! What reliability promises, held against solves with an error put in, and against published tests of others.
//!
//! `TRIALS=100000 cargo test --release --test reliability -- --nocapture` measures powers at full size.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use nalgebra::{DMatrix, Point3};
use rayon::prelude::*;
use support::{refined, trials};
use touchref::{
    Fixture, Frame, Probe, Problem, Touch,
    analysis::{
        Reliability, ReliabilityError, Test,
        linear::Observation,
        simulation::{Layout, generator, random_frame, random_layout, simulate},
    },
};

const SIGMA: f64 = 0.005;
const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };

fn reliability(fixture: &dyn Fixture, touches: &[Touch], near: &Frame) -> Reliability {
    let problem = Problem::new(fixture, touches, PROBE).unwrap();
    Reliability::of(&problem, &refined(&problem, near), Test::default()).unwrap()
}

/// The layout of the published figures: R = 25 mm, four touches on the cylinder at these angles and heights, three on a
/// circle of 25 mm on the plane.
fn published() -> (Box<dyn Fixture>, Layout) {
    let fixture = support::cylinder_plane(25.0, 45.0);
    let mut layout: Layout = [(0.0, -25.0), (90.0, -25.0), (45.0, 25.0), (135.0, 25.0)]
        .into_iter()
        .map(|(degrees, z): (f64, f64)| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            (0, Point3::new(25.0 * cos, 25.0 * sin, z))
        })
        .collect();
    let touchref::Shape::Plane { normal, .. } = fixture.surfaces()[1].shape else { panic!("no plane") };
    let across = nalgebra::Vector3::y();
    let along = across.cross(&normal);
    for k in 0..3 {
        let (sin, cos) = (f64::from(k) * 120.0).to_radians().sin_cos();
        layout.push((1, Point3::from((along * cos + across * sin) * 25.0)));
    }
    (fixture, layout)
}

/// The power of one of CERN's LGC2 tests: an observation checked wholly by others, sigma 1.
#[test]
fn published_test_vectors() {
    let wide = Test { alpha: 0.01, power: 0.90 };
    assert!(wide.critical_value() > 2.57 && wide.critical_value() < 2.58);
    assert!((wide.noncentrality() - 3.857).abs() < 5e-4);
    let wider = Test { alpha: 0.02, power: 0.80 };
    assert!(wider.critical_value() > 2.325 && wider.critical_value() < 2.327);
    assert!((wider.noncentrality() - 3.168).abs() < 5e-4);
    // The custom of geodesy (JAG3D's defaults).
    assert!((Test::default().noncentrality() - 4.1321).abs() < 5e-5);
}

/// With one check all test values are one: a bad touch is noticed, never told which.
#[test]
fn seven_touches_detect_and_do_not_locate() {
    let (fixture, layout) = published();
    let truth = random_frame(100.0, &mut generator(1, 1));
    let touches = simulate(&*fixture, &layout, &truth, &PROBE, SIGMA, &mut generator(2, 2));
    let told = reliability(&*fixture, &touches, &truth);
    let sum: f64 = told.observations.iter().map(|checked| checked.redundancy).sum();
    assert!((sum - 1.0).abs() < 1e-9);
    for checked in &told.observations {
        let Some(check) = &checked.check else { continue };
        let others = told.observations.iter().filter(|other| other.check.is_some()).count() - 1;
        assert_eq!(check.confusions.len(), others);
        assert!(
            check
                .confusions
                .iter()
                .all(|confusion| confusion.always && (confusion.chance - 0.5).abs() < 1e-12)
        );
    }
    // By normal equations of this test's own.
    let jacobian = DMatrix::from_fn(7, 6, |row, column| {
        let problem = Problem::new(&*fixture, &touches, PROBE).unwrap();
        let frame = refined(&problem, &truth);
        problem.contact(&frame, row).gradient()[column] / SIGMA
    });
    let hat = &jacobian * (jacobian.transpose() * &jacobian).try_inverse().unwrap() * jacobian.transpose();
    for (index, checked) in told.observations.iter().enumerate() {
        assert!((checked.redundancy - (1.0 - hat[(index, index)])).abs() < 1e-6, "{index}");
    }
}

/// A touch that nothing checks is always said to be one.
#[test]
fn unchecked_touches_are_told() {
    let fixture = support::fixture("cube", &support::settings("cube")[0]);
    for seed in 0..50 {
        let mut rng = generator(seed, 3);
        let truth = random_frame(100.0, &mut rng);
        // One touch on the third face: nothing else tells how far out it is. On each of the others there is one to spare.
        let layout = random_layout(&*fixture, &[4, 0, 3, 0, 1, 0], &mut rng);
        let touches = simulate(&*fixture, &layout, &truth, &PROBE, SIGMA, &mut rng);
        let told = reliability(&*fixture, &touches, &truth);
        for (touch, checked) in touches.iter().zip(&told.observations) {
            assert_eq!(checked.check.is_none(), touch.surface == 4, "{seed}");
            assert_eq!(checked.undetected_shift().is_none(), touch.surface == 4, "{seed}");
        }
    }
    // Six touches check nothing.
    let layout = random_layout(&*fixture, &[3, 0, 2, 0, 1, 0], &mut generator(4, 4));
    let touches = simulate(&*fixture, &layout, &Frame::identity(), &PROBE, SIGMA, &mut generator(5, 5));
    assert!(
        reliability(&*fixture, &touches, &Frame::identity()).observations.iter().all(|o| o.check.is_none())
    );
}

/// The frame moves as told when a touch errs, and when it is left out.
#[test]
fn shifts_are_those_of_solving_again() {
    /// Second-order terms: errors of some 0.1 over radii of some 20.
    const NEAR: f64 = 0.02;
    let fixture = support::cylinder_plane(20.0, 45.0);
    let mut rng = generator(6, 6);
    let truth = random_frame(100.0, &mut rng);
    let layout = random_layout(&*fixture, &[6, 5], &mut rng);
    let touches = simulate(&*fixture, &layout, &truth, &PROBE, SIGMA, &mut rng);
    let told = reliability(&*fixture, &touches, &truth);
    let problem = Problem::new(&*fixture, &touches, PROBE).unwrap();
    let frame = refined(&problem, &truth);
    for (index, checked) in told.observations.iter().enumerate() {
        assert_eq!(checked.observation, Observation::Touch(index));
        let check = checked.check.as_ref().unwrap();
        let mut erring = touches.clone();
        erring[index].at +=
            frame.rotation * problem.contact(&frame, index).normal * check.smallest_detectable;
        let found = refined(&Problem::new(&*fixture, &erring, PROBE).unwrap(), &frame);
        let (seen, expected) = (frame.error_to(&found), checked.undetected_shift().unwrap());
        assert!((seen - expected).norm() < NEAR * expected.norm(), "{index}: {seen} {expected}");

        let mut rest = touches.clone();
        rest.remove(index);
        let found = refined(&Problem::new(&*fixture, &rest, PROBE).unwrap(), &frame);
        let (seen, expected) = (frame.error_to(&found), checked.shift_without().unwrap());
        assert!((seen - expected).norm() < NEAR * expected.norm(), "{index}: {seen} {expected}");
    }
}

/// An error of the smallest detectable size is noticed as often as the power says, sound touches as rarely as alpha, and
/// another touch has the larger test value as often as told.
#[test]
fn errors_are_noticed_with_the_power_stated() {
    let trials = trials(3000);
    let cases: [(&str, &[usize]); 3] =
        [("cylinder-plane", &[5, 4]), ("three-sphere", &[4, 4, 4]), ("cube", &[3, 0, 3, 0, 3, 0])];
    for (kind, counts) in cases {
        let fixture = support::fixture(kind, &support::settings(kind)[0]);
        let mut rng = generator(7, 7);
        let layout = random_layout(&*fixture, counts, &mut rng);
        let truth = random_frame(100.0, &mut rng);
        let exact = simulate(&*fixture, &layout, &truth, &PROBE, 0.0, &mut rng);
        let planned = reliability(&*fixture, &exact, &truth);
        // The best checked touch and the worst: errors of a worse one are no longer small.
        let mut order: Vec<usize> =
            (0..exact.len()).filter(|k| planned.observations[*k].redundancy > 0.02).collect();
        order.sort_by(|a, b| {
            planned.observations[*a].redundancy.total_cmp(&planned.observations[*b].redundancy)
        });
        for bad in [order[0], order[order.len() - 1]] {
            let check = planned.observations[bad].check.as_ref().unwrap();
            let one = |trial: u64| {
                let mut rng = generator(8, trial);
                let mut touches = simulate(&*fixture, &layout, &truth, &PROBE, SIGMA, &mut rng);
                let problem = Problem::new(&*fixture, &exact, PROBE).unwrap();
                touches[bad].at +=
                    truth.rotation * problem.contact(&truth, bad).normal * check.smallest_detectable;
                let told = reliability(&*fixture, &touches, &truth);
                let value = |index: usize| told.observations[index].check.as_ref().unwrap().test_value.abs();
                let confused =
                    check.confusions.first().is_some_and(|likeliest| value(likeliest.with) > value(bad));
                [value(bad) > told.test.critical_value(), confused]
            };
            let all: Vec<[bool; 2]> = (0..trials).into_par_iter().map(one).collect();
            let share = |k: usize| all.iter().filter(|of| of[k]).count() as f64 / trials as f64;
            let confused = check.confusions.first().map_or(0.0, |likeliest| likeliest.chance);
            println!("{kind}, touch {bad}: power {:.4}, confused {:.4} of {confused:.4}", share(0), share(1));
            let allowed = |p: f64| (5.0 * (p * (1.0 - p) / trials as f64).sqrt()).max(0.01);
            assert!((share(0) - 0.80).abs() < allowed(0.80), "{kind} {bad}: {}", share(0));
            assert!((share(1) - confused).abs() < allowed(confused), "{kind} {bad}: {}", share(1));
        }
    }
}

#[test]
fn without_a_sigma_no_error_is_large() {
    let (fixture, layout) = published();
    let probe = Probe { sigma: None, ..PROBE };
    let touches = simulate(&*fixture, &layout, &Frame::identity(), &probe, SIGMA, &mut generator(1, 1));
    let problem = Problem::new(&*fixture, &touches, probe).unwrap();
    let told = Reliability::of(&problem, &Frame::identity(), Test::default());
    assert_eq!(told, Err(ReliabilityError::NoSigma));
}
