//! Errors as Python raises them.

use pyo3::prelude::*;
use touchref::{DialectError, RegistryError, io::InputError, locate};

/// Why there is no result.
#[derive(Debug)]
pub(crate) enum Failure {
    /// What touchref says of the input, or of the frame.
    Told(Box<locate::Failure>),
    /// What Python itself raises: an interrupt, say.
    Python(PyErr),
}

impl From<locate::Failure> for Failure {
    fn from(failure: locate::Failure) -> Self {
        Self::Told(Box::new(failure))
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        locate::Failure::from(error).into()
    }
}

impl From<RegistryError> for Failure {
    fn from(error: RegistryError) -> Self {
        InputError::from(error).into()
    }
}

impl From<DialectError> for Failure {
    fn from(error: DialectError) -> Self {
        locate::Failure::from(error).into()
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

/// `touchref.InputError` or `touchref.Refused`, made of the document that the command line prints.
impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        let told = match failure {
            Failure::Told(told) => told,
            Failure::Python(error) => return error,
        };
        // Keys are strings and numbers are plain, so that writing to memory cannot fail.
        let document = serde_json::to_string(&told.record()).unwrap_or_default();
        let refused = told.status() == 1;
        Python::attach(|py| {
            let error = py.import("touchref._errors")?.getattr("of_document")?.call1((document, refused))?;
            Ok(Self::from_value(error))
        })
        .unwrap_or_else(|error| error)
    }
}
