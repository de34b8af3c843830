//! The roots of the cylinder-plane equations by the textbook way: the polynomial of degree six in `t = tan(phi/2)`,
//! and the eigenvalues of its companion matrix.

use std::sync::LazyLock;

use nalgebra::{Matrix3, Point3, SMatrix, SVector, Vector3};

/// Direction cosines of the axis about the plane's normal: everything that the equations need.
pub struct Equations {
    /// Differences of the first three cylinder touches from the fourth, in coordinates (u, v, n).
    p: [Vector3<f64>; 3],
    /// Columns: u, v, n in the parent.
    basis: Matrix3<f64>,
    sin: f64,
    cos: f64,
}

impl Equations {
    /// From four touches on the cylinder, three on the plane, and the angle between axis and normal (radians).
    pub fn new(cylinder: &[Point3<f64>; 4], plane: &[Point3<f64>; 3], angle: f64) -> Self {
        let mut normal = (plane[1] - plane[0]).cross(&(plane[2] - plane[0])).normalize();
        if normal.dot(&(cylinder[3] - plane[0])) > 0.0 {
            normal = -normal;
        }
        let u = normal.cross(&(cylinder[1] - cylinder[0])).normalize();
        let basis = Matrix3::from_columns(&[u, normal.cross(&u), normal]);
        let mut p = [0, 1, 2].map(|i| basis.transpose() * (cylinder[i] - cylinder[3]));
        let scale = p.iter().map(Vector3::norm).fold(0.0, f64::max);
        for p in &mut p {
            *p /= scale;
        }
        Self { p, basis, sin: angle.sin(), cos: angle.cos() }
    }

    /// Equation (1) of the paper at the direction with angle `phi`.
    pub fn value(&self, phi: f64) -> f64 {
        let s = Vector3::new(self.sin * phi.cos(), self.sin * phi.sin(), self.cos);
        let [p1, p2, p3] = &self.p;
        let sum = p2.cross(p3) * p1.cross(&s).norm_squared()
            + p3.cross(p1) * p2.cross(&s).norm_squared()
            + p1.cross(p2) * p3.cross(&s).norm_squared();
        s.dot(&sum)
    }

    /// Coefficients of `value * (1 + t^2)^3` over powers of `t = tan(phi / 2)`, by interpolation.
    pub fn polynomial(&self) -> SVector<f64, 7> {
        // Places over most of the half circle keep the interpolation well conditioned.
        const PLACES: [f64; 7] = [-2.55, -1.7, -0.85, 0.0, 0.85, 1.7, 2.55];
        static OF_VALUES: LazyLock<SMatrix<f64, 7, 7>> = LazyLock::new(|| {
            let power = |row: usize, k: usize| {
                let t = (0.5 * PLACES[row]).tan();
                t.powf(k as f64) / (1.0 + t * t).powi(3)
            };
            SMatrix::<f64, 7, 7>::from_fn(power).try_inverse().unwrap()
        });
        *OF_VALUES * SVector::from(PLACES.map(|phi| self.value(phi)))
    }

    /// All six roots as complex angles (real and imaginary part), unordered: from the eigenvalues of the companion matrix.
    pub fn roots(&self) -> Vec<(f64, f64)> {
        // 2 atan(a + b i).
        let angle = |(a, b): (f64, f64)| {
            let imaginary = 0.5 * ((a * a + (1.0 + b).powi(2)) / (a * a + (1.0 - b).powi(2))).ln();
            ((2.0 * a).atan2(1.0 - a * a - b * b), imaginary)
        };
        companion_roots(&self.polynomial()).into_iter().map(angle).collect()
    }

    /// The axis at the direction with angle `phi`, in the parent.
    pub fn axis(&self, phi: f64) -> Vector3<f64> {
        self.basis * Vector3::new(self.sin * phi.cos(), self.sin * phi.sin(), self.cos)
    }
}

/// Eigenvalues (real and imaginary part) of the companion matrix of a polynomial of degree six.
pub fn companion_roots(polynomial: &SVector<f64, 7>) -> Vec<(f64, f64)> {
    companion(polynomial).complex_eigenvalues().iter().map(|z| (z.re, z.im)).collect()
}

/// The matrix whose eigenvalues are the roots of a polynomial of degree six.
pub fn companion(polynomial: &SVector<f64, 7>) -> SMatrix<f64, 6, 6> {
    SMatrix::from_fn(|row, k| match row {
        0 => -polynomial[5 - k] / polynomial[6],
        _ => f64::from(u8::from(row == k + 1)),
    })
}
