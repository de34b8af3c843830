//! DMIS: measured points of coordinate measuring machines.

use std::ops::Range;

use nalgebra::{Point3, Unit, Vector3};
use touchref_core::direction;

use crate::{InputError, Units, source::Source};

use super::{
    Fault, Importer, LoggedPoint, Reader,
    scan::{self, lines},
};

pub(super) const IMPORTER: Importer = Importer {
    name: "dmis",
    summary: "DMIS output: PTMEAS/CART and FA(name)=FEAT/POINT,CART",
    about: "A point is a statement PTMEAS/CART,x,y,z,i,j,k (it has a row) or FA(name)=FEAT/POINT,CART,x,y,z,i,j,k (its \
            name is the label). i,j,k is the normal of the surface: the probe moved against it. The unit is that of \
            UNITS/, the base the datum set recalled or defined last; state `units` and `base` where the file has \
            none. Whether the points are contact points is not told: state `compensated`. Nominal features, F(name)=, \
            are not read, and PTMEAS of a program that moves the machine (GOTO/) is refused: it says where the probe is \
            sent, not where it touched.",
    extensions: &["dmi", "dmo", "dms", "dmis"],
    units: None,
    frame: None,
    reference: "ISO 22093, Dimensional Measuring Interface Standard: UNITS, FEAT/POINT, MEAS, PTMEAS, RECALL.",
    tip_centres: false,
    reader: Reader::Record(read),
};

fn read(source: &Source) -> Result<Vec<LoggedPoint>, InputError> {
    let text = joined(source.text());
    let (mut points, mut sent) = (Vec::new(), Vec::new());
    let (mut units, mut base, mut moves) = (None, None, false);
    for line in lines(&text) {
        let indent = line.len() - text[line.clone()].trim_start().len();
        let line = line.start + indent..line.start + indent + text[line.clone()].trim().len();
        let Some(slash) = text[line.clone()].find('/') else { continue };
        let head: String = text[line.start..line.start + slash].split_whitespace().collect();
        let arguments = arguments(&text, line.start + slash + 1..line.end);
        let argument = |index: usize| arguments.get(index).map_or("", |span| &text[span.clone()]);
        let is = |index: usize, word: &str| argument(index).eq_ignore_ascii_case(word);
        let head_is = |word: &str| head.eq_ignore_ascii_case(word);
        let label = |text: &str| {
            text.split_once('(').and_then(|(_, rest)| rest.split_once(')')).map(|(l, _)| l.to_owned())
        };
        let begins =
            |word: &str| head.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
        if head_is("UNITS") {
            units = Some(unit(argument(0)).ok_or_else(|| {
                let span = arguments.first().map_or(line.clone(), Clone::clone);
                let message = format!("unit `{}` is not known; expected MM, M or INCH", argument(0));
                InputError::new("invalid-input", message).at(source.place(span))
            })?);
        } else if head_is("GOTO") {
            moves = true;
        } else if head_is("RECALL") && begins_datum(argument(0)) {
            base = label(argument(0));
        } else if begins("D(") {
            base = label(&head);
        }
        let measured = begins("FA(") && head.to_ascii_uppercase().ends_with(")=FEAT") && is(0, "POINT");
        let coordinates = match (measured, head_is("PTMEAS")) {
            (true, _) => arguments.get(1..),
            (_, true) => arguments.get(..),
            _ => continue,
        };
        let (position, approach) = match coordinates.unwrap_or(&[]) {
            [kind, coordinates @ ..] if text[kind.clone()].eq_ignore_ascii_case("CART") => {
                position(&text, coordinates, &line)
            }
            _ => (Err(Fault::new("not in Cartesian coordinates (CART)", line.clone())), None),
        };
        if head_is("PTMEAS") {
            sent.push(points.len());
        }
        let name = measured.then(|| label(&head)).flatten();
        let point = LoggedPoint::new(name, line, position);
        points.push(LoggedPoint { units, approach, base: base.clone(), ..point });
    }
    for index in sent.into_iter().filter(|_| moves) {
        let span = points[index].span.clone();
        points[index].refuse(
            "a program that moves the machine (GOTO/): PTMEAS says where the probe is sent, not where it touched",
            span,
        );
    }
    Ok(points)
}

fn begins_datum(argument: &str) -> bool {
    ["D(", "DA("]
        .iter()
        .any(|start| argument.get(..start.len()).is_some_and(|a| a.eq_ignore_ascii_case(start)))
}

fn unit(name: &str) -> Option<Units> {
    match name.to_ascii_uppercase().as_str() {
        "MM" => Some(Units::Millimetre),
        "M" => Some(Units::Metre),
        "INCH" => Some(Units::Inch),
        _ => None,
    }
}

/// The text with comments (`$$`) and what joins lines (`$` at an end) replaced by as many blanks.
fn joined(text: &str) -> String {
    let mut joined = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let code = line.find("$$").map_or(line, |at| &line[..at]);
        let goes_on = code.len() == line.len() && line.trim_end().ends_with('$');
        let kept = if goes_on { code.trim_end().strip_suffix('$').unwrap_or(code) } else { code };
        joined.push_str(kept);
        let blank = |c: char| if c == '\n' && !goes_on { "\n".to_owned() } else { " ".repeat(c.len_utf8()) };
        joined.extend(line[kept.len()..].chars().map(blank));
    }
    joined
}

/// What stands between commas, without blanks around it.
fn arguments(text: &str, part: Range<usize>) -> Vec<Range<usize>> {
    let mut start = part.start;
    let fields = text[part].split(',').map(|field| {
        let begin = start + (field.len() - field.trim_start().len());
        start += field.len() + 1;
        begin..begin + field.trim().len()
    });
    fields.collect()
}

/// Unit vectors may be written with one digit after the point; coordinates split at decimal commas are none.
const ROUNDED: f64 = 0.1;

type Found = (Result<Point3<f64>, Fault>, Option<Unit<Vector3<f64>>>);

/// The position, and the direction against the normal of the surface.
fn position(text: &str, coordinates: &[Range<usize>], line: &Range<usize>) -> Found {
    let of = |[x, y, z]: [&Range<usize>; 3]| scan::point(text, [x.clone(), y.clone(), z.clone()]);
    match coordinates {
        [x, y, z] => (of([x, y, z]), None),
        [x, y, z, i, j, k] => match of([i, j, k]) {
            Ok(normal) => match direction(-normal.coords) {
                Some(approach) if (normal.coords.norm() - 1.0).abs() < ROUNDED => {
                    (of([x, y, z]), Some(approach))
                }
                _ => (Err(Fault::new("i,j,k is no unit vector: is it a normal?", i.start..k.end)), None),
            },
            Err(fault) => (Err(fault), None),
        },
        _ => (Err(Fault::new("expected x,y,z or x,y,z,i,j,k", line.clone())), None),
    }
}
