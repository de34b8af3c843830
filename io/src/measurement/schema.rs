//! JSON Schema of a measurement file: what `file` reads, and what the plugins of fixtures take.

use schemars::json_schema;
use serde_json::{Map, Value, json};
use touchref_core::{
    FixturePlugin, ParameterKind, ParameterSpec, Registry, TableSpec,
    parameters::{TYPE, parse},
};

use super::UNLABELLED;
use crate::{
    Units, log,
    schema::{or_uncertain, titled},
    solution,
};

/// The schema of a measurement file, TOML or JSON, with the fixtures that `registry` has.
///
/// It refuses what reading the file and building its fixture refuse: keys that are not known, missing or in each other's
/// way, values of a wrong type, and ranges, as far as one value tells them.
#[must_use]
pub fn measurement(registry: &Registry) -> Value {
    let fixtures = registry.fixtures().iter().map(|plugin| fixture(plugin)).collect::<Vec<_>>();
    let whole = json_schema!({
        "description": "What was touched, with what, and where. Lengths are in `units`, angles in degrees; what is touched \
                        is located in the parent: the frame that the touches are given in.",
        "type": "object",
        "required": ["units", "fixture"],
        "properties": {
            "units": {
                "description": "Unit of every length in this file, in a touch table that it names, and in the result",
                "enum": Units::ALL.map(Units::name)
            },
            "fixture": {
                "description": "What is touched: the kind of the fixture, and its parameters",
                "oneOf": fixtures
            },
            "probe": { "$ref": "#/$defs/probe" },
            "touches": { "$ref": "#/$defs/touches" },
            "touch": { "$ref": "#/$defs/touch" },
            "log": { "$ref": "#/$defs/log" },
            "placement": {
                "description": "Many placements of the fixture, for `touchref calibrate`; instead of `touch`, `touches` or `log`",
                "type": "array",
                "minItems": 1,
                "items": {
                    "type": "object",
                    "properties": {
                        "name": { "description": "What it is called; a name of its own", "type": "string" },
                        "touches": { "$ref": "#/$defs/touches" },
                        "touch": { "$ref": "#/$defs/touch", "minItems": 1 },
                        "log": { "$ref": "#/$defs/log" }
                    },
                    "additionalProperties": false,
                    "oneOf": [{ "required": ["touches"] }, { "required": ["touch"] }, { "required": ["log"] }]
                }
            }
        },
        "additionalProperties": false,
        "dependentSchemas": not_together(&["touches", "touch", "log", "placement"]),
        "$defs": {
            "probe": probe(),
            "touches": {
                "description": "Touch table (CSV with the columns surface, x, y, z), relative to this file",
                "type": "string"
            },
            "touch": touch(),
            "log": log_section(),
            "vector": vector(&json!({ "type": "number" })),
            "direction": direction()
        }
    });
    titled("touchref.measurement/1", whole)
}

/// Keys of which only one may be given.
fn not_together(keys: &[&str]) -> Value {
    let others = |key: &str| {
        let others = keys.iter().filter(|other| **other != key);
        others.map(|other| ((*other).to_owned(), Value::Bool(false))).collect::<Map<_, _>>()
    };
    keys.iter().map(|key| ((*key).to_owned(), json!({ "properties": others(key) }))).collect()
}

fn vector(number: &Value) -> Value {
    json!({ "type": "array", "items": number, "minItems": 3, "maxItems": 3 })
}

fn direction() -> Value {
    let mut direction = vector(&json!({ "type": "number" }));
    direction["contains"] = json!({ "not": { "const": 0 } });
    direction
}

fn probe() -> Value {
    let mut tip_radius = or_uncertain(&json!({ "type": "number", "minimum": 0 }));
    tip_radius["description"] =
        "Radius of the tip; 0, the default, where touches are points of the surface".into();
    json!({
        "description": "What touches were made with",
        "type": "object",
        "properties": {
            "tip_radius": tip_radius,
            "sigma": {
                "description": "Standard deviation of one touch along the surface's normal; without it the answer is conditional",
                "type": "number",
                "exclusiveMinimum": 0
            }
        },
        "additionalProperties": false
    })
}

fn touch() -> Value {
    let surface = format!("Name of the surface of the fixture, or \"{UNLABELLED}\" where it is not known");
    json!({
        "description": "The touches",
        "type": "array",
        "items": {
            "type": "object",
            "required": ["surface", "at"],
            "properties": {
                "surface": { "description": surface, "type": "string" },
                "at": { "$ref": "#/$defs/vector", "description": "Centre of the tip [x, y, z], in the parent" },
                "id": { "description": "What you call the touch", "type": "string" },
                "sigma": {
                    "description": "Standard deviation of this touch along the surface's normal, instead of the probe's",
                    "type": "number",
                    "exclusiveMinimum": 0
                },
                "covariance": {
                    "description": "Covariance of the position along the parent's axes, a symmetric matrix, instead of `sigma`",
                    "type": "array",
                    "items": { "$ref": "#/$defs/vector" },
                    "minItems": 3,
                    "maxItems": 3
                },
                "approach": {
                    "$ref": "#/$defs/direction",
                    "description": "Direction [i, j, k] in which the probe moved, in the parent, of any length"
                }
            },
            "additionalProperties": false,
            "dependentSchemas": not_together(&["sigma", "covariance"])
        }
    })
}

fn log_section() -> Value {
    let tables = log::ALL.iter().filter(|importer| importer.takes_columns()).map(|importer| importer.name);
    let name_or_number = |description: &str| {
        json!({
            "description": description,
            "anyOf": [
                { "type": "string", "pattern": "\\S" },
                { "type": "integer", "minimum": 0, "maximum": u32::MAX }
            ]
        })
    };
    let mut mapping = selection("Points of the log that are touches of one surface");
    mapping["properties"]["surface"] = json!({
        "description": format!("Name of the surface of the fixture, or \"{UNLABELLED}\" where it is not known"),
        "type": "string"
    });
    mapping["required"] = json!(["surface"]);
    json!({
        "description": "The log of a machine, and which of its points is a touch of what: each point is mapped or ignored",
        "type": "object",
        "required": ["file", "format", "touch"],
        "properties": {
            "file": { "description": "The log, relative to this file", "type": "string" },
            "format": {
                "description": "Its format: see `touchref list logs`",
                "enum": log::ALL.iter().map(|importer| importer.name).collect::<Vec<_>>()
            },
            "columns": {
                "description": "Which columns of a table hold what: by names in the header, or by numbers from 1 where there is none",
                "anyOf": [
                    columns(&json!({ "type": "string" })),
                    columns(&json!({ "type": "integer", "minimum": 1, "maximum": u32::MAX }))
                ]
            },
            "units": {
                "description": "Unit of the log, where it does not tell it",
                "enum": Units::ALL.map(Units::name)
            },
            "base": name_or_number("What the positions are relative to; checked where the log tells it"),
            "tool": name_or_number("The tool that was active; checked where the log tells it"),
            "compensated": {
                "description": "Whether the log has contact points (true) or tip centres (false)",
                "type": "boolean"
            },
            "touch": { "description": "The touches", "type": "array", "minItems": 1, "items": mapping },
            "ignore": selection("Points of the log that are no touches")
        },
        "additionalProperties": false,
        "if": { "properties": { "format": { "enum": tables.collect::<Vec<_>>() } }, "required": ["format"] },
        "then": { "required": ["columns"] },
        "else": { "properties": { "columns": false } }
    })
}

/// Points by name or by row; at least one.
fn selection(description: &str) -> Value {
    json!({
        "description": description,
        "type": "object",
        "properties": {
            "points": { "description": "By name", "type": "array", "items": { "type": "string" } },
            "rows": {
                "description": "By row, counted from 1: \"1-4, 7\"",
                "type": "string",
                "pattern": r"^\s*[0-9]+\s*(-\s*[0-9]+\s*)?(,\s*[0-9]+\s*(-\s*[0-9]+\s*)?)*$"
            }
        },
        "additionalProperties": false,
        "anyOf": [{ "required": ["points"], "properties": { "points": { "minItems": 1 } } }, { "required": ["rows"] }]
    })
}

/// Columns that are all told in one way.
fn columns(column: &Value) -> Value {
    let told = |description: &str, mut value: Value| {
        value["description"] = description.into();
        value
    };
    json!({
        "type": "object",
        "required": ["at"],
        "properties": {
            "at": told("Of x, y and z", vector(column)),
            "name": told("Of the name of the point", column.clone()),
            "approach": told("Of the direction in which the probe moved", vector(column)),
            "normal": told("Of the normal of the surface, against which the probe moved", vector(column))
        },
        "additionalProperties": false,
        "dependentSchemas": not_together(&["approach", "normal"])
    })
}

fn fixture(plugin: &FixturePlugin) -> Value {
    let FixturePlugin { name, summary, touches, frame, surfaces, .. } = *plugin;
    let surfaces = surfaces.iter().map(|(name, meaning)| format!(" `{name}`: {meaning}."));
    let description =
        format!("{name}: {summary}. Touches: {touches}. Frame: {frame}.{}", surfaces.collect::<String>());
    table("kind", name, &description, plugin.parameters)
}

/// A table that the word of `key` makes one with these parameters.
fn table(key: &str, word: &str, description: &str, parameters: &[ParameterSpec]) -> Value {
    let mut properties = Map::new();
    properties.insert(key.to_owned(), json!({ "const": word }));
    properties.extend(parameters.iter().map(|spec| (spec.name.to_owned(), parameter(spec))));
    let replacement =
        |spec: &ParameterSpec| parameters.iter().find(|other| other.replaces() == Some(spec.name));
    let (mut required, mut either) = (vec![Value::from(key)], Vec::new());
    for spec in parameters {
        match (replacement(spec), spec.default) {
            (Some(other), None) => {
                either.push(json!({ "oneOf": [{ "required": [spec.name] }, { "required": [other.name] }] }));
            }
            (Some(other), Some(_)) => {
                either.push(json!({ "dependentSchemas": not_together(&[spec.name, other.name]) }));
            }
            (None, None) => required.push(spec.name.into()),
            (None, Some(_)) => {}
        }
    }
    let mut table = json!({
        "title": word,
        "description": description,
        "type": "object",
        "required": required,
        "properties": properties,
        "additionalProperties": false
    });
    if !either.is_empty() {
        table["allOf"] = either.into();
    }
    table
}

fn parameter(spec: &ParameterSpec) -> Value {
    let mut parameter = value(spec.kind);
    let stands_for_itself = spec.replaces().is_none() && !spec.is_derived();
    let default = spec.default.and_then(|text| parse(spec.kind, text)).filter(|_| stands_for_itself);
    let otherwise = match spec.default {
        Some(told) if spec.is_derived() => format!("; left out: {told}"),
        Some(told) if default.is_none() => format!("; {told}"),
        _ => String::new(),
    };
    if let Some(default) = default {
        parameter["default"] = solution::parameter(&default);
    }
    parameter["description"] = format!("{}; {}{otherwise}", spec.meaning, spec.kind).into();
    parameter
}

/// What a parameter of this kind takes.
fn value(kind: ParameterKind) -> Value {
    match kind {
        ParameterKind::Length => or_uncertain(&json!({ "type": "number", "exclusiveMinimum": 0 })),
        ParameterKind::Angle { above, below } => {
            or_uncertain(&json!({ "type": "number", "exclusiveMinimum": above, "exclusiveMaximum": below }))
        }
        ParameterKind::Lengths3 => vector(&json!({ "type": "number", "exclusiveMinimum": 0 })),
        ParameterKind::Choice(words) => json!({ "enum": words }),
        ParameterKind::Flag => json!({ "type": "boolean" }),
        ParameterKind::Name => json!({ "type": "string", "pattern": "\\S" }),
        ParameterKind::Words(words) => {
            json!({ "type": "array", "items": { "enum": words }, "uniqueItems": true })
        }
        ParameterKind::Coordinate => {
            let mut coordinate = or_uncertain(&json!({ "type": "number" }));
            // No uncertainty of where a surface ends.
            coordinate["anyOf"][1]["properties"]["u"] = json!({ "const": 0 });
            coordinate
        }
        ParameterKind::Point => json!({ "$ref": "#/$defs/vector" }),
        ParameterKind::Direction => json!({ "$ref": "#/$defs/direction" }),
        ParameterKind::Tables(tables) => {
            let of_type = |spec: &TableSpec| table(TYPE, spec.name, spec.name, spec.parameters);
            let types: Vec<Value> = tables.iter().map(of_type).collect();
            json!({ "type": "array", "minItems": 1, "items": { "oneOf": types } })
        }
        // A kind that is newer than this: nothing is known of it.
        _ => json!({}),
    }
}
