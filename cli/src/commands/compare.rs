//! `compare`: has the fixture moved?

use std::{
    num::NonZero,
    path::{Path, PathBuf},
};

use nalgebra::Point3;
use schemars::JsonSchema;
use serde::Serialize;
use touchref::{
    Covariance, Fixture, Frame, Motion, Probe, Problem, Registry, SigmaSource, Touch, TouchError, Twist,
    Unknown,
    analysis::{
        Estimate, Linear,
        drift::{
            self, Baseline, Change, Comparison, DriftError, Explanation, Hypothesis, Located, Scatter, Seen,
            Significance,
        },
    },
    io::{
        FrameRecord, Input, InputError, SolutionRecord,
        history::{History, Selection},
        schema,
        solution::{FixtureRecord, TwistRecord, WarningRecord},
    },
};

use super::{
    history::{self, SelectionArgs},
    reliability::chance,
};
use crate::{args::Format, failure::Failure, output::Output, points::PointArgs, text};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.comparison/1";

/// Tell whether the fixture has moved between results, by how much, along which motion, and how sure that is
///
/// Each result is held against the baseline: the first result, or the mean of the first ones. The squared Mahalanobis
/// distance of the motion, in the covariance of the difference, is chi-square with as many degrees of freedom as there are
/// motions when nothing has moved (F where the residuals tell the noise); beyond its limit at --alpha the fixture has
/// moved. Exit status 0: nothing has moved; 1: something has; 2: the input or the call is wrong.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref compare cell.db --baseline 5 --series\n\
\x20 touchref compare before.json after.json")]
pub(crate) struct Args {
    /// Result file; or the frames in a store, FILE, or one of them, FILE#NUMBER. In the order of time
    #[arg(value_name = "RESULT", required = true, value_hint = clap::ValueHint::FilePath)]
    results: Vec<String>,
    #[command(flatten)]
    selection: SelectionArgs,
    /// How many of the first results make the baseline: their mean, if they agree
    #[arg(long, value_name = "N", default_value = "1")]
    baseline: NonZero<usize>,
    /// Chance of a false alarm: of one comparison that finds a motion where there is none
    #[arg(long, value_name = "A", default_value_t = drift::ALPHA, value_parser = chance)]
    alpha: f64,
    /// --alpha is the chance of any false alarm in all comparisons together
    #[arg(long)]
    series: bool,
    /// Count nothing as common to the results: other tips, or other fixtures of one drawing
    #[arg(long)]
    independent: bool,
    #[command(flatten)]
    points: PointArgs,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// The JSON of `compare`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ComparisonRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The fixture.
    pub(crate) fixture: FixtureRecord,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    pub(crate) units: String,
    /// Whether any result is out of its limit, or the baseline is no single frame.
    pub(crate) moved: bool,
    /// Chance of a false alarm of one comparison.
    pub(crate) alpha: f64,
    /// Chance of at least one in all of them: 1 - (1 - alpha)^n.
    pub(crate) alpha_of_series: f64,
    /// What counts as the same error in all results: names of parameters, or `tip_radius`.
    pub(crate) common: Vec<String>,
    /// What the results are held against.
    pub(crate) baseline: BaselineRecord,
    /// In the order of the results.
    pub(crate) comparisons: Vec<ChangeRecord>,
    /// Index, in `comparisons`, of the first that has moved.
    pub(crate) first_moved: Option<usize>,
    /// What the user should know.
    pub(crate) warnings: Vec<WarningRecord>,
}

/// What the others are held against.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct BaselineRecord {
    /// What its results are called.
    pub(crate) results: Vec<String>,
    /// Its frame in the parent, the mean of the results' frames.
    pub(crate) frame: FrameRecord,
    /// As a result states it.
    pub(crate) covariance: [[f64; 6]; 6],
    /// Whether they are one frame; `null` for a single result.
    pub(crate) agreement: Option<SignificanceRecord>,
}

/// How far something is from nothing.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SignificanceRecord {
    /// Squared Mahalanobis distance.
    pub(crate) squared_distance: f64,
    /// Which it exceeds by chance `alpha` where there is nothing.
    pub(crate) limit: f64,
    /// `chi-square`, or `F` for a distance that is an F-ratio times its degrees of freedom.
    #[schemars(extend("enum" = ["chi-square", "F"]))]
    pub(crate) distribution: &'static str,
    /// Motions that are compared.
    pub(crate) degrees_of_freedom: usize,
    /// Of the noise, for an F-ratio.
    pub(crate) degrees_of_freedom_of_noise: Option<usize>,
    /// Chance of a larger distance where there is nothing.
    pub(crate) p_value: Option<f64>,
    /// Whether it exceeds the limit.
    pub(crate) exceeded: bool,
}

/// The motion from the baseline to one result.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ChangeRecord {
    /// What the result is called.
    pub(crate) result: String,
    /// When it was recorded, in a store.
    pub(crate) time: Option<String>,
    #[serde(flatten)]
    pub(crate) significance: SignificanceRecord,
    /// Translation of the fixture's origin and rotation vector.
    pub(crate) motion: TwistRecord,
    /// Of the motion: order, axes and origin as those of a frame.
    pub(crate) covariance: [[f64; 6]; 6],
    /// What the motion is mostly; `null` where there is none.
    pub(crate) words: Option<String>,
    /// Length of the translation.
    pub(crate) shift: Uncertain,
    /// Angle of the rotation, degrees.
    pub(crate) turn_deg: Uncertain,
    /// Points of the fixture.
    pub(crate) points: Vec<PointRecord>,
    /// What explains the motion; `null` where there is none, or where the results do not tell.
    pub(crate) explanations: Option<Vec<ExplanationRecord>>,
}

/// A number and its standard uncertainty.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct Uncertain {
    /// The number.
    pub(crate) value: f64,
    /// Its standard uncertainty.
    pub(crate) u: f64,
}

/// How far a point of the fixture has moved.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PointRecord {
    /// Fixture coordinates.
    pub(crate) at: [f64; 3],
    /// Along the parent's axes.
    pub(crate) moved: [f64; 3],
    /// Of `moved`, along the parent's axes.
    pub(crate) covariance: [[f64; 3]; 3],
    /// Length of `moved`.
    pub(crate) distance: Uncertain,
}

/// What may have moved, and how well that explains the touches.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ExplanationRecord {
    /// Name of the surface; `null` for the fixture as a whole.
    pub(crate) surface: Option<String>,
    /// Squared misfit of all touches over the variance, if only this has moved.
    pub(crate) chi_square: f64,
    /// Touches less unknowns.
    pub(crate) degrees_of_freedom: usize,
    /// Chance of a larger `chi_square`.
    pub(crate) p_value: f64,
    /// Whether `p_value` is at least `alpha`.
    pub(crate) explains: bool,
}

/// A result as it was read, and what it is called.
struct Named {
    name: String,
    /// When it was recorded, in a store.
    time: Option<String>,
    record: SolutionRecord,
}

/// A result with a covariance, and what it is called.
struct Dated {
    name: String,
    time: Option<String>,
    record: SolutionRecord,
    frame: Frame,
    probe: Probe,
    covariance: Covariance,
    /// Where the result tells them.
    touches: Option<Vec<Touch>>,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let records = self.read()?;
        let used = self.baseline.get();
        if records.len() <= used {
            let message = format!("{} results are given, of which {used} make the baseline", records.len());
            return Err(InputError::new("invalid-input", message)
                .with_key("RESULT")
                .with_help("give the results before and after, or a store with both")
                .into());
        }
        one_fixture(&records)?;
        let fixture = records[0].record.fixture.build(registry)?;
        let results: Vec<Dated> =
            records.into_iter().map(|one| Dated::of(one, &*fixture)).collect::<Result<_, _>>()?;
        let record = self.compared(&*fixture, &results)?;
        let output = Output::in_form(self.format, &record, &record.warnings, text::comparison);
        Ok(output.with_status(u8::from(record.moved)))
    }

    /// Every result that is named, with its name and time.
    fn read(&self) -> Result<Vec<Named>, InputError> {
        let mut records = Vec::new();
        let mut stores = 0;
        for argument in &self.results {
            let Some((file, number)) = store(argument) else {
                let record = SolutionRecord::read(&Input::from(PathBuf::from(argument)))?;
                records.push(Named { name: argument.clone(), time: None, record });
                continue;
            };
            stores += 1;
            let selection = match number {
                Some(_) => Selection { number, ..Selection::default() },
                None => self.selection.selection(),
            };
            let frames = history::frames(&file, selection)?;
            if let (Some(number), true) = (number, frames.is_empty()) {
                let message = format!("{} has no frame of number {number}", file.display());
                let help = format!("`touchref history {}` lists what it has", file.display());
                return Err(InputError::new("invalid-input", message).with_key("RESULT").with_help(help));
            }
            for recorded in frames {
                let name = format!("{}#{}", file.display(), recorded.number);
                let record = SolutionRecord::from_text(&name, &recorded.entry.json)?;
                records.push(Named { name, time: Some(recorded.time), record });
            }
        }
        if stores == 0 && !self.selection.is_all() {
            let message =
                "--last, --since, --until, --name and --fixture choose from a store, and none is given";
            return Err(
                InputError::new("invalid-input", message).with_help("leave them out, or name a store")
            );
        }
        Ok(records)
    }

    fn compared(&self, fixture: &dyn Fixture, results: &[Dated]) -> Result<ComparisonRecord, Failure> {
        let comparison = Comparison::of(fixture);
        let (common, located) = self.located(fixture, comparison, results)?;
        let (of_baseline, later) = results.split_at(self.baseline.get());
        let (before, after) = located.split_at(self.baseline.get());
        let alpha = if self.series { alpha_of_each(self.alpha, later.len()) } else { self.alpha };
        let Baseline { located: baseline, agreement } =
            comparison.baseline(before).map_err(|error| singular(&error))?;
        let agreement = agreement.map(|agreement| SignificanceRecord::new(agreement, alpha));
        let mut comparisons = Vec::new();
        for (result, located) in later.iter().zip(after) {
            let change = comparison.change(&baseline, located).map_err(|error| singular(&error))?;
            comparisons.push(self.change(fixture, of_baseline, result, &change, alpha)?);
        }
        let first_moved = comparisons.iter().position(|change| change.significance.exceeded);
        let disagrees = agreement.as_ref().is_some_and(|agreement| agreement.exceeded);
        Ok(ComparisonRecord {
            schema: SCHEMA,
            fixture: results[0].record.fixture.clone(),
            units: results[0].record.units.clone(),
            moved: first_moved.is_some() || disagrees,
            alpha,
            alpha_of_series: -(later.len() as f64 * (-alpha).ln_1p()).exp_m1(),
            common: common
                .iter()
                .flatten()
                .map(|unknown| unknown.stated(fixture, &results[0].probe).name.to_string())
                .collect(),
            baseline: BaselineRecord {
                results: of_baseline.iter().map(|result| result.name.clone()).collect(),
                frame: FrameRecord::from(&baseline.frame),
                covariance: baseline.covariance().transpose().into(),
                agreement,
            },
            comparisons,
            first_moved,
            warnings: warnings(results, common.is_none() && !self.independent),
        })
    }

    /// The frames with their uncertainties; and what of these is common to all, `None` where that cannot be told although
    /// something uncertain is.
    fn located(
        &self,
        fixture: &dyn Fixture,
        comparison: Comparison,
        results: &[Dated],
    ) -> Result<(Option<Vec<Unknown>>, Vec<Located>), InputError> {
        let tip = |result: &Dated| (result.probe.tip_radius, result.probe.tip_radius_u);
        let one_tip = results.iter().all(|result| tip(result) == tip(&results[0]));
        let common = |unknown: Unknown| unknown != Unknown::TipRadius || one_tip;
        let independent = || results.iter().map(Dated::independent).collect();
        if self.independent {
            return Ok((Some(Vec::new()), independent()));
        }
        let mut unknowns = Vec::new();
        let mut located = Vec::new();
        for result in results {
            let Some(touches) = &result.touches else { return Ok((None, independent())) };
            let problem = Problem::new(fixture, touches, result.probe)?;
            unknowns = problem.uncertain().map(|(unknown, _)| unknown).filter(|what| common(*what)).collect();
            if unknowns.is_empty() {
                located.push(result.independent());
                continue;
            }
            let linear = Linear::at(&problem, &result.frame);
            let apart =
                linear.and_then(|linear| comparison.taken_apart(&linear, common, &result.covariance.matrix));
            match apart {
                Some(apart) => located.push(apart),
                None => return Ok((None, independent())),
            }
        }
        Ok((Some(unknowns), located))
    }

    fn change(
        &self,
        fixture: &dyn Fixture,
        baseline: &[Dated],
        result: &Dated,
        change: &Change,
        alpha: f64,
    ) -> Result<ChangeRecord, InputError> {
        let significance = SignificanceRecord::new(change.significance, alpha);
        let Twist { translation, rotation } = change.motion;
        let about = change.from.origin.into();
        let turn = change.turn();
        let told = significance.exceeded;
        let explanations =
            if told && !self.independent { explained(baseline, result, fixture)? } else { None };
        Ok(ChangeRecord {
            result: result.name.clone(),
            time: result.time.clone(),
            motion: TwistRecord { translation: translation.into(), rotation: rotation.into(), about },
            covariance: change.covariance.transpose().into(),
            words: told.then(|| Motion::of_fixture(fixture, &change.from, &change.screw(alpha)).to_string()),
            shift: change.shift().into(),
            turn_deg: Uncertain { value: turn.value.to_degrees(), u: turn.u.to_degrees() },
            points: self.points.points().iter().map(|point| PointRecord::new(point, change)).collect(),
            explanations: explanations
                .map(|all| all.iter().map(|one| ExplanationRecord::new(one, fixture, alpha)).collect()),
            significance,
        })
    }
}

/// A store, and the number of a result in it if one is given.
fn store(argument: &str) -> Option<(PathBuf, Option<i64>)> {
    if History::is_at(Path::new(argument)) {
        return Some((argument.into(), None));
    }
    let (file, number) = argument.rsplit_once('#')?;
    let number = number.parse().ok()?;
    History::is_at(Path::new(file)).then(|| (file.into(), Some(number)))
}

/// Refuses results of different fixtures or in different units.
fn one_fixture(records: &[Named]) -> Result<(), InputError> {
    let Named { name: first_name, record: first, .. } = &records[0];
    let differ = |name: &str, what: String, help: &str| {
        InputError::new("invalid-input", format!("{first_name} and {name} {what}"))
            .with_key("RESULT")
            .with_help(help)
    };
    for Named { name, record: other, .. } in &records[1..] {
        let (a, b) = (&first.fixture, &other.fixture);
        if a.kind != b.kind {
            let what = format!("are of different fixtures: {} and {}", a.kind, b.kind);
            return Err(differ(name, what, "compare results of one fixture"));
        }
        if first.units != other.units {
            let what = format!("are in different units: {} and {}", first.units, other.units);
            return Err(differ(name, what, "locate both in one unit: lengths are never converted"));
        }
        let keys = a.parameters.keys().chain(b.parameters.keys());
        if let Some(key) = keys.into_iter().find(|key| a.parameters.get(*key) != b.parameters.get(*key)) {
            let told = |fixture: &FixtureRecord| {
                fixture.parameters.get(key).map_or_else(|| "none".to_owned(), ToString::to_string)
            };
            let what = format!("have different fixtures: {key} is {} and {}", told(a), told(b));
            return Err(differ(
                name,
                what,
                "compare results of one fixture, located with the same parameters",
            ));
        }
    }
    Ok(())
}

impl Dated {
    fn of(Named { name, time, record }: Named, fixture: &dyn Fixture) -> Result<Self, InputError> {
        let covariance = record.covariance.as_ref().map(Covariance::from).ok_or_else(|| {
            let message = format!("{name} has no covariance, so that no significance can be told");
            InputError::new("invalid-input", message)
                .with_file(&name)
                .with_key("covariance")
                .with_help("state sigma under [probe], or touch more than the fewest, and locate again")
        })?;
        let touches = record.used_touches(fixture).map_err(InputError::from)?;
        let frame = record.located_frame().unwrap_or_else(Frame::identity);
        let probe = record.probe.into();
        Ok(Self { name, time, record, frame, probe, covariance, touches })
    }

    /// The frame, all of its uncertainty its own.
    fn independent(&self) -> Located {
        let Covariance { matrix, sigma, sigma_source } = self.covariance;
        let estimated = (sigma_source == SigmaSource::Residuals)
            .then_some(Scatter { sigma, degrees_of_freedom: self.record.degrees_of_freedom.max(1) });
        Located::independent(self.frame, matrix, estimated)
    }
}

/// What may have moved; `None` where the results do not tell.
fn explained(
    baseline: &[Dated],
    later: &Dated,
    fixture: &dyn Fixture,
) -> Result<Option<Vec<Explanation>>, InputError> {
    let seen = |result| seen(result, fixture);
    let before = baseline.iter().map(seen).collect::<Result<Option<Vec<_>>, _>>()?;
    match (before, seen(later)?) {
        (Some(before), Some(later)) => Ok(drift::explain(&before, &later)?),
        _ => Ok(None),
    }
}

fn seen<'a>(result: &'a Dated, fixture: &'a dyn Fixture) -> Result<Option<Seen<'a>>, TouchError> {
    let Some(touches) = &result.touches else { return Ok(None) };
    Ok(Some(Seen { problem: Problem::new(fixture, touches, result.probe)?, frame: result.frame }))
}

/// What the user should know of the results.
fn warnings(results: &[Dated], not_apart: bool) -> Vec<WarningRecord> {
    let mut warnings = Vec::new();
    let mut warn = |code: &str, message: String| {
        warnings.push(WarningRecord { code: code.to_owned(), message });
    };
    let first = &results[0];
    if let Some(other) = results.iter().find(|other| other.record.solver != first.record.solver) {
        let (a, b) = (&first.record.solver, &other.record.solver);
        warn("solvers-differ", format!("{} is of solver {a}, {} of {b}", first.name, other.name));
    }
    if let Some(other) = results.iter().find(|other| other.probe != first.probe) {
        warn(
            "probes-differ",
            format!(
                "{} and {} state different probes; of the tip nothing is common then",
                first.name, other.name
            ),
        );
    }
    let scatter = |result: &Dated| result.independent().estimated;
    if let Some(known) = scatter(first)
        && let Some(other) =
            results.iter().find(|other| scatter(other).is_some_and(|own| own.differs_from(known)))
    {
        let message = format!(
            "the residuals of {} and {} do not show the same noise, which is taken to be one",
            first.name, other.name
        );
        warn("noise-differs", message);
    }
    if not_apart {
        warn(
            "common-errors",
            "what the results owe to the same errors of sizes and tip cannot be taken apart, as a result does not tell \
             its touches or its solver weighs them otherwise: all uncertainty counts as independent, and a motion is \
             less significant than it could be"
                .to_owned(),
        );
    }
    warnings
}

fn singular(error: &DriftError) -> Failure {
    InputError::new("invalid-input", error.to_string())
        .with_help("locate again with touches that see every motion")
        .into()
}

/// The chance of a false alarm of each of so many comparisons, for this chance of any.
fn alpha_of_each(alpha_of_series: f64, comparisons: usize) -> f64 {
    -((-alpha_of_series).ln_1p() / comparisons as f64).exp_m1()
}

impl SignificanceRecord {
    fn new(significance: Significance, alpha: f64) -> Self {
        Self {
            squared_distance: significance.squared_distance,
            limit: significance.limit(alpha),
            distribution: if significance.of_noise.is_some() { "F" } else { "chi-square" },
            degrees_of_freedom: significance.degrees_of_freedom,
            degrees_of_freedom_of_noise: significance.of_noise,
            p_value: significance.p_value(),
            exceeded: significance.exceeds(alpha),
        }
    }
}

impl From<Estimate> for Uncertain {
    fn from(Estimate { value, u }: Estimate) -> Self {
        Self { value, u }
    }
}

impl PointRecord {
    fn new(point: &Point3<f64>, change: &Change) -> Self {
        let moved = change.at(point);
        Self {
            at: (*point).into(),
            moved: moved.vector.into(),
            covariance: moved.covariance.transpose().into(),
            distance: moved.length().into(),
        }
    }
}

impl ExplanationRecord {
    fn new(explanation: &Explanation, fixture: &dyn Fixture, alpha: f64) -> Self {
        let Explanation { hypothesis, chi_square, degrees_of_freedom, p_value } = *explanation;
        let surface = match hypothesis {
            Hypothesis::Fixture => None,
            Hypothesis::Surface(index) => Some(fixture.surfaces()[index].name.clone()),
        };
        Self { surface, chi_square, degrees_of_freedom, p_value, explains: p_value >= alpha }
    }
}
