//! Many placements of one fixture, from Arrow to Arrow.

use std::{
    collections::BTreeMap,
    sync::{
        Mutex, PoisonError,
        mpsc::{Receiver, Sender, channel},
    },
    thread,
};

use arrow_array::{RecordBatch, cast::AsArray};
use arrow_schema::{DataType, Schema, SchemaRef};
use pyo3::{
    prelude::*,
    types::{PyCapsule, PyDict},
};
use rayon::ThreadPoolBuilder;
use touchref::{
    Frame, Parameters, Solver, SolverPlugin,
    batch::Locator,
    io::{InputError, Measurement as Measured},
    locate::{Setup, build_solver, solver_plugin},
};

use crate::{capsule, errors::Failure, measurement::Measurement, registry, values, waiting::wait};

/// So many rows are handed to the threads at once: enough to keep many processors busy, and soon done where the user
/// interrupts.
const ROWS_TOGETHER: usize = 16_384;

/// More threads than any machine has use for.
const MOST_THREADS: usize = 1024;

/// Frames, one row a placement: a table for whatever speaks Arrow's ``PyCapsule`` interface.
#[pyclass(frozen, module = "touchref")]
pub(crate) struct Frames {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

#[pymethods]
impl Frames {
    /// Those of several parts of one table.
    #[staticmethod]
    fn joined(parts: Vec<PyRef<'_, Self>>) -> Result<Self, Failure> {
        let Some(first) = parts.first() else {
            return Err(InputError::new("too-few-touches", "there are no touches").into());
        };
        let batches = parts.iter().flat_map(|part| part.batches.iter().cloned()).collect();
        Ok(Self { schema: SchemaRef::clone(&first.schema), batches })
    }

    fn __repr__(&self) -> String {
        let counts = self.counts().into_iter().map(|(status, count)| format!("{count} {status}"));
        format!("<Frames: {}>", counts.collect::<Vec<_>>().join(", "))
    }

    fn __len__(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    /// How many placements by status: `ok`, or the code of the refusal.
    #[getter]
    fn counts(&self) -> BTreeMap<String, usize> {
        let mut counts = BTreeMap::new();
        for status in self.batches.iter().filter_map(|batch| batch.column_by_name("status")) {
            for word in status.as_string::<i32>().iter().flatten() {
                *counts.entry(word.to_owned()).or_default() += 1;
            }
        }
        counts
    }

    /// Arrow's C stream in a capsule. Columns come in the types they have, whatever `requested_schema` says.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        capsule::stream(py, SchemaRef::clone(&self.schema), self.batches.clone())
    }
}

/// Touches for the thread at work; `None` where there are no more.
type Touches = Option<RecordBatch>;
/// Frames, or what is wrong with the touches.
type Answer = Result<RecordBatch, InputError>;

/// Placements that are located as their touches come.
#[pyclass(module = "touchref._touchref")]
pub(crate) struct Stream {
    work: Work,
    /// The thread, once the columns of the touches are known.
    at_work: Option<AtWork>,
    /// Whether it was finished, has failed or was interrupted.
    ended: bool,
}

/// What a thread needs to begin.
#[derive(Clone)]
struct Work {
    measured: Measured,
    solver: &'static SolverPlugin,
    parameters: Parameters,
    near: Option<Frame>,
    fast: bool,
    threads: usize,
}

struct AtWork {
    columns: SchemaRef,
    schema: SchemaRef,
    touches: Sender<Touches>,
    /// Only one thread of Python has the stream; the lock tells the compiler.
    answers: Mutex<Receiver<Answer>>,
}

#[pymethods]
impl Stream {
    #[new]
    fn new(
        measurement: &Measurement,
        solver: Option<&str>,
        parameters: &Bound<'_, PyDict>,
        near: Option<Vec<f64>>,
        fast: bool,
        threads: usize,
    ) -> Result<Self, Failure> {
        let solver = solver_plugin(registry()?, solver)?;
        let parameters = values::parameters(parameters)?;
        build_solver(solver, &[], &parameters)?;
        if threads > MOST_THREADS {
            let message = format!("threads is {threads}; expected {MOST_THREADS} or fewer");
            return Err(InputError::new("invalid-input", message).with_key("threads").into());
        }
        let near = near.map(|numbers| values::frame(&numbers)).transpose()?;
        let measured = measurement.measured.clone();
        Ok(Self {
            work: Work { measured, solver, parameters, near, fast, threads },
            at_work: None,
            ended: false,
        })
    }

    /// Takes more touches, and returns the frames of the placements that are complete.
    fn add(&mut self, py: Python<'_>, touches: &Bound<'_, PyAny>) -> Result<Frames, Failure> {
        self.require_open()?;
        let mut reader = capsule::reader(touches)?;
        let columns = arrow_array::RecordBatchReader::schema(&reader);
        let result = self.add_all(py, &columns, || py.detach(|| reader.next()));
        // What failed may have left a placement behind of which half is known.
        self.ended = result.is_err();
        result
    }

    /// The frame of the last placement.
    fn finish(&mut self, py: Python<'_>) -> Result<Frames, Failure> {
        self.require_open()?;
        self.ended = true;
        let Some(mut at_work) = self.at_work.take() else {
            return Err(InputError::new("too-few-touches", "there are no touches").into());
        };
        let last = at_work.ask(py, None)?;
        Ok(Frames { schema: at_work.schema, batches: vec![last] })
    }
}

impl Stream {
    fn require_open(&self) -> Result<(), InputError> {
        if self.ended {
            return Err(InputError::new("invalid-input", "the stream has ended; begin another one"));
        }
        Ok(())
    }

    fn add_all(
        &mut self,
        py: Python<'_>,
        columns: &SchemaRef,
        mut next: impl FnMut() -> Option<Result<RecordBatch, arrow_schema::ArrowError>>,
    ) -> Result<Frames, Failure> {
        let at_work = match &mut self.at_work {
            Some(at_work) => at_work.same_columns(columns)?,
            none => none.insert(self.work.clone().begin(columns)?),
        };
        let mut batches = Vec::new();
        while let Some(batch) = next() {
            let batch =
                batch.map_err(|error| InputError::new("unreadable", format!("the touches: {error}")))?;
            for first in (0..batch.num_rows()).step_by(ROWS_TOGETHER) {
                let rows = ROWS_TOGETHER.min(batch.num_rows() - first);
                batches.push(at_work.ask(py, Some(batch.slice(first, rows)))?);
            }
        }
        Ok(Frames { schema: SchemaRef::clone(&at_work.schema), batches })
    }
}

impl Work {
    /// Starts the thread, and those on which it solves: threads of a pool that all streams shared would not be there in a
    /// process that was forked.
    fn begin(self, columns: &SchemaRef) -> Result<AtWork, Failure> {
        let registry = registry()?;
        let solver = build_solver(self.solver, &[], &self.parameters)?;
        let setup = Setup::new(self.measured, registry)?;
        let pool = ThreadPoolBuilder::new().num_threads(self.threads).build().map_err(|error| {
            InputError::new("invalid-input", format!("cannot start the threads: {error}")).with_key("threads")
        })?;
        let (near, fast) = (self.near, self.fast);
        let schema = locator(&setup, &*solver, near, fast).stream(columns)?.schema();
        let (touches, to_be_located) = channel::<Touches>();
        let (answer, answers) = channel();
        let of_touches = SchemaRef::clone(columns);
        thread::spawn(move || {
            pool.install(move || {
                let Ok(mut stream) = locator(&setup, &*solver, near, fast).stream(&of_touches) else {
                    return;
                };
                // Nobody receives, or sends, once the stream is dropped.
                while let Ok(touches) = to_be_located.recv() {
                    let Some(touches) = touches else {
                        let _ = answer.send(stream.finish());
                        return;
                    };
                    if answer.send(stream.add(&touches)).is_err() {
                        return;
                    }
                }
            });
        });
        Ok(AtWork { columns: SchemaRef::clone(columns), schema, touches, answers: Mutex::new(answers) })
    }
}

fn locator<'a>(setup: &'a Setup, solver: &'a dyn Solver, near: Option<Frame>, fast: bool) -> Locator<'a> {
    let measured = &setup.measurement;
    Locator { fixture: &*setup.fixture, solver, probe: measured.probe, units: measured.units, near, fast }
}

impl AtWork {
    /// What is made of the touches; of the last ones where there are no more.
    fn ask(&mut self, py: Python<'_>, touches: Touches) -> Result<RecordBatch, Failure> {
        // Where the thread has ended there will be no answer either.
        let _ = self.touches.send(touches);
        let answers = self.answers.get_mut().unwrap_or_else(PoisonError::into_inner);
        Ok(wait(py, answers)??)
    }

    /// All parts of a table have the same columns, of the same types.
    fn same_columns(&mut self, columns: &Schema) -> Result<&mut Self, InputError> {
        let told = |schema: &Schema| -> Vec<(String, DataType)> {
            schema.fields().iter().map(|field| (field.name().clone(), field.data_type().clone())).collect()
        };
        if told(&self.columns) == told(columns) {
            return Ok(self);
        }
        let words = |schema: &Schema| {
            let columns = told(schema).into_iter().map(|(name, data_type)| format!("{name}: {data_type}"));
            columns.collect::<Vec<_>>().join(", ")
        };
        let message = format!(
            "the touches have the columns {}; those before had {}",
            words(columns),
            words(&self.columns)
        );
        Err(InputError::new("invalid-input", message)
            .with_key("touches")
            .with_help("all parts of a table have the same columns"))
    }
}
