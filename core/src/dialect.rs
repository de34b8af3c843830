//! Dialects: a frame in the words of the machine or program that will use it.
//!
//! A dialect prints a frame and reads it back. What is handed out is a [`Literal`]: a text that was read back, with how
//! far the frame in it is from the one that was to be told.

use std::fmt;

use nalgebra::Point3;
use thiserror::Error;

use crate::{Frame, Units};

/// How a machine or a program writes a frame.
pub trait Dialect: fmt::Debug + Send + Sync {
    /// What the numbers of its literals mean.
    fn convention(&self) -> Convention;

    /// The text to paste; lengths of the frame are in the convention's unit.
    fn print(&self, frame: &Frame) -> String;

    /// The frame that the machine will understand from a text of this form, lengths in the convention's unit; `None`
    /// when the text has another form.
    fn parse(&self, literal: &str) -> Option<Frame>;
}

/// What the numbers of a literal mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Convention {
    /// What they are relative to.
    pub parent: &'static str,
    /// Unit of its lengths; `None` when it takes the measurement's.
    pub units: Option<Units>,
    /// What its numbers of rotation are, in which unit: `degrees`.
    pub angles: &'static str,
    /// How many digits are printed.
    pub digits: String,
    /// How the numbers of rotation make the rotation.
    pub rotation: String,
    /// Where the literal goes, and what to verify on the machine.
    pub usage: &'static str,
    /// The most that printing may lose.
    pub loss: Loss,
    /// What it cannot tell, as a sentence, and what can; `None` for a dialect that can tell every frame.
    pub omission: Option<Omission>,
}

/// How far a printed frame may be from the one that was to be told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loss {
    /// Of each coordinate, in the dialect's unit.
    pub length: f64,
    /// Angle between the two, radians.
    pub angle: f64,
}

/// What a dialect has no words for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Omission {
    /// What it leaves out: `tilt`.
    pub what: &'static str,
    /// Why.
    pub reason: &'static str,
    /// Which dialects, or which setting, tell it.
    pub help: &'static str,
}

/// A frame in the words of a machine, read back and compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Literal {
    /// The text to paste, one line or several, without a line end after the last.
    pub text: String,
    /// What its numbers mean.
    pub convention: Convention,
    /// Unit of its lengths.
    pub units: Units,
    /// By how much at most it displaces a touch, in the measurement's unit: the frame read back beside the one that was
    /// to be told.
    pub rounding_loss: f64,
    /// How far the touch farthest from the fixture's origin is from it, in the measurement's unit.
    pub farthest_touch: f64,
}

impl Literal {
    /// Prints `frame` in the dialect that goes by `name`, reads it back, and tells what is lost at the points that were
    /// touched. Frame and points, both in the parent, are in `units`.
    ///
    /// # Errors
    /// [`DialectError`] when the frame is none, or what was printed reads as nothing or as another frame.
    pub fn new(
        name: &str,
        dialect: &dyn Dialect,
        frame: &Frame,
        units: Units,
        touched: &[Point3<f64>],
    ) -> Result<Self, DialectError> {
        /// Unit conversion and reading back: a few roundings, in parts of a coordinate.
        const ROUNDING: f64 = 8.0 * f64::EPSILON;
        /// The same for rotations. Angles have twice this worst case at their locks, 1.8e-12; 1 m away it is 4 pm.
        const ANGLE_ROUNDING: f64 = 4e-12;
        if !frame.is_sound() {
            return Err(DialectError::Unsound { name: name.to_owned() });
        }
        let convention = dialect.convention();
        let spoken = convention.units.unwrap_or(units);
        let scaled = |frame: &Frame, from: Units, to: Units| {
            let factor = if from == to { 1.0 } else { from.millimetres() / to.millimetres() };
            Frame { origin: frame.origin * factor, ..*frame }
        };
        let told = scaled(frame, units, spoken);
        let text = dialect.print(&told);
        let Some(read) = dialect.parse(&text).filter(Frame::is_sound) else {
            return Err(DialectError::Unreadable { name: name.to_owned(), literal: text });
        };
        let off = (read.origin - told.origin).abs().max();
        let angle = told.twist_to(&read).rotation.norm();

        let back = scaled(&read, spoken, units);
        let displaced = |point: &Point3<f64>| {
            let arm = frame.to_fixture(point).coords;
            // The difference of two points far away would lose digits.
            let turned = (back.rotation.matrix() - frame.rotation.matrix()) * arm;
            ((back.origin - frame.origin) + turned).norm()
        };
        let largest = |lengths: &mut dyn Iterator<Item = f64>| lengths.fold(0.0, f64::max);
        let rounding_loss = largest(&mut touched.iter().chain([&frame.origin]).map(displaced));
        let farthest_touch = largest(&mut touched.iter().map(|point| (point - frame.origin).norm()));

        let Loss { length: length_bound, angle: angle_bound } = convention.loss;
        let fits = off <= length_bound + ROUNDING * told.origin.coords.norm()
            && angle <= angle_bound + ANGLE_ROUNDING;
        if !fits {
            let lost = Lost {
                omission: convention.omission,
                off: off * spoken.millimetres() / units.millimetres(),
                angle,
                angle_bound,
                displacement: rounding_loss,
                farthest_touch,
                units,
            };
            return Err(DialectError::Lossy { name: name.to_owned(), lost: Box::new(lost) });
        }
        Ok(Self { text, convention, units: spoken, rounding_loss, farthest_touch })
    }
}

/// How far a literal would have been from the frame; lengths in `units`, angles in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lost {
    /// What the dialect has no words for.
    pub omission: Option<Omission>,
    /// Largest error of a coordinate of the origin.
    pub off: f64,
    /// Angle between the frame and what would be read.
    pub angle: f64,
    /// The largest that is allowed.
    pub angle_bound: f64,
    /// Largest displacement of a touch.
    pub displacement: f64,
    /// How far the touch farthest from the fixture's origin is from it.
    pub farthest_touch: f64,
    /// The measurement's unit.
    pub units: Units,
}

/// Why a frame is not told in a dialect.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DialectError {
    /// A number is not finite, or the axes are no axes.
    #[error(
        "dialect `{name}`: what is to be told is no frame: a number is not finite, or the axes are not square"
    )]
    Unsound {
        /// The dialect.
        name: String,
    },
    /// It cannot read its own words.
    #[error("dialect `{name}` cannot read back what it printed: {literal}")]
    Unreadable {
        /// The dialect.
        name: String,
        /// What it printed.
        literal: String,
    },
    /// Its words are another frame than the one to be told.
    #[error("dialect `{name}` {lost}")]
    Lossy {
        /// The dialect.
        name: String,
        /// By how much, and why.
        lost: Box<Lost>,
    },
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (angle, bound) = (self.angle.to_degrees(), self.angle_bound.to_degrees());
        let Self { off, displacement, farthest_touch, units, .. } = self;
        match self.omission {
            Some(Omission { what, reason, .. }) => write!(
                f,
                "cannot tell this frame: {reason}; its {what} of {angle:.6} degrees would be lost, {displacement:.6} \
                 {units} at the touches (the farthest is {farthest_touch:.3} {units} from the origin); bound \
                 {bound:.6} degrees"
            ),
            None => write!(
                f,
                "reads back another frame than it was told: {off:e} {units} off and turned by {angle:e} degrees, \
                 bound {bound:e} degrees"
            ),
        }
    }
}

impl DialectError {
    /// The code by which programs know it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Unsound { .. } | Self::Unreadable { .. } => "dialect-failed",
            Self::Lossy { lost, .. } if lost.omission.is_none() => "dialect-failed",
            Self::Lossy { .. } => "not-representable",
        }
    }

    /// What to do about it.
    #[must_use]
    pub fn help(&self) -> &'static str {
        match self {
            Self::Lossy { lost, .. } if let Some(omission) = lost.omission => omission.help,
            _ => "take another dialect (`matrix` loses nothing), and report this one to its author",
        }
    }
}
