//! Frames in the words of machines: what the numbers of every literal mean, read by this file's own reader and composed
//! from this file's own elementary rotations, against golden values, against scipy (`tests/oracle/rotations.py`), and of
//! every dialect against every other.

#![allow(clippy::unwrap_used)] // A test may panic.
#![allow(clippy::approx_constant, clippy::float_cmp)] // Golden values as printed; what loses nothing is equal.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rayon::prelude::*;
use touchref_core::{Convention, Dialect, DialectError, Frame, Literal, Parameters, Registry, Units};
use touchref_io::{
    InputError,
    dialect::{ALL, find},
};

/// Rounding of a composed rotation, beside what the printed digits lose.
const ROUNDING: f64 = 5e-12;

fn registry() -> Registry {
    Registry::linked(&[], &[], ALL).unwrap()
}

fn dialect(name: &str) -> Box<dyn Dialect> {
    find(&registry(), name).unwrap_or_else(|error| panic!("{name}: {error}"))
}

// ---- elementary rotations, and what is left between two ----

fn rx(degrees: f64) -> Matrix3<f64> {
    let (s, c) = degrees.to_radians().sin_cos();
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

fn ry(degrees: f64) -> Matrix3<f64> {
    let (s, c) = degrees.to_radians().sin_cos();
    Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

fn rz(degrees: f64) -> Matrix3<f64> {
    let (s, c) = degrees.to_radians().sin_cos();
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

/// Rodrigues.
fn about(axis: Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let k = axis.normalize().cross_matrix();
    Matrix3::identity() + k * angle.sin() + k * k * (2.0 * (0.5 * angle).sin().powi(2))
}

fn of_quaternion([w, x, y, z]: [f64; 4]) -> Matrix3<f64> {
    let v = Vector3::new(x, y, z);
    about(if v.norm() > 0.0 { v } else { Vector3::x() }, 2.0 * v.norm().atan2(w))
}

/// Angle between two rotations; keeps small ones.
fn between(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
    2.0 * ((a - b).norm() / 8f64.sqrt()).min(1.0).asin()
}

fn frame(axes: Matrix3<f64>, origin: [f64; 3]) -> Frame {
    Frame { rotation: Rotation3::from_matrix_unchecked(axes), origin: origin.into() }
}

// ---- golden values ----

const P: [f64; 3] = [100.0, 200.0, 300.0];

/// One rotation in every convention: angles in degrees, quaternion w x y z, rotation vector in radians.
struct Golden {
    id: &'static str,
    built: Matrix3<f64>,
    zyx: [f64; 3],
    xyz: [f64; 3],
    zyz: [f64; 3],
    zxz: [f64; 3],
    wxyz: [f64; 4],
    vector: [f64; 3],
}

#[rustfmt::skip]
fn golden() -> Vec<Golden> {
    let g = |id, built, zyx, xyz, zyz, zxz, wxyz, vector| Golden { id, built, zyx, xyz, zyz, zxz, wxyz, vector };
    vec![
        g("G1", rz(30.0) * ry(20.0) * rx(10.0), [30.0, 20.0, 10.0], [-1.116_055, 22.242_181, 28.451_775],
          [2.726_830, 22.268_744, 25.505_550], [92.726_830, 22.268_744, -64.494_450],
          [0.951_548_525, 0.038_134_576, 0.189_307_857, 0.239_298_338], [0.077_525_317, 0.384_851_569, 0.486_479_230]),
        g("G2", rx(180.0), [0.0, 0.0, 180.0], [180.0, 0.0, 0.0], [0.0, 180.0, 180.0], [0.0, 180.0, 0.0],
          [0.0, 1.0, 0.0, 0.0], [3.141_592_654, 0.0, 0.0]),
        g("G3", rz(40.0) * ry(90.0) * rx(10.0), [30.0, 90.0, 0.0], [-90.0, 60.0, 90.0], [30.0, 90.0, 0.0],
          [120.0, 90.0, -90.0], [0.683_012_702, -0.183_012_702, 0.683_012_702, 0.183_012_702],
          [-0.410_380_241, 1.531_559_909, 0.410_380_241]),
        g("G4", rz(40.0) * ry(-90.0) * rx(10.0), [50.0, -90.0, 0.0], [90.0, -40.0, 90.0], [-130.0, 90.0, 180.0],
          [-40.0, 90.0, 90.0], [0.640_856_382, 0.298_836_239, -0.640_856_382, 0.298_836_239],
          [0.681_385_318, -1.461_235_530, 0.681_385_318]),
        g("G5", rx(179.98), [0.0, 0.0, 179.98], [179.98, 0.0, 0.0], [-90.0, 179.98, 90.0], [0.0, 179.98, 0.0],
          [0.000_174_533, 0.999_999_985, 0.0, 0.0], [3.141_243_588, 0.0, 0.0]),
        g("G6", about(Vector3::new(1.0, 2.0, 3.0), 0.002_f64.to_radians()), [0.001_604, 0.001_069, 0.000_535],
          [0.000_535, 0.001_069, 0.001_604], [-26.564_249, 0.001_195, 26.565_853], [63.435_751, 0.001_195, -63.434_147],
          [1.0, 0.000_004_665, 0.000_009_329, 0.000_013_994], [0.000_009_329, 0.000_018_658, 0.000_027_988]),
        g("G7", rz(-135.0) * ry(-35.0) * rx(170.0), [-135.0, -35.0, 170.0], [161.072_498, -31.480_337, 132.780_520],
          [-152.088_303, 143.775_460, 166.071_912], [-62.088_303, 143.775_460, 76.071_912],
          [0.308_568_137, 0.339_369_595, -0.887_796_103, 0.037_842_601], [0.897_021_783, -2.346_622_843, 0.100_025_572]),
        g("G8", rz(30.0) * ry(89.9) * rx(10.0), [30.0, 89.9, 10.0], [-89.712_063, 69.999_782, 89.746_793],
          [19.999_985, 89.901_519, 0.017_365], [109.999_985, 89.901_519, -89.982_635],
          [0.696_943_828, -0.122_576_708, 0.695_784_122, 0.122_998_807], [-0.273_371_432, 1.551_742_618, 0.274_312_799]),
        g("G9", rz(30.0), [30.0, 0.0, 0.0], [0.0, 0.0, 30.0], [0.0, 0.0, 30.0], [0.0, 0.0, 30.0],
          [0.965_925_826, 0.0, 0.0, 0.258_819_045], [0.0, 0.0, 0.523_598_776]),
        g("G10", rx(20.0) * ry(90.0) * rz(30.0), [90.0, 40.0, 90.0], [50.0, 90.0, 0.0], [0.0, 90.0, 50.0],
          [90.0, 90.0, -40.0], [0.640_856_382, 0.298_836_239, 0.640_856_382, 0.298_836_239],
          [0.681_385_318, 1.461_235_530, 0.681_385_318]),
        g("G11", rx(20.0) * ry(-90.0) * rz(30.0), [90.0, -80.0, -90.0], [-10.0, -90.0, 0.0], [180.0, 90.0, -170.0],
          [-90.0, 90.0, 100.0], [0.704_416_026, -0.061_628_417, -0.704_416_026, 0.061_628_417],
          [-0.137_046_447, -1.566_448_052, 0.137_046_447]),
        g("G12", rz(25.0) * rx(180.0), [25.0, 0.0, 180.0], [180.0, 0.0, -25.0], [0.0, 180.0, 155.0],
          [0.0, 180.0, -25.0], [0.0, 0.976_296_007, 0.216_439_614, 0.0], [3.067_124_364, 0.679_965_101, 0.0]),
    ]
}

// ---- a reader of literals that shares nothing with the library ----

/// Which convention the numbers of rotation follow, in the order in which the reader hands them out.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Column {
    /// About Z, Y, X.
    Zyx,
    Xyz,
    Zyz,
    Zxz,
    /// w, x, y, z.
    Quaternion,
    Vector,
}

/// How one literal is read: x, y, z and the numbers of rotation stand after these labels.
struct Reader {
    name: &'static str,
    labels: &'static [&'static str],
    column: Column,
    /// Where the numbers that follow x, y, z stand in the order of the column.
    places: &'static [usize],
    /// Millimetres in its unit of length, degrees in that of angles.
    scale: [f64; 2],
    /// Steps of the last digits printed, in its units.
    steps: [f64; 2],
}

const MM: [f64; 2] = [1.0, 1.0];
const ABC: &[usize] = &[0, 1, 2];
const CBA: &[usize] = &[2, 1, 0];
const LIST: &[&str] = &["(", ",", ",", ",", ",", ","];

#[rustfmt::skip]
const READERS: &[Reader] = &[
    Reader { name: "kuka", labels: &["{X ", ",Y ", ",Z ", ",A ", ",B ", ",C "], column: Column::Zyx, places: ABC,
             scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "abb", labels: &["[[", ",", ",", "],[", ",", ",", ","], column: Column::Quaternion,
             places: &[0, 1, 2, 3], scale: MM, steps: [1e-4, 1e-9] },
    Reader { name: "fanuc", labels: &[",1]=", ",2]=", ",3]=", ",4]=", ",5]=", ",6]="], column: Column::Zyx, places: CBA,
             scale: MM, steps: [1e-3, 1e-3] },
    Reader { name: "ur", labels: &["p[", ",", ",", ",", ",", ","], column: Column::Vector, places: ABC,
             scale: [1e3, 1.0], steps: [1e-9, 1e-9] },
    Reader { name: "staubli", labels: &[" x=\"", " y=\"", " z=\"", " rx=\"", " ry=\"", " rz=\""], column: Column::Xyz,
             places: ABC, scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "mecademic", labels: LIST, column: Column::Xyz, places: ABC, scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "yaskawa", labels: &["BUSER ", ",", ",", ",", ",", ","], column: Column::Zyx, places: CBA, scale: MM,
             steps: [1e-3, 1e-4] },
    Reader { name: "kawasaki", labels: LIST, column: Column::Zyz, places: ABC, scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "adept", labels: LIST, column: Column::Zyz, places: ABC, scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "comau", labels: LIST, column: Column::Zyz, places: ABC, scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "doosan", labels: LIST, column: Column::Zyz, places: ABC, scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "mitsubishi", labels: LIST, column: Column::Zyx, places: CBA, scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "siemens", labels: &["CTRANS(X,", ",Y,", ",Z,", "CROT(X,", ",Y,", ",Z,"], column: Column::Zyx,
             places: CBA, scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "heidenhain", labels: &["7.1 X", "7.2 Y", "7.3 Z", "SPATIAL SPA", "SPB", "SPC"], column: Column::Zyx,
             places: CBA, scale: MM, steps: [1e-4, 1e-4] },
    Reader { name: "fanuc-cnc", labels: &["G68.2 X", " Y", " Z", " I", " J", " K"], column: Column::Zxz, places: ABC,
             scale: MM, steps: [1e-4, 1e-6] },
    Reader { name: "linuxcnc-g68", labels: &["Q313 X", " Y", " Z", " I", " J", " K"], column: Column::Zxz, places: ABC,
             scale: MM, steps: [1e-6, 1e-6] },
    Reader { name: "ros2", labels: &["--x ", "--y ", "--z ", "--qx ", "--qy ", "--qz ", "--qw "],
             column: Column::Quaternion, places: &[1, 2, 3, 0], scale: [1e3, 1.0], steps: [1e-9, 1e-9] },
    Reader { name: "urdf", labels: &["xyz=\"", " ", " ", "rpy=\"", " ", " "], column: Column::Zyx, places: CBA,
             scale: [1e3, 180.0 / PI], steps: [1e-9, 1e-9] },
    Reader { name: "quaternion", labels: &["", ",", ",", ",", ",", ",", ","], column: Column::Quaternion,
             places: &[1, 2, 3, 0], scale: MM, steps: [1e-12, 1e-16] },
    Reader { name: "euler:zyx:intrinsic:deg", labels: &["", " ", " ", " ", " ", " "], column: Column::Zyx, places: ABC,
             scale: MM, steps: [1e-9, 1e-10] },
    Reader { name: "euler:xyz:extrinsic:rad", labels: &["", " ", " ", " ", " ", " "], column: Column::Zyx, places: CBA,
             scale: [1.0, 180.0 / PI], steps: [1e-9, 1e-12] },
    Reader { name: "euler:xyz:intrinsic:deg", labels: &["", " ", " ", " ", " ", " "], column: Column::Xyz, places: ABC,
             scale: MM, steps: [1e-9, 1e-10] },
    Reader { name: "euler:zyz:intrinsic:deg", labels: &["", " ", " ", " ", " ", " "], column: Column::Zyz, places: ABC,
             scale: MM, steps: [1e-9, 1e-10] },
    Reader { name: "euler:zxz:intrinsic:rad", labels: &["", " ", " ", " ", " ", " "], column: Column::Zxz, places: ABC,
             scale: [1.0, 180.0 / PI], steps: [1e-9, 1e-12] },
];

impl Reader {
    /// Position in mm, and the numbers of rotation in the order of the column; angles in degrees.
    fn read(&self, literal: &str) -> ([f64; 3], Vec<f64>) {
        let mut rest = literal;
        let mut numbers = self.labels.iter().map(|label| {
            let at = rest.find(label).unwrap_or_else(|| panic!("{}: no {label:?} in {literal}", self.name));
            rest = &rest[at + label.len()..];
            let end = rest.find(|c: char| !"+-.0123456789".contains(c)).unwrap_or(rest.len());
            rest[..end].parse::<f64>().unwrap_or_else(|_| panic!("{}: {:?}", self.name, &rest[..end]))
        });
        let position = [(); 3].map(|()| numbers.next().unwrap() * self.scale[0]);
        let mut rotation = vec![0.0; self.places.len()];
        for (place, number) in self.places.iter().zip(numbers) {
            rotation[*place] = number * self.scale[1];
        }
        (position, rotation)
    }

    fn axes(&self, numbers: &[f64]) -> Matrix3<f64> {
        match (self.column, numbers) {
            (Column::Zyx, [a, b, c]) => rz(*a) * ry(*b) * rx(*c),
            (Column::Xyz, [a, b, c]) => rx(*a) * ry(*b) * rz(*c),
            (Column::Zyz, [a, b, c]) => rz(*a) * ry(*b) * rz(*c),
            (Column::Zxz, [a, b, c]) => rz(*a) * rx(*b) * rz(*c),
            (Column::Quaternion, &[w, x, y, z]) => of_quaternion([w, x, y, z]),
            (Column::Vector, &[x, y, z]) => {
                let v = Vector3::new(x, y, z);
                about(if v.norm() > 0.0 { v } else { Vector3::x() }, v.norm())
            }
            other => panic!("{other:?}"),
        }
    }

    /// The largest angle, radians, by which printing may turn.
    fn quantum(&self) -> f64 {
        let half = 0.5 * self.steps[1];
        match self.column {
            Column::Quaternion => 4.0 * half,
            Column::Vector => 3f64.sqrt() * half,
            _ => 3.0 * half * self.scale[1].to_radians(),
        }
    }
}

/// Angles: 180 and -180 are one.
fn same_angle(got: f64, want: f64, tolerance: f64) -> bool {
    let off = (got - want).abs();
    off < tolerance || (off - 360.0).abs() < tolerance
}

#[test]
fn the_golden_vectors_in_every_dialect() {
    /// Half a unit of the last digit of the golden values: angles in degrees, and the others.
    const GOLDEN: [f64; 2] = [0.51e-6, 0.51e-9];
    for reader in READERS {
        let dialect = dialect(reader.name);
        for golden in golden() {
            let literal =
                Literal::new(reader.name, &*dialect, &frame(golden.built, P), Units::Millimetre, &[])
                    .unwrap();
            let (position, numbers) = reader.read(&literal.text);
            let what = format!("{} {}: {}", reader.name, golden.id, literal.text);
            assert!(position.iter().zip(P).all(|(got, want)| (got - want).abs() < 1e-9), "{what}");
            assert!(between(&reader.axes(&numbers), &golden.built) <= reader.quantum() + ROUNDING, "{what}");
            let angles = |want: [f64; 3]| {
                let tolerance = 0.5 * reader.steps[1] * reader.scale[1] + GOLDEN[0];
                numbers.iter().zip(want).all(|(got, want)| same_angle(*got, want, tolerance))
            };
            let numbers_are = |want: &[f64]| {
                let near = |sign: f64| {
                    numbers
                        .iter()
                        .zip(want)
                        .all(|(g, w)| (sign * g - w).abs() < 0.5 * reader.steps[1] + GOLDEN[1])
                };
                // At a half turn either sign is the same rotation.
                near(1.0) || (golden.wxyz[0] == 0.0 && near(-1.0))
            };
            let right = match reader.column {
                Column::Zyx => angles(golden.zyx),
                Column::Xyz => angles(golden.xyz),
                // So near its lock only the sum of the outer angles means anything.
                Column::Zyz | Column::Zxz if golden.id == "G6" => true,
                Column::Zyz => angles(golden.zyz),
                Column::Zxz => angles(golden.zxz),
                Column::Quaternion => numbers_are(&golden.wxyz),
                Column::Vector => numbers_are(&golden.vector),
            };
            assert!(right, "{what}");
        }
    }
}

#[test]
fn the_golden_vectors_as_matrices() {
    let g1 = golden().swap_remove(0);
    let text = Literal::new("matrix", &*dialect("matrix"), &frame(g1.built, P), Units::Millimetre, &[])
        .unwrap()
        .text;
    let rows: Vec<Vec<f64>> = serde_json::from_str(&text).unwrap();
    let printed = [
        [0.813_797_681_349, -0.440_969_610_530, 0.378_522_306_370, 100.0],
        [0.469_846_310_393, 0.882_564_119_259, 0.018_028_311_236, 200.0],
        [-0.342_020_143_326, 0.163_175_911_167, 0.925_416_578_398, 300.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    let off = |row: usize, column: usize| (rows[row][column] - printed[row][column]).abs();
    assert!((0..16).all(|k| off(k / 4, k % 4) < 0.51e-12), "{text}");

    for golden in golden() {
        let told = frame(golden.built, P);
        let read =
            |name: &str| Literal::new(name, &*dialect(name), &told, Units::Millimetre, &[]).unwrap().text;
        // Every digit.
        let rows: Vec<Vec<f64>> = serde_json::from_str(&read("matrix")).unwrap();
        assert!((0..9).all(|k| rows[k / 3][k % 3] == golden.built[(k / 3, k % 3)]), "{}", golden.id);
        // Column after column, metres.
        let columns: Vec<f64> = serde_json::from_str(&read("franka")).unwrap();
        assert!(
            (0..9).all(|k| columns[k % 3 + 4 * (k / 3)] == golden.built[(k % 3, k / 3)]),
            "{}",
            golden.id
        );
        assert!(
            columns[12..].iter().zip([0.1, 0.2, 0.3, 1.0]).all(|(g, w)| (g - w).abs() < 1e-15),
            "{columns:?}"
        );
    }
}

/// Only the one golden vector that lies flat can be a work offset of `LinuxCNC`.
#[test]
fn a_tilt_is_refused_where_it_cannot_be_told() {
    for golden in golden() {
        let point = Point3::new(100.0, 200.0, 800.0);
        let told = Literal::new(
            "linuxcnc",
            &*dialect("linuxcnc"),
            &frame(golden.built, P),
            Units::Millimetre,
            &[point],
        );
        if golden.id == "G9" {
            assert_eq!(told.unwrap().text, "G21\nG10 L2 P1 X100.000000 Y200.000000 Z300.000000 R30.000000");
            continue;
        }
        let error = told.unwrap_err();
        assert_eq!(error.code(), "not-representable", "{}", golden.id);
        let DialectError::Lossy { lost, .. } = &error else { panic!("{error}") };
        let tilt = golden.built[(2, 2)].clamp(-1.0, 1.0).acos();
        assert!((lost.angle - tilt).abs() < 1e-7, "{}: {} {tilt}", golden.id, lost.angle);
        // Along the parent's Z the turn about Z does nothing, the tilt all.
        let chord = 2.0 * 500.0 * (0.5 * tilt).sin();
        assert!((lost.displacement - chord).abs() < 1e-4, "{} {chord}", lost.displacement);
        assert!(error.to_string().contains("tilt") && error.help().contains("linuxcnc-g68"), "{error}");
    }
}

#[test]
fn how_much_tilt_may_be_lost_can_be_said() {
    let tilted = frame(rz(30.0) * rx(0.02), P);
    let point = Point3::new(100.0, 200.0, 1300.0);
    let told = |name: &str| Literal::new(name, &*dialect(name), &tilted, Units::Millimetre, &[point]);
    assert_eq!(told("linuxcnc").unwrap_err().code(), "not-representable");
    assert_eq!(told("linuxcnc:1:0.019").unwrap_err().code(), "not-representable");
    let literal = told("linuxcnc:2:0.021:in").unwrap();
    assert_eq!(literal.text, "G20\nG10 L2 P2 X3.937008 Y7.874016 Z11.811024 R30.000000");
    // What is lost is told: 0.02 degrees, a metre away.
    assert!((literal.rounding_loss - 0.349_066).abs() < 1e-4, "{}", literal.rounding_loss);
    assert!((literal.farthest_touch - 1000.0).abs() < 1e-9);
}

// ---- against scipy ----

#[test]
fn scipy_reads_the_same() {
    /// Of the file's numbers, composed, beside the digits of `euler`: degrees.
    const TOLERANCE: f64 = 1e-9;
    let cases: serde_json::Value =
        serde_json::from_str(include_str!("../../tests/oracle/rotations.json")).unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let registry = registry();
    for case in cases.as_array().unwrap() {
        let axes = Matrix3::from_fn(|row, column| number(&case["matrix"][row][column]));
        let told = frame(axes, P);
        let numbers = |name: &str| -> Vec<f64> {
            let dialect = find(&registry, name).unwrap();
            let text = Literal::new(name, &*dialect, &told, Units::Millimetre, &[]).unwrap().text;
            text.replace(',', " ").split(' ').skip(3).map(|word| word.parse().unwrap()).collect()
        };
        let turn = |letter: u8, degrees: f64| match letter {
            b'x' => rx(degrees),
            b'y' => ry(degrees),
            _ => rz(degrees),
        };
        for (order, expected) in case["angles_deg"].as_object().unwrap() {
            let [i, j, k] = *order.as_bytes() else { panic!("{order}") };
            for (word, key) in [("intrinsic", "moving"), ("extrinsic", "fixed")] {
                let got = numbers(&format!("euler:{order}:{word}:deg"));
                let [a, b, c] = [turn(i, got[0]), turn(j, got[1]), turn(k, got[2])];
                let composed = if key == "moving" { a * b * c } else { c * b * a };
                let what = format!("{} {order} {key} {got:?}", case["name"]);
                assert!(between(&composed, &axes) < 1e-11 + 3.0 * 0.5e-10_f64.to_radians(), "{what}");
                let radians = numbers(&format!("euler:{order}:{word}:rad"));
                let same = got.iter().zip(&radians).all(|(d, r)| same_angle(*d, r.to_degrees(), TOLERANCE));
                assert!(same, "{what} {radians:?}");
                if expected["regular"] == true {
                    let agree = (0..3).all(|n| same_angle(got[n], number(&expected[key][n]), TOLERANCE));
                    assert!(agree, "{what} {}", expected[key]);
                }
            }
        }
        let quaternion = numbers("quaternion");
        let by = |sign: f64| {
            (0..4).all(|n| (sign * quaternion[n] - number(&case["quaternion_xyzw"][n])).abs() < 1e-12)
        };
        assert!(by(1.0) || (quaternion[3] < 1e-9 && by(-1.0)), "{}: {quaternion:?}", case["name"]);
        let ur = READERS.iter().find(|reader| reader.name == "ur").unwrap();
        let (_, vector) =
            ur.read(&Literal::new("ur", &*dialect("ur"), &told, Units::Millimetre, &[]).unwrap().text);
        let by = |sign: f64| {
            (0..3).all(|n| (sign * vector[n] - number(&case["rotation_vector"][n])).abs() < 0.51e-9)
        };
        assert!(by(1.0) || (quaternion[3] < 1e-9 && by(-1.0)), "{}: {vector:?}", case["name"]);
    }
}

// ---- what holds for every frame ----

/// Random frames, and frames that stand ever nearer to every lock, to no turn and to a half turn.
fn frames(random: usize) -> Vec<Frame> {
    let mut generator = SmallRng::seed_from_u64(7);
    let mut all: Vec<Frame> = (0..random)
        .map(|_| {
            let q: [f64; 4] = std::array::from_fn(|_| generator.random_range(-1.0..1.0));
            // Two of three are small; near and far, to 10 m.
            let reach = 10f64.powf(generator.random_range(-4.0..4.0));
            let origin = std::array::from_fn(|_| generator.random_range(-reach..reach));
            frame(of_quaternion(q), origin)
        })
        .collect();
    for k in 0..=16 {
        // The last is at the very place.
        let off = if k == 0 { 0.0 } else { 10f64.powi(-k) };
        for _ in 0..10 {
            let [a, c] = [(); 2].map(|()| generator.random_range(-180.0..180.0));
            let axis = Vector3::from_fn(|_, _| generator.random_range(-1.0..1.0));
            for sign in [1.0, -1.0] {
                let near = |place: f64| (place + sign * off).to_degrees();
                for place in [FRAC_PI_2, -FRAC_PI_2] {
                    all.push(frame(rz(a) * ry(near(place)) * rx(c), P));
                    all.push(frame(rx(a) * ry(near(place)) * rz(c), P));
                }
                for place in [0.0, PI] {
                    all.push(frame(rz(a) * ry(near(place)) * rz(c), P));
                    all.push(frame(rz(a) * rx(near(place)) * rz(c), P));
                    all.push(frame(about(axis, place + sign * off), P));
                    all.push(frame(rx(near(place)), P));
                }
            }
        }
    }
    all
}

/// No exponent, no negative zero, nothing that is no number.
fn assert_plain(text: &str) {
    let bytes = text.as_bytes();
    let exponent = bytes.windows(2).any(|pair| pair[0].is_ascii_digit() && matches!(pair[1], b'e' | b'E'));
    assert!(!exponent && !text.contains("NaN") && !text.contains("inf"), "{text}");
    for (at, _) in text.match_indices('-') {
        let number: String = text[at + 1..].chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
        assert!(number.is_empty() || number.parse::<f64>().unwrap() != 0.0, "{text}");
    }
}

/// `parse(print(T))`, and what the reader of this file makes of the text: within the printed digits, for every frame;
/// so all dialects of one frame agree.
#[test]
fn every_dialect_of_a_frame_tells_the_same_frame() {
    const RANDOM: usize = 100_000;
    /// Every dialect tells one in so many of the random frames, some 16 000; one in twice so many is told by all.
    const SHARE: usize = 6;
    /// Rounding of a coordinate.
    const LENGTH: f64 = 4e-16;
    let registry = registry();
    let dialects: Vec<_> =
        READERS.iter().map(|reader| (reader, find(&registry, reader.name).unwrap())).collect();
    let lossless = ["matrix", "franka"].map(|name| find(&registry, name).unwrap());
    frames(RANDOM).par_iter().enumerate().for_each(|(index, frame)| {
        let all = index >= RANDOM || index % (2 * SHARE) == 0;
        let turn = |nth: usize| all || nth % SHARE == index % SHARE;
        for (_, (reader, dialect)) in dialects.iter().enumerate().filter(|(nth, _)| turn(*nth)) {
            let scaled = Frame { origin: frame.origin / reader.scale[0], ..*frame };
            let text = dialect.print(&scaled);
            assert_plain(&text);
            let (position, numbers) = reader.read(&text);
            let what = || format!("{} of frame {index}: {text} of {frame:?}", reader.name);
            let axes = reader.axes(&numbers);
            assert!(between(&axes, frame.rotation.matrix()) <= reader.quantum() + ROUNDING, "{}", what());
            let length = 0.5 * reader.steps[0] * reader.scale[0];
            let off = (Point3::from(position) - frame.origin).abs().max();
            assert!(off <= length + LENGTH * frame.origin.coords.norm(), "{}: {off:e}", what());
            let back = dialect.parse(&text).unwrap();
            assert!(between(back.rotation.matrix(), &axes) < ROUNDING, "{}", what());
            let off = (back.origin * reader.scale[0] - Point3::from(position)).abs().max();
            assert!(off <= LENGTH * frame.origin.coords.norm(), "{}: {off:e}", what());
            if reader.column == Column::Quaternion {
                let norm: f64 = numbers.iter().map(|v| v * v).sum();
                assert!((norm - 1.0).abs() < 1e-6, "{}", what());
            }
        }
        for dialect in &lossless {
            let text = dialect.print(frame);
            assert_plain(&text);
            assert_eq!(dialect.parse(&text), Some(*frame), "{text}");
        }
    });
}

/// The one dialect that the frames above are not for: turns about Z, near none and near a half turn, too.
#[test]
fn every_level_frame_is_a_work_offset() {
    let mut generator = SmallRng::seed_from_u64(11);
    let near = (0..=16).flat_map(|k| {
        let off = if k == 0 { 0.0 } else { 10f64.powi(-k).to_degrees() };
        [off, -off, 180.0 - off, -180.0 + off]
    });
    let mut turns: Vec<f64> = near.collect();
    turns.extend((0..10_000).map(|_| generator.random_range(-180.0..180.0)));
    for (name, millimetres) in [("linuxcnc", 1.0), ("linuxcnc:units=in", 25.4)] {
        let dialect = dialect(name);
        for turn in &turns {
            let told = frame(rz(*turn), std::array::from_fn(|_| generator.random_range(-2e3..2e3)));
            let text = Literal::new(name, &*dialect, &told, Units::Millimetre, &[]).unwrap().text;
            assert_plain(&text);
            let numbers: Vec<f64> =
                text.split([' ', '\n']).skip(4).map(|word| word[1..].parse().unwrap()).collect();
            let [x, y, z, r] = numbers[..] else { panic!("{text}") };
            let off = (Point3::new(x, y, z) * millimetres - told.origin).abs().max();
            assert!(off <= 0.5e-6 * millimetres + 1e-12, "{text}: {off:e}");
            assert!(between(&rz(r), told.rotation.matrix()) <= 0.5e-6_f64.to_radians() + ROUNDING, "{text}");
        }
    }
}

/// What is said to be lost is what the reader of this file finds, in whatever unit the measurement is.
#[test]
fn the_loss_at_the_touches_is_told() {
    let told = frame(golden()[6].built, [123.456_78, -98.765_43, 1_234.567_89]);
    let touched: Vec<Point3<f64>> = [[1.0, 0.0, 0.0], [-300.0, 400.0, 20.0], [900.0, -1200.0, 50.0]]
        .map(|p| told.to_parent(&p.into()))
        .into();
    for reader in READERS.iter().filter(|reader| reader.name != "quaternion") {
        let mut texts = Vec::new();
        for units in Units::ALL {
            let scale = 1.0 / units.millimetres();
            let scaled: Vec<_> = touched.iter().map(|point| point * scale).collect();
            let frame = Frame { origin: told.origin * scale, ..told };
            let literal = Literal::new(reader.name, &*dialect(reader.name), &frame, units, &scaled).unwrap();
            assert!((literal.farthest_touch * units.millimetres() - 1_500.833_102).abs() < 1e-5);
            if literal.convention.units.is_none() && units != Units::Millimetre {
                continue; // It takes the measurement's unit.
            }
            let (position, numbers) = reader.read(&literal.text);
            let (axes, position) = (reader.axes(&numbers), Point3::from(position));
            let off = touched.iter().map(|p| (position + axes * told.to_fixture(p).coords - p).norm());
            let expected = off.fold((position - told.origin).norm(), f64::max);
            let got = literal.rounding_loss * units.millimetres();
            assert!((got - expected).abs() < 1e-8, "{} in {units}: {got:e} {expected:e}", reader.name);
            assert!(expected > 0.0 && expected < 0.1, "{}: {expected}", reader.name);
            texts.push(literal.text);
        }
        assert!(texts.iter().all(|text| *text == texts[0]), "{texts:#?}");
    }
}

// ---- what vendors say ----

/// The control reads frames back in one of many triples: examples of the job planning manual.
#[test]
fn siemens_reads_back_as_its_manual_says() {
    let siemens = dialect("siemens");
    let literal = |rotation: &str| format!("$P_UIFR[1]=CTRANS(X,0.0000,Y,0.0000,Z,0.0000):CROT({rotation})");
    for (programmed, read_back) in [
        ("X,10,Y,90,Z,40", "X,0.000000,Y,90.000000,Z,30.000000"),
        ("X,190,Y,0,Z,-200", "X,-170.000000,Y,0.000000,Z,160.000000"),
    ] {
        let frame = siemens.parse(&literal(programmed)).unwrap();
        assert_eq!(siemens.print(&frame), literal(read_back));
    }
}

#[test]
fn literals_are_in_the_form_that_machines_take() {
    let g1 = frame(golden()[0].built, P);
    for (name, expected) in [
        ("kuka", "{X 100.0000,Y 200.0000,Z 300.0000,A 30.000000,B 20.000000,C 10.000000}"),
        (
            "kuka:BASE_DATA[3]",
            "BASE_DATA[3]={X 100.0000,Y 200.0000,Z 300.0000,A 30.000000,B 20.000000,C 10.000000}",
        ),
        (
            "abb:wFix",
            "PERS wobjdata wFix:=[FALSE,TRUE,\"\",[[100.0000,200.0000,300.0000],[0.951548525,0.038134576,\
                      0.189307857,0.239298338]],[[0,0,0],[1,0,0,0]]];",
        ),
        (
            "fanuc:3",
            "PR[3,1]=100.000 ;\nPR[3,2]=200.000 ;\nPR[3,3]=300.000 ;\nPR[3,4]=10.000 ;\nPR[3,5]=20.000 ;\n\
                     PR[3,6]=30.000 ;\nUFRAME[3]=PR[3] ;",
        ),
        ("ur:fix1", "fix1 = p[0.100000000,0.200000000,0.300000000,0.077525317,0.384851569,0.486479230]"),
        (
            "staubli:fFix",
            "<Data name=\"fFix\" access=\"private\" xsi:type=\"array\" type=\"frame\" size=\"1\">\
                          <Value key=\"0\" x=\"100.0000\" y=\"200.0000\" z=\"300.0000\" rx=\"-1.116055\" \
                          ry=\"22.242181\" rz=\"28.451775\" fatherId=\"world[0]\"/></Data>",
        ),
        ("mecademic", "SetWRF(100.0000,200.0000,300.0000,-1.116055,22.242181,28.451775)"),
        ("yaskawa", "///BUSER 100.000,200.000,300.000,10.0000,20.0000,30.0000"),
        ("kawasaki:fix1", "POINT fix1 = TRANS(100.0000,200.0000,300.0000,2.726830,22.268744,25.505550)"),
        ("doosan:p", "p = posx(100.0000,200.0000,300.0000,2.726830,22.268744,25.505550)"),
        ("mitsubishi:PFix", "PFix=(100.0000,200.0000,300.0000,10.000000,20.000000,30.000000)(0,0)"),
        (
            "siemens:2",
            "$P_UIFR[2]=CTRANS(X,100.0000,Y,200.0000,Z,300.0000):CROT(X,10.000000,Y,20.000000,Z,30.000000)",
        ),
        (
            "heidenhain",
            "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+100.0000\nCYCL DEF 7.2 Y+200.0000\n\
                        CYCL DEF 7.3 Z+300.0000\nPLANE SPATIAL SPA+10.0000 SPB+20.0000 SPC+30.0000 STAY",
        ),
        ("fanuc-cnc", "G68.2 X100.0000 Y200.0000 Z300.0000 I92.726830 J22.268744 K-64.494450"),
        (
            "ros2:map:vise",
            "ros2 run tf2_ros static_transform_publisher --x 0.100000000 --y 0.200000000 \
                           --z 0.300000000 --qx 0.038134576 --qy 0.189307857 --qz 0.239298338 --qw 0.951548525 \
                           --frame-id map --child-frame-id vise",
        ),
        (
            "urdf",
            "<origin xyz=\"0.100000000 0.200000000 0.300000000\" rpy=\"0.174532925 0.349065850 0.523598776\"/>",
        ),
    ] {
        let literal = Literal::new(name, &*dialect(name), &g1, Units::Millimetre, &[]).unwrap();
        assert_eq!(literal.text, expected);
    }
}

// ---- refusals ----

#[test]
fn what_is_no_frame_is_not_told() {
    for plugin in registry().dialects() {
        if plugin.parameters.iter().any(|spec| spec.default.is_none()) {
            continue;
        }
        let dialect = plugin.build(&Parameters::new()).unwrap();
        let nan = Frame { origin: Point3::new(0.0, f64::NAN, 0.0), ..Frame::identity() };
        let infinite = Frame { origin: Point3::new(0.0, 0.0, f64::INFINITY), ..Frame::identity() };
        for frame in [nan, infinite, frame(-Matrix3::identity(), P), frame(1.01 * Matrix3::identity(), P)] {
            let error = Literal::new(plugin.name, &*dialect, &frame, Units::Metre, &[]).unwrap_err();
            assert_eq!(error.code(), "dialect-failed", "{}: {error}", plugin.name);
        }
    }
}

/// A dialect with a mistake: what it reads is another frame, or nothing.
#[derive(Debug)]
struct Mistaken {
    reads: Option<Frame>,
}

impl Dialect for Mistaken {
    fn convention(&self) -> Convention {
        dialect("matrix").convention()
    }
    fn print(&self, _: &Frame) -> String {
        "something".to_owned()
    }
    fn parse(&self, _: &str) -> Option<Frame> {
        self.reads
    }
}

#[test]
fn a_dialect_that_reads_back_another_frame_is_refused() {
    let told = frame(golden()[0].built, P);
    let turned = Frame { rotation: told.rotation.inverse(), ..told };
    let shifted = Frame { origin: told.origin + 1e-9 * Vector3::x(), ..told };
    let unsound = Frame { origin: Point3::new(f64::NAN, 0.0, 0.0), ..told };
    for reads in [None, Some(turned), Some(shifted), Some(unsound)] {
        let error = Literal::new("mistaken", &Mistaken { reads }, &told, Units::Millimetre, &[]).unwrap_err();
        assert!(error.code() == "dialect-failed" && error.to_string().contains("mistaken"), "{error}");
    }
    assert!(Literal::new("right", &Mistaken { reads: Some(told) }, &told, Units::Millimetre, &[]).is_ok());
}

#[test]
fn wrong_names_and_values_are_told() {
    let registry = registry();
    let error = |text: &str| -> InputError { find(&registry, text).unwrap_err() };
    for (text, code, nearest, word) in [
        ("kuka2", "unknown-dialect", Some("kuka"), "kuka2"),
        ("euler", "invalid-input", None, "`order` is missing"),
        ("euler:zyy:intrinsic:deg", "invalid-input", Some("zyx"), "zyy"),
        ("euler:zyx:intrinsc:deg", "invalid-input", Some("intrinsic"), "intrinsc"),
        ("euler:zyx:intrinsic:degrees", "invalid-input", Some("deg"), "degrees"),
        ("euler:zyx:intrinsic:deg:more", "invalid-input", None, "more"),
        ("linuxcnc:tlt=1", "unknown-key", Some("tilt"), "tlt"),
        ("linuxcnc:0", "invalid-input", None, "from 1 to 9"),
        ("linuxcnc:tilt=11", "invalid-input", None, "11"),
        ("linuxcnc:1:number=2", "invalid-input", None, "twice"),
        ("kuka:1A", "invalid-input", None, "1A"),
        ("abb:w Fix", "invalid-input", None, "w Fix"),
        ("ros2:a;b", "invalid-input", None, "a;b"),
        ("", "unknown-dialect", None, "``"),
    ] {
        let error = error(text);
        assert_eq!((error.code(), error.nearest()), (code, nearest), "{text}: {error}");
        assert!(error.to_string().contains(word), "{text}: {error}");
        assert!(nearest.is_none() || error.help().is_some(), "{text}");
    }
    let euler = error("euler");
    assert!(euler.help().unwrap().contains("euler:<order>:<intrinsic|extrinsic>:<deg|rad>"), "{euler:?}");
}
