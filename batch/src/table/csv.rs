//! Comma-separated values: a touch table with a column `placement`.

use std::io::{self, Write};

use arrow_array::RecordBatch;
use touchref_core::{Fixture, Units, Warning};
use touchref_io::{
    Input, InputError,
    table::{PlacedRow, TableReader},
};

use super::{Sink, Source};
use crate::{
    NameType,
    placement::{Gathering, Name, Placement},
};

/// Touches, read line by line.
pub(super) struct Touches<'a> {
    fixture: &'a dyn Fixture,
    reader: TableReader,
    gathering: Gathering,
}

impl<'a> Touches<'a> {
    pub(super) fn open(input: &Input, fixture: &'a dyn Fixture, units: Units) -> Result<Self, InputError> {
        let names: Vec<&str> = fixture.surfaces().iter().map(|surface| surface.name.as_str()).collect();
        let reader = TableReader::open(input, &names)?.in_units(units);
        reader.require_placements()?;
        Ok(Self { fixture, reader, gathering: Gathering::default() })
    }
}

impl Source for Touches<'_> {
    fn names(&self) -> NameType {
        NameType::Text
    }

    fn next_placement(&mut self) -> Result<Option<Placement>, InputError> {
        while let Some(PlacedRow { placement, line, touch }) = self.reader.next_placed()? {
            let touch = touch.and_then(|record| {
                record.touch(self.fixture).map_err(|error| {
                    let error = InputError::from(error);
                    InputError::new(error.code(), format!("line {line}: {error}")).with_key("surface")
                })
            });
            if let Some(complete) =
                self.gathering.add(&Name::Text(placement), touch, || format!("line {line}"))?
            {
                return Ok(Some(complete));
            }
        }
        Ok(self.gathering.finish())
    }

    fn warnings(&self) -> &[Warning] {
        self.reader.warnings()
    }
}

/// Frames, a line each.
pub(super) struct Frames<W: Write>(arrow_csv::Writer<W>);

impl<W: Write> Frames<W> {
    pub(super) fn new(writer: W) -> Self {
        Self(arrow_csv::Writer::new(writer))
    }
}

impl<W: Write + Send> Sink for Frames<W> {
    fn write(&mut self, frames: &RecordBatch) -> io::Result<()> {
        self.0.write(frames).map_err(io::Error::other)
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.0.into_inner().flush()
    }
}
