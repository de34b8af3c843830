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
use touchref::{
    Fixture, Frame, Observability, Parameters, Probe, Problem, Solution, SolveError, Solver, Touch,
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

fn trials(few: u64) -> u64 {
    std::env::var("TRIALS").ok().and_then(|text| text.parse().ok()).unwrap_or(few)
}

/// The fixtures of the studies.
fn fixture(kind: &str) -> Box<dyn Fixture> {
    support::fixture(kind, &support::settings(kind)[0])
}

/// `robust` for at most so many bad touches.
fn robust(bad: &str) -> Box<dyn Solver> {
    let plugin = touchref::registry().unwrap().solver("robust").unwrap();
    plugin.build(&Parameters::new().with("bad", bad)).unwrap()
}

/// A simulated measurement, some of its touches off along their normals.
struct Measurement {
    touches: Vec<Touch>,
    /// The same without noise.
    exact: Vec<Touch>,
    truth: Frame,
    probe: Probe,
    bad: Vec<usize>,
}

impl Measurement {
    /// At random places, so many on each surface, so many of them bad.
    fn random(fixture: &dyn Fixture, counts: &[usize], bad: usize, trial: u64) -> Self {
        let mut rng = generator(4 + bad as u64, trial);
        let layout = random_layout(fixture, counts, &mut rng);
        let truth = random_frame(1000.0, &mut rng);
        let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };
        let mut exact = simulate(fixture, &layout, &truth, &probe, 0.0, &mut rng);
        let mut touches = simulate(fixture, &layout, &truth, &probe, SIGMA, &mut rng);
        let bad = rand::seq::index::sample(&mut rng, touches.len(), bad).into_vec();
        for &index in &bad {
            let seen = fixture.surfaces()[layout[index].0].seen_from(&layout[index].1);
            let way = if rng.random() { OFF } else { -OFF };
            for touches in [&mut touches, &mut exact] {
                touches[index].at += truth.rotation * seen.normal * (way * SIGMA);
            }
        }
        let mut bad = bad;
        bad.sort_unstable();
        Self { touches, exact, truth, probe, bad }
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
    /// Refused with suspects, the bad ones among them.
    suspected: u64,
    /// Refused with suspects, but not the bad ones.
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
                let all = measurement.bad.iter().all(|bad| suspects.contains(bad));
                match (suspects.is_empty(), all) {
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

/// Random layouts with bad touches: the tally of all, and of those that are well conditioned by their true geometry.
fn study(kind: &str, counts: &[usize], bad: usize, assumed: &str, trials: u64) -> [Tally; 2] {
    let (fixture, solver) = (fixture(kind), robust(assumed));
    let tallies = (0..trials).into_par_iter().map(|trial| {
        let measurement = Measurement::random(&*fixture, counts, bad, trial);
        let tally = Tally::of(&measurement, &solver.solve(&measurement.problem(&*fixture)));
        [tally, if is_well_conditioned(&*fixture, &measurement) { tally } else { Tally::default() }]
    });
    let [all, good] =
        tallies.reduce(Default::default, |one, other| [one[0].plus(other[0]), one[1].plus(other[1])]);
    println!("{kind} {counts:?}, {bad} bad of at most {assumed}\n  all  {all:?}\n  good {good:?}");
    [all, good]
}

/// Beforehand, by the true geometry: the frame is well determined with the bad touches and without; no other frame comes
/// near the sound touches; and whatever is taken for bad instead of the bad ones is seen not to be, by five standard
/// deviations.
fn is_well_conditioned(fixture: &dyn Fixture, measurement: &Measurement) -> bool {
    const CONDITION: f64 = 100.0;
    const CHANCE: f64 = 5.0;
    let Measurement { exact, truth, bad, probe, .. } = measurement;
    let n = exact.len();
    let without = |left_out: &[usize]| -> Vec<Touch> {
        (0..n).filter(|index| !left_out.contains(index)).map(|index| exact[index]).collect()
    };
    let all = Problem::new(fixture, exact, *probe).unwrap();
    let sound = without(bad);
    let sound = Problem::new(fixture, &sound, *probe).unwrap();
    let level = (chi_square_level(1e-6, n - 6 - bad.len()).sqrt() + CHANCE).powi(2);
    let is_seen = |rival: usize| {
        let rest = without(&[rival]);
        let minima = minima(&Problem::new(fixture, &rest, *probe).unwrap());
        minima.is_some_and(|minima| minima.iter().all(|end| end.chi_square > level))
    };
    cofactors(&all, truth).1 < CONDITION
        && cofactors(&sound, truth).1 < CONDITION
        && minima(&sound).is_some_and(|minima| {
            minima.iter().all(|end| end.chi_square > level || is_at(fixture, &end.frame, truth))
        })
        && (0..n).filter(|rival| !bad.contains(rival)).all(is_seen)
}

fn is_at(fixture: &dyn Fixture, frame: &Frame, truth: &Frame) -> bool {
    truth.twist_to(frame).extent(fixture.size()) < 1e-6
}

/// Every frame that comes near touches; `None` where so few, or so weak ones, do not let them all be found.
fn minima(problem: &Problem<'_>) -> Option<Vec<Minimum>> {
    /// Of the stated noise: the level that rivals must exceed is as far beyond that of the solver.
    const FAR: f64 = 2.0;
    let mut starts = Vec::new();
    let closed_form = problem.fixture().closed_form().unwrap();
    let complete_up_to = closed_form.candidates(problem, FAR, &mut |frame| starts.push(frame)).ok()?;
    let ends = starts.iter().filter_map(|start| descend(problem, &[], start));
    let ends = ends.filter(|end| problem.fixture().objection(problem, &end.frame).is_none());
    (complete_up_to > FAR).then(|| ends.collect())
}

#[test]
fn explore() {
    for (kind, counts, bad, assumed) in [
        ("cylinder-plane", &[4, 3][..], 1, "1"),
        ("cylinder-plane", &[5, 3], 1, "1"),
        ("cylinder-plane", &[4, 4], 1, "1"),
        ("cylinder-plane", &[6, 3], 1, "1"),
        ("cylinder-plane", &[5, 4], 1, "1"),
        ("three-sphere", &[3, 3, 3], 1, "1"),
        ("cube", &[3, 0, 3, 0, 3, 0], 1, "1"),
        ("cylinder-plane", &[5, 4], 2, "2"),
        ("cylinder-plane", &[5, 4], 2, "1"),
        ("cylinder-plane", &[8, 6], 1, "1"),
        ("cylinder-plane", &[8, 6], 1, "2"),
        ("cylinder-plane", &[8, 6], 2, "2"),
    ] {
        let started = std::time::Instant::now();
        study(kind, counts, bad, assumed, trials(300));
        println!("  {:?}", started.elapsed());
    }
    let fixture = fixture("cylinder-plane");
    for (counts, trial) in [([4, 3], 3), ([5, 3], 1), ([5, 4], 0), ([5, 4], 3)] {
        let m = Measurement::random(&*fixture, &counts, 1, trial);
        match support::solver("robust").solve(&m.problem(&*fixture)) {
            Ok(s) => println!("{:?}\n {:?} {:?}", m.bad, s.excluded, s.warnings),
            Err(e) => println!("{:?}\n {e}\n  {}", m.bad, e.help()),
        }
    }
}
