//! Parameters of plugins from files and from arguments.

use std::ops::Range;

use touchref_core::{
    ParameterKind, ParameterSpec, Parameters, Value,
    parameters::{nearest, parse},
};

use crate::{
    InputError,
    source::Source,
    tree::{self, Content},
    walk::{Field, Table},
};

/// Where a parameter stands in a file: its name (`surface[2].radius` in a table), its key and its value.
pub(crate) type Written = (String, Range<usize>, Range<usize>);

/// The parameters in a text that messages call `name`, TOML or a JSON object: what would stand in a measurement file; the
/// plugin's description checks them later.
///
/// # Errors
/// `invalid-input`: a syntax error, or a value that no parameter takes.
pub fn read(name: &str, text: &str) -> Result<Parameters, InputError> {
    let source = Source::new(name, text);
    let tree = tree::parse(&source)?;
    from_table(&Table::root(&source, &tree)?, None, "", &mut Vec::new())
}

/// The parameters in a table, of whatever kinds they are, except the one of the name `without`; the plugin's
/// description checks them later. Tells in `places` where each stands, its name after `within`.
pub(crate) fn from_table(
    table: &Table<'_>,
    without: Option<&'static str>,
    within: &str,
    places: &mut Vec<Written>,
) -> Result<Parameters, InputError> {
    let mut parameters = Parameters::new();
    for (entry, field) in table.fields(without) {
        let name = format!("{within}{}", entry.key);
        places.push((name.clone(), entry.key_span.clone(), field.node.span.clone()));
        parameters.set(&entry.key, from_field(&field, &name, places)?);
    }
    Ok(parameters)
}

fn from_field(field: &Field<'_>, name: &str, places: &mut Vec<Written>) -> Result<Value, InputError> {
    match &field.node.content {
        Content::Number(_) | Content::Table(_) => {
            let (value, u) = field.uncertain()?;
            Ok(Value::Number { value, u })
        }
        Content::Text(text) => Ok(Value::from(text.as_str())),
        Content::Flag(flag) => Ok(Value::from(*flag)),
        Content::List(nodes) => {
            let elements = field.list("a list")?;
            match nodes.first().map(|first| &first.content) {
                Some(Content::Table(_)) => {
                    let tables = elements.iter().enumerate().map(|(index, element)| {
                        let within = format!("{name}[{index}]");
                        places.push((within.clone(), element.node.span.clone(), element.node.span.clone()));
                        from_table(&element.table()?, None, &format!("{within}."), places)
                    });
                    Ok(Value::Tables(tables.collect::<Result<_, _>>()?))
                }
                Some(Content::Text(_)) => {
                    let words = elements.iter().map(|word| word.text().map(str::to_owned));
                    Ok(Value::Words(words.collect::<Result<_, _>>()?))
                }
                _ => {
                    let numbers = elements.iter().map(|number| number.number("a number"));
                    Ok(Value::Numbers(numbers.collect::<Result<_, _>>()?))
                }
            }
        }
        Content::Other(what) => {
            Err(field.wrong(what, "a number, a string, a truth value or a list of numbers"))
        }
    }
}

/// The value of a plugin's parameter from an argument `name=text`; `plugin` is told in the message, as "fixture `cube`".
///
/// # Errors
/// `unknown-key` when the plugin has no such parameter, `invalid-input` when the text is no value of its kind.
pub fn from_argument(
    plugin: &str,
    specs: &[ParameterSpec],
    name: &str,
    text: &str,
) -> Result<Value, InputError> {
    let spec = specs.iter().find(|spec| spec.name == name).ok_or_else(|| unknown(plugin, specs, name))?;
    from_text(spec, text)
}

/// No parameter of that name.
pub(crate) fn unknown(plugin: &str, specs: &[ParameterSpec], name: &str) -> InputError {
    let known = || specs.iter().map(|spec| spec.name);
    let list = known().collect::<Vec<_>>().join(", ");
    let message = if list.is_empty() {
        format!("{plugin} has no parameters")
    } else {
        format!("{plugin} has no parameter `{name}`; it has {list}")
    };
    InputError::new("unknown-key", message).with_nearest(nearest(name, known())).with_key(name)
}

/// The value of a parameter from the text after `NAME=`: a number may carry a standard uncertainty, `15±0.002` or
/// `15+-0.002`.
fn from_text(spec: &ParameterSpec, text: &str) -> Result<Value, InputError> {
    let value = match spec.kind {
        ParameterKind::Length | ParameterKind::Angle { .. } => {
            uncertain(text).map(|(value, u)| Value::Number { value, u })
        }
        kind => parse(kind, text),
    };
    value.ok_or_else(|| {
        InputError::new(
            "invalid-input",
            format!("parameter `{}` is `{text}`; expected {}", spec.name, spec.kind),
        )
        .with_key(spec.name)
        .with_help(format!("{}: {}", spec.name, spec.meaning))
    })
}

/// A number with its standard uncertainty from text: `15`, `15±0.002`, `15+-0.002`.
pub(crate) fn uncertain(text: &str) -> Option<(f64, f64)> {
    let (value, u) = ["±", "+-", "+/-"].iter().find_map(|sign| text.split_once(sign)).unwrap_or((text, "0"));
    Some((value.trim().parse().ok()?, u.trim().parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_read_from_either_language() {
        let toml = read("p", "radius = { value = 15.0, u = 0.002 }\nbore = true").unwrap();
        let json = read("p", r#" {"radius": {"value": 15.0, "u": 0.002}, "bore": true}"#).unwrap();
        assert_eq!(toml, json);
        assert_eq!(toml.get("radius"), Some(&Value::Number { value: 15.0, u: 0.002 }));
        for wrong in ["{", "radius", "{\"radius\": null}", "radius = 1\nradius = 2"] {
            assert_eq!(read("p", wrong).unwrap_err().code(), "invalid-input", "{wrong}");
        }
        assert_eq!(read("p", "").unwrap(), Parameters::new());
    }

    #[test]
    fn arguments_may_carry_an_uncertainty() {
        let spec = |kind| ParameterSpec { name: "p", kind, default: None, meaning: "" };
        let length = spec(ParameterKind::Length);
        for text in ["15±0.002", "15 +- 0.002", "15+/-0.002"] {
            assert_eq!(from_text(&length, text).unwrap(), Value::Number { value: 15.0, u: 0.002 });
        }
        assert_eq!(from_text(&length, "15").unwrap(), Value::from(15.0));
        let lengths = from_text(&spec(ParameterKind::Lengths3), "[1, 2,3]").unwrap();
        assert_eq!(lengths, Value::from([1.0, 2.0, 3.0]));
        for wrong in ["", "x", "1±", "1±2±3"] {
            assert_eq!(from_text(&length, wrong).unwrap_err().key(), Some("p"), "{wrong}");
        }
    }
}
