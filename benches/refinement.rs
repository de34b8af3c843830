//! Refinement beside its peers: the plain loop and argmin's `Executor` over the same step, argmin's own Gauss-Newton,
//! and the `levenberg-marquardt` crate.
//!
//! ```text
//! cargo bench --bench refinement -- [problems timed] [bad starts]
//! ```
//!
//! First the time from a root of the closed form to the least-squares frame of 4 + 3 touches: medians of interleaved
//! rounds in one run, and their ratios. Then the share of bad starts, 30 degrees and 30 mm off, from which each reaches
//! the frame of 16 + 14 touches.
//!
//! The peers are told to stop where the library does.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)] // A bench may panic, and tells its figures.

mod rounds;
#[path = "../tests/support/mod.rs"]
mod support;
mod vectors;

use std::hint::black_box;

use argmin::core::{Executor, State};
use nalgebra::{Vector3, Vector6};
use nalgebra_0_34::{
    Const, DefaultAllocator, DimMax, DimMaximum, DimMin, U6,
    allocator::{Allocator, Reallocator},
};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use rounds::Rounds;
use touchref::{
    Fixture, Frame, Probe, Problem, Root, Touch, Twist,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
    solvers::{
        Unknowns,
        refinement::{LevenbergMarquardt, Misfit, RefinementState, descend},
    },
};
use vectors::{Chart, End, STEPS, by_gauss_newton, by_levenberg_marquardt, by_library_bounds};

const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(0.01) };
/// Two ends nearer than this are one frame: what the plain loop promises, standard deviations.
const SAME: f64 = 1e-4;
/// A bad start that ends as near as this to where the truth leads has reached it, standard deviations.
const REACHED: f64 = 1e-3;
/// How far off a bad start is turned, radians.
const TURN: f64 = std::f64::consts::FRAC_PI_6;
/// How far off its origin lies.
const SHIFT: f64 = 30.0;

fn main() {
    // `cargo bench` adds an argument of its own.
    let arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let mut sizes = arguments.map(|argument| argument.parse::<u64>().unwrap());
    let (problems, starts) = (sizes.next().unwrap_or(1000), sizes.next().unwrap_or(10_000));
    let fixture = support::cylinder_plane(20.0, 45.0);
    derivatives_are_true(&*fixture);
    time_from_roots(&*fixture, problems);
    println!();
    share_of_bad_starts(&*fixture, starts);
}

/// Random touches of a fixture at a random frame, and that frame.
fn measurement(fixture: &dyn Fixture, counts: [usize; 2], rng: &mut impl Rng) -> (Vec<Touch>, Frame) {
    let layout = random_layout(fixture, &counts, rng);
    let truth = random_frame(1000.0, rng);
    (simulate(fixture, &layout, &truth, &PROBE, 0.01, rng), truth)
}

/// The distance between two frames in standard deviations that the touches give the first.
fn deviations(problem: &Problem<'_>, from: &Frame, to: &Frame) -> f64 {
    let twist = Vector6::from(from.twist_to(to));
    let rises = (0..problem.touches().len()).map(|index| {
        let contact = problem.contact(from, index);
        Vector6::from(contact.gradient()).dot(&twist) / contact.sigma
    });
    rises.map(|rise| rise * rise).sum::<f64>().sqrt()
}

/// A way from a start to the least-squares frame; judged by where it ends, whatever it says of that.
struct Method {
    name: &'static str,
    run: for<'a> fn(&'a Problem<'a>, &Frame) -> Option<End>,
}

/// The plain loop, the `Executor`, and the peers, for `N` touches.
fn methods<const N: usize>() -> [Method; 4]
where
    Const<N>: DimMin<U6> + DimMax<U6>,
    DefaultAllocator: Allocator<DimMaximum<Const<N>, U6>, U6>
        + Reallocator<f64, Const<N>, U6, DimMaximum<Const<N>, U6>, U6>,
{
    [
        Method {
            name: "plain loop",
            run: |problem, start| {
                let end = descend(problem, start);
                Some(End { frame: end.frame, steps: end.steps as u64 })
            },
        },
        Method {
            name: "the same by argmin's Executor",
            run: |problem, start| {
                let start = Unknowns::at(*start);
                let result = Executor::new(Misfit::<6>::new(problem, &[]), LevenbergMarquardt::default())
                    .configure(|state: RefinementState| state.param(start).max_iters(STEPS).counting(false))
                    .ctrlc(false)
                    .run()
                    .ok()?;
                Some(End { frame: result.state().get_param()?.frame, steps: result.state().get_iter() })
            },
        },
        Method { name: "argmin's Gauss-Newton", run: by_gauss_newton },
        Method {
            name: "levenberg-marquardt crate",
            run: |problem, start| {
                Some(by_levenberg_marquardt::<Const<N>>(&by_library_bounds(), problem, start))
            },
        },
    ]
}

/// The peers' derivatives against central differences, near the start and far from it.
fn derivatives_are_true(fixture: &dyn Fixture) {
    /// Of the differences: lengths and radians.
    const STEP: f64 = 1e-5;
    /// What truncation and rounding leave of a derivative, in parts of the largest.
    const LEFT: f64 = 1e-8;
    for trial in 0..20 {
        let mut rng = generator(21, trial);
        let (touches, truth) = measurement(fixture, [4, 3], &mut rng);
        let problem = Problem::new(fixture, &touches, PROBE).unwrap();
        let mut chart = Chart::new(&problem, &truth);
        // Turns from 1e-4 radians, where the series holds, to 1.
        let reach = 10.0_f64.powf(-0.2 * trial as f64);
        let x: [f64; 6] = std::array::from_fn(|_| reach * rng.random_range(-1.0..1.0));
        chart.move_to(&x);
        let exact: Vec<[f64; 6]> = chart.gradients().collect();
        let largest = exact.iter().flatten().fold(0.0_f64, |most, slope| most.max(slope.abs()));
        for k in 0..6 {
            let [ahead, behind] = [STEP, -STEP].map(|step| {
                let mut moved = x;
                moved[k] += step;
                chart.move_to(&moved);
                [0, 1, 2, 3, 4, 5, 6].map(|touch| chart.residual(touch))
            });
            for i in 0..7 {
                let difference = (ahead[i] - behind[i]) / (2.0 * STEP);
                let off = (difference - exact[i][k]).abs() / largest;
                assert!(off < LEFT, "trial {trial}, touch {i}, unknown {k}: {off:e} of the largest");
            }
        }
    }
}

/// Times from the root nearest the truth to the least-squares frame of 4 + 3 touches, where all methods find the same.
fn time_from_roots(fixture: &dyn Fixture, count: u64) {
    let measurements: Vec<_> =
        (0..count).map(|trial| measurement(fixture, [4, 3], &mut generator(22, trial))).collect();
    let methods = methods::<7>();
    let mut problems: Vec<(Problem<'_>, Frame)> = Vec::new();
    let (mut without_root, mut steps, mut elsewhere) = (0, [0; 4], [0; 4]);
    for (touches, truth) in &measurements {
        let problem = Problem::new(fixture, touches, PROBE).unwrap();
        let Some(start) = nearest_root(&problem, truth) else {
            without_root += 1;
            continue;
        };
        let ends = methods.each_ref().map(|method| (method.run)(&problem, &start));
        let ours = ends[0].as_ref().unwrap().frame;
        let same = ends
            .each_ref()
            .map(|end| end.as_ref().is_some_and(|end| deviations(&problem, &ours, &end.frame) <= SAME));
        for (count, same) in elsewhere.iter_mut().zip(same) {
            *count += u64::from(!same);
        }
        if same == [true; 4] {
            for (sum, end) in steps.iter_mut().zip(ends) {
                *sum += end.unwrap().steps;
            }
            problems.push((problem, start));
        }
    }

    let runs = methods.each_ref().map(|method| {
        || {
            for (problem, start) in &problems {
                black_box((method.run)(black_box(problem), black_box(start)));
            }
        }
    });
    let rounds = Rounds::of(problems.len(), runs.each_ref().map(|run| run as &dyn Fn()));
    println!("from the root nearest the truth to the frame of 4 + 3 touches, random layouts");
    println!("{:30}   median   steps   times plain loop   times Executor   elsewhere", "");
    for (index, method) in methods.iter().enumerate() {
        println!(
            "{:30} {:6.0} ns {:7.2} {:18.2} {:16.2} {:11}",
            method.name,
            rounds.time(index),
            steps[index] as f64 / problems.len() as f64,
            rounds.ratio(index, 0),
            rounds.ratio(index, 1),
            elsewhere[index],
        );
    }
    println!(
        "timed: {} of {count}, where all end within {SAME} standard deviations of the plain loop, not elsewhere; \
         {without_root} have no root",
        problems.len()
    );
}

/// The frame of the closed form's root that is nearest the truth.
fn nearest_root(problem: &Problem<'_>, truth: &Frame) -> Option<Frame> {
    let mut nearest: Option<(f64, Frame)> = None;
    let mut keep = |root: Root| {
        let off = truth.twist_to(&root.frame).extent(problem.fixture().size());
        if nearest.is_none_or(|(least, _)| off < least) {
            nearest = Some((off, root.frame));
        }
    };
    problem.fixture().closed_form().unwrap().roots(problem, &mut keep).unwrap();
    nearest.map(|(_, frame)| frame)
}

/// How many bad starts lead to where the truth leads, with 16 + 14 touches.
fn share_of_bad_starts(fixture: &dyn Fixture, count: u64) {
    let methods = methods::<30>();
    let mut reached = [0_u64; 4];
    for trial in 0..count {
        let mut rng = generator(23, trial);
        let (touches, truth) = measurement(fixture, [16, 14], &mut rng);
        let problem = Problem::new(fixture, &touches, PROBE).unwrap();
        let mut direction = || Vector3::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal)).normalize();
        let start = truth.moved(&Twist { translation: direction() * SHIFT, rotation: direction() * TURN });
        let goal = descend(&problem, &truth).frame;
        for (count, method) in reached.iter_mut().zip(&methods) {
            let end = (method.run)(&problem, &start);
            *count += u64::from(end.is_some_and(|end| deviations(&problem, &goal, &end.frame) <= REACHED));
        }
    }
    println!(
        "{count} starts turned by {:.0} degrees and shifted by {SHIFT} mm, to the frame of 16 + 14 touches",
        TURN.to_degrees()
    );
    println!("{:30}   share that reach it", "");
    for (method, reached) in methods.iter().zip(reached) {
        println!("{:30} {:18.2} %", method.name, 100.0 * reached as f64 / count as f64);
    }
}
