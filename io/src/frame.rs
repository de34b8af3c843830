//! Frames as text: in results, and as an argument.

use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use touchref_core::Frame;

use crate::{Input, InputError, source::Source};

/// A frame as results write it: the same rotation three ways, so that no reader has to convert.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrameRecord {
    /// The fixture's origin in the parent.
    pub origin: [f64; 3],
    /// The fixture's X axis in the parent; a unit vector.
    pub x_axis: [f64; 3],
    /// The fixture's Y axis in the parent; a unit vector.
    pub y_axis: [f64; 3],
    /// The fixture's Z axis in the parent; a unit vector.
    pub z_axis: [f64; 3],
    /// Unit quaternion of the rotation fixture to parent, scalar last, `w >= 0`.
    pub quaternion_xyzw: [f64; 4],
    /// Homogeneous 4x4 matrix, rows first, that maps fixture coordinates into the parent.
    pub matrix: [[f64; 4]; 4],
}

impl From<&Frame> for FrameRecord {
    fn from(frame: &Frame) -> Self {
        let matrix = frame.matrix();
        Self {
            origin: frame.origin.into(),
            x_axis: frame.axis(0).into(),
            y_axis: frame.axis(1).into(),
            z_axis: frame.axis(2).into(),
            quaternion_xyzw: frame.quaternion_xyzw(),
            matrix: std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)])),
        }
    }
}

/// The part of a result file that a frame is read from.
#[derive(Deserialize)]
struct ResultFile {
    frame: Pose,
}

#[derive(Deserialize)]
struct Pose {
    origin: [f64; 3],
    quaternion_xyzw: [f64; 4],
}

/// Reads a frame argument: `x,y,z,qx,qy,qz,qw` (the quaternion of any length above zero), or the path of a result
/// file (JSON with `frame`).
///
/// # Errors
/// `invalid-input` or `unreadable`, saying what a frame looks like.
pub fn read_frame(argument: &str) -> Result<Frame, InputError> {
    const EXPECTED: &str = "a frame is x,y,z,qx,qy,qz,qw or a result file (the JSON of `touchref locate`)";
    let fields: Vec<&str> = argument.split(',').map(str::trim).collect();
    let numbers = fields.iter().map(|field| field.parse()).collect::<Result<Vec<f64>, _>>();
    let pose = match numbers {
        Ok(numbers) => match numbers.as_slice() {
            &[x, y, z, qx, qy, qz, qw] => Pose { origin: [x, y, z], quaternion_xyzw: [qx, qy, qz, qw] },
            other => {
                let message = format!("`{argument}` has {} numbers; a frame has seven", other.len());
                return Err(InputError::new("invalid-input", message).with_help(EXPECTED));
            }
        },
        Err(_) if fields.len() == 7 => {
            let wrong = fields.iter().find(|field| field.parse::<f64>().is_err()).unwrap_or(&"");
            let message = format!("`{wrong}` in `{argument}` is not a number");
            return Err(InputError::new("invalid-input", message).with_help(EXPECTED));
        }
        Err(_) => from_result_file(argument).map_err(|error| error.with_help(EXPECTED))?,
    };
    let [x, y, z] = pose.origin;
    Frame::from_quaternion_xyzw(Point3::new(x, y, z), pose.quaternion_xyzw).ok_or_else(|| {
        InputError::new(
            "invalid-input",
            format!("the frame `{argument}` has no rotation, or a number is not finite"),
        )
        .with_help(EXPECTED)
    })
}

fn from_result_file(path: &str) -> Result<Pose, InputError> {
    let source = Source::read(&Input::File(path.into()))?;
    let result: ResultFile = serde_json::from_str(source.text()).map_err(|error| {
        InputError::new("invalid-input", format!("{path} is not a result file: {error}")).with_file(path)
    })?;
    Ok(result.frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_of_seven_numbers() {
        let frame = read_frame("1, 2,3, 0,0,2,2").unwrap();
        assert_eq!(frame.origin, Point3::new(1.0, 2.0, 3.0));
        assert!((frame.axis(0) - nalgebra::Vector3::y()).norm() < 1e-15);
    }

    #[test]
    fn what_is_no_frame_is_refused() {
        for (text, message) in [
            ("1,2,3", "seven"),
            ("1,2,3,0,0,0,0", "no rotation"),
            ("1,2,nan,0,0,0,1", "finite"),
            ("1,2,x,0,0,0,1", "`x`"),
            ("no-such-file.json", "cannot read"),
            ("", "cannot read"),
        ] {
            let error = read_frame(text).unwrap_err();
            assert!(error.to_string().contains(message), "{error}");
        }
    }
}
