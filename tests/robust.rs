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

/// A simulated measurement, some of its touches off along their normals.
struct Measurement {
    touches: Vec<Touch>,
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
        let mut touches = simulate(fixture, &layout, &truth, &probe, SIGMA, &mut rng);
        let bad = rand::seq::index::sample(&mut rng, touches.len(), bad).into_vec();
        for &index in &bad {
            let seen = fixture.surfaces()[layout[index].0].seen_from(&layout[index].1);
            let way = if rng.random() { OFF } else { -OFF };
            touches[index].at += truth.rotation * seen.normal * (way * SIGMA);
        }
        let mut bad = bad;
        bad.sort_unstable();
        Self { touches, truth, probe, bad }
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
            refused: self.refused + other.refused,
        }
    }
}

/// Random layouts with bad touches: the tally of all, and of those that are well conditioned by their true geometry.
fn study(kind: &str, counts: &[usize], bad: usize, trials: u64) -> [Tally; 2] {
    let (fixture, solver) = (fixture(kind), support::solver("robust"));
    let tallies = (0..trials).into_par_iter().map(|trial| {
        let measurement = Measurement::random(&*fixture, counts, bad, trial);
        let problem = measurement.problem(&*fixture);
        let tally = Tally::of(&measurement, &solver.solve(&problem));
        [tally, if is_well_conditioned(&measurement, &problem) { tally } else { Tally::default() }]
    });
    let [all, good] =
        tallies.reduce(Default::default, |one, other| [one[0].plus(other[0]), one[1].plus(other[1])]);
    println!("{kind} {counts:?}, {bad} bad\n  all  {all:?}\n  good {good:?}");
    [all, good]
}

/// Beforehand, by the true geometry: every touch is checked, and whatever is taken for bad instead of what is must be
/// seen not to be, by five standard deviations.
fn is_well_conditioned(measurement: &Measurement, problem: &Problem<'_>) -> bool {
    const CONDITION: f64 = 100.0;
    const REDUNDANCY: f64 = 0.1;
    const CHANCE: f64 = 5.0;
    let (q, condition) = cofactors(problem, &measurement.truth);
    let n = measurement.touches.len();
    let bad = &measurement.bad;
    let mut error = DVector::zeros(n);
    for &index in bad {
        error[index] = OFF;
    }
    let level = (chi_square_level(1e-6, n - 6 - bad.len()).sqrt() + CHANCE).powi(2);
    condition < CONDITION
        && (0..n).all(|i| q[(i, i)] >= REDUNDANCY)
        && (0..n).all(|rival| bad.contains(&rival) || left_over(&q, &error, &[rival]) > level)
}

#[test]
fn explore() {
    for (kind, counts, bad) in [
        ("cylinder-plane", &[4, 3][..], 1),
        ("cylinder-plane", &[5, 3], 1),
        ("cylinder-plane", &[4, 4], 1),
        ("cylinder-plane", &[6, 3], 1),
        ("cylinder-plane", &[5, 4], 1),
        ("three-sphere", &[3, 3, 3], 1),
        ("cube", &[3, 0, 3, 0, 3, 0], 1),
        ("cylinder-plane", &[5, 4], 2),
        ("cylinder-plane", &[8, 6], 1),
        ("cylinder-plane", &[8, 6], 2),
    ] {
        let started = std::time::Instant::now();
        study(kind, counts, bad, trials(300));
        println!("  {:?}", started.elapsed());
    }
    let fixture = fixture("cylinder-plane");
    for (counts, trial) in [([4, 3], 1), ([5, 3], 1), ([5, 3], 2), ([5, 4], 0), ([6, 3], 1),([5,4],1),([5,4],2),([5,4],3)] {
        let m = Measurement::random(&*fixture, &counts, 1, trial);
        match support::solver("robust").solve(&m.problem(&*fixture)) {
            Ok(s) => println!("{:?}\n {:?} {:?}", m.bad, s.excluded, s.warnings),
            Err(e) => println!("{:?}\n {e}\n  {}", m.bad, e.help()),
        }
    }
}
