//! `closed-form`: the roots of the fixture's equations; the known geometry chooses.
//!
//! The touches alone tell the frame **and** the dimensions that the equations leave free (the radius, for
//! `cylinder-plane`); what is known of these dimensions serves only to choose among the roots, and to refuse when two
//! roots fit or none does. `least-squares` instead lets the known dimensions take part in the estimate.
//!
//! With as many touches as unknowns the frame is the root itself. With more, it is the least-squares frame of all
//! touches with these dimensions free, to which the root leads.
//!
//! Acceptance is [that of every solver](crate#when-a-frame-is-accepted), on the frames that each candidate leads to
//! under the known geometry; the root's own curvature, with its dimensions free, must pass, too.

use nalgebra::{Matrix6, SMatrix, SVector};
use touchref_core::{
    ClosedForm, Frame, MAX_MEASURES, Measure, Observability, ParameterError, Parameters, Problem, Root,
    RootKind, RootReport, Solution, SolveError, Solver, SolverPlugin, Unknown,
};

use crate::{
    acceptance::{
        self, Account, Bounds, Found, INCONSISTENT, Judgement, Margin, Search, Weakest, curvature_bound,
        degenerate, degrees_of_freedom, rank_lost, rise_bound,
    },
    levenberg_marquardt::{descend, polish},
    model::{Extra, Model, SquareRoot, Unknowns, uncertain, with_unknowns},
    words::{short, wanted_dimensions},
};

/// The plugin.
pub static PLUGIN: SolverPlugin = SolverPlugin {
    name: "closed-form",
    summary: "every root of the fixture's equations; the known dimensions choose",
    origin: module_path!(),
    parameters: &[Margin::SPEC],
    about: "Solves the fixture's equations without a starting guess and lists every real root with the dimensions it \
            implies. The known dimensions choose: a root stands when it fits within the stated noise, no other does, \
            and first-order uncertainty holds. The frame rests on the touches alone; take `least-squares` for the \
            frame that the known dimensions make more certain.",
    reference: "roots: the fixture's own reference; acceptance: chi-square levels, see docs of touchref-solvers",
    build,
};
touchref_core::register_solver!(PLUGIN);

fn build(parameters: &Parameters) -> Result<Box<dyn Solver>, ParameterError> {
    let parameters = parameters.checked(PLUGIN.parameters)?;
    Ok(Box::new(ClosedFormSolver { margin: Margin::of(&parameters) }))
}

/// The roots of the fixture's equations; the known geometry chooses.
#[derive(Debug, Clone, Copy, Default)]
pub struct ClosedFormSolver {
    /// How far beyond the stated noise other frames are looked for.
    pub margin: Margin,
}

impl Solver for ClosedFormSolver {
    fn name(&self) -> &'static str {
        PLUGIN.name
    }

    fn solve(&self, problem: &Problem<'_>) -> Result<Solution, SolveError> {
        problem.require_enough()?;
        let Some(closed_form) = problem.fixture().closed_form() else {
            return Err(SolveError::Unsupported {
                solver: PLUGIN.name,
                reason: format!("fixture `{}` has no closed form", problem.fixture().kind()),
            });
        };
        let mut roots = Vec::new();
        closed_form.roots(problem, &mut |root| roots.push(root))?;
        let known = uncertain(problem);
        let free = free_extras(closed_form, &known);
        with_unknowns!(known.len(), P => {
            let model = Model::<P>::new(problem, &known);
            let judgement = Judgement::of(&model, Search::Fixture, self.margin)?;
            choose(problem, closed_form, &model, judgement, &free, &roots)
        })
    }
}

fn choose(
    problem: &Problem<'_>,
    closed_form: &dyn ClosedForm,
    known: &dyn Known,
    judgement: Judgement,
    free: &[Extra],
    roots: &[Root],
) -> Result<Solution, SolveError> {
    with_unknowns!(free.len(), F => {
        let model = Model::<F>::new(problem, free);
        Choice { problem, closed_form, known, model, judgement }.settle(roots)
    })
}

/// The model of the known geometry, whatever the number of its unknowns.
trait Known {
    /// Where a descent ends, and the squared misfit there.
    fn descend(&self, from: &Frame) -> (Frame, f64);
    /// Square root of the frame's information at the nominal dimensions.
    fn information(&self, at: &Frame) -> Matrix6<f64>;
}

impl<const P: usize> Known for Model<'_, P> {
    fn descend(&self, from: &Frame) -> (Frame, f64) {
        let end = descend(self, Unknowns::at(*from));
        (end.at.frame, end.chi_square())
    }

    fn information(&self, at: &Frame) -> Matrix6<f64> {
        self.square_root(&Unknowns::at(*at)).of_frame()
    }
}

/// The uncertain dimensions and tip, but the measured dimensions come first, known by the touches only.
fn free_extras(closed_form: &dyn ClosedForm, known: &[Extra]) -> Vec<Extra> {
    let measured = closed_form.measured();
    let is_measured = |extra: &&Extra| measured.iter().any(|m| extra.what == Unknown::Dimension(*m));
    let free = measured.iter().map(|m| Extra { what: Unknown::Dimension(*m), prior: None });
    free.chain(known.iter().filter(|extra| !is_measured(extra)).copied()).collect()
}

/// The choice among the roots; `F` unknowns with the measured dimensions free.
struct Choice<'a, 'p, const F: usize> {
    problem: &'a Problem<'p>,
    closed_form: &'a dyn ClosedForm,
    known: &'a dyn Known,
    /// With the measured dimensions free.
    model: Model<'a, F>,
    judgement: Judgement,
}

/// A root, brought to all touches, with its dimensions free.
struct Estimate<const F: usize> {
    state: Unknowns,
    root: SquareRoot<F>,
    kind: RootKind,
    /// Whether it is the root itself, as touches are no more than unknowns.
    is_root: bool,
    /// Values of the measured dimensions and their covariance; further ones are zero, of variance one.
    measures: [f64; MAX_MEASURES],
    covariance: Option<SMatrix<f64, MAX_MEASURES, MAX_MEASURES>>,
    /// Squared misfit under the known geometry, to first order.
    chi_square: Option<f64>,
    /// Which minimum its descent under the known geometry ends in, and how high that is.
    leads_to: Option<usize>,
    descends_to: f64,
}

impl<const F: usize> Choice<'_, '_, F> {
    fn settle(self, roots: &[Root]) -> Result<Solution, SolveError> {
        let mut estimates: Vec<Estimate<F>> = Vec::new();
        let size = self.problem.fixture().size();
        for estimate in roots.iter().map(|root| self.estimate(root)) {
            // With more touches than unknowns several roots may lead to one estimate.
            let known = |other: &Estimate<F>| {
                other.state.frame.twist_to(&estimate.state.frame).extent(size) < acceptance::SAME_PLACE
            };
            if estimate.is_root || !estimates.iter().any(known) {
                estimates.push(estimate);
            }
        }
        self.require_regular(&estimates)?;
        let chosen = self.chosen(&estimates);
        let bounds = self.bounds(chosen.map(|i| &estimates[i]));
        let account = Account { problem: self.problem, judgement: &self.judgement, bounds };
        let refusal = account.refusal(|| self.reports(&estimates, None), || self.hint(&estimates));
        match (refusal, chosen) {
            (Some(refusal), _) => Err(refusal),
            (None, Some(index)) => {
                let reports = self.reports(&estimates, Some(index));
                Ok(self.solution(&estimates[index], reports, &account))
            }
            // Bounds without an estimate allow no noise, so the account has refused.
            (None, None) => unreachable!("a frame is accepted only with a root"),
        }
    }

    fn estimate(&self, root: &Root) -> Estimate<F> {
        let measured = self.closed_form.measured();
        let dimensions = self.problem.fixture().dimensions();
        let mut state = Unknowns::at(root.frame);
        for (k, m) in measured.iter().enumerate() {
            state.extras[k] = root.measures[k] - dimensions[*m].value;
        }
        let is_root = self.problem.touches().len() <= 6 + measured.len();
        if !is_root {
            (state, _) = polish(&self.model, descend(&self.model, state).at);
        }
        let square_root = self.model.square_root(&state);
        let q = measured.len();
        let covariance = square_root.covariance().map(|c| {
            let mut measured = SMatrix::<f64, MAX_MEASURES, MAX_MEASURES>::identity();
            measured.view_mut((0, 0), (q, q)).copy_from(&c.view((0, 0), (q, q)));
            measured
        });
        let deviation = SVector::from_fn(|k, _| if k < q { state.extras[k] } else { 0.0 });
        let chi_square = covariance.and_then(|mut c| {
            for (k, m) in measured.iter().enumerate() {
                c[(k, k)] += dimensions[*m].u.powi(2);
            }
            let misfit = c.cholesky()?.solve(&deviation).dot(&deviation);
            Some(misfit + self.model.chi_square(&state)).filter(|v| v.is_finite())
        });
        let (end, descends_to) = self.known.descend(&state.frame);
        let size = self.problem.fixture().size();
        let leads_to = self.judgement.minima.iter().position(|m| m.is_at(&end, size, 1.0));
        Estimate {
            measures: std::array::from_fn(|k| {
                measured.get(k).map_or(0.0, |m| dimensions[*m].value + state.extras[k])
            }),
            state,
            root: square_root,
            kind: root.kind,
            is_root,
            covariance,
            chi_square,
            leads_to,
            descends_to,
        }
    }

    /// Refuses a layout that leaves a motion free, whether the dimensions are known or not.
    fn require_regular(&self, estimates: &[Estimate<F>]) -> Result<(), SolveError> {
        /// A double root this near (parts of the fixture's size, radians) to the best minimum is the same place.
        const NEAR: f64 = 0.1;
        let fixture = self.problem.fixture();
        let seen = &self.judgement.observability;
        if seen.rank < self.problem.unknowns() {
            return Err(degenerate(self.problem, seen, rank_lost(seen)));
        }
        // A singular layout is met exactly at its double root, where the descent under the known geometry only comes
        // near it.
        let best = self.judgement.best().state.frame;
        let at_best =
            estimates.iter().filter(|e| best.twist_to(&e.state.frame).extent(fixture.size()) < NEAR);
        for estimate in at_best {
            let frame = estimate.state.frame;
            let known = self.known.information(&frame);
            for information in [known, estimate.root.of_frame()] {
                let seen = Observability::from_square_root(fixture, &frame, &information);
                if seen.rank < self.problem.unknowns() {
                    return Err(degenerate(self.problem, &seen, rank_lost(&seen)));
                }
            }
        }
        Ok(())
    }

    /// The real root that leads to the accepted minimum; of several, the one that fits best.
    fn chosen(&self, estimates: &[Estimate<F>]) -> Option<usize> {
        let leading = estimates.iter().enumerate().filter(|(_, estimate)| {
            estimate.kind == RootKind::Real
                && estimate.leads_to == Some(self.judgement.chosen)
                && estimate.chi_square.is_some()
        });
        let misfit = |estimate: &Estimate<F>| estimate.chi_square.unwrap_or(f64::INFINITY);
        leading.min_by(|a, b| misfit(a.1).total_cmp(&misfit(b.1))).map(|(index, _)| index)
    }

    /// The judgement's bounds, tightened by the root's own.
    fn bounds(&self, estimate: Option<&Estimate<F>>) -> Bounds {
        let mut bounds = self.judgement.bounds;
        let Some(estimate) = estimate else {
            // The roots have merged within the noise: no root stands for the frame that fits.
            bounds.curvature = 0.0;
            return bounds;
        };
        let degrees = degrees_of_freedom(self.problem);
        if let (Some(chi_square), true) = (estimate.chi_square, degrees > 0) {
            let from = (chi_square / INCONSISTENT.value(degrees)).sqrt();
            if self.problem.reference_sigma().is_none() {
                bounds.from = bounds.from.max(from);
            } else if from > 1.0 {
                // Consistent under the known geometry, but not to first order from the root.
                bounds.rise = 0.0;
            }
        }
        let curvature = self.model.curvature(&estimate.state, &estimate.root);
        bounds.curvature = bounds.curvature.min(curvature_bound(curvature));
        let weakest = Weakest::of(&estimate.root.of_frame(), self.problem.fixture());
        let at = (&estimate.state, self.model.chi_square(&estimate.state));
        let rise = rise_bound(&self.model, at, &estimate.root, &weakest, bounds.up_to().0);
        bounds.rise = bounds.rise.min(rise);
        bounds
    }

    fn measures(&self, estimate: &Estimate<F>) -> Vec<Measure> {
        let dimensions = self.problem.fixture().dimensions();
        let known = self.problem.reference_sigma().is_some();
        let measured = self.closed_form.measured().iter().enumerate();
        measured
            .map(|(k, m)| {
                let scale = dimensions[*m].quantity.scale();
                let u = estimate.covariance.as_ref().map(|c| c[(k, k)].max(0.0).sqrt() * scale);
                let u = u.filter(|u| known && u.is_finite());
                Measure { name: dimensions[*m].name.clone(), value: estimate.measures[k] * scale, u }
            })
            .collect()
    }

    /// Every root and what became of it: real ones, and near misses that the noise could have lifted.
    fn reports(&self, estimates: &[Estimate<F>], selected: Option<usize>) -> Vec<RootReport> {
        let known = self.problem.reference_sigma().is_some();
        let within = self.ambiguous_level();
        let shown = estimates.iter().enumerate().filter(|(_, estimate)| {
            estimate.kind == RootKind::Real || (known && estimate.descends_to < within)
        });
        let mut reports: Vec<(f64, RootReport)> = shown
            .map(|(index, estimate)| {
                let report = RootReport {
                    frame: estimate.state.frame,
                    measures: self.measures(estimate),
                    misfit: estimate.chi_square.filter(|_| known).map(f64::sqrt),
                    selected: selected == Some(index),
                    reason: self.reason(estimate, selected == Some(index)).into(),
                };
                (estimate.chi_square.unwrap_or(f64::INFINITY), report)
            })
            .collect();
        reports.sort_by(|a, b| b.1.selected.cmp(&a.1.selected).then(a.0.total_cmp(&b.0)));
        reports.into_iter().map(|(_, report)| report).collect()
    }

    /// Level below which a frame survives; without a stated sigma none can be told.
    fn ambiguous_level(&self) -> f64 {
        acceptance::AMBIGUOUS.value(degrees_of_freedom(self.problem))
    }

    fn reason(&self, estimate: &Estimate<F>, selected: bool) -> String {
        let known = self.problem.reference_sigma();
        if let Some(objection) = acceptance::objection(self.problem, &estimate.state.frame) {
            return objection;
        }
        let chi_square = estimate.descends_to;
        // Without a stated sigma every misfit is one that some sigma allows.
        let far = |misfit: f64| known.is_none() || misfit > self.ambiguous_level();
        if let Some(misfit) = estimate.chi_square
            && !selected
            && far(misfit)
            && estimate.leads_to == Some(self.judgement.chosen)
            && estimate.kind == RootKind::Real
        {
            let far = if known.is_some() {
                format!("{} standard deviations", short(misfit.sqrt()))
            } else {
                format!("a misfit of {}", short(misfit.sqrt()))
            };
            return format!(
                "{far} from the known dimensions, which lead from here to the frame that fits better"
            );
        }
        match (selected, known) {
            (true, Some(_)) if self.judgement.by_near => {
                format!("fits, and is nearest the expected frame: chi-square {}", short(chi_square))
            }
            (true, Some(_)) => format!("fits: chi-square {} at the known dimensions", short(chi_square)),
            (true, None) => {
                let from = INCONSISTENT.value(degrees_of_freedom(self.problem));
                format!("fits best: from a sigma of {}", short((chi_square / from).sqrt()))
            }
            (false, Some(_)) if chi_square < self.ambiguous_level() => {
                let what =
                    if estimate.kind == RootKind::Real { "fits" } else { "two roots merged, and fits" };
                format!("{what}, too: chi-square {} at the known dimensions", short(chi_square))
            }
            (false, Some(_)) => format!(
                "does not fit the known dimensions: chi-square {}, at most {}",
                short(chi_square),
                short(self.ambiguous_level())
            ),
            (false, None) => {
                let from = (chi_square / self.ambiguous_level()).sqrt();
                format!("would fit from a sigma of {}", short(from))
            }
        }
    }

    /// What the best root says of the dimensions, for a refusal.
    fn hint(&self, estimates: &[Estimate<F>]) -> String {
        let misfit = |estimate: &&Estimate<F>| estimate.chi_square.unwrap_or(f64::INFINITY);
        let real = estimates.iter().filter(|estimate| estimate.kind == RootKind::Real);
        let best = real.min_by(|a, b| misfit(a).total_cmp(&misfit(b)));
        best.map_or_else(String::new, |best| {
            wanted_dimensions(self.problem, self.closed_form, best.measures.as_slice())
        })
    }

    fn solution(
        &self,
        estimate: &Estimate<F>,
        reports: Vec<RootReport>,
        account: &Account<'_, '_>,
    ) -> Solution {
        let at = Unknowns::at(estimate.state.frame);
        let found = Found {
            frame: at.frame,
            residuals: (0..self.problem.touches().len()).map(|i| self.model.residual(&at, i)).collect(),
            chi_square: estimate.chi_square.unwrap_or(f64::NAN),
            covariance: estimate.root.frame_covariance(&at.frame),
        };
        let mut solution = account.solution(PLUGIN.name, found);
        solution.roots = reports;
        solution
    }
}
