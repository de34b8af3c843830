//! Values of Python as parameters of plugins and as frames.

use nalgebra::{Matrix4, Point3, UnitQuaternion, Vector3};
use pyo3::{
    prelude::*,
    types::{PyBool, PyDict, PyString},
};
use touchref::{Frame, Parameters, Value, io::InputError};

use crate::errors::Failure;

/// Tables in tables that no plugin has: a list that holds itself would have no end.
const MOST_NESTED: usize = 16;

/// Named values of a `dict`.
///
/// # Errors
/// `invalid-input` for a value that no parameter can have.
pub(crate) fn parameters(given: &Bound<'_, PyDict>) -> Result<Parameters, Failure> {
    named(given, "", 0)
}

fn named(given: &Bound<'_, PyDict>, within: &str, nested: usize) -> Result<Parameters, Failure> {
    let mut parameters = Parameters::new();
    for (name, value) in given {
        let name: String = name.extract()?;
        let value = self::value(&value, &format!("{within}{name}"), nested)?;
        parameters.set(&name, value);
    }
    Ok(parameters)
}

/// One value: a number, one with its uncertainty (by the names `value` and `u`), a text, a truth value, or a sequence.
fn value(given: &Bound<'_, PyAny>, name: &str, nested: usize) -> Result<Value, Failure> {
    if let Ok(flag) = given.cast::<PyBool>() {
        return Ok(flag.is_true().into());
    }
    if let Ok(text) = given.cast::<PyString>() {
        return Ok(text.extract::<String>()?.as_str().into());
    }
    if let Ok(table) = given.cast::<PyDict>() {
        let number = |key| table.get_item(key).ok().flatten().and_then(|number| number.extract::<f64>().ok());
        if let (2, Some(value), Some(u)) = (table.len(), number("value"), number("u")) {
            return Ok(Value::Number { value, u });
        }
        return Err(wrong(given, name));
    }
    if let Ok(value) = given.extract::<f64>() {
        return Ok(value.into());
    }
    // What has a value and its uncertainty by these names.
    if let (Ok(value), Ok(u)) = (given.getattr("value"), given.getattr("u")) {
        let told = |_| wrong(given, name);
        return Ok(Value::Number { value: value.extract().map_err(told)?, u: u.extract().map_err(told)? });
    }
    if let Ok(numbers) = given.extract::<Vec<f64>>() {
        return Ok(Value::Numbers(numbers));
    }
    if let Ok(words) = given.extract::<Vec<String>>() {
        return Ok(Value::Words(words));
    }
    if let Ok(tables) = given.extract::<Vec<Bound<'_, PyDict>>>()
        && nested < MOST_NESTED
    {
        let tables = tables
            .iter()
            .enumerate()
            .map(|(index, table)| named(table, &format!("{name}[{index}]."), nested + 1));
        return Ok(Value::Tables(tables.collect::<Result<_, _>>()?));
    }
    Err(wrong(given, name))
}

fn wrong(given: &Bound<'_, PyAny>, name: &str) -> Failure {
    let message = format!("parameter `{name}` is {given:?}, which is no value of a parameter");
    InputError::new("invalid-input", message)
        .with_key(name)
        .with_help(
            "a number, Uncertain(value, u), a text, True or False, a list of numbers or of texts, or a list of dicts",
        )
        .into()
}

/// A frame of its homogeneous 4x4 matrix, or of seven numbers, `x, y, z, qx, qy, qz, qw`.
///
/// # Errors
/// `invalid-input` for numbers that are no frame.
pub(crate) fn frame(numbers: &[f64]) -> Result<Frame, InputError> {
    let frame = match *numbers {
        _ if !numbers.iter().all(|number| number.is_finite()) => None,
        [x, y, z, qx, qy, qz, qw] => Frame::from_quaternion_xyzw(Point3::new(x, y, z), [qx, qy, qz, qw]),
        _ if numbers.len() == 16 => of_matrix(&Matrix4::from_row_slice(numbers)),
        _ => None,
    };
    frame.ok_or_else(|| {
        InputError::new("invalid-input", format!("the numbers {numbers:?} are no frame"))
            .with_key("near")
            .with_help("give a Frame, a Solution, a homogeneous 4x4 matrix, or [x, y, z, qx, qy, qz, qw]")
    })
}

fn of_matrix(matrix: &Matrix4<f64>) -> Option<Frame> {
    /// A matrix that was rounded to seven digits is a frame, one that also scales or shears is none.
    const ORTHOGONAL: f64 = 1e-6;
    let rotation = matrix.fixed_view::<3, 3>(0, 0).into_owned();
    let last = matrix.row(3) - nalgebra::RowVector4::new(0.0, 0.0, 0.0, 1.0);
    let off = (rotation.transpose() * rotation - nalgebra::Matrix3::identity()).amax().max(last.amax());
    if off > ORTHOGONAL || rotation.determinant() < 0.0 {
        return None;
    }
    let quaternion = UnitQuaternion::from_matrix(&rotation);
    let origin = Point3::from(Vector3::from(matrix.fixed_view::<3, 1>(0, 3)));
    Frame::from_quaternion_xyzw(origin, quaternion.coords.into())
}
