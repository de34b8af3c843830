//! Walks a tree of keys and values; every refusal points to the very key or value.

use nalgebra::{Matrix3, Unit, Vector3};
use touchref_core::{direction, parameters::nearest};

use crate::{
    InputError,
    source::{Place, Source},
    tree::{Content, Entry, Node},
};

/// A table at a path of keys.
#[derive(Clone)]
pub(crate) struct Table<'a> {
    source: &'a Source,
    path: String,
    node: &'a Node,
    entries: &'a [Entry],
}

/// A key of a table with its value.
#[derive(Clone)]
pub(crate) struct Field<'a> {
    source: &'a Source,
    /// Path of keys: `fixture.radius`, `touch[2].at`; touches count from 0 as in the result.
    pub(crate) path: String,
    pub(crate) node: &'a Node,
}

impl<'a> Table<'a> {
    /// The whole document.
    pub(crate) fn root(source: &'a Source, node: &'a Node) -> Result<Self, InputError> {
        Field { source, path: String::new(), node }.table()
    }

    /// Refuses every key that is not among `known`.
    pub(crate) fn only(&self, known: &[&str]) -> Result<(), InputError> {
        match self.entries.iter().find(|entry| !known.contains(&entry.key.as_str())) {
            None => Ok(()),
            Some(entry) => Err(InputError::new(
                "unknown-key",
                format!("key `{}` is not known; known here: {}", entry.key, known.join(", ")),
            )
            .with_nearest(nearest(&entry.key, known.iter().copied()))
            .with_key(self.path_of(&entry.key))
            .labelled("not a known key")
            .at(self.source.place(entry.key_span.clone()))),
        }
    }

    /// The value of a key, if it is given.
    pub(crate) fn get(&self, key: &str) -> Option<Field<'a>> {
        let entry = self.entries.iter().find(|entry| entry.key == key)?;
        Some(Field { source: self.source, path: self.path_of(key), node: &entry.value })
    }

    /// The value of a key that must be given.
    pub(crate) fn require(&self, key: &str, expected: &str) -> Result<Field<'a>, InputError> {
        self.get(key).ok_or_else(|| self.missing(key, expected))
    }

    /// The error of a key that is not given.
    pub(crate) fn missing(&self, key: &str, expected: &str) -> InputError {
        InputError::new("missing-key", format!("`{}` is missing", self.path_of(key)))
            .with_help(format!("expected {expected}"))
            .with_key(self.path_of(key))
            .labelled(format!("`{key}` is missing here"))
            .at(self.source.place(self.node.span.clone()))
    }

    /// Every key with its value, in the order of the text, except `without`.
    pub(crate) fn fields(
        &self,
        without: Option<&'static str>,
    ) -> impl Iterator<Item = (&'a Entry, Field<'a>)> + '_ {
        self.entries.iter().filter(move |entry| without != Some(entry.key.as_str())).map(|entry| {
            (entry, Field { source: self.source, path: self.path_of(&entry.key), node: &entry.value })
        })
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }
}

impl<'a> Field<'a> {
    /// Where the value stands.
    pub(crate) fn place(&self) -> Place {
        self.source.place(self.node.span.clone())
    }

    /// An error at this value.
    pub(crate) fn wrong(&self, found: &str, expected: &str) -> InputError {
        let of = if self.path.is_empty() { "the document".to_owned() } else { format!("`{}`", self.path) };
        InputError::new("invalid-input", format!("{of} is {found}; expected {expected}"))
            .with_key(self.path.clone())
            .labelled(format!("expected {expected}"))
            .at(self.source.place(self.node.span.clone()))
    }

    fn wrong_kind(&self, expected: &str) -> InputError {
        self.wrong(self.node.kind(), expected)
    }

    pub(crate) fn table(&self) -> Result<Table<'a>, InputError> {
        match &self.node.content {
            Content::Table(entries) => {
                Ok(Table { source: self.source, path: self.path.clone(), node: self.node, entries })
            }
            _ => Err(self.wrong_kind("a table")),
        }
    }

    pub(crate) fn text(&self) -> Result<&'a str, InputError> {
        match &self.node.content {
            Content::Text(text) => Ok(text),
            _ => Err(self.wrong_kind("a string")),
        }
    }

    /// The elements of a list.
    pub(crate) fn list(&self, expected: &str) -> Result<Vec<Field<'a>>, InputError> {
        let Content::List(nodes) = &self.node.content else { return Err(self.wrong_kind(expected)) };
        let field =
            |(index, node)| Field { source: self.source, path: format!("{}[{index}]", self.path), node };
        Ok(nodes.iter().enumerate().map(field).collect())
    }

    /// A finite number.
    pub(crate) fn number(&self, expected: &str) -> Result<f64, InputError> {
        match self.node.content {
            Content::Number(value) if value.is_finite() => Ok(value),
            Content::Number(value) => Err(self.wrong(&value.to_string(), "a finite number")),
            _ => Err(self.wrong_kind(expected)),
        }
    }

    /// A finite number within bounds that `expected` tells.
    pub(crate) fn number_where(
        &self,
        right: impl Fn(f64) -> bool,
        expected: &str,
    ) -> Result<f64, InputError> {
        let value = self.number(expected)?;
        if right(value) { Ok(value) } else { Err(self.wrong(&value.to_string(), expected)) }
    }

    /// A number, or `{ value, u }` with a standard uncertainty; both finite, the uncertainty 0 or more.
    pub(crate) fn uncertain(&self) -> Result<(f64, f64), InputError> {
        if matches!(self.node.content, Content::Table(_)) {
            let table = self.table()?;
            table.only(&["value", "u"])?;
            let value = table.require("value", "a number")?.number("a number")?;
            let u = table.require("u", "a standard uncertainty")?;
            Ok((value, u.number_where(|u| u >= 0.0, "a standard uncertainty, 0 or more")?))
        } else {
            Ok((self.number("a number, or { value, u }")?, 0.0))
        }
    }

    /// Three finite numbers.
    pub(crate) fn vector(&self) -> Result<Vector3<f64>, InputError> {
        const EXPECTED: &str = "three numbers [x, y, z]";
        let numbers = self.list(EXPECTED)?;
        let [x, y, z] = numbers.as_slice() else {
            return Err(self.wrong(&format!("a list of {}", numbers.len()), EXPECTED));
        };
        Ok(Vector3::new(x.number("a number")?, y.number("a number")?, z.number("a number")?))
    }

    /// A direction of any length above zero.
    pub(crate) fn direction(&self) -> Result<Unit<Vector3<f64>>, InputError> {
        let vector = self.vector()?;
        direction(vector).ok_or_else(|| self.wrong("no direction", "a direction [i, j, k], not all zero"))
    }

    /// A covariance matrix: three rows of three, symmetric, with eigenvalues above zero.
    pub(crate) fn covariance(&self) -> Result<Matrix3<f64>, InputError> {
        const EXPECTED: &str = "a symmetric matrix [[..], [..], [..]] with eigenvalues > 0";
        let rows = self.list(EXPECTED)?;
        let [first, second, third] = rows.as_slice() else {
            return Err(self.wrong(&format!("a list of {}", rows.len()), EXPECTED));
        };
        let rows = [first.vector()?, second.vector()?, third.vector()?];
        let matrix = Matrix3::from_rows(&rows.map(|row| row.transpose()));
        let symmetric = (matrix - matrix.transpose()).abs().max() <= 1e-12 * matrix.abs().max();
        if symmetric && matrix.symmetric_eigenvalues().min() > 0.0 {
            Ok(matrix)
        } else {
            Err(self.wrong("no covariance", EXPECTED))
        }
    }
}
