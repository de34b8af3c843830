//! Measurement files, touch tables and records as text.

use std::{fmt::Write as _, io};

use nalgebra::{Point3, Unit, Vector3};
use serde::Serialize;
use touchref_core::{Frame, Noise, Parameters, Probe, Value};

use crate::{TouchRecord, Units, measurement::NOT_MEASURED};

/// A record (a result, an error) as JSON, the way every interface of touchref hands it out.
#[must_use]
pub fn json(record: &impl Serialize) -> String {
    // Keys are strings and numbers are plain, so that writing to memory cannot fail.
    serde_json::to_string_pretty(record).unwrap_or_default() + "\n"
}

/// One row of a touch table to write; numbers keep the digits that round-trip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row<'a> {
    /// Name of the surface.
    pub surface: &'a str,
    /// Centre of the tip, in the parent.
    pub at: Point3<f64>,
    /// What the user calls the touch; written where the table has the column.
    pub id: Option<&'a str>,
    /// The placement it belongs to; written where the table has the column.
    pub placement: Option<u64>,
}

/// Which columns a touch table has besides `surface`, `x`, `y` and `z`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Columns {
    /// `id`.
    pub id: bool,
    /// `placement`.
    pub placement: bool,
}

/// Writes a touch table row by row.
#[derive(Debug)]
pub struct TableWriter<W: io::Write> {
    writer: csv::Writer<W>,
    columns: Columns,
}

impl<W: io::Write> TableWriter<W> {
    /// Writes each of `comments` on a line of its own, then the header.
    ///
    /// # Errors
    /// Those of `output`.
    pub fn new(mut output: W, comments: &[String], columns: Columns) -> io::Result<Self> {
        for comment in comments {
            writeln!(output, "# {}", comment.replace(['\n', '\r'], " "))?;
        }
        let mut writer = csv::Writer::from_writer(output);
        let header =
            [(columns.placement, "placement"), (columns.id, "id")].into_iter().filter(|(there, _)| *there);
        let header = header.map(|(_, name)| name).chain(["surface", "x", "y", "z"]);
        writer.write_record(header).map_err(io_error)?;
        Ok(Self { writer, columns })
    }

    /// Writes a row.
    ///
    /// # Errors
    /// Those of the output.
    pub fn write(&mut self, row: &Row<'_>) -> io::Result<()> {
        self.write_fields(row).map_err(io_error)
    }

    fn write_fields(&mut self, row: &Row<'_>) -> csv::Result<()> {
        if self.columns.placement {
            self.writer.write_field(row.placement.map_or(String::new(), |number| number.to_string()))?;
        }
        if self.columns.id {
            self.writer.write_field(row.id.unwrap_or_default())?;
        }
        self.writer.write_field(row.surface)?;
        for coordinate in row.at.iter() {
            self.writer.write_field(coordinate.to_string())?;
        }
        self.writer.write_record(None::<&[u8]>)
    }

    /// Writes what is still held back.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// The error of the output itself, so that a closed pipe stays one; csv's own conversion hides its kind.
fn io_error(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// A measurement file (TOML); the touches are listed in it.
#[must_use]
pub fn measurement(
    kind: &str,
    parameters: &Parameters,
    units: Units,
    probe: &Probe,
    touches: &[TouchRecord],
) -> String {
    let mut text = head(kind, parameters, units, probe);
    for touch in touches {
        text.push_str("\n[[touch]]\n");
        if let Some(id) = &touch.id {
            line(&mut text, "id", &quoted(id));
        }
        line(&mut text, "surface", &quoted(&touch.surface));
        line(&mut text, "at", &list(touch.at.iter().copied()));
        match touch.noise {
            Noise::OfProbe => {}
            Noise::Sigma(sigma) => line(&mut text, "sigma", &number(sigma)),
            Noise::Covariance(c) => {
                let rows: Vec<String> = c.row_iter().map(|row| list(row.iter().copied())).collect();
                line(&mut text, "covariance", &format!("[{}]", rows.join(", ")));
            }
        }
        if let Some(approach) = touch.approach {
            line(&mut text, "approach", &list(approach.iter().copied()));
        }
    }
    text
}

/// A touch that is still to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct ToFill<'a> {
    /// Name of the surface.
    pub surface: &'a str,
    /// Where the tip is to meet it, in fixture coordinates.
    pub contact: Point3<f64>,
    /// Centre of the tip there, in fixture coordinates.
    pub tip: Point3<f64>,
    /// Direction of the probe's motion, in fixture coordinates.
    pub approach: Unit<Vector3<f64>>,
}

/// A measurement file (TOML) to be filled in: each touch has [`NOT_MEASURED`] in the place of what the probe will read, and
/// a comment where it is to be made. Until then the file is refused.
///
/// Approach directions are those that the touches will have in the parent, where the `frame` is known.
#[must_use]
pub fn measurement_to_fill(
    kind: &str,
    parameters: &Parameters,
    units: Units,
    probe: &Probe,
    touches: &[ToFill<'_>],
    frame: Option<&Frame>,
) -> String {
    let start = format!(
        "# Planned touches. Write the tip centre that the probe reads, in the parent, in the place of each \
         \"{NOT_MEASURED}\":\n# at = [x, y, z].\n\n"
    );
    let mut text = start + &head(kind, parameters, units, probe);
    for (index, touch) in touches.iter().enumerate() {
        text.push_str("\n[[touch]]\n");
        line(&mut text, "# touch", &index.to_string());
        line(&mut text, "# contact, in fixture coordinates", &list(touch.contact.iter().copied()));
        line(&mut text, "# tip centre, in fixture coordinates", &list(touch.tip.iter().copied()));
        line(&mut text, "# approach, in fixture coordinates", &list(touch.approach.iter().copied()));
        if let Some(frame) = frame {
            line(
                &mut text,
                "# tip centre expected in the parent",
                &list(frame.to_parent(&touch.tip).iter().copied()),
            );
        }
        line(&mut text, "surface", &quoted(touch.surface));
        line(&mut text, "at", &quoted(NOT_MEASURED));
        if let Some(frame) = frame {
            line(&mut text, "approach", &list((frame.rotation * touch.approach).iter().copied()));
        }
    }
    text
}

/// A touch table to be filled in: `x`, `y` and `z` are empty, so that it is refused until then. Where each touch is to be made
/// stands in columns that are not read; `i`, `j`, `k` and the place expected in the parent are there where the `frame` is
/// known.
///
/// # Errors
/// Those of `output`.
pub fn table_to_fill<W: io::Write>(
    output: W,
    touches: &[ToFill<'_>],
    frame: Option<&Frame>,
) -> io::Result<()> {
    const NOMINAL: [&str; 6] = ["contact_x", "contact_y", "contact_z", "tip_x", "tip_y", "tip_z"];
    const PARENT: [&str; 6] = ["i", "j", "k", "expected_x", "expected_y", "expected_z"];
    let mut writer = csv::Writer::from_writer(output);
    let known = if frame.is_some() { PARENT.as_slice() } else { &[] };
    let header = ["surface", "x", "y", "z"].iter().chain(known).chain(&NOMINAL);
    writer.write_record(header).map_err(io_error)?;
    for touch in touches {
        let mut fields = vec![touch.surface.to_owned(), String::new(), String::new(), String::new()];
        let mut push = |numbers: &[f64]| fields.extend(numbers.iter().map(f64::to_string));
        if let Some(frame) = frame {
            push((frame.rotation * touch.approach).as_slice());
            push(frame.to_parent(&touch.tip).coords.as_slice());
        }
        push(touch.contact.coords.as_slice());
        push(touch.tip.coords.as_slice());
        writer.write_record(fields).map_err(io_error)?;
    }
    writer.flush()
}

/// What stands above the touches.
fn head(kind: &str, parameters: &Parameters, units: Units, probe: &Probe) -> String {
    let mut text = format!("units = \"{units}\"\n\n[fixture]\nkind = {}\n", quoted(kind));
    for (name, value) in parameters.iter() {
        line(&mut text, name, &value_text(value));
    }
    text.push_str("\n[probe]\n");
    line(&mut text, "tip_radius", &number_text(probe.tip_radius, probe.tip_radius_u));
    if let Some(sigma) = probe.sigma {
        line(&mut text, "sigma", &number(sigma));
    }
    text
}

fn line(text: &mut String, key: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{key} = {value}");
}

fn value_text(value: &Value) -> String {
    match value {
        Value::Number { value, u } => number_text(*value, *u),
        Value::Numbers(values) => list(values.iter().copied()),
        Value::Word(word) => quoted(word),
        Value::Flag(flag) => flag.to_string(),
        Value::Words(words) => {
            format!("[{}]", words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(", "))
        }
        Value::Tables(tables) => {
            let pairs = |table: &Parameters| {
                table
                    .iter()
                    .map(|(name, value)| format!("{name} = {}", value_text(value)))
                    .collect::<Vec<_>>()
            };
            let tables = tables.iter().map(|table| format!("\n    {{ {} }},", pairs(table).join(", ")));
            format!("[{}\n]", tables.collect::<String>())
        }
        _ => quoted("?"),
    }
}

fn number_text(value: f64, u: f64) -> String {
    if u == 0.0 { number(value) } else { format!("{{ value = {}, u = {} }}", number(value), number(u)) }
}

/// A number as TOML has it, a float even where it is whole.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn list(values: impl Iterator<Item = f64>) -> String {
    format!("[{}]", values.map(number).collect::<Vec<_>>().join(", "))
}

/// A TOML basic string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::{Matrix3, Unit, Vector3};

    use super::*;
    use crate::{Measurement, TouchSource, table::TableReader};

    #[test]
    fn a_written_measurement_reads_back_the_same() {
        let parameters = Parameters::new()
            .with("radius", Value::Number { value: 15.0, u: 0.002 })
            .with("radii", [1.0, 0.1 + 0.2, 1e-300])
            .with("side", "beh\"ind\\\n")
            .with("bore", true);
        let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.001, sigma: Some(5e-5) };
        let touch = |noise, id: Option<&str>| TouchRecord {
            noise,
            approach: Some(Unit::new_unchecked(Vector3::z())),
            id: id.map(str::to_owned),
            ..TouchRecord::new("+x", Point3::new(1.0, -2e20, 1.0 / 3.0))
        };
        let touches = [
            touch(Noise::OfProbe, Some("a")),
            touch(Noise::Sigma(0.1), None),
            touch(Noise::Covariance(Matrix3::identity()), None),
        ];
        let text = measurement("k", &parameters, Units::Inch, &probe, &touches);
        let back = Measurement::from_text("m.toml", &text, Path::new("")).unwrap();
        assert_eq!((back.units, back.parameters(), back.probe), (Units::Inch, &parameters, probe));
        let TouchSource::Listed(mut listed) = back.touches else { panic!("the touches are listed") };
        for touch in &mut listed {
            touch.line = None;
        }
        assert_eq!(listed, touches);
    }

    #[test]
    fn a_written_table_reads_back_the_same() {
        let at = Point3::new(0.1 + 0.2, -1e-7, 1e30);
        let mut bytes = Vec::new();
        let columns = Columns { id: true, placement: true };
        let mut writer = TableWriter::new(&mut bytes, &["seed 1\nand".to_owned()], columns).unwrap();
        for placement in [0, 1] {
            writer.write(&Row { surface: "a,b", at, id: Some("t"), placement: Some(placement) }).unwrap();
        }
        writer.finish().unwrap();
        let table = TableReader::new(Box::new(std::io::Cursor::new(bytes)), "t", &["a,b"]).unwrap();
        let rows: Vec<TouchRecord> = table.collect::<Result<_, _>>().unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!((rows[1].at, rows[1].placement.as_deref()), (at, Some("1")));
    }
}
