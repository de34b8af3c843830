//! `global` certifies the other solvers: it agrees with `least-squares` wherever both answer, and lists every minimum that
//! random starts lead to. `cargo run --release --example certify_study` does the same at full size.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use support::certify::{SIGMA, agreement, completeness, measurement, roots};
use touchref::{Parameters, Problem, registry};

/// Measurements of each layout.
const AGREEMENT_TRIALS: u64 = 40;
const COMPLETENESS_TRIALS: u64 = 150;

#[test]
fn global_and_least_squares_agree_or_one_refuses() {
    let [global, other] = ["global", "least-squares"].map(support::solver);
    for plugin in registry().unwrap().fixtures() {
        let fixture = plugin.build(&support::settings(plugin.name)[0]).unwrap();
        let fewest = &fixture.requirement().alternatives[0];
        let counts: Vec<usize> = fewest.iter().map(|count| count + usize::from(*count > 0)).collect();
        let told = agreement((&*global, &*other), &*fixture, &counts, 11, AGREEMENT_TRIALS);
        println!("{}: {told:?}", plugin.name);
        assert_eq!(told.apart, 0, "{}", plugin.name);
        assert!(2 * told.both > AGREEMENT_TRIALS, "{}: they hardly ever answer both", plugin.name);
    }
}

#[test]
fn no_random_start_finds_another_minimum() {
    let global = support::solver("global");
    let fixture = support::cylinder_plane(20.0, 45.0);
    let told = completeness(&*global, &*fixture, &[4, 3], 12, COMPLETENESS_TRIALS);
    println!("{told:?}");
    assert!(told.layouts >= 5 && told.minima > 2 * told.layouts, "hardly any is ambiguous");
    assert_eq!(told.missed, 0);
}

/// How many minima there are, how far apart and how much worse: whatever the order of the touches.
#[test]
fn the_minima_are_told() {
    let global = support::solver("global");
    let fixture = support::cylinder_plane(20.0, 45.0);
    let (mut touches, probe, truth) = measurement(&*fixture, &[5, 4], SIGMA, 13, 0);
    let outcome = global.solve(&Problem::new(&*fixture, &touches, probe).unwrap());
    let told = roots(&outcome).to_vec();
    assert!(outcome.as_ref().unwrap().squared_distance(&truth).unwrap() < 53.34);
    assert!(told.len() > 2 && told[0].selected);
    assert!(told[1..].iter().all(|root| root.reason.contains("degrees from the best")), "{}", told[1].reason);
    assert!(told[1..].windows(2).all(|pair| pair[0].misfit <= pair[1].misfit));
    touches.reverse();
    let reversed = global.solve(&Problem::new(&*fixture, &touches, probe).unwrap());
    assert_eq!(roots(&reversed).len(), told.len());
}

#[test]
fn it_has_no_parameters() {
    let plugin = registry().unwrap().solver("global").unwrap();
    assert!(plugin.build(&Parameters::new().with("margin", "full")).is_err());
}
