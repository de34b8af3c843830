//! The matrix itself, which loses nothing.

use nalgebra::{Matrix3, Point3, Rotation3, Vector4};
use touchref_core::{Convention, Dialect, DialectPlugin, Frame, Loss, ParameterKind, ParameterSpec, Units};

/// Rows in brackets, as `numpy` and JSON read them.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "matrix",
    summary: "4x4 matrix, rows in brackets (NumPy, JSON, CAD): loses nothing, the one to archive",
    origin: module_path!(),
    parameters: &[ParameterSpec {
        name: "units",
        kind: ParameterKind::Choice(&["mm", "m", "um", "in"]),
        default: Some("by the measurement"),
        meaning: "unit of the last column",
    }],
    reference: "homogeneous coordinates: p_parent = M p_fixture",
    build: |parameters| {
        let units = Units::from_name(parameters.word("units"));
        Ok(Box::new(Matrix { units, layout: Layout::Rows }))
    },
};
touchref_core::register_dialect!(PLUGIN);

/// Column after column, as Franka's `O_T_EE`.
pub static FRANKA: DialectPlugin = DialectPlugin {
    name: "franka",
    summary: "Franka: 16 numbers of a 4x4 matrix, column after column, metres",
    origin: module_path!(),
    parameters: &[],
    reference: "libfranka: O_T_EE",
    build: |_| Ok(Box::new(Matrix { units: Some(Units::Metre), layout: Layout::Columns })),
};
touchref_core::register_dialect!(FRANKA);

#[derive(Debug)]
struct Matrix {
    units: Option<Units>,
    layout: Layout,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Layout {
    Rows,
    Columns,
}

impl Dialect for Matrix {
    fn convention(&self) -> Convention {
        let (rotation, usage) = match self.layout {
            Layout::Rows => (
                "rows in brackets",
                "the first three columns are the fixture's X, Y and Z axes, the last its origin",
            ),
            Layout::Columns => {
                ("column after column", "one list of 16 numbers; the last four are the origin and 1")
            }
        };
        Convention {
            parent: "the frame the touches are told in",
            units: self.units,
            angles: "no angles",
            digits: "as many digits as give the same numbers back".to_owned(),
            rotation: format!("the matrix that maps fixture coordinates into the parent, {rotation}"),
            usage,
            loss: Loss { length: 0.0, angle: 0.0 },
            omission: None,
        }
    }

    fn print(&self, frame: &Frame) -> String {
        let matrix = frame.matrix();
        // Displayed, a double has the fewest digits that give it back, and no exponent; zero has no sign.
        let row = |numbers: Vector4<f64>| {
            format!(
                "[{}]",
                numbers.map(|v| (v + 0.0).to_string()).iter().cloned().collect::<Vec<_>>().join(", ")
            )
        };
        match self.layout {
            Layout::Rows => {
                format!(
                    "[{}]",
                    matrix.row_iter().map(|r| row(r.transpose())).collect::<Vec<_>>().join(",\n ")
                )
            }
            Layout::Columns => {
                let columns: Vec<String> = matrix.column_iter().map(|c| row(c.into_owned())).collect();
                format!(
                    "[{}]",
                    columns.iter().map(|c| c.trim_matches(['[', ']'])).collect::<Vec<_>>().join(", ")
                )
            }
        }
    }

    fn parse(&self, literal: &str) -> Option<Frame> {
        let flat: String = literal.chars().filter(|c| !c.is_whitespace()).collect();
        let numbers = |text: &str| text.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>().ok();
        let inside = flat.strip_prefix('[')?.strip_suffix(']')?;
        let vectors: Vec<Vec<f64>> = match self.layout {
            Layout::Rows => {
                let rows = inside.strip_prefix('[')?.strip_suffix(']')?.split("],[");
                rows.map(numbers).collect::<Option<_>>()?
            }
            Layout::Columns => numbers(inside)?.chunks(4).map(<[f64]>::to_vec).collect(),
        };
        if vectors.len() != 4 || vectors.iter().any(|vector| vector.len() != 4) {
            return None;
        }
        let m = |row: usize, column: usize| match self.layout {
            Layout::Rows => vectors[row][column],
            Layout::Columns => vectors[column][row],
        };
        let last: [f64; 4] = std::array::from_fn(|column| m(3, column));
        let axes = Matrix3::from_fn(m);
        let origin = Point3::new(m(0, 3), m(1, 3), m(2, 3));
        #[expect(clippy::float_cmp, reason = "the last row is no measurement")]
        let homogeneous = last == [0.0, 0.0, 0.0, 1.0];
        homogeneous.then(|| Frame { rotation: Rotation3::from_matrix_unchecked(axes), origin })
    }
}
