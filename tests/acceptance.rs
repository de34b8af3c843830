//! How often frames are right, refused or wrong, at a size that runs with every check. The full size:
//! `cargo run --release --example acceptance_study -- 1000000 SEED`.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use touchref::{
    Probe,
    analysis::{Study, StudyLayout, StudyOutcome},
};

const TRIALS: u64 = 10_000;

fn study(layout: StudyLayout, sigma: f64, seed: u64) -> StudyOutcome {
    let (fixture, solver) = (support::cylinder_plane(20.0, 45.0), support::solver("closed-form"));
    let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(sigma) };
    let (fixture, solver) = (&*fixture, &*solver);
    let plugin = &touchref::fixtures::cylinder_plane::PLUGIN;
    let study = Study { fixture, plugin, solver, layout, probe, reach: 1000.0, seed, trials: TRIALS };
    let outcome = study.run().unwrap();
    println!(
        "accepted {}, wrong {}, NEES {:?}, refused {:?}",
        outcome.accepted,
        outcome.wrong,
        outcome.nees_mean(),
        outcome.refused
    );
    outcome
}

/// Chance of being called inconsistent, and five standard deviations of its count.
fn assert_inconsistent_at_its_level(outcome: &StudyOutcome) {
    let expected = 1e-3 * TRIALS as f64;
    let inconsistent = outcome.refused.get("inconsistent").copied().unwrap_or(0) as f64;
    assert!(inconsistent < expected + 5.0 * expected.sqrt(), "{inconsistent}, expected {expected}");
}

#[test]
fn random_layouts_are_right_or_refused() {
    /// Of a million such trials none was wrong and 61 % were accepted.
    const ACCEPTED: f64 = 0.58;
    let outcome = study(StudyLayout::Random(vec![4, 3]), 0.01, 71);
    assert_eq!(outcome.wrong, 0);
    assert!(outcome.accepted as f64 > ACCEPTED * TRIALS as f64);
    assert_inconsistent_at_its_level(&outcome);
    // Three standard deviations of the mean, and 0.05 for the noise that the acceptance itself cuts off.
    let nees = outcome.nees_mean().unwrap();
    assert!((nees.value - 6.0).abs() < 3.0 * nees.u + 0.05, "{nees:?}");
}

#[test]
fn more_touches_are_accepted_more_often() {
    let outcome = study(StudyLayout::Random(vec![8, 6]), 0.01, 72);
    assert_eq!(outcome.wrong, 0);
    assert!(outcome.accepted as f64 > 0.97 * TRIALS as f64);
    assert_inconsistent_at_its_level(&outcome);
}

#[test]
fn a_study_is_the_same_for_any_number_of_threads() {
    let (fixture, solver) = (support::cylinder_plane(20.0, 45.0), support::solver("closed-form"));
    let probe = Probe { sigma: Some(0.01), ..Probe::default() };
    let (fixture, solver) = (&*fixture, &*solver);
    let plugin = &touchref::fixtures::cylinder_plane::PLUGIN;
    let layout = StudyLayout::Random(vec![4, 3]);
    let study = Study { fixture, plugin, solver, layout, probe, reach: 100.0, seed: 73, trials: 600 };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| study.run().unwrap())
    };
    assert_eq!(on(1), on(3));
}
