//! What fixtures, solvers and dialects say of themselves.

use pyo3::{prelude::*, types::PyDict};
use serde_json::{Value, json};
use touchref::{
    ParameterKind, ParameterSpec, Plugin,
    locate::{build_solver, solver_plugin},
};

use crate::{errors::Failure, registry, values};

/// Every plugin as JSON; the classes of the Python package are made of it.
#[pyfunction]
pub(crate) fn plugins() -> Result<String, Failure> {
    let registry = registry()?;
    let fixtures = registry.fixtures().iter().map(|plugin| {
        let about = format!("Touches: {}.\n\nFrame: {}.", plugin.touches, plugin.frame);
        let surfaces =
            plugin.surfaces.iter().map(|(name, meaning)| json!({ "name": name, "meaning": meaning }));
        description(*plugin, &about, plugin.reference, surfaces.collect())
    });
    let solvers = registry.solvers().iter();
    let solvers = solvers.map(|plugin| description(*plugin, plugin.about, plugin.reference, Vec::new()));
    let dialects = registry.dialects().iter();
    let dialects = dialects.map(|plugin| description(*plugin, "", plugin.reference, Vec::new()));
    let all = json!({
        "fixtures": fixtures.collect::<Vec<_>>(),
        "solvers": solvers.collect::<Vec<_>>(),
        "dialects": dialects.collect::<Vec<_>>(),
    });
    Ok(all.to_string())
}

fn description(plugin: &impl Plugin, about: &str, reference: &str, surfaces: Vec<Value>) -> Value {
    let specs = plugin.parameters();
    json!({
        "name": plugin.name(),
        "summary": plugin.summary(),
        "about": about,
        "reference": reference,
        "surfaces": surfaces,
        "parameters": specs.iter().map(|spec| parameter(spec, specs)).collect::<Vec<_>>(),
    })
}

fn parameter(spec: &ParameterSpec, all: &[ParameterSpec]) -> Value {
    let (kind, words) = match spec.kind {
        ParameterKind::Length | ParameterKind::Angle { .. } => ("uncertain", None),
        ParameterKind::Coordinate => ("number", None),
        ParameterKind::Lengths3 | ParameterKind::Point | ParameterKind::Direction => ("numbers", None),
        ParameterKind::Choice(words) => ("choice", Some(words)),
        ParameterKind::Flag => ("flag", None),
        ParameterKind::Name => ("text", None),
        ParameterKind::Words(words) => ("words", Some(words)),
        ParameterKind::Tables(_) => ("tables", None),
        _ => ("any", None),
    };
    let replaced = all.iter().any(|other| other.replaces() == Some(spec.name));
    json!({
        "name": spec.name,
        "kind": kind,
        "words": words,
        "required": spec.default.is_none() && !replaced,
        "default": spec.default,
        "takes": spec.kind.to_string(),
        "meaning": spec.meaning,
    })
}

/// Checks a solver's name and parameters.
#[pyfunction]
pub(crate) fn check_solver(name: &str, parameters: &Bound<'_, PyDict>) -> Result<(), Failure> {
    build_solver(solver_plugin(registry()?, Some(name))?, &[], &values::parameters(parameters)?)?;
    Ok(())
}
