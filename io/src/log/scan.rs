//! Reads words and numbers out of a text, and knows where they stand.

use std::ops::Range;

use nalgebra::Point3;

use super::Fault;

/// A part of a text, read from its beginning.
#[derive(Debug, Clone)]
pub(super) struct Scanner<'a> {
    text: &'a str,
    at: usize,
    end: usize,
}

impl<'a> Scanner<'a> {
    pub(super) fn new(text: &'a str, part: Range<usize>) -> Self {
        Self { text, at: part.start, end: part.end }
    }

    /// Where it stands.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// What is not read yet.
    pub(super) fn rest(&self) -> &'a str {
        &self.text[self.at..self.end]
    }

    pub(super) fn slice(&self, span: &Range<usize>) -> &'a str {
        &self.text[span.clone()]
    }

    /// What comes next, blanks and line ends left out.
    pub(super) fn peek(&mut self) -> Option<char> {
        self.at = self.end - self.rest().trim_start().len();
        self.rest().chars().next()
    }

    /// Goes past the next character.
    pub(super) fn step(&mut self) {
        self.at += self.rest().chars().next().map_or(0, char::len_utf8);
    }

    /// Goes past a character if it comes next.
    pub(super) fn eat(&mut self, wanted: char) -> bool {
        let is_next = self.peek() == Some(wanted);
        if is_next {
            self.step();
        }
        is_next
    }

    /// The name that comes next, of letters, digits, `_` and `$`, not beginning with a digit.
    pub(super) fn word(&mut self) -> Option<Range<usize>> {
        let first = self.peek()?;
        (first.is_alphabetic() || "_$".contains(first))
            .then(|| self.take(|c| c.is_alphanumeric() || "_$".contains(c)))
    }

    /// What comes next up to a blank or a sign that separates; perhaps nothing.
    pub(super) fn token(&mut self) -> Range<usize> {
        self.peek();
        self.take(|c| !c.is_whitespace() && !",;:=(){}[]\"'".contains(c))
    }

    /// The same, commas between digits included: a decimal comma is to be seen, not to be cut at.
    pub(super) fn token_with_commas(&mut self) -> Range<usize> {
        let mut token = self.token();
        while self.rest().strip_prefix(',').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
        {
            self.step();
            token.end = self.token().end;
        }
        token
    }

    fn take(&mut self, within: impl Fn(char) -> bool) -> Range<usize> {
        let start = self.at;
        self.at += self.rest().find(|c| !within(c)).unwrap_or(self.rest().len());
        start..self.at
    }

    /// Goes past the next `end`, or to the end; what stands before it.
    pub(super) fn until(&mut self, end: char) -> Range<usize> {
        let span = self.take(|c| c != end);
        self.step();
        span
    }
}

/// The number in a token, finite.
pub(super) fn number(text: &str, span: Range<usize>) -> Result<f64, Fault> {
    let token = &text[span.clone()];
    token.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| {
        let shown: String = token.chars().take(40).collect();
        let found = if shown.is_empty() { "nothing".to_owned() } else { format!("`{shown}`") };
        let why = if shown.starts_with("**") { "the control has no value here; " } else { "" };
        Fault::new(format!("{found} where a coordinate is: {why}expected a finite number"), span)
    })
}

/// The point whose coordinates stand there.
pub(super) fn point(text: &str, spans: [Range<usize>; 3]) -> Result<Point3<f64>, Fault> {
    let [x, y, z] = spans.map(|span| number(text, span));
    Ok(Point3::new(x?, y?, z?))
}

/// A key with its value, and perhaps a unit: `X 1.0`, `X = 1.0 mm`, `X: 1.0`.
#[derive(Debug, Clone)]
pub(super) struct Field {
    pub(super) key: Range<usize>,
    pub(super) value: Range<usize>,
}

/// The point of fields `X`, `Y` and `Z`, each there once; `whole` is where a missing one is missed.
pub(super) fn point_of(text: &str, fields: &[Field], whole: Range<usize>) -> Result<Point3<f64>, Fault> {
    let find = |name: &str| {
        let mut named = fields.iter().filter(|field| text[field.key.clone()].eq_ignore_ascii_case(name));
        let first = named.next().ok_or_else(|| Fault::new(format!("there is no {name}"), whole.clone()))?;
        match named.next() {
            Some(second) => Err(Fault::new(format!("{name} is there twice"), second.key.clone())),
            None => Ok(first.value.clone()),
        }
    };
    point(text, [find("X")?, find("Y")?, find("Z")?])
}

/// The value of the field of this name.
pub(super) fn value_of(text: &str, fields: &[Field], name: &str) -> Option<Range<usize>> {
    let field = fields.iter().find(|field| text[field.key.clone()].eq_ignore_ascii_case(name))?;
    Some(field.value.clone())
}

/// Whether the name of a field is that of a joint: `A1`, `J6`, without its digit.
pub(super) fn joints(text: &str, fields: &[Field], letter: char) -> Option<Range<usize>> {
    let is_joint = |key: &str| {
        key.strip_prefix([letter, letter.to_ascii_lowercase()])
            .is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit()))
    };
    fields.iter().find(|field| is_joint(&text[field.key.clone()])).map(|field| field.key.clone())
}

/// The lines of a text, without their ends.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Range<usize>> + '_ {
    text.split_inclusive('\n').scan(0, |start, line| {
        let span = *start..*start + line.trim_end_matches(['\n', '\r']).len();
        *start += line.len();
        Some(span)
    })
}

/// The text with its comments, from `comment` to the end of the line, and what is quoted replaced by as many blanks.
pub(super) fn without_comments(text: &str, comment: char) -> String {
    let (mut quoted, mut commented) = (false, false);
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        if c == '\n' {
            (quoted, commented) = (false, false);
        } else if !commented && c == '"' {
            quoted = !quoted;
        } else if !quoted && c == comment {
            commented = true;
        }
        if c != '\n' && (commented || (quoted && c != '"')) {
            plain.extend(std::iter::repeat_n(' ', c.len_utf8()));
        } else {
            plain.push(c);
        }
    }
    plain
}
