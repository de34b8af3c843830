//! One row of a table of touches, whatever form the table has.

use nalgebra::{Point3, Vector3};
use touchref_core::{Fixture, Noise, Touch, Units, direction, parameters::nearest};
use touchref_io::InputError;

/// The values of a row; what is not there is `None`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Row<'a> {
    pub(crate) surface: Option<&'a str>,
    pub(crate) at: [Option<f64>; 3],
    pub(crate) sigma: Option<f64>,
    pub(crate) approach: [Option<f64>; 3],
    pub(crate) units: Option<&'a str>,
}

/// The names of the columns of [`Row::at`].
pub(crate) const AT: [&str; 3] = ["x", "y", "z"];
/// The names of the columns of [`Row::approach`].
pub(crate) const APPROACH: [&str; 3] = ["i", "j", "k"];

impl Row<'_> {
    /// The touch; `place` says where the row stands.
    ///
    /// # Errors
    /// The first column that is wrong.
    pub(crate) fn touch(
        &self,
        fixture: &dyn Fixture,
        units: Units,
        place: impl Fn() -> String,
    ) -> Result<Touch, InputError> {
        let wrong = |column: &str, found: String, expected: &str| {
            let message = format!("{}, column `{column}` is {found}; expected {expected}", place());
            InputError::new("invalid-input", message).with_key(column)
        };
        let number = |column: &str, value: f64, right: bool, expected: &str| {
            if right { Ok(value) } else { Err(wrong(column, value.to_string(), expected)) }
        };
        if let Some(stated) = self.units
            && stated != units.name()
        {
            let expected = format!("`{units}`, the unit of the measurement: lengths are not converted");
            return Err(wrong("units", format!("`{stated}`"), &expected));
        }
        let name = self.surface.unwrap_or_default();
        let surfaces = fixture.surfaces();
        let Some(surface) = surfaces.iter().position(|surface| surface.name == name) else {
            let names = || surfaces.iter().map(|surface| surface.name.as_str());
            let known: Vec<&str> = names().collect();
            let message =
                format!("{}: the fixture has no surface `{name}`; it has {}", place(), known.join(", "));
            return Err(InputError::new("unknown-surface", message)
                .with_nearest(nearest(name, names()))
                .with_key("surface"));
        };
        let mut at = Point3::origin();
        for axis in 0..3 {
            let expected = "a finite number";
            let value = self.at[axis].ok_or_else(|| wrong(AT[axis], "empty".to_owned(), expected))?;
            at[axis] = number(AT[axis], value, value.is_finite(), expected)?;
        }
        let noise = match self.sigma {
            None => Noise::OfProbe,
            Some(sigma) => {
                Noise::Sigma(number("sigma", sigma, sigma.is_finite() && sigma > 0.0, "a length > 0")?)
            }
        };
        let approach = match self.approach {
            [None, None, None] => None,
            [Some(i), Some(j), Some(k)] => {
                let told =
                    || wrong("i", format!("{i}, with {j} and {k}"), "a direction i, j, k, not all zero");
                Some(direction(Vector3::new(i, j, k)).ok_or_else(told)?)
            }
            _ => return Err(wrong("i", "not alone".to_owned(), "all three of i, j, k, or none")),
        };
        Ok(Touch { surface, at, noise, approach })
    }
}
