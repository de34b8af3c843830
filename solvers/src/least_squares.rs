//! `least-squares`: the maximum-likelihood frame of all touches; the known geometry takes part.
//!
//! The squared misfit (signed distance from the surface less the tip radius, over the touch's standard deviation) is
//! minimised over the frame, and over those dimensions and the tip radius whose uncertainty is stated: each of these is
//! an unknown with what is known of it as one more observation. Every candidate that the fixture's search gives is
//! refined; what is accepted among the minima, [that of every solver](crate#when-a-frame-is-accepted).
//!
//! The covariance is the inverse of the information at the minimum. Where no sigma is stated it is scaled by the
//! residuals, and there is none without redundancy.

use std::borrow::Cow;

use touchref_core::{
    Adjustment, Frame, Measure, ParameterError, Parameters, Problem, Root, RootKind, RootReport, Rule,
    Solution, SolveError, Solver, SolverPlugin,
};

use crate::{
    acceptance::{
        self, Account, Found, Judgement, Margin, Minimum, Search, Standing, degenerate, degrees_of_freedom,
        rank_lost,
    },
    levenberg_marquardt::linear_minimum,
    model::{Model, SquareRoot, Unknowns, uncertain, with_unknowns},
    refinement::{Ended, execute},
    words::{short, wanted_dimensions},
};

/// The plugin.
pub static PLUGIN: SolverPlugin = SolverPlugin {
    name: "least-squares",
    summary: "maximum likelihood over the frame with known geometry, every candidate refined (default)",
    origin: module_path!(),
    parameters: &[Margin::SPEC],
    about: "Minimises the squared misfit of all touches over the frame, each weighted by its sigma; dimensions and tip \
            radius with a stated uncertainty are unknowns, too, held by what is known of them. Starts from every root \
            and near miss of the fixture's equations and from a search of what lies between; accepts the best minimum \
            when it fits, no other does, and first-order uncertainty holds. Levenberg-Marquardt on the manifold of \
            frames, run by argmin.",
    reference: "Marquardt (1963); right increments as in Sola et al. (2018); acceptance: see docs of touchref-solvers",
    build,
};
touchref_core::register_solver!(PLUGIN);

fn build(parameters: &Parameters) -> Result<Box<dyn Solver>, ParameterError> {
    let parameters = parameters.checked(PLUGIN.parameters)?;
    Ok(Box::new(LeastSquares { margin: Margin::of(&parameters) }))
}

/// The maximum-likelihood frame of all touches.
#[derive(Debug, Clone, Copy, Default)]
pub struct LeastSquares {
    /// How far beyond the stated noise other frames are looked for.
    pub margin: Margin,
}

impl Solver for LeastSquares {
    fn name(&self) -> &'static str {
        PLUGIN.name
    }

    fn solve(&self, problem: &Problem<'_>) -> Result<Solution, SolveError> {
        solve(PLUGIN.name, problem, Search::Fixture, self.margin)
    }

    fn rule(&self) -> Option<Rule> {
        (self.margin == Margin::Near).then(acceptance::rule)
    }
}

/// The lowest minimum of a search, if it stands; for the solver of this name.
pub(crate) fn solve(
    solver: &'static str,
    problem: &Problem<'_>,
    search: Search,
    margin: Margin,
) -> Result<Solution, SolveError> {
    if problem.expected_near().is_none() {
        problem.require_enough()?;
    }
    let extras = uncertain(problem);
    with_unknowns!(extras.len(), P => {
        let model = Model::<P>::new(problem, &extras);
        let judgement = Judgement::of(&model, search, margin)?;
        let (solution, _) = Answer { solver, problem, search, model, judgement }.settle()?;
        Ok(solution)
    })
}

/// The verdict on the minima, to be told.
pub(crate) struct Answer<'a, 'p, const P: usize> {
    /// Name of the solver.
    pub(crate) solver: &'static str,
    pub(crate) problem: &'a Problem<'p>,
    pub(crate) search: Search,
    pub(crate) model: Model<'a, P>,
    pub(crate) judgement: Judgement,
}

impl<const P: usize> Answer<'_, '_, P> {
    /// The frame as a solution, and all unknowns there; or why it does not stand.
    pub(crate) fn settle(self) -> Result<(Solution, Unknowns), SolveError> {
        let seen = &self.judgement.observability;
        if seen.rank < self.problem.unknowns() {
            return Err(degenerate(self.problem, seen, rank_lost(seen)));
        }
        let bounds = self.judgement.bounds;
        let account = Account { problem: self.problem, judgement: &self.judgement, bounds };
        if let Some(refusal) = account.refusal(|| self.reports(false), || self.hint()) {
            return Err(refusal);
        }
        let best = self.judgement.best();
        let Ended { mut at, chi_square, root, mut iteration } = execute(&self.model, &best.state)?;
        at.frame = Standing::of(self.problem).frame(at.frame);
        iteration.steps += best.steps;
        let found = Found {
            frame: at.frame,
            residuals: (0..self.problem.touches().len()).map(|i| self.model.residual(&at, i)).collect(),
            chi_square,
            covariance: root.frame_covariance(&at.frame),
        };
        let mut solution = account.solution(self.solver, found);
        solution.adjustments = self.adjustments(&at, &root);
        solution.iteration = Some(iteration);
        solution.roots = self.reports(true);
        Ok((solution, at))
    }

    /// How far the uncertain dimensions and the tip moved.
    fn adjustments(&self, at: &Unknowns, root: &SquareRoot<P>) -> Vec<Adjustment> {
        if self.model.extras().is_empty() {
            return Vec::new();
        }
        let Some(covariance) = root.covariance() else { return Vec::new() };
        let told = self.model.extras().iter().enumerate().map(|(k, extra)| {
            let stated = extra.what.stated(self.problem.fixture(), self.problem.probe());
            stated.adjusted(extra.prior, at.extras[k], covariance[(k, k)].sqrt())
        });
        told.collect()
    }

    /// Every real root, how far it is from the known geometry, and which one leads to the frame. More touches than the
    /// equations have unknowns have no roots: then every minimum that was weighed.
    fn reports(&self, accepted: bool) -> Vec<RootReport> {
        let mut reports = self.of_roots().unwrap_or_else(|| self.of_minima());
        reports.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut reports: Vec<RootReport> = reports.into_iter().map(|(_, report)| report).collect();
        if accepted && let Some(nearest) = self.nearest(&reports) {
            reports[..=nearest].rotate_right(1);
            reports[0].selected = true;
            reports[0].reason = Cow::Borrowed("leads to the frame");
        }
        reports
    }

    /// The real roots with their squared misfits under the known geometry, to first order.
    fn of_roots(&self) -> Option<Vec<(f64, RootReport)>> {
        let closed_form = self.search.by(self.problem)?;
        let measured = closed_form.measured();
        if self.problem.touches().len() > 6 + measured.len() {
            return None;
        }
        let dimensions = self.problem.fixture().dimensions();
        let mut reports = Vec::new();
        // What the equations refuse, the judgement has refused before.
        let _ = closed_form.roots(self.problem, &mut |root| {
            if root.kind == RootKind::Real {
                let measures = measured.iter().zip(root.measures).map(|(index, value)| {
                    let dimension = &dimensions[*index];
                    let value = value * dimension.quantity.scale();
                    Measure { name: dimension.name.clone(), value, u: None }
                });
                let misfit = linear_minimum(&self.model, &Unknowns::at(root.frame));
                let objection = acceptance::objection(self.problem, &root.frame);
                reports.push(self.report(root.frame, misfit, objection, measures.collect()));
            }
        });
        Some(reports)
    }

    /// Every minimum that was weighed, and how far it is from the best.
    fn of_minima(&self) -> Vec<(f64, RootReport)> {
        let best = self.judgement.best();
        let told = |minimum: &Minimum| {
            let frame = minimum.state.frame;
            let (misfit, mut report) =
                self.report(frame, minimum.chi_square, minimum.objection.clone(), Vec::new());
            if !std::ptr::eq(minimum, best) {
                let twist = best.state.frame.twist_to(&frame);
                report.reason = Cow::Owned(format!(
                    "{}; {} and {} degrees from the best",
                    report.reason,
                    short(twist.translation.norm()),
                    short(twist.rotation.norm().to_degrees())
                ));
            }
            (misfit, report)
        };
        self.judgement.minima.iter().map(told).collect()
    }

    /// A frame that the touches may mean, and its squared misfit.
    fn report(
        &self,
        frame: Frame,
        misfit: f64,
        objection: Option<String>,
        measures: Vec<Measure>,
    ) -> (f64, RootReport) {
        let known = self.problem.reference_sigma().is_some();
        let fits = misfit <= acceptance::AMBIGUOUS.value(degrees_of_freedom(self.problem));
        let reason = match objection {
            Some(objection) => Cow::Owned(objection),
            None if !known => {
                Cow::Owned(format!("a misfit of {} from the known geometry", short(misfit.sqrt())))
            }
            None if fits => Cow::Borrowed("fits the known geometry"),
            None => Cow::Borrowed("does not fit the known geometry"),
        };
        let told = known.then(|| misfit.sqrt());
        (misfit, RootReport { frame, measures, misfit: told, selected: false, reason })
    }

    /// What the root nearest the known geometry says of the dimensions, for a refusal.
    fn hint(&self) -> String {
        let Some(closed_form) = self.search.by(self.problem) else { return String::new() };
        let mut best: Option<(f64, Root)> = None;
        let _ = closed_form.roots(self.problem, &mut |root| {
            if root.kind == RootKind::Real {
                let misfit = linear_minimum(&self.model, &Unknowns::at(root.frame));
                if best.is_none_or(|(least, _)| misfit < least) {
                    best = Some((misfit, root));
                }
            }
        });
        best.map_or_else(String::new, |(_, root)| {
            wanted_dimensions(self.problem, closed_form, &root.measures)
        })
    }

    /// The root nearest the accepted frame, in that frame's own standard deviations.
    fn nearest(&self, reports: &[RootReport]) -> Option<usize> {
        let best = self.judgement.best();
        let distance = |report: &RootReport| best.mahalanobis(&report.frame);
        let nearest = reports.iter().enumerate().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        nearest.map(|(index, _)| index)
    }
}
