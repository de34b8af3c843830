//! Motions between simulated results: false alarms at the stated rate, found as often as theory predicts, and put down to
//! what has moved. `examples/drift_study.rs` is the same with more pairs.
#![allow(clippy::unwrap_used)] // A test may panic.

#[path = "support/pairs.rs"]
mod pairs;
mod support;

use nalgebra::{Point3, Vector3, Vector6};
use pairs::{Found, INDEPENDENT, cases};
use touchref::{
    Fixture, Frame, Probe, Problem, Touch, Twist,
    analysis::{
        drift::{Comparison, Explanation, Hypothesis, Located, Seen, explain},
        simulation::{Layout, generator, simulate},
    },
};

/// The rate is `expected` within four of the standard deviations that it then has.
fn assert_rate(found: &Found, expected: f64, what: &str) {
    let deviation = (expected * (1.0 - expected) / found.pairs as f64).sqrt();
    let off = (found.rate() - expected) / deviation;
    assert!(
        off.abs() < 4.0,
        "{what}: {} of {}, {off:.1} deviations off {expected}",
        found.moved,
        found.pairs
    );
}

/// Pairs of each fixture; composites take longer.
fn trials(name: &str) -> u64 {
    if name == "composite" { 15 } else { 500 }
}

#[test]
fn false_alarms_come_at_the_stated_rate() {
    let solver = support::solver("least-squares");
    let still = Twist::from(Vector6::zeros());
    for case in cases(5) {
        for (name, pairs) in case.kinds(&*solver).iter().filter(|(name, _)| *name != INDEPENDENT) {
            let found = &pairs.found(trials(case.plugin.name), &still, &[0.05])[0];
            // Few pairs are refused.
            assert!(found.pairs as f64 > 0.9 * trials(case.plugin.name) as f64, "{}, {name}", case.name);
            assert_rate(found, 0.05, &format!("{}, {name}", case.name));
        }
    }
}

/// Errors that are common and counted as independent hide motions: the study would notice that they are not common.
#[test]
fn what_is_common_hides_less() {
    let solver = support::solver("least-squares");
    let still = Twist::from(Vector6::zeros());
    let case = &cases(5)[0];
    let kinds = case.kinds(&*solver);
    let (_, independent) = kinds.iter().find(|(name, _)| *name == INDEPENDENT).unwrap();
    let found = &independent.found(600, &still, &[0.05])[0];
    assert!(found.rate() < 0.035, "{found:?}");
}

/// Chance that a squared distance of mean three standard deviations is beyond the level of 5 %: noncentral chi-square,
/// noncentrality 9, by `tests/oracle/noncentral.py`.
const POWER: [(usize, f64); 2] = [(6, 0.589_458_443), (5, 0.623_584_612)];

#[test]
fn three_standard_deviations_are_found_as_often_as_predicted() {
    let solver = support::solver("least-squares");
    for case in cases(6) {
        let pairs = case.exact(&*solver);
        let fixture = case.plugin.build(&case.exact).unwrap();
        let unknowns = 6 - fixture.freedom().count();
        let (_, power) = POWER.into_iter().find(|(degrees, _)| *degrees == unknowns).unwrap();
        for motion in pairs.motions(3.0) {
            let found = &pairs.found(trials(case.plugin.name), &motion, &[0.05])[0];
            assert_rate(found, power, case.name);
        }
    }
}

const SIGMA: f64 = 0.005;
const ALPHA: f64 = 1e-3;

/// Touches and frame of a fixture that is touched at `layout` where it stands, each surface moved on it by `moved`.
fn measured(
    fixture: &dyn Fixture,
    layout: &Layout,
    frame: &Frame,
    moved: impl Fn(usize) -> Twist,
    seed: u64,
) -> (Vec<Touch>, Frame) {
    let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };
    let mut rng = generator(seed, 0);
    let mut touches = simulate(fixture, layout, &Frame::identity(), &probe, SIGMA, &mut rng);
    for touch in &mut touches {
        touch.at = frame.to_parent(&Frame::identity().moved(&moved(touch.surface)).to_parent(&touch.at));
    }
    // Near the truth: what a solver finds where one surface has moved is not asked here.
    let problem = Problem::new(fixture, &touches, probe).unwrap();
    let linear = touchref::analysis::Linear::at(&problem, frame).unwrap();
    let step = (0..touches.len()).fold(Vector6::zeros(), |sum, index| {
        sum - linear.sensitivity(index) * (problem.contact(frame, index).residual / SIGMA)
    });
    let turned = Frame { rotation: frame.rotation.inverse(), ..*frame };
    let along = Twist {
        translation: turned.rotation * step.fixed_rows::<3>(0),
        rotation: turned.rotation * step.fixed_rows::<3>(3),
    };
    (touches, frame.moved(&along))
}

fn explained(
    fixture: &dyn Fixture,
    moved: impl Fn(usize) -> Twist,
    whole: &Twist,
    seed: u64,
) -> Vec<Explanation> {
    // Two rings of four on every surface: each shows all of its own motions.
    let layout: Layout = (0..fixture.surfaces().len())
        .flat_map(|surface| {
            let ring = |v: f64| {
                [0.0, 0.25, 0.5, 0.75]
                    .map(|u| (surface, fixture.surfaces()[surface].point_at(u + 0.1 * v, v)))
            };
            ring(0.1).into_iter().chain(ring(0.9))
        })
        .collect();
    let frame = Frame::from_quaternion_xyzw(Point3::new(100.0, -50.0, 20.0), [0.1, 0.5, -0.3, 0.8]).unwrap();
    let still = |_| Twist::from(Vector6::zeros());
    let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };
    let before = measured(fixture, &layout, &frame, still, seed);
    let after = measured(fixture, &layout, &frame.moved(whole), moved, seed + 1000);
    let seen = |(touches, frame)| Seen { problem: Problem::new(fixture, touches, probe).unwrap(), frame };
    explain(&[seen((&before.0[..], before.1))], &seen((&after.0[..], after.1))).unwrap().unwrap()
}

fn explaining(explanations: &[Explanation]) -> Vec<Hypothesis> {
    explanations.iter().filter(|one| one.p_value >= ALPHA).map(|one| one.hypothesis).collect()
}

/// A motion of all of the fixture, small or large beside the noise, is told as that; a motion of one surface as that.
#[test]
fn what_has_moved_is_named() {
    let still = |_| Twist::from(Vector6::zeros());
    let none = Twist::from(Vector6::zeros());
    for case in cases(1) {
        let fixture = case.plugin.build(&case.exact).unwrap();
        for (seed, scale) in (0..).zip([1.0, 30.0]) {
            let all = Twist {
                translation: Vector3::new(0.05, -0.04, 0.06) * scale,
                rotation: Vector3::new(1e-3, -2e-3, 1e-3) * scale,
            };
            let told = explaining(&explained(&*fixture, still, &all, seed));
            assert_eq!(told, [Hypothesis::Fixture], "{}", case.name);
        }
        for surface in 0..fixture.surfaces().len() {
            // A tilt about Y changes the angle between any two surfaces of which it moves one.
            let normal = fixture.surfaces()[surface].seen_from(&Point3::new(1.0, 2.0, 3.0)).normal;
            let own = Twist { translation: normal * 0.06, rotation: Vector3::y() * 3e-3 };
            let moved = |of: usize| if of == surface { own } else { none };
            let told = explaining(&explained(&*fixture, moved, &none, 20 + surface as u64));
            assert_eq!(told, [Hypothesis::Surface(surface)], "{}", case.name);
        }
    }
}

/// A plane that has moved along its normal looks as the whole fixture does that has moved along the cylinder.
#[test]
fn what_cannot_be_told_apart_is_not_named() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let still = |_| Twist::from(Vector6::zeros());
    let along = Twist { translation: Vector3::z() * 0.1, rotation: Vector3::zeros() };
    let told = explaining(&explained(&*fixture, still, &along, 3));
    assert_eq!(told, [Hypothesis::Fixture, Hypothesis::Surface(1)]);
}

/// If a hypothesis is true, its chi-square is one: mean and spread over many pairs.
#[test]
fn a_true_hypothesis_is_rejected_at_the_stated_rate() {
    const PAIRS: u64 = 400;
    let fixture = support::cylinder_plane(20.0, 45.0);
    let none = Twist::from(Vector6::zeros());
    let tilt = Twist { translation: Vector3::z() * 0.05, rotation: Vector3::x() * 2e-3 };
    let plane = |surface: usize| if surface == 1 { tilt } else { none };
    let all: Vec<Explanation> =
        (0..PAIRS).map(|seed| explained(&*fixture, plane, &none, 2 * PAIRS * seed)[2]).collect();
    assert!(all.iter().all(|one| one.hypothesis == Hypothesis::Surface(1) && one.degrees_of_freedom == 4));
    let mean = all.iter().map(|one| one.chi_square).sum::<f64>() / PAIRS as f64;
    // Variance of chi-square with four degrees of freedom: eight.
    assert!((mean - 4.0).abs() < 4.0 * (8.0 / PAIRS as f64).sqrt(), "{mean}");
    let rejected = all.iter().filter(|one| one.p_value < 0.05).count() as u64;
    assert_rate(&Found { pairs: PAIRS, moved: rejected }, 0.05, "the plane");
}

/// The distance is that of one frame from the other in both covariances: nothing else of the analysis takes part.
#[test]
fn the_distance_of_two_solutions_is_that_in_both_covariances() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let solver = support::solver("least-squares");
    let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };
    let frame = Frame::from_quaternion_xyzw(Point3::new(100.0, -50.0, 20.0), [0.1, 0.5, -0.3, 0.8]).unwrap();
    let solutions = [1, 2].map(|seed| {
        let mut rng = generator(seed, 0);
        let touches = simulate(&*fixture, &fixture.nominal_layout(), &frame, &probe, SIGMA, &mut rng);
        solver.solve(&Problem::new(&*fixture, &touches, probe).unwrap()).unwrap()
    });
    let [a, b] = solutions.map(|one| (one.frame, one.covariance.unwrap().matrix));
    let located = |(frame, covariance)| Located::independent(frame, covariance, None);
    let change = Comparison::of(&*fixture).change(&located(a), &located(b)).unwrap();
    let step = b.0.origin - a.0.origin;
    let turn = nalgebra::Rotation3::from_matrix(&(b.0.rotation.matrix() * a.0.rotation.matrix().transpose()));
    let turn = turn.scaled_axis();
    let difference = Vector6::new(step.x, step.y, step.z, turn.x, turn.y, turn.z);
    let expected = difference.dot(&((a.1 + b.1).try_inverse().unwrap() * difference));
    let ratio = change.significance.squared_distance / expected;
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
    assert_eq!(change.significance.degrees_of_freedom, 6);
}
