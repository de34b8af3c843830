//! One line of a table, and its fields.

use std::ops::Range;

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

use crate::{InputError, source::Place};

/// A line, without its end.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub(crate) file: String,
    /// From 1.
    pub(crate) number: usize,
    /// Byte offset of its text in the input.
    pub(crate) offset: usize,
    pub(crate) text: String,
}

/// Splits lines into fields; keeps its buffers from one line to the next.
#[derive(Debug)]
pub(crate) struct Fields {
    reader: Reader,
    delimiter: char,
    /// The unquoted fields behind each other.
    content: Vec<u8>,
    /// Where each ends.
    ends: Vec<usize>,
    count: usize,
    quoted: bool,
}

impl Fields {
    pub(crate) fn new(delimiter: u8) -> Self {
        Self {
            reader: ReaderBuilder::new().delimiter(delimiter).build(),
            delimiter: char::from(delimiter),
            content: Vec::new(),
            ends: Vec::new(),
            count: 0,
            quoted: false,
        }
    }

    /// Splits a line that is not blank.
    ///
    /// # Errors
    /// A quote that is not closed on the line.
    pub(crate) fn split(&mut self, line: &Line) -> Result<(), InputError> {
        self.quoted = line.text.contains('"');
        if line.text.matches('"').count() % 2 == 1 {
            let quote = line.text.rfind('"').unwrap_or(0);
            return Err(InputError::new("invalid-input", "a quote is not closed on its line")
                .at(line.place_of(quote..quote + 1)));
        }
        // Unquoting never lengthens, and there is at most one field more than delimiters.
        self.content.resize(line.text.len(), 0);
        self.ends.resize(line.text.matches(self.delimiter).count() + 1, 0);
        self.reader.reset();
        let (result, _, written, ended) =
            self.reader.read_record(line.text.as_bytes(), &mut self.content, &mut self.ends);
        self.count = ended;
        if result == ReadRecordResult::InputEmpty {
            // An empty input tells the parser that the line, and with it the last field, ends here.
            let (_, _, _, ended) =
                self.reader.read_record(&[], &mut self.content[written..], &mut self.ends[ended..]);
            self.count += ended;
        }
        Ok(())
    }

    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// A field without quotes and without blanks around it.
    pub(crate) fn get(&self, index: usize) -> &str {
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        // The line is UTF-8 and is cut at ASCII characters only.
        std::str::from_utf8(&self.content[start..self.ends[index]]).unwrap_or("").trim()
    }

    /// The place of a field of `line`, which was split last; of the whole line where quotes hide it.
    pub(crate) fn place(&self, line: &Line, index: usize) -> Place {
        self.span(line, index).map_or_else(|| line.place(), |span| line.place_of(span))
    }

    /// Where in the text of `line`, which was split last, a field is; `None` where quotes hide it.
    pub(crate) fn span(&self, line: &Line, index: usize) -> Option<Range<usize>> {
        if self.quoted {
            return None;
        }
        let start: usize = line.text.split(self.delimiter).take(index).map(|field| field.len() + 1).sum();
        let start = start.min(line.text.len());
        let field = line.text[start..].split(self.delimiter).next().unwrap_or("");
        let indent = field.len() - field.trim_start().len();
        Some(start + indent..start + indent + field.trim().len())
    }
}
