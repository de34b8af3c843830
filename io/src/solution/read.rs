//! Results read back: frame, covariance, fixture and touches as they were.

use nalgebra::{Matrix3, Matrix6, Point3, Vector3};
use serde::Deserialize;
use touchref_core::{
    Covariance, Fixture, Frame, Noise, Parameters, Probe, Registry, SigmaSource, Touch, TouchError, Value,
};

use super::{CovarianceRecord, FixtureRecord, ProbeRecord, ResidualRecord, SCHEMA, SolutionRecord};
use crate::{Input, InputError, refusal, source::Source};

/// What a result file is, for messages.
const EXPECTED: &str = "a result file is what `touchref locate --format json` prints";

/// What to do with a refusal.
const REFUSED: &str = "a refused measurement has no frame: see in the file why, and locate again";

/// What every kind of JSON says first.
#[derive(Deserialize)]
struct Kind {
    schema: String,
}

impl SolutionRecord {
    /// Reads a result file.
    ///
    /// # Errors
    /// `unreadable`, or `invalid-input` for a text that is no result.
    pub fn read(input: &Input) -> Result<Self, InputError> {
        Self::from_text(&input.name(), Source::read(input)?.text())
    }

    /// Reads the text of a result file that messages call `name`.
    ///
    /// # Errors
    /// `invalid-input`.
    pub fn from_text(name: &str, text: &str) -> Result<Self, InputError> {
        let wrong = |problem: String| {
            let message = format!("{name} is no result of `locate`: {problem}");
            InputError::new("invalid-input", message).with_file(name).with_help(EXPECTED)
        };
        let kind: Kind = serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        if kind.schema == refusal::SCHEMA {
            return Err(wrong(format!("its schema is {}, it is a refusal", kind.schema)).with_help(REFUSED));
        }
        if kind.schema != SCHEMA {
            return Err(wrong(format!("its schema is {}, not {SCHEMA}", kind.schema)));
        }
        let record: Self = serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        record.located_frame().ok_or_else(|| wrong("its frame has no rotation".to_owned()))?;
        Ok(record)
    }

    /// The fixture's frame in the parent; `None` for a quaternion of zeros.
    #[must_use]
    pub fn located_frame(&self) -> Option<Frame> {
        Frame::from_quaternion_xyzw(Point3::from(self.frame.origin), self.frame.quaternion_xyzw)
    }

    /// The touches on which the frame rests; `None` for a result that does not tell where they were.
    ///
    /// # Errors
    /// [`TouchError::UnknownSurface`] for a fixture that has other surfaces.
    pub fn used_touches(&self, fixture: &dyn Fixture) -> Result<Option<Vec<Touch>>, TouchError> {
        let used = self.touches.iter().filter(|touch| !touch.excluded);
        used.map(|touch| touch.as_measured(fixture)).collect()
    }
}

impl ResidualRecord {
    fn as_measured(&self, fixture: &dyn Fixture) -> Result<Option<Touch>, TouchError> {
        let Some(at) = self.at else { return Ok(None) };
        let noise = match (self.sigma, self.covariance) {
            (Some(sigma), _) => Noise::Sigma(sigma),
            (None, Some(rows)) => Noise::Covariance(Matrix3::from(rows).transpose()),
            (None, None) => Noise::OfProbe,
        };
        let touch = Touch { noise, ..fixture.touch(&self.surface, at)? };
        Ok(Some(match self.approach {
            Some(direction) => touch.with_approach(Vector3::from(direction)),
            None => touch,
        }))
    }
}

impl FixtureRecord {
    /// Builds the fixture.
    ///
    /// # Errors
    /// `unknown-fixture`, or `invalid-input` for parameters that it does not have.
    pub fn build(&self, registry: &Registry) -> Result<Box<dyn Fixture>, InputError> {
        let plugin = registry.fixture(&self.kind)?;
        let wrong = |problem: String| {
            InputError::new("invalid-input", format!("fixture `{}`: {problem}", self.kind))
                .with_help(EXPECTED)
        };
        let parameters = parameters(&self.parameters).map_err(wrong)?;
        plugin.build(&parameters).map_err(|error| wrong(error.to_string()))
    }
}

/// The inverse of what is written; what is written by nothing is told.
fn parameters(table: &serde_json::Map<String, serde_json::Value>) -> Result<Parameters, String> {
    table.iter().try_fold(Parameters::new(), |parameters, (name, json)| {
        let value = value(json).ok_or_else(|| format!("parameter `{name}` is {json}"))?;
        Ok(parameters.with(name, value))
    })
}

fn value(json: &serde_json::Value) -> Option<Value> {
    use serde_json::Value as Json;
    Some(match json {
        Json::Number(number) => Value::Number { value: number.as_f64()?, u: 0.0 },
        Json::Object(table) => {
            Value::Number { value: table.get("value")?.as_f64()?, u: table.get("u")?.as_f64()? }
        }
        Json::String(word) => Value::Word(word.clone()),
        Json::Bool(flag) => Value::Flag(*flag),
        Json::Array(list) => match list.first() {
            Some(Json::Object(_)) => {
                let tables = list.iter().map(|table| parameters(table.as_object()?).ok());
                Value::Tables(tables.collect::<Option<_>>()?)
            }
            Some(Json::String(_)) => {
                let words = list.iter().map(|word| word.as_str().map(str::to_owned));
                Value::Words(words.collect::<Option<_>>()?)
            }
            _ => Value::Numbers(list.iter().map(Json::as_f64).collect::<Option<_>>()?),
        },
        Json::Null => return None,
    })
}

impl From<ProbeRecord> for Probe {
    fn from(record: ProbeRecord) -> Self {
        let ProbeRecord { tip_radius, tip_radius_u, sigma } = record;
        Self { tip_radius, tip_radius_u, sigma }
    }
}

impl From<&CovarianceRecord> for Covariance {
    fn from(record: &CovarianceRecord) -> Self {
        let sigma_source = if record.sigma_source == SigmaSource::Residuals.name() {
            SigmaSource::Residuals
        } else {
            SigmaSource::Given
        };
        Self {
            matrix: Matrix6::from_fn(|row, column| record.matrix[row][column]),
            sigma: record.sigma.unwrap_or(f64::NAN),
            sigma_source,
        }
    }
}
