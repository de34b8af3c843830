//! `global`: every distinct minimum, with no closed form and no guess.
//!
//! Descends from a deterministic cover of all frames: rotations on a super-Fibonacci spiral, each with a translation of
//! its own. Rounds of twice as many starts follow one another until one finds nothing new. A descent that arrives in
//! the basin of a known minimum is given up there.
//!
//! What is accepted among the minima, [that of every solver](crate#when-a-frame-is-accepted). The roots of its solution
//! are all minima, however badly they fit: how many there are, how far apart, and how much worse.

use touchref_core::{ParameterError, Parameters, Problem, Solution, SolveError, Solver, SolverPlugin};

use crate::{
    acceptance::{Margin, Search},
    least_squares::solve,
};

/// The plugin.
pub static PLUGIN: SolverPlugin = SolverPlugin {
    name: "global",
    summary: "every minimum of the misfit, with no closed form and no guess: certifies the other solvers",
    origin: module_path!(),
    parameters: &[],
    about: "The frame of `least-squares`, but from starts that cover all frames instead of what the fixture knows: \
            slow (tens of milliseconds), and as good for a fixture without a closed form. Lists every distinct minimum of \
            the squared misfit, how far it is from the best and how much worse. Take it to certify another solver's \
            answer, or to see what else the touches could mean.",
    reference: "Alexa, Super-Fibonacci Spirals (2022); acceptance: see docs of touchref-solvers",
    build,
};
touchref_core::register_solver!(PLUGIN);

fn build(parameters: &Parameters) -> Result<Box<dyn Solver>, ParameterError> {
    parameters.checked(PLUGIN.parameters)?;
    Ok(Box::new(Global))
}

/// The lowest of all minima.
#[derive(Debug, Clone, Copy, Default)]
pub struct Global;

impl Solver for Global {
    fn name(&self) -> &'static str {
        PLUGIN.name
    }

    fn solve(&self, problem: &Problem<'_>) -> Result<Solution, SolveError> {
        solve(PLUGIN.name, problem, Search::Everywhere, Margin::Full)
    }
}
