//! Tables whose columns the measurement names.

use std::ops::Range;

use nalgebra::{Point3, Unit, Vector3};
use touchref_core::{direction, parameters::nearest};

use crate::{
    InputError,
    source::Source,
    table::{
        decimal,
        line::{Fields, Line},
    },
};

use super::{Fault, Importer, LoggedPoint, Reader, scan::lines};

pub(super) const IMPORTER: Importer = Importer {
    name: "csv",
    summary: "any table of points: the measurement says which columns are what",
    about: "A point is a row. `columns` says where its position is, and perhaps its name and the direction of probing or \
            the normal of the surface, by the names in the header: columns = { at = [\"X\", \"Y\", \"Z\"], name = \"Point\", \
            normal = [\"I\", \"J\", \"K\"] }; or by numbers from 1, where the table has no header. Fields are separated by \
            semicolons (then a decimal comma is accepted), tabs, commas or blanks. State `units`, `base`, and \
            `compensated` where the tip has a radius.",
    extensions: &["csv", "txt", "tsv"],
    units: None,
    frame: None,
    reference: "None: whoever exported the table knows its columns.",
    tip_centres: false,
    reader: Reader::Table(read),
};

/// Which columns of a table hold a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    /// Of x, y and z.
    pub at: [Column; 3],
    /// Of the name.
    pub name: Option<Column>,
    /// Of the direction in which the probe moved.
    pub approach: Option<[Column; 3]>,
    /// Of the normal of the surface, against which the probe moved; instead of `approach`.
    pub normal: Option<[Column; 3]>,
}

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// By its name in the header.
    Named(String),
    /// From 1, in a table without a header.
    Numbered(usize),
}

impl Columns {
    /// Only of the position.
    #[must_use]
    pub fn of(at: [Column; 3]) -> Self {
        Self { at, name: None, approach: None, normal: None }
    }

    /// Each that is stated.
    pub(super) fn all(&self) -> impl Iterator<Item = &Column> {
        let directions = self.approach.iter().chain(&self.normal).flatten();
        self.at.iter().chain(&self.name).chain(directions)
    }
}

/// The rows of a table, one split at a time.
pub(super) struct Rows<'a> {
    source: &'a Source,
    lines: Box<dyn Iterator<Item = (usize, Range<usize>)> + 'a>,
    fields: Fields,
    delimiter: u8,
}

impl<'a> Rows<'a> {
    fn new(source: &'a Source) -> Self {
        let lines = lines(source.text()).enumerate().filter(|(_, line)| {
            let text = source.text()[line.clone()].trim_start();
            !text.is_empty() && !text.starts_with('#')
        });
        let mut lines = lines.peekable();
        let first = lines.peek().map_or("", |(_, line)| &source.text()[line.clone()]);
        let delimiter =
            [b';', b'\t', b','].into_iter().find(|d| first.contains(char::from(*d))).unwrap_or(b' ');
        Self { source, lines: Box::new(lines), fields: Fields::new(delimiter), delimiter }
    }

    /// The names in the first line.
    pub(super) fn header(source: &'a Source) -> Result<Vec<String>, InputError> {
        let mut rows = Self::new(source);
        let Some(_) = rows.next_line()? else { return Ok(Vec::new()) };
        Ok((0..rows.fields.len()).map(|index| rows.fields.get(index).to_owned()).collect())
    }

    /// Splits the next line.
    fn next_line(&mut self) -> Result<Option<(Line, Range<usize>)>, InputError> {
        let Some((index, span)) = self.lines.next() else { return Ok(None) };
        let text = self.source.text()[span.clone()].to_owned();
        // Blanks at the end separate nothing.
        let text = if self.delimiter == b' ' { text.trim_end().to_owned() } else { text };
        let line = Line {
            file: self.source.name().to_owned(),
            number: index + 1,
            offset: self.source.start() + span.start,
            text,
        };
        self.fields.split(&line)?;
        Ok(Some((line, span)))
    }
}

/// The points of a table.
pub(super) fn read(source: &Source, columns: &Columns) -> Result<Vec<LoggedPoint>, InputError> {
    let mut rows = Rows::new(source);
    let named = columns.all().any(|column| matches!(column, Column::Named(_)));
    let mut width = None;
    let mut header = Vec::new();
    if named {
        let Some((line, _)) = rows.next_line()? else { return Ok(Vec::new()) };
        header = (0..rows.fields.len()).map(|index| rows.fields.get(index).to_owned()).collect();
        width = Some(header.len());
        for column in columns.all() {
            index_of(&header, column).map_err(|error| error.at(line.place()))?;
        }
    }
    let index = |column: &Column| index_of(&header, column).unwrap_or(usize::MAX);
    let (at, name) = (columns.at.each_ref().map(index), columns.name.as_ref().map(index));
    let along = columns.approach.as_ref().map(|columns| (columns.each_ref().map(index), 1.0));
    let against = columns.normal.as_ref().map(|columns| (columns.each_ref().map(index), -1.0));
    let last = columns.all().map(index).max().unwrap_or(0);
    let (mut points, mut has_decimals) = (Vec::new(), false);
    while let Some((line, span)) = rows.next_line()? {
        let found = rows.fields.len();
        let expected = *width.get_or_insert(found);
        if found != expected || last >= found {
            let message = if last >= found && found == expected {
                format!("this line has {found} fields; column {} is wanted", last + 1)
            } else {
                format!("this line has {found} fields; those before have {expected}")
            };
            let help =
                "decimal commas need semicolons between the fields; text that holds a delimiter needs quotes";
            return Err(InputError::new("invalid-input", message).with_help(help).at(line.place()));
        }
        has_decimals |= at.iter().any(|index| rows.fields.get(*index).contains('.'));
        let (position, approach) =
            match along.or(against).map(|(of, sign)| (rows.point(&line, &span, of), sign)) {
                None => (rows.point(&line, &span, at), None),
                Some((Err(fault), _)) => (Err(fault), None),
                Some((Ok(along), sign)) => match direction(along.coords * sign) {
                    None => (Err(Fault::new("the direction is zero", span.clone())), None),
                    Some(approach) => (rows.point(&line, &span, at), Some::<Unit<Vector3<f64>>>(approach)),
                },
            };
        let name = name.map(|index| rows.fields.get(index).to_owned()).filter(|name| !name.is_empty());
        points.push(LoggedPoint { approach, ..LoggedPoint::new(name, span, position) });
    }
    if !named && rows.delimiter == b',' && !has_decimals && !points.is_empty() {
        let message = "no coordinate of this table has a decimal point: are its commas decimal commas?";
        let help = "write decimal points, or semicolons between the fields";
        return Err(InputError::new("invalid-input", message)
            .with_help(help)
            .at(source.place(points[0].span.clone())));
    }
    Ok(points)
}

impl Rows<'_> {
    /// The three numbers in these columns of the line split last.
    fn point(&self, line: &Line, span: &Range<usize>, at: [usize; 3]) -> Result<Point3<f64>, Fault> {
        let number = |index: usize| {
            let text = self.fields.get(index);
            decimal(text, self.delimiter == b';').ok_or_else(|| {
                let text: String = text.chars().take(40).collect();
                let found = if text.is_empty() { "an empty field".to_owned() } else { format!("`{text}`") };
                let within = self.fields.span(line, index).unwrap_or(0..line.text.len());
                let within = span.start + within.start..span.start + within.end;
                Fault::new(format!("{found} where a coordinate is; expected a finite number"), within)
            })
        };
        let [x, y, z] = at;
        Ok(Point3::new(number(x)?, number(y)?, number(z)?))
    }
}

/// Where a column is, from 0.
fn index_of(header: &[String], column: &Column) -> Result<usize, InputError> {
    match column {
        Column::Numbered(number) => Ok(number.saturating_sub(1)),
        Column::Named(name) => {
            let mut found = header.iter().enumerate().filter(|(_, column)| *column == name);
            match (found.next(), found.next()) {
                (Some((index, _)), None) => Ok(index),
                (Some(_), Some(_)) => {
                    let message = format!("column `{name}` is there twice");
                    Err(InputError::new("invalid-input", message).with_key(name.clone()))
                }
                (None, _) => {
                    let message = format!("column `{name}` is missing; the header has {}", header.join(", "));
                    let near = nearest(name, header.iter().map(String::as_str));
                    Err(InputError::new("missing-column", message).with_nearest(near).with_key(name.clone()))
                }
            }
        }
    }
}
