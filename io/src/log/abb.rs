//! ABB RAPID modules: declared robtargets and positions.

use std::ops::Range;

use nalgebra::Point3;

use crate::Units;

use super::{
    Fault, Importer, LoggedPoint, Position, Reader,
    scan::{self, Scanner, without_comments},
};

pub(super) const IMPORTER: Importer = Importer {
    name: "abb-mod",
    summary: "ABB RAPID modules (.mod, .sys): declarations of robtarget and pos",
    about: "A point is a declaration, as CONST robtarget p1:=[[x,y,z],[q1,q2,q3,q4],[..],[..]]; or PERS pos p1:=[x,y,z];. \
            Its name is the variable's (p1), of an array's element p1{2}. Millimetres, in single precision. The file does \
            not say of which work object a target is: state it as `base`. Refused are jointtargets, 9E9, and a target \
            whose quaternion is zero: it was never taught.",
    extensions: &["mod", "modx", "sys", "prg"],
    units: Some(Units::Millimetre),
    frame: None,
    reference: "ABB Robotics, RAPID Instructions, Functions and Data types: robtarget, pos, wobjdata.",
    tip_centres: true,
    reader: Reader::Program(read),
};

/// Something a declaration is set to.
enum Value {
    Plain(Range<usize>),
    List(Range<usize>, Vec<Value>),
}

/// The deepest list in a list that a declaration of points has, and more.
const DEEPEST: usize = 8;

/// What RAPID writes where a number is not defined.
const UNDEFINED: f64 = 9e9;

fn read(text: &str) -> Vec<LoggedPoint> {
    let text = without_comments(text, '!');
    let mut scanner = Scanner::new(&text, 0..text.len());
    let mut points = Vec::new();
    while scanner.peek().is_some() {
        let Some(word) = scanner.word() else {
            if scanner.token().is_empty() {
                scanner.step();
            }
            continue;
        };
        let is = |span: &Range<usize>, name: &str| text[span.clone()].eq_ignore_ascii_case(name);
        if ["CONST", "PERS", "VAR"].iter().any(|storage| is(&word, storage))
            && let Some(kind) = scanner.word()
            && let Some(wanted) = ["robtarget", "pos", "jointtarget"].into_iter().find(|name| is(&kind, name))
        {
            declaration(&text, wanted, &mut scanner, &mut points);
        }
    }
    points
}

/// The points of a declaration, from its name on.
fn declaration(text: &str, kind: &str, scanner: &mut Scanner<'_>, points: &mut Vec<LoggedPoint>) {
    let Some(name) = scanner.word() else { return };
    let (told, is_array) = (text[name.clone()].to_owned(), scanner.eat('{'));
    if is_array {
        scanner.until('}');
    }
    if !(scanner.eat(':') && scanner.eat('=')) {
        let message = format!("`{told}` has no value: it was declared, never taught");
        let fault = Fault::new(message, name.clone());
        let point = LoggedPoint::new(Some(told), name, Err(fault.clone()));
        points.push(LoggedPoint { position: Position::Empty(fault), ..point });
        return;
    }
    let start = scanner.at();
    let value = value(scanner, 0).filter(|_| scanner.peek() == Some(';'));
    let whole = name.start..scanner.at().max(start);
    let Some(value) = value else {
        let message = format!("the value of `{told}` is not written out in numbers");
        points.push(LoggedPoint::new(Some(told), name, Err(Fault::new(message, whole))));
        return;
    };
    match value {
        Value::List(_, elements) if is_array => {
            points.extend(elements.iter().enumerate().map(|(index, element)| {
                let position = position(text, kind, element);
                LoggedPoint::new(Some(format!("{told}{{{}}}", index + 1)), element.span().clone(), position)
            }));
        }
        value => points.push(LoggedPoint::new(Some(told), name, position(text, kind, &value))),
    }
}

impl Value {
    fn span(&self) -> &Range<usize> {
        let (Self::Plain(span) | Self::List(span, _)) = self;
        span
    }
}

/// `[1,[2,3],TRUE]`, or one of its elements.
fn value(scanner: &mut Scanner<'_>, depth: usize) -> Option<Value> {
    if !scanner.eat('[') {
        let token = scanner.token();
        return (!token.is_empty()).then_some(Value::Plain(token));
    }
    if depth == DEEPEST {
        return None;
    }
    let start = scanner.at() - 1;
    let mut elements = Vec::new();
    loop {
        elements.push(value(scanner, depth + 1)?);
        if scanner.eat(']') {
            return Some(Value::List(start..scanner.at(), elements));
        }
        if !scanner.eat(',') {
            return None;
        }
    }
}

fn position(text: &str, kind: &str, value: &Value) -> Result<Point3<f64>, Fault> {
    let wrong =
        |expected: &str| Fault::new(format!("this is no {kind}; expected {expected}"), value.span().clone());
    let position = match (kind, value) {
        ("jointtarget", _) => {
            return Err(Fault::new("joint angles, not a position; record a robtarget", value.span().clone()));
        }
        ("robtarget", Value::List(_, parts)) => {
            let [position, Value::List(span, rotation), _, _] = parts.as_slice() else {
                return Err(wrong("[[x,y,z],[q1,q2,q3,q4],[..],[..]]"));
            };
            let zero = |value: &Value| matches!(value, Value::Plain(span) if text[span.clone()].parse::<f64>().is_ok_and(|v| v == 0.0));
            if rotation.iter().all(zero) {
                return Err(Fault::new("the quaternion is zero: the target was never taught", span.clone()));
            }
            position
        }
        _ => value,
    };
    let Value::List(_, coordinates) = position else { return Err(wrong("[x,y,z]")) };
    let [Value::Plain(x), Value::Plain(y), Value::Plain(z)] = coordinates.as_slice() else {
        return Err(wrong("three coordinates, [x,y,z]"));
    };
    let point = scan::point(text, [x, y, z].map(Clone::clone))?;
    if point.iter().any(|v| v.abs() >= UNDEFINED) {
        return Err(Fault::new("9E9 stands for a coordinate that is not defined", position.span().clone()));
    }
    Ok(point)
}
