//! How often is a frame right, refused, or wrong? Random layouts of `cylinder-plane`, by the `closed-form` solver.
//!
//! ```text
//! cargo run --release --example acceptance_study -- [trials] [seed] [sigma] [cylinder touches] [plane touches]
//! ```
//!
//! A frame is wrong when it was accepted and its true error lies outside its own stated covariance at the 1e-9 level
//! (chi-square above 53.34 with six degrees of freedom). Beside it: the choice of the root of nearest radius, which
//! refuses nothing; wrong there is an axis more than two degrees off.

#![allow(clippy::print_stdout)] // An example tells its figures.

use std::error::Error;

use rayon::prelude::*;
use touchref::{
    Frame, Parameters, Probe, Problem, RootKind,
    analysis::{Study, StudyLayout},
};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument =
        |index: usize, default: &str| arguments.get(index).map_or(default.to_owned(), Clone::clone);
    let (trials, seed) = (argument(0, "100000").parse()?, argument(1, "1").parse()?);
    let sigma = argument(2, "0.01").parse()?;
    let counts = vec![argument(3, "4").parse()?, argument(4, "3").parse()?];

    let registry = touchref::registry()?;
    let parameters = Parameters::new().with("radius", 20.0).with("angle_deg", 45.0);
    let plugin = registry.fixture("cylinder-plane")?;
    let fixture = plugin.build(&parameters)?;
    let solver = registry.solver("least-squares")?.build(&Parameters::new())?;
    let study = Study {
        fixture: &*fixture,
        plugin,
        solver: &*solver,
        layout: StudyLayout::Random(counts.clone()),
        probe: Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(sigma) },
        reach: 1000.0,
        seed,
        trials,
    };

    let started = std::time::Instant::now();
    let outcome = study.run()?;
    let seconds = started.elapsed().as_secs_f64();
    let share = |count: u64| 100.0 * count as f64 / trials as f64;
    println!(
        "{trials} trials, {}+{} touches, radius 20, sigma {sigma}, seed {seed}: {seconds:.1} s",
        counts[0], counts[1]
    );
    println!(
        "accepted {:.2} %, wrong {} (worst squared error {:.1})",
        share(outcome.accepted),
        outcome.wrong,
        outcome.worst
    );
    for (code, count) in &outcome.refused {
        println!("refused as {code}: {:.3} %", share(*count));
    }
    if let (Some(nees), Some(coverage), Some([translation, rotation])) =
        (outcome.nees_mean(), outcome.coverage_95(), outcome.rms_over_bound())
    {
        println!(
            "of the accepted: NEES {nees:.4}, part within their 95 % regions {coverage:.4}, rms over the bound with \
             known radius {translation:.3} and {rotation:.3}"
        );
    }
    let wrong = (0..trials).into_par_iter().filter(|trial| nearest_radius_is_wrong(&study, *trial)).count();
    println!("nearest radius, no refusals: {wrong} wrong");
    Ok(())
}

/// Whether the root of nearest radius has its axis more than two degrees off, or does not exist.
fn nearest_radius_is_wrong(study: &Study<'_>, trial: u64) -> bool {
    let Ok((touches, truth)) = study.measurement(trial) else { return true };
    let known = study.fixture.dimensions()[0].value;
    let mut best: Option<(f64, Frame)> = None;
    if let (Ok(problem), Some(closed_form)) =
        (Problem::new(study.fixture, &touches, study.probe), study.fixture.closed_form())
    {
        // A layout whose roots cannot be had at all counts as wrong, too.
        let _ = closed_form.roots(&problem, &mut |root| {
            let misfit = (root.measures[0] - known).abs();
            if root.kind == RootKind::Real && best.is_none_or(|(least, _)| misfit < least) {
                best = Some((misfit, root.frame));
            }
        });
    }
    best.is_none_or(|(_, frame)| frame.axis(2).angle(&truth.axis(2)) > 2.0_f64.to_radians())
}
