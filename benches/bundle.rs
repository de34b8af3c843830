//! Many placements: how the time of a calibration grows with them, and how far it is below that of a dense solve of the
//! same normal equations by faer. Fastest of a few calls, one core.
//!
//! ```text
//! cargo bench --bench bundle -- [placements of the dense solve]
//! ```

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)] // A bench may panic, and prints its figures.

#[path = "../tests/support/placements.rs"]
mod placements;

use std::{hint::black_box, time::Instant};

use faer::{Mat, Side, linalg::solvers::Solve};
use placements::{Placements, twelve, unknowns};
use touchref::{
    Frame, Parameters, Probe, Problem, Value,
    analysis::simulation::generator,
    fixtures::cylinder_plane::PLUGIN,
    solvers::bundle::{adjust, calibrate},
};

const COUNTS: [usize; 5] = [10, 30, 100, 300, 1000];
const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.002, sigma: Some(0.005) };

fn main() {
    // Cargo adds an argument of its own.
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let dense: usize = arguments.next().map_or(1000, |argument| argument.parse().unwrap());
    println!("placements of 12 touches, radius and tip unknown: microseconds a placement");
    println!("{:>10} {:>12} {:>8} {:>12} {:>8}", "placements", "calibrate", "growth", "adjust", "growth");
    let mut last: Option<(usize, [f64; 2])> = None;
    for count in COUNTS {
        let placements = drawn(count);
        let unknowns = unknowns(&*placements.fixture, &PROBE, &["radius", "tip_radius"]);
        let problems = placements.problems();
        let times = [
            fastest(9, || drop(black_box(calibrate(&PLUGIN, &problems, &unknowns).unwrap()))),
            fastest(9, || drop(black_box(adjust(&problems, &unknowns, &placements.frames).unwrap()))),
        ];
        let [whole, iteration] = times.map(|time| time * 1e6 / count as f64);
        // Time over time, divided by placements over placements: 1 is linear.
        let growth = |k: usize| {
            last.map_or_else(String::new, |(before, old): (usize, [f64; 2])| {
                format!("{:.2}", times[k] / old[k] * before as f64 / count as f64)
            })
        };
        println!("{count:>10} {whole:>12.1} {:>8} {iteration:>12.2} {:>8}", growth(0), growth(1));
        last = Some((count, times));
    }

    let placements = drawn(dense);
    let unknowns = unknowns(&*placements.fixture, &PROBE, &["radius", "tip_radius"]);
    let problems = placements.problems();
    let whole = fastest(3, || drop(black_box(calibrate(&PLUGIN, &problems, &unknowns).unwrap())));
    let iteration = fastest(3, || drop(black_box(adjust(&problems, &unknowns, &placements.frames).unwrap())));
    let (normal, gradient) = normal_equations(&problems, &placements.frames);
    let solved = fastest(1, || drop(black_box(normal.llt(Side::Lower).unwrap().solve(&gradient))));
    println!(
        "{dense} placements: one dense solve {:.2} s; the whole iteration {:.2} ms, {:.0} times less; search, iteration \
         and verdict {:.1} ms, {:.0} times less",
        solved,
        iteration * 1e3,
        solved / iteration,
        whole * 1e3,
        solved / whole,
    );
}

fn drawn(count: usize) -> Placements {
    let stated =
        Parameters::new().with("radius", Value::Number { value: 20.0, u: 0.005 }).with("angle_deg", 45.0);
    let layout = twelve(&*PLUGIN.build(&stated).unwrap());
    Placements::drawn(&PLUGIN, &stated, PROBE, (&layout, count), &mut generator(81, 0))
}

/// Seconds of the fastest of so many calls: what disturbs one makes it slower, never faster.
fn fastest(calls: usize, mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..calls).map(time).fold(f64::INFINITY, f64::min)
}

/// Of one Gauss-Newton step, dense: six unknowns of each frame, then radius and tip.
fn normal_equations(problems: &[Problem<'_>], frames: &[Frame]) -> (Mat<f64>, Mat<f64>) {
    let shared = 6 * problems.len();
    let mut normal = Mat::zeros(shared + 2, shared + 2);
    let mut gradient = Mat::zeros(shared + 2, 1);
    for (placement, (problem, frame)) in problems.iter().zip(frames).enumerate() {
        for index in 0..problem.touches().len() {
            let contact = problem.contact(frame, index);
            let surface = problem.touches()[index].surface;
            let of_radius = problem.fixture().dimension_gradient(0, surface, &contact.at, &[20.0, 0.0]);
            let slopes = contact.gradient().into_iter().chain([of_radius, -1.0]);
            let places = (6 * placement..6 * placement + 6).chain(shared..shared + 2);
            let entries: Vec<(usize, f64)> = places.zip(slopes.map(|slope| slope / contact.sigma)).collect();
            for (i, a) in &entries {
                gradient[(*i, 0)] -= a * contact.residual / contact.sigma;
                for (j, b) in &entries {
                    normal[(*i, *j)] += a * b;
                }
            }
        }
    }
    // What is known of radius and tip.
    normal[(shared, shared)] += 1.0 / (0.005 * 0.005);
    normal[(shared + 1, shared + 1)] += 1.0 / (0.002 * 0.002);
    (normal, gradient)
}
