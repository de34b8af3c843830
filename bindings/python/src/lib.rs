//! The native part of the Python package `touchref`.
//!
//! It is small: what Python passes becomes a [`Measurement`](touchref::io::Measurement), and goes the way of the command
//! line from there on; results and errors come back as the JSON documents that the command line prints, of which the
//! Python part makes objects. Long work runs on threads of its own while Python's are free, and ends a wait for it when
//! the user interrupts.

mod batch;
mod capsule;
mod errors;
mod measurement;
mod plugins;
mod solution;
mod values;
mod waiting;

use std::sync::OnceLock;

use touchref::{Registry, RegistryError};

/// Every plugin that is linked in.
fn registry() -> Result<&'static Registry, RegistryError> {
    static REGISTRY: OnceLock<Result<Registry, RegistryError>> = OnceLock::new();
    REGISTRY.get_or_init(touchref::registry).as_ref().map_err(Clone::clone)
}

/// What the Python part builds on; not for users.
#[pyo3::pymodule]
mod _touchref {
    #[pymodule_export]
    use crate::{
        batch::{Frames, Stream},
        measurement::Measurement,
        plugins::{check_solver, plugins},
        solution::Solution,
    };
}
