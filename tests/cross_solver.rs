//! Every pair of solvers, on every fixture, on the same touches: they agree within their stated uncertainty, or one of
//! them refuses; and none hands out a frame far from the truth.
//!
//! Beside the solvers that are linked in stands a reference that shares no code with them: Newton's method from every
//! candidate.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use std::{collections::BTreeMap, fmt};

use nalgebra::{Matrix6, RowVector6};
use rand::{RngExt, seq::SliceRandom};
use rayon::prelude::*;
use touchref::{
    Covariance, Fixture, Frame, Limit, Observability, Parameters, Probe, Problem, Residual, SigmaSource,
    Solution, SolveError, Solver, Touch, Trust,
    analysis::{
        reference::{Minimum, condition, descend},
        simulation::{generator, random_frame, random_layout, simulate},
        study::WRONG_LEVEL,
    },
    registry,
    statistics::chi_square_level,
};

/// Measurements of each kind, for each fixture, shared by the settings it is tried with.
const TRIALS: u64 = 400;
/// Standard deviation of a touch, in parts of the fixture's size.
const NOISE: f64 = 1e-4;
/// The same where several frames fit.
const LOUD: f64 = 3e-3;
/// Frames of exact touches are the same to this: parts of the fixture's size, radians.
const EXACT: f64 = 1e-9;
/// Squared difference of two frames in the sum of their covariances, beyond the level at which a frame counts as wrong:
/// two estimates of the same touches differ by less than two of different ones would.
fn most_apart() -> f64 {
    chi_square_level(WRONG_LEVEL, 6)
}

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    /// The nominal layout or a random one, without noise.
    Exact,
    /// The nominal layout.
    Nominal,
    /// The fewest touches, at random places.
    Minimal,
    /// More, at random places.
    Redundant,
    /// As many touches as needed, but of five points: a motion is free.
    Degenerate,
    /// The fewest touches, with so much noise that often several frames fit.
    Ambiguous,
}

const KINDS: [Kind; 6] =
    [Kind::Exact, Kind::Nominal, Kind::Minimal, Kind::Redundant, Kind::Degenerate, Kind::Ambiguous];

impl Kind {
    /// Noise of the touches, and the sigma that is stated of it; in parts of the size.
    fn noise(self, trial: u64) -> (f64, f64) {
        match self {
            Self::Exact => (0.0, NOISE),
            // Half of them exact: there the free motion is exactly free.
            Self::Degenerate => (NOISE * (trial % 2) as f64, NOISE),
            Self::Ambiguous => (LOUD, LOUD),
            _ => (NOISE, NOISE),
        }
    }

    /// The touches of a trial, and the true frame.
    fn measurement(self, fixture: &dyn Fixture, trial: u64) -> (Vec<Touch>, Frame, Probe) {
        let mut rng = generator(81 + self as u64, trial);
        let alternatives = &fixture.requirement().alternatives;
        let mut counts = alternatives[rng.random_range(0..alternatives.len())].clone();
        let more = match self {
            Self::Redundant => rng.random_range(1..=8),
            Self::Exact => rng.random_range(0..=4),
            _ => 0,
        };
        let touched: Vec<usize> = (0..counts.len()).filter(|surface| counts[*surface] > 0).collect();
        for _ in 0..more {
            counts[touched[rng.random_range(0..touched.len())]] += 1;
        }
        let nominal = self == Self::Nominal || (self == Self::Exact && trial.is_multiple_of(4));
        let mut layout =
            if nominal { fixture.nominal_layout() } else { random_layout(fixture, &counts, &mut rng) };
        if self == Self::Degenerate {
            layout.shuffle(&mut rng);
            let (points, repeated) = layout.split_at_mut(5);
            for place in repeated {
                *place = *points.iter().find(|point| point.0 == place.0).unwrap_or(&points[0]);
            }
        }
        let truth = random_frame(10.0 * fixture.size(), &mut rng);
        let (noise, sigma) = self.noise(trial);
        let tip_radius = 0.01 * fixture.size() * (trial % 3) as f64;
        let probe = Probe { tip_radius, tip_radius_u: 0.0, sigma: Some(sigma * fixture.size()) };
        let touches = simulate(fixture, &layout, &truth, &probe, noise * fixture.size(), &mut rng);
        (touches, truth, probe)
    }
}

/// Newton's method from every candidate; refuses whatever is not plain.
#[derive(Debug)]
struct Reference;

impl Solver for Reference {
    fn name(&self) -> &'static str {
        "reference"
    }

    fn solve(&self, problem: &Problem<'_>) -> Result<Solution, SolveError> {
        /// Minima this near are one: parts of the size, radians.
        const SAME: f64 = 1e-6;
        /// A layout above this condition, or a motion above this standard deviation (parts of the size, radians), is
        /// weak.
        const WEAK: f64 = 100.0;
        const UNSURE: f64 = 0.02;
        problem.require_enough()?;
        let fixture = problem.fixture();
        let size = fixture.size();
        let closed_form = fixture.closed_form().ok_or_else(|| refused("no closed form"))?;
        let mut starts = Vec::new();
        let complete_up_to = closed_form.candidates(problem, 1.0, &mut |frame| starts.push(frame))?;
        if complete_up_to < 1.0 {
            return Err(refused("incomplete"));
        }
        let mut minima: Vec<Minimum> = Vec::new();
        for end in starts.iter().filter_map(|start| descend(problem, &[], start)) {
            let known = minima.iter().any(|m| m.frame.twist_to(&end.frame).extent(size) < SAME);
            if !known && fixture.objection(problem, &end.frame).is_none() {
                minima.push(end);
            }
        }
        minima.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        let degrees = problem.touches().len() - 6;
        let level = |chance| if degrees == 0 { 1e-9 } else { chi_square_level(chance, degrees) };
        let best = match minima.as_slice() {
            [best, ..] if best.chi_square > level(1e-3) => return Err(refused("inconsistent")),
            [_, second, ..] if second.chi_square < level(1e-6) => return Err(refused("ambiguous")),
            [best, ..] => best,
            [] => return Err(refused("no minimum")),
        };
        let mut information = Matrix6::zeros();
        for index in 0..problem.touches().len() {
            let contact = problem.contact(&best.frame, index);
            let row = RowVector6::from_row_slice(&contact.gradient()) / contact.sigma;
            information += row.transpose() * row;
        }
        if condition(problem, &[], &best.frame) > WEAK {
            return Err(refused("weak layout"));
        }
        let along_fixture = information.cholesky().ok_or_else(|| refused("singular"))?.inverse();
        let scale = Matrix6::from_diagonal(&[1.0, 1.0, 1.0, size, size, size].map(|s| s / size).into());
        if (scale * along_fixture * scale).symmetric_eigenvalues().max().sqrt() > UNSURE {
            return Err(refused("unsure"));
        }

        let residuals = (0..problem.touches().len()).map(|index| {
            let contact = problem.contact(&best.frame, index);
            Residual { length: contact.residual, normalized: Some(contact.residual / contact.sigma) }
        });
        let sigma = problem.reference_sigma().ok_or_else(|| refused("no sigma"))?;
        let trust = Trust {
            sigma: Some(sigma),
            from_sigma: 0.0,
            up_to_sigma: sigma,
            limited_by: Limit::Search,
            second_minimum: None,
            nonlinearity: None,
        };
        let observability = Observability::at(problem, &best.frame);
        let mut solution = Solution::new("reference", best.frame, residuals.collect(), trust, observability);
        let matrix = best.frame.to_parent_axes(&along_fixture);
        solution.covariance = Some(Covariance { matrix, sigma, sigma_source: SigmaSource::Given });
        Ok(solution)
    }
}

fn refused(because: &str) -> SolveError {
    SolveError::InvalidTouches { problem: because.to_owned(), help: "none".to_owned(), touches: Vec::new() }
}

/// What became of the measurements of one kind, for two solvers.
#[derive(Debug, Default, Clone)]
struct Tally {
    agreed: u64,
    only: [u64; 2],
    neither: u64,
    /// Largest squared difference of two accepted frames, in the sum of their covariances.
    apart: f64,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { agreed, only: [first, second], neither, apart } = self;
        write!(f, "{agreed:5} {first:6} {second:6} {neither:8}   {apart:.1e}")
    }
}

/// Squared difference of two frames, in the sum of their covariances.
fn apart(one: &Solution, other: &Solution) -> f64 {
    let covariance = one.covariance.unwrap().matrix + other.covariance.unwrap().matrix;
    let difference = one.frame.error_to(&other.frame);
    difference.dot(&covariance.cholesky().unwrap().solve(&difference))
}

/// Nobody's frame is far from the truth.
fn assert_right(outcome: &Result<Solution, SolveError>, truth: &Frame, size: f64, exact: bool, what: &str) {
    let Ok(solution) = outcome else { return };
    let squared = solution.squared_distance(truth).unwrap();
    assert!(squared <= most_apart(), "{what}: {} is wrong: squared error {squared}", solution.solver);
    let off = solution.frame.twist_to(truth).extent(size);
    assert!(!exact || off < EXACT, "{what}: {} is off by {off:e} on exact touches", solution.solver);
}

/// All solvers on the measurements of one kind: a tally for each pair.
fn tallies(
    solvers: &[Box<dyn Solver>],
    fixture: &dyn Fixture,
    kind: Kind,
    trials: u64,
) -> BTreeMap<(&'static str, &'static str), Tally> {
    let outcomes: Vec<Vec<Result<Solution, SolveError>>> = (0..trials)
        .into_par_iter()
        .map(|trial| {
            let (touches, truth, probe) = kind.measurement(fixture, trial);
            let problem = Problem::new(fixture, &touches, probe).unwrap();
            let what = format!("{} {:?}, {kind:?}, trial {trial}", fixture.kind(), fixture.parameters());
            let outcomes: Vec<_> = solvers.iter().map(|solver| solver.solve(&problem)).collect();
            for outcome in &outcomes {
                assert_right(outcome, &truth, fixture.size(), kind == Kind::Exact, &what);
                let exactly_free = kind == Kind::Degenerate && kind.noise(trial).0 == 0.0;
                assert!(!(exactly_free && outcome.is_ok()), "{what}: {outcome:?} although a motion is free");
            }
            outcomes
        })
        .collect();

    let mut tallies = BTreeMap::new();
    for (first, second) in (0..solvers.len()).flat_map(|j| (0..j).map(move |i| (i, j))) {
        let mut tally = Tally::default();
        for (trial, outcomes) in outcomes.iter().enumerate() {
            match (&outcomes[first], &outcomes[second]) {
                (Ok(one), Ok(other)) => {
                    let apart = apart(one, other);
                    assert!(
                        apart <= most_apart(),
                        "{}, {kind:?}, trial {trial}: {} and {} differ by {apart}",
                        fixture.kind(),
                        one.solver,
                        other.solver
                    );
                    let off = one.frame.twist_to(&other.frame).extent(fixture.size());
                    assert!(kind != Kind::Exact || off < EXACT, "{kind:?}, trial {trial}: {off:e} apart");
                    tally.agreed += 1;
                    tally.apart = tally.apart.max(apart);
                }
                (Ok(_), Err(_)) => tally.only[0] += 1,
                (Err(_), Ok(_)) => tally.only[1] += 1,
                (Err(_), Err(_)) => tally.neither += 1,
            }
        }
        tallies.insert((solvers[first].name(), solvers[second].name()), tally);
    }
    tallies
}

#[test]
fn two_solvers_agree_or_one_refuses() {
    let registry = registry().unwrap();
    let mut solvers: Vec<Box<dyn Solver>> = vec![Box::new(Reference)];
    // `global` takes a thousand times as long: tests/global.rs holds it against the others.
    let linked = registry.solvers().iter().filter(|plugin| plugin.name != "global");
    solvers.extend(linked.map(|plugin| plugin.build(&Parameters::new()).unwrap()));
    assert!(solvers.len() >= 2);
    for plugin in registry.fixtures() {
        let settings = support::settings(plugin.name);
        for parameters in settings.clone() {
            let fixture = plugin.build(&parameters).unwrap();
            // So does any search without a closed form to lead it.
            let share = if fixture.closed_form().is_some() { 1 } else { 40 };
            let trials = TRIALS.div_ceil(settings.len() as u64 * share);
            println!("\n{} {parameters:?}, {trials} measurements of each kind", plugin.name);
            println!("{:44}  both  first second  neither   furthest apart", "");
            let mut unsettled = 0;
            for kind in KINDS {
                for ((first, second), tally) in tallies(&solvers, &*fixture, kind, trials) {
                    println!("{:10} {:33} {tally}", format!("{kind:?}"), format!("{first}, {second}"));
                    // Two that refuse everything would agree, too.
                    if kind == Kind::Nominal && fixture.closed_form().is_some() {
                        assert!(2 * tally.agreed > trials, "{first} and {second} hardly ever answer both");
                    }
                    if kind == Kind::Ambiguous {
                        unsettled += trials - tally.agreed;
                    }
                }
            }
            assert!(unsettled > 0, "{}: no measurement was ambiguous", plugin.name);
        }
    }
}
