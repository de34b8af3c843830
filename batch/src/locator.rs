//! One fixture, one solver, one probe: many placements.

use std::{collections::BTreeMap, fmt};

use arrow_array::RecordBatch;
use arrow_schema::{Schema, SchemaRef};
use rayon::prelude::*;
use touchref_core::{Fixture, Frame, Probe, Problem, Solution, SolveError, Solver, Touch, TouchError, Units};
use touchref_io::InputError;

use crate::{
    NameType, columns,
    columns::Rows,
    frames,
    placement::{Gathering, Placement},
    source::Source,
};

/// So many placements are located at once: enough to keep many processors busy, few enough to take little room.
const TOGETHER: usize = 8192;

/// Finds the frames of many placements of one fixture.
///
/// Each frame is, bit for bit, the one that the solver gives for that placement alone, whatever the number of threads.
/// Touches and frames are in `units`; a placement without a frame is a row with the code of its refusal as status.
#[derive(Debug, Clone, Copy)]
pub struct Locator<'a> {
    /// The fixture.
    pub fixture: &'a dyn Fixture,
    /// The solver.
    pub solver: &'a dyn Solver,
    /// The probe.
    pub probe: Probe,
    /// Unit of every length.
    pub units: Units,
    /// The frame near which every placement is expected, if there is one.
    pub near: Option<Frame>,
}

/// Why a placement has no frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The code by which programs know it.
    pub code: &'static str,
    /// For people.
    pub message: String,
}

impl From<SolveError> for Refusal {
    fn from(error: SolveError) -> Self {
        Self { code: error.code(), message: error.to_string() }
    }
}

impl From<&InputError> for Refusal {
    fn from(error: &InputError) -> Self {
        Self { code: error.code(), message: error.to_string() }
    }
}

/// Some placements of a file, located.
#[derive(Debug, Clone)]
pub struct Located {
    /// Their frames.
    pub frames: RecordBatch,
    /// How many rows of the file were theirs.
    pub rows: u64,
}

/// How many placements came to what.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Counts(pub BTreeMap<&'static str, u64>);

impl Counts {
    /// All placements.
    #[must_use]
    pub fn placements(&self) -> u64 {
        self.0.values().sum()
    }

    /// The placements that have a frame.
    #[must_use]
    pub fn located(&self) -> u64 {
        self.0.get(frames::OK).copied().unwrap_or(0)
    }
}

impl<'a> Locator<'a> {
    /// Locates all placements whose touches are in a record batch: rows with the columns `placement`, `surface`, `x`, `y`,
    /// `z`, and where known `sigma`, `i`, `j`, `k` and `units`; the rows of a placement stand together.
    ///
    /// # Errors
    /// Columns that are missing, misspelt, of a wrong type or in another unit; a placement that comes again.
    pub fn locate(&self, touches: &RecordBatch) -> Result<RecordBatch, InputError> {
        let mut stream = self.stream(&touches.schema())?;
        let frames = stream.add(touches)?;
        let last = stream.finish()?;
        joined(&frames.schema(), [&frames, &last])
    }

    /// Locates placements as their touches come, batch by batch, in tables of these columns.
    ///
    /// # Errors
    /// As [`locate`](Self::locate).
    pub fn stream(&self, touches: &Schema) -> Result<Stream<'a>, InputError> {
        let names = columns::check(touches, self.units)?;
        Ok(Stream { locator: *self, schema: self.schema(names), gathering: Gathering::default(), rows: 0 })
    }

    /// The columns of the frames.
    #[must_use]
    pub fn schema(&self, names: NameType) -> SchemaRef {
        frames::schema(names, self.units)
    }

    /// Locates the placements of a file, hands on their frames in its order, a record batch at a time, and counts them.
    ///
    /// Reads, locates and hands on at the same time, on the threads of the pool it is called in, and holds a few thousand
    /// placements in memory.
    ///
    /// # Errors
    /// The first thing that is wrong with the file other than with single placements, and the first error of `sink`.
    pub fn run<E: From<InputError> + Send>(
        &self,
        source: &mut dyn Source,
        sink: &mut (dyn FnMut(&Located) -> Result<(), E> + Send),
    ) -> Result<Counts, E> {
        let schema = self.schema(source.names());
        let mut counts = Counts::default();
        let mut read = chunk(source)?;
        let mut found: Option<Located> = None;
        while !read.is_empty() || found.is_some() {
            let ((outcomes, next), written) = rayon::join(
                || rayon::join(|| self.outcomes(&read), || chunk(source)),
                || found.as_ref().map_or(Ok(()), &mut *sink),
            );
            written?;
            for outcome in &outcomes {
                *counts.0.entry(frames::status(outcome)).or_default() += 1;
            }
            found = None;
            if !read.is_empty() {
                let rows = read.iter().map(|placement| placement.rows).sum();
                found = Some(Located { frames: batch(&schema, &read, &outcomes)?, rows });
            }
            read = next?;
        }
        Ok(counts)
    }

    fn outcomes(&self, placements: &[Placement]) -> Vec<Result<Solution, Refusal>> {
        placements.par_iter().map(|placement| self.outcome(placement)).collect()
    }

    fn outcome(&self, placement: &Placement) -> Result<Solution, Refusal> {
        let touches: &[Touch] = placement.touches.as_ref()?;
        let problem = Problem::new(self.fixture, touches, self.probe).map_err(|error: TouchError| {
            let error = InputError::from(error);
            Refusal::from(&error)
        })?;
        let problem = self.near.map_or(problem, |frame| problem.near(frame));
        Ok(self.solver.solve(&problem)?)
    }
}

/// Placements that are located as their touches come.
pub struct Stream<'a> {
    locator: Locator<'a>,
    schema: SchemaRef,
    gathering: Gathering,
    rows: u64,
}

impl fmt::Debug for Stream<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stream").field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl Stream<'_> {
    /// The columns of the frames.
    #[must_use]
    pub fn schema(&self) -> SchemaRef {
        SchemaRef::clone(&self.schema)
    }

    /// Takes more touches, and returns the frames of the placements that are complete: that another one follows.
    ///
    /// # Errors
    /// As [`Locator::locate`].
    pub fn add(&mut self, touches: &RecordBatch) -> Result<RecordBatch, InputError> {
        let Locator { fixture, units, .. } = self.locator;
        let rows = Rows { first: self.rows, ..Rows::default() };
        let mut complete = Vec::new();
        columns::gather(touches, rows, fixture, units, &mut self.gathering, |placement| {
            complete.push(placement);
        })?;
        self.rows += touches.num_rows() as u64;
        batch(&self.schema, &complete, &self.locator.outcomes(&complete))
    }

    /// The frame of the last placement; no row where there were no touches.
    ///
    /// # Errors
    /// None are known: memory that is too small for the row.
    pub fn finish(mut self) -> Result<RecordBatch, InputError> {
        let last: Vec<Placement> = self.gathering.finish().into_iter().collect();
        batch(&self.schema, &last, &self.locator.outcomes(&last))
    }
}

/// The next placements of a file; none at its end.
fn chunk(source: &mut dyn Source) -> Result<Vec<Placement>, InputError> {
    let mut placements = Vec::with_capacity(TOGETHER);
    while placements.len() < TOGETHER {
        match source.next_placement()? {
            Some(placement) => placements.push(placement),
            None => break,
        }
    }
    Ok(placements)
}

fn batch(
    schema: &SchemaRef,
    placements: &[Placement],
    outcomes: &[Result<Solution, Refusal>],
) -> Result<RecordBatch, InputError> {
    frames::record_batch(schema, placements, outcomes)
        .map_err(|error| InputError::new("invalid-input", error.to_string()))
}

fn joined<'b>(
    schema: &SchemaRef,
    batches: impl IntoIterator<Item = &'b RecordBatch>,
) -> Result<RecordBatch, InputError> {
    arrow_select::concat::concat_batches(schema, batches)
        .map_err(|error| InputError::new("invalid-input", error.to_string()))
}
