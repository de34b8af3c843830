//! Frames: where a fixture stands in its parent, and small motions of it.

use nalgebra::{Matrix3, Matrix4, Matrix6, Point3, Rotation3, Unit, Vector3, Vector6};

/// The direction of a vector of any length above zero; `None` when it is zero or a number is not finite.
#[must_use]
pub fn direction(vector: Vector3<f64>) -> Option<Unit<Vector3<f64>>> {
    // Scaled first: the squares of very small or large components leave the range of numbers.
    let scaled = vector / vector.amax();
    Unit::try_new(scaled, 0.0).filter(|unit| unit.iter().all(|v| v.is_finite()))
}

/// Pose of the fixture in the parent frame (robot base, machine coordinates).
///
/// `p_parent = rotation * p_fixture + origin`; the columns of `rotation` are the fixture's X, Y and Z axes
/// seen from the parent. Lengths are in the caller's one consistent unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Rotation fixture -> parent.
    pub rotation: Rotation3<f64>,
    /// The fixture's origin, in the parent.
    pub origin: Point3<f64>,
}

impl Frame {
    /// The frame that coincides with its parent.
    #[must_use]
    pub fn identity() -> Self {
        Self { rotation: Rotation3::identity(), origin: Point3::origin() }
    }

    /// A frame from its origin and two of its axes, in the parent: `z` is kept, `x` is made perpendicular to it.
    ///
    /// `None` when either is not finite, is zero, or when they are parallel.
    #[must_use]
    pub fn from_z_and_x(origin: Point3<f64>, z: Vector3<f64>, x: Vector3<f64>) -> Option<Self> {
        let z = z.try_normalize(0.0)?;
        let x = (x - z * z.dot(&x)).try_normalize(0.0)?;
        let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
        let frame = Self { rotation: Rotation3::from_matrix_unchecked(axes), origin };
        frame.is_sound().then_some(frame)
    }

    /// A frame from a quaternion `[x, y, z, w]` of any length above zero and an origin.
    ///
    /// `None` when a number is not finite or the quaternion is zero.
    #[must_use]
    pub fn from_quaternion_xyzw(origin: Point3<f64>, xyzw: [f64; 4]) -> Option<Self> {
        let [x, y, z, w] = xyzw;
        let finite = xyzw.iter().chain(origin.iter()).all(|v| v.is_finite());
        // The square of a very long or short one would leave the range of numbers.
        let largest = xyzw.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
        let scale = if (1e-100..1e100).contains(&largest) { 1.0 } else { largest };
        let quaternion = nalgebra::Quaternion::new(w, x, y, z) / scale;
        let unit = nalgebra::UnitQuaternion::try_new(quaternion, 0.0)?;
        finite.then(|| Self { rotation: unit.to_rotation_matrix(), origin })
    }

    /// Whether it is one: every number finite, and the axes unit, perpendicular and right-handed. What was computed from
    /// absurd numbers may not be.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        /// Rounding of a rotation, far below what any use would notice.
        const ROUNDING: f64 = 1e-9;
        let axes = self.rotation.matrix();
        let off = axes.tr_mul(axes) - Matrix3::identity();
        // The greatest of them would not show what is no number.
        off.iter().all(|v| v.abs() < ROUNDING)
            && axes.determinant() > 0.0
            && self.origin.iter().all(|v| v.is_finite())
    }

    /// Maps a point given in fixture coordinates into the parent.
    #[must_use]
    pub fn to_parent(&self, point: &Point3<f64>) -> Point3<f64> {
        self.origin + self.rotation * point.coords
    }

    /// Maps a point given in the parent into fixture coordinates.
    #[must_use]
    #[inline]
    pub fn to_fixture(&self, point: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation.matrix().tr_mul(&(point - self.origin)))
    }

    /// The frame after a small motion told along the **fixture's** axes, about the fixture's origin:
    /// `origin + R v`, `R exp(w)`.
    #[must_use]
    #[inline]
    pub fn moved(&self, twist: &Twist) -> Self {
        Self {
            rotation: self.rotation * exp(&twist.rotation),
            origin: self.origin + self.rotation * twist.translation,
        }
    }

    /// The twist that [`moved`](Self::moved) would need to reach `other`: translation and rotation vector, along
    /// this frame's axes.
    #[must_use]
    pub fn twist_to(&self, other: &Self) -> Twist {
        let inverse = self.rotation.inverse();
        let between = Self { rotation: inverse * other.rotation, origin: Point3::origin() };
        Twist { translation: inverse * (other.origin - self.origin), rotation: between.rotation_vector() }
    }

    /// The motion that leads to `other`, in the order and along the axes of a covariance: translation of the origin and
    /// rotation vector, along the **parent's** axes.
    #[must_use]
    pub fn error_to(&self, other: &Self) -> Vector6<f64> {
        self.twist_to(other).turned(&self.rotation).into()
    }

    /// This frame as seen from another parent, whose pose is `grandparent`.
    #[must_use]
    pub fn seen_from(&self, grandparent: &Self) -> Self {
        Self { rotation: grandparent.rotation * self.rotation, origin: grandparent.to_parent(&self.origin) }
    }

    /// The rotation as a unit quaternion `[x, y, z, w]` with `w >= 0` (when `w` is 0 the first of x, y, z that is
    /// not zero is positive).
    ///
    /// Shepperd's four branches: no cancellation at any angle.
    #[must_use]
    pub fn quaternion_xyzw(&self) -> [f64; 4] {
        let m = self.rotation.matrix();
        let diagonal = [m[(0, 0)], m[(1, 1)], m[(2, 2)]];
        let trace = diagonal.iter().sum::<f64>();
        // Four times the square of w, x, y and z in turn; divide by the largest.
        let w4 = 1.0 + trace;
        let largest = (0..3).max_by(|&a, &b| diagonal[a].total_cmp(&diagonal[b])).unwrap_or(0);
        let mut q = [0.0; 4];
        if w4 >= 1.0 + 2.0 * diagonal[largest] - trace {
            q[0] = m[(2, 1)] - m[(1, 2)];
            q[1] = m[(0, 2)] - m[(2, 0)];
            q[2] = m[(1, 0)] - m[(0, 1)];
            q[3] = w4;
        } else {
            let (i, j, k) = (largest, (largest + 1) % 3, (largest + 2) % 3);
            q[i] = 1.0 + 2.0 * diagonal[i] - trace;
            q[j] = m[(i, j)] + m[(j, i)];
            q[k] = m[(i, k)] + m[(k, i)];
            q[3] = m[(k, j)] - m[(j, k)];
        }
        let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
        let leading = if q[3] == 0.0 { q.iter().copied().find(|v| *v != 0.0).unwrap_or(1.0) } else { q[3] };
        let scale = norm.copysign(leading);
        q.map(|v| v / scale + 0.0)
    }

    /// The rotation as a rotation vector in radians, angle in `[0, pi]`.
    #[must_use]
    pub fn rotation_vector(&self) -> Vector3<f64> {
        let [x, y, z, w] = self.quaternion_xyzw();
        let v = Vector3::new(x, y, z);
        let sine = v.norm();
        if sine == 0.0 { 2.0 * v } else { v * (2.0 * sine.atan2(w) / sine) }
    }

    /// The homogeneous 4x4 matrix that maps fixture coordinates into the parent.
    #[must_use]
    pub fn matrix(&self) -> Matrix4<f64> {
        let mut m = self.rotation.matrix().to_homogeneous();
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.origin.coords);
        m
    }

    /// The fixture's X, Y or Z axis (0, 1, 2) in the parent.
    #[must_use]
    pub fn axis(&self, index: usize) -> Vector3<f64> {
        self.rotation.matrix().column(index).into()
    }

    /// Turns a 6x6 matrix over a twist along the fixture's axes (a covariance, say) into the same over a twist
    /// along the parent's axes, both about the fixture's origin.
    #[must_use]
    pub fn to_parent_axes(&self, about_fixture_axes: &Matrix6<f64>) -> Matrix6<f64> {
        let mut both = Matrix6::zeros();
        both.fixed_view_mut::<3, 3>(0, 0).copy_from(self.rotation.matrix());
        both.fixed_view_mut::<3, 3>(3, 3).copy_from(self.rotation.matrix());
        both * about_fixture_axes * both.transpose()
    }
}

/// An infinitesimal motion: three translations and a rotation vector (radians), about an origin and along axes
/// that the user of the twist states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    /// Translation of the origin.
    pub translation: Vector3<f64>,
    /// Rotation vector, radians.
    pub rotation: Vector3<f64>,
}

impl Twist {
    /// The same motion along other axes, about the same origin: `rotation` leads from these axes to those, as a frame's does
    /// from the fixture's to the parent's.
    #[must_use]
    pub fn turned(&self, rotation: &Rotation3<f64>) -> Self {
        Self { translation: rotation * self.translation, rotation: rotation * self.rotation }
    }

    /// How large the motion is beside something of this size: translation in parts of it, plus rotation in radians.
    #[must_use]
    pub fn extent(&self, size: f64) -> f64 {
        self.translation.norm() / size + self.rotation.norm()
    }
}

impl From<Vector6<f64>> for Twist {
    fn from(v: Vector6<f64>) -> Self {
        Self { translation: v.fixed_rows::<3>(0).into(), rotation: v.fixed_rows::<3>(3).into() }
    }
}

impl From<Twist> for Vector6<f64> {
    fn from(t: Twist) -> Self {
        let (v, w) = (t.translation, t.rotation);
        Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
    }
}

/// The rotation by a rotation vector (Rodrigues), exact near zero.
#[inline]
fn exp(w: &Vector3<f64>) -> Rotation3<f64> {
    /// Square of half an angle (0.25 rad) below which the series end beneath rounding; steps of iterations are shorter.
    const SMALL: f64 = 1.0 / 16.0;
    let x = 0.25 * w.norm_squared();
    // cos(t/2), and sin(t/2) / t.
    let (cos, factor) = if x < SMALL {
        let cos = 1.0
            + x * (-1.0 / 2.0
                + x * (1.0 / 24.0 + x * (-1.0 / 720.0 + x * (1.0 / 40_320.0 + x * (-1.0 / 3_628_800.0)))));
        let sinc = 1.0
            + x * (-1.0 / 6.0
                + x * (1.0 / 120.0
                    + x * (-1.0 / 5_040.0 + x * (1.0 / 362_880.0 + x * (-1.0 / 39_916_800.0)))));
        (cos, 0.5 * sinc)
    } else {
        let half = x.sqrt();
        (half.cos(), half.sin() / (2.0 * half))
    };
    // A unit quaternion, to rounding.
    let q = nalgebra::Quaternion::from_parts(cos, w * factor);
    nalgebra::UnitQuaternion::new_unchecked(q).to_rotation_matrix()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_may_have_any_length_above_zero() {
        for length in [1.0, 1e-300, f64::from_bits(1), 1e300, f64::MAX] {
            assert_eq!(direction(Vector3::y() * length), Some(Vector3::y_axis()), "{length:e}");
        }
        for length in [0.0, f64::INFINITY, f64::NAN] {
            assert_eq!(direction(Vector3::repeat(length)), None);
        }
    }

    #[test]
    fn a_quaternion_may_have_any_length_above_zero() {
        let turn = |length: f64| Frame::from_quaternion_xyzw(Point3::origin(), [0.0, 0.0, length, length]);
        for length in [1.0, 1e-160, 1e-300, f64::from_bits(1), 1e160, f64::MAX] {
            let frame = turn(length).unwrap();
            assert!(
                frame.is_sound() && (frame.axis(0) - Vector3::y()).norm() < 1e-15,
                "{length:e}: {frame:?}"
            );
        }
        for length in [0.0, f64::INFINITY, f64::NAN] {
            assert_eq!(turn(length), None);
        }
    }

    /// Short turns add up to long ones: on either side of where the series give way.
    #[test]
    fn small_turns_add_up() {
        let axis = Vector3::new(0.6, -0.64, 0.48);
        for angle in [1e-9, 1e-3, 0.1, 0.49, 0.4999, 0.5, 0.5001, 0.6, 3.0] {
            let turned = |by: f64| exp(&(axis * by)).matrix().clone_owned();
            let (whole, half) = (turned(angle), turned(0.5 * angle));
            assert!((whole - half * half).abs().max() < 4.0 * f64::EPSILON, "{angle}");
            let expected = Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), angle);
            assert!((whole - expected.matrix()).abs().max() < 4.0 * f64::EPSILON, "{angle}");
        }
    }

    /// Product of elementary rotations, the independent way to build one.
    fn zyx(z: f64, y: f64, x: f64) -> Frame {
        let about = |axis, degrees: f64| Rotation3::from_axis_angle(&axis, degrees.to_radians());
        let rotation =
            about(Vector3::z_axis(), z) * about(Vector3::y_axis(), y) * about(Vector3::x_axis(), x);
        Frame { rotation, origin: Point3::new(1.0, 2.0, 3.0) }
    }

    #[test]
    fn quaternion_of_known_rotations() {
        // Values from composition of elementary rotations at higher precision.
        let golden = [
            (zyx(30.0, 20.0, 10.0), [0.038_134_576, 0.189_307_857, 0.239_298_338, 0.951_548_525]),
            (zyx(0.0, 0.0, 180.0), [1.0, 0.0, 0.0, 0.0]),
            (zyx(0.0, 0.0, 179.98), [0.999_999_985, 0.0, 0.0, 0.000_174_533]),
            (zyx(-135.0, -35.0, 170.0), [0.339_369_595, -0.887_796_103, 0.037_842_601, 0.308_568_137]),
        ];
        for (frame, expected) in golden {
            for (got, want) in frame.quaternion_xyzw().iter().zip(expected) {
                assert!((got - want).abs() < 1e-9, "{:?} {expected:?}", frame.quaternion_xyzw());
            }
        }
    }

    #[test]
    fn a_twist_brings_one_frame_to_the_other() {
        let (from, to) = (zyx(30.0, 20.0, 10.0), zyx(-100.0, 70.0, 160.0));
        let reached = from.moved(&from.twist_to(&to));
        assert!((reached.matrix() - to.matrix()).norm() < 1e-14);
    }

    #[test]
    fn points_go_to_the_parent_and_back() {
        let frame = zyx(-20.0, 80.0, 15.0);
        let p = Point3::new(3.0, -4.0, 5.0);
        assert!((frame.to_fixture(&frame.to_parent(&p)) - p).norm() < 1e-14);
    }

    #[test]
    fn what_is_no_rotation_or_no_number_is_no_frame() {
        let sound = zyx(30.0, 20.0, 10.0);
        assert!(sound.is_sound());
        let with = |axes| Frame { rotation: Rotation3::from_matrix_unchecked(axes), ..sound };
        let axes = *sound.rotation.matrix();
        assert!(!with(-axes).is_sound(), "left-handed");
        assert!(!with(axes * 1.001).is_sound(), "too long");
        for bad in [f64::NAN, f64::INFINITY] {
            for k in 0..9 {
                let mut axes = axes;
                axes[k] = bad;
                assert!(!with(axes).is_sound(), "{axes}");
            }
            for k in 0..3 {
                let mut origin = sound.origin;
                origin[k] = bad;
                assert!(!Frame { origin, ..sound }.is_sound(), "{origin}");
            }
        }
    }
}
