//! A tree of keys and values that remember where they stand, whether from TOML or from JSON.

use std::ops::Range;

use jsonc_parser::{
    ParseOptions,
    ast::{ObjectPropName, Value},
    common::Ranged,
};
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use crate::{InputError, source::Source};

/// A value, and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Node {
    pub(crate) span: Range<usize>,
    pub(crate) content: Content,
}

/// What a value is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Content {
    Number(f64),
    Text(String),
    Flag(bool),
    List(Vec<Node>),
    Table(Vec<Entry>),
    /// Something that no key takes.
    Other(&'static str),
}

/// A key with its value; tables keep the order of the text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    pub(crate) key: String,
    pub(crate) key_span: Range<usize>,
    pub(crate) value: Node,
}

impl Node {
    /// What it is, for messages.
    pub(crate) fn kind(&self) -> &'static str {
        match &self.content {
            Content::Number(_) => "a number",
            Content::Text(_) => "a string",
            Content::Flag(_) => "a truth value",
            Content::List(_) => "a list",
            Content::Table(_) => "a table",
            Content::Other(what) => what,
        }
    }
}

/// Reads a text that is JSON when its first character is `{` or the name says so, and TOML otherwise.
///
/// # Errors
/// A syntax error, or a key given twice.
pub(crate) fn parse(source: &Source) -> Result<Node, InputError> {
    let ends_with = |ending: &str| source.name().to_ascii_lowercase().ends_with(ending);
    let is_json = ends_with(".json") || (!ends_with(".toml") && source.text().trim_start().starts_with('{'));
    if is_json { parse_json(source) } else { parse_toml(source) }
}

fn syntax_error(source: &Source, language: &str, message: &str, span: Range<usize>) -> InputError {
    InputError::new("invalid-input", format!("not valid {language}: {message}"))
        .at(source.place(span))
        .with_help(format!(
            "see `touchref describe FIXTURE` for an example of a measurement file ({language})"
        ))
}

fn parse_toml(source: &Source) -> Result<Node, InputError> {
    match DeTable::parse(source.text()) {
        Ok(table) => Ok(Node { span: 0..0, content: toml_table(table.into_inner()) }),
        Err(error) => {
            // The parser points to the key it met again; an end of text is a place too.
            let end = source.text().len();
            Err(syntax_error(source, "TOML", error.message(), error.span().unwrap_or(end..end)))
        }
    }
}

fn toml_table(table: DeTable<'_>) -> Content {
    let mut entries: Vec<Entry> = table
        .into_iter()
        .map(|(key, value)| Entry {
            key_span: key.span(),
            key: key.into_inner().into_owned(),
            value: toml_value(value),
        })
        .collect();
    entries.sort_by_key(|entry| entry.key_span.start);
    Content::Table(entries)
}

fn toml_value(value: Spanned<DeValue<'_>>) -> Node {
    let span = value.span();
    let content = match value.into_inner() {
        DeValue::String(text) => Content::Text(text.into_owned()),
        // A number too large for the type becomes infinite, and is refused as such where a number is wanted.
        DeValue::Integer(integer) => Content::Number(
            i64::from_str_radix(integer.as_str(), integer.radix()).map_or(f64::INFINITY, |v| v as f64),
        ),
        DeValue::Float(float) => Content::Number(float.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Content::Flag(flag),
        DeValue::Datetime(_) => Content::Other("a date"),
        DeValue::Array(list) => Content::List(list.into_iter().map(toml_value).collect()),
        DeValue::Table(table) => toml_table(table),
    };
    Node { span, content }
}

/// JSON as RFC 8259 has it: none of the parser's extensions.
const STRICT: ParseOptions = ParseOptions {
    allow_comments: false,
    allow_loose_object_property_names: false,
    allow_trailing_commas: false,
    allow_missing_commas: false,
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

fn parse_json(source: &Source) -> Result<Node, InputError> {
    let end = source.text().len();
    match jsonc_parser::parse_to_ast(source.text(), &jsonc_parser::CollectOptions::default(), &STRICT) {
        Ok(result) => match result.value {
            Some(value) => json_value(source, value),
            None => Err(syntax_error(source, "JSON", "the text is empty", end..end)),
        },
        Err(error) => {
            let range = error.range();
            Err(syntax_error(source, "JSON", &error.kind().to_string(), range.start..range.end))
        }
    }
}

fn json_value(source: &Source, value: Value<'_>) -> Result<Node, InputError> {
    let range = value.range();
    let content = match value {
        Value::StringLit(text) => Content::Text(text.value.into_owned()),
        Value::NumberLit(number) => Content::Number(number.value.parse().unwrap_or(f64::NAN)),
        Value::BooleanLit(flag) => Content::Flag(flag.value),
        Value::NullKeyword(_) => Content::Other("null"),
        Value::Array(list) => {
            let nodes = list.elements.into_iter().map(|value| json_value(source, value));
            Content::List(nodes.collect::<Result<_, _>>()?)
        }
        Value::Object(object) => {
            let mut entries: Vec<Entry> = Vec::new();
            for property in object.properties {
                let key_range = property.name.range();
                let key = match property.name {
                    ObjectPropName::String(text) => text.value.into_owned(),
                    ObjectPropName::Word(word) => word.value.to_owned(),
                };
                let key_span = key_range.start..key_range.end;
                if entries.iter().any(|entry| entry.key == key) {
                    return Err(syntax_error(source, "JSON", "duplicate key", key_span).with_key(key));
                }
                entries.push(Entry { key, key_span, value: json_value(source, property.value)? });
            }
            Content::Table(entries)
        }
    };
    Ok(Node { span: range.start..range.end, content })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(node: &Node) -> Vec<&str> {
        match &node.content {
            Content::Table(entries) => entries.iter().map(|entry| entry.key.as_str()).collect(),
            _ => Vec::new(),
        }
    }

    #[test]
    fn both_languages_keep_the_order_of_the_text() {
        let toml = parse(&Source::new("m.toml", "z = 1\na = 0x10\n[m]\nb = 1_0.5")).unwrap();
        let json = parse(&Source::new("-", " {\"z\": 1, \"a\": 16, \"m\": {\"b\": 10.5}}")).unwrap();
        assert_eq!(keys(&toml), ["z", "a", "m"]);
        assert_eq!(keys(&json), ["z", "a", "m"]);
    }

    #[test]
    fn syntax_errors_have_a_place() {
        let table = [
            ("m.toml", "a = 1\na = 2", 2),
            ("m.toml", "a = 1\nb = [1,", 2),
            ("m.json", "{\"a\": 1,\n \"a\": 2}", 2),
            ("m.json", "{\"a\": 1,}", 1),
            ("m.json", "", 1),
            ("m.json", "{\n\"a\": NaN}", 2),
        ];
        for (name, text, line) in table {
            let error = parse(&Source::new(name, text)).unwrap_err();
            assert_eq!(error.place().unwrap().line, line, "{text}");
        }
        for open in ["[", "{\"a\":", "a=["] {
            parse(&Source::new("-", &open.repeat(100_000))).unwrap_err();
        }
    }
}
