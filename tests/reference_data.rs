//! Reference data: touches whose least-squares frame is known for residuals of any size; and the solvers that must find
//! it to rounding.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use nalgebra::{Point3, Vector6};
use rand::{Rng, RngExt};
use rayon::prelude::*;
use touchref::{
    Fixture, Frame, Parameters, Probe, Problem, Solver, Touch, Twist, Unknown,
    analysis::{
        reference::{LEAST_STEEPNESS, Magnitude, NullSpace, ReferenceMeasurement, descend},
        simulation::{Layout, generator, random_frame, random_layout},
    },
    conformance::Claim,
    registry,
};

const TIP_RADIUS: f64 = 1.5;
const PROBE: Probe = Probe { tip_radius: TIP_RADIUS, tip_radius_u: 0.0, sigma: None };

/// One of the alternatives, with one to eight touches more.
fn redundant_layout(fixture: &dyn Fixture, rng: &mut impl Rng) -> Layout {
    let alternatives = &fixture.requirement().alternatives;
    let mut counts = alternatives[rng.random_range(0..alternatives.len())].clone();
    let touched: Vec<usize> = (0..counts.len()).filter(|surface| counts[*surface] > 0).collect();
    for _ in 0..rng.random_range(1..=8) {
        counts[touched[rng.random_range(0..touched.len())]] += 1;
    }
    random_layout(fixture, &counts, rng)
}

fn null_space<'a>(
    fixture: &'a dyn Fixture,
    layout: &'a [(usize, Point3<f64>)],
    magnitude: Magnitude,
) -> NullSpace<'a> {
    NullSpace {
        fixture,
        layout,
        sigmas: &[],
        probe: PROBE,
        frame: random_frame(100.0, &mut generator(90, 0)),
        unknowns: &[],
        magnitude,
    }
}

/// Half the squared misfit, from the surfaces' distances alone.
fn misfit(fixture: &dyn Fixture, touches: &[Touch], sigmas: &[f64], tip_radius: f64, frame: &Frame) -> f64 {
    let squares = touches.iter().enumerate().map(|(index, touch)| {
        let seen = frame.rotation.inverse() * (touch.at - frame.origin);
        let distance = fixture.surfaces()[touch.surface].seen_from(&Point3::from(seen)).distance;
        let sigma = sigmas.get(index).copied().unwrap_or(1.0);
        ((distance - tip_radius) / sigma).powi(2)
    });
    0.5 * squares.sum::<f64>()
}

/// First and second derivative of a function at zero, by differences.
fn derivatives(step: f64, of: impl Fn(f64) -> f64) -> (f64, f64) {
    let (up, here, down) = (of(step), of(0.0), of(-step));
    ((up - down) / (2.0 * step), (up - 2.0 * here + down) / (step * step))
}

/// Along random motions, and with touches that are not equally sure.
#[test]
fn the_design_frame_is_a_minimum() {
    const TRIALS: u64 = 100;
    const MOTIONS: usize = 20;
    /// In parts of the size, of a motion: truncation of the third derivative 1e-10, rounding 1e-16 / step.
    const STEP: f64 = 1e-5;
    /// First derivative beside the second, in parts of the size: what a frame off by this would show.
    const FLAT: f64 = 1e-8;
    for plugin in registry().unwrap().fixtures() {
        let parameters = &support::settings(plugin.name)[0];
        let fixture = plugin.build(parameters).unwrap();
        let (size, mut drawn) = (fixture.size(), 0);
        for trial in 0..TRIALS {
            let mut rng = generator(91, trial);
            let layout = redundant_layout(&*fixture, &mut rng);
            let sigmas: Vec<f64> = layout.iter().map(|_| rng.random_range(0.5..2.0)).collect();
            let magnitude = Magnitude::Largest(0.02 * size);
            let set = NullSpace { sigmas: &sigmas, ..null_space(&*fixture, &layout, magnitude) };
            let Some(ReferenceMeasurement { touches, frame, residuals, .. }) = set.draw(&mut rng) else {
                continue;
            };
            drawn += 1;
            let at_design = misfit(&*fixture, &touches, &sigmas, TIP_RADIUS, &frame);
            let stated = residuals.iter().zip(&sigmas).map(|(r, s)| (r / s).powi(2)).sum::<f64>();
            assert!((at_design / (0.5 * stated) - 1.0).abs() < 1e-9, "{}: the residuals", plugin.name);
            for _ in 0..MOTIONS {
                let along =
                    Vector6::from_fn(|k, _| rng.random_range(-1.0..1.0) * if k < 3 { size } else { 1.0 });
                let (first, second) = derivatives(STEP, |by| {
                    let there = frame.moved(&Twist::from(along * by));
                    misfit(&*fixture, &touches, &sigmas, TIP_RADIUS, &there)
                });
                assert!(second > 0.0, "{}, trial {trial}: second derivative {second}", plugin.name);
                let off = (first / second).abs();
                assert!(off < FLAT, "{}, trial {trial}: a minimum {off:e} away", plugin.name);
            }
        }
        assert!(drawn > TRIALS / 2, "{}: {drawn} of {TRIALS}", plugin.name);
    }
}

/// The misfit does not fall with a dimension or the tip radius either, where these are unknowns.
#[test]
fn unknown_dimensions_stay_what_they_are() {
    const STEP: f64 = 1e-5;
    const FLAT: f64 = 1e-9;
    let parameters = Parameters::new().with("radius", 20.0).with("angle_deg", 40.0);
    let fixture = support::fixture("cylinder-plane", &parameters);
    // All three at once would leave one free: a wider tip is a wider cylinder behind a nearer plane.
    for unknowns in [&[Unknown::Dimension(0), Unknown::Dimension(1)][..], &[Unknown::TipRadius]] {
        let mut drawn = 0;
        for trial in 0..50 {
            let mut rng = generator(92, trial);
            let layout = random_layout(&*fixture, &[8, 6], &mut rng);
            let magnitude = Magnitude::RootMeanSquare(0.3);
            let set = NullSpace { unknowns, ..null_space(&*fixture, &layout, magnitude) };
            let Some(reference) = set.draw(&mut rng) else { continue };
            drawn += 1;
            let of = |radius: f64, angle_deg: f64, tip_radius: f64| {
                let parameters = parameters.clone().with("radius", radius).with("angle_deg", angle_deg);
                let other = support::fixture("cylinder-plane", &parameters);
                misfit(&*other, &reference.touches, &[], tip_radius, &reference.frame)
            };
            for unknown in unknowns {
                let (first, second) = derivatives(STEP, |by| match unknown {
                    Unknown::Dimension(0) => of(20.0 + by, 40.0, TIP_RADIUS),
                    Unknown::Dimension(_) => of(20.0, 40.0 + by.to_degrees(), TIP_RADIUS),
                    Unknown::TipRadius => of(20.0, 40.0, TIP_RADIUS + by),
                });
                assert!((first / second).abs() < FLAT, "trial {trial}: {unknown:?} falls by {first:e}");
            }
        }
        assert!(drawn >= 40, "{unknowns:?}: {drawn}");
    }
}

#[test]
fn residuals_are_as_large_as_was_asked_for() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let mut rng = generator(93, 0);
    let layout = random_layout(&*fixture, &[7, 5], &mut rng);
    let largest = null_space(&*fixture, &layout, Magnitude::Largest(0.7)).draw(&mut rng).unwrap();
    let greatest = largest.residuals.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
    assert!((greatest - 0.7).abs() < 1e-12, "{greatest}");
    let mean = null_space(&*fixture, &layout, Magnitude::RootMeanSquare(0.4)).draw(&mut rng).unwrap();
    let rms = (mean.residuals.iter().map(|r| r * r).sum::<f64>() / 12.0).sqrt();
    assert!((rms - 0.4).abs() < 1e-12, "{rms}");
    // Random, and repeatable.
    let again = null_space(&*fixture, &layout, Magnitude::Largest(0.7));
    assert_eq!(again.draw(&mut generator(93, 1)), again.draw(&mut generator(93, 1)));
    assert_ne!(again.draw(&mut generator(93, 1)), again.draw(&mut generator(93, 2)));
}

#[test]
fn where_there_is_no_null_space_or_no_minimum_there_are_no_data() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let mut rng = generator(94, 0);
    let small = Magnitude::Largest(0.1);
    // Seven touches for seven unknowns.
    let nominal = fixture.nominal_layout();
    let radius = [Unknown::Dimension(0)];
    let set = NullSpace { unknowns: &radius, ..null_space(&*fixture, &nominal, small) };
    assert_eq!(set.draw(&mut rng), None);
    assert!(null_space(&*fixture, &nominal, small).draw(&mut rng).is_some());
    // Many touches of five points.
    let few: Layout = (0..20).map(|k| nominal[k % 5]).collect();
    assert_eq!(null_space(&*fixture, &few, small).draw(&mut rng), None);
    // A sigma, a surface and a dimension that do not exist.
    let set = NullSpace { sigmas: &[0.0; 7], ..null_space(&*fixture, &nominal, small) };
    assert_eq!(set.draw(&mut rng), None);
    let beside: Layout = nominal.iter().map(|(surface, at)| (surface + 1, *at)).collect();
    assert_eq!(null_space(&*fixture, &beside, small).draw(&mut rng), None);
    let unknowns = [Unknown::Dimension(2)];
    let set = NullSpace { unknowns: &unknowns, ..null_space(&*fixture, &nominal, small) };
    assert_eq!(set.draw(&mut rng), None);

    // The larger the residuals, the less of the minimum is left; beyond the radius of curvature nothing.
    let layout = random_layout(&*fixture, &[8, 6], &mut rng);
    let steepness = |length: f64| {
        let set = null_space(&*fixture, &layout, Magnitude::Largest(length));
        set.draw(&mut generator(94, 1)).map(|reference| reference.steepness)
    };
    let kept: Vec<Option<f64>> = [1e-3, 0.1, 1.0, 2.0, 400.0].into_iter().map(steepness).collect();
    println!("{kept:?}");
    assert!((kept[0].unwrap() - 1.0).abs() < 1e-3);
    assert!(kept.windows(2).all(|pair| pair[1].unwrap_or(0.0) < pair[0].unwrap()), "{kept:?}");
    assert!(kept.iter().flatten().all(|steepness| *steepness >= LEAST_STEEPNESS));
    assert_eq!(kept[4], None);
}

/// Reference frames come back to this times the condition: parts of the size, radians.
const RECOVERED: f64 = 1e-12;
/// The largest residual, as a power of ten: from a micrometre to a millimetre.
const RESIDUALS: std::ops::Range<f64> = -3.0..0.0;
/// Sets with residuals of half of that must be among those that come back.
const LARGE: f64 = 0.5;
/// Sets that must come back, for each fixture; half as many more are drawn, as large residuals are refused by right.
const SETS: usize = 1000;
/// The same where dimensions are unknowns, too: the search for frames, which takes the time, is the same.
const SETS_MEASURED: usize = 500;
/// The same where a search is everywhere, which takes a thousand times as long.
const SETS_EVERYWHERE: usize = 80;

/// A set that gives a frame.
struct Recovered {
    /// How far off the frame is, in parts of the bound.
    off: f64,
    /// The largest residual.
    largest: f64,
}

/// Every set that gives a frame.
fn recovered(
    fixture: &dyn Fixture,
    unknowns: &[Unknown],
    find: &(dyn Fn(&ReferenceMeasurement) -> Vec<Frame> + Sync),
    sets: usize,
) -> Vec<Recovered> {
    let one = |trial: u64| {
        let mut rng = generator(95, trial);
        let layout = redundant_layout(fixture, &mut rng);
        let largest = 10.0_f64.powf(rng.random_range(RESIDUALS));
        let frame = random_frame(10.0 * fixture.size(), &mut rng);
        let set = null_space(fixture, &layout, Magnitude::Largest(largest));
        let reference = NullSpace { unknowns, frame, ..set }.draw(&mut rng)?;
        let found = find(&reference);
        let off = found.iter().map(|found| found.twist_to(&reference.frame).extent(fixture.size()));
        let worst = off.reduce(f64::max)?;
        Some(Recovered { off: worst / (RECOVERED * reference.condition), largest })
    };
    (0..3 * sets as u64 / 2).into_par_iter().filter_map(one).collect()
}

fn assert_recovered(what: &str, recovered: &[Recovered], sets: usize) {
    let count = recovered.len();
    let worst = recovered.iter().map(|set| set.off).fold(0.0, f64::max);
    let largest = recovered.iter().map(|set| set.largest).fold(0.0, f64::max);
    println!("{what}: {count} sets, residuals up to {largest:.3}, at worst {worst:.1e} of the bound");
    assert!(count >= sets, "{what}: only {count} sets give a frame");
    assert!(largest >= LARGE, "{what}: residuals only up to {largest}");
    assert!(recovered.iter().all(|set| set.off <= 1.0), "{what}: {worst} of the bound");
}

/// What a solver finds: without a sigma, and with one as large as the residuals.
fn solved(solver: &dyn Solver, fixture: &dyn Fixture, reference: &ReferenceMeasurement) -> Vec<Frame> {
    let squares = reference.residuals.iter().map(|r| r * r).sum::<f64>();
    let rms = (squares / reference.residuals.len() as f64).sqrt();
    let found = [None, Some(rms)].into_iter().filter_map(|sigma| {
        let problem = Problem::new(fixture, &reference.touches, Probe { sigma, ..PROBE }).unwrap();
        let solution = solver.solve(&problem).ok()?;
        // Far from the design frame a better minimum may lie: without a sigma it is the answer, as far as its trust
        // goes.
        let trust = &solution.trust;
        (trust.from_sigma <= rms && rms <= trust.up_to_sigma).then_some(solution.frame)
    });
    found.collect()
}

#[test]
fn every_least_squares_solver_recovers_the_design_frame() {
    let registry = registry().unwrap();
    for plugin in registry.fixtures() {
        let settings = support::settings(plugin.name);
        let count = settings.len();
        for parameters in settings {
            let fixture = plugin.build(&parameters).unwrap();
            let what = format!("{} {parameters:?}", plugin.name);
            for solver in registry.solvers() {
                let closed_form = fixture.closed_form();
                if closed_form.is_none() && solver.name == "robust" {
                    // It makes dozens of searches.
                    continue;
                }
                let everywhere = closed_form.is_none() || solver.name == "global";
                let (unknowns, sets) = match (support::claim(solver.name), closed_form) {
                    (Claim::LeastSquares, _) if everywhere => (Vec::new(), SETS_EVERYWHERE),
                    (Claim::LeastSquares, _) => (Vec::new(), SETS),
                    (Claim::LeastSquaresMeasured, Some(form)) => {
                        (form.measured().iter().map(|m| Unknown::Dimension(*m)).collect(), SETS_MEASURED)
                    }
                    _ => continue,
                };
                let sets = sets.div_ceil(count);
                let solver = solver.build(&Parameters::new()).unwrap();
                let find = |reference: &ReferenceMeasurement| solved(&*solver, &*fixture, reference);
                let recovered = recovered(&*fixture, &unknowns, &find, sets);
                assert_recovered(&format!("{} on {what}", solver.name()), &recovered, sets);
            }
        }
    }
}

/// The reference descent itself, from a thousandth of the size beside.
#[test]
fn the_reference_descent_recovers_the_design_frame() {
    for plugin in registry().unwrap().fixtures() {
        let fixture = plugin.build(&support::settings(plugin.name)[0]).unwrap();
        let beside = Twist {
            translation: nalgebra::Vector3::new(6e-4, -6e-4, 5e-4) * fixture.size(),
            rotation: nalgebra::Vector3::new(-3e-4, 7e-4, 6e-4),
        };
        let find = |reference: &ReferenceMeasurement| {
            let problem = Problem::new(&*fixture, &reference.touches, PROBE).unwrap();
            let minimum = descend(&problem, &[], &reference.frame.moved(&beside));
            minimum.into_iter().map(|minimum| minimum.frame).collect()
        };
        let recovered = recovered(&*fixture, &[], &find, SETS);
        assert_recovered(&format!("descent on {}", plugin.name), &recovered, SETS);
    }
}
