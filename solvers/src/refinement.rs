//! Least squares from a given start: the iteration alone, without a search for other frames or a verdict.
//!
//! [`refine`] is the plain loop. The same step is also an [`argmin::core::Solver`], so that argmin's
//! [`Executor`](argmin::core::Executor) can run, limit, and observe it:
//!
//! ```
//! # use touchref_core::{Frame, Problem};
//! use argmin::core::{Executor, State};
//! use touchref_solvers::refinement::{LevenbergMarquardt, Misfit};
//!
//! # fn example(problem: &Problem<'_>, start: Frame) -> Result<(), argmin::core::Error> {
//! let misfit = Misfit::<6>::new(problem, &[]);
//! let result = Executor::new(misfit, LevenbergMarquardt::default())
//!     .configure(|state| state.param(touchref_solvers::Unknowns::at(start)).max_iters(50))
//!     .run()?;
//! eprintln!("{:?} after {} iterations", result.state().get_termination_status(), result.state().get_iter());
//! # Ok(())
//! # }
//! ```
//!
//! K. Levenberg, "A method for the solution of certain non-linear problems in least squares" (1944), and
//! D. W. Marquardt, "An algorithm for least-squares estimation of nonlinear parameters" (1963), with the damping in
//! proportion to the diagonal; steps on the manifold as in J. Sola et al., "A micro Lie theory for state estimation in
//! robotics" (2018), right increments.

// In a WebAssembly module argmin's clock would be an import that its host has to bring: there is no argmin there.
#[cfg(not(target_family = "wasm"))]
mod executor;

use touchref_core::{Frame, Iteration, Problem, Solution, SolveError, Touch};

#[cfg(not(target_family = "wasm"))]
pub(crate) use executor::execute;
#[cfg(not(target_family = "wasm"))]
pub use executor::{LevenbergMarquardt, Misfit, RefinementState};

pub use crate::levenberg_marquardt::{Progress, Stop};
use crate::{
    acceptance::Standing,
    levenberg_marquardt::{Descent, STEPS, polish, settle},
    model::{Model, SquareRoot, Unknowns, uncertain, with_unknowns},
};

/// Where an iteration ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// The frame, and how far the uncertain dimensions and tip moved.
    pub unknowns: Unknowns,
    /// Squared misfit there, priors included; lengths squared where no sigma is stated.
    pub chi_square: f64,
    /// Steps made, and what ended them.
    pub iteration: Iteration,
    /// What each step did.
    pub history: Vec<Progress>,
}

/// The least-squares frame of a measurement that `start` leads to; uncertain dimensions and tip take part.
///
/// No search for other frames, no verdict: that is what a solver adds. Allocates for the history only.
///
/// # Errors
/// [`SolveError::NotConverged`], and [`SolveError::Unsupported`] for more uncertain dimensions than
/// [`MAX_EXTRAS`](crate::MAX_EXTRAS).
pub fn refine(problem: &Problem<'_>, start: &Frame) -> Result<Refinement, SolveError> {
    let extras = uncertain(problem);
    with_unknowns!(extras.len(), P => {
        let model = Model::<P>::new(problem, &extras);
        let (history, at, stop) = followed(&model, Unknowns::at(*start));
        let Ended { at, chi_square, iteration, .. } = ended(&model, &at, history.len(), stop)?;
        Ok(Refinement { unknowns: at, chi_square, iteration, history })
    })
}

/// Where a plain descent ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Descended {
    /// The frame.
    pub frame: Frame,
    /// Squared misfit there; lengths squared where no sigma is stated.
    pub chi_square: f64,
    /// Steps tried.
    pub steps: usize,
    /// Why it ended.
    pub stop: Stop,
}

/// The plain loop over [`refine`]'s steps, all dimensions taken as known: to 1e-4 standard deviations, as many frames
/// are wanted and none is to be polished. Allocates nothing.
#[must_use]
pub fn descend(problem: &Problem<'_>, start: &Frame) -> Descended {
    let model = Model::<6>::new(problem, &[]);
    let mut descent = Descent::from(&model, Unknowns::at(*start));
    let mut end = None;
    let mut steps = 0;
    while end.is_none() && steps < STEPS {
        end = descent.advance(&model).1;
        steps += 1;
    }
    let (frame, chi_square) = (descent.at.frame, descent.chi_square());
    Descended { frame, chi_square, steps, stop: end.unwrap_or(Stop::Iterations) }
}

/// The same as [`refine`], in a solver's own hands.
#[cfg(target_family = "wasm")]
pub(crate) fn execute<const P: usize>(
    model: &Model<'_, P>,
    start: &Unknowns,
) -> Result<Ended<P>, SolveError> {
    let (history, at, stop) = followed(model, *start);
    ended(model, &at, history.len(), stop)
}

/// What each step did on the way to a solution: from the start of the search that led to it, and from the minimum it found
/// to the frame. The steps are made once more, so that a solver that nobody watches need not keep them.
///
/// Empty for a frame that is no end of an iteration, as a root of a closed form.
///
/// # Errors
/// [`SolveError::Unsupported`] for more uncertain dimensions than [`MAX_EXTRAS`](crate::MAX_EXTRAS), and for touches that
/// are not those of the solution.
pub fn retrace(problem: &Problem<'_>, solution: &Solution) -> Result<Vec<Progress>, SolveError> {
    let selected = solution.search.iter().flat_map(|search| &search.minima).find(|minimum| minimum.selected);
    let (Some(_), Some(minimum)) = (solution.iteration, selected) else { return Ok(Vec::new()) };
    let numbers: Vec<usize> =
        (0..problem.touches().len()).filter(|index| !solution.excluded.contains(index)).collect();
    let touches: Vec<Touch> = numbers.iter().map(|index| problem.touches()[*index]).collect();
    let problem = problem.with_touches(&touches, &numbers)?;
    let extras = uncertain(&problem);
    with_unknowns!(extras.len(), P => {
        let model = Model::<P>::new(&problem, &extras);
        let (mut history, end, _) = followed(&model, Unknowns::at(minimum.start));
        let standing = |at: &Unknowns| Standing::of(&problem).frame(at.frame);
        // A search everywhere settles the ends of its descents.
        let end = if standing(&end) == minimum.frame { end } else { settle(&model, end).unwrap_or(end) };
        let (more, ..) = followed(&model, Unknowns { frame: standing(&end), ..end });
        history.extend(more);
        Ok(history)
    })
}

/// Every step of a descent, where it ended and why.
fn followed<const P: usize>(
    model: &Model<'_, P>,
    start: Unknowns,
) -> (Vec<Progress>, Unknowns, Option<Stop>) {
    let mut descent = Descent::from(model, start);
    let (mut history, mut stop) = (Vec::new(), None);
    while stop.is_none() && history.len() < STEPS {
        let (progress, ended) = descent.advance(model);
        history.push(progress);
        stop = ended;
    }
    (history, descent.at, stop)
}

/// The very minimum near where a descent ended.
pub(crate) struct Ended<const P: usize> {
    pub(crate) at: Unknowns,
    pub(crate) chi_square: f64,
    /// Square root of the information there.
    pub(crate) root: SquareRoot<P>,
    pub(crate) iteration: Iteration,
}

/// Undamped steps longer than this (standard deviations) do not tell a minimum.
pub(crate) const SETTLED: f64 = 1e-3;

/// The very minimum near where a descent ended, or why there is none.
fn ended<const P: usize>(
    model: &Model<'_, P>,
    at: &Unknowns,
    steps: usize,
    stop: Option<Stop>,
) -> Result<Ended<P>, SolveError> {
    let (at, root) = polish(model, *at);
    let chi_square = model.chi_square(&at);
    let stop = stop.unwrap_or(Stop::Iterations);
    if !stop.converged() {
        // Where no sigma is stated, the residuals tell their own.
        let unit = if model.problem.reference_sigma().is_some() { 1.0 } else { chi_square.sqrt() };
        let left = model.square_root(&at).step_in_deviations() / unit;
        if left.is_nan() || left > SETTLED {
            return Err(SolveError::NotConverged { iterations: steps, step: left, bound: SETTLED });
        }
    }
    let iteration = Iteration { steps, stopped_by: stop.name() };
    Ok(Ended { at, chi_square, root, iteration })
}
