//! How often is a frame right, refused, or wrong? Random layouts of `cylinder-plane`, by the `least-squares` solver.
//!
//! ```text
//! cargo run --release --example acceptance_study -- [trials] [seed] [sigma] [cylinder touches] [plane touches] [searched]
//! ```
//!
//! A frame is wrong when it was accepted and its true error lies outside its own stated covariance at the 1e-9 level
//! (chi-square above 53.34 with six degrees of freedom). Beside it: the choice of the root of nearest radius, which
//! refuses nothing; wrong there is an axis more than two degrees off.
//!
//! And how often is a frame refused although nothing speaks against it? The first `searched` trials (20 000, as this
//! takes longer) tell: of those with a layout of condition below 100 and no impostor, another local minimum of the squared
//! misfit with a chi-square below 100, at least 99 % should be accepted at a sigma of 0.01.

#![allow(clippy::print_stdout)] // An example tells its figures.

use std::{collections::BTreeMap, error::Error};

use rayon::prelude::*;
use touchref::{
    Frame, Observability, Parameters, Probe, Problem, RootKind,
    analysis::{Share, Study, StudyError, StudyLayout},
    solvers::refinement::{Refinement, descend, refine},
    statistics::chi_square_level,
};

/// Condition of the layout, rotations scaled by the fixture's size, from which a frame may well be refused.
const WEAK: f64 = 100.0;
/// Chi-square from which a minimum is no impostor.
const IMPOSTOR: f64 = 100.0;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument =
        |index: usize, default: &str| arguments.get(index).map_or(default.to_owned(), Clone::clone);
    let (trials, seed) = (argument(0, "100000").parse()?, argument(1, "1").parse()?);
    let sigma = argument(2, "0.01").parse()?;
    let counts = vec![argument(3, "4").parse()?, argument(4, "3").parse()?];
    let searched = argument(5, "20000").parse::<u64>()?.min(trials);

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
    tell_the_plain(&study, searched)
}

/// Tells how many of the measurements that are plain are accepted, and why the others are not.
fn tell_the_plain(study: &Study<'_>, searched: u64) -> Result<(), Box<dyn Error>> {
    let started = std::time::Instant::now();
    let trials: Result<Vec<Trial>, StudyError> =
        (0..searched).into_par_iter().map(|trial| Trial::of(study, trial)).collect();
    let seconds = started.elapsed().as_secs_f64();
    let (mut sound, mut plain, mut accepted, mut refused) = (0, 0, 0, BTreeMap::new());
    for trial in trials? {
        sound += u64::from(!matches!(trial, Trial::Weak));
        let Trial::Plain { refusal } = trial else { continue };
        plain += 1;
        match refusal {
            None => accepted += 1,
            Some(code) => *refused.entry(code).or_insert(0_u64) += 1,
        }
    }
    println!(
        "of {searched} trials {sound} with a condition below {WEAK}, {plain} of them without an impostor within \
         chi-square {IMPOSTOR}: {seconds:.1} s"
    );
    if let Some(Share { value, low, high }) = Share::of(accepted, plain) {
        let [value, low, high] = [value, low, high].map(|part| 100.0 * part);
        println!(
            "accepted of these {value:.2} % ({low:.2} to {high:.2} % with 95 % confidence; 99 % wanted at sigma 0.01)"
        );
    }
    for (code, count) in refused {
        println!("refused of these as {code}: {count}");
    }
    Ok(())
}

/// What a trial shows.
enum Trial {
    /// The layout sees some motion too weakly.
    Weak,
    /// Another frame fits nearly as well.
    Mistakable,
    /// Neither; the code with which it is refused all the same.
    Plain { refusal: Option<&'static str> },
}

impl Trial {
    fn of(study: &Study<'_>, trial: u64) -> Result<Self, StudyError> {
        let (touches, truth) = study.measurement(trial)?;
        let problem = Problem::new(study.fixture, &touches, study.probe)?;
        if Observability::at(&problem, &truth).condition >= WEAK {
            return Ok(Self::Weak);
        }
        if has_impostor(&problem, &truth) {
            return Ok(Self::Mistakable);
        }
        let refusal = study.solver.solve(&problem).err().map(|refusal| refusal.code());
        Ok(Self::Plain { refusal })
    }
}

/// Whether another local minimum than the one at the true frame has a chi-square below [`IMPOSTOR`] and nothing against
/// it. The solver's verdict takes no part: descents from every root and every candidate of the closed form tell.
fn has_impostor(problem: &Problem<'_>, truth: &Frame) -> bool {
    /// Minima this near (parts of the fixture's size, radians) are one.
    const SAME: f64 = 1e-6;
    /// Candidates reach up to the level of this chance, at the noise that they are asked for.
    const REACHED: f64 = 1e-6;
    let fixture = problem.fixture();
    let (Some(own), Some(closed_form)) = (minimum(problem, truth), fixture.closed_form()) else {
        return false;
    };
    let degrees_of_freedom = problem.touches().len().saturating_sub(6);
    let noise = (IMPOSTOR / chi_square_level(REACHED, degrees_of_freedom)).sqrt();
    let mut starts = Vec::new();
    // Where a search is refused, what it found counts all the same.
    let _ = closed_form.roots(problem, &mut |root| starts.push(root.frame));
    let _ = closed_form.candidates(problem, noise, &mut |frame| starts.push(frame));
    starts.iter().filter_map(|start| minimum(problem, start)).any(|other| {
        let frame = &other.unknowns.frame;
        other.chi_square < IMPOSTOR
            && own.unknowns.frame.twist_to(frame).extent(fixture.size()) > SAME
            && fixture.objection(problem, frame).is_none()
    })
}

/// The minimum to which a descent leads, to rounding; `None` where it is none or fits too badly to matter.
fn minimum(problem: &Problem<'_>, start: &Frame) -> Option<Refinement> {
    let end = descend(problem, start);
    let matters = end.chi_square < IMPOSTOR || !end.stop.converged();
    matters.then(|| refine(problem, &end.frame).ok()).flatten()
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
