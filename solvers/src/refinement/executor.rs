//! The iteration as argmin's [`Executor`] runs it.

use argmin::core::{
    CostFunction, Error, Executor, IterState, KV, Solver as ArgminSolver, State, TerminationReason,
    TerminationStatus,
};
use touchref_core::{Problem, SolveError};

use super::{Ended, ended};
use crate::{
    levenberg_marquardt::{Descent, Progress, STEPS, Stop},
    model::{Extra, Model, Normal, Unknowns},
};

/// argmin's state of the iteration: the unknowns, and in the place of the gradient the [`Progress`] of the last step.
pub type RefinementState = IterState<Unknowns, Progress, (), (), (), f64>;

/// The squared misfit of a measurement over `P` unknowns: half of nothing, the plain chi-square with its priors.
#[derive(Debug, Clone, Copy)]
pub struct Misfit<'a, const P: usize>(Model<'a, P>);

impl<'a, const P: usize> Misfit<'a, P> {
    /// Of the frame and these `extras`, which must be `P - 6`: none, or [`uncertain`](crate::uncertain).
    ///
    /// # Panics
    /// When they are not.
    #[must_use]
    pub fn new(problem: &'a Problem<'a>, extras: &'a [Extra]) -> Self {
        assert_eq!(extras.len() + 6, P, "the unknowns are six and one for each extra");
        Self(Model::new(problem, extras))
    }
}

impl<const P: usize> CostFunction for Misfit<'_, P> {
    type Param = Unknowns;
    type Output = f64;

    fn cost(&self, at: &Unknowns) -> Result<f64, Error> {
        Ok(self.0.chi_square(at))
    }
}

/// Levenberg-Marquardt on the manifold of frames, for argmin's `Executor`.
///
/// Ends with [`TerminationReason::SolverExit`] and the name of the criterion ([`Stop::name`]). Matrices are kept here
/// rather than in argmin's state, which is moved several times an iteration.
#[derive(Debug, Clone, Copy, Default)]
pub struct LevenbergMarquardt<const P: usize> {
    descent: Option<Descent<Normal<P>>>,
    stop: Option<Stop>,
}

impl<const P: usize> LevenbergMarquardt<P> {
    /// The criterion that ended the iteration, once it has ended.
    #[must_use]
    pub fn stop(&self) -> Option<Stop> {
        self.stop
    }
}

impl<const P: usize> ArgminSolver<Misfit<'_, P>, RefinementState> for LevenbergMarquardt<P> {
    fn name(&self) -> &'static str {
        "Levenberg-Marquardt"
    }

    fn init(
        &mut self,
        problem: &mut argmin::core::Problem<Misfit<'_, P>>,
        mut state: RefinementState,
    ) -> Result<(RefinementState, Option<KV>), Error> {
        let misfit = problem.problem.as_ref().ok_or_else(|| Error::msg("no misfit to minimise"))?;
        let start = state.take_param().ok_or_else(|| Error::msg("no start: configure the state with one"))?;
        let descent = Descent::from(&misfit.0, start);
        (self.descent, self.stop) = (Some(descent), None);
        Ok((state.param(start).cost(descent.chi_square()), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut argmin::core::Problem<Misfit<'_, P>>,
        state: RefinementState,
    ) -> Result<(RefinementState, Option<KV>), Error> {
        let misfit = problem.problem.as_ref().ok_or_else(|| Error::msg("no misfit to minimise"))?;
        let descent = self.descent.as_mut().ok_or_else(|| Error::msg("not initialised"))?;
        let (progress, stop) = descent.advance(&misfit.0);
        self.stop = stop;
        Ok((state.param(descent.at).cost(descent.chi_square()).gradient(progress), None))
    }

    fn terminate(&mut self, _: &RefinementState) -> TerminationStatus {
        match self.stop {
            Some(stop) => {
                TerminationStatus::Terminated(TerminationReason::SolverExit(stop.name().to_owned()))
            }
            None => TerminationStatus::NotTerminated,
        }
    }
}

/// The same as [`refine`](super::refine) by argmin's `Executor`, in a solver's own hands.
pub(crate) fn execute<const P: usize>(
    model: &Model<'_, P>,
    start: &Unknowns,
) -> Result<Ended<P>, SolveError> {
    let failed =
        |error: Error| SolveError::Unsupported { solver: "least-squares", reason: error.to_string() };
    let result = Executor::new(Misfit(*model), LevenbergMarquardt::<P>::default())
        .configure(|state: RefinementState| state.param(*start).max_iters(STEPS as u64).counting(false))
        .ctrlc(false)
        .timer(false)
        .run()
        .map_err(failed)?;
    let steps = usize::try_from(result.state().get_iter()).unwrap_or(usize::MAX);
    let stop = result.solver().stop();
    let at = result.state().get_param().copied().unwrap_or(*start);
    ended(model, &at, steps, stop)
}
