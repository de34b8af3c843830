//! Is the uncertainty of a calibration true? Simulated placements of `cylinder-plane`, radius and tip drawn from what is
//! stated of them: how often their joint 95 % region holds the truth.
//!
//! ```text
//! cargo run --release --example calibration_study -- [data sets] [seed] [placements]
//! ```

#![allow(clippy::print_stdout)] // An example tells its figures.

#[path = "../tests/support/placements.rs"]
mod placements;

use std::{collections::BTreeMap, error::Error, time::Instant};

use placements::{Placements, twelve, unknowns};
use rayon::prelude::*;
use touchref::{
    Parameters, Probe, Value, analysis::simulation::generator, fixtures::cylinder_plane::PLUGIN,
    solvers::bundle::calibrate,
};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument =
        |index: usize, default: &str| arguments.get(index).map_or(default.to_owned(), Clone::clone);
    let (sets, seed): (u64, u64) = (argument(0, "1000").parse()?, argument(1, "1").parse()?);
    let count = argument(2, "200").parse()?;

    let stated =
        Parameters::new().with("radius", Value::Number { value: 20.0, u: 0.005 }).with("angle_deg", 45.0);
    let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.002, sigma: Some(0.005) };
    let layout = twelve(&*PLUGIN.build(&stated)?);
    let started = Instant::now();
    let outcomes: Vec<Result<(f64, bool), &'static str>> = (0..sets)
        .into_par_iter()
        .map(|set| {
            let rng = &mut generator(seed, set);
            let placements = Placements::drawn(&PLUGIN, &stated, probe, (&layout, count), rng);
            let unknowns = unknowns(&*placements.fixture, &probe, &["radius", "tip_radius"]);
            let calibration = calibrate(&PLUGIN, &placements.problems(), &unknowns);
            let calibration = calibration.map_err(|refusal| refusal.code())?;
            Ok((placements.squared_error(&calibration), placements.holds_the_truth(&calibration)))
        })
        .collect();
    let seconds = started.elapsed().as_secs_f64();
    let accepted: Vec<(f64, bool)> = outcomes.iter().filter_map(|outcome| outcome.ok()).collect();
    let held = accepted.iter().filter(|(_, holds)| *holds).count();
    let mean = accepted.iter().map(|(square, _)| square).sum::<f64>() / accepted.len() as f64;
    println!("{sets} data sets of {count} placements, 12 touches each, seed {seed}: {seconds:.1} s");
    println!(
        "{} calibrated; the joint 95 % region of radius and tip holds the truth in {:.2} % (+- {:.2}), mean squared \
         error {mean:.3} (2 expected, +- {:.3})",
        accepted.len(),
        100.0 * held as f64 / accepted.len() as f64,
        100.0 * (0.05 * 0.95 / accepted.len() as f64).sqrt(),
        2.0 / (accepted.len() as f64).sqrt(),
    );
    let mut refused = BTreeMap::new();
    for code in outcomes.iter().filter_map(|outcome| outcome.err()) {
        *refused.entry(code).or_insert(0_u64) += 1;
    }
    for (code, number) in refused {
        println!("refused as {code}: {number}");
    }
    Ok(())
}
