//! Many placements of one fixture: sizes of the fixture and the tip radius, shared by all, are calibrated along the way.
//!
//! Maximum likelihood over the frame of every placement and the shared parameters, each with what is known of it, or
//! without. What one placement leaves open (radius and tip act alike on one pin) several may tell; what none tells is
//! refused by name, found from the null space of the information that is left once the frames are eliminated.
//!
//! No start is presumed. A placement is started by [the search and the rule of every
//! solver](crate#when-a-frame-is-accepted), with the shared parameters uncertain by what is known of them; those that are
//! clear tell the parameters, with which the others are looked at again. In the end every placement must have one frame
//! only by the same rule, on the fixture as calibrated. A parameter of which nothing is known has a nominal value all the
//! same: it is taken to be right to 10 % (five times 2 %), so that frames that want another size are out. Where two
//! frames fit within that, the placement is refused as ambiguous.
//!
//! Where no sigma is stated the residuals tell it, if five degrees of freedom are left; nominal values then cannot be
//! weighed against the touches, and stated uncertainties are refused.

mod arrow;

use std::borrow::Cow;

use thiserror::Error;
use touchref_core::{
    Calibration, Covariance, Fixture, FixturePlugin, Frame, ParameterError, Placement, Probe, Problem,
    RANK_TOLERANCE, Residual, SigmaSource, SolveError, Stated, Unknown,
    statistics::{chi_square_level, chi_square_p_value},
};

use crate::{
    acceptance::{
        Account, FREE, INCONSISTENT, Judgement, Margin, Minimum, REACH, Search, degenerate,
        degrees_of_freedom, rank_lost,
    },
    model::{Extra, MAX_EXTRAS, Model, Unknowns, uncertain, with_unknowns},
    refinement::SETTLED,
    words::short,
};
use arrow::{Fit, fit};

/// Standard uncertainty that is taken, to find a start, for a parameter of which nothing is stated: parts of its nominal
/// value, of the fixture's size where that is zero. Frames that want it five times as far off are not considered.
const WIDE: f64 = 0.02;
/// Degrees of freedom with which residuals tell a sigma: to a third of it.
const TELLS_SIGMA: usize = 5;

/// Why there is no calibration.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum BundleError {
    /// What was asked for is none: no placement, no unknown, one twice, or placements of different fixtures.
    #[error("{problem}")]
    Call {
        /// What is wrong, in words.
        problem: String,
        /// What to do about it.
        help: &'static str,
    },
    /// The touches of one placement are wrong, too few, or give no frame to trust.
    #[error("placement {placement}: {error}")]
    Placement {
        /// Which one, from 0.
        placement: usize,
        /// What is wrong with it.
        error: SolveError,
    },
    /// There are fewer touches and stated nominal values than unknowns.
    #[error("{observations} touches and stated uncertainties for {unknowns} unknowns{for_sigma}")]
    TooFew {
        /// Touches of all placements, and parameters with a stated uncertainty.
        observations: usize,
        /// Those of each frame, and the parameters.
        unknowns: usize,
        /// What else they would have to tell, in words.
        for_sigma: &'static str,
    },
    /// The touches of all placements do not tell some of the parameters, or not apart.
    #[error("{what}; {quantity} is {value:.1e}, bound {bound:.0e}")]
    Degenerate {
        /// The parameters concerned.
        parameters: Vec<Cow<'static, str>>,
        /// What is not seen, in words.
        what: String,
        /// What shows it.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// The bound on the wrong side of which it lies.
        bound: f64,
    },
    /// No parameters and frames fit all touches within the noise.
    #[error("{message}")]
    Inconsistent {
        /// What is wrong, with the measured value and the bound.
        message: String,
        /// The placement that fits worst, from 0.
        worst: usize,
    },
    /// As calibrated, another frame than the one found is the likeliest of a placement.
    #[error("placement {placement}: more than one frame fits on the fixture as calibrated")]
    Ambiguous {
        /// Which one, from 0.
        placement: usize,
    },
    /// A value that the touches want is none that the fixture can have.
    #[error("the touches want a fixture that cannot be: {0}")]
    Impossible(ParameterError),
    /// The iteration over all placements did not settle, or has too many unknowns.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

impl BundleError {
    fn call(problem: impl Into<String>, help: &'static str) -> Self {
        Self::Call { problem: problem.into(), help }
    }

    /// The code by which programs know the refusal.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Call { .. } => "invalid-input",
            Self::Placement { error, .. } | Self::Solve(error) => error.code(),
            Self::TooFew { .. } => "too-few-touches",
            Self::Degenerate { .. } => "degenerate",
            Self::Inconsistent { .. } => "inconsistent",
            Self::Ambiguous { .. } => "ambiguous",
            Self::Impossible(_) => "not-converged",
        }
    }

    /// Whether the input is wrong (`true`), or sound without giving anything to trust (`false`).
    #[must_use]
    pub fn is_input_error(&self) -> bool {
        match self {
            Self::Call { .. } | Self::TooFew { .. } => true,
            Self::Placement { error, .. } | Self::Solve(error) => error.is_input_error(),
            _ => false,
        }
    }

    /// What to do about it, in words.
    #[must_use]
    pub fn help(&self) -> &str {
        match self {
            Self::Call { help, .. } => help,
            Self::Placement { error, .. } | Self::Solve(error) => error.help(),
            Self::TooFew { .. } => "add placements, or touches to those there are",
            Self::Degenerate { parameters, .. } if parameters.len() > 1 => {
                "state u for one of them, or take one as exact; or touch surfaces that tell them apart"
            }
            Self::Degenerate { .. } => "state u for it, or touch surfaces that tell it",
            Self::Inconsistent { .. } => {
                "check labels, units and the touches of that placement, the sizes that are taken as exact and the stated \
                 sigma"
            }
            Self::Ambiguous { .. } => "give that placement one more touch, or leave it out",
            Self::Impossible(_) => "check labels and units, or state u for the parameters that are free",
        }
    }

    /// The placement it is about, from 0.
    #[must_use]
    pub fn placement(&self) -> Option<usize> {
        match self {
            Self::Placement { placement, .. } | Self::Ambiguous { placement } => Some(*placement),
            Self::Inconsistent { worst, .. } => Some(*worst),
            _ => None,
        }
    }
}

/// Calibrates what many placements of one fixture share.
///
/// `problems` are the placements, all with the same fixture (of the kind that `plugin` builds) and probe; an expected
/// frame counts. `unknowns` are calibrated; other dimensions and the tip are taken as exact, whatever is stated of them.
///
/// # Errors
/// [`BundleError`]: a call that makes no sense, too few touches, parameters that are not told apart, touches that
/// contradict each other, or a placement whose frame is not to be trusted.
pub fn calibrate(
    plugin: &FixturePlugin,
    problems: &[Problem<'_>],
    unknowns: &[Extra],
) -> Result<Calibration, BundleError> {
    let bundle = Bundle::new(problems, unknowns)?;
    bundle.require_enough()?;
    let starts = bundle.starts(plugin)?;
    let fit = bundle.fit(starts)?;
    bundle.determined(&fit)?;
    bundle.consistent(&fit)?;
    bundle.unique(plugin, &fit)?;
    Ok(bundle.told(&fit))
}

/// The same from frames that are known nearly: the iteration alone, without a search for other frames or a verdict.
///
/// # Errors
/// [`BundleError`]: a call that makes no sense, too few touches, parameters that are not told apart, or an iteration that
/// does not settle.
pub fn adjust(
    problems: &[Problem<'_>],
    unknowns: &[Extra],
    frames: &[Frame],
) -> Result<Calibration, BundleError> {
    let bundle = Bundle::new(problems, unknowns)?;
    if frames.len() != problems.len() {
        let problem = format!("{} frames for {} placements", frames.len(), problems.len());
        return Err(BundleError::call(problem, "give one frame for each placement"));
    }
    bundle.require_enough()?;
    let fit = bundle.fit(frames.iter().copied().map(Unknowns::at).collect())?;
    bundle.determined(&fit)?;
    Ok(bundle.told(&fit))
}

/// What is to be calibrated, checked.
#[derive(Clone, Copy)]
struct Bundle<'a, 'p> {
    problems: &'a [Problem<'p>],
    unknowns: &'a [Extra],
    fixture: &'p dyn Fixture,
    probe: &'a Probe,
    /// Whether a sigma is stated.
    weighed: bool,
}

impl<'a, 'p> Bundle<'a, 'p> {
    fn new(problems: &'a [Problem<'p>], unknowns: &'a [Extra]) -> Result<Self, BundleError> {
        let wrong = |problem: String, help| Err(BundleError::call(problem, help));
        let Some(first) = problems.first() else {
            return wrong("there are no placements".to_owned(), "give the touches of at least one");
        };
        let (fixture, probe) = (first.fixture(), first.probe());
        let weighed = first.reference_sigma().is_some();
        for (index, other) in problems.iter().enumerate() {
            let same_fixture = other.fixture().kind() == fixture.kind()
                && other.fixture().parameters() == fixture.parameters();
            if !same_fixture || other.probe() != probe {
                let problem = format!("placement {index} has another fixture or probe than the first");
                return wrong(problem, "calibrate placements of one fixture, touched with one probe");
            }
            if other.reference_sigma().is_some() != weighed {
                let problem = format!("placement {index} and the first do not both state a sigma");
                return wrong(problem, "state a sigma for all placements, or for none");
            }
        }
        let bundle = Self { problems, unknowns, fixture, probe, weighed };
        bundle.check_unknowns()?;
        Ok(bundle)
    }

    fn check_unknowns(&self) -> Result<(), BundleError> {
        let wrong = |problem: String, help| Err(BundleError::call(problem, help));
        if self.unknowns.is_empty() {
            let help =
                "state a standard uncertainty of a dimension or of the tip radius, or name one that is free";
            return wrong("nothing is unknown besides the frames".to_owned(), help);
        }
        if self.unknowns.len() > MAX_EXTRAS {
            let problem = format!("{} unknown parameters are more than {MAX_EXTRAS}", self.unknowns.len());
            return wrong(problem, "take some of them as exact");
        }
        for (k, unknown) in self.unknowns.iter().enumerate() {
            if let Unknown::Dimension(index) = unknown.what
                && index >= self.fixture.dimensions().len()
            {
                let problem = format!("fixture `{}` has no dimension number {index}", self.fixture.kind());
                return wrong(problem, "dimensions count from 0");
            }
            let name = self.stated(unknown).name;
            if self.unknowns[..k].iter().any(|other| other.what == unknown.what) {
                return wrong(format!("`{name}` is unknown twice"), "name it once");
            }
            match unknown.prior {
                Some(u) if !(u.is_finite() && u > 0.0) => {
                    return wrong(format!("`{name}` has the standard uncertainty {u}"), "it must be above 0");
                }
                Some(_) if !self.weighed => {
                    let problem = format!(
                        "the uncertainty of `{name}` is stated, but no sigma to weigh the touches by"
                    );
                    return wrong(problem, "state a sigma, or let the parameter be free");
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn stated(&self, unknown: &Extra) -> Stated {
        unknown.what.stated(self.fixture, self.probe)
    }

    fn observations(&self) -> usize {
        let touches: usize = self.problems.iter().map(|problem| problem.touches().len()).sum();
        touches + self.unknowns.iter().filter(|unknown| unknown.prior.is_some()).count()
    }

    /// Those of all frames, and the parameters.
    fn count_unknowns(&self) -> usize {
        self.problems.iter().map(Problem::unknowns).sum::<usize>() + self.unknowns.len()
    }

    fn degrees_of_freedom(&self) -> usize {
        self.observations().saturating_sub(self.count_unknowns())
    }

    fn require_enough(&self) -> Result<(), BundleError> {
        for (placement, problem) in self.problems.iter().enumerate() {
            if problem.expected_near().is_none() {
                problem.require_enough().map_err(|error| BundleError::Placement { placement, error })?;
            }
        }
        let (observations, unknowns) = (self.observations(), self.count_unknowns());
        let (spare, for_sigma) = if self.weighed {
            (0, "")
        } else {
            (TELLS_SIGMA, ", and no sigma is stated: five more have to tell it")
        };
        if observations < unknowns + spare {
            return Err(BundleError::TooFew { observations, unknowns, for_sigma });
        }
        Ok(())
    }

    fn fit(&self, starts: Vec<Unknowns>) -> Result<Fit, BundleError> {
        let (problems, unknowns) = (self.problems, self.unknowns);
        Ok(with_unknowns!(unknowns.len(), P => Ok(fit::<P>(problems, unknowns, starts)))?)
    }

    /// A frame near the likeliest of each placement.
    fn starts(&self, plugin: &FixturePlugin) -> Result<Vec<Unknowns>, BundleError> {
        /// What is not clear after as many has nothing more to learn.
        const ROUNDS: usize = 4;
        let guessed = self.guessed();
        let mut known = Known {
            deviations: vec![0.0; guessed.len()],
            uncertainties: guessed.iter().map(|unknown| unknown.prior.unwrap_or(0.0)).collect(),
            sigma: self.probe.sigma,
        };
        let mut found: Vec<Option<Frame>> = vec![None; self.problems.len()];
        let mut rounds = 0;
        loop {
            rounds += 1;
            let (fixture, probe) = self.as_known(plugin, &known)?;
            let (mut news, mut refusal) = (false, None);
            for (placement, problem) in self.problems.iter().enumerate() {
                if found[placement].is_some() {
                    continue;
                }
                match judged(&*fixture, probe, problem) {
                    Ok(minimum) => (found[placement], news) = (Some(minimum.state.frame), true),
                    Err(error) => refusal = refusal.or(Some(BundleError::Placement { placement, error })),
                }
            }
            let Some(refusal) = refusal else {
                let start = |frame: &Frame| {
                    let mut start = Unknowns::at(*frame);
                    start.extras[..known.deviations.len()].copy_from_slice(&known.deviations);
                    start
                };
                return Ok(found.iter().flatten().map(start).collect());
            };
            if !news || rounds == ROUNDS {
                return Err(refusal);
            }
            // What the clear ones tell may clear the others.
            let clear = self.problems.iter().zip(&found).filter(|(_, frame)| frame.is_some());
            let clear: Vec<Problem<'_>> = clear.map(|(problem, _)| *problem).collect();
            let starts = found.iter().flatten().copied().map(Unknowns::at).collect();
            let of_clear = Bundle { problems: &clear, unknowns: &guessed, ..*self };
            let fit = of_clear.fit(starts)?;
            if fit.reduced.unseen() > 0 {
                return Err(refusal);
            }
            known = of_clear.known(&fit);
        }
    }

    /// The unknowns with what is taken to be known of them to find a start. Without a sigma there is nothing to weigh it
    /// against.
    fn guessed(&self) -> Vec<Extra> {
        let guess = |unknown: &Extra| {
            let nominal = self.stated(unknown).nominal.abs();
            let scale = if nominal > 0.0 { nominal } else { self.fixture.size() };
            let prior = if self.weighed { unknown.prior.or(Some(WIDE * scale)) } else { None };
            Extra { prior, ..*unknown }
        };
        self.unknowns.iter().map(guess).collect()
    }

    /// What a fit tells of the shared parameters.
    fn known(&self, fit: &Fit) -> Known {
        let unit = self.unit(fit);
        Known {
            deviations: fit.shared.clone(),
            uncertainties: fit.covariance.diagonal().iter().map(|variance| variance.sqrt() * unit).collect(),
            sigma: if self.weighed { self.probe.sigma } else { Some(unit) },
        }
    }

    /// The standard deviation to which all uncertainties are in proportion, in the problems' own sigmas: that of the
    /// residuals where none is stated.
    fn unit(&self, fit: &Fit) -> f64 {
        if self.weighed { 1.0 } else { (fit.chi_square / self.degrees_of_freedom().max(1) as f64).sqrt() }
    }

    /// The fixture and the probe with the shared parameters as they are known; whatever else is stated as uncertain is
    /// taken as exact.
    fn as_known(
        &self,
        plugin: &FixturePlugin,
        known: &Known,
    ) -> Result<(Box<dyn Fixture>, Probe), BundleError> {
        let mut parameters = self.fixture.parameters().clone();
        let mut probe = Probe { tip_radius_u: 0.0, sigma: known.sigma, ..*self.probe };
        for dimension in self.fixture.dimensions() {
            let scale = dimension.quantity.scale();
            parameters.set_number(&dimension.name, dimension.value * scale, 0.0);
        }
        for ((unknown, deviation), u) in self.unknowns.iter().zip(&known.deviations).zip(&known.uncertainties)
        {
            let Stated { name, nominal, scale, .. } = self.stated(unknown);
            let value = nominal + deviation;
            match unknown.what {
                Unknown::Dimension(_) => {
                    parameters.set_number(&name, value * scale, u * scale);
                }
                // A tip of next to none may come out below it; no probe has such a one.
                Unknown::TipRadius => (probe.tip_radius, probe.tip_radius_u) = (value.max(0.0), *u),
            }
        }
        let fixture = plugin.build(&parameters).map_err(BundleError::Impossible)?;
        Ok((fixture, probe))
    }

    /// Every parameter is told by the touches or by what is known of it.
    fn determined(&self, fit: &Fit) -> Result<(), BundleError> {
        const UNSEEN: &str = "what the frames leave of the information on it (least singular value)";
        let unseen = fit.reduced.unseen();
        if unseen > 0 {
            let value = fit.reduced.singular_values.last().copied().unwrap_or(0.0);
            return Err(self.degenerate(fit, unseen, (UNSEEN, value, RANK_TOLERANCE)));
        }
        let size = self.fixture.size();
        for (k, unknown) in self.unknowns.iter().enumerate() {
            let size = match unknown.what {
                Unknown::Dimension(index)
                    if self.fixture.dimensions()[index].quantity == touchref_core::Quantity::Angle =>
                {
                    1.0
                }
                _ => size,
            };
            let u = fit.covariance[(k, k)].sqrt() * self.unit(fit) / size;
            if unknown.prior.is_none() && (u.is_nan() || u > FREE) {
                let shown = ("its standard uncertainty in parts of the fixture's size (or radians)", u, FREE);
                return Err(self.degenerate(fit, 1, shown));
            }
        }
        let left = fit.step_left / self.unit(fit);
        if left.is_nan() || left > SETTLED {
            let iterations = fit.iteration.steps;
            return Err(SolveError::NotConverged { iterations, step: left, bound: SETTLED }.into());
        }
        Ok(())
    }

    /// The parameters that take part in the `unseen` combinations that are seen least.
    fn degenerate(
        &self,
        fit: &Fit,
        unseen: usize,
        (quantity, value, bound): (&'static str, f64, f64),
    ) -> BundleError {
        /// A parameter whose part in them is less than this has none, but for rounding and weak ties.
        const PART: f64 = 0.1;
        /// A combination whose coefficients differ by less than this is a plain sum or difference.
        const PLAIN: f64 = 1e-2;
        let count = self.unknowns.len();
        let directions = fit.reduced.directions.columns(count - unseen, unseen);
        let concerned: Vec<usize> = (0..count).filter(|k| directions.row(*k).norm() > PART).collect();
        let names: Vec<Cow<'static, str>> =
            concerned.iter().map(|k| self.stated(&self.unknowns[*k]).name).collect();
        let what = match (concerned.as_slice(), names.as_slice()) {
            ([_], [name]) => format!("no touch tells {name}: the frames take up whatever it does"),
            ([a, b], [first, second]) if unseen == 1 => {
                // Along the direction that is not seen both change; what is seen stays.
                let along = |k: usize| directions[(k, 0)] / fit.reduced.scales[k];
                let ratio = -along(*a) / along(*b);
                let seen = if (ratio - 1.0).abs() < PLAIN {
                    format!("{first} + {second}")
                } else if (ratio + 1.0).abs() < PLAIN {
                    format!("{first} - {second}")
                } else {
                    "a combination of them".to_owned()
                };
                format!("the touches do not tell {first} and {second} apart: only {seen} is seen")
            }
            _ => format!("the touches do not tell {} apart", names.join(", ")),
        };
        BundleError::Degenerate { parameters: names, what, quantity, value, bound }
    }

    /// All touches fit, and none of the placements stands out.
    fn consistent(&self, fit: &Fit) -> Result<(), BundleError> {
        if !self.weighed {
            // The residuals are as large as the sigma that they tell.
            return Ok(());
        }
        let count = self.problems.len();
        let level_of_one = |problem: &Problem<'_>| {
            let degrees = degrees_of_freedom(problem);
            // So many placements must not be called inconsistent more often than one.
            (degrees > 0).then(|| chi_square_level(INCONSISTENT.chance() / count as f64, degrees))
        };
        let excess = |placement: usize| {
            let level = level_of_one(&self.problems[placement]);
            level.map_or(0.0, |level| fit.placements[placement].chi_square() / level)
        };
        let worst = (0..count).max_by(|a, b| excess(*a).total_cmp(&excess(*b))).unwrap_or(0);
        let of_worst = fit.placements[worst].chi_square();
        let degrees = self.degrees_of_freedom();
        let level = INCONSISTENT.value(degrees);
        let message = if degrees > 0 && fit.chi_square > level {
            format!(
                "the touches contradict the fixture or each other: chi-square {} with {degrees} degrees of freedom, at \
                 most {} expected (level {}); placement {worst} fits worst, chi-square {} of {} touches",
                short(fit.chi_square),
                short(level),
                INCONSISTENT.chance(),
                short(of_worst),
                self.problems[worst].touches().len(),
            )
        } else if excess(worst) > 1.0 {
            format!(
                "placement {worst} contradicts the others: chi-square {} of {} touches, at most {} expected (level {} for \
                 the worst of {count})",
                short(of_worst),
                self.problems[worst].touches().len(),
                short(level_of_one(&self.problems[worst]).unwrap_or(0.0)),
                INCONSISTENT.chance(),
            )
        } else {
            return Ok(());
        };
        Err(BundleError::Inconsistent { message, worst })
    }

    /// Each placement has one frame only, on the fixture as calibrated.
    fn unique(&self, plugin: &FixturePlugin, fit: &Fit) -> Result<(), BundleError> {
        let (fixture, probe) = self.as_known(plugin, &self.known(fit))?;
        for (placement, problem) in self.problems.iter().enumerate() {
            let minimum = judged(&*fixture, probe, problem)
                .map_err(|error| BundleError::Placement { placement, error })?;
            // Within this distance the misfit was seen to rise as about one minimum.
            if minimum.mahalanobis(&fit.placements[placement].at.frame) > REACH {
                return Err(BundleError::Ambiguous { placement });
            }
        }
        Ok(())
    }

    /// The fit in the words of the result.
    fn told(&self, fit: &Fit) -> Calibration {
        let unit = self.unit(fit);
        let variance = unit * unit;
        let sigma_source = if self.weighed { SigmaSource::Given } else { SigmaSource::Residuals };
        let scales: Vec<f64> = self.unknowns.iter().map(|unknown| self.stated(unknown).scale).collect();
        let covariance = fit.covariance.map_with_location(|i, j, c| c * scales[i] * scales[j] * variance);
        let parameters = self.unknowns.iter().enumerate().map(|(k, unknown)| {
            let u = fit.covariance[(k, k)].sqrt() * unit;
            self.stated(unknown).adjusted(unknown.prior, fit.shared[k], u)
        });
        let sigma_of = |problem: &Problem<'_>| problem.reference_sigma().unwrap_or(unit);
        let placements = self.problems.iter().zip(&fit.placements).map(|(problem, placement)| {
            let residual = |(length, normalized): &(f64, f64)| Residual {
                length: *length,
                normalized: Some(normalized / unit).filter(|_| self.weighed),
            };
            Placement {
                frame: placement.at.frame,
                covariance: Covariance {
                    matrix: placement.covariance * variance,
                    sigma: sigma_of(problem),
                    sigma_source,
                },
                chi_square: self.weighed.then(|| placement.chi_square()),
                residuals: placement.residuals.iter().map(residual).collect(),
            }
        });
        let touches = || self.problems.iter().zip(&fit.placements);
        let count: usize = self.problems.iter().map(|problem| problem.touches().len()).sum();
        let mean = |sum: f64| (sum / count as f64).sqrt();
        let squares =
            touches().flat_map(|(_, placement)| &placement.residuals).map(|(length, _)| length * length);
        let sigmas = touches().map(|(problem, _)| sigma_of(problem).powi(2) * problem.touches().len() as f64);
        let degrees_of_freedom = self.degrees_of_freedom();
        let chi_square = self.weighed.then_some(fit.chi_square);
        Calibration {
            parameters: parameters.collect(),
            placements: placements.collect(),
            sigma: mean(sigmas.sum()),
            sigma_source,
            rms: mean(squares.sum()),
            chi_square,
            degrees_of_freedom,
            p_value: chi_square.and_then(|chi_square| chi_square_p_value(chi_square, degrees_of_freedom)),
            iteration: fit.iteration,
            covariance,
        }
    }
}

/// What is known of the shared parameters while placements are looked at one by one.
struct Known {
    /// From the nominal values, in the order of the unknowns.
    deviations: Vec<f64>,
    uncertainties: Vec<f64>,
    sigma: Option<f64>,
}

/// The frame of one placement, or why it is not to be trusted; how well it fits is for the bundle to say where a sigma is
/// known.
fn judged(fixture: &dyn Fixture, probe: Probe, placed: &Problem<'_>) -> Result<Minimum, SolveError> {
    let mut problem = Problem::new(fixture, placed.touches(), probe)?;
    if let Some(near) = placed.expected_near() {
        problem = problem.near(*near);
    }
    let extras = uncertain(&problem);
    with_unknowns!(extras.len(), P => {
        let model = Model::<P>::new(&problem, &extras);
        let mut judgement = Judgement::of(&model, Search::Fixture, Margin::Near)?;
        let seen = &judgement.observability;
        if seen.rank < problem.unknowns() {
            return Err(degenerate(&problem, seen, rank_lost(seen)));
        }
        let mut bounds = judgement.bounds;
        if problem.reference_sigma().is_some() {
            bounds.from = 0.0;
        }
        let account = Account { problem: &problem, judgement: &judgement, bounds };
        match account.refusal(Vec::new, String::new) {
            Some(refusal) => Err(refusal),
            None => Ok(judgement.minima.swap_remove(judgement.chosen)),
        }
    })
}
