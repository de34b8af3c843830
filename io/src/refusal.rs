//! The JSON of an error: `touchref.error/1`.

use schemars::JsonSchema;
use serde::Serialize;
use touchref_core::{DialectError, SolveError};

use crate::{
    InputError, TouchRecord, Units, schema,
    solution::{ObservabilityRecord, RootRecord, TrustRecord, TwistRecord},
};

/// The schema that [`ErrorRecord`] states.
pub const SCHEMA: &str = "touchref.error/1";

/// Every code there is: first those of sound input that gives no result to trust, then those of wrong input or a wrong call,
/// and last that of a fault, which bindings tell where a program of Rust would panic.
pub const CODES: [&str; 26] = [
    "ambiguous",
    "degenerate",
    "dialect-failed",
    "inconsistent",
    "not-converged",
    "not-met",
    "not-representable",
    "not-validated",
    "invalid-input",
    "missing-column",
    "missing-key",
    "too-few-touches",
    "unknown-column",
    "unknown-dialect",
    "unknown-fixture",
    "unknown-key",
    "unknown-log",
    "unknown-name",
    "unknown-point",
    "unknown-solver",
    "unknown-surface",
    "unreadable",
    "unsupported",
    "unwritable",
    "usage",
    "internal",
];

/// Why there is no frame. Only the details that an error has are written.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ErrorRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    pub schema: &'static str,
    /// The error.
    pub error: ErrorDetails,
}

/// What is known of an error.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct ErrorDetails {
    /// By which programs know it.
    #[schemars(extend("enum" = CODES))]
    pub code: String,
    /// For people: what is wrong, with the measured value and the bound.
    pub message: String,
    /// What to do about it.
    pub help: String,
    /// Place in an input.
    #[serde(flatten)]
    pub place: PlaceRecord,
    /// What a solver found on the way.
    #[serde(flatten)]
    pub findings: Findings,
}

/// Where in an input something is wrong.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct PlaceRecord {
    /// The file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Line, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<usize>,
    /// Column, from 1, in characters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// Byte offset in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<usize>,
    /// Bytes from there on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<usize>,
    /// Path of keys (`fixture.radius`), or the column of a table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<String>,
    /// The right name that was most likely meant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nearest: Option<String>,
}

/// What a solver found on the way to a refusal; lengths in `units`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct Findings {
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<&'static str>,
    /// The solver that refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<String>,
    /// What is missing, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing: Option<String>,
    /// The placement concerned, where there are many.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placement: Option<ConcernedPlacement>,
    /// The touches concerned.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub touches: Vec<ConcernedTouch>,
    /// The parameters that are not told, or not apart.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<String>,
    /// How many of the unknowns the touches determine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank: Option<usize>,
    /// How many unknowns there are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unknowns: Option<usize>,
    /// What shows that a motion is free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantity: Option<&'static str>,
    /// Its value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// How many iterations were made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterations: Option<usize>,
    /// Length of the last step, in standard deviations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// The bound that `value` or `step` missed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<f64>,
    /// The motion that is free, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free: Option<String>,
    /// The same in numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twist: Option<TwistRecord>,
    /// Every root, survivors first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roots: Option<Vec<RootRecord>>,
    /// The margin in which a frame would have stood.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trust: Option<TrustRecord>,
    /// What the touches see at the best candidate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observability: Option<ObservabilityRecord>,
}

/// A placement that a refusal is about.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ConcernedPlacement {
    /// Which one, from 0.
    pub index: usize,
    /// What the user calls it.
    pub name: Option<String>,
}

/// A touch that a refusal is about.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ConcernedTouch {
    /// Which touch, from 0.
    pub index: usize,
    /// What the user calls it.
    pub id: Option<String>,
    /// Name of the surface.
    pub surface: String,
    /// Line of the file, from 1.
    pub line: Option<usize>,
}

impl ConcernedTouch {
    /// Those with these indices.
    fn of(concerned: &[usize], touches: &[TouchRecord]) -> Vec<Self> {
        let known = concerned.iter().filter_map(|&index| touches.get(index).map(|touch| (index, touch)));
        let told = |(index, touch): (usize, &TouchRecord)| Self {
            index,
            id: touch.id.clone(),
            surface: touch.surface.clone(),
            line: touch.line,
        };
        known.map(told).collect()
    }
}

impl ErrorRecord {
    /// An error of which no more is known.
    #[must_use]
    pub fn new(code: &str, message: impl Into<String>, help: impl Into<String>) -> Self {
        let error = ErrorDetails {
            code: code.to_owned(),
            message: message.into(),
            help: help.into(),
            ..ErrorDetails::default()
        };
        Self { schema: SCHEMA, error }
    }

    /// The record of a solver's refusal of these touches.
    #[must_use]
    pub fn of_refusal(error: &SolveError, units: Units, touches: &[TouchRecord]) -> Self {
        let mut findings = Findings { units: Some(units.name()), ..Findings::default() };
        match error {
            SolveError::TooFewTouches { missing } => findings.missing = Some(missing.clone()),
            SolveError::InvalidTouches { touches: concerned, .. } => {
                findings.touches = ConcernedTouch::of(concerned, touches);
            }
            SolveError::Degenerate(details) => {
                findings.rank = Some(details.rank);
                findings.unknowns = Some(details.unknowns);
                findings.quantity = Some(details.quantity);
                findings.value = Some(details.value);
                findings.bound = Some(details.bound);
                findings.free = Some(details.free.to_string());
                findings.twist = Some(TwistRecord::from(&details.free));
            }
            SolveError::NotConverged { iterations, step, bound } => {
                findings.iterations = Some(*iterations);
                findings.step = Some(*step);
                findings.bound = Some(*bound);
            }
            SolveError::Unsupported { solver, .. } => findings.solver = Some((*solver).to_owned()),
            _ => {}
        }
        if let Some(refusal) = error.refusal() {
            findings.touches = ConcernedTouch::of(&refusal.touches, touches);
            findings.roots = Some(refusal.roots.iter().map(RootRecord::from).collect());
            findings.trust = Some(TrustRecord::from(&refusal.trust));
            findings.observability = refusal.observability.as_ref().map(ObservabilityRecord::from);
        }
        let mut record = Self::new(error.code(), error.to_string(), error.help());
        record.error.findings = findings;
        record
    }
}

impl From<&InputError> for ErrorRecord {
    fn from(error: &InputError) -> Self {
        let mut record = Self::new(error.code(), error.to_string(), error.help().unwrap_or_default());
        let place = error.place();
        record.error.place = PlaceRecord {
            file: error.file().map(str::to_owned),
            line: place.map(|place| place.line),
            column: place.and_then(|place| place.column),
            offset: place.map(|place| place.offset),
            length: place.map(|place| place.length),
            key: error.key().filter(|key| !key.is_empty()).map(str::to_owned),
            nearest: error.nearest().map(str::to_owned),
        };
        record
    }
}

impl From<&DialectError> for ErrorRecord {
    /// What a dialect cannot tell, with the angle and its bound in degrees.
    fn from(error: &DialectError) -> Self {
        let mut record = Self::new(error.code(), error.to_string(), error.help());
        record.error.place.key = Some("dialect".to_owned());
        if let DialectError::Lossy { lost, .. } = error {
            let findings = &mut record.error.findings;
            findings.units = Some(lost.units.name());
            findings.quantity = Some(lost.omission.map_or("angle in degrees", |_| "tilt in degrees"));
            findings.value = Some(lost.angle.to_degrees());
            findings.bound = Some(lost.angle_bound.to_degrees());
        }
        record
    }
}
