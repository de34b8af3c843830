//! The roots of the cylinder-plane equations by the textbook way: the polynomial of degree six in `t = tan(phi/2)`,
//! and the eigenvalues of its companion matrix.

use nalgebra::{Matrix3, Point3, SMatrix, SVector, Vector3};

/// Direction cosines of the axis about the plane's normal: everything that the equations need.
pub struct Equations {
    /// Differences of the first three cylinder touches from the fourth, in coordinates (u, v, n).
    p: [Vector3<f64>; 3],
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
        Self { p, sin: angle.sin(), cos: angle.cos() }
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
    fn polynomial(&self) -> SVector<f64, 7> {
        // Places over most of the half circle keep the interpolation well conditioned.
        let places = [-2.55, -1.7, -0.85, 0.0, 0.85, 1.7, 2.55_f64];
        let mut powers = SMatrix::<f64, 7, 7>::zeros();
        let mut values = SVector::<f64, 7>::zeros();
        for (row, phi) in places.iter().enumerate() {
            let t = (0.5 * phi).tan();
            let scale = (1.0 + t * t).powi(3);
            let mut power = 1.0 / scale;
            for k in 0..7 {
                powers[(row, k)] = power;
                power *= t;
            }
            values[row] = self.value(*phi);
        }
        powers.lu().solve(&values).unwrap()
    }

    /// Angles of the real roots, unordered: eigenvalues of the companion matrix whose imaginary part is below
    /// `tolerance`.
    pub fn real_roots(&self, tolerance: f64) -> Vec<f64> {
        let polynomial = self.polynomial();
        companion_roots(&polynomial)
            .into_iter()
            .filter(|(_, imaginary)| imaginary.abs() < tolerance)
            .map(|(real, _)| 2.0 * real.atan())
            .collect()
    }
}

/// Eigenvalues (real and imaginary part) of the companion matrix of a polynomial of degree six.
pub fn companion_roots(polynomial: &SVector<f64, 7>) -> Vec<(f64, f64)> {
    let mut companion = SMatrix::<f64, 6, 6>::zeros();
    for k in 0..6 {
        companion[(0, k)] = -polynomial[5 - k] / polynomial[6];
        if k < 5 {
            companion[(k + 1, k)] = 1.0;
        }
    }
    companion.complex_eigenvalues().iter().map(|z| (z.re, z.im)).collect()
}
