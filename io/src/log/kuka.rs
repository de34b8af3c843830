//! KUKA data lists (`.dat`): taught points, and the frames that were active.

use std::ops::Range;

use crate::Units;

use super::{
    Fault, Importer, LoggedPoint, Position, Reader,
    scan::{self, Field, Scanner, lines, without_comments},
};

pub(super) const IMPORTER: Importer = Importer {
    name: "kuka-dat",
    summary: "KUKA data lists (.dat): E6POS, POS and FRAME, with BASE_NO and TOOL_NO of their FDAT",
    about: "A point is a declaration or an element with X, Y and Z, as DECL E6POS XP1={X 1.0,Y 2.0,Z 3.0,...}; its \
            name is the variable's (XP1, TOUCH[2]). Base and tool are those of its FDAT (FP1). Millimetres. Refused are \
            joint angles (E6AXIS), a base or tool of -1, and points taught with an external tool (IPO_FRAME #TCP).",
    extensions: &["dat"],
    units: Some(Units::Millimetre),
    frame: None,
    reference: "KUKA Roboter, KUKA System Software, Operating and Programming Instructions: data lists, E6POS, FDAT.",
    tip_centres: true,
    reader: Reader::Program(read),
};

const POINT_TYPES: [&str; 3] = ["E6POS", "POS", "FRAME"];
const JOINT_TYPES: [&str; 2] = ["E6AXIS", "AXIS"];

/// A variable that a line declares or sets.
struct Variable {
    kind: Option<String>,
    name: Range<usize>,
    /// With its index.
    whole: Range<usize>,
    indexed: bool,
    fields: Option<Result<Vec<Field>, Fault>>,
}

fn read(text: &str) -> Vec<LoggedPoint> {
    let text = without_comments(text, ';');
    let (mut points, mut frames) = (Vec::new(), Vec::new());
    for line in lines(&text) {
        let Some(variable) = variable(&text, line) else { continue };
        match variable.kind.as_deref() {
            Some("FDAT") => frames.push(variable),
            Some(kind) if POINT_TYPES.contains(&kind) || JOINT_TYPES.contains(&kind) => {
                points.extend(point(&text, &variable));
            }
            // An element of an array, whose type stands elsewhere.
            None if variable.indexed => points.extend(point(&text, &variable)),
            _ => {}
        }
    }
    for frame in &frames {
        add_frame(&text, frame, &mut points);
    }
    points
}

/// The variable of a line, if it has one: `[DECL] [GLOBAL] TYPE NAME[..]={..}`.
fn variable(text: &str, line: Range<usize>) -> Option<Variable> {
    let mut scanner = Scanner::new(text, line);
    let mut words = Vec::new();
    while let Some(word) = scanner.word() {
        words.push(word);
    }
    let name = words.pop()?;
    let kind = words.last().map(|word| text[word.clone()].to_ascii_uppercase());
    let indexed = scanner.eat('[');
    if indexed {
        scanner.until(']');
    }
    let whole = name.start..scanner.at().max(name.end);
    let fields = (scanner.eat('=') && scanner.eat('{')).then(|| fields(&mut scanner));
    Some(Variable { kind, name, whole, indexed, fields })
}

/// The fields of an aggregate after its brace: `X 1.0,S 2,POINT2[] " "}`, perhaps after its type, `E6POS: X 1.0}`.
fn fields(scanner: &mut Scanner<'_>) -> Result<Vec<Field>, Fault> {
    let start = scanner.at();
    let mut fields = Vec::new();
    while let Some(mut key) = scanner.word() {
        if scanner.eat(':') {
            let Some(first) = scanner.word() else { break };
            key = first;
        }
        while scanner.eat('[') || scanner.eat(']') {}
        fields.push(Field { key, value: scanner.token() });
        if scanner.eat('"') {
            scanner.until('"');
        }
        if scanner.eat('}') {
            return Ok(fields);
        }
        if !scanner.eat(',') {
            break;
        }
    }
    // A decimal comma would end up here: what follows it is no name.
    Err(Fault::new("not written as {X 1.0,Y 2.0,Z 3.0,...}", start..scanner.at()))
}

fn point(text: &str, variable: &Variable) -> Option<LoggedPoint> {
    let name = text[variable.whole.clone()].split_whitespace().collect::<String>();
    let Some(fields) = &variable.fields else {
        // The size of an array; its elements have lines of their own.
        if variable.indexed {
            return None;
        }
        let message = format!("`{name}` has no value: it was declared, never taught");
        let mut point =
            LoggedPoint::new(Some(name), variable.whole.clone(), Err(Fault::new("", variable.whole.clone())));
        point.position = Position::Empty(Fault::new(message, variable.whole.clone()));
        return Some(point);
    };
    let fields = match fields {
        Ok(fields) => fields,
        // Of an array of another type it is none of ours.
        Err(_) if variable.kind.is_none() => return None,
        Err(fault) => return Some(LoggedPoint::new(Some(name), variable.whole.clone(), Err(fault.clone()))),
    };
    let has = |name: &str| scan::value_of(text, fields, name).is_some();
    let position = if let Some(joint) = scan::joints(text, fields, 'A') {
        Err(Fault::new(format!("`{name}` holds joint angles, not a position; store it as E6POS"), joint))
    } else if variable.kind.is_none() && !["X", "Y", "Z"].iter().any(|axis| has(axis)) {
        return None;
    } else {
        scan::point_of(text, fields, variable.whole.clone())
    };
    Some(LoggedPoint::new(Some(name), variable.whole.clone(), position))
}

/// Tells the point of an FDAT (`FP1` of `XP1`) which base and tool were active.
fn add_frame(text: &str, frame: &Variable, points: &mut [LoggedPoint]) {
    let (Some(fields), Some(of)) = (&frame.fields, text[frame.name.clone()].get(1..)) else { return };
    let (fields, fault) = match fields {
        Ok(fields) => (fields.as_slice(), None),
        Err(fault) => (&[][..], Some(fault)),
    };
    let is_its_own = |point: &&mut LoggedPoint| {
        let name = point.name.as_deref().and_then(|name| name.get(1..));
        name.is_some_and(|name| name.eq_ignore_ascii_case(of))
    };
    for point in points.iter_mut().filter(is_its_own) {
        if let Some(Fault { message, span }) = fault {
            point.refuse(message, span.clone());
        }
        if let Some(kind) = scan::value_of(text, fields, "IPO_FRAME")
            && text[kind.clone()].eq_ignore_ascii_case("#TCP")
        {
            point.refuse("the tool stood still (IPO_FRAME #TCP): the position is that of a workpiece", kind);
        }
        if let Some(base) = scan::value_of(text, fields, "BASE_NO") {
            point.set_number(text, "BASE_NO", base, |point| &mut point.base);
        }
        if let Some(tool) = scan::value_of(text, fields, "TOOL_NO") {
            point.set_number(text, "TOOL_NO", tool, |point| &mut point.tool);
        }
    }
}
