//! Frames of many measurements at once: the solver's own, or none.

#![allow(clippy::unwrap_used)] // A test may panic.

use nalgebra::{Point3, Vector6};
use rand::{RngExt, seq::SliceRandom};
use touchref::{
    Certain, Fixture, Parameters, Probe, Problem, Solution, Together, Touch,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
};

mod support;

const SEED: u64 = 20_261_207;
/// In standard deviations, and of covariance, misfit and condition: what is promised.
const SAME: f64 = 1e-6;

fn probe(sigma: f64) -> Probe {
    Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(sigma) }
}

fn fixture(parameters: &Parameters) -> Box<dyn Fixture> {
    support::fixture("cylinder-plane", parameters)
}

fn pin(angle_deg: f64) -> Parameters {
    Parameters::new().with("radius", 20.0).with("angle_deg", angle_deg)
}

fn together(fixture: &dyn Fixture, probe: &Probe) -> Box<dyn Together> {
    fixture.together(probe, &support::solver("least-squares").rule().unwrap()).unwrap()
}

fn located(together: &dyn Together, measurements: &[Vec<Touch>]) -> Vec<Option<Certain>> {
    let touches: Vec<Point3<f64>> = measurements.iter().flatten().map(|touch| touch.at).collect();
    let mut found = vec![None; measurements.len()];
    let mut last = None;
    together.locate(&touches, &mut |index, certain| {
        assert!(last < Some(index), "in order, each once");
        last = Some(index);
        found[index] = Some(*certain);
    });
    found
}

fn simulated(fixture: &dyn Fixture, sigma: f64, random: bool, seed: u64, count: u64) -> Vec<Vec<Touch>> {
    let one = |trial| {
        let mut rng = generator(seed, trial);
        let layout =
            if random { random_layout(fixture, &[4, 3], &mut rng) } else { fixture.nominal_layout() };
        simulate(fixture, &layout, &random_frame(1000.0, &mut rng), &probe(sigma), sigma, &mut rng)
    };
    (0..count).map(one).collect()
}

/// How far one account of a measurement is from another: the frame in standard deviations, the rest in parts.
fn differences(solution: &Solution, certain: &Certain) -> [f64; 4] {
    let covariance = solution.covariance.as_ref().unwrap().matrix;
    let error: Vector6<f64> = solution.frame.error_to(&certain.frame);
    [
        covariance.cholesky().unwrap().solve(&error).dot(&error).sqrt(),
        // Of each element against the standard deviations of its row and column.
        (0..36)
            .map(|k| (k / 6, k % 6))
            .map(|(i, j)| {
                (certain.covariance[(i, j)] - covariance[(i, j)]).abs()
                    / (covariance[(i, i)] * covariance[(j, j)]).sqrt()
            })
            .fold(0.0, f64::max),
        (solution.chi_square.unwrap() - certain.chi_square).abs(),
        (certain.condition / solution.observability.condition - 1.0).abs(),
    ]
}

/// Asserts that the solver accepts every measurement that is certain, with the same numbers; how many these are.
fn compare(what: &str, fixture: &dyn Fixture, sigma: f64, measurements: &[Vec<Touch>]) -> usize {
    let (probe, solver) = (probe(sigma), support::solver("least-squares"));
    let found = located(&*together(fixture, &probe), measurements);
    for (touches, certain) in measurements.iter().zip(&found) {
        let Some(certain) = certain else { continue };
        let alone = solver.solve(&Problem::new(fixture, touches, probe).unwrap());
        let solution = alone.unwrap_or_else(|error| panic!("{what}: {certain:?}, but {error}"));
        let differences = differences(&solution, certain);
        assert!(differences.iter().all(|difference| *difference < SAME), "{what}: {differences:?}");
        assert_eq!(certain.degrees_of_freedom, solution.degrees_of_freedom);
        let warnings: Vec<&str> = solution.warnings.iter().map(|warning| warning.code).collect();
        assert_eq!(certain.warnings, warnings, "{what}");
    }
    found.iter().flatten().count()
}

#[test]
fn nominal_measurements_are_certain_and_the_solvers() {
    /// Of those that the solver accepts.
    const MOST: f64 = 0.99;
    const COUNT: u64 = 1500;
    let fixtures = [
        pin(45.0),
        pin(30.0).with("bore", true),
        pin(60.0).with("cylinder_side", "front"),
        pin(20.0).with("bore", true).with("cylinder_side", "front"),
    ];
    for (case, parameters) in fixtures.into_iter().enumerate() {
        let fixture = fixture(&parameters);
        for sigma in [0.002, 0.02] {
            let measurements = simulated(&*fixture, sigma, false, SEED + case as u64, COUNT);
            let certain = compare(&format!("case {case}, sigma {sigma}"), &*fixture, sigma, &measurements);
            assert!(certain as f64 > MOST * COUNT as f64, "case {case}, sigma {sigma}: {certain} of {COUNT}");
        }
    }
}

#[test]
fn random_layouts_are_certain_only_where_the_solver_accepts() {
    let fixture = fixture(&pin(45.0));
    for (sigma, least) in [(0.0005, 1000), (0.005, 300), (0.05, 0)] {
        let measurements = simulated(&*fixture, sigma, true, SEED, 2000);
        let certain = compare(&format!("random, sigma {sigma}"), &*fixture, sigma, &measurements);
        assert!(certain > least, "{sigma}: {certain}");
    }
}

/// What is done to the touches of a measurement, and by how much of it.
type Harm = fn(&mut Vec<Touch>, f64);

/// What must not pass for plain: each kind of harm to measurements that were.
#[test]
fn nothing_that_is_harmed_is_certain_unless_the_solver_accepts_it() {
    const SIGMA: f64 = 0.005;
    let fixture = fixture(&pin(45.0));
    let harms: [(&str, bool, Harm); 10] = [
        ("a touch off by 10 to 100 sigmas", false, |touches, by| {
            touches[2].at.x += SIGMA * (10.0 + 90.0 * by);
        }),
        ("a cylinder's and a plane's touch exchanged", true, |touches, _| {
            let (a, b) = touches.split_at_mut(4);
            std::mem::swap(&mut a[1].at, &mut b[1].at);
        }),
        ("in inches", true, |touches, _| touches.iter_mut().for_each(|touch| touch.at.coords /= 25.4)),
        ("in metres", true, |touches, _| touches.iter_mut().for_each(|touch| touch.at.coords /= 1000.0)),
        ("one not a number", true, |touches, _| touches[6].at.z = f64::NAN),
        ("one infinite", true, |touches, _| touches[0].at.y = f64::INFINITY),
        ("two on the cylinder coincide", true, |touches, _| touches[3].at = touches[1].at),
        ("two on the plane coincide", true, |touches, _| touches[5].at = touches[4].at),
        ("mirrored", false, |touches, _| touches.iter_mut().for_each(|touch| touch.at.x = -touch.at.x)),
        ("all at one place", true, |touches, by| {
            for touch in touches {
                touch.at = Point3::new(by, 0.0, 0.0);
            }
        }),
    ];
    for (what, never, harm) in harms {
        let mut measurements = simulated(&*fixture, SIGMA, false, SEED, 400);
        for (trial, touches) in (0..).zip(&mut measurements) {
            harm(touches, generator(SEED + 1, trial).random());
        }
        let certain = compare_harmed(what, &*fixture, SIGMA, &measurements);
        assert!(!never || certain == 0, "{what}: {certain}");
    }
}

/// As [`compare`], for touches that may not even make a problem.
fn compare_harmed(what: &str, fixture: &dyn Fixture, sigma: f64, measurements: &[Vec<Touch>]) -> usize {
    if measurements.iter().flatten().all(|touch| touch.at.iter().all(|x| x.is_finite())) {
        return compare(what, fixture, sigma, measurements);
    }
    located(&*together(fixture, &probe(sigma)), measurements).iter().flatten().count()
}

/// Four touches a quarter of a turn apart, low, high, low, high, are singular; five degrees off they nearly are.
#[test]
fn nearly_singular_layouts_are_certain_only_where_the_solver_accepts() {
    const SIGMA: f64 = 0.001;
    let fixture = fixture(&pin(45.0));
    let mut certain = 0;
    for turn in [0.0, 1e-6, 1e-4, 1e-3, 0.01, 0.05, 0.1] {
        let mut layout = fixture.nominal_layout();
        for (k, (surface, at)) in layout.iter_mut().take(4).enumerate() {
            let place = 0.1 + 0.25 * k as f64 + if k == 2 { turn } else { 0.0 };
            *at = fixture.surfaces()[*surface].point_at(place, (k % 2) as f64);
        }
        let one = |trial| {
            let mut rng = generator(SEED + 2, trial);
            simulate(&*fixture, &layout, &random_frame(1000.0, &mut rng), &probe(SIGMA), SIGMA, &mut rng)
        };
        let measurements: Vec<_> = (0..200).map(one).collect();
        let here = compare(&format!("{turn} off singular"), &*fixture, SIGMA, &measurements);
        assert!(turn > 1e-3 || here == 0, "{turn}: {here}");
        certain += here;
    }
    assert!(certain > 0);
}

#[test]
fn a_frame_does_not_depend_on_those_beside_it() {
    const SIGMA: f64 = 0.005;
    let fixture = fixture(&pin(45.0));
    let together = together(&*fixture, &probe(SIGMA));
    let mut measurements = simulated(&*fixture, SIGMA, false, SEED + 3, 130);
    measurements.extend(simulated(&*fixture, SIGMA, true, SEED + 3, 130));
    let whole = located(&*together, &measurements);
    let mut order: Vec<usize> = (0..measurements.len()).collect();
    for trial in 0..5 {
        order.shuffle(&mut generator(SEED + 4, trial));
        let shuffled: Vec<Vec<Touch>> = order.iter().map(|index| measurements[*index].clone()).collect();
        for (found, index) in located(&*together, &shuffled).iter().zip(&order) {
            assert_eq!(found, &whole[*index], "measurement {index}");
        }
    }
    for (touches, expected) in measurements.iter().zip(&whole) {
        assert_eq!(&located(&*together, std::slice::from_ref(touches))[0], expected);
    }
}

/// Frames follow the parent, the unit and, to rounding, the order of the touches.
#[test]
fn frames_follow_parent_unit_and_order() {
    const SIGMA: f64 = 0.005;
    const INCH: f64 = 25.4;
    let fixture = fixture(&pin(45.0));
    let inches = self::fixture(&Parameters::new().with("radius", 20.0 / INCH));
    let solver = support::solver("least-squares");
    let in_inches = Probe { tip_radius: 1.5 / INCH, tip_radius_u: 0.0, sigma: Some(SIGMA / INCH) };
    let measurements = simulated(&*fixture, SIGMA, false, SEED + 5, 200);
    let whole = located(&*together(&*fixture, &probe(SIGMA)), &measurements);
    let changed = |change: &dyn Fn(&mut Vec<Touch>)| {
        let mut all = measurements.clone();
        all.iter_mut().for_each(change);
        all
    };
    let reordered = changed(&|touches| {
        touches[..4].reverse();
        touches[4..].rotate_left(1);
    });
    let scaled = changed(&|touches| touches.iter_mut().for_each(|touch| touch.at.coords /= INCH));
    let motion = random_frame(500.0, &mut generator(SEED + 6, 0));
    let moved =
        changed(&|touches| touches.iter_mut().for_each(|touch| touch.at = motion.to_parent(&touch.at)));
    let by_order = located(&*together(&*fixture, &probe(SIGMA)), &reordered);
    let by_motion = located(&*together(&*fixture, &probe(SIGMA)), &moved);
    let by_unit = located(&*inches.together(&in_inches, &solver.rule().unwrap()).unwrap(), &scaled);
    for (k, certain) in whole.iter().enumerate() {
        let Some(certain) = certain else { continue };
        let deviations = |frame: &touchref::Frame| {
            let error: Vector6<f64> = certain.frame.error_to(frame);
            certain.covariance.cholesky().unwrap().solve(&error).dot(&error).sqrt()
        };
        assert!(deviations(&by_order[k].unwrap().frame) < SAME);
        let mut unscaled = by_unit[k].unwrap().frame;
        unscaled.origin.coords *= INCH;
        assert!(deviations(&unscaled) < SAME);
        let frame = by_motion[k].unwrap().frame;
        let back = touchref::Frame {
            rotation: motion.rotation.inverse() * frame.rotation,
            origin: motion.to_fixture(&frame.origin),
        };
        assert!(deviations(&back) < SAME);
    }
}

/// What is uncertain, or has no sigma, is left to a solver.
#[test]
fn what_is_uncertain_is_left_to_a_solver() {
    let rule = support::solver("least-squares").rule().unwrap();
    let fixture = fixture(&pin(45.0));
    assert!(fixture.together(&Probe { sigma: None, ..probe(0.01) }, &rule).is_none());
    assert!(fixture.together(&Probe { tip_radius_u: 0.001, ..probe(0.01) }, &rule).is_none());
    let uncertain =
        self::fixture(&pin(45.0).with("radius", touchref::Value::Number { value: 20.0, u: 0.002 }));
    assert!(uncertain.together(&probe(0.01), &rule).is_none());
    assert!(support::solver("closed-form").rule().is_none() && support::solver("robust").rule().is_none());
}
