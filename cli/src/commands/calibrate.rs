//! `calibrate`: from many placements of one fixture to its sizes and the tip's radius.

use std::{io, path::PathBuf};

use anstream::adapter::strip_str;
use touchref::{
    Problem, Registry, Unknown,
    io::{CalibrationRecord, InputError, PlacementTouches, write::json},
    solvers::{
        Extra,
        bundle::{BundleError, calibrate},
    },
};

use crate::{
    args::Format,
    failure::{Failure, Uncalibrated},
    output::{Output, working, write_file},
    setup::{MeasurementArgs, Setup},
    text::{self, Look},
};

/// The tip's radius, among the parameters of the fixture.
const TIP_RADIUS: &str = "tip_radius";

/// Calibrate sizes of a fixture and the tip radius from many placements
///
/// The measurement has the touches of each placement under [[placement]], or a table with a column `placement`. What is
/// stated with a standard uncertainty u is an unknown held by that; what --free names is told by the touches alone.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref calibrate examples/calibration.toml")]
pub(crate) struct Args {
    #[command(flatten)]
    measurement: MeasurementArgs,
    /// Parameter of the fixture, or `tip_radius`, of which nothing is known but a value to start from; may be repeated
    #[arg(long = "free", value_name = "NAME")]
    free: Vec<String>,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let setup = self.measurement.load(registry)?;
        let unknowns = unknowns(&setup, &self.free)?;
        let placements = setup.measurement.placements(&*setup.fixture)?;
        let probe = setup.measurement.probe;
        let problems = placements
            .iter()
            .map(|placement| Problem::new(&*setup.fixture, &placement.touches.touches, probe))
            .collect::<Result<Vec<_>, _>>()
            .map_err(InputError::from)?;
        let plugin = setup.measurement.plugin(registry)?;
        let working = working("fitting all placements");
        let calibration = calibrate(plugin, &problems, &unknowns);
        drop(working);
        let calibration = calibration.map_err(|error| refused(error, &setup, placements.clone()))?;
        let fixture = (setup.fixture.kind(), setup.fixture.parameters());
        let record =
            CalibrationRecord::new(fixture, (setup.measurement.units, &probe), &placements, &calibration);
        let look = if self.output.is_some() { Look::PLAIN } else { Look::of(&io::stdout()) };
        let (result, notes) = match self.format {
            Format::Json => (json(&record), Vec::new()),
            Format::Text => {
                let warnings = record.warnings.iter();
                let notes = warnings.map(|warning| format!("warning: {}", warning.message)).collect();
                (text::calibration(&record, look), notes)
            }
        };
        let output = match &self.output {
            Some(path) => {
                // A file keeps no colours.
                write_file(path, |output| write!(output, "{}", strip_str(&result)))?;
                Output::nothing()
            }
            None => Output::bytes(result),
        };
        Ok(output.with_notes(notes))
    }
}

/// What is unknown besides the frames: whatever has a stated uncertainty, and what is `free`.
fn unknowns(setup: &Setup, free: &[String]) -> Result<Vec<Extra>, InputError> {
    let dimensions = setup.fixture.dimensions();
    let probe = &setup.measurement.probe;
    let names = dimensions.iter().map(|dimension| dimension.name.as_ref()).chain([TIP_RADIUS]);
    if let Some(name) = free.iter().find(|name| !names.clone().any(|known| known == name.as_str())) {
        let error = InputError::unknown("unknown-name", "parameter", name, names);
        return Err(error.with_key("free"));
    }
    let stated = dimensions.iter().map(|dimension| dimension.u).chain([probe.tip_radius_u]);
    let unknown = |(index, (name, u)): (usize, (&str, f64))| {
        let what = if index < dimensions.len() { Unknown::Dimension(index) } else { Unknown::TipRadius };
        let is_free = free.iter().any(|free| free == name);
        (is_free || u > 0.0).then_some(Extra { what, prior: if is_free { None } else { Some(u) } })
    };
    Ok(names.zip(stated).enumerate().filter_map(unknown).collect())
}

fn refused(error: BundleError, setup: &Setup, placements: Vec<PlacementTouches>) -> Failure {
    Failure::Uncalibrated(Box::new(Uncalibrated { error, units: setup.measurement.units, placements }))
}
