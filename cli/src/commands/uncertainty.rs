//! `uncertainty`: how sure the frame is where it is used, and where that comes from.

use nalgebra::Point3;
use schemars::JsonSchema;
use serde::Serialize;
use touchref::{
    Problem, Registry, Solution,
    analysis::{
        Uncertainty, UncertaintyError,
        propagation::{Interval, MonteCarlo, Propagated, PropagationError, Trials, Validation},
        uncertainty::{Contribution, Draws, Spread},
    },
    io::{
        FrameRecord, InputError, schema,
        solution::{FixtureRecord, ProbeRecord, WarningRecord},
    },
    observability::direction_in_words,
    solvers::refinement::refine,
};

use crate::{
    args::Format,
    commands::reliability::chance,
    failure::Failure,
    output::{Output, progress},
    points::{InUse, UseArgs},
    samples::trials,
    setup::{Setup, missing_sigma},
    text,
};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.uncertainty/1";

/// Residuals of fewer degrees of freedom tell a sigma that has no variance of its own: nothing settles.
const LEAST_DEGREES: usize = 3;

/// Tell how sure the frame is where it is used: to first order and by Monte Carlo, with a budget of the sources
///
/// Touch noise, and the uncertainty that is stated of sizes and of the tip radius, are carried to each point of use. The
/// Monte Carlo method (JCGM 101) draws all of them again and again and finds the frame anew; where its intervals agree with
/// those of first order, these are validated (clause 8).
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref uncertainty examples/three-sphere.toml --at 300,0,0 --samples 10000")]
pub(crate) struct Args {
    #[command(flatten)]
    of: UseArgs,
    /// Draws of the Monte Carlo method: a number, `auto` (until its figures are stable) or `none`
    #[arg(long, value_name = "N", default_value = "auto", value_parser = samples)]
    samples: Samples,
    /// Chance with which an interval covers the true value
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = chance)]
    probability: f64,
    /// Significant digits of the uncertainties to which Monte Carlo and first order are to agree
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=2))]
    digits: u32,
    /// Seed: the same seed gives the same draws, whatever the number of threads
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// How many draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Samples {
    None,
    Some(Trials),
}

fn samples(text: &str) -> Result<Samples, String> {
    match text.trim() {
        "none" => Ok(Samples::None),
        some => trials(some).map(Samples::Some).map_err(|error| format!("{error}, or `none`")),
    }
}

/// The JSON of `uncertainty`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct UncertaintyRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The fixture.
    pub(crate) fixture: FixtureRecord,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    pub(crate) units: &'static str,
    /// The probe as used.
    pub(crate) probe: ProbeRecord,
    /// The fixture's frame in the parent.
    pub(crate) frame: FrameRecord,
    /// Chance with which an interval covers the true value.
    pub(crate) probability: f64,
    /// `null`: what is stated is known exactly.
    pub(crate) degrees_of_freedom: Option<usize>,
    /// By which a standard uncertainty is multiplied for that.
    pub(crate) coverage_factor: f64,
    /// Standard deviation of one touch that all rests on.
    pub(crate) sigma: f64,
    /// `given` or `residuals`.
    #[schemars(schema_with = "schema::sigma_source")]
    pub(crate) sigma_source: &'static str,
    /// Each point of use: lengths.
    pub(crate) points: Vec<QuantityRecord>,
    /// The rotation vector: radians.
    pub(crate) rotation: QuantityRecord,
    /// What draws tell; `null` where none were made.
    pub(crate) monte_carlo: Option<MonteCarloRecord>,
    /// What the user should know.
    pub(crate) warnings: Vec<WarningRecord>,
}

/// Uncertainty of three numbers along the parent's axes.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct QuantityRecord {
    /// The point, in fixture coordinates.
    pub(crate) at: Option<[f64; 3]>,
    /// Where that is, in the parent.
    pub(crate) place: Option<[f64; 3]>,
    /// Standard uncertainties along the parent's axes.
    pub(crate) u: [f64; 3],
    /// Expanded ones.
    pub(crate) expanded: [f64; 3],
    /// Along the parent's axes, rows first.
    pub(crate) covariance: [[f64; 3]; 3],
    /// The direction that is known least.
    pub(crate) worst: WorstRecord,
    /// What each source contributes.
    pub(crate) budget: Vec<ContributionRecord>,
}

/// The direction that is known least.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct WorstRecord {
    /// Standard uncertainty along it.
    pub(crate) u: f64,
    /// Expanded uncertainty along it.
    pub(crate) expanded: f64,
    /// A unit vector of the parent.
    pub(crate) direction: [f64; 3],
    /// The same in words.
    pub(crate) along: String,
}

/// What one source contributes.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ContributionRecord {
    /// The source, in words.
    pub(crate) source: String,
    /// Standard uncertainties along the parent's axes that it alone would leave.
    pub(crate) u: [f64; 3],
    /// The same along the worst direction of the whole.
    pub(crate) u_worst: f64,
    /// Its part of the variance along that direction.
    pub(crate) share: f64,
}

/// What the draws tell.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct MonteCarloRecord {
    /// Of the random numbers.
    pub(crate) seed: u64,
    /// Draws that were made.
    pub(crate) trials: u64,
    /// Draws without a frame, left out.
    pub(crate) failed: u64,
    /// Whether further draws would change none of the digits.
    pub(crate) stable: bool,
    /// Significant digits of the uncertainties to which all is compared.
    pub(crate) digits: u32,
    /// In the order of the points, `x y z` of each, then the rotation.
    pub(crate) quantities: Vec<DrawnRecord>,
    /// Whether the intervals of first order are validated (JCGM 101, clause 8).
    pub(crate) validated: bool,
}

/// One number, from where the measurement has it.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct DrawnRecord {
    /// `x at 0,0,0`, `rx`.
    pub(crate) name: String,
    /// Mean deviation of the draws: the bias of the frame, where it is more than chance.
    pub(crate) mean: f64,
    /// Standard deviation of the draws.
    pub(crate) u: f64,
    /// The interval, from the value measured.
    pub(crate) low: f64,
    /// Its upper end.
    pub(crate) high: f64,
    /// That of first order.
    pub(crate) first_order: [f64; 2],
    /// By so much the ends may differ.
    pub(crate) tolerance: f64,
    /// Whether they do not.
    pub(crate) validated: bool,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let InUse { setup, solution, points } = self.of.locate(registry)?;
        let problem = setup.problem()?;
        let uncertainty = Uncertainty::of(&problem, &solution.frame).map_err(failure)?;
        let mut record = self.record(&setup, &problem, &solution, &uncertainty, &points)?;
        record.monte_carlo = self.drawn(registry, &setup, &problem, &uncertainty, &points)?;
        if let Some(warning) = record.monte_carlo.as_ref().and_then(doubt) {
            record.warnings.push(warning);
        }
        if record.monte_carlo.is_none() && self.samples != Samples::None {
            let message = format!(
                "no Monte Carlo: a sigma from residuals of fewer than {LEAST_DEGREES} degrees of freedom has no variance; \
                 state one"
            );
            record.warnings.push(WarningRecord { code: "no-monte-carlo".to_owned(), message });
        }
        Ok(Output::in_form(self.format, &record, &record.warnings, text::uncertainty))
    }

    fn record(
        &self,
        setup: &Setup,
        problem: &Problem<'_>,
        solution: &Solution,
        uncertainty: &Uncertainty,
        points: &[Point3<f64>],
    ) -> Result<UncertaintyRecord, Failure> {
        let frame = &solution.frame;
        let factor = uncertainty.coverage_factor(self.probability);
        let quantity = |spread: Spread, budget: Vec<Contribution>, at: Option<&Point3<f64>>| {
            let (u, direction) = spread.worst();
            let contribution = |part: &Contribution| {
                let u_worst = part.spread.along(&direction);
                ContributionRecord {
                    source: part.source.in_words(problem),
                    u: part.spread.along_axes(),
                    u_worst,
                    share: if u > 0.0 { (u_worst / u).powi(2) } else { 0.0 },
                }
            };
            QuantityRecord {
                at: at.map(|point| (*point).into()),
                place: at.map(|point| frame.to_parent(point).into()),
                u: spread.along_axes(),
                expanded: spread.along_axes().map(|u| factor * u),
                covariance: spread.0.transpose().into(),
                worst: WorstRecord {
                    u,
                    expanded: factor * u,
                    direction: direction.into(),
                    along: direction_in_words(problem.fixture(), frame, &direction),
                },
                budget: budget.iter().map(contribution).collect(),
            }
        };
        let context = setup.context()?;
        Ok(UncertaintyRecord {
            schema: SCHEMA,
            fixture: FixtureRecord::new(context.kind, context.parameters),
            units: context.units.name(),
            probe: ProbeRecord::from(context.probe),
            frame: FrameRecord::from(frame),
            probability: self.probability,
            degrees_of_freedom: uncertainty.degrees_of_freedom(),
            coverage_factor: factor,
            sigma: problem.reference_sigma().unwrap_or(uncertainty.sigma_of_residuals()),
            sigma_source: uncertainty.sigma_source().name(),
            points: points
                .iter()
                .map(|point| {
                    quantity(uncertainty.of_point(point), uncertainty.budget_of_point(point), Some(point))
                })
                .collect(),
            rotation: quantity(uncertainty.of_turn(), uncertainty.budget_of_turn(), None),
            monte_carlo: None,
            warnings: setup.warnings().iter().map(WarningRecord::from).collect(),
        })
    }

    /// What draws tell; `None` where none are wanted, or none would settle.
    fn drawn(
        &self,
        registry: &Registry,
        setup: &Setup,
        problem: &Problem<'_>,
        uncertainty: &Uncertainty,
        points: &[Point3<f64>],
    ) -> Result<Option<MonteCarloRecord>, Failure> {
        let Samples::Some(trials) = self.samples else { return Ok(None) };
        let of_residuals =
            uncertainty.degrees_of_freedom().map(|degrees| (uncertainty.sigma_of_residuals(), degrees));
        if of_residuals.is_some_and(|(_, degrees)| degrees < LEAST_DEGREES) {
            return Ok(None);
        }
        let draws = Draws {
            problem,
            plugin: setup.measurement.plugin(registry)?,
            frame: uncertainty.frame(),
            points,
            estimator: &|problem, near| Some(refine(problem, near).ok()?.unknowns.frame),
            of_residuals,
        };
        let monte_carlo = MonteCarlo {
            probability: self.probability,
            digits: self.digits,
            seed: self.seed,
            trials,
            interval: Interval::Symmetric,
        };
        let bar = progress(match trials {
            Trials::Fixed(trials) | Trials::Adaptive { most: trials } => trials,
        });
        let made = |count| bar.inc(count);
        let propagated = monte_carlo.run(draws.outputs(), &|rng, row| draws.draw(rng, row), &made);
        drop(bar);
        let propagated = propagated.map_err(|error| too_uncertain(&error))?;
        Ok(Some(self.told(&propagated, uncertainty, points)))
    }

    fn told(
        &self,
        drawn: &Propagated,
        uncertainty: &Uncertainty,
        points: &[Point3<f64>],
    ) -> MonteCarloRecord {
        let factor = uncertainty.coverage_factor(self.probability);
        let of_points =
            points.iter().map(|point| (uncertainty.of_point(point), ["x", "y", "z"], Some(point)));
        let all = of_points.chain([(uncertainty.of_turn(), ["rx", "ry", "rz"], None)]);
        let numbers = all.flat_map(|(spread, names, at)| {
            let at =
                at.map_or_else(String::new, |point| format!(" at {}, {}, {}", point.x, point.y, point.z));
            names.into_iter().zip(spread.along_axes()).map(move |(name, u)| (format!("{name}{at}"), u))
        });
        let quantities: Vec<DrawnRecord> = numbers
            .zip(&drawn.outputs)
            .map(|((name, u), output)| {
                let first_order = [-factor * u, factor * u];
                // The number of digits is checked where it is typed.
                let compared = Validation::new(first_order, [output.low, output.high], u, self.digits);
                let (tolerance, validated) = compared.map_or((0.0, false), |v| (v.tolerance, v.validated()));
                DrawnRecord {
                    name,
                    mean: output.estimate,
                    u: output.u,
                    low: output.low,
                    high: output.high,
                    first_order,
                    tolerance,
                    validated,
                }
            })
            .collect();
        MonteCarloRecord {
            seed: self.seed,
            trials: drawn.trials,
            failed: drawn.failed,
            stable: drawn.stable,
            digits: self.digits,
            validated: quantities.iter().all(|quantity| quantity.validated),
            quantities,
        }
    }
}

/// What there is to doubt after the draws.
fn doubt(drawn: &MonteCarloRecord) -> Option<WarningRecord> {
    let message = if !drawn.validated {
        "first order is not validated by Monte Carlo: take the intervals of that"
    } else if drawn.failed > 0 {
        "some draws have no frame, and are left out of the intervals of Monte Carlo"
    } else {
        return None;
    };
    Some(WarningRecord { code: "first-order-doubtful".to_owned(), message: message.to_owned() })
}

fn failure(error: UncertaintyError) -> Failure {
    match error {
        UncertaintyError::NoSigma => missing_sigma(error.to_string()).into(),
        // The frame was accepted: what is left is a layout at the very edge of that.
        _ => InputError::new("degenerate", error.to_string()).with_help("add touches").into(),
    }
}

fn too_uncertain(error: &PropagationError) -> Failure {
    let help = "state smaller uncertainties, or draw none (--samples none); --samples must be large enough for --probability";
    InputError::new("invalid-input", error.to_string()).with_key("samples").with_help(help).into()
}
