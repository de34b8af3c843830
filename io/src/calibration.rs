//! The JSON of a calibration: `touchref.calibration/1`.

use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use touchref_core::{Calibration, Parameters, Placement, Probe};

use crate::{
    FrameRecord, PlacementTouches, Units, schema,
    solution::{
        AdjustmentRecord, CovarianceRecord, FixtureRecord, IterationRecord, ProbeRecord, ResidualRecord,
        WarningRecord, finite,
    },
};

/// The schema that [`CalibrationRecord`] states.
pub const SCHEMA: &str = "touchref.calibration/1";

/// What many placements of one fixture tell of its sizes and of the probe; lengths in `units`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CalibrationRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    pub schema: String,
    /// The fixture as stated.
    pub fixture: FixtureRecord,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    pub units: String,
    /// The probe as stated.
    pub probe: ProbeRecord,
    /// The parameters that were unknown.
    pub parameters: Vec<AdjustmentRecord>,
    /// Their covariance, rows first, in their order; lengths and degrees.
    pub covariance: Vec<Vec<f64>>,
    /// Their correlations, rows first, in their order.
    pub correlations: Vec<Vec<f64>>,
    /// Standard deviation of one touch.
    pub sigma: Option<f64>,
    /// `given` or `residuals`.
    #[schemars(schema_with = "schema::sigma_source")]
    pub sigma_source: String,
    /// Root mean square of all residuals.
    pub rms: Option<f64>,
    /// Squared misfit of all touches and of the stated nominal values.
    pub chi_square: Option<f64>,
    /// Touches and stated nominal values less unknowns.
    pub degrees_of_freedom: usize,
    /// Chance of a larger `chi_square`.
    pub p_value: Option<f64>,
    /// How the iteration ended.
    pub iteration: IterationRecord,
    /// The placements, in input order.
    pub placements: Vec<PlacementRecord>,
    /// What the user should know of the input.
    pub warnings: Vec<WarningRecord>,
}

impl CalibrationRecord {
    /// The record of a calibration of the fixture of this kind and these parameters.
    #[must_use]
    pub fn new(
        (kind, parameters): (&str, &Parameters),
        (units, probe): (Units, &Probe),
        placements: &[PlacementTouches],
        calibration: &Calibration,
    ) -> Self {
        let placed = calibration.placements.iter().zip(placements).enumerate();
        Self {
            schema: SCHEMA.to_owned(),
            fixture: FixtureRecord::new(kind, parameters),
            units: units.name().to_owned(),
            probe: ProbeRecord::from(probe),
            parameters: calibration.parameters.iter().map(AdjustmentRecord::from).collect(),
            covariance: rows(&calibration.covariance),
            correlations: rows(&calibration.correlations()),
            sigma: finite(calibration.sigma),
            sigma_source: calibration.sigma_source.name().to_owned(),
            rms: finite(calibration.rms),
            chi_square: calibration.chi_square.and_then(finite),
            degrees_of_freedom: calibration.degrees_of_freedom,
            p_value: calibration.p_value.and_then(finite),
            iteration: IterationRecord::from(calibration.iteration),
            placements: placed
                .map(|(index, (placement, touches))| PlacementRecord::new(index, touches, placement))
                .collect(),
            warnings: placements
                .iter()
                .flat_map(|placement| &placement.touches.warnings)
                .map(WarningRecord::from)
                .collect(),
        }
    }
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// One placement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlacementRecord {
    /// Which one, from 0.
    pub index: usize,
    /// What the user calls it.
    pub name: Option<String>,
    /// Its frame in the parent.
    pub frame: FrameRecord,
    /// Covariance of that, the uncertainty of the parameters included.
    pub covariance: CovarianceRecord,
    /// Squared misfit of its touches.
    pub chi_square: Option<f64>,
    /// Its touches in input order, with their residuals.
    pub touches: Vec<ResidualRecord>,
}

impl PlacementRecord {
    fn new(index: usize, placement: &PlacementTouches, found: &Placement) -> Self {
        let touches = found.residuals.iter().zip(&placement.touches.records).enumerate();
        Self {
            index,
            name: placement.name.clone(),
            frame: FrameRecord::from(&found.frame),
            covariance: CovarianceRecord::from(&found.covariance),
            chi_square: found.chi_square.and_then(finite),
            touches: touches
                .map(|(index, (residual, touch))| ResidualRecord::new(index, touch, residual))
                .collect(),
        }
    }
}
