//! `global` held against `least-squares`, and its minima against those of random starts: for a test and a study.

use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use rand::RngExt;
use rayon::prelude::*;
use touchref::{
    Fixture, Frame, Probe, Problem, RootReport, Solution, SolveError, Solver, Touch,
    analysis::{
        reference::{Minimum, descend},
        simulation::{generator, random_frame, random_layout, simulate},
    },
    solvers::refinement,
};

/// Standard deviation of a touch, in parts of the fixture's size.
pub const SIGMA: f64 = 5e-4;
/// The same, so loud that a second frame often fits within it.
const LOUD: f64 = 5e-3;
/// Frames of two solvers are one: parts of the size, radians. Both descend to rounding.
const SAME_FRAME: f64 = 1e-7;
/// Minima are one, in the same measure: Newton's method settles both to rounding times a condition below 1e5.
const SAME_MINIMUM: f64 = 1e-6;
/// Starts at random.
const STARTS: usize = 200;

/// A measurement of a random layout; `sigma` in parts of the fixture's size.
pub fn measurement(
    fixture: &dyn Fixture,
    counts: &[usize],
    sigma: f64,
    seed: u64,
    trial: u64,
) -> (Vec<Touch>, Probe, Frame) {
    let mut rng = generator(seed, trial);
    let size = fixture.size();
    let layout = random_layout(fixture, counts, &mut rng);
    let truth = random_frame(10.0 * size, &mut rng);
    let sigma = sigma * size;
    let probe = Probe { tip_radius: 0.05 * size, tip_radius_u: 0.0, sigma: Some(sigma) };
    (simulate(fixture, &layout, &truth, &probe, sigma, &mut rng), probe, truth)
}

/// What became of the measurements that both solvers were given.
#[derive(Debug, Default, Clone, Copy)]
pub struct Agreement {
    pub both: u64,
    pub only_global: u64,
    pub only_other: u64,
    pub neither: u64,
    /// Both gave a frame, but not the same.
    pub apart: u64,
}

impl Agreement {
    fn plus(self, other: Self) -> Self {
        Self {
            both: self.both + other.both,
            only_global: self.only_global + other.only_global,
            only_other: self.only_other + other.only_other,
            neither: self.neither + other.neither,
            apart: self.apart + other.apart,
        }
    }
}

/// Both solvers on `trials` random measurements.
pub fn agreement(
    (global, other): (&dyn Solver, &dyn Solver),
    fixture: &dyn Fixture,
    counts: &[usize],
    seed: u64,
    trials: u64,
) -> Agreement {
    let one = |trial| {
        let (touches, probe, _) = measurement(fixture, counts, SIGMA, seed, trial);
        let problem = Problem::new(fixture, &touches, probe).unwrap();
        let mut tally = Agreement::default();
        match (global.solve(&problem), other.solve(&problem)) {
            (Ok(first), Ok(second)) => {
                let same = first.frame.twist_to(&second.frame).extent(fixture.size()) < SAME_FRAME;
                (tally.both, tally.apart) = (1, u64::from(!same));
            }
            (Ok(_), Err(_)) => tally.only_global = 1,
            (Err(_), Ok(_)) => tally.only_other = 1,
            (Err(_), Err(_)) => tally.neither = 1,
        }
        tally
    };
    (0..trials).into_par_iter().map(one).reduce(Agreement::default, Agreement::plus)
}

/// Minima that random starts lead to, and how many of them `global` has not found.
#[derive(Debug, Default, Clone, Copy)]
pub struct Completeness {
    /// Layouts of which `global` listed its minima: all that it did not call degenerate.
    pub layouts: u64,
    /// Minima of random starts.
    pub minima: u64,
    /// Those of them that `global` does not list.
    pub missed: u64,
    /// Minima that `global` lists.
    pub listed: u64,
}

impl Completeness {
    fn plus(self, other: Self) -> Self {
        Self {
            layouts: self.layouts + other.layouts,
            minima: self.minima + other.minima,
            missed: self.missed + other.missed,
            listed: self.listed + other.listed,
        }
    }
}

/// Every minimum that random starts lead to on `trials` ambiguous measurements, and whether `global` lists it.
///
/// Ambiguous: a second frame fits within the noise, which is [`LOUD`].
pub fn completeness(
    global: &dyn Solver,
    fixture: &dyn Fixture,
    counts: &[usize],
    seed: u64,
    trials: u64,
) -> Completeness {
    let one = |trial| {
        let (touches, probe, _) = measurement(fixture, counts, LOUD, seed, trial);
        let problem = Problem::new(fixture, &touches, probe).unwrap();
        let Err(SolveError::Ambiguous(refusal)) = global.solve(&problem) else {
            return Completeness::default();
        };
        let settle = |frame: &Frame| descend(&problem, &[], frame);
        let listed: Vec<Minimum> = refusal.roots.iter().filter_map(|root| settle(&root.frame)).collect();
        let found = distinct(
            starts(&problem, seed, trial).iter().filter_map(|start| {
                // Newton's method needs a start in the basin.
                settle(&refinement::descend(&problem, start).frame)
            }),
            fixture.size(),
        );
        let is_listed = |minimum: &&Minimum| listed.iter().any(|known| same(known, minimum, fixture.size()));
        Completeness {
            layouts: 1,
            minima: found.len() as u64,
            missed: found.iter().filter(|minimum| !is_listed(minimum)).count() as u64,
            listed: refusal.roots.len() as u64,
        }
    };
    (0..trials).into_par_iter().map(one).reduce(Completeness::default, Completeness::plus)
}

fn same(one: &Minimum, other: &Minimum, size: f64) -> bool {
    one.frame.twist_to(&other.frame).extent(size) < SAME_MINIMUM
}

fn distinct(minima: impl Iterator<Item = Minimum>, size: f64) -> Vec<Minimum> {
    let mut kept: Vec<Minimum> = Vec::new();
    for minimum in minima {
        if !kept.iter().any(|known| same(known, &minimum, size)) {
            kept.push(minimum);
        }
    }
    kept
}

/// Frames at random: any rotation, the origin within twice the fixture's size of the middle of the touches.
fn starts(problem: &Problem<'_>, seed: u64, trial: u64) -> Vec<Frame> {
    let mut rng = generator(seed + 1, trial);
    let touches = problem.touches();
    let middle = touches.iter().map(|touch| touch.at.coords).sum::<Vector3<f64>>() / touches.len() as f64;
    let one = |_| {
        let [w, x, y, z] = std::array::from_fn(|_| rng.sample::<f64, _>(rand_distr::StandardNormal));
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix();
        let offset = Vector3::from_fn(|_, _| rng.random_range(-2.0..=2.0) * problem.fixture().size());
        Frame { rotation, origin: Point3::from(middle + offset) }
    };
    (0..STARTS).map(one).collect()
}

/// The roots that a solver lists, of a frame or a refusal.
pub fn roots(outcome: &Result<Solution, SolveError>) -> &[RootReport] {
    match outcome {
        Ok(solution) => &solution.roots,
        Err(error) => error.refusal().map_or(&[], |refusal| &refusal.roots),
    }
}
