//! Touches as the columns of a table.

use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use touchref::{Fixture, Touch};

/// The touches of placements, each with its number.
pub(crate) fn record_batch(fixture: &dyn Fixture, placements: &[(u64, Vec<Touch>)]) -> RecordBatch {
    let rows = || {
        placements
            .iter()
            .flat_map(|(name, touches)| touches.iter().map(move |touch| (name.cast_signed(), touch)))
    };
    let surfaces = fixture.surfaces();
    let axis = |axis: usize| -> ArrayRef {
        Arc::new(Float64Array::from_iter_values(rows().map(|(_, touch)| touch.at[axis])))
    };
    let names = rows().map(|(_, touch)| &surfaces[touch.surface].name);
    RecordBatch::try_from_iter([
        ("placement", Arc::new(Int64Array::from_iter_values(rows().map(|(name, _)| name))) as ArrayRef),
        ("surface", Arc::new(StringArray::from_iter_values(names))),
        ("x", axis(0)),
        ("y", axis(1)),
        ("z", axis(2)),
    ])
    .unwrap()
}
