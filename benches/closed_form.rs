//! The closed form of `cylinder-plane` from 4 + 3 touches, beside the eigenvalues of the companion matrix of the same
//! equations by nalgebra: medians of interleaved rounds in one run, and their ratio.

#![allow(missing_docs, clippy::unwrap_used)] // A bench may panic.

mod rounds;
#[path = "../tests/support/mod.rs"]
mod support;

use std::hint::black_box;

use nalgebra::Point3;
use rounds::Rounds;
use support::companion::Equations;
use touchref::{
    Frame, Probe, Problem, Touch,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
};

const PROBLEMS: usize = 1000;

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
            sum += equations.roots().iter().map(|root| root.0).sum::<f64>();
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

    let rounds = Rounds::of(PROBLEMS, [&ours, &companion, &eigenvalues]);
    let labels = [
        "closed form, 4 + 3 touches to every frame",
        "companion matrix, touches to angles",
        "companion matrix, eigenvalues alone",
    ];
    for (method, label) in labels.into_iter().enumerate() {
        println!("{label:44} {:8.0} ns   {:4.1} times", rounds.time(method), rounds.ratio(method, 0));
    }
}

/// A polynomial with the spread of coefficients that the equations have.
fn coefficients(trial: u64) -> nalgebra::SVector<f64, 7> {
    use rand::RngExt;
    let mut rng = generator(8, trial);
    nalgebra::SVector::from_fn(|_, _| rng.random_range(-1.0..1.0))
}
