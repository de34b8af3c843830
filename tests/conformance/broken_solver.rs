//! Solvers that break one promise each: the check that is meant for it says so.

use rayon::prelude::*;
use touchref::{
    ParameterError, Parameters, Probe, Problem, Residual, SigmaSource, Solution, SolveError, Solver,
    SolverPlugin,
    conformance::{Claim, Report, Suite},
    fixtures::cylinder_plane,
    solvers::{ClosedFormSolver, closed_form},
};

/// What is wrong, and the check that must say so.
macro_rules! faults {
    ($($(#[$doc:meta])* $fault:ident: $check:literal,)*) => {
        #[derive(Debug, Clone, Copy, PartialEq)]
        enum Fault {
            None,
            $($(#[$doc])* $fault,)*
        }

        const FAULTS: &[(Fault, &str, Build)] =
            &[$((Fault::$fault, $check, |_| Ok(Box::new(Broken(Fault::$fault)))),)*];
    };
}

faults! {
    /// It goes by another name.
    Name: "description",
    /// Its frames are a thousandth of the size off.
    Off: "exact",
    /// It refuses everything.
    Refuses: "exact",
    /// It takes the first root that comes.
    AnyRoot: "noisy",
    /// Its standard deviations are half of what they are.
    Overconfident: "account",
    /// They are twice that.
    Timid: "noisy",
    /// It tells no covariance although a sigma is stated.
    NoCovariance: "noisy",
    /// Residuals come in the opposite order.
    Reordered: "account",
    /// Residuals are normalized by twice the sigma.
    Normalized: "account",
    /// The p-value is that of one degree of freedom fewer.
    PValue: "account",
    /// Chi-square is twice what it is.
    ChiSquare: "account",
    /// The bounds of trust are exchanged.
    Trust: "account",
    /// Every root is the one.
    AllRoots: "account",
    /// The first touch moves the frame by a hundredth of a standard deviation.
    OrderDependent: "invariance",
    /// Only frames in front of the parent's origin are accepted.
    ParentDependent: "invariance",
    /// A sigma above a hundredth of any unit is too large.
    UnitAssumed: "invariance",
    /// Where there are too few touches it says that they are inconsistent.
    TooFew: "refusals",
    /// Refusals say nothing.
    Mute: "refusals",
    /// Where a motion is free it hands out a frame all the same.
    AnyFrame: "refusals",
    /// Where none is stated it takes a sigma that is usual.
    UsualSigma: "no-sigma",
    /// Without a sigma it trusts its frame whatever the sigma.
    Trusting: "no-sigma",
    /// Touches far away make it panic.
    Panics: "wild-touches",
    /// The last of redundant touches takes no part.
    TouchIgnored: "null-space",
}

type Build = fn(&Parameters) -> Result<Box<dyn Solver>, ParameterError>;

/// `closed-form` with a fault.
#[derive(Debug)]
struct Broken(Fault);

impl Solver for Broken {
    fn name(&self) -> &'static str {
        if self.0 == Fault::Name { "closed" } else { closed_form::PLUGIN.name }
    }

    fn solve(&self, problem: &Problem<'_>) -> Result<Solution, SolveError> {
        let touches = problem.touches();
        let usual = Probe { sigma: Some(0.002), ..*problem.probe() };
        let with_sigma = Problem::new(problem.fixture(), touches, usual).unwrap();
        let without_last = &touches[..touches.len() - 1];
        let shorter = Problem::new(problem.fixture(), without_last, *problem.probe());
        let outcome = match self.0 {
            Fault::UsualSigma => ClosedFormSolver::default().solve(&with_sigma),
            Fault::TouchIgnored if touches.len() > 7 => ClosedFormSolver::default().solve(&shorter.unwrap()),
            Fault::Panics if touches[0].at.coords.norm() > 1e12 => panic!("far away"),
            _ => ClosedFormSolver::default().solve(problem),
        };
        match outcome {
            Ok(solution) => self.changed(problem, solution),
            Err(refusal) => self.refusal(problem, refusal),
        }
    }
}

impl Broken {
    fn changed(&self, problem: &Problem<'_>, mut solution: Solution) -> Result<Solution, SolveError> {
        let sigma = problem.probe().sigma;
        let refused = |because: &str| {
            let (problem, help) = (because.to_owned(), "none".to_owned());
            Err(SolveError::InvalidTouches { problem, help, touches: Vec::new() })
        };
        let scale_covariance = |solution: &mut Solution, factor: f64| {
            if let Some(covariance) = &mut solution.covariance {
                covariance.matrix *= factor;
            }
        };
        match self.0 {
            Fault::Off => solution.frame.origin.x += 1e-3 * problem.fixture().size(),
            Fault::Refuses => return refused("never"),
            Fault::AnyRoot => solution.frame = solution.roots.last().unwrap().frame,
            Fault::Overconfident => scale_covariance(&mut solution, 0.25),
            Fault::Timid => scale_covariance(&mut solution, 4.0),
            Fault::NoCovariance => solution.covariance = None,
            Fault::Reordered => solution.residuals.reverse(),
            Fault::Normalized => {
                let halve =
                    |residual: &mut Residual| residual.normalized = residual.normalized.map(|n| 0.5 * n);
                solution.residuals.iter_mut().for_each(halve);
            }
            Fault::PValue => solution.p_value = solution.p_value.map(|p| p * 0.99),
            Fault::ChiSquare => solution.chi_square = solution.chi_square.map(|c| 2.0 * c),
            Fault::Trust => {
                let trust = &mut solution.trust;
                std::mem::swap(&mut trust.from_sigma, &mut trust.up_to_sigma);
            }
            Fault::AllRoots => solution.roots.iter_mut().for_each(|root| root.selected = true),
            Fault::OrderDependent if problem.touches()[0].at.x > problem.touches()[1].at.x => {
                let sd = solution.covariance.map(|covariance| covariance.standard_deviations());
                solution.frame.origin.x += 0.01 * sd.map_or(0.0, |sd| sd[0]);
            }
            Fault::ParentDependent if solution.frame.origin.x < 0.0 => return refused("behind the origin"),
            Fault::UnitAssumed if sigma.is_some_and(|sigma| sigma > 0.01) => return refused("a large sigma"),
            Fault::Trusting if sigma.is_none() => {
                (solution.trust.from_sigma, solution.trust.up_to_sigma) = (0.0, f64::INFINITY);
                if let Some(covariance) = &mut solution.covariance {
                    covariance.sigma_source = SigmaSource::Given;
                }
            }
            _ => {}
        }
        Ok(solution)
    }

    fn refusal(&self, problem: &Problem<'_>, refusal: SolveError) -> Result<Solution, SolveError> {
        let invalid = |problem: String, help: String| {
            Err(SolveError::InvalidTouches { problem, help, touches: Vec::new() })
        };
        match (self.0, &refusal) {
            (Fault::TooFew, SolveError::TooFewTouches { missing }) => {
                invalid(missing.clone(), "more".to_owned())
            }
            (Fault::Mute, _) => invalid(refusal.to_string(), String::new()),
            (Fault::AnyFrame, SolveError::Degenerate(_)) => {
                // The frame of a sound layout: it shows nothing of these touches.
                let fixture = problem.fixture();
                let touches: Vec<touchref::Touch> = fixture
                    .nominal_layout()
                    .into_iter()
                    .map(|(surface, at)| touchref::Touch::new(surface, at))
                    .collect();
                let probe = Probe { tip_radius: 0.0, ..*problem.probe() };
                ClosedFormSolver::default().solve(&Problem::new(fixture, &touches, probe).unwrap())
            }
            _ => Err(refusal),
        }
    }
}

fn report(build: Build) -> Report {
    let sound = &closed_form::PLUGIN;
    let plugin = SolverPlugin {
        name: sound.name,
        summary: sound.summary,
        origin: module_path!(),
        parameters: sound.parameters,
        about: sound.about,
        reference: sound.reference,
        build,
    };
    let fixture = Parameters::new().with("radius", 20.0);
    let suite = Suite { trials: 5, seed: 1 };
    let (mine, fixture) = ((&plugin, &Parameters::new()), (&cylinder_plane::PLUGIN, &fixture));
    suite.solver(mine, Claim::LeastSquaresMeasured, fixture)
}

#[test]
fn every_fault_of_a_solver_is_caught_by_the_check_meant_for_it() {
    FAULTS.par_iter().for_each(|(fault, check, build)| {
        let report = report(*build);
        println!("{fault:?}: {:?}", report.failed());
        assert!(report.failed().contains(check), "{fault:?} must fail `{check}`: {report}");
    });
}

/// The wrapper itself breaks nothing.
#[test]
fn without_a_fault_nothing_is_caught() {
    report(|_| Ok(Box::new(Broken(Fault::None)))).assert_passed();
}
