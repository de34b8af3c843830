//! Arrow's C stream interface in Python's capsules (the Arrow `PyCapsule` interface): tables in and out without a copy.

use std::ffi::CStr;

use arrow_array::{
    RecordBatch, RecordBatchIterator,
    ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader},
};
use arrow_schema::SchemaRef;
use pyo3::{prelude::*, types::PyCapsule};
use touchref::io::InputError;

use crate::errors::Failure;

/// What capsules of streams are called.
const STREAM: &CStr = c"arrow_array_stream";

/// The record batches of an object that has `__arrow_c_stream__`: a table, or what reads one.
///
/// # Errors
/// `invalid-input` for any other object, and for a stream that cannot be read.
pub(crate) fn reader(given: &Bound<'_, PyAny>) -> Result<RecordBatchStreamReader, Failure> {
    const EXPECTED: &str = "a table of pyarrow, polars or pandas, or any object with __arrow_c_stream__";
    let wrong =
        |problem: String| InputError::new("invalid-input", problem).with_key("touches").with_help(EXPECTED);
    let Ok(method) = given.getattr("__arrow_c_stream__") else {
        let name = given.get_type().name()?;
        return Err(wrong(format!("the touches are a `{name}`, which is no Arrow table")).into());
    };
    let capsule = method.call0()?;
    let capsule = capsule.cast::<PyCapsule>().map_err(PyErr::from)?;
    Ok(imported(capsule)?.map_err(|error| wrong(format!("the touches are no table: {error}")))?)
}

/// Takes the stream out of its capsule.
#[allow(unsafe_code, reason = "a capsule holds a pointer of C")]
fn imported(
    capsule: &Bound<'_, PyCapsule>,
) -> PyResult<Result<RecordBatchStreamReader, arrow_schema::ArrowError>> {
    let pointer = capsule.pointer_checked(Some(STREAM))?;
    // SAFETY: a capsule of this name holds a valid `ArrowArrayStream` as long as it lives, which is beyond this call; the
    // stream is moved out, and what is left in the capsule is marked as released, so that nobody uses or frees it again.
    Ok(unsafe { RecordBatchStreamReader::from_raw(pointer.as_ptr().cast::<FFI_ArrowArrayStream>()) })
}

/// A capsule with a stream of record batches; their memory is shared, not copied.
///
/// # Errors
/// Python's, where memory is too small.
pub(crate) fn stream(
    py: Python<'_>,
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
) -> PyResult<Bound<'_, PyCapsule>> {
    let batches = RecordBatchIterator::new(batches.into_iter().map(Ok), schema);
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(batches)), STREAM)
}
