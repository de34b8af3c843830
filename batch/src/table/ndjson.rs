//! JSON, one touch a line: an object with the keys of a touch table.

use std::io::{self, BufRead, Read, Write};

use arrow_array::RecordBatch;
use arrow_json::writer::{LineDelimited, Writer, WriterBuilder};
use serde_json::{Map, Value};
use touchref_core::{Fixture, Touch, Units};
use touchref_io::{Input, InputError, table::nearest_column};

use super::{Sink, Source};
use crate::{
    NameType,
    placement::{Gathering, Name, Placement},
    touch::{APPROACH, AT, Row},
};

/// The longest line read, in bytes: more is not a touch.
const LONGEST: u64 = 1 << 16;

/// The keys that a line may have, and that are not known otherwise; any other is left alone unless it is misspelt.
const OTHERS: [&str; 5] = ["placement", "surface", "sigma", "units", "id"];

/// The placement that a line names, and its touch or what is wrong with it.
type Line = (Name, Result<Touch, InputError>);

/// Touches, read line by line.
pub(super) struct Touches<'a> {
    fixture: &'a dyn Fixture,
    units: Units,
    file: String,
    reader: Box<dyn BufRead + Send>,
    /// Of the line read last, from 1.
    line: u64,
    /// The first touch: it tells what placements are called.
    first: Option<Line>,
    names: NameType,
    gathering: Gathering,
}

impl<'a> Touches<'a> {
    pub(super) fn open(input: &Input, fixture: &'a dyn Fixture, units: Units) -> Result<Self, InputError> {
        let mut touches = Self {
            fixture,
            units,
            file: input.name(),
            reader: input.open()?,
            line: 0,
            first: None,
            names: NameType::Text,
            gathering: Gathering::default(),
        };
        touches.first = touches.read()?;
        if let Some((Name::Integer(_), _)) = touches.first {
            touches.names = NameType::Integer;
        }
        Ok(touches)
    }

    fn place(&self) -> String {
        format!("{}, line {}", self.file, self.line)
    }

    fn wrong(&self, problem: &str) -> InputError {
        InputError::new("invalid-input", format!("{}: {problem}", self.place()))
            .with_file(&self.file)
            .with_help(r#"a line is as {"placement": "a", "surface": "plane", "x": 1.0, "y": 2.0, "z": 3.0}"#)
    }

    /// The touch of the next line that is not blank.
    fn read(&mut self) -> Result<Option<Line>, InputError> {
        let mut text = Vec::new();
        loop {
            text.clear();
            let read = self.reader.by_ref().take(LONGEST + 1).read_until(b'\n', &mut text);
            let length = read.map_err(|error| {
                InputError::new("unreadable", format!("cannot read {}: {error}", self.file))
                    .with_file(&self.file)
            })?;
            if length == 0 {
                return Ok(None);
            }
            self.line += 1;
            if length as u64 > LONGEST {
                return Err(self.wrong(&format!("the line is longer than {} KiB", LONGEST >> 10)));
            }
            if !text.trim_ascii().is_empty() {
                break;
            }
        }
        let keys: Map<String, Value> = serde_json::from_slice(&text)
            .map_err(|error| self.wrong(&format!("column {}: no JSON object: {error}", error.column())))?;
        let name = match keys.get("placement") {
            Some(Value::String(text)) if !text.is_empty() => Name::Text(text.clone()),
            Some(Value::Number(number)) if number.is_i64() => {
                Name::Integer(number.as_i64().unwrap_or_default())
            }
            Some(other) => {
                return Err(self.wrong(&format!("placement is {other}; expected a text or an integer")));
            }
            None => return Err(self.wrong("the touch belongs to no placement")),
        };
        let touch = self.touch(&keys);
        Ok(Some((name, touch)))
    }

    fn touch(&self, keys: &Map<String, Value>) -> Result<Touch, InputError> {
        let known = |key: &&String| {
            let key = key.as_str();
            AT.contains(&key) || APPROACH.contains(&key) || OTHERS.contains(&key)
        };
        for key in keys.keys().filter(|key| !known(key)) {
            if let Some(near) = nearest_column(key) {
                let message = format!("{}: key `{key}` is not known", self.place());
                return Err(InputError::new("unknown-key", message).with_nearest(Some(near)).with_key(key));
            }
        }
        let wrong = |key: &str, found: &Value, expected: &str| {
            let message = format!("{}, `{key}` is {found}; expected {expected}", self.place());
            InputError::new("invalid-input", message).with_key(key)
        };
        let number = |key: &str| match keys.get(key) {
            None | Some(Value::Null) => Ok(None),
            Some(found) => found.as_f64().map(Some).ok_or_else(|| wrong(key, found, "a number")),
        };
        let text = |key: &str| match keys.get(key) {
            None | Some(Value::Null) => Ok(None),
            Some(found) => found.as_str().map(Some).ok_or_else(|| wrong(key, found, "a text")),
        };
        let [x, y, z] = AT.map(number);
        let [i, j, k] = APPROACH.map(number);
        let row = Row {
            surface: text("surface")?,
            at: [x?, y?, z?],
            sigma: number("sigma")?,
            approach: [i?, j?, k?],
            units: text("units")?,
        };
        row.touch(self.fixture, self.units, || self.place())
    }
}

impl Source for Touches<'_> {
    fn names(&self) -> NameType {
        self.names
    }

    fn next_placement(&mut self) -> Result<Option<Placement>, InputError> {
        loop {
            let Some((name, touch)) =
                self.first.take().map_or_else(|| self.read(), |first| Ok(Some(first)))?
            else {
                return Ok(self.gathering.finish());
            };
            if name.name_type() != self.names {
                return Err(self.wrong("placements are called by numbers, or by texts; not by both"));
            }
            let place = format!("{}, line {}", self.file, self.line);
            if let Some(complete) = self.gathering.add(&name, touch, || place)? {
                return Ok(Some(complete));
            }
        }
    }
}

/// Frames, an object a line; what does not exist is `null`.
pub(super) struct Frames<W: Write>(Writer<W, LineDelimited>);

impl<W: Write> Frames<W> {
    pub(super) fn new(writer: W) -> Self {
        Self(WriterBuilder::new().with_explicit_nulls(true).build(writer))
    }
}

impl<W: Write + Send> Sink for Frames<W> {
    fn write(&mut self, frames: &RecordBatch) -> io::Result<()> {
        self.0.write(frames).map_err(io::Error::other)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.0.finish().map_err(io::Error::other)?;
        self.0.into_inner().flush()
    }
}
