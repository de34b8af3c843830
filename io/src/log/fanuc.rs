//! FANUC programs (`.LS`) and position registers (`POSREG.VA`).

use std::ops::Range;

use crate::{InputError, Units, source::Source};

use super::{
    Fault, Importer, LoggedPoint, Position, Reader,
    scan::{self, Field, Scanner, lines},
};

pub(super) const PROGRAM: Importer = Importer {
    name: "fanuc-ls",
    summary: "FANUC programs as text (.LS): the positions of the section /POS, with their UF and UT",
    about: "A point is P[n] in the section /POS; its name is P[1], whatever its comment. Its base is UF, its tool UT. \
            Millimetres. Refused are joint angles, values that are stars (uninitialised), and a point with positions of \
            two motion groups.",
    extensions: &["ls"],
    units: Some(Units::Millimetre),
    frame: None,
    reference: "FANUC, Operator's Manual: programs as text (.LS); position registers as text (POSREG.VA).",
    tip_centres: true,
    reader: Reader::Record(read_program),
};

pub(super) const REGISTERS: Importer = Importer {
    name: "fanuc-posreg",
    summary: "FANUC position registers as text (POSREG.VA)",
    about: "A point is a position register; its name is PR[1], of another motion group PR[2,1]. Millimetres. The file \
            does not say in which user frame a register was recorded: state it as `base`. Registers without a value \
            need not be ignored; joint angles and stars are refused.",
    extensions: &["va"],
    units: Some(Units::Millimetre),
    frame: None,
    reference: "FANUC, Operator's Manual: programs as text (.LS); position registers as text (POSREG.VA).",
    tip_centres: true,
    reader: Reader::Program(read_registers),
};

fn read_program(source: &Source) -> Result<Vec<LoggedPoint>, InputError> {
    let text = source.text();
    let mut all = lines(text).skip_while(|line| !text[line.clone()].trim().eq_ignore_ascii_case("/POS"));
    let Some(header) = all.next() else {
        let message = "there is no section /POS; expected a program saved as text (.LS)";
        return Err(InputError::new("invalid-input", message).with_file(source.name()));
    };
    let body = all.take_while(|line| !text[line.clone()].trim().eq_ignore_ascii_case("/END"));
    let end = body.last().map_or(header.end, |line| line.end);
    let mut points = Vec::new();
    let mut scanner = Scanner::new(text, header.end..end);
    while scanner.peek().is_some() {
        let start = scanner.at();
        if !text[start..].starts_with("P[") {
            scanner.until('\n');
            continue;
        }
        scanner.until('[');
        let number = scanner.token();
        let name = format!("P[{}]", &text[number]);
        // The comment may hold any sign.
        if scanner.eat(':') && scanner.eat('"') {
            scanner.until('"');
        }
        scanner.until(']');
        let head = start..scanner.at();
        scanner.until('{');
        let groups = scanner.until('}');
        points.push(of_groups(text, name, head, groups));
    }
    Ok(points)
}

/// A point of a program, from what stands between its braces.
fn of_groups(text: &str, name: String, span: Range<usize>, body: Range<usize>) -> LoggedPoint {
    let fields = fields(text, body);
    let is_group = |field: &Field| {
        let key = &text[field.key.clone()];
        key.len() > 2 && key.is_char_boundary(2) && key[..2].eq_ignore_ascii_case("GP")
    };
    let mut groups = fields.split(is_group).skip(usize::from(fields.first().is_some_and(is_group)));
    let first = groups.next().unwrap_or(&[]);
    let mut point = LoggedPoint::new(Some(name), span.clone(), position(text, first, span));
    let unit_of = |axis| {
        scan::value_of(text, first, axis).map(|value| Scanner::new(text, value.end..text.len()).token())
    };
    let other = ["X", "Y", "Z"].into_iter().filter_map(unit_of).find(|unit| &text[unit.clone()] != "mm");
    if let Some(unit) = other {
        point.refuse(format!("`{}` where the unit is; expected mm", &text[unit.clone()]), unit);
    }
    if let Some(second) = groups.find_map(|group| scan::value_of(text, group, "X")) {
        point.refuse("two motion groups have a position here: it is not clear whose touch it is", second);
    }
    if let Some(frame) = scan::value_of(text, first, "UF") {
        point.set_number(text, "UF", frame, |point| &mut point.base);
    }
    if let Some(tool) = scan::value_of(text, first, "UT") {
        point.set_number(text, "UT", tool, |point| &mut point.tool);
    }
    point
}

fn position(text: &str, fields: &[Field], span: Range<usize>) -> Result<nalgebra::Point3<f64>, Fault> {
    if let Some(joint) = scan::joints(text, fields, 'J') {
        return Err(Fault::new("joint angles, not a position; record it in Cartesian form", joint));
    }
    scan::point_of(text, fields, span)
}

/// Fields `KEY = 1.0 mm`, `KEY : 1`, `KEY: 1`; a `GP1:` has the value before the next key, if any.
fn fields(text: &str, part: Range<usize>) -> Vec<Field> {
    let mut scanner = Scanner::new(text, part);
    let mut fields = Vec::new();
    while scanner.peek().is_some() {
        let Some(key) = scanner.word() else {
            if scanner.eat('\'') {
                scanner.until('\'');
            } else if scanner.token().is_empty() {
                scanner.step();
            }
            continue;
        };
        if scanner.eat(':') || scanner.eat('=') {
            // `GP1:` has fields of its own instead of a value.
            let is_group = text[key.clone()].to_ascii_uppercase().starts_with("GP");
            let value = if is_group { key.end..key.end } else { scanner.token_with_commas() };
            fields.push(Field { key, value });
        }
    }
    fields
}

fn read_registers(text: &str) -> Vec<LoggedPoint> {
    let heads: Vec<(Range<usize>, Register)> =
        lines(text).filter_map(|line| Some((line.clone(), register(text, line)?))).collect();
    let mut points = Vec::new();
    for (index, (_, head)) in heads.iter().enumerate() {
        let next = heads.get(index + 1).map_or(text.len(), |(line, _)| line.start);
        // A variable that follows the registers begins with its program's name.
        let end = text[head.rest..next].find("\n[").map_or(next, |at| head.rest + at);
        let fields = fields(text, head.rest..end);
        let name = head.name.clone();
        let mut point =
            LoggedPoint::new(Some(name), head.span.clone(), position(text, &fields, head.span.clone()));
        if text[head.rest..end].trim_start().starts_with("Uninitialized") {
            let message = format!("{} is uninitialised: nothing was recorded in it", head.name);
            point.position = Position::Empty(Fault::new(message, head.span.clone()));
        }
        points.push(point);
    }
    points
}

/// The head of a register.
struct Register {
    name: String,
    span: Range<usize>,
    /// Where its values begin.
    rest: usize,
}

/// The head on a line, as `[1,2] = 'touch 2'  Group: 1`.
fn register(text: &str, line: Range<usize>) -> Option<Register> {
    let mut scanner = Scanner::new(text, line.clone());
    if !scanner.eat('[') {
        return None;
    }
    let start = scanner.at() - 1;
    let group: u32 = {
        let token = scanner.token();
        scanner.slice(&token).parse().ok()?
    };
    if !scanner.eat(',') {
        return None;
    }
    let number: u32 = {
        let token = scanner.token();
        scanner.slice(&token).parse().ok()?
    };
    if !scanner.eat(']') {
        return None;
    }
    let span = start..scanner.at();
    if !scanner.eat('=') {
        return None;
    }
    // A comment may hold quotes of its own.
    let rest = text[scanner.at()..line.end].rfind('\'').map_or(scanner.at(), |at| scanner.at() + at + 1);
    let name = if group == 1 { format!("PR[{number}]") } else { format!("PR[{group},{number}]") };
    Some(Register { name, span, rest })
}
