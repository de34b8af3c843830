//! `nearest-measure`: the root whose dimensions are nearest the known ones, and no questions asked.
//!
//! An example of a solver in one file, **not** one to use: this choice is silently wrong in percents of random layouts.

use touchref::{
    Limit, Observability, Parameters, Problem, Residual, Root, RootKind, Solution, SolveError, Solver,
    SolverPlugin, Trust, Warning,
};

/// The plugin.
pub(crate) static PLUGIN: SolverPlugin = SolverPlugin {
    name: "nearest-measure",
    summary: "the root whose dimensions are nearest the known ones; an example, never to be trusted",
    origin: module_path!(),
    parameters: &[],
    about: "Takes the closed form's root whose dimensions are nearest the known ones. Nothing is weighed against the \
            noise, so nothing is refused.",
    reference: "none",
    build: |_: &Parameters| Ok(Box::new(NearestMeasure)),
};
touchref::register_solver!(PLUGIN);

/// The root of nearest dimensions.
#[derive(Debug)]
pub(crate) struct NearestMeasure;

impl Solver for NearestMeasure {
    fn name(&self) -> &'static str {
        PLUGIN.name
    }

    fn solve(&self, problem: &Problem<'_>) -> Result<Solution, SolveError> {
        problem.require_enough()?;
        let fixture = problem.fixture();
        let closed_form = fixture.closed_form().ok_or_else(|| SolveError::Unsupported {
            solver: PLUGIN.name,
            reason: format!("fixture `{}` has no closed form", fixture.kind()),
        })?;
        let off = |root: &Root| -> f64 {
            let measures = closed_form.measured().iter().zip(root.measures);
            measures.map(|(d, measure)| (measure / fixture.dimensions()[*d].value - 1.0).abs()).sum()
        };
        let mut roots = Vec::new();
        closed_form.roots(problem, &mut |root| roots.push(root))?;
        let real = roots.iter().filter(|root| root.kind == RootKind::Real);
        let nearest = real.min_by(|a, b| off(a).total_cmp(&off(b)));
        let frame = nearest.map(|root| root.frame).ok_or_else(|| SolveError::InvalidTouches {
            problem: "no frame satisfies the equations".to_owned(),
            help: "check the labels and the unit of the touches".to_owned(),
            touches: Vec::new(),
        })?;

        let sigma = problem.reference_sigma();
        let residuals = (0..problem.touches().len()).map(|index| {
            let contact = problem.contact(&frame, index);
            let normalized = sigma.map(|_| contact.residual / contact.sigma);
            Residual { length: contact.residual, normalized }
        });
        // An empty interval: there is no sigma for which anything was shown.
        let trust = Trust {
            sigma,
            from_sigma: f64::INFINITY,
            up_to_sigma: 0.0,
            limited_by: Limit::Search,
            second_minimum: None,
            nonlinearity: None,
        };
        let observability = Observability::at(problem, &frame);
        let mut solution = Solution::new(PLUGIN.name, frame, residuals.collect(), trust, observability);
        solution.warnings.push(Warning {
            code: "nothing-checked",
            message: "the root of nearest dimensions; whether it is the right one was not asked".to_owned(),
        });
        Ok(solution)
    }
}
