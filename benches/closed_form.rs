//! The closed form of `cylinder-plane` from 4 + 3 touches, beside the eigenvalues of the companion matrix of the same
//! equations by nalgebra: medians of interleaved rounds in one run, and their ratio.

#![allow(missing_docs, clippy::unwrap_used)] // A bench may panic.

#[path = "../tests/support/mod.rs"]
mod support;

use std::{hint::black_box, time::Instant};

use nalgebra::Point3;
use support::companion::Equations;
use touchref::{
    Frame, Probe, Problem, Touch,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
};

const PROBLEMS: usize = 1000;
const ROUNDS: usize = 101;

#[allow(clippy::print_stdout)]
fn main() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let probe = Probe { sigma: Some(0.01), ..Probe::default() };
    let measurements: Vec<Vec<Touch>> = (0..PROBLEMS as u64)
        .map(|trial| {
            let mut rng = generator(7, trial);
            let layout = random_layout(&*fixture, &[4, 3], &mut rng);
            let frame = random_frame(1000.0, &mut rng);
            simulate(&*fixture, &layout, &frame, &probe, 0.01, &mut rng)
        })
        .collect();
    let problems: Vec<Problem<'_>> =
        measurements.iter().map(|touches| Problem::new(&*fixture, touches, probe).unwrap()).collect();
    let closed_form = fixture.closed_form().unwrap();

    let ours = || {
        let mut sum = 0.0;
        for problem in &problems {
            closed_form
                .roots(black_box(problem), &mut |root| {
                    let frame: Frame = root.frame;
                    sum += frame.origin.x + root.measures[0];
                })
                .unwrap();
        }
        black_box(sum);
    };
    let companion = || {
        let mut sum = 0.0;
        for touches in &measurements {
            let at = |i: usize| -> Point3<f64> { black_box(touches[i].at) };
            let equations = Equations::new(&[0, 1, 2, 3].map(at), &[4, 5, 6].map(at), 45.0_f64.to_radians());
            sum += equations.real_roots(1e-6).iter().sum::<f64>();
        }
        black_box(sum);
    };
    // The eigenvalues alone: no polynomial, no frames.
    let eigenvalues_only: Vec<_> = (0..PROBLEMS).map(|k| coefficients(k as u64)).collect();
    let eigenvalues = || {
        let mut sum = 0.0;
        for polynomial in &eigenvalues_only {
            sum +=
                support::companion::companion_roots(black_box(polynomial)).iter().map(|r| r.0).sum::<f64>();
        }
        black_box(sum);
    };

    let mut times = [const { Vec::new() }; 3];
    for _ in 0..ROUNDS {
        for (times, run) in times.iter_mut().zip([&ours as &dyn Fn(), &companion, &eigenvalues]) {
            let start = Instant::now();
            run();
            times.push(start.elapsed().as_secs_f64() * 1e9 / PROBLEMS as f64);
        }
    }
    // The median of the rounds' own ratios: a disturbance hits a round's three alike.
    let ratio = |of: &[f64]| median(of.iter().zip(&times[0]).map(|(theirs, ours)| theirs / ours).collect());
    let [ratio_companion, ratio_eigenvalues] = [ratio(&times[1]), ratio(&times[2])];
    let [ours, companion, eigenvalues] = times.map(median);
    println!("closed form, 4 + 3 touches to every frame    {ours:8.0} ns");
    println!("companion matrix, touches to angles          {companion:8.0} ns   {ratio_companion:.1} times");
    println!(
        "companion matrix, eigenvalues alone          {eigenvalues:8.0} ns   {ratio_eigenvalues:.1} times"
    );
}

/// A polynomial with the spread of coefficients that the equations have.
fn coefficients(trial: u64) -> nalgebra::SVector<f64, 7> {
    use rand::RngExt;
    let mut rng = generator(8, trial);
    nalgebra::SVector::from_fn(|_, _| rng.random_range(-1.0..1.0))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
