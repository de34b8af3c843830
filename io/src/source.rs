//! Where input comes from, and places in it.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read},
    ops::Range,
    path::PathBuf,
};

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

use crate::InputError;

/// A file, or standard input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Input {
    /// Standard input, written `-`.
    Stdin,
    /// The file at this path.
    File(PathBuf),
}

impl From<PathBuf> for Input {
    fn from(path: PathBuf) -> Self {
        if path.as_os_str() == "-" { Self::Stdin } else { Self::File(path) }
    }
}

impl Input {
    /// What messages call it.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Stdin => "standard input".to_owned(),
            Self::File(path) => path.display().to_string(),
        }
    }

    /// Opens it.
    ///
    /// # Errors
    /// `unreadable` when there is no such file, when it is a directory, or when it may not be read.
    pub fn open(&self) -> Result<Box<dyn BufRead + Send>, InputError> {
        match self {
            Self::Stdin => Ok(Box::new(BufReader::new(io::stdin()))),
            Self::File(path) => {
                let file = File::open(path).map_err(|error| self.unreadable(&error))?;
                // Opening a directory succeeds on Unix; reading it then tells an obscure error.
                if file.metadata().is_ok_and(|metadata| metadata.is_dir()) {
                    return Err(self.unreadable(&io::ErrorKind::IsADirectory.into()));
                }
                Ok(Box::new(BufReader::new(file)))
            }
        }
    }

    /// The error of a file that cannot be opened or read.
    #[must_use]
    pub fn unreadable(&self, error: &io::Error) -> InputError {
        let help = match error.kind() {
            io::ErrorKind::NotFound => {
                "check the path; a table that a measurement file names is looked for beside that file"
            }
            io::ErrorKind::IsADirectory => "give a file in it",
            _ => "check the file and its permissions",
        };
        InputError::new("unreadable", format!("cannot read {}: {error}", self.name()))
            .with_file(&self.name())
            .with_help(help)
    }
}

/// The whole text of a file, held to point into it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Source {
    name: String,
    text: String,
    /// Bytes of a byte order mark that preceded the text.
    skipped: usize,
}

/// The largest measurement file read, in bytes; larger ones are a device or the wrong file.
const LARGEST: u64 = 64 << 20;

impl Source {
    /// A text that was read already.
    pub(crate) fn new(name: &str, text: &str) -> Self {
        let rest = text.strip_prefix('\u{feff}').unwrap_or(text);
        Self { name: name.to_owned(), text: rest.to_owned(), skipped: text.len() - rest.len() }
    }

    /// Reads the whole of `input`.
    pub(crate) fn read(input: &Input) -> Result<Self, InputError> {
        let name = input.name();
        let mut bytes = Vec::new();
        input.open()?.take(LARGEST + 1).read_to_end(&mut bytes).map_err(|error| input.unreadable(&error))?;
        if bytes.len() as u64 > LARGEST {
            let message = format!("{name} is larger than {} MiB", LARGEST >> 20);
            return Err(InputError::new("invalid-input", message)
                .with_file(&name)
                .with_help("a measurement file or a log is short; many touches belong in a touch table"));
        }
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Self::new(&name, &text)),
            Err(error) => {
                let good = error.utf8_error().valid_up_to();
                let readable = String::from_utf8_lossy(&error.as_bytes()[..good]);
                Err(not_utf8(error.as_bytes()).at(Self::new(&name, &readable).place(good..good)))
            }
        }
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Where in the input its text begins, in bytes.
    pub(crate) fn start(&self) -> usize {
        self.skipped
    }

    /// The place of a span of bytes of [`text`](Self::text).
    pub(crate) fn place(&self, span: Range<usize>) -> Place {
        /// Lines shown before the one that is wrong.
        const BEFORE: usize = 2;
        let start = floor(&self.text, span.start);
        let end = floor(&self.text, span.end).max(start);
        let line_start = self.text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let line = self.text[..start].matches('\n').count();
        let shown_from =
            self.text[..line_start].rmatch_indices('\n').nth(BEFORE).map_or(0, |(newline, _)| newline + 1);
        let shown_to = self.text[end..].find('\n').map_or(self.text.len(), |newline| end + newline);
        let shown = &self.text[shown_from..shown_to];
        let lines_before = self.text[shown_from..line_start].matches('\n').count();
        Place {
            file: self.name.clone(),
            line: line + 1,
            column: Some(self.text[line_start..start].chars().count() + 1),
            offset: self.skipped + start,
            length: end - start,
            excerpt: Excerpt::new(
                &self.name,
                line - lines_before,
                shown,
                start - shown_from..end - shown_from,
            ),
        }
    }
}

/// The error of bytes that are not UTF-8, still without a place.
pub(crate) fn not_utf8(bytes: &[u8]) -> InputError {
    let help = if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        "this looks like UTF-16: save it as UTF-8"
    } else {
        "save it as UTF-8 text"
    };
    InputError::new("invalid-input", "this is not UTF-8 text").with_help(help)
}

/// The last character boundary of `text` at or before `index`.
fn floor(text: &str, index: usize) -> usize {
    (0..=index.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}

/// A place in an input, with the lines around it.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// What messages call the input.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters; `None` when the line as a whole is meant.
    pub column: Option<usize>,
    /// Byte offset in the input.
    pub offset: usize,
    /// Bytes from there on.
    pub length: usize,
    pub(crate) excerpt: Excerpt,
}

/// A few lines of an input, as diagnostics show them; never long, whatever the input is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Excerpt {
    file: String,
    /// Line of the input at which the text begins, from 0.
    first_line: usize,
    text: String,
    span: Range<usize>,
}

impl Excerpt {
    /// `text` begins at line `first_line` (from 0); `span` is what is wrong in it.
    pub(crate) fn new(file: &str, first_line: usize, text: &str, span: Range<usize>) -> Self {
        /// The longest text shown whole, in bytes.
        const WHOLE: usize = 2000;
        /// What is shown on either side of what is wrong in a longer one.
        const AROUND: usize = 60;
        let (mut first_line, mut from, mut to) = (first_line, 0, text.len());
        if text.len() > WHOLE {
            let line_start = text[..span.start].rfind('\n').map_or(0, |newline| newline + 1);
            from = floor(text, line_start.max(span.start.saturating_sub(AROUND)));
            to = floor(text, text.len().min(span.start + AROUND));
            first_line += text[..from].matches('\n').count();
        }
        let span = span.start - from..span.end.min(to).max(span.start) - from;
        // As many bytes, so that spans stay, but nothing that a terminal would obey.
        let harmless = |c: char| match c {
            '\n' | '\t' => c,
            '\r' => ' ',
            c if c.is_ascii_control() => '?',
            c => c,
        };
        let text = text[from..to].chars().map(harmless).collect();
        Self { file: file.to_owned(), first_line, text, span }
    }

    pub(crate) fn span(&self) -> SourceSpan {
        self.span.clone().into()
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        context_lines_before: usize,
        context_lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.text.read_span(span, context_lines_before, context_lines_after)?;
        let line = self.first_line + inner.line();
        Ok(Box::new(MietteSpanContents::new_named(
            self.file.clone(),
            inner.data(),
            *inner.span(),
            line,
            inner.column(),
            inner.line_count(),
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters_from_one() {
        let source = Source::new("f", "\u{feff}a\r\nµµ = 1\nend");
        let at = source.text().find('1').unwrap();
        let place = source.place(at..at + 1);
        assert_eq!((place.line, place.column, place.length), (2, Some(6), 1));
        assert_eq!(place.offset, at + 3, "the byte order mark counts");
        let end = source.place(1000..2000);
        assert_eq!((end.line, end.column), (3, Some(4)));
    }

    #[test]
    fn an_excerpt_of_a_long_line_is_short() {
        let text = format!("first\n{}X{}", "µ".repeat(5000), "b".repeat(5000));
        let at = text.find('X').unwrap();
        let place = Source::new("f", &text).place(at..at + 4000);
        assert_eq!((place.line, place.column), (2, Some(5001)));
        assert!(place.excerpt.text.len() < 200);
        let shown = place.excerpt.read_span(&place.excerpt.span(), 1, 1).unwrap();
        assert_eq!(shown.line(), 1);
    }
}
