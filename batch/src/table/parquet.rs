//! Apache Parquet.

use std::{
    collections::VecDeque,
    fs::File,
    io::{self, Write},
    sync::Arc,
};

use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use parquet::{
    arrow::{
        ArrowWriter, ProjectionMask,
        arrow_reader::{
            ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReader,
            ParquetRecordBatchReaderBuilder,
        },
    },
    basic::Compression,
    errors::ParquetError,
    file::properties::WriterProperties,
    schema::types::ColumnPath,
};
use touchref_core::{Fixture, Units, Warning};
use touchref_io::{Input, InputError};

use super::{Sink, Source};
use crate::{
    NameType, columns,
    columns::Rows,
    placement::{Gathering, Placement},
};

/// So many rows are decoded at once.
const ROWS_TOGETHER: usize = 16_384;
/// So many frames make a row group: some ten megabytes, which are held until it is written.
const FRAMES_IN_A_GROUP: usize = 32_768;

/// Touches, read row group by row group.
pub(super) struct Touches<'a> {
    fixture: &'a dyn Fixture,
    units: Units,
    names: NameType,
    file: File,
    name: String,
    metadata: ArrowReaderMetadata,
    /// The row group that is read, from 0.
    group: usize,
    reader: Option<ParquetRecordBatchReader>,
    /// Rows that were read.
    rows: u64,
    gathering: Gathering,
    complete: VecDeque<Placement>,
    ended: bool,
    warnings: Vec<Warning>,
}

impl<'a> Touches<'a> {
    pub(super) fn open(input: &Input, fixture: &'a dyn Fixture, units: Units) -> Result<Self, InputError> {
        let name = input.name();
        let Input::File(path) = input else {
            let message = "Parquet is read from a file, as its end comes first; not from standard input";
            return Err(InputError::new("invalid-input", message).with_help("give the path of the file"));
        };
        let file = File::open(path).map_err(|error| input.unreadable(&error))?;
        let metadata = ArrowReaderMetadata::load(&file, ArrowReaderOptions::new()).map_err(|error| {
            InputError::new("unreadable", format!("cannot read {name} as Parquet: {error}"))
                .with_file(&name)
                .with_help("it may be of another form, or cut off: its end tells what is in it")
        })?;
        let names = columns::check(metadata.schema(), units).map_err(|error| error.with_file(&name))?;
        let warnings = columns::ignored(metadata.schema(), &name);
        Ok(Self {
            fixture,
            units,
            names,
            warnings,
            file,
            name,
            metadata,
            group: 0,
            reader: None,
            rows: 0,
            gathering: Gathering::default(),
            complete: VecDeque::new(),
            ended: false,
        })
    }

    /// Reads the columns that touches are made of; of them only `only`, if that is given.
    fn open_group(&self, only: Option<&str>) -> Result<ParquetRecordBatchReader, ParquetError> {
        let builder =
            ParquetRecordBatchReaderBuilder::new_with_metadata(self.file.try_clone()?, self.metadata.clone());
        let names = builder.schema().fields().iter().enumerate();
        let wanted = names.filter(|(_, field)| match only {
            Some(only) => field.name() == only,
            None => columns::is_column(field.name()),
        });
        let roots: Vec<usize> = wanted.map(|(index, _)| index).collect();
        let mask = ProjectionMask::roots(builder.parquet_schema(), roots);
        builder.with_projection(mask).with_row_groups(vec![self.group]).with_batch_size(ROWS_TOGETHER).build()
    }

    /// The next rows; `None` at the end.
    fn read(&mut self) -> Result<Option<RecordBatch>, InputError> {
        while self.group < self.metadata.metadata().num_row_groups() {
            if self.reader.is_none() {
                self.reader = Some(self.open_group(None).map_err(|error| self.corrupt(&error))?);
            }
            let Some(reader) = &mut self.reader else { break };
            match reader.next() {
                Some(Ok(batch)) => return Ok(Some(batch)),
                Some(Err(error)) => return Err(self.corrupt(&error)),
                None => {
                    self.reader = None;
                    self.group += 1;
                }
            }
        }
        Ok(None)
    }

    /// A row group that cannot be decoded, with the columns in which it cannot.
    fn corrupt(&self, error: &dyn std::error::Error) -> InputError {
        let bad = |name: &str| {
            self.open_group(Some(name)).map_or(true, |mut reader| reader.any(|batch| batch.is_err()))
        };
        let fields = self.metadata.schema().fields().iter();
        let columns: Vec<String> = fields
            .map(|field| field.name().as_str())
            .filter(|name| columns::is_column(name) && bad(name))
            .map(|name| format!("`{name}`"))
            .collect();
        let place = match columns.as_slice() {
            [] => String::new(),
            [one] => format!(", column {one}"),
            many => format!(", columns {}", many.join(", ")),
        };
        let message = format!("cannot read {}, row group {}{place}: {error}", self.name, self.group);
        InputError::new("unreadable", message)
            .with_file(&self.name)
            .with_help("the file is damaged, or packed in a way that is not known: write it anew")
    }
}

impl Source for Touches<'_> {
    fn names(&self) -> NameType {
        self.names
    }

    fn rows(&self) -> Option<u64> {
        u64::try_from(self.metadata.metadata().file_metadata().num_rows()).ok()
    }

    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    fn next_placement(&mut self) -> Result<Option<Placement>, InputError> {
        while self.complete.is_empty() && !self.ended {
            let Some(batch) = self.read()? else {
                self.ended = true;
                self.complete.extend(self.gathering.finish());
                break;
            };
            let rows = Rows { file: Some(&self.name), group: Some(self.group), first: self.rows };
            let complete = &mut self.complete;
            columns::gather(&batch, rows, self.fixture, self.units, &mut self.gathering, |placement| {
                complete.push_back(placement);
            })?;
            self.rows += batch.num_rows() as u64;
        }
        Ok(self.complete.pop_front())
    }
}

/// Frames, a row each.
pub(super) struct Frames<W: Write + Send>(ArrowWriter<W>);

impl<W: Write + Send> Frames<W> {
    pub(super) fn new(schema: &SchemaRef, writer: W) -> io::Result<Self> {
        // No two frames share a number: only the few words are worth a dictionary.
        let mut properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .set_max_row_group_row_count(Some(FRAMES_IN_A_GROUP));
        for words in ["status", "warnings", "message"] {
            properties = properties.set_column_dictionary_enabled(ColumnPath::from(words), true);
        }
        let writer = ArrowWriter::try_new(writer, Arc::clone(schema), Some(properties.build()))?;
        Ok(Self(writer))
    }
}

impl<W: Write + Send> Sink for Frames<W> {
    fn write(&mut self, frames: &RecordBatch) -> io::Result<()> {
        Ok(self.0.write(frames)?)
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.0.close()?;
        Ok(())
    }
}
