//! `robust` names the bad touch where theory says that it can be told, accuses no sound one, and says else what it cannot
//! tell.
//!
//! The theory is Baarda's, linear, and written here on its own: with the whitened Jacobian `J` and `Q = I - J (J'J)^-1 J'`,
//! an error of `d` standard deviations in touch `j` raises chi-square by `d^2 Q_jj`, and leaves `d^2 (Q_jj - Q_ij^2 / Q_ii)`
//! of that when touch `i` is left out instead.
//!
//! Rates are measured on a few hundred measurements. `TRIALS=20000 cargo test --release --test robust -- --nocapture`
//! measures them on more.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rayon::prelude::*;
use support::trials;
use touchref::{
    Fixture, Frame, Observability, Parameters, Probe, Problem, Solution, SolveError, Solver, Touch, Unknown,
    Value,
    analysis::{
        reference::{Minimum, descend},
        simulation::{generator, random_frame, random_layout, simulate},
        study::WRONG_LEVEL,
    },
    statistics::chi_square_level,
};

const SIGMA: f64 = 0.01;
/// How far a bad touch is off, standard deviations.
const OFF: f64 = 100.0;

/// The fixtures of the studies.
fn fixture(kind: &str) -> Box<dyn Fixture> {
    support::fixture(kind, &support::settings(kind)[0])
}

/// `robust` for at most so many bad touches.
fn robust(bad: usize) -> Box<dyn Solver> {
    let plugin = touchref::registry().unwrap().solver("robust").unwrap();
    plugin.build(&Parameters::new().with("bad", bad.to_string().as_str())).unwrap()
}

/// A simulated measurement, some of its touches off along their normals.
struct Measurement {
    touches: Vec<Touch>,
    /// The same without noise.
    exact: Vec<Touch>,
    truth: Frame,
    probe: Probe,
    bad: Vec<usize>,
    /// How far each is off, standard deviations.
    off: Vec<f64>,
}

impl Measurement {
    /// At random places, so many on each surface, so many of them bad.
    fn random(fixture: &dyn Fixture, counts: &[usize], bad: usize, trial: u64) -> Self {
        Self::with_errors(fixture, counts, bad, [OFF, OFF], trial)
    }

    /// The same, the bad ones off by between these (standard deviations), any order of magnitude as likely.
    fn with_errors(fixture: &dyn Fixture, counts: &[usize], bad: usize, off: [f64; 2], trial: u64) -> Self {
        let [least, most] = off;
        let mut rng = generator(4 + bad as u64, trial);
        let layout = random_layout(fixture, counts, &mut rng);
        let truth = random_frame(1000.0, &mut rng);
        let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };
        let mut exact = simulate(fixture, &layout, &truth, &probe, 0.0, &mut rng);
        let mut touches = simulate(fixture, &layout, &truth, &probe, SIGMA, &mut rng);
        let mut bad = rand::seq::index::sample(&mut rng, touches.len(), bad).into_vec();
        bad.sort_unstable();
        let mut off = vec![0.0; touches.len()];
        for &index in &bad {
            let seen = fixture.surfaces()[layout[index].0].seen_from(&layout[index].1);
            let size = least * (most / least).powf(rng.random());
            off[index] = if rng.random() { size } else { -size };
            for touches in [&mut touches, &mut exact] {
                touches[index].at += truth.rotation * seen.normal * (off[index] * SIGMA);
            }
        }
        Self { touches, exact, truth, probe, bad, off }
    }

    /// The errors of the bad touches, in standard deviations.
    fn error(&self) -> DVector<f64> {
        DVector::from_fn(self.touches.len(), |index, _| self.off[index])
    }

    fn exact_without(&self, left_out: &[usize]) -> Vec<Touch> {
        let kept = (0..self.exact.len()).filter(|index| !left_out.contains(index));
        kept.map(|index| self.exact[index]).collect()
    }

    fn problem<'a>(&'a self, fixture: &'a dyn Fixture) -> Problem<'a> {
        Problem::new(fixture, &self.touches, self.probe).unwrap()
    }
}

/// The matrix `Q` at the true frame, and the condition there.
fn cofactors(problem: &Problem<'_>, truth: &Frame) -> (DMatrix<f64>, f64) {
    let n = problem.touches().len();
    let mut jacobian = DMatrix::zeros(n, 6);
    for index in 0..n {
        let contact = problem.contact(truth, index);
        for (k, slope) in contact.gradient().into_iter().enumerate() {
            jacobian[(index, k)] = slope / contact.sigma;
        }
    }
    let orthonormal = jacobian.qr().q();
    let q = DMatrix::identity(n, n) - &orthonormal * orthonormal.transpose();
    (q, Observability::at(problem, truth).condition)
}

/// What is left of chi-square when `left_out` are taken for bad and `error` (standard deviations) is what is wrong.
fn left_over(q: &DMatrix<f64>, error: &DVector<f64>, left_out: &[usize]) -> f64 {
    let seen = q * error;
    let block = DMatrix::from_fn(left_out.len(), left_out.len(), |i, j| q[(left_out[i], left_out[j])]);
    let part = DVector::from_fn(left_out.len(), |i, _| seen[left_out[i]]);
    let explained = block.svd(true, true).solve(&part, 1e-9).map_or(0.0, |x| x.dot(&part));
    error.dot(&seen) - explained
}

/// What is left of chi-square when a size is taken for wrong instead: least over the dimensions and the tip radius.
fn left_over_of_sizes(problem: &Problem<'_>, truth: &Frame, q: &DMatrix<f64>, error: &DVector<f64>) -> f64 {
    /// Sizes that no touch sees, in parts of what one sees at most.
    const UNSEEN: f64 = 1e-9;
    let (fixture, n) = (problem.fixture(), error.len());
    let values: Vec<f64> = fixture.dimensions().iter().map(|dimension| dimension.value).collect();
    let contacts: Vec<_> = (0..n).map(|index| problem.contact(truth, index)).collect();
    let mut columns = vec![DVector::from_fn(n, |_, _| 1.0 / SIGMA)];
    for dimension in 0..values.len() {
        columns.push(DVector::from_fn(n, |index, _| {
            let surface = problem.touches()[index].surface;
            fixture.dimension_gradient(dimension, surface, &contacts[index].at, &values) / SIGMA
        }));
    }
    let seen = q * error;
    let explained = columns.iter().map(|column| {
        let own = column.dot(&(q * column));
        if own < UNSEEN * column.norm_squared() { 0.0 } else { column.dot(&seen).powi(2) / own }
    });
    error.dot(&seen) - explained.fold(0.0, f64::max)
}

/// What came of measurements with bad touches.
#[derive(Debug, Default, Clone, Copy)]
struct Tally {
    trials: u64,
    /// A frame without the bad touches, and no others.
    named: u64,
    /// A frame without others.
    wrongly_named: u64,
    /// A frame whose true error is outside its own covariance at the 1e-9 level.
    wrong: u64,
    /// A frame of all touches.
    unnoticed: u64,
    /// Refused with suspects, bad ones among them.
    suspected: u64,
    /// Refused with suspects, none of them bad.
    misled: u64,
    /// Refused because the frame without the bad touches, and no others, does not stand.
    weak: u64,
    /// Refused otherwise.
    refused: u64,
}

impl Tally {
    fn of(measurement: &Measurement, outcome: &Result<Solution, SolveError>) -> Self {
        let mut tally = Self { trials: 1, ..Self::default() };
        match outcome {
            Ok(solution) => {
                let squared = solution.squared_distance(&measurement.truth).unwrap();
                tally.wrong += u64::from(squared > chi_square_level(WRONG_LEVEL, 6));
                match solution.excluded.as_slice() {
                    [] => tally.unnoticed += 1,
                    named if named == measurement.bad => tally.named += 1,
                    _ => tally.wrongly_named += 1,
                }
            }
            Err(refusal) => {
                let suspects = refusal.refusal().map_or(&[][..], |refusal| &refusal.touches);
                // Of the bad ones those that explain without the others are enough.
                let some = measurement.bad.iter().any(|bad| suspects.contains(bad));
                match (suspects.is_empty(), some) {
                    (true, _) => tally.refused += 1,
                    (false, true) if refusal.code() != "inconsistent" => tally.weak += 1,
                    (false, true) => tally.suspected += 1,
                    (false, false) => tally.misled += 1,
                }
            }
        }
        tally
    }

    fn plus(self, other: Self) -> Self {
        Self {
            trials: self.trials + other.trials,
            named: self.named + other.named,
            wrongly_named: self.wrongly_named + other.wrongly_named,
            wrong: self.wrong + other.wrong,
            unnoticed: self.unnoticed + other.unnoticed,
            suspected: self.suspected + other.suspected,
            misled: self.misled + other.misled,
            weak: self.weak + other.weak,
            refused: self.refused + other.refused,
        }
    }
}

/// Random layouts with bad touches, told that at most so many are: the tally of all, and of those that are well
/// conditioned by their true geometry.
fn study(kind: &str, counts: &[usize], bad: usize, assumed: usize, trials: u64) -> [Tally; 2] {
    let (fixture, solver) = (fixture(kind), robust(assumed));
    let tallies = (0..trials).into_par_iter().map(|trial| {
        let measurement = Measurement::random(&*fixture, counts, bad, trial);
        let tally = Tally::of(&measurement, &solver.solve(&measurement.problem(&*fixture)));
        let good = is_well_conditioned(&*fixture, &measurement, assumed);
        [tally, if good { tally } else { Tally::default() }]
    });
    let [all, good] =
        tallies.reduce(Default::default, |one, other| [one[0].plus(other[0]), one[1].plus(other[1])]);
    println!("{kind} {counts:?}, {bad} bad, at most {assumed}: {trials} measurements");
    println!("  all:              {all:?}\n  well conditioned: {good:?}");
    [all, good]
}

/// Beforehand, by the true geometry: the frame is well determined with the bad touches and without; no other frame comes
/// near the sound touches; and whatever is taken for bad instead of the bad ones, another touch or a size, is seen not to
/// be, by five standard deviations.
fn is_well_conditioned(fixture: &dyn Fixture, measurement: &Measurement, assumed: usize) -> bool {
    const CONDITION: f64 = 100.0;
    const CHANCE: f64 = 5.0;
    let Measurement { exact, truth, bad, probe, .. } = measurement;
    let (problem, n) = (Problem::new(fixture, exact, *probe).unwrap(), exact.len());
    let level = (chi_square_level(1e-6, n - 6 - assumed).sqrt() + CHANCE).powi(2);
    let (q, condition) = cofactors(&problem, truth);
    let sound = measurement.exact_without(bad);
    let sound = Problem::new(fixture, &sound, *probe).unwrap();
    let seen_by_theory = |rival: &Vec<usize>| left_over(&q, &measurement.error(), rival) > level;
    let seen = |rival: &Vec<usize>| {
        let rest = measurement.exact_without(rival);
        let minima = minima(&Problem::new(fixture, &rest, *probe).unwrap());
        minima.is_some_and(|minima| minima.iter().all(|end| end.chi_square > level))
    };
    let rivals =
        || sets(n, assumed).into_iter().filter(|rival| !bad.iter().all(|touch| rival.contains(touch)));
    condition < CONDITION
        && cofactors(&sound, truth).1 < CONDITION
        && rivals().all(|rival| seen_by_theory(&rival))
        && left_over_of_sizes(&problem, truth, &q, &measurement.error()) > level
        && !other_size_fits(&problem, &sound, level)
        && minima(&sound).is_some_and(|minima| {
            minima.iter().all(|end| end.chi_square > level || is_at(fixture, &end.frame, truth))
        })
        && rivals().all(|rival| seen(&rival))
}

/// Every set of one or two of the first numbers.
fn sets(n: usize, count: usize) -> Vec<Vec<usize>> {
    if count == 1 {
        return (0..n).map(|i| vec![i]).collect();
    }
    (0..n).flat_map(|j| (0..j).map(move |i| vec![i, j])).collect()
}

/// Whether a dimension that is far from its own value makes touches fit, from any frame that the equations, or the sound
/// touches, allow.
fn other_size_fits(problem: &Problem<'_>, sound: &Problem<'_>, level: f64) -> bool {
    let closed_form = problem.fixture().closed_form().unwrap();
    let mut starts = Vec::new();
    for touches in [problem, sound] {
        let _ = closed_form.roots(touches, &mut |root| starts.push(root.frame));
    }
    (0..problem.fixture().dimensions().len()).any(|dimension| {
        let free = [Unknown::Dimension(dimension)];
        starts.iter().filter_map(|start| descend(problem, &free, start)).any(|end| end.chi_square <= level)
    })
}

fn is_at(fixture: &dyn Fixture, frame: &Frame, truth: &Frame) -> bool {
    truth.twist_to(frame).extent(fixture.size()) < 1e-6
}

/// Every frame that comes near touches; `None` where so few, or so weak ones, do not let them all be found.
fn minima(problem: &Problem<'_>) -> Option<Vec<Minimum>> {
    /// Of the stated noise, as the level that rivals must exceed is as far beyond that of the solver.
    const FAR: f64 = 3.0;
    let mut starts = Vec::new();
    let closed_form = problem.fixture().closed_form().unwrap();
    let complete_up_to = closed_form.candidates(problem, FAR, &mut |frame| starts.push(frame)).ok()?;
    let ends = starts.iter().filter_map(|start| descend(problem, &[], start));
    let ends = ends.filter(|end| problem.fixture().objection(problem, &end.frame).is_none());
    (complete_up_to >= FAR).then(|| ends.collect())
}

/// Bad touches of measurements that seven touches make: noticed or not, never named.
#[test]
fn seven_touches_never_tell_which_is_bad() {
    let (fixture, solver) = (fixture("cylinder-plane"), robust(1));
    let noticed = (0..trials(500)).filter(|trial| {
        let measurement = Measurement::random(&*fixture, &[4, 3], 1, *trial);
        let problem = measurement.problem(&*fixture);
        match solver.solve(&problem) {
            // A touch that others do not check shows in nothing.
            Ok(solution) => {
                assert!(solution.excluded.is_empty());
                let refused = support::solver("least-squares").solve(&problem).is_err();
                assert!(!refused, "trial {trial}");
                false
            }
            Err(SolveError::Inconsistent(refusal)) => {
                assert_eq!(refusal.touches, [0, 1, 2, 3, 4, 5, 6]);
                assert!(refusal.message.contains("noticed, but never told"), "{}", refusal.message);
                assert!(
                    refusal.help.contains("one more touch on each of `cylinder` and `plane`"),
                    "{}",
                    refusal.help
                );
                true
            }
            Err(_) => false,
        }
    });
    assert!(noticed.count() > 100);
}

/// Nine touches tell one bad one wherever theory says so, and never accuse another.
#[test]
fn nine_touches_tell_which_is_bad() {
    for (kind, counts) in
        [("cylinder-plane", &[5, 4][..]), ("three-sphere", &[3, 3, 3]), ("cube", &[3, 0, 3, 0, 3, 0])]
    {
        let [all, good] = study(kind, counts, 1, 1, trials(800));
        assert_eq!((all.wrongly_named, all.misled), (0, 0));
        // What is not noticed may be wrong, in this solver as in every other; what is named is right.
        assert!(all.wrong <= all.unnoticed);
        assert!(5 * good.trials > all.trials, "hardly any are well conditioned");
        assert!(100 * good.named >= 99 * good.trials, "{good:?}");
        assert_eq!(good.unnoticed, 0);
    }
}

/// Two bad touches are told where redundancy allows; where it does not, and two are reckoned with, nothing is named.
#[test]
fn two_bad_touches_are_told_as_a_pair() {
    let [all, good] = study("cylinder-plane", &[8, 6], 2, 2, trials(60));
    assert_eq!((all.wrongly_named, all.misled, all.wrong), (0, 0, 0));
    assert!(2 * good.trials > all.trials && 100 * good.named >= 99 * good.trials, "{good:?}");
    let [all, good] = study("cylinder-plane", &[8, 6], 1, 2, trials(60));
    assert_eq!((all.wrongly_named, all.misled, all.wrong), (0, 0, 0));
    assert!(2 * good.trials > all.trials && 100 * good.named >= 99 * good.trials, "{good:?}");
    let [all, _] = study("cylinder-plane", &[5, 4], 2, 2, trials(200));
    assert_eq!((all.named, all.wrongly_named, all.misled), (0, 0, 0));
    assert!(all.wrong <= all.unnoticed);
    // The assumption that one at most is bad, where two are: measured, not promised.
    study("cylinder-plane", &[5, 4], 2, 1, trials(200));
}

/// Of sound measurements no more are accused than the level at which touches are inconsistent; in truth far fewer.
#[test]
fn sound_touches_are_not_accused() {
    const LEVEL: f64 = 1e-3;
    let trials = trials(10_000);
    for (kind, counts) in
        [("cylinder-plane", &[5, 4][..]), ("cylinder-plane", &[8, 6]), ("three-sphere", &[3, 3, 3])]
    {
        let (fixture, solver) = (fixture(kind), robust(1));
        let outcomes = (0..trials).into_par_iter().map(|trial| {
            let measurement = Measurement::random(&*fixture, counts, 0, trial);
            match solver.solve(&measurement.problem(&*fixture)) {
                Ok(solution) => [u64::from(!solution.excluded.is_empty()), 0],
                Err(refusal) => [0, u64::from(refusal.code() == "inconsistent")],
            }
        });
        let [accused, inconsistent] = outcomes.reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        println!("{kind} {counts:?}, none bad: {accused} accused, {inconsistent} inconsistent, of {trials}");
        // Five standard deviations of chance.
        let most = LEVEL * trials as f64 + 5.0 * (LEVEL * trials as f64).sqrt();
        assert!((accused + inconsistent) as f64 <= most);
        assert!(accused as f64 <= 0.1 * most);
    }
}

/// Which touches cannot be told apart is what linear theory says: suspects are all those that it cannot tell from the bad
/// one, and others only where a frame far off, or a search that is not complete, speaks for them.
#[test]
fn suspects_are_those_of_theory() {
    let layouts: [(&str, &[usize]); 9] = [
        ("cylinder-plane", &[5, 3]),
        ("cylinder-plane", &[4, 4]),
        ("cylinder-plane", &[6, 3]),
        ("cylinder-plane", &[5, 4]),
        ("three-sphere", &[4, 3, 3]),
        ("three-sphere", &[3, 3, 3]),
        ("cube", &[3, 0, 3, 0, 2, 0]),
        ("cube", &[4, 0, 3, 0, 2, 0]),
        ("cube", &[3, 0, 3, 0, 3, 0]),
    ];
    for (kind, counts) in layouts {
        let fixture = fixture(kind);
        let (mut never, mut same, mut more) = (0, 0, 0);
        for trial in 0..trials(150) {
            let measurement = Measurement::random(&*fixture, counts, 1, trial);
            let exact = Problem::new(&*fixture, &measurement.exact, measurement.probe).unwrap();
            let (n, (q, condition)) = (measurement.touches.len(), cofactors(&exact, &measurement.truth));
            let level = chi_square_level(1e-6, n - 7);
            let error = measurement.error();
            // Beyond doubt, by five standard deviations either way, as far as linear theory goes.
            let left: Vec<f64> = (0..n).map(|rival| left_over(&q, &error, &[rival])).collect();
            let noticed = error.dot(&(&q * &error)) > (chi_square_level(1e-3, n - 6).sqrt() + 5.0).powi(2);
            if condition > 30.0 || !noticed {
                continue;
            }
            let suspects = match robust(1).solve(&measurement.problem(&*fixture)) {
                Ok(solution) => solution.excluded,
                Err(SolveError::Inconsistent(refusal)) if !refusal.touches.is_empty() => refusal.touches,
                Err(SolveError::NotValidated(refusal) | SolveError::Ambiguous(refusal)) => refusal.touches,
                _ => continue,
            };
            let what = format!(
                "{kind} {counts:?}, trial {trial}, bad {:?}, {suspects:?}, {left:?}",
                measurement.bad
            );
            let alike = |rival: &usize| left[*rival] < 1e-9 * OFF * OFF;
            let expected: Vec<usize> = (0..n).filter(alike).collect();
            assert!(expected.iter().all(|rival| suspects.contains(rival)), "{what}");
            never += u32::from(expected.len() > 1);
            let beyond: Vec<usize> = suspects.iter().copied().filter(|rival| !alike(rival)).collect();
            same += u32::from(beyond.is_empty());
            more += u32::from(!beyond.is_empty());
            for rival in beyond {
                let mut rest = measurement.touches.clone();
                rest.remove(rival);
                let rest = Problem::new(&*fixture, &rest, measurement.probe).unwrap();
                let searched = fixture.can_search(&rest.counts()).then(|| minima(&rest)).flatten();
                let fits = searched.is_none_or(|minima| minima.iter().any(|end| end.chi_square <= level));
                assert!(fits, "{what}: {rival}");
            }
        }
        println!(
            "{kind} {counts:?}: {same} as theory says, {more} with others, in {never} the bad one has equals"
        );
        assert!(same + more > 20);
    }
}

/// Sound touches: the answer of `least-squares`, to the last digit.
#[test]
fn consistent_touches_are_solved_as_by_least_squares() {
    for (kind, counts) in
        [("cylinder-plane", &[4, 3][..]), ("three-sphere", &[3, 3, 3]), ("cube", &[3, 0, 2, 0, 2, 0])]
    {
        let fixture = fixture(kind);
        for trial in 0..50 {
            let measurement = Measurement::random(&*fixture, counts, 0, trial);
            let problem = measurement.problem(&*fixture);
            let [expected, got] =
                ["least-squares", "robust"].map(|name| support::solver(name).solve(&problem));
            match (expected, got) {
                (Ok(expected), Ok(mut got)) => {
                    got.solver = expected.solver;
                    assert_eq!(got, expected);
                }
                (Err(expected), Err(got)) => assert_eq!(got.code(), expected.code()),
                (expected, got) => panic!("{kind}, trial {trial}: {got:?}, not {expected:?}"),
            }
        }
    }
}

/// The frame without the bad touch is that of the others alone; and which touch is first does not matter.
#[test]
fn the_frame_is_that_of_the_other_touches() {
    let fixture = fixture("cylinder-plane");
    let mut named = 0;
    for trial in 0..60 {
        let measurement = Measurement::random(&*fixture, &[6, 5], 1, trial);
        let outcome = robust(1).solve(&measurement.problem(&*fixture));
        let Ok(solution) = outcome else { continue };
        let [bad] = measurement.bad[..] else { unreachable!() };
        if solution.excluded.is_empty() {
            continue;
        }
        named += 1;
        assert_eq!(solution.excluded, [bad]);
        assert_eq!(solution.residuals.len(), 11);
        let off = solution.residuals[bad].normalized.unwrap();
        assert!((off.abs() - OFF).abs() < 20.0, "{off}");
        assert_eq!(solution.warnings.iter().filter(|warning| warning.code == "touch-excluded").count(), 1);

        let mut others = measurement.touches.clone();
        let moved = others.remove(bad);
        let alone = Problem::new(&*fixture, &others, measurement.probe).unwrap();
        let alone = support::solver("least-squares").solve(&alone).unwrap();
        assert_eq!((solution.frame, solution.covariance), (alone.frame, alone.covariance));
        assert_eq!((solution.chi_square, solution.rms), (alone.chi_square, alone.rms));

        others.push(moved);
        let reordered = Problem::new(&*fixture, &others, measurement.probe).unwrap();
        let reordered = robust(1).solve(&reordered).unwrap();
        assert_eq!((reordered.excluded.as_slice(), reordered.frame), (&[10][..], alone.frame));
    }
    assert!(named > 40, "{named}");
}

/// An uncertain radius and tip, and an expected frame, take part as in `least-squares`.
#[test]
fn uncertain_sizes_and_an_expected_frame_take_part() {
    let radius = Value::Number { value: 20.0, u: 0.02 };
    let fixture = support::fixture("cylinder-plane", &Parameters::new().with("radius", radius));
    let (mut named, mut adjusted) = (0, 0);
    for trial in 0..60 {
        let mut measurement = Measurement::random(&*fixture, &[6, 5], 1, trial);
        measurement.probe.tip_radius_u = 0.01;
        let problem = measurement.problem(&*fixture).near(measurement.truth);
        if let Ok(solution) = robust(1).solve(&problem) {
            assert!(solution.excluded.is_empty() || solution.excluded == measurement.bad);
            assert!(
                solution.squared_distance(&measurement.truth).unwrap() < 53.34
                    || solution.excluded.is_empty()
            );
            named += u32::from(!solution.excluded.is_empty());
            adjusted += u32::from(solution.adjustments.len() == 2);
        }
    }
    assert!(named > 40 && adjusted > 40, "{named} {adjusted}");
}

/// Too many touches to try every pair are refused at once, with the one that explains.
#[test]
fn too_many_subsets_are_refused() {
    let fixture = fixture("cylinder-plane");
    let measurement = Measurement::random(&*fixture, &[60, 50], 1, 0);
    let problem = measurement.problem(&*fixture);
    assert_eq!(robust(1).solve(&problem).unwrap().excluded, measurement.bad);
    let refusal = robust(2).solve(&problem).unwrap_err();
    assert!(refusal.to_string().contains("more than 5000 searches"), "{refusal}");
    assert_eq!(refusal.refusal().unwrap().touches, measurement.bad);
}

/// However far a bad touch is off, no other one is named, and a frame without it is right.
#[test]
fn no_sound_touch_is_named_whatever_the_error() {
    for (kind, counts) in [
        ("cylinder-plane", &[5, 4][..]),
        ("cylinder-plane", &[8, 6]),
        ("three-sphere", &[3, 3, 3]),
        ("cube", &[3, 0, 3, 0, 3, 0]),
    ] {
        let (fixture, solver) = (fixture(kind), robust(1));
        let tallies = (0..trials(500)).into_par_iter().map(|trial| {
            let measurement = Measurement::with_errors(&*fixture, counts, 1, [1.0, 1e4], trial);
            let outcome = solver.solve(&measurement.problem(&*fixture));
            let tally = Tally::of(&measurement, &outcome);
            let named = outcome.is_ok_and(|solution| !solution.excluded.is_empty());
            assert!(!named || tally.wrong == 0, "{kind}, trial {trial}");
            tally
        });
        let all = tallies.reduce(Default::default, Tally::plus);
        println!("{kind} {counts:?}, 1 bad by 1 to 10000 standard deviations: {all:?}");
        assert_eq!(all.wrongly_named, 0);
    }
}

/// A radius that is wrong is not taken for a bad touch.
#[test]
fn a_wrong_size_is_no_bad_touch() {
    let real = fixture("cylinder-plane");
    for (off, counts) in [(0.05, [5, 4]), (0.2, [5, 4]), (1.0, [5, 4]), (0.05, [8, 6]), (0.2, [8, 6])] {
        let stated = support::cylinder_plane(20.0 + off, 45.0);
        for assumed in [1, 2] {
            let trials = trials(200);
            let named = (0..trials).into_par_iter().filter(|trial| {
                let measurement = Measurement::random(&*real, &counts, 0, *trial);
                let outcome = robust(assumed).solve(&measurement.problem(&*stated));
                outcome.is_ok_and(|solution| !solution.excluded.is_empty())
            });
            let named = named.count();
            println!("radius off by {off}, {counts:?}, at most {assumed} bad: {named} of {trials} named");
            assert_eq!(named, 0);
        }
    }
}
