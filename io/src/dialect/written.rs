//! Dialects that are a text with numbers in it: nearly all.

use nalgebra::{Point3, Rotation3, Vector3};
use touchref_core::{
    Convention, Dialect, Frame, Loss, ParameterError, ParameterKind, ParameterSpec, Parameters, Units,
    dialect::Omission, parameters::Fault,
};

use super::angles::Order;
use crate::number::fixed;

/// A literal of one form of text: three coordinates and the numbers of a rotation, each at its place.
#[derive(Debug, Clone)]
pub(super) struct Written {
    /// The text. `#x #y #z` are the coordinates, `#a #b #c #d` the numbers of the rotation in the order of its form;
    /// `#+x` is a coordinate with its sign always written.
    pub(super) pattern: String,
    /// Unit of the coordinates; `None` for the measurement's.
    pub(super) units: Option<Units>,
    /// Digits after the point of coordinates, and of the numbers of rotation.
    pub(super) decimals: [usize; 2],
    /// Form of the rotation.
    pub(super) rotation: Form,
    /// What it is relative to.
    pub(super) parent: &'static str,
    /// Where it goes.
    pub(super) usage: &'static str,
}

/// Numbers that make a rotation.
#[derive(Debug, Clone, Copy)]
pub(super) enum Form {
    /// Three angles, by the names that they have on the machine.
    Angles {
        /// About which axes.
        order: Order,
        /// Whether the axes stay where they are: the first named turns first, about the parent's axes.
        fixed: bool,
        /// Their names, in the order in which they turn.
        names: [&'static str; 3],
        /// Radians instead of degrees.
        radians: bool,
    },
    /// Unit quaternion x, y, z, w, with w >= 0.
    QuaternionXyzw,
    /// Axis times angle in radians, at most pi.
    RotationVector,
    /// One angle about Z, degrees; more than `tilt` radians between the Z axes cannot be told.
    AboutZ {
        /// The largest tilt that may be left out, radians.
        tilt: f64,
    },
}

impl Form {
    /// Three angles in degrees about moving axes.
    pub(super) const fn moving(order: Order, names: [&'static str; 3]) -> Self {
        Self::Angles { order, fixed: false, names, radians: false }
    }

    /// The numbers as printed: `a`, `b`, `c`, `d`.
    fn numbers(self, frame: &Frame) -> [f64; 4] {
        let rotation = &frame.rotation;
        match self {
            Self::Angles { order, fixed, radians, .. } => {
                let moving = if fixed { order.reversed() } else { order };
                let mut angles = moving.angles(rotation);
                if fixed {
                    angles.reverse();
                }
                let [a, b, c] = if radians { angles } else { angles.map(f64::to_degrees) };
                [a, b, c, 0.0]
            }
            Self::QuaternionXyzw => frame.quaternion_xyzw(),
            Self::RotationVector => {
                let v = frame.rotation_vector();
                [v.x, v.y, v.z, 0.0]
            }
            // Of all turns about Z the nearest; what is left is the tilt.
            Self::AboutZ { .. } => {
                let turn = (rotation[(1, 0)] - rotation[(0, 1)]).atan2(rotation[(0, 0)] + rotation[(1, 1)]);
                [turn.to_degrees(), 0.0, 0.0, 0.0]
            }
        }
    }

    fn frame(self, origin: Point3<f64>, numbers: [f64; 4]) -> Option<Frame> {
        let [a, b, c, _] = numbers;
        let rotation = match self {
            Self::Angles { order, fixed, radians, .. } => {
                let [a, b, c] = if radians { [a, b, c] } else { [a, b, c].map(f64::to_radians) };
                if fixed { order.reversed().rotation([c, b, a]) } else { order.rotation([a, b, c]) }
            }
            Self::QuaternionXyzw => return Frame::from_quaternion_xyzw(origin, numbers),
            Self::RotationVector => Rotation3::from_scaled_axis(Vector3::new(a, b, c)),
            Self::AboutZ { .. } => Rotation3::from_axis_angle(&Vector3::z_axis(), a.to_radians()),
        };
        Some(Frame { rotation, origin })
    }

    /// The largest angle, radians, by which numbers that are each rounded to a whole multiple of `step` turn.
    fn loss(self, step: f64) -> f64 {
        let half = 0.5 * step;
        match self {
            // Each angle turns by what it loses.
            Self::Angles { radians: true, .. } => 3.0 * half,
            Self::Angles { .. } => 3.0 * half.to_radians(),
            // Twice the distance of two unit quaternions; that of the rounded one is half a diagonal of a cube in four dimensions.
            Self::QuaternionXyzw => 2.0 * 2.0 * half,
            // The map from rotation vectors to rotations stretches nothing.
            Self::RotationVector => 3_f64.sqrt() * half,
            Self::AboutZ { tilt } => tilt + half.to_radians(),
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::Angles { radians: false, .. } | Self::AboutZ { .. } => "degrees",
            Self::Angles { .. } => "radians",
            Self::QuaternionXyzw => "unit quaternion",
            Self::RotationVector => "rotation vector in radians",
        }
    }

    /// How the numbers make the rotation, in words.
    fn words(self) -> String {
        match self {
            Self::Angles { order, fixed, names, .. } => {
                let axes = order.axes().map(|axis| ["X", "Y", "Z"][axis]);
                let [i, j, k] = axes;
                let [a, b, c] = names;
                let product = |order: [usize; 3]| {
                    let factors = order.map(|n| format!("R{}({})", axes[n].to_lowercase(), names[n]));
                    factors.join(" ")
                };
                let (sentence, product, free) = if fixed {
                    let sentence =
                        format!("{a} about the parent's {i}, then {b} about its {j}, then {c} about its {k}");
                    (sentence, product([2, 1, 0]), if order.is_proper() { c } else { a })
                } else {
                    let sentence = format!(
                        "{a} about {i}, then {b} about the {j} so reached, then {c} about the {k} so reached"
                    );
                    (sentence, product([0, 1, 2]), if order.is_proper() { a } else { c })
                };
                let lock = if order.is_proper() { "0 or 180" } else { "+-90" };
                format!("{sentence}: {product}; where {b} is {lock} degrees, {free} is 0")
            }
            Self::QuaternionXyzw => "quaternion with w >= 0".to_owned(),
            Self::RotationVector => "axis times angle, the angle from 0 to pi".to_owned(),
            Self::AboutZ { .. } => "one angle about Z, counterclockwise".to_owned(),
        }
    }

    fn omission(self) -> Option<Omission> {
        match self {
            Self::AboutZ { .. } => Some(Omission {
                what: "tilt",
                reason: "its work offset turns about Z only",
                help: "level the fixture; or take a dialect that tells a tilt (`linuxcnc-g68`, `fanuc-cnc`, `heidenhain`, \
                       `siemens`, `matrix`); or allow a small tilt to be lost, `linuxcnc:tilt=DEGREES`",
            }),
            _ => None,
        }
    }
}

impl Dialect for Written {
    fn convention(&self) -> Convention {
        let [length, rotation] = self.decimals;
        let step = |decimals: usize| 10f64.powi(-i32::try_from(decimals).unwrap_or(i32::MAX));
        Convention {
            parent: self.parent,
            units: self.units,
            angles: self.rotation.unit(),
            digits: format!("{length} decimals of lengths, {rotation} of rotations"),
            rotation: self.rotation.words(),
            usage: self.usage,
            loss: Loss { length: 0.5 * step(length), angle: self.rotation.loss(step(rotation)) },
            omission: self.rotation.omission(),
        }
    }

    fn print(&self, frame: &Frame) -> String {
        let numbers = self.rotation.numbers(frame);
        let [length, rotation] = self.decimals;
        let angle = |value: f64| match self.rotation.unit() {
            "degrees" => degrees(value, rotation),
            _ => fixed(value, rotation),
        };
        let mut text = String::new();
        for piece in pieces(&self.pattern) {
            match piece {
                Piece::Text(part) => text.push_str(part),
                Piece::Number { signed, slot } => {
                    let number = match slot {
                        Slot::Length(index) => fixed(frame.origin[index], length),
                        Slot::Rotation(index) => angle(numbers[index]),
                    };
                    if signed && !number.starts_with('-') {
                        text.push('+');
                    }
                    text.push_str(&number);
                }
            }
        }
        text
    }

    fn parse(&self, literal: &str) -> Option<Frame> {
        let (mut origin, mut numbers) = (Point3::origin(), [0.0; 4]);
        let literal = spaced(literal);
        let mut rest = literal.as_str();
        for piece in pieces(&spaced(&self.pattern)) {
            match piece {
                Piece::Text(part) => rest = rest.strip_prefix(part)?,
                Piece::Number { slot, .. } => {
                    let end =
                        rest.find(|c: char| !matches!(c, '0'..='9' | '+' | '-' | '.')).unwrap_or(rest.len());
                    let number: f64 = rest[..end].parse().ok()?;
                    rest = &rest[end..];
                    match slot {
                        Slot::Length(index) => origin[index] = number,
                        Slot::Rotation(index) => numbers[index] = number,
                    }
                }
            }
        }
        if rest.is_empty() { self.rotation.frame(origin, numbers) } else { None }
    }
}

/// Part of a pattern.
enum Piece<'a> {
    Text(&'a str),
    Number { signed: bool, slot: Slot },
}

/// Which number.
#[derive(Clone, Copy)]
enum Slot {
    Length(usize),
    Rotation(usize),
}

/// The parts of a pattern, in their order.
fn pieces(pattern: &str) -> impl Iterator<Item = Piece<'_>> {
    let mut rest = pattern;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let number = rest.strip_prefix('#').and_then(|after| {
            let (signed, after) = after.strip_prefix('+').map_or((false, after), |after| (true, after));
            let slot = match after.bytes().next()? {
                letter @ b'x'..=b'z' => Slot::Length(usize::from(letter - b'x')),
                letter @ b'a'..=b'd' => Slot::Rotation(usize::from(letter - b'a')),
                _ => return None,
            };
            Some((Piece::Number { signed, slot }, &after[1..]))
        });
        let (piece, after) = number.unwrap_or_else(|| {
            let end = rest[1..].find('#').map_or(rest.len(), |at| at + 1);
            (Piece::Text(&rest[..end]), &rest[end..])
        });
        rest = after;
        Some(piece)
    })
}

/// The same text, each run of blanks and line ends a single blank.
fn spaced(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// An angle in `(-180, 180]` with so many digits after the point: what rounds to -180 is 180.
fn degrees(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    match text.strip_prefix('-') {
        Some(half_turn) if half_turn == fixed(180.0, decimals) => half_turn.to_owned(),
        _ => text,
    }
}

/// A parameter that is the name of a variable.
pub(super) const fn name(default: &'static str, meaning: &'static str) -> ParameterSpec {
    word("name", default, meaning)
}

/// A parameter that is the number of a frame in the machine's memory.
pub(super) const fn number(meaning: &'static str) -> ParameterSpec {
    word("number", "1", meaning)
}

/// A parameter that is a word.
pub(super) const fn word(name: &'static str, default: &'static str, meaning: &'static str) -> ParameterSpec {
    ParameterSpec { name, kind: ParameterKind::Name, default: Some(default), meaning }
}

/// The parameter of this name, a letter followed by letters, digits and `_`, and whatever `more` allows beside.
///
/// # Errors
/// When it has other characters: the machine would not take it.
pub(super) fn variable<'a>(
    parameters: &'a Parameters,
    name: &'static str,
    more: &str,
) -> Result<&'a str, ParameterError> {
    let word = parameters.word(name);
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || more.contains(c);
    let begins = word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_' || more.contains(c));
    if begins && word.chars().all(allowed) {
        return Ok(word);
    }
    let marks: Vec<String> = "_".chars().chain(more.chars()).map(|c| format!("`{c}`")).collect();
    Err(wrong(name, word, format!("a letter, then letters, digits, {}", marks.join(", "))))
}

/// The parameter `number`.
///
/// # Errors
/// When it is no whole number that the machine counts by, `from` to `to`.
pub(super) fn whole(parameters: &Parameters, from: u32, to: u32) -> Result<u32, ParameterError> {
    let word = parameters.word("number");
    word.parse()
        .ok()
        .filter(|number| (from..=to).contains(number))
        .ok_or_else(|| wrong("number", word, format!("a whole number from {from} to {to}")))
}

fn wrong(name: &str, word: &str, expected: String) -> ParameterError {
    let problem = format!("is `{word}`");
    ParameterError { name: name.to_owned(), problem, expected, nearest: None, fault: Fault::Wrong }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_negative_zero_and_no_minus_180() {
        assert_eq!((fixed(-0.000_4, 3), fixed(-1.25, 1)), ("0.000".to_owned(), "-1.2".to_owned()));
        assert_eq!((degrees(-179.999_9, 3), degrees(-179.9, 1)), ("180.000".to_owned(), "-179.9".to_owned()));
        assert_eq!(fixed(1e-30, 3), "0.000");
        assert_eq!(fixed(1e20, 1), "100000000000000000000.0");
    }

    fn kuka() -> Written {
        Written {
            pattern: "{X #x,Y #y,Z #+z,A #a,B #b,C #c}".to_owned(),
            units: None,
            decimals: [1, 1],
            rotation: Form::moving(Order::ZYX, ["A", "B", "C"]),
            parent: "",
            usage: "",
        }
    }

    #[test]
    fn what_has_another_form_is_not_read() {
        let text = kuka().print(&Frame::identity());
        assert_eq!(text, "{X 0.0,Y 0.0,Z +0.0,A 0.0,B 0.0,C 0.0}");
        assert_eq!(kuka().parse(&text), Some(Frame::identity()));
        assert_eq!(kuka().parse("{X 0.0,Y\n   0.0,Z +0.0,A 0.0,B 0.0,C 0.0}\n"), Some(Frame::identity()));
        for wrong in [
            "",
            "{X 0.0",
            &text[1..],
            &format!("{text};"),
            &text.replace("0.0,", "-,"),
            &text.replace('A', "D"),
        ] {
            assert_eq!(kuka().parse(wrong), None, "{wrong}");
        }
    }
}
