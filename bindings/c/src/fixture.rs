//! Fixtures, and measurements of them.

use std::{ffi::CString, path::Path, sync::LazyLock};

use nalgebra::{Point3, Vector3};
use touchref::{
    Noise, Plugin, TouchError, direction,
    io::{InputError, Measurement, TouchRecord, TouchSource, measurement::units_named, parameter},
};

use crate::{
    c_string,
    interface::{Probe, Touch},
};

/// A kind of fixture with its parameters.
#[derive(Debug)]
pub struct Fixture {
    /// Without probe and touches.
    measurement: Measurement,
    pub(crate) surfaces: Vec<CString>,
}

impl Fixture {
    /// Builds it, so that what is wrong with the parameters is told here.
    ///
    /// # Errors
    /// `unknown-fixture`, `unknown-name` for the unit, and what is wrong with the parameters.
    pub(crate) fn new(kind: &str, parameters: &str, units: &str) -> Result<Self, InputError> {
        let measurement = Measurement::new(kind, units_named(units)?)
            .with_parameters(&parameter::read("parameters", parameters)?);
        let fixture = measurement.fixture(&touchref::registry()?)?;
        let surfaces = fixture.surfaces().iter().map(|surface| c_string(&surface.name)).collect();
        Ok(Self { measurement, surfaces })
    }

    /// A measurement of it.
    ///
    /// # Errors
    /// `invalid-input` for a string that is missing or not UTF-8, and for a direction that is none.
    pub(crate) fn measurement(
        &self,
        touches: &[Touch<'_>],
        probe: &Probe,
    ) -> Result<Measurement, InputError> {
        let Probe { tip_radius, tip_radius_u, sigma } = *probe;
        let mut measurement = self.measurement.clone();
        measurement.probe =
            touchref::Probe { tip_radius, tip_radius_u, sigma: Some(sigma).filter(|s| *s != 0.0) };
        let records = touches.iter().enumerate().map(|(index, touch)| record(index, touch));
        measurement.touches = TouchSource::Listed(records.collect::<Result<_, _>>()?);
        Ok(measurement)
    }
}

/// A touch as a measurement states it.
fn record(index: usize, touch: &Touch<'_>) -> Result<TouchRecord, InputError> {
    let surface = touch.surface.required(&format!("touch[{index}].surface"))?;
    let approach = Vector3::from(touch.approach);
    if let Some(value) = approach.iter().copied().find(|v| !v.is_finite()) {
        // A direction that is no number would count as not known.
        let (what, expected) = ("a component of the approach", "a finite number");
        return Err(TouchError::BadNumber { index, what, value, expected }.into());
    }
    Ok(TouchRecord {
        noise: if touch.sigma == 0.0 { Noise::OfProbe } else { Noise::Sigma(touch.sigma) },
        approach: direction(approach),
        id: touch.id.optional(&format!("touch[{index}].id"))?.map(str::to_owned),
        ..TouchRecord::new(surface, Point3::from(touch.at))
    })
}

/// A measurement as a text states it.
///
/// # Errors
/// What is wrong with it.
pub(crate) fn measurement_of(text: &str, folder: &str) -> Result<Measurement, InputError> {
    Measurement::from_text("measurement", text, Path::new(folder))
}

/// The names of all plugins.
#[derive(Debug, Default)]
pub(crate) struct Names {
    pub(crate) fixtures: Vec<CString>,
    pub(crate) solvers: Vec<CString>,
    pub(crate) dialects: Vec<CString>,
}

/// The names of all plugins; none where two have one name, which every other call then tells.
pub(crate) fn names() -> &'static Names {
    static NAMES: LazyLock<Names> = LazyLock::new(|| {
        let Ok(registry) = touchref::registry() else { return Names::default() };
        Names {
            fixtures: of(registry.fixtures()),
            solvers: of(registry.solvers()),
            dialects: of(registry.dialects()),
        }
    });
    &NAMES
}

fn of<P: Plugin>(plugins: &[&P]) -> Vec<CString> {
    plugins.iter().map(|plugin| c_string(plugin.name())).collect()
}
