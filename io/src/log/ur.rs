//! Universal Robots: poses of programs, and recorded positions of the tool.

use std::ops::Range;

use crate::{InputError, Units, source::Source};

use super::{
    Fault, Importer, LoggedPoint, Position, Reader,
    columns::{Column, Columns, Rows},
    scan::{self, Scanner, lines, without_comments},
};

pub(super) const SCRIPT: Importer = Importer {
    name: "urscript",
    summary: "Universal Robots URScript: poses name = p[x,y,z,rx,ry,rz]",
    about: "A point is a line name = p[x,y,z,rx,ry,rz], or a pose alone on its line; its name is the variable's. Metres. A \
            pose does not say of which feature it is: state it as `base`, as base or the plane's name. A pose within an \
            expression or a call is refused: it may be a waypoint; so is one of zeros only, and one farther than a robot \
            reaches (millimetres?).",
    extensions: &["script", "urscript", "variables"],
    units: Some(Units::Metre),
    frame: None,
    reference: "Universal Robots, The URScript Programming Language: pose; Real-Time Data Exchange guide: actual_TCP_pose.",
    tip_centres: true,
    reader: Reader::Program(read_script),
};

pub(super) const RECORD: Importer = Importer {
    name: "ur-rtde",
    summary: "Universal Robots positions as a table: RTDE records, ur_rtde, RoboDK",
    about: "A point is a row of a table with columns actual_TCP_pose_0 to _2, tcp_0 to _2, or TCP X (m) to TCP Z (m); \
            points have rows, no names. Metres, in the robot's base. Target positions are not taken for touches; rows of \
            zeros only, or farther than a robot reaches (millimetres?), are refused.",
    extensions: &[],
    units: Some(Units::Metre),
    frame: Some("the robot's base"),
    reference: "Universal Robots, The URScript Programming Language: pose; Real-Time Data Exchange guide: actual_TCP_pose.",
    tip_centres: true,
    reader: Reader::Record(read_record),
};

/// No robot's tool is farther from its base, in metres: numbers beyond are of another unit.
const FARTHEST: f64 = 10.0;

/// A position that is one: some number is not zero, none is beyond reach.
fn plausible(mut point: LoggedPoint, span: Range<usize>) -> LoggedPoint {
    let Position::At(at) = point.position else { return point };
    if at.coords.amax() == 0.0 {
        point.refuse("all coordinates are zero: the pose was never set", span);
    } else if at.coords.amax() > FARTHEST {
        point.refuse(
            "farther from the base than a robot reaches: poses are in metres; is this millimetres?",
            span,
        );
    }
    point
}

fn read_script(text: &str) -> Vec<LoggedPoint> {
    let text = without_comments(text, '#');
    let mut points = Vec::new();
    for line in lines(&text) {
        let mut from = line.start;
        while let Some(at) = text[from..line.end].find("p[").map(|at| from + at) {
            from = at + 2;
            let within_word = text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
            if !within_word {
                points.push(pose(&text, at, &line));
            }
        }
    }
    points
}

/// The pose that begins at `at`, in a line.
fn pose(text: &str, at: usize, line: &Range<usize>) -> LoggedPoint {
    let mut scanner = Scanner::new(text, at + 2..line.end);
    let mut numbers = vec![scanner.token()];
    while scanner.eat(',') {
        numbers.push(scanner.token());
    }
    let closed = scanner.eat(']');
    let span = at..scanner.at();
    let position = match numbers.as_slice() {
        [x, y, z, _, _, _] if closed => scan::point(text, [x.clone(), y.clone(), z.clone()]),
        _ => Err(Fault::new("expected p[x,y,z,rx,ry,rz]", span.clone())),
    };
    let before = text[line.start..at].trim();
    let name = before.strip_suffix('=').map(|name| name.trim_end_matches(':').trim());
    let name = name
        .map(|name| ["global ", "local "].iter().find_map(|word| name.strip_prefix(word)).unwrap_or(name));
    let name = name.map(str::trim).filter(|name| name.chars().all(|c| c.is_alphanumeric() || c == '_'));
    let mut point = LoggedPoint::new(name.map(str::to_owned), span.clone(), position);
    if (name.is_none() && !before.is_empty()) || scanner.peek().is_some() {
        point.refuse("a pose within an expression: it is not clear that it is a touch", span.clone());
    }
    plausible(point, span)
}

/// What the columns of a position are called.
const NAMES: [[&str; 3]; 3] = [
    ["actual_TCP_pose_0", "actual_TCP_pose_1", "actual_TCP_pose_2"],
    ["tcp_0", "tcp_1", "tcp_2"],
    ["TCP X (m)", "TCP Y (m)", "TCP Z (m)"],
];

fn read_record(source: &Source) -> Result<Vec<LoggedPoint>, InputError> {
    let columns = |names: [&str; 3]| Columns::of(names.map(|name| Column::Named(name.to_owned())));
    let header = Rows::header(source)?;
    let there = |names: &&[&str; 3]| names.iter().any(|name| header.iter().any(|column| column == name));
    let mut found = NAMES.iter().filter(there);
    let (Some(names), None) = (found.next(), found.next()) else {
        let all = NAMES.map(|names| format!("{} to {}", names[0], names[2])).join(", or ");
        let which = if NAMES.iter().any(|names| there(&names)) {
            "columns of more than one kind"
        } else {
            "no columns"
        };
        return Err(InputError::new(
            "missing-column",
            format!("the header has {which} of a position; expected {all}"),
        )
        .with_key(NAMES[0][0])
        .with_file(source.name()));
    };
    let points = super::columns::read(source, &columns(*names))?;
    Ok(points
        .into_iter()
        .map(|point| {
            let span = point.span.clone();
            plausible(point, span)
        })
        .collect())
}
