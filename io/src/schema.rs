//! JSON Schema (draft 2020-12) of what is read and printed.
//!
//! The schema of a record comes from its type, so that it cannot tell another thing than what is printed: keys, types and
//! what is `null`; documentation becomes descriptions. That of a measurement file is [`measurement`](fn@measurement).

use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema, SchemaGenerator, generate::SchemaSettings, json_schema};
use serde_json::{Value, json};
use touchref_core::SigmaSource;

use crate::Units;

pub use crate::measurement::schema::measurement;

/// The schema of a record as it is printed; `form` is what its key `schema` says, as `touchref.solution/1`.
///
/// It allows keys that it does not have: later versions may add some.
#[must_use]
pub fn of<T: JsonSchema>(form: &str) -> Value {
    titled(form, generator().into_root_schema_for::<T>())
}

/// The same of a form that is one of several records, each told by [`SchemaGenerator::subschema_for`].
#[must_use]
pub fn any_of(form: &str, records: &[fn(&mut SchemaGenerator) -> Schema]) -> Value {
    let mut generator = generator();
    let records: Vec<Schema> = records.iter().map(|record| record(&mut generator)).collect();
    titled(form, json_schema!({ "anyOf": records, "$defs": generator.take_definitions(true) }))
}

fn generator() -> SchemaGenerator {
    // What Rust calls a number is no format that JSON knows.
    let plain = RecursiveTransform(|schema: &mut Schema| {
        schema.remove("format");
    });
    SchemaSettings::draft2020_12().for_serialize().with_transform(plain).into_generator()
}

/// The schema of a form, with its names first.
pub(crate) fn titled(form: &str, mut schema: Schema) -> Value {
    let names = json!({
        "$schema": schemars::consts::meta_schemas::DRAFT2020_12,
        "$id": format!("urn:{}", form.replace(['.', '/'], ":")),
        "title": form
    });
    let mut whole = names.as_object().cloned().unwrap_or_default();
    let others = std::mem::take(schema.ensure_object());
    whole.extend(others.into_iter().filter(|(key, _)| names.get(key).is_none()));
    Value::Object(whole)
}

/// Of the name of a unit of length.
#[must_use]
pub fn units(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": Units::ALL.map(Units::name) })
}

/// Of the name of a unit of length, or `null`.
#[must_use]
pub fn units_or_null(_: &mut SchemaGenerator) -> Schema {
    let names = Units::ALL.map(|units| Value::from(units.name()));
    json_schema!({ "enum": names.into_iter().chain([Value::Null]).collect::<Vec<_>>() })
}

/// Of where a standard deviation comes from.
#[must_use]
pub fn sigma_source(_: &mut SchemaGenerator) -> Schema {
    let sources = [SigmaSource::Given, SigmaSource::Residuals];
    json_schema!({ "enum": sources.map(SigmaSource::name) })
}

/// Of the parameters of a plugin, by name: which there are is told by `touchref describe`.
#[must_use]
pub fn parameters(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "object",
        "additionalProperties": {
            "anyOf": [
                { "type": ["number", "string", "boolean"] },
                { "type": "array", "items": { "type": ["number", "string", "object"] } },
                or_uncertain(&json!({ "type": "number" }))["anyOf"][1]
            ]
        }
    })
}

/// Of a number, or of the same with its standard uncertainty.
pub(crate) fn or_uncertain(number: &Value) -> Value {
    json!({
        "anyOf": [
            number,
            {
                "description": "with its standard uncertainty `u`",
                "type": "object",
                "required": ["value", "u"],
                "properties": { "value": number, "u": { "type": "number", "minimum": 0 } },
                "additionalProperties": false
            }
        ]
    })
}
