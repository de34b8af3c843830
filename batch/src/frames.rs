//! Frames as Arrow record batches: one row a placement.

use std::{collections::HashMap, sync::Arc};

use arrow_array::{
    ArrayRef, RecordBatch,
    builder::{Float64Builder, Int64Builder, StringBuilder},
};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use nalgebra::Matrix6;
use touchref_core::{Certain, Frame, Solution, Units, statistics::chi_square_p_value};

use crate::{
    NameType, Refusal,
    columns::UNITS_KEY,
    placement::{Name, Placement},
};

/// The status of a placement that has a frame.
pub const OK: &str = "ok";

/// Origin and unit quaternion (scalar last, `w >= 0`) of the fixture's frame in the parent.
const POSE: [&str; 7] = ["x", "y", "z", "qx", "qy", "qz", "qw"];
/// Rows and columns of a frame's covariance, along the parent's axes, about the fixture's origin; radians.
const COVARIANCE: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// What a table tells of a frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    frame: Frame,
    chi_square: Option<f64>,
    degrees_of_freedom: usize,
    p_value: Option<f64>,
    condition: f64,
    covariance: Option<Matrix6<f64>>,
    warnings: Option<String>,
}

impl From<Solution> for Row {
    fn from(solution: Solution) -> Self {
        let codes: Vec<&str> = solution.warnings.iter().map(|warning| warning.code).collect();
        Self {
            frame: solution.frame,
            chi_square: solution.chi_square,
            degrees_of_freedom: solution.degrees_of_freedom,
            p_value: solution.p_value,
            condition: solution.observability.condition,
            covariance: solution.covariance.map(|covariance| covariance.matrix),
            warnings: joined(&codes),
        }
    }
}

impl From<&Certain> for Row {
    fn from(certain: &Certain) -> Self {
        Self {
            frame: certain.frame,
            chi_square: Some(certain.chi_square),
            degrees_of_freedom: certain.degrees_of_freedom,
            p_value: chi_square_p_value(certain.chi_square, certain.degrees_of_freedom),
            condition: certain.condition,
            covariance: Some(certain.covariance),
            warnings: joined(certain.warnings),
        }
    }
}

fn joined(codes: &[&str]) -> Option<String> {
    (!codes.is_empty()).then(|| codes.join(" "))
}

/// The upper triangle of the covariance, row by row.
fn upper_triangle() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|row| (row..6).map(move |column| (row, column)))
}

/// The columns of the frames; their lengths in `units`.
pub(crate) fn schema(names: NameType, units: Units) -> SchemaRef {
    let number = |name: &str| Field::new(name, DataType::Float64, true);
    let text = |name: &str| Field::new(name, DataType::Utf8, true);
    let mut fields =
        vec![Field::new("placement", names.data_type(), false), Field::new("status", DataType::Utf8, false)];
    fields.extend(POSE.map(number));
    fields.push(number("chi_square"));
    fields.push(Field::new("degrees_of_freedom", DataType::Int64, true));
    fields.extend(["p_value", "condition"].map(number));
    fields.extend(
        upper_triangle()
            .map(|(row, column)| number(&format!("cov_{}_{}", COVARIANCE[row], COVARIANCE[column]))),
    );
    fields.extend(["warnings", "message"].map(text));
    let metadata = HashMap::from([(UNITS_KEY.to_owned(), units.name().to_owned())]);
    Arc::new(Schema::new(fields).with_metadata(metadata))
}

/// The frames of some placements, or why they have none, in the order of the placements.
pub(crate) fn record_batch(
    schema: &SchemaRef,
    placements: &[Placement],
    outcomes: &[Result<Row, Refusal>],
) -> Result<RecordBatch, ArrowError> {
    let rows = || outcomes.iter().map(|outcome| outcome.as_ref().ok());
    let number = |value: &dyn Fn(&Row) -> Option<f64>| -> ArrayRef {
        let mut column = Float64Builder::with_capacity(outcomes.len());
        for row in rows() {
            // What does not exist is null, never invented.
            column.append_option(row.and_then(value).filter(|value| value.is_finite()));
        }
        Arc::new(column.finish())
    };
    let mut columns =
        vec![names(placements, schema), texts(outcomes, |outcome| Some(status(outcome).to_owned()))];
    for axis in 0..3 {
        columns.push(number(&|row| Some(row.frame.origin[axis])));
    }
    for part in 0..4 {
        columns.push(number(&|row| Some(row.frame.quaternion_xyzw()[part])));
    }
    columns.push(number(&|row| row.chi_square));
    let mut degrees = Int64Builder::with_capacity(outcomes.len());
    for row in rows() {
        degrees.append_option(row.and_then(|row| i64::try_from(row.degrees_of_freedom).ok()));
    }
    columns.push(Arc::new(degrees.finish()));
    columns.push(number(&|row| row.p_value));
    columns.push(number(&|row| Some(row.condition)));
    for (row, column) in upper_triangle() {
        columns.push(number(&|found| Some(found.covariance?[(row, column)])));
    }
    columns.push(texts(outcomes, |outcome| outcome.as_ref().ok()?.warnings.clone()));
    columns.push(texts(outcomes, |outcome| outcome.as_ref().err().map(|refusal| refusal.message.clone())));
    RecordBatch::try_new(Arc::clone(schema), columns)
}

/// `ok`, or the code of the refusal.
pub(crate) fn status(outcome: &Result<Row, Refusal>) -> &'static str {
    outcome.as_ref().map_or_else(|refusal| refusal.code, |_| OK)
}

fn names(placements: &[Placement], schema: &SchemaRef) -> ArrayRef {
    if schema.field(0).data_type() == &DataType::Int64 {
        let mut numbers = Int64Builder::with_capacity(placements.len());
        for placement in placements {
            numbers.append_option(match placement.name {
                Name::Integer(number) => Some(number),
                Name::Text(_) => None,
            });
        }
        return Arc::new(numbers.finish());
    }
    let mut texts = StringBuilder::new();
    for placement in placements {
        texts.append_value(placement.name.to_string());
    }
    Arc::new(texts.finish())
}

fn texts(
    outcomes: &[Result<Row, Refusal>],
    text: impl Fn(&Result<Row, Refusal>) -> Option<String>,
) -> ArrayRef {
    let mut column = StringBuilder::new();
    for outcome in outcomes {
        column.append_option(text(outcome));
    }
    Arc::new(column.finish())
}
