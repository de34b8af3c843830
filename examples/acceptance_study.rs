//! How often is a frame right, refused, or wrong? Random layouts of `cylinder-plane`, by the `closed-form` solver.
//!
//! ```text
//! cargo run --release --example acceptance_study -- [trials] [seed] [sigma] [cylinder touches] [plane touches]
//! ```
//!
//! A frame is wrong when it was accepted and its true error lies outside its own stated covariance at the 1e-9 level
//! (chi-square above 53.34 with six degrees of freedom). Beside it: the choice of the root of nearest radius, which
//! refuses nothing.

#![allow(clippy::print_stdout)] // An example tells its figures.

use std::{collections::BTreeMap, error::Error};

use rand::RngExt;
use rayon::prelude::*;
use touchref::{
    Fixture, Frame, Parameters, Probe, Problem, RootKind, Solution, Solver,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
    statistics::chi_square_level,
};

#[derive(Default)]
struct Tally {
    accepted: u64,
    wrong: u64,
    worst: f64,
    nees: f64,
    nearest_radius_wrong: u64,
    sound: u64,
    sound_accepted: u64,
    refused: BTreeMap<&'static str, u64>,
}

impl Tally {
    fn plus(mut self, other: Self) -> Self {
        self.accepted += other.accepted;
        self.wrong += other.wrong;
        self.worst = self.worst.max(other.worst);
        self.nees += other.nees;
        self.nearest_radius_wrong += other.nearest_radius_wrong;
        self.sound += other.sound;
        self.sound_accepted += other.sound_accepted;
        for (code, count) in other.refused {
            *self.refused.entry(code).or_default() += count;
        }
        self
    }
}

/// Squared error of a frame in its own stated covariance.
fn squared_error(solution: &Solution, truth: &Frame) -> Option<f64> {
    let covariance = solution.covariance.as_ref()?.matrix;
    let fixture_axes = solution.frame.twist_to(truth);
    let rotation = solution.frame.rotation;
    let (t, w) = (rotation * fixture_axes.translation, rotation * fixture_axes.rotation);
    let error = nalgebra::Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z);
    Some(error.dot(&covariance.cholesky()?.solve(&error)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut number = |default: f64| -> Result<f64, Box<dyn Error>> {
        Ok(arguments.next().map_or(Ok(default), |text| text.parse())?)
    };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let [trials, seed, cylinder, plane, sigma] = {
        let (trials, seed, sigma) = (number(1e5)?, number(1.0)?, number(0.01)?);
        let (cylinder, plane) = (number(4.0)?, number(3.0)?);
        [trials as u64, seed as u64, cylinder as u64, plane as u64, sigma.to_bits()]
    };
    let sigma = f64::from_bits(sigma);
    let counts = [usize::try_from(cylinder)?, usize::try_from(plane)?];

    let registry = touchref::registry()?;
    let radius = 20.0;
    let parameters = Parameters::new().with("radius", radius).with("angle_deg", 45.0);
    let fixture = registry.fixture("cylinder-plane")?.build(&parameters)?;
    let solver = registry.solver("closed-form")?.build(&Parameters::new())?;
    let level = chi_square_level(1e-9, 6);

    let started = std::time::Instant::now();
    let tally = (0..trials)
        .into_par_iter()
        .map(|trial| one(&*fixture, &*solver, &counts, sigma, seed, trial, level))
        .reduce(Tally::default, Tally::plus);
    let seconds = started.elapsed().as_secs_f64();

    let share = |count: u64| 100.0 * count as f64 / trials as f64;
    println!(
        "{trials} trials, {}+{} touches, radius {radius}, sigma {sigma}, seed {seed}: {seconds:.1} s",
        counts[0], counts[1]
    );
    println!(
        "accepted {:.2} %, wrong {} (worst squared error {:.1}), NEES of the accepted {:.4}",
        share(tally.accepted),
        tally.wrong,
        tally.worst,
        tally.nees / tally.accepted as f64
    );
    for (code, count) in &tally.refused {
        println!("refused as {code}: {:.3} %", share(*count));
    }
    println!("nearest radius, no refusals: {} wrong", tally.nearest_radius_wrong);
    Ok(())
}

fn one(
    fixture: &dyn Fixture,
    solver: &dyn Solver,
    counts: &[usize],
    sigma: f64,
    seed: u64,
    trial: u64,
    level: f64,
) -> Tally {
    let mut rng = generator(seed, trial);
    let layout = random_layout(fixture, counts, &mut rng);
    let truth = random_frame(1000.0, &mut rng);
    let probe = Probe { tip_radius: rng.random_range(0.5..3.0), tip_radius_u: 0.0, sigma: Some(sigma) };
    let touches = simulate(fixture, &layout, &truth, &probe, sigma, &mut rng);
    let mut tally = Tally::default();
    let Ok(problem) = Problem::new(fixture, &touches, probe) else { return tally };
    match solver.solve(&problem) {
        Ok(solution) => {
            let error = squared_error(&solution, &truth).unwrap_or(f64::INFINITY);
            tally.accepted = 1;
            tally.wrong = u64::from(error > level);
            tally.worst = error;
            tally.nees = error;
        }
        Err(refusal) => {
            tally.refused.insert(refusal.code(), 1);
        }
    }
    tally.nearest_radius_wrong = u64::from(nearest_radius_is_wrong(fixture, &problem, &truth));
    tally
}

/// Whether the root of nearest radius has its axis more than two degrees off, or does not exist.
fn nearest_radius_is_wrong(fixture: &dyn Fixture, problem: &Problem<'_>, truth: &Frame) -> bool {
    let known = fixture.dimensions()[0].value;
    let mut best: Option<(f64, Frame)> = None;
    if let Some(closed_form) = fixture.closed_form() {
        let _ = closed_form.roots(problem, &mut |root| {
            let misfit = (root.measures[0] - known).abs();
            if root.kind == RootKind::Real && best.is_none_or(|(least, _)| misfit < least) {
                best = Some((misfit, root.frame));
            }
        });
    }
    best.is_none_or(|(_, frame)| frame.axis(2).angle(&truth.axis(2)) > 2.0_f64.to_radians())
}
