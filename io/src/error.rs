//! What is wrong with an input, and where.

use std::fmt;

use miette::{Diagnostic, LabeledSpan, SourceCode};
use thiserror::Error;
use touchref_core::{RegistryError, parameters::nearest};

use crate::source::Place;

/// An input that cannot be used: a file, a table or an argument.
///
/// The codes are `invalid-input`, `unreadable`, `missing-key`, `missing-column`, and `unknown-...` followed by
/// `fixture`, `solver`, `surface`, `dialect`, `log`, `point`, `key`, `column` or `name`. As a [`Diagnostic`] it points into the text.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{}", .0.message)]
pub struct InputError(Box<Details>);

#[derive(Debug, Clone, PartialEq)]
struct Details {
    code: &'static str,
    message: String,
    help: Option<String>,
    file: Option<String>,
    place: Option<Place>,
    label: Option<String>,
    key: Option<String>,
    nearest: Option<String>,
}

impl InputError {
    /// An error of this code; where and what about it are added.
    #[must_use]
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        // Input is quoted in messages; its control characters are not for the terminal.
        let message = message.into().replace(char::is_control, "?");
        Self(Box::new(Details {
            code,
            message,
            help: None,
            file: None,
            place: None,
            label: None,
            key: None,
            nearest: None,
        }))
    }

    /// A name that none of `known` is: code `unknown-{what}`, with the nearest known name.
    #[must_use]
    pub fn unknown<'a>(
        code: &'static str,
        what: &str,
        name: &str,
        known: impl Iterator<Item = &'a str> + Clone,
    ) -> Self {
        let all: Vec<&str> = known.clone().collect();
        let all = if all.is_empty() { "none".to_owned() } else { all.join(", ") };
        Self::new(code, format!("{what} `{name}` is not known; known: {all}"))
            .with_nearest(nearest(name, known))
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(help.into());
        self
    }

    /// Adds the right name that was most likely meant, and asks for it where no other help is given.
    #[must_use]
    pub fn with_nearest(mut self, nearest: Option<&str>) -> Self {
        if let Some(name) = nearest {
            self.0.help.get_or_insert_with(|| format!("did you mean `{name}`?"));
            self.0.nearest = Some(name.to_owned());
        }
        self
    }

    /// Adds the path of keys (`fixture.radius`, `touch[2].at`) or the column.
    #[must_use]
    pub fn with_key(mut self, key: impl Into<String>) -> Self {
        self.0.key = Some(key.into());
        self
    }

    /// Adds the file where no place in it is meant.
    #[must_use]
    pub fn with_file(mut self, file: &str) -> Self {
        self.0.file = Some(file.to_owned());
        self
    }

    /// Adds the place.
    #[must_use]
    pub fn at(mut self, place: Place) -> Self {
        self.0.file = Some(place.file.clone());
        self.0.place = Some(place);
        self
    }

    /// Adds what to write beside the place.
    #[must_use]
    pub fn labelled(mut self, label: impl Into<String>) -> Self {
        self.0.label = Some(label.into());
        self
    }

    /// The code by which programs know the error.
    #[must_use]
    pub fn code(&self) -> &'static str {
        self.0.code
    }

    /// What to do about it.
    #[must_use]
    pub fn help(&self) -> Option<&str> {
        self.0.help.as_deref()
    }

    /// The file it is in.
    #[must_use]
    pub fn file(&self) -> Option<&str> {
        self.0.file.as_deref()
    }

    /// The place in the file.
    #[must_use]
    pub fn place(&self) -> Option<&Place> {
        self.0.place.as_ref()
    }

    /// The path of keys, or the column.
    #[must_use]
    pub fn key(&self) -> Option<&str> {
        self.0.key.as_deref()
    }

    /// The right name that was most likely meant.
    #[must_use]
    pub fn nearest(&self) -> Option<&str> {
        self.0.nearest.as_deref()
    }
}

impl From<RegistryError> for InputError {
    fn from(error: RegistryError) -> Self {
        match &error {
            RegistryError::Unknown { kind, name, known, .. } => {
                let code = match *kind {
                    "solver" => "unknown-solver",
                    "dialect" => "unknown-dialect",
                    _ => "unknown-fixture",
                };
                Self::unknown(code, kind, name, known.iter().copied())
            }
            _ => Self::new("invalid-input", error.to_string())
                .with_help("link one plugin of that name only, or rename one"),
        }
    }
}

impl Diagnostic for InputError {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.0.code))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.0.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.place.as_ref().map(|place| &place.excerpt as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.0.place.as_ref()?;
        let label = self.0.label.clone().unwrap_or_else(|| "here".to_owned());
        let span = LabeledSpan::new_primary_with_span(Some(label), place.excerpt.span());
        Some(Box::new(std::iter::once(span)))
    }
}
