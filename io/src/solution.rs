//! The JSON of a frame: `touchref.solution/1`.
//!
//! Where a number does not exist it is `null`, never invented: no sigma is stated, or nothing limits it (an infinite
//! `up_to_sigma` or `condition`). Numbers print with the digits that round-trip.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use touchref_core::{
    Adjustment, Covariance, Iteration, Limit, Literal, Measure, Motion, Noise, Observability, Parameters,
    Probe, Residual, RootReport, Solution, Trust, Twist, Value, Warning,
};

use crate::{FrameRecord, TouchRecord, Units, schema};

/// The schema that [`SolutionRecord`] states.
pub const SCHEMA: &str = "touchref.solution/1";

/// A frame with all that was weighed on the way; lengths in `units`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SolutionRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    pub schema: String,
    /// The fixture.
    pub fixture: FixtureRecord,
    /// Name of the solver.
    pub solver: String,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    pub units: String,
    /// The probe as used.
    pub probe: ProbeRecord,
    /// The fixture's frame in the parent.
    pub frame: FrameRecord,
    /// Motions along and about the frame's own axes that the fixture leaves free, by name; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub free: Vec<String>,
    /// The touches in input order, with their residuals.
    pub touches: Vec<ResidualRecord>,
    /// Root mean square of the residuals of the touches that are not excluded.
    pub rms: Option<f64>,
    /// Squared misfit over the variance.
    pub chi_square: Option<f64>,
    /// Touches that are not excluded, less unknowns.
    pub degrees_of_freedom: usize,
    /// Chance of a larger `chi_square`.
    pub p_value: Option<f64>,
    /// Covariance of the frame.
    pub covariance: Option<CovarianceRecord>,
    /// Every root, and why all but one are out.
    pub roots: Vec<RootRecord>,
    /// Uncertain dimensions and tip radius that were unknowns beside the frame.
    #[serde(default)]
    pub adjustments: Vec<AdjustmentRecord>,
    /// How the iteration ended, where there was one.
    #[serde(default)]
    pub iteration: Option<IterationRecord>,
    /// The margin within which the frame stands.
    pub trust: TrustRecord,
    /// What the touches see.
    pub observability: ObservabilityRecord,
    /// What the user should know although the frame stands.
    pub warnings: Vec<WarningRecord>,
    /// The frame in the words of machines, by dialect.
    pub dialects: BTreeMap<String, String>,
    /// What the numbers in these words mean, and what they lose, by dialect; left out where there are none.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub dialect_notes: BTreeMap<String, DialectNote>,
}

/// What the numbers of a literal mean, and what they lose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DialectNote {
    /// What they are relative to.
    pub parent: String,
    /// Unit of the lengths, and of the rotation: `mm, degrees`.
    pub units: String,
    /// How the numbers of rotation make the rotation.
    pub convention: String,
    /// How many digits are printed.
    pub digits: String,
    /// Where the literal goes, and what to verify on the machine.
    pub usage: String,
    /// What the dialect cannot tell, and leaves out as far as that is allowed: `tilt`; `null` when it tells all.
    pub leaves_out: Option<String>,
    /// By how much at most the literal, read back, displaces a touch, in the measurement's unit.
    pub rounding_loss: f64,
    /// How far the touch farthest from the fixture's origin is from it, in the measurement's unit.
    pub farthest_touch: f64,
}

impl From<&Literal> for DialectNote {
    fn from(literal: &Literal) -> Self {
        let convention = &literal.convention;
        Self {
            parent: convention.parent.to_owned(),
            units: format!("{}, {}", literal.units, convention.angles),
            convention: convention.rotation.clone(),
            digits: convention.digits.clone(),
            usage: convention.usage.to_owned(),
            leaves_out: convention.omission.map(|omission| omission.what.to_owned()),
            rounding_loss: literal.rounding_loss,
            farthest_touch: literal.farthest_touch,
        }
    }
}

/// What a [`SolutionRecord`] is made from.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    /// Kind of the fixture.
    pub kind: &'a str,
    /// Its parameters, defaults filled in.
    pub parameters: &'a Parameters,
    /// Unit of every length.
    pub units: Units,
    /// The probe as used.
    pub probe: &'a Probe,
    /// The touches in input order.
    pub touches: &'a [TouchRecord],
}

impl SolutionRecord {
    /// The record of a solution.
    #[must_use]
    pub fn new(context: &Context<'_>, solution: &Solution) -> Self {
        let touches = solution.residuals.iter().zip(context.touches).enumerate();
        Self {
            schema: SCHEMA.to_owned(),
            fixture: FixtureRecord::new(context.kind, context.parameters),
            solver: solution.solver.to_owned(),
            units: context.units.name().to_owned(),
            probe: ProbeRecord::from(context.probe),
            frame: FrameRecord::from(&solution.frame),
            free: solution.freedom.names().map(str::to_owned).collect(),
            touches: touches
                .map(|(index, (residual, touch))| ResidualRecord {
                    excluded: solution.excluded.contains(&index),
                    ..ResidualRecord::new(index, touch, residual)
                })
                .collect(),
            rms: finite(solution.rms),
            chi_square: solution.chi_square.and_then(finite),
            degrees_of_freedom: solution.degrees_of_freedom,
            p_value: solution.p_value.and_then(finite),
            covariance: solution.covariance.as_ref().map(CovarianceRecord::from),
            roots: solution.roots.iter().map(RootRecord::from).collect(),
            adjustments: solution.adjustments.iter().map(AdjustmentRecord::from).collect(),
            iteration: solution.iteration.map(IterationRecord::from),
            trust: TrustRecord::from(&solution.trust),
            observability: ObservabilityRecord::from(&solution.observability),
            warnings: solution.warnings.iter().map(WarningRecord::from).collect(),
            dialects: BTreeMap::new(),
            dialect_notes: BTreeMap::new(),
        }
    }

    /// Adds the frame in the words of the dialect that goes by `name`.
    pub fn tell(&mut self, name: &str, literal: &Literal) {
        self.dialects.insert(name.to_owned(), literal.text.clone());
        self.dialect_notes.insert(name.to_owned(), DialectNote::from(literal));
    }
}

/// The number, if there is one to write.
pub(crate) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// A fixture: kind and parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FixtureRecord {
    /// Name of its plugin.
    pub kind: String,
    /// Parameters by name, in the order of the plugin's description; a number that is uncertain is `{ value, u }`.
    #[schemars(schema_with = "schema::parameters")]
    pub parameters: serde_json::Map<String, serde_json::Value>,
}

impl FixtureRecord {
    /// The record of a fixture.
    #[must_use]
    pub fn new(kind: &str, parameters: &Parameters) -> Self {
        Self { kind: kind.to_owned(), parameters: self::parameters(parameters) }
    }
}

fn parameters(parameters: &Parameters) -> serde_json::Map<String, serde_json::Value> {
    parameters.iter().map(|(name, value)| (name.to_owned(), parameter(value))).collect()
}

/// A parameter as JSON.
pub(crate) fn parameter(value: &Value) -> serde_json::Value {
    match value {
        Value::Number { value, u } if *u == 0.0 => (*value).into(),
        Value::Number { value, u } => serde_json::json!({ "value": value, "u": u }),
        Value::Numbers(values) => values.clone().into(),
        Value::Word(word) => word.clone().into(),
        Value::Flag(flag) => (*flag).into(),
        Value::Words(words) => words.clone().into(),
        Value::Tables(tables) => tables.iter().map(parameters).collect::<Vec<_>>().into(),
        _ => serde_json::Value::Null,
    }
}

/// The probe as used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProbeRecord {
    /// Radius of the tip; 0 where touches are surface points.
    pub tip_radius: f64,
    /// Its standard uncertainty.
    pub tip_radius_u: f64,
    /// Standard deviation of one touch along the normal, as stated.
    pub sigma: Option<f64>,
}

impl From<&Probe> for ProbeRecord {
    fn from(probe: &Probe) -> Self {
        Self { tip_radius: probe.tip_radius, tip_radius_u: probe.tip_radius_u, sigma: probe.sigma }
    }
}

/// How far one touch is from its surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualRecord {
    /// Which touch, from 0.
    pub index: usize,
    /// What the user calls it.
    pub id: Option<String>,
    /// Name of the surface.
    pub surface: String,
    /// Centre of the tip, in the parent; older results do not tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
    /// Standard deviation along the surface's normal, where the touch states its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma: Option<f64>,
    /// Covariance of the position, along the parent's axes, where the touch states that instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<[[f64; 3]; 3]>,
    /// Direction in which the probe moved, in the parent, where that is stated; a unit vector.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub approach: Option<[f64; 3]>,
    /// Signed distance from the surface less the tip radius.
    pub residual: Option<f64>,
    /// The same in standard deviations.
    pub normalized: Option<f64>,
    /// Whether the frame does not rest on it, as the solver holds it for bad.
    #[serde(default, skip_serializing_if = "is_not")]
    pub excluded: bool,
    /// Whether the measurement left its surface open, and the solver found it.
    #[serde(default, skip_serializing_if = "is_not")]
    pub label_found: bool,
}

/// What is not so is not written.
#[allow(clippy::trivially_copy_pass_by_ref)] // As serde asks.
fn is_not(flag: &bool) -> bool {
    !flag
}

impl ResidualRecord {
    pub(crate) fn new(index: usize, touch: &TouchRecord, residual: &Residual) -> Self {
        Self {
            index,
            id: touch.id.clone(),
            surface: touch.surface.clone(),
            at: Some(touch.at.into()),
            sigma: match touch.noise {
                Noise::Sigma(sigma) => Some(sigma),
                _ => None,
            },
            covariance: match touch.noise {
                Noise::Covariance(covariance) => Some(covariance.transpose().into()),
                _ => None,
            },
            approach: touch.approach.map(|direction| direction.into_inner().into()),
            residual: finite(residual.length),
            normalized: residual.normalized.and_then(finite),
            excluded: false,
            label_found: touch.label_found,
        }
    }
}

/// What the rows of a frame's covariance are.
const ORDER: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Covariance of a frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CovarianceRecord {
    /// The 6x6 matrix, rows first.
    pub matrix: [[f64; 6]; 6],
    /// What its rows are: `x y z rx ry rz`, translation of the fixture's origin and rotation vector; radians.
    #[schemars(extend("const" = ORDER))]
    pub order: [String; 6],
    /// Along which axes: `parent`.
    #[schemars(extend("const" = "parent"))]
    pub axes: String,
    /// About which point rotations are: `origin`, the fixture's.
    #[schemars(extend("const" = "origin"))]
    pub about: String,
    /// Standard deviation of one touch that it stands on.
    pub sigma: Option<f64>,
    /// `given` or `residuals`.
    #[schemars(schema_with = "schema::sigma_source")]
    pub sigma_source: String,
}

impl From<&Covariance> for CovarianceRecord {
    fn from(covariance: &Covariance) -> Self {
        Self {
            matrix: covariance.matrix.transpose().into(),
            order: ORDER.map(str::to_owned),
            axes: "parent".to_owned(),
            about: "origin".to_owned(),
            sigma: finite(covariance.sigma),
            sigma_source: covariance.sigma_source.name().to_owned(),
        }
    }
}

/// One root, and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RootRecord {
    /// Its frame.
    pub frame: FrameRecord,
    /// The dimensions it implies, by name: lengths, or degrees.
    #[schemars(with = "BTreeMap<String, Option<f64>>")]
    pub measures: serde_json::Map<String, serde_json::Value>,
    /// Their standard uncertainties.
    #[schemars(with = "BTreeMap<String, Option<f64>>")]
    pub measures_u: serde_json::Map<String, serde_json::Value>,
    /// How far it is from the known geometry, in standard deviations.
    pub misfit: Option<f64>,
    /// Whether it is the one.
    pub selected: bool,
    /// Why it is, or why not.
    pub reason: String,
}

impl From<&RootReport> for RootRecord {
    fn from(root: &RootReport) -> Self {
        let by_name = |number: fn(&Measure) -> Option<f64>| {
            root.measures.iter().map(|measure| (measure.name.to_string(), number(measure).into())).collect()
        };
        Self {
            frame: FrameRecord::from(&root.frame),
            measures: by_name(|measure| finite(measure.value)),
            measures_u: by_name(|measure| measure.u.and_then(finite)),
            misfit: root.misfit.and_then(finite),
            selected: root.selected,
            reason: root.reason.to_string(),
        }
    }
}

/// An uncertain quantity that was an unknown beside the frame: a length, or degrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AdjustmentRecord {
    /// Name of the fixture's parameter, or `tip_radius`.
    pub name: String,
    /// As stated.
    pub nominal: Option<f64>,
    /// Standard uncertainty of that; `null` where only the touches tell it.
    pub nominal_u: Option<f64>,
    /// As estimated.
    pub value: Option<f64>,
    /// Standard uncertainty of that.
    pub u: Option<f64>,
    /// How far it moved, in standard uncertainties of the nominal value; of the estimated one where the nominal value has
    /// none.
    pub moved: Option<f64>,
}

impl From<&Adjustment> for AdjustmentRecord {
    fn from(adjustment: &Adjustment) -> Self {
        Self {
            name: adjustment.name.to_string(),
            nominal: finite(adjustment.nominal),
            nominal_u: adjustment.nominal_u.and_then(finite),
            value: finite(adjustment.value),
            u: finite(adjustment.u),
            moved: finite(adjustment.moved()),
        }
    }
}

/// How an iteration ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct IterationRecord {
    /// Steps made.
    pub steps: usize,
    /// The criterion that ended it: `gradient`, `step` or `cost`.
    pub stopped_by: String,
    /// What each step did; left out where nobody asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub history: Option<Vec<StepRecord>>,
}

/// One step of an iteration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StepRecord {
    /// Squared misfit after it.
    pub chi_square: Option<f64>,
    /// Largest cosine between the residuals and a column of the Jacobian, before it.
    pub gradient: Option<f64>,
    /// Length of the step tried: translation in parts of the fixture's size, plus rotation in radians.
    pub step: Option<f64>,
    /// Marquardt's damping of it.
    pub damping: Option<f64>,
    /// Whether it led downhill and was taken.
    pub taken: bool,
}

impl From<Iteration> for IterationRecord {
    fn from(iteration: Iteration) -> Self {
        Self { steps: iteration.steps, stopped_by: iteration.stopped_by.to_owned(), history: None }
    }
}

/// The margin within which a frame stands: the standard deviation of one touch lies between two bounds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrustRecord {
    /// As stated.
    pub sigma: Option<f64>,
    /// Below this the touches contradict the fixture.
    pub from_sigma: Option<f64>,
    /// Above this the frame is not the only one, or its uncertainty is not true; `null` where nothing limits it.
    pub up_to_sigma: Option<f64>,
    /// What gives way above: `none`, `ambiguity`, `curvature`, `rise` or `search`.
    #[schemars(extend("enum" = LIMITS.map(limit_name)))]
    pub limited_by: String,
    /// The next best frame.
    pub second_minimum: Option<SecondMinimumRecord>,
    /// Relative curvature.
    pub nonlinearity: Option<f64>,
}

/// The next best frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SecondMinimumRecord {
    /// Its squared misfit over the variance.
    pub chi_square: Option<f64>,
    /// The frame.
    pub frame: FrameRecord,
}

impl From<&Trust> for TrustRecord {
    fn from(trust: &Trust) -> Self {
        Self {
            sigma: trust.sigma,
            from_sigma: finite(trust.from_sigma),
            up_to_sigma: finite(trust.up_to_sigma),
            limited_by: limit_name(trust.limited_by).to_owned(),
            second_minimum: trust.second_minimum.map(|second| SecondMinimumRecord {
                chi_square: second.chi_square.and_then(finite),
                frame: FrameRecord::from(&second.frame),
            }),
            nonlinearity: trust.nonlinearity.and_then(finite),
        }
    }
}

/// Every limit there is.
const LIMITS: [Limit; 5] = [Limit::None, Limit::Ambiguity, Limit::Curvature, Limit::Rise, Limit::Search];

fn limit_name(limit: Limit) -> &'static str {
    match limit {
        Limit::None => "none",
        Limit::Ambiguity => "ambiguity",
        Limit::Curvature => "curvature",
        Limit::Rise => "rise",
        Limit::Search => "search",
        _ => "other",
    }
}

/// What the touches see.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObservabilityRecord {
    /// How many motions the touches determine.
    pub rank: usize,
    /// Largest over smallest singular value; `null` when infinite.
    pub condition: Option<f64>,
    /// The motion that the touches see least, in words.
    pub weakest: String,
    /// The same in numbers.
    pub twist: TwistRecord,
}

impl From<&Observability> for ObservabilityRecord {
    fn from(observability: &Observability) -> Self {
        Self {
            rank: observability.rank,
            condition: finite(observability.condition),
            weakest: observability.weakest.to_string(),
            twist: TwistRecord::from(&observability.weakest),
        }
    }
}

/// A small motion of the fixture, along the **parent's** axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TwistRecord {
    /// Translation of the point `about`.
    pub translation: [f64; 3],
    /// Rotation vector about that point, radians.
    pub rotation: [f64; 3],
    /// The point, in the parent.
    pub about: [f64; 3],
}

impl From<&Motion> for TwistRecord {
    fn from(motion: &Motion) -> Self {
        let Twist { translation, rotation } = motion.twist;
        Self { translation: translation.into(), rotation: rotation.into(), about: motion.about.into() }
    }
}

/// Something the user should know.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct WarningRecord {
    /// By which programs know it.
    pub code: String,
    /// For people.
    pub message: String,
}

impl From<&Warning> for WarningRecord {
    fn from(warning: &Warning) -> Self {
        Self { code: warning.code.to_owned(), message: warning.message.clone() }
    }
}

mod read;
#[cfg(test)]
mod tests;
