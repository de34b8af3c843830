//! What was measured.

use std::path::Path;

use nalgebra::{Point3, Vector3};
use pyo3::{prelude::*, types::PyDict};
use touchref::{
    Noise, Probe, direction,
    io::{
        Input, InputError, Measurement as Measured, TouchRecord, TouchSource,
        measurement::units_named,
        solution::{FixtureRecord, ProbeRecord},
    },
    locate::{self, Setup, locating_solver},
};

use crate::{errors::Failure, registry, solution::Solution, values, waiting::interruptible};

/// A measurement, its fixture checked.
#[pyclass(frozen, module = "touchref._touchref")]
pub(crate) struct Measurement {
    pub(crate) measured: Measured,
    /// Kind and parameters of the fixture, defaults filled in.
    fixture: FixtureRecord,
    /// The names of its surfaces.
    surfaces: Vec<String>,
}

/// A touch as Python passes it: surface, tip centre, sigma, approach direction, id.
type Given = (String, [f64; 3], Option<f64>, Option<[f64; 3]>, Option<String>);

impl Measurement {
    fn new(measured: Measured) -> Result<Self, Failure> {
        let fixture = measured.fixture(registry()?)?;
        let surfaces = fixture.surfaces().iter().map(|surface| surface.name.clone()).collect();
        let fixture = FixtureRecord::new(fixture.kind(), fixture.parameters());
        Ok(Self { measured, fixture, surfaces })
    }
}

#[pymethods]
impl Measurement {
    /// Reads a measurement file.
    #[staticmethod]
    fn read(path: &str) -> Result<Self, Failure> {
        Self::new(Measured::read(&Input::File(path.into()))?)
    }

    /// Reads the text of one, which messages call `name`; tables that it names are in `folder`.
    #[staticmethod]
    fn from_text(text: &str, name: &str, folder: &str) -> Result<Self, Failure> {
        Self::new(Measured::from_text(name, text, Path::new(folder))?)
    }

    /// One of values; without touches what `Stream` takes.
    #[staticmethod]
    fn of(
        kind: &str,
        parameters: &Bound<'_, PyDict>,
        units: &str,
        tip_radius: (f64, f64),
        sigma: Option<f64>,
        touches: Option<Vec<Given>>,
    ) -> Result<Self, Failure> {
        let parameters = values::parameters(parameters)?;
        let mut measured = Measured::new(kind, units_named(units)?).with_parameters(&parameters);
        let (tip_radius, tip_radius_u) = tip_radius;
        measured.probe = Probe { tip_radius, tip_radius_u, sigma };
        if let Some(touches) = touches {
            let records = touches.into_iter().enumerate().map(|(index, touch)| record(index, touch));
            measured.touches = TouchSource::Listed(records.collect::<Result<_, _>>()?);
        }
        Self::new(measured)
    }

    /// Kind and parameters of the fixture as JSON, the names of its surfaces.
    fn fixture(&self) -> (String, Vec<String>) {
        (serde_json::to_string(&self.fixture).unwrap_or_default(), self.surfaces.clone())
    }

    /// The probe as JSON.
    fn probe(&self) -> String {
        serde_json::to_string(&ProbeRecord::from(&self.measured.probe)).unwrap_or_default()
    }

    /// Unit of every length.
    fn units(&self) -> &'static str {
        self.measured.units.name()
    }

    /// Locates the fixture, as `touchref locate` does.
    fn locate(
        &self,
        py: Python<'_>,
        solver: Option<&str>,
        parameters: &Bound<'_, PyDict>,
        near: Option<Vec<f64>>,
    ) -> Result<Solution, Failure> {
        let parameters = values::parameters(parameters)?;
        let solver = locating_solver(registry()?, solver, &parameters)?;
        let near = near.map(|numbers| values::frame(&numbers)).transpose()?;
        let measured = self.measured.clone();
        let registry = registry()?;
        let located: Result<_, locate::Failure> = interruptible(py, move || {
            let setup = Setup::new(measured, registry)?;
            let solution = setup.solve(&*solver, near)?;
            Ok(Solution { record: setup.record(&solution)?, frame: solution.frame })
        })?;
        Ok(located?)
    }
}

fn record(index: usize, touch: Given) -> Result<TouchRecord, InputError> {
    let (surface, at, sigma, approach, id) = touch;
    let approach = approach.map(|[i, j, k]| {
        direction(Vector3::new(i, j, k)).ok_or_else(|| {
            let message =
                format!("touch {index}: the approach is [{i}, {j}, {k}]; expected a direction, not all zero");
            InputError::new("invalid-input", message).with_key(format!("touch[{index}].approach"))
        })
    });
    Ok(TouchRecord {
        noise: sigma.map_or(Noise::OfProbe, Noise::Sigma),
        approach: approach.transpose()?,
        id,
        ..TouchRecord::new(&surface, Point3::from(at))
    })
}
