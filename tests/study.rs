//! Studies vary in truth all that is stated as uncertain, tell a solver that is wrong, and count every trial once.

#![allow(clippy::unwrap_used)] // A test may panic.

mod support;

use nalgebra::{Matrix3, Matrix6, Point3, Vector3};
use touchref::{
    Covariance, Fixture, FixturePlugin, Frame, Limit, Noise, Observability, Parameters, Probe, Problem,
    SigmaSource, Solution, SolveError, Solver, Touch, TouchError, Trust, Value,
    analysis::{Study, StudyError, StudyLayout, StudyOutcome},
    fixtures::cylinder_plane::PLUGIN,
};

const SIGMA: f64 = 0.01;
const CYLINDER: usize = 0;
const PLANE: usize = 1;

fn uncertain(value: f64, u: f64) -> Value {
    Value::Number { value, u }
}

/// `cylinder-plane` of radius 20 and 45 degrees with these standard uncertainties.
fn fixture(radius_u: f64, angle_u_deg: f64) -> Box<dyn Fixture> {
    let parameters = Parameters::new()
        .with("radius", uncertain(20.0, radius_u))
        .with("angle_deg", uncertain(45.0, angle_u_deg));
    PLUGIN.build(&parameters).unwrap()
}

fn probe(tip_radius_u: f64, sigma: f64) -> Probe {
    Probe { tip_radius: 1.5, tip_radius_u, sigma: Some(sigma) }
}

/// A study of the nominal layout.
fn study<'a>(fixture: &'a dyn Fixture, solver: &'a dyn Solver, probe: Probe, trials: u64) -> Study<'a> {
    let layout = StudyLayout::Fixed(fixture.nominal_layout());
    Study { fixture, plugin: &PLUGIN, solver, layout, probe, reach: 100.0, seed: 81, trials }
}

/// Mean and standard deviation.
fn moments(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    (mean, (squares / values.len() as f64).sqrt())
}

/// Within five of its own standard deviations: of `count` normal values of standard deviation `expected`.
fn assert_deviation(values: &[f64], expected: f64) {
    let (_, deviation) = moments(values);
    let own = expected / (2.0 * values.len() as f64).sqrt();
    assert!((deviation - expected).abs() < 5.0 * own, "{deviation}, expected {expected} +- {own}");
}

#[test]
fn the_truth_varies_as_the_fixture_and_the_probe_state() {
    let (radius_u, tip_u, angle_u_deg) = (0.03, 0.04, 0.2);
    let (fixture, solver) = (fixture(radius_u, angle_u_deg), support::solver("closed-form"));
    // Touches that are next to exact show the true dimensions.
    let study = study(&*fixture, &*solver, probe(tip_u, 1e-7), 0);
    let (mut radii, mut angles) = (Vec::new(), Vec::new());
    for trial in 0..3000 {
        let (touches, truth) = study.measurement(trial).unwrap();
        let at = |index: usize| truth.to_fixture(&touches[index].at);
        assert_eq!((touches[0].surface, touches[4].surface), (CYLINDER, PLANE));
        radii.push(at(0).x.hypot(at(0).y));
        let normal = (at(5) - at(4)).cross(&(at(6) - at(4)));
        angles.push((normal.z.abs() / normal.norm()).acos().to_degrees());
    }
    assert_deviation(&radii, f64::hypot(radius_u, tip_u));
    assert_deviation(&angles, angle_u_deg);
    assert!((moments(&radii).0 - 21.5).abs() < 0.005 && (moments(&angles).0 - 45.0).abs() < 0.02);
}

/// Enough for a standard uncertainty of the NEES of 0.11: one direction less would be nine of them.
const TRIALS: u64 = 1000;

fn assert_true_covariance(outcome: &StudyOutcome) {
    assert_eq!(outcome.wrong, 0);
    assert!(outcome.accepted as f64 > 0.9 * outcome.trials as f64, "{outcome:?}");
    let (nees, coverage) = (outcome.nees_mean().unwrap(), outcome.coverage_95().unwrap());
    // Four standard deviations, and the noise that the acceptance itself cuts off.
    assert!((nees.value - 6.0).abs() < 4.0 * nees.u + 0.05, "{nees:.3}");
    assert!((coverage.value - 0.95).abs() < 4.0 * coverage.u + 0.002, "{coverage:.4}");
}

#[test]
fn uncertain_sizes_leave_the_covariance_true() {
    let solver = support::solver("closed-form");
    let none = probe(0.0, SIGMA);
    for (fixture, probe) in [
        (fixture(0.05, 0.0), none),
        (fixture(0.0, 0.1), none),
        (fixture(0.0, 0.0), probe(0.05, SIGMA)),
        (fixture(0.02, 0.03), probe(0.02, SIGMA)),
    ] {
        assert_true_covariance(&study(&*fixture, &*solver, probe, TRIALS).run().unwrap());
    }
}

#[test]
fn a_truth_that_does_not_vary_would_be_noticed() {
    static STIFF: FixturePlugin =
        FixturePlugin { build: |_| PLUGIN.build(&Parameters::new().with("radius", 20.0)), ..PLUGIN };
    let (fixture, solver) = (fixture(0.0, 0.1), support::solver("closed-form"));
    let study = Study { plugin: &STIFF, ..study(&*fixture, &*solver, probe(0.0, SIGMA), 500) };
    let nees = study.run().unwrap().nees_mean().unwrap();
    // The angle's uncertainty is one of the six that the covariance counts.
    assert!(nees.value < 5.5, "{nees:.3}");
}

/// Touches of a fixture at `frame` without noise, each with a noise and an approach of its own.
fn measured(fixture: &dyn Fixture, frame: &Frame, probe: &Probe) -> Vec<Touch> {
    let noises = [
        Noise::Sigma(0.01),
        Noise::Sigma(0.05),
        Noise::Sigma(0.01),
        Noise::Covariance(Matrix3::new(4e-4, 1e-4, 0.0, 1e-4, 1e-4, 0.0, 0.0, 0.0, 9e-4)),
        Noise::Sigma(0.02),
        Noise::Sigma(0.01),
        Noise::Covariance(Matrix3::from_diagonal(&Vector3::new(1e-4, 4e-4, 1e-4))),
    ];
    let touch = |((surface, contact), noise): ((usize, Point3<f64>), Noise)| {
        let surface_normal = fixture.surfaces()[surface].seen_from(&contact).normal;
        let at = frame.to_parent(&(contact + surface_normal * probe.tip_radius));
        Touch { noise, ..Touch::new(surface, at) }.with_approach(frame.rotation * -surface_normal)
    };
    fixture.nominal_layout().into_iter().zip(noises).map(touch).collect()
}

#[test]
fn a_measurement_is_repeated_with_its_own_noise_and_approach() {
    let (fixture, solver) = (fixture(0.0, 0.0), support::solver("closed-form"));
    let probe = Probe { sigma: None, ..probe(0.0, SIGMA) };
    let frame = Frame::from_quaternion_xyzw(Point3::new(7.0, -3.0, 9.0), [0.3, -0.5, 0.1, 0.7]).unwrap();
    let touches = measured(&*fixture, &frame, &probe);
    let layout = StudyLayout::Measured { touches: touches.clone(), frame };
    let study = Study { layout, probe, ..study(&*fixture, &*solver, probe, TRIALS) };
    assert_eq!(study.touches_per_surface(), [4, 3]);

    let mut along_normal = vec![Vec::new(); touches.len()];
    for trial in 0..TRIALS {
        let (simulated, truth) = study.measurement(trial).unwrap();
        for (index, (touch, original)) in simulated.iter().zip(&touches).enumerate() {
            let normal = fixture.surfaces()[touch.surface].seen_from(&frame.to_fixture(&original.at)).normal;
            let moved = truth.to_fixture(&touch.at) - frame.to_fixture(&original.at);
            along_normal[index].push(moved.dot(&normal));
            // The probe came from where it came from, seen from the fixture.
            let approach = truth.rotation.inverse() * touch.approach.unwrap();
            assert!((approach.into_inner() + normal).norm() < 1e-12);
        }
    }
    for (values, original) in along_normal.iter().zip(&touches) {
        let normal = -original.approach.unwrap().into_inner();
        let sigma = match original.noise {
            Noise::Sigma(sigma) => sigma,
            Noise::Covariance(c) => (normal.transpose() * c * normal)[0].sqrt(),
            Noise::OfProbe => panic!("every touch states its own"),
        };
        assert_deviation(values, sigma);
        assert!(moments(values).0.abs() < 5.0 * sigma / (TRIALS as f64).sqrt());
    }
    let rms = touches.iter().map(|touch| match touch.noise {
        Noise::Covariance(c) => c.trace() / 3.0,
        Noise::Sigma(sigma) => sigma * sigma,
        Noise::OfProbe => 0.0,
    });
    let rms = (rms.sum::<f64>() / touches.len() as f64).sqrt();
    assert!((study.sigma().unwrap() - rms).abs() < 1e-15);
    assert_true_covariance(&study.run().unwrap());
}

/// A solver that finds nothing, or always the same frame.
#[derive(Debug)]
struct Blind(Option<Frame>);

impl Solver for Blind {
    fn name(&self) -> &'static str {
        "blind"
    }

    fn solve(&self, problem: &Problem<'_>) -> Result<Solution, SolveError> {
        problem.require_enough()?;
        let Some(frame) = self.0 else {
            return Err(SolveError::NotConverged { iterations: 1, step: 1.0, bound: 0.1 });
        };
        let trust = Trust {
            sigma: Some(SIGMA),
            from_sigma: 0.0,
            up_to_sigma: 1.0,
            limited_by: Limit::None,
            second_minimum: None,
            nonlinearity: None,
        };
        let observability = Observability::at(problem, &Frame::identity());
        let mut solution = Solution::new("blind", frame, Vec::new(), trust, observability);
        let matrix = Matrix6::identity() * 1e-6;
        solution.covariance = Some(Covariance { matrix, sigma: SIGMA, sigma_source: SigmaSource::Given });
        Ok(solution)
    }
}

#[test]
fn every_trial_is_made_once_and_the_threads_do_not_matter() {
    use std::sync::atomic::{AtomicU64, Ordering};
    /// More than are added up at once, and no multiple of anything.
    const MANY: u64 = 70_001;
    let (fixture, solver) = (fixture(0.01, 0.0), Blind(None));
    let study = study(&*fixture, &solver, probe(0.0, SIGMA), MANY);
    let seen = AtomicU64::new(0);
    let count = || {
        seen.fetch_add(1, Ordering::Relaxed);
    };
    let outcome = study.run_with(&count).unwrap();
    assert_eq!((outcome.trials, seen.into_inner()), (MANY, MANY));
    assert_eq!(outcome.refused, [("not-converged", MANY)].into());
    assert_eq!((outcome.accepted, outcome.wrong), (0, 0));
    assert!(outcome.nees_mean().is_none() && outcome.coverage_95().is_none());
    assert!(outcome.rms_over_bound().is_none() && outcome.wrong_at_most().is_none());

    let solver = support::solver("closed-form");
    let layout = StudyLayout::Random(vec![4, 3]);
    let study = Study { solver: &*solver, layout, trials: 700, ..study };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| study.run().unwrap())
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn wrong_frames_are_counted() {
    let (fixture, solver) = (fixture(0.0, 0.0), Blind(Some(Frame::identity())));
    let outcome = study(&*fixture, &solver, probe(0.0, SIGMA), 100).run().unwrap();
    assert_eq!((outcome.accepted, outcome.wrong), (100, 100));
    assert_eq!(outcome.wrong_at_most(), Some(1.0));
    assert!(outcome.coverage_95().unwrap().value <= 0.0);
    // Frames lie some 100 away, uniformly along each axis, and the covariance says 0.001: a squared error of 1e10.
    let nees = outcome.nees_mean().unwrap().value;
    assert!((0.5e10..1.5e10).contains(&nees), "{nees}");

    let nowhere = Frame { origin: Point3::new(f64::NAN, 0.0, 0.0), ..Frame::identity() };
    let solver = Blind(Some(nowhere));
    let outcome = study(&*fixture, &solver, probe(0.0, SIGMA), 100).run().unwrap();
    assert_eq!((outcome.accepted, outcome.wrong), (100, 100));
}

#[test]
fn what_cannot_be_studied_is_told() {
    let (known, solver) = (fixture(0.0, 0.0), Blind(None));
    let study = study(&*known, &solver, probe(0.0, SIGMA), 1000);
    let silent = Study { probe: Probe { sigma: None, ..study.probe }, layout: study.layout.clone(), ..study };
    assert_eq!(silent.run(), Err(StudyError::NoSigma));
    let few = Study { layout: StudyLayout::Random(vec![3, 3]), probe: study.probe, ..silent };
    assert!(matches!(few.run(), Err(StudyError::Unsuitable(SolveError::TooFewTouches { .. }))));
    let none = Study { layout: StudyLayout::Random(vec![0, 0]), ..few };
    assert!(matches!(none.run(), Err(StudyError::Touches(_))));
    let mut beside = known.nominal_layout();
    beside[4].0 = 2;
    let beside = Study { layout: StudyLayout::Fixed(beside), ..none };
    let missing = TouchError::NoSuchSurface { index: 4, surface: 2, surfaces: 2 };
    assert_eq!(beside.run(), Err(StudyError::Touches(missing.clone())));
    assert_eq!(beside.measurement(0), Err(StudyError::Touches(missing)));
    // A radius of 20 +- 10 is negative in one trial of 44, and the first of them is told whatever the threads.
    let vague = fixture(10.0, 0.0);
    let impossible = Study { fixture: &*vague, layout: study.layout.clone(), ..beside };
    let error = impossible.run().unwrap_err();
    let StudyError::Fixture { trial, error: parameter } = &error else { panic!("{error}") };
    assert_eq!(parameter.name, "radius");
    assert!((0..*trial).all(|trial| impossible.measurement(trial).is_ok()));
    assert!(error.to_string().contains("expected length > 0"), "{error}");
}
