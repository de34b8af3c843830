//! Uncertainties told to first order, against the scatter of simulated measurements.
//!
//! Figures are measured on a few thousand measurements.
//! `TRIALS=100000 cargo test --release --test uncertainty -- --nocapture` measures them on more.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;
use support::{refined, trials};
use touchref::{
    Fixture, Frame, Probe, Problem, Touch, Unknown,
    analysis::{
        Study, StudyLayout, Uncertainty, UncertaintyError,
        propagation::{Interval, MonteCarlo, Trials, Validation},
        simulation::{Layout, generator, random_frame, random_layout, simulate},
        uncertainty::{Draws, Source},
    },
    registry,
};

/// Standard deviation of a touch: 1e-4 of the sizes, so that second-order terms are as small a part.
const SIGMA: f64 = 0.005;
const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.004, sigma: Some(SIGMA) };
/// Standard deviations of what is measured that a figure may be off: one figure of a million is.
const MOST_OFF: f64 = 5.0;

/// Places at which frames are used: on the fixture, and half a metre away.
fn points() -> [Point3<f64>; 3] {
    [Point3::origin(), Point3::new(500.0, 0.0, 0.0), Point3::new(-100.0, 300.0, 200.0)]
}

/// Touches of one noise, tip and sizes that are common to all: predicted and simulated standard deviation at points of use.
#[test]
fn points_scatter_as_predicted() {
    let registry = registry().unwrap();
    let trials = trials(4000);
    for kind in ["cylinder-plane", "three-sphere", "cube", "composite"] {
        let plugin = registry.fixture(kind).unwrap();
        let fixture = plugin.build(&support::uncertain(kind)).unwrap();
        let solver = support::solver("least-squares");
        let layout = StudyLayout::Fixed(fixture.nominal_layout());
        let study = Study {
            fixture: &*fixture,
            plugin,
            solver: &*solver,
            layout,
            probe: PROBE,
            reach: 100.0,
            seed: 31,
            trials,
        };
        let predicted = {
            let (touches, truth) = study.measurement(0).unwrap();
            let problem = Problem::new(&*fixture, &touches, PROBE).unwrap();
            let uncertainty = Uncertainty::of(&problem, &refined(&problem, &truth)).unwrap();
            // Every trial has its own frame: compare along the fixture's axes.
            let turn = uncertainty.frame().rotation.inverse();
            points().map(|point| turn * uncertainty.of_point(&point).0 * turn.inverse())
        };
        let errors = |trial| {
            let (touches, truth) = study.measurement(trial).unwrap();
            let problem = Problem::new(&*fixture, &touches, PROBE).unwrap();
            let found = refined(&problem, &truth);
            points()
                .map(|point| truth.rotation.inverse() * (found.to_parent(&point) - truth.to_parent(&point)))
        };
        let errors: Vec<[Vector3<f64>; 3]> = (0..trials).into_par_iter().map(errors).collect();
        for (k, covariance) in predicted.iter().enumerate() {
            let squares: Matrix3<f64> = errors.iter().map(|of| of[k] * of[k].transpose()).sum();
            let seen = squares / trials as f64;
            let worst = covariance
                .symmetric_eigen()
                .eigenvectors
                .column(covariance.symmetric_eigen().eigenvalues.imax())
                .into_owned();
            for direction in [Vector3::x(), Vector3::y(), Vector3::z(), worst] {
                let [of_seen, of_predicted] =
                    [seen, *covariance].map(|c| direction.dot(&(c * direction)).sqrt());
                let ratio = of_predicted / of_seen;
                println!(
                    "{kind}, {:?} along {:.2?}: predicted {of_predicted:.6}, ratio {ratio:.4}",
                    points()[k],
                    direction.as_slice()
                );
                let allowed = MOST_OFF / (2.0 * trials as f64).sqrt();
                assert!((ratio - 1.0).abs() < allowed.max(0.01), "{kind} {k}: {ratio}");
                // At full size within one percent.
                assert!(trials < 100_000 || (ratio - 1.0).abs() < 0.01, "{kind} {k}: {ratio}");
            }
        }
    }
}

/// A sigma from the residuals: Student's factor makes intervals cover as stated, however few degrees of freedom.
#[test]
fn expanded_uncertainties_cover_as_stated() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let probe = Probe { sigma: None, tip_radius_u: 0.0, ..PROBE };
    let trials = trials(5000);
    for (degrees, counts) in [(1, [4, 3]), (2, [5, 3]), (5, [7, 4]), (20, [14, 12])] {
        let layout = random_layout(&*fixture, &counts, &mut generator(77, degrees));
        let covered = |trial: u64| {
            let mut rng = generator(78 + degrees, trial);
            let truth = random_frame(100.0, &mut rng);
            let touches = simulate(&*fixture, &layout, &truth, &probe, SIGMA, &mut rng);
            let problem = Problem::new(&*fixture, &touches, probe).unwrap();
            let found = refined(&problem, &truth);
            let uncertainty = Uncertainty::of(&problem, &found).unwrap();
            assert_eq!(uncertainty.degrees_of_freedom(), usize::try_from(degrees).ok());
            let factor = uncertainty.coverage_factor(0.95);
            let point = points()[1];
            // Along the fixture's X axis, and along the worst direction: that is the layout's, not the noise's.
            let spread = uncertainty.of_point(&point);
            let error = found.to_parent(&point) - truth.to_parent(&point);
            [found.rotation * Vector3::x(), spread.worst().1]
                .map(|direction| error.dot(&direction).abs() <= factor * spread.along(&direction))
        };
        let all: Vec<[bool; 2]> = (0..trials).into_par_iter().map(covered).collect();
        for k in 0..2 {
            let share = all.iter().filter(|of| of[k]).count() as f64 / trials as f64;
            println!("{degrees} degrees of freedom: {share:.4} covered");
            let allowed = (MOST_OFF * (0.05 * 0.95 / trials as f64).sqrt()).max(0.005);
            assert!((share - 0.95).abs() < allowed, "{degrees}: {share}");
        }
    }
}

/// Draws of all that is uncertain agree with what is told to first order; where noise bends the distances they do not.
#[test]
fn draws_validate_first_order_where_it_is_true() {
    let registry = registry().unwrap();
    for (kind, sigma, valid) in [
        ("cylinder-plane", SIGMA, true),
        ("three-sphere", SIGMA, true),
        ("cube", SIGMA, true),
        ("composite", SIGMA, true),
        ("three-sphere", 60.0 * SIGMA, false),
    ] {
        let plugin = registry.fixture(kind).unwrap();
        let fixture = plugin.build(&support::uncertain(kind)).unwrap();
        let probe = Probe { sigma: Some(sigma), ..PROBE };
        let truth = random_frame(100.0, &mut generator(51, 1));
        let layout = fixture.nominal_layout();
        let touches = simulate(&*fixture, &layout, &truth, &probe, sigma, &mut generator(51, 2));
        let problem = Problem::new(&*fixture, &touches, probe).unwrap();
        let frame = refined(&problem, &truth);
        let uncertainty = Uncertainty::of(&problem, &frame).unwrap();
        let points = points();
        let estimator = |problem: &Problem<'_>, near: &Frame| Some(refined(problem, near));
        let draws = Draws {
            problem: &problem,
            plugin,
            frame: &frame,
            points: &points,
            estimator: &estimator,
            of_residuals: None,
        };
        let trials = Trials::Adaptive { most: 100_000 };
        let method =
            MonteCarlo { probability: 0.95, digits: 1, seed: 6, trials, interval: Interval::Symmetric };
        let drawn = method.run(draws.outputs(), &|rng, row| draws.draw(rng, row), &|_| ()).unwrap();
        assert_eq!(drawn.failed, 0);
        let told = points.iter().map(|point| uncertainty.of_point(point)).chain([uncertainty.of_turn()]);
        let mut all = true;
        for (u, output) in told.flat_map(|spread| spread.along_axes()).zip(&drawn.outputs) {
            let half = uncertainty.coverage_factor(0.95) * u;
            all &= Validation::new([-half, half], [output.low, output.high], u, 1).unwrap().validated();
        }
        assert_eq!(all, valid, "{kind}, sigma {sigma}");
    }
}

/// A sigma that five residuals tell: draws have Student's distribution, as the first order says.
#[test]
fn draws_know_how_little_residuals_tell() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let probe = Probe { sigma: None, tip_radius_u: 0.0, ..PROBE };
    let layout = random_layout(&*fixture, &[7, 4], &mut generator(61, 0));
    let truth = random_frame(100.0, &mut generator(61, 1));
    let touches = simulate(&*fixture, &layout, &truth, &probe, SIGMA, &mut generator(61, 2));
    let problem = Problem::new(&*fixture, &touches, probe).unwrap();
    let frame = refined(&problem, &truth);
    let uncertainty = Uncertainty::of(&problem, &frame).unwrap();
    let registry = registry().unwrap();
    let draws = Draws {
        problem: &problem,
        plugin: registry.fixture("cylinder-plane").unwrap(),
        frame: &frame,
        points: &[Point3::origin()],
        estimator: &|problem, near| Some(refined(problem, near)),
        of_residuals: Some((uncertainty.sigma_of_residuals(), 5)),
    };
    let method = MonteCarlo {
        probability: 0.95,
        digits: 1,
        seed: 7,
        trials: Trials::Fixed(100_000),
        interval: Interval::Symmetric,
    };
    let drawn = method.run(draws.outputs(), &|rng, row| draws.draw(rng, row), &|_| ()).unwrap();
    for (u, output) in uncertainty.of_point(&Point3::origin()).along_axes().into_iter().zip(&drawn.outputs) {
        // Student's distribution with five degrees of freedom has the variance 5/3 and the 97.5 % quantile 2.5706.
        assert!((output.u / u - (5.0_f64 / 3.0).sqrt()).abs() < 0.02, "{} {u}", output.u);
        assert!(
            (output.high / u - 2.5706).abs() < 0.04 && (output.low / u + 2.5706).abs() < 0.04,
            "{}",
            output.high
        );
    }
}

#[test]
fn a_budget_adds_up_and_names_what_matters() {
    for kind in ["cylinder-plane", "three-sphere", "cube", "composite"] {
        let fixture = support::fixture(kind, &support::uncertain(kind));
        let truth = random_frame(100.0, &mut generator(5, 5));
        let touches = exact(&*fixture, &fixture.nominal_layout(), &truth);
        let problem = Problem::new(&*fixture, &touches, PROBE).unwrap();
        let uncertainty = Uncertainty::of(&problem, &truth).unwrap();
        for point in points() {
            let whole = uncertainty.of_point(&point).0;
            let budget = uncertainty.budget_of_point(&point);
            let sum: Matrix3<f64> = budget.iter().map(|part| part.spread.0).sum();
            assert!((sum - whole).abs().max() < 1e-12 * whole.abs().max(), "{kind}");
            assert!(budget.iter().any(|part| part.source == Source::Stated(Unknown::TipRadius)));
        }
        let sum: Matrix3<f64> = uncertainty.budget_of_turn().iter().map(|part| part.spread.0).sum();
        assert!((sum - uncertainty.of_turn().0).abs().max() < 1e-12 * sum.abs().max(), "{kind}");
    }
    // A cube touched on three faces stands off by the tip's error along each: nothing averages that.
    let fixture = support::fixture("cube", &support::settings("cube")[0]);
    let touches = exact(&*fixture, &fixture.nominal_layout(), &Frame::identity());
    let problem = Problem::new(&*fixture, &touches, PROBE).unwrap();
    let uncertainty = Uncertainty::of(&problem, &Frame::identity()).unwrap();
    let budget = uncertainty.budget_of_point(&Point3::new(-25.0, -25.0, -25.0));
    let tip = budget.iter().find(|part| part.source == Source::Stated(Unknown::TipRadius)).unwrap();
    for u in tip.spread.along_axes() {
        assert!((u - PROBE.tip_radius_u).abs() < 1e-12, "{u}");
    }
}

/// Touches without noise.
fn exact(fixture: &dyn Fixture, layout: &Layout, frame: &Frame) -> Vec<Touch> {
    simulate(fixture, layout, frame, &PROBE, 0.0, &mut generator(0, 0))
}

#[test]
fn without_sigma_and_redundancy_there_is_none() {
    let fixture = support::fixture("cube", &support::settings("cube")[0]);
    let probe = Probe { sigma: None, ..PROBE };
    let six: Layout = random_layout(&*fixture, &[3, 0, 2, 0, 1, 0], &mut generator(9, 9));
    let touches = exact(&*fixture, &six, &Frame::identity());
    let problem = Problem::new(&*fixture, &touches, probe).unwrap();
    assert_eq!(Uncertainty::of(&problem, &Frame::identity()), Err(UncertaintyError::NoSigma));
    let five = Problem::new(&*fixture, &touches[..5], PROBE).unwrap();
    assert_eq!(Uncertainty::of(&five, &Frame::identity()), Err(UncertaintyError::Degenerate));
}
