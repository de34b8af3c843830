//! One fixture, one solver, one probe: many placements.

use std::{collections::BTreeMap, fmt};

use arrow_array::RecordBatch;
use arrow_schema::{ArrowError, Schema, SchemaRef};
use nalgebra::Point3;
use rayon::prelude::*;
use touchref_core::{
    Fixture, Frame, Noise, Probe, Problem, SolveError, Solver, Together, Touch, TouchError, Units,
};
use touchref_io::InputError;

use crate::{
    NameType, columns,
    columns::Rows,
    frames::{self, Row},
    placement::{Gathering, Placement},
    source::Source,
};

/// So many placements are located at once: enough to keep many processors busy, few enough to take little room.
const TOGETHER: usize = 8192;
/// So many placements are a piece of work, and a record batch: solutions are large, and kept no longer than until they are
/// rows.
const IN_A_PIECE: usize = 256;

/// Finds the frames of many placements of one fixture.
///
/// Each frame is, bit for bit, the one that the solver gives for that placement alone, whatever the number of threads; with
/// `fast`, the same to a millionth of its standard deviations, and bit for bit the same whatever the number of threads and the
/// placements beside it.
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
    /// Whether placements of which it is cheaply certain what the solver would find are located
    /// [together](touchref_core::Together), where fixture and solver can.
    pub fast: bool,
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

/// Some placements of a table, located.
#[derive(Debug, Clone)]
pub struct Located {
    /// Their frames.
    pub frames: RecordBatch,
    /// How many rows of the table were theirs.
    pub rows: u64,
    counts: Counts,
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
        let mut found = Vec::new();
        while !read.is_empty() || !found.is_empty() {
            let ((located, next), written) = rayon::join(
                || rayon::join(|| self.located(&schema, &read), || chunk(source)),
                || found.iter().try_for_each(&mut *sink),
            );
            written?;
            found = located?;
            for (status, count) in found.iter().flat_map(|located| &located.counts.0) {
                *counts.0.entry(status).or_default() += count;
            }
            read = next?;
        }
        Ok(counts)
    }

    /// Locates placements piece by piece, on the threads of the pool it is called in.
    fn located(&self, schema: &SchemaRef, placements: &[Placement]) -> Result<Vec<Located>, InputError> {
        let together = self.together();
        let piece = |placements: &[Placement]| {
            let outcomes = self.outcomes(together.as_deref(), placements);
            let frames = frames::record_batch(schema, placements, &outcomes).map_err(unbuilt)?;
            let mut counts = Counts::default();
            for outcome in &outcomes {
                *counts.0.entry(frames::status(outcome)).or_default() += 1;
            }
            Ok(Located { frames, rows: placements.iter().map(|placement| placement.rows).sum(), counts })
        };
        placements.par_chunks(IN_A_PIECE).map(piece).collect()
    }

    /// As [`located`](Self::located), in one record batch.
    fn frames(&self, schema: &SchemaRef, placements: &[Placement]) -> Result<RecordBatch, InputError> {
        let located = self.located(schema, placements)?;
        joined(schema, located.iter().map(|located| &located.frames))
    }

    /// The way to many frames at once, if it is wanted and there is one.
    fn together(&self) -> Option<Box<dyn Together>> {
        let wanted = self.fast && self.near.is_none();
        let rule = self.solver.rule().filter(|_| wanted)?;
        self.fixture.together(&self.probe, &rule)
    }

    fn outcomes(
        &self,
        together: Option<&dyn Together>,
        placements: &[Placement],
    ) -> Vec<Result<Row, Refusal>> {
        let mut certain: Vec<Option<Row>> = vec![None; placements.len()];
        if let Some(together) = together {
            let (mut touches, mut owners) = (Vec::new(), Vec::new());
            for (index, placement) in placements.iter().enumerate() {
                if gather_plain(placement, together.counts(), &mut touches) {
                    owners.push(index);
                }
            }
            together.locate(&touches, &mut |index, found| certain[owners[index]] = Some(found.into()));
        }
        let outcome = |(certain, placement)| match certain {
            Some(row) => Ok(row),
            None => self.outcome(placement),
        };
        certain.into_iter().zip(placements).map(outcome).collect()
    }

    fn outcome(&self, placement: &Placement) -> Result<Row, Refusal> {
        let touches: &[Touch] = placement.touches.as_ref()?;
        let problem = Problem::new(self.fixture, touches, self.probe).map_err(|error: TouchError| {
            let error = InputError::from(error);
            Refusal::from(&error)
        })?;
        let problem = self.near.map_or(problem, |frame| problem.near(frame));
        Ok(self.solver.solve(&problem)?.into())
    }
}

/// Appends the tip centres of a placement, surface by surface, if it has just these counts and nothing but them.
fn gather_plain(placement: &Placement, counts: &[usize], to: &mut Vec<Point3<f64>>) -> bool {
    let Ok(touches) = &placement.touches else { return false };
    let plain = |touch: &Touch| touch.approach.is_none() && touch.noise == Noise::OfProbe;
    if touches.len() != counts.iter().sum::<usize>() || !touches.iter().all(plain) {
        return false;
    }
    let before = to.len();
    for (surface, count) in counts.iter().enumerate() {
        let first = to.len();
        to.extend(touches.iter().filter(|touch| touch.surface == surface).map(|touch| touch.at));
        if to.len() - first != *count {
            to.truncate(before);
            return false;
        }
    }
    true
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
        self.locator.frames(&self.schema, &complete)
    }

    /// The frame of the last placement; no row where there were no touches.
    ///
    /// # Errors
    /// None are known: memory that is too small for the row.
    pub fn finish(mut self) -> Result<RecordBatch, InputError> {
        let last: Vec<Placement> = self.gathering.finish().into_iter().collect();
        self.locator.frames(&self.schema, &last)
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

fn joined<'b>(
    schema: &SchemaRef,
    batches: impl IntoIterator<Item = &'b RecordBatch>,
) -> Result<RecordBatch, InputError> {
    arrow_select::concat::concat_batches(schema, batches).map_err(unbuilt)
}

/// None is known: memory that is too small for the columns.
#[allow(clippy::needless_pass_by_value)] // For `map_err`.
fn unbuilt(error: ArrowError) -> InputError {
    InputError::new("invalid-input", error.to_string())
}
