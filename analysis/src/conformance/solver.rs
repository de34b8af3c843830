//! The promises of a solver, with one fixture.

use nalgebra::{Matrix6, SymmetricEigen};
use rand::seq::SliceRandom;
use touchref_core::{
    Covariance, Frame, Observability, Parameters, Probe, Problem, Residual, SigmaSource, Solution,
    SolveError, Solver, SolverPlugin, Touch, Unknown,
    statistics::{chi_square_level, chi_square_p_value},
};

use super::{
    Claim, Finding, Promise,
    case::{self, Case, Places, REGULAR, SOUND, View},
    ensure,
    fixture::{RECOVERED, documented, no_harm, null_space_case},
    without_panic,
};
use crate::{
    reference::{condition, descend},
    simulation::{random_frame, simulate},
    study::WRONG_LEVEL,
};

/// A solver under test, and the fixture to test it with.
#[derive(Debug)]
pub(super) struct Subject<'a> {
    fixture: case::Subject<'a>,
    plugin: &'a SolverPlugin,
    /// What it was built from, defaults filled in.
    parameters: Parameters,
    solver: Box<dyn Solver>,
    claim: Claim,
}

/// What is promised; where the solver cannot do the fixture at all, the description alone.
pub(super) fn checks<'a>(subject: &Subject<'a>) -> Vec<Promise<Subject<'a>>> {
    let mut checks: Vec<Promise<Subject<'a>>> = vec![("description", description)];
    if subject.unsupported().is_none() {
        checks.extend_from_slice(&[
            ("exact", exact),
            ("noisy", noisy),
            ("account", account),
            ("invariance", invariance),
            ("refusals", refusals),
            ("no-sigma", no_sigma),
            ("wild-touches", wild_touches),
            ("null-space", null_space),
        ]);
    }
    checks
}

impl<'a> Subject<'a> {
    pub(super) fn new(
        plugin: &'a SolverPlugin,
        parameters: &Parameters,
        claim: Claim,
        fixture: case::Subject<'a>,
    ) -> Result<Self, String> {
        let told = |error| format!("{}: {error}", plugin.name);
        let parameters = parameters.checked(plugin.parameters).map_err(told)?;
        let solver = without_panic(|| plugin.build(&parameters))?.map_err(told)?;
        Ok(Self { fixture, plugin, parameters, solver, claim })
    }

    /// Why the solver cannot do the fixture, if it cannot.
    fn unsupported(&self) -> Option<SolveError> {
        let case = self.fixture.case(Places::Nominal, 0, 0.0, Some(self.fixture.sigma()));
        let outcome = without_panic(|| self.solve(&case)).ok()?.ok()?;
        outcome.err().filter(|refusal| matches!(refusal, SolveError::Unsupported { .. }))
    }

    /// The outcome of a case, whose refusal says something; where there is none, why in words.
    fn solve(&self, case: &Case) -> Result<Result<Solution, SolveError>, String> {
        let problem = Problem::new(&*self.fixture.fixture, &case.touches, case.probe);
        self.outcome(&problem.map_err(|error| format!("{}: {error}", case.what))?)
            .map_err(|words| format!("{}: {words}", case.what))
    }

    fn outcome(&self, problem: &Problem<'_>) -> Result<Result<Solution, SolveError>, String> {
        let outcome = self.solver.solve(problem);
        match &outcome {
            Ok(solution) => ensure!(solution.frame.is_sound(), "a frame that is none: {:?}", solution.frame),
            Err(refusal) => {
                let told = !refusal.to_string().is_empty() && !refusal.help().is_empty();
                ensure!(told, "refused as `{}` without words or help", refusal.code());
            }
        }
        Ok(outcome)
    }

    /// How far a frame is from another: parts of the fixture's size, radians.
    fn apart(&self, one: &Frame, other: &Frame) -> f64 {
        one.twist_to(other).extent(self.fixture.size())
    }
}

fn description(subject: &Subject<'_>) -> Finding {
    let plugin = subject.plugin;
    let name = subject.solver.name();
    ensure!(name == plugin.name, "the solver calls itself `{name}`");
    let told = [
        ("summary", plugin.summary),
        ("origin", plugin.origin),
        ("way", plugin.about),
        ("reference", plugin.reference),
    ];
    for (what, words) in told {
        ensure!(!words.trim().is_empty(), "nothing is said of its {what}");
    }
    ensure!(plugin.summary.lines().count() == 1, "the summary has more than one line");
    documented(plugin, &subject.parameters)?;
    let parameters = format!("{} parameters", plugin.parameters.len());
    Ok(subject.unsupported().map_or(parameters, |refusal| refusal.to_string()))
}

fn exact(subject: &Subject<'_>) -> Finding {
    /// Parts of the size and radians, for a condition of one: far beyond what any machine measures, and short of what
    /// reference data ask for.
    const EXACT: f64 = 1e-10;
    let (mut accepted, mut count, mut worst) = (0, 0, 0.0_f64);
    for places in Places::ALL {
        for case in subject.fixture.cases(places, 0.0, Some(subject.fixture.sigma()), REGULAR)? {
            count += 1;
            match subject.solve(&case)? {
                Ok(solution) => {
                    let problem = Problem::new(&*subject.fixture.fixture, &case.touches, case.probe);
                    let problem = problem.map_err(|error| error.to_string())?;
                    let off = subject.apart(&case.truth, &solution.frame);
                    let bound = EXACT * condition(&problem, &subject.fixture.measured(), &case.truth);
                    ensure!(
                        off <= bound,
                        "{}: the frame is off by {off:.2e} (parts of the size, radians), at most {bound:.1e}",
                        case.what
                    );
                    accepted += 1;
                    worst = worst.max(off / bound);
                }
                Err(refusal) if places == Places::Nominal => {
                    return Err(format!("{}: refused as `{}`: {refusal}", case.what, refusal.code()));
                }
                Err(_) => {}
            }
        }
    }
    Ok(format!("{accepted} of {count} accepted, at worst {worst:.1e} of the bound"))
}

fn noisy(subject: &Subject<'_>) -> Finding {
    /// Measurements of each kind for one of the suite's trials: rates need more of them.
    const RATE: u64 = 10;
    /// Part of the measurements at the nominal layout that must give a frame.
    const ACCEPTED: f64 = 0.9;
    /// Standard deviations of the mean that chance may take, once in two million.
    const CHANCE: f64 = 5.0;
    /// Variance of chi-square with six degrees of freedom.
    const VARIANCE: f64 = 12.0;
    let (sigma, trials) = (subject.fixture.sigma(), RATE * subject.fixture.suite.trials);
    let wrong = chi_square_level(WRONG_LEVEL, 6);
    let mut told = Vec::new();
    for places in Places::ALL {
        let mut squared_errors = Vec::new();
        for trial in 0..trials {
            let case = subject.fixture.case(places, trial, sigma, Some(sigma));
            let Ok(solution) = subject.solve(&case)? else { continue };
            let covariance = stated(&solution, sigma).map_err(|words| format!("{}: {words}", case.what))?;
            let squared = solution.squared_distance(&case.truth).unwrap_or(f64::INFINITY);
            ensure!(
                squared <= wrong,
                "{}: a wrong frame: its squared error is {squared:.1} in its own covariance, at most {wrong:.1} \
                 (level {WRONG_LEVEL:e}); standard deviations {:?}",
                case.what,
                covariance.standard_deviations()
            );
            squared_errors.push(squared);
        }
        let accepted = squared_errors.len() as f64;
        let mean = squared_errors.iter().sum::<f64>() / accepted;
        told.push(format!("{accepted} of {trials} accepted, mean squared error {mean:.2}"));
        if places == Places::Nominal {
            ensure!(accepted >= ACCEPTED * trials as f64, "nominal layout: only {}", told[0]);
            let chance = CHANCE * (VARIANCE / accepted).sqrt();
            ensure!(
                (mean - 6.0).abs() <= chance,
                "nominal layout: {}, 6 within {chance:.2} expected",
                told[0]
            );
        }
    }
    Ok(told.join("; "))
}

/// The covariance of a solution whose sigma is stated.
fn stated(solution: &Solution, sigma: f64) -> Result<&Covariance, String> {
    /// Products of two matrices.
    const SYMMETRIC: f64 = 1e-12;
    let covariance = solution.covariance.as_ref().ok_or("a sigma is stated, but no covariance is")?;
    let matrix = &covariance.matrix;
    for (i, j) in (0..6).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let scale = (matrix[(i, i)] * matrix[(j, j)]).sqrt();
        let off = (matrix[(i, j)] - matrix[(j, i)]).abs();
        ensure!(off <= SYMMETRIC * scale, "the covariance is not symmetric: {matrix}");
    }
    ensure!(matrix.cholesky().is_some(), "the covariance is not positive: {matrix}");
    let source = (covariance.sigma_source, covariance.sigma);
    ensure!(source == (SigmaSource::Given, sigma), "the covariance stands on {source:?}, stated is {sigma}");
    Ok(covariance)
}

fn account(subject: &Subject<'_>) -> Finding {
    let (sigma, mut count) = (subject.fixture.sigma(), 0);
    for places in Places::ALL {
        for case in subject.fixture.cases(places, sigma, Some(sigma), SOUND)? {
            let Ok(solution) = subject.solve(&case)? else { continue };
            let problem = Problem::new(&*subject.fixture.fixture, &case.touches, case.probe);
            let problem = problem.map_err(|error| error.to_string())?;
            let verdict = residuals(subject, &problem, &solution)
                .and_then(|()| misfit(subject, &problem, &solution))
                .and_then(|()| certainty(subject, &problem, &solution))
                .and_then(|()| margin(subject, &solution, sigma));
            verdict.map_err(|words| format!("{}: {words}", case.what))?;
            count += 1;
        }
    }
    Ok(format!("{count} solutions"))
}

/// Sums of a few numbers that are as large as what they are compared with.
const ROUNDING: f64 = 1e-9;
/// Part by which first-order quantities differ where the solver takes them at another point than the suite: relative
/// curvatures are a few hundredths at sound layouts.
const FIRST_ORDER: f64 = 0.1;

fn residuals(subject: &Subject<'_>, problem: &Problem<'_>, solution: &Solution) -> Result<(), String> {
    ensure!(solution.solver == subject.plugin.name, "it says to come from `{}`", solution.solver);
    let (told, touches) = (solution.residuals.len(), problem.touches().len());
    ensure!(told == touches, "{told} residuals for {touches} touches");
    for (index, residual) in solution.residuals.iter().enumerate() {
        let contact = problem.contact(&solution.frame, index);
        let off = (residual.length - contact.residual).abs() / contact.sigma;
        let (told, is) = (residual.length, contact.residual);
        ensure!(off <= ROUNDING, "the residual of touch {index} is told as {told:e}, and is {is:e}");
        let normalized = residual.normalized.ok_or("a sigma is stated, but a residual is not normalized")?;
        let off = (normalized - residual.length / contact.sigma).abs();
        ensure!(off <= ROUNDING, "the residual of touch {index} is {told:e}, normalized {normalized:e}");
    }
    let used = touches - solution.excluded.len();
    let squares = used_residuals(solution).map(|residual| residual.length.powi(2)).sum::<f64>();
    let rms = (squares / used as f64).sqrt();
    ensure!(
        (solution.rms - rms).abs() <= ROUNDING * rms,
        "the rms is told as {}, and is {rms}",
        solution.rms
    );
    Ok(())
}

/// Of the touches on which the frame rests.
fn used_residuals(solution: &Solution) -> impl Iterator<Item = &Residual> {
    let residuals = solution.residuals.iter().enumerate();
    residuals.filter(|(index, _)| !solution.excluded.contains(index)).map(|(_, residual)| residual)
}

fn misfit(subject: &Subject<'_>, problem: &Problem<'_>, solution: &Solution) -> Result<(), String> {
    let chi_square = solution.chi_square.ok_or("a sigma is stated, but no chi-square is")?;
    let degrees = solution.degrees_of_freedom;
    let most = problem.touches().len() - solution.excluded.len() - 6;
    ensure!(degrees <= most, "{degrees} degrees of freedom, {most} touches beyond the frame's six");
    let at_frame: f64 =
        used_residuals(solution).filter_map(|residual| residual.normalized).map(|n| n * n).sum();
    let exactly = subject.claim == Claim::LeastSquares;
    let at_least = if exactly {
        at_frame
    } else {
        let free = descend(problem, &subject.fixture.measured(), &solution.frame);
        free.map_or(0.0, |minimum| minimum.chi_square)
    };
    let slack = if exactly { ROUNDING } else { FIRST_ORDER };
    let (least, greatest) = (at_least * (1.0 - slack) - ROUNDING, at_frame * (1.0 + slack) + ROUNDING);
    ensure!(
        chi_square >= least && chi_square <= greatest,
        "chi-square is told as {chi_square}, and is between {least} and {greatest}"
    );
    let p_value = chi_square_p_value(chi_square, degrees);
    let agree = match (solution.p_value, p_value) {
        (Some(told), Some(is)) => (told - is).abs() <= ROUNDING,
        (told, is) => told == is,
    };
    ensure!(agree, "the p-value is told as {:?}, and is {p_value:?}", solution.p_value);
    Ok(())
}

/// No frame is surer than the touches make it: the covariance is not below that of Cramer and Rao.
fn certainty(subject: &Subject<'_>, problem: &Problem<'_>, solution: &Solution) -> Result<(), String> {
    let sigma = subject.fixture.sigma();
    let matrix = stated(solution, sigma)?.matrix;
    let mut information = Matrix6::zeros();
    for index in 0..problem.touches().len() {
        let contact = problem.contact(&solution.frame, index);
        let row = nalgebra::RowVector6::from_row_slice(&contact.gradient()) / contact.sigma;
        information += row.transpose() * row;
    }
    let cholesky = information.cholesky().ok_or("its own frame leaves a motion free")?;
    let bound = solution.frame.to_parent_axes(&cholesky.inverse());
    let lower = bound.cholesky().ok_or("its own frame leaves a motion free")?.l();
    let half = lower.solve_lower_triangular(&matrix).unwrap_or_default();
    let whitened = lower.solve_lower_triangular(&half.transpose()).unwrap_or_default();
    let variances = SymmetricEigen::new(whitened).eigenvalues;
    let (least, greatest) = (variances.min(), variances.max());
    ensure!(least >= 1.0 - FIRST_ORDER, "a variance is {least:.3} of the least that the touches allow");
    let efficient = subject.claim != Claim::LeastSquares || greatest <= 1.0 + FIRST_ORDER;
    ensure!(efficient, "a variance is {greatest:.3} of that of least squares");

    let seen = Observability::at(problem, &solution.frame);
    let (told, rank) = (solution.observability.condition, solution.observability.rank);
    ensure!(rank == 6, "a frame is handed out although the touches see {rank} motions");
    let off = (told / seen.condition - 1.0).abs();
    ensure!(off <= FIRST_ORDER, "the condition is told as {told}, and is {}", seen.condition);
    Ok(())
}

/// Trust and roots.
fn margin(subject: &Subject<'_>, solution: &Solution, sigma: f64) -> Result<(), String> {
    let trust = &solution.trust;
    let (from, up_to) = (trust.from_sigma, trust.up_to_sigma);
    ensure!(trust.sigma == Some(sigma), "the stated sigma is told as {:?}", trust.sigma);
    let within = from >= 0.0 && from <= sigma && sigma <= up_to;
    ensure!(within, "a frame is handed out at sigma {sigma}, to be trusted from {from} to {up_to}");
    let selected = solution.roots.iter().filter(|root| root.selected).count();
    ensure!(selected <= 1, "{selected} roots are the one");
    let dimensions = subject.fixture.fixture.dimensions();
    for root in &solution.roots {
        ensure!(root.frame.is_sound(), "a root whose frame is none: {:?}", root.frame);
        ensure!(!root.reason.trim().is_empty(), "a root without reason");
        for measure in &root.measures {
            let known = dimensions.iter().any(|dimension| dimension.name == measure.name);
            ensure!(known, "a root measures `{}`, which is no dimension", measure.name);
        }
    }
    for warning in &solution.warnings {
        let told = !warning.code.is_empty() && !warning.message.is_empty();
        ensure!(told, "a warning without words: {warning:?}");
    }
    Ok(())
}

fn invariance(subject: &Subject<'_>) -> Finding {
    let (sigma, mut compared, mut worst) = (subject.fixture.sigma(), 0, 0.0_f64);
    for places in Places::ALL {
        for (trial, case) in (0..).zip(subject.fixture.cases(places, sigma, Some(sigma), SOUND)?) {
            let one = subject.solve(&case)?;
            for view in subject.fixture.views(&case, &mut subject.fixture.generator(places, trial)) {
                let problem = Problem::new(view.fixture, &view.touches, view.probe);
                let other = subject.outcome(&problem.map_err(|error| error.to_string())?);
                let told = |words: String| format!("{}, {}: {words}", case.what, view.what);
                let off = same_outcome(&one, &other.map_err(told)?, &view).map_err(told)?;
                worst = worst.max(off);
                compared += 1;
            }
        }
    }
    Ok(format!("{compared} pairs of outcomes, frames {worst:.1e} standard deviations apart at worst"))
}

/// Holds two outcomes of one measurement together; how far their frames are apart, in standard deviations.
fn same_outcome(
    one: &Result<Solution, SolveError>,
    other: &Result<Solution, SolveError>,
    view: &View<'_>,
) -> Result<f64, String> {
    /// Frames, in standard deviations: coordinates round to 1e-11 of them, which weak motions and descents that stop
    /// near the minimum amplify.
    const FRAME: f64 = 1e-6;
    /// Variances, chi-square and bounds, relative: bounds are searched for, not computed.
    const NUMBER: f64 = 1e-4;
    let verdict = |outcome: &Result<Solution, SolveError>| match outcome {
        Ok(_) => "accepted".to_owned(),
        Err(refusal) => format!("refused as `{}`: {refusal}", refusal.code()),
    };
    let (one, other) = match (one, other) {
        (Ok(one), Ok(other)) => (one, other),
        (Err(a), Err(b)) if a.code() == b.code() => return Ok(0.0),
        _ => return Err(format!("{}; before: {}", verdict(other), verdict(one))),
    };
    let off = other.squared_distance(&view.of(&one.frame)).ok_or("no covariance")?.sqrt();
    ensure!(off <= FRAME, "the frames are {off:.1e} standard deviations apart");
    let close = |got: f64, expected: f64| {
        got.total_cmp(&expected).is_eq() || (got - expected).abs() <= NUMBER * expected.abs()
    };
    let chi_squares = [one, other].map(|solution| solution.chi_square.unwrap_or(f64::NAN));
    ensure!((chi_squares[1] - chi_squares[0]).abs() <= NUMBER, "chi-squares {chi_squares:?}");
    let (trust, seen) = (&one.trust, &other.trust);
    for (bound, got) in [(trust.from_sigma, seen.from_sigma), (trust.up_to_sigma, seen.up_to_sigma)] {
        ensure!(close(got, bound * view.unit), "a bound of trust is {got}, not {}", bound * view.unit);
    }
    let [before, seen] =
        [one, other].map(|solution| solution.covariance.map(|c| c.matrix).unwrap_or_default());
    let scale = |k: usize| if k < 3 { view.unit } else { 1.0 };
    let scaled = Matrix6::from_fn(|i, j| before[(i, j)] * scale(i) * scale(j));
    let expected = view.motion.to_parent_axes(&scaled);
    for (i, j) in (0..6).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        let scale = (expected[(i, i)] * expected[(j, j)]).sqrt();
        let off = (seen[(i, j)] - expected[(i, j)]).abs() / scale;
        ensure!(off <= NUMBER, "element ({i}, {j}) of the covariance is off by {off:.1e}");
    }
    for (index, from) in view.order.iter().enumerate() {
        let (got, before) = (other.residuals[index].normalized, one.residuals[*from].normalized);
        let off = got.unwrap_or(f64::NAN) - before.unwrap_or(f64::NAN);
        ensure!(off.abs() <= FRAME.max(NUMBER), "the residual of touch {from} is {got:?}, not {before:?}");
    }
    Ok(off)
}

fn refusals(subject: &Subject<'_>) -> Finding {
    let fixture = &*subject.fixture.fixture;
    let sigma = subject.fixture.sigma();
    let case = subject.fixture.case(Places::Nominal, 0, 0.0, Some(sigma));
    for count in 1..case.touches.len() {
        let fewer = Case { touches: case.touches[..count].to_vec(), ..case.clone() };
        let problem =
            Problem::new(fixture, &fewer.touches, fewer.probe).map_err(|error| error.to_string())?;
        if problem.require_enough().is_ok() {
            break;
        }
        let code = subject.solve(&fewer)?.err().map(|refusal| refusal.code());
        ensure!(code == Some("too-few-touches"), "{count} of the nominal touches: {code:?}");
    }
    let mut count = 0;
    for trial in 0..subject.fixture.suite.trials {
        let Some((exact, noisy)) = degenerate(&subject.fixture, trial) else { continue };
        for sigma in [Some(sigma), None] {
            let exact = Case { probe: Probe { sigma, ..exact.probe }, ..exact.clone() };
            let outcome = subject.solve(&exact)?;
            ensure!(outcome.is_err(), "{}, sigma {sigma:?}: a frame is handed out", exact.what);
        }
        // Noise makes the layout regular; a frame may stand where it is true all the same.
        if let Ok(solution) = subject.solve(&noisy)? {
            let squared = solution.squared_distance(&noisy.truth).unwrap_or(f64::INFINITY);
            let wrong = chi_square_level(WRONG_LEVEL, 6);
            ensure!(squared <= wrong, "{}: a wrong frame: its squared error is {squared:.1}", noisy.what);
        }
        count += 1;
    }
    Ok(format!("{count} layouts that leave a motion free"))
}

/// As many touches as are needed, but of five points only, so that a motion is free: exact, and with noise. `None`
/// where more surfaces are touched.
fn degenerate(subject: &case::Subject<'_>, trial: u64) -> Option<(Case, Case)> {
    const POINTS: usize = 5;
    let mut rng = subject.generator(Places::Fewest, trial + (1 << 31));
    let mut layout = subject.layout(Places::Fewest, &mut rng);
    layout.shuffle(&mut rng);
    let (points, repeated) = layout.split_at_mut(POINTS);
    for place in repeated {
        *place = *points.iter().find(|point| point.0 == place.0)?;
    }
    let truth = random_frame(case::REACH * subject.size(), &mut rng);
    let sigma = subject.sigma();
    let probe = Probe { tip_radius: subject.tip_radius(), tip_radius_u: 0.0, sigma: Some(sigma) };
    let mut with_noise = |noise| {
        let touches = simulate(&*subject.fixture, &layout, &truth, &probe, noise, &mut rng);
        let what = format!("a layout of {POINTS} points, trial {trial}, noise {noise}");
        Case { what, layout: layout.clone(), truth, probe, touches }
    };
    Some((with_noise(0.0), with_noise(sigma)))
}

fn no_sigma(subject: &Subject<'_>) -> Finding {
    /// What is between the bounds by this factor is not at their edge.
    const EDGE: f64 = 1.1;
    let (sigma, mut accepted, mut count) = (subject.fixture.sigma(), 0, 0);
    for places in Places::ALL {
        for case in subject.fixture.cases(places, sigma, None, SOUND)? {
            count += 1;
            let Ok(solution) = subject.solve(&case)? else { continue };
            accepted += 1;
            let told = |words: String| format!("{}: {words}", case.what);
            nothing_invented(&solution).map_err(told)?;
            // The answer is conditional; where its condition is met, it must be true.
            let trust = &solution.trust;
            if trust.from_sigma * EDGE < sigma && sigma * EDGE < trust.up_to_sigma {
                let with_sigma = Case { probe: Probe { sigma: Some(sigma), ..case.probe }, ..case.clone() };
                let mut stated = subject.solve(&with_sigma)?.map_err(|refusal| {
                    told(format!(
                        "it stands from {} to {}, but {refusal}",
                        trust.from_sigma, trust.up_to_sigma
                    ))
                })?;
                stated.frame = solution.frame;
                let squared = stated.squared_distance(&case.truth);
                let wrong = chi_square_level(WRONG_LEVEL, 6);
                let squared = squared.unwrap_or(f64::INFINITY);
                ensure!(squared <= wrong, "{}", told(format!("wrong: its squared error is {squared:.1}")));
            }
        }
    }
    Ok(format!("{accepted} of {count} accepted"))
}

fn nothing_invented(solution: &Solution) -> Result<(), String> {
    let trust = &solution.trust;
    let (from, up_to) = (trust.from_sigma, trust.up_to_sigma);
    ensure!(from >= 0.0 && from <= up_to, "it stands from {from} to {up_to}");
    let second = trust.second_minimum.and_then(|second| second.chi_square);
    let of_residuals = solution.residuals.iter().find_map(|residual| residual.normalized);
    let of_roots = solution.roots.iter().find_map(|root| root.misfit);
    let u = solution.roots.iter().flat_map(|root| &root.measures).find_map(|measure| measure.u);
    let invented = [
        ("a sigma", trust.sigma),
        ("a chi-square", solution.chi_square),
        ("a p-value", solution.p_value),
        ("a chi-square of the next best frame", second),
        ("a normalized residual", of_residuals),
        ("a misfit of a root", of_roots),
        ("an uncertainty of a measure", u),
    ];
    for (what, value) in invented {
        ensure!(value.is_none(), "no sigma is stated, but {what} of {}", value.unwrap_or_default());
    }
    match &solution.covariance {
        None => Ok(()),
        Some(covariance) => {
            let source = (covariance.sigma_source, solution.degrees_of_freedom > 0);
            let from_residuals = source == (SigmaSource::Residuals, true);
            ensure!(from_residuals, "no sigma is stated, but the covariance stands on {:?}", source.0);
            Ok(())
        }
    }
}

fn wild_touches(subject: &Subject<'_>) -> Finding {
    no_harm(&subject.fixture, |problem| subject.outcome(problem).map(|_| ()))
}

fn null_space(subject: &Subject<'_>) -> Finding {
    let unknowns: Vec<Unknown> = match subject.claim {
        Claim::LeastSquares => Vec::new(),
        Claim::LeastSquaresMeasured => subject.fixture.measured(),
        Claim::Other => return Ok("least squares is not claimed".to_owned()),
    };
    let (mut accepted, mut count, mut worst) = (0, 0, 0.0_f64);
    for trial in 0..subject.fixture.suite.trials {
        let Some((case, reference)) = null_space_case(&subject.fixture, &unknowns, trial) else { continue };
        count += 1;
        let touches: Vec<Touch> = reference.touches.clone();
        // As large as the residuals are: neither too good to be true, nor contradicted.
        let squares = reference.residuals.iter().map(|residual| residual * residual).sum::<f64>();
        let sigma = (squares / touches.len() as f64).sqrt();
        let probe = Probe { sigma: Some(sigma), ..case.probe };
        let case = Case { probe, touches, ..case };
        let Ok(solution) = subject.solve(&case)? else { continue };
        accepted += 1;
        let off = subject.apart(&reference.frame, &solution.frame);
        let bound = RECOVERED * reference.condition;
        ensure!(
            off <= bound,
            "{}, residuals of {sigma:.1e}: {off:.2e} from the design frame (parts of the size, radians), at most \
             {bound:.1e}",
            case.what
        );
        worst = worst.max(off / bound);
    }
    ensure!(2 * accepted >= count, "only {accepted} of {count} sets of reference data give a frame");
    Ok(format!("{accepted} of {count} accepted, at worst {worst:.1e} of the bound"))
}
