//! Rotations as three angles, in all twelve orders, exact at and near their locks.
//!
//! At a lock two of the three angles turn about one axis, and only their sum or difference means anything. The textbook
//! formulas, and those of many libraries, are off by degrees there. Here the middle angle comes from the pair that is
//! always well conditioned, one outer angle from its own pair, and the other one **with that angle put in**, so that
//! noise in the first cancels in the product. Conventions: J. Diebel, "Representing Attitude: Euler Angles, Unit
//! Quaternions, and Rotation Vectors", 2006.

use nalgebra::{Rotation3, Vector3};

/// Sine (or cosine) of the middle angle below which it counts as locked. It only selects which of the many triples is
/// printed; the error it may make is its own size, in radians.
const LOCK: f64 = 1e-12;

/// About which axes, moving with the body, three angles turn in turn: 0, 1, 2 for X, Y, Z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Order([usize; 3]);

impl Order {
    /// First Z, then the Y so reached, then the X so reached: `Rz Ry Rx`. The same as about the fixed X, then Y, then Z.
    pub(super) const ZYX: Self = Self([2, 1, 0]);
    /// `Rx Ry Rz`.
    pub(super) const XYZ: Self = Self([0, 1, 2]);
    /// `Rz Ry Rz`; a frame that lies parallel to its parent is at the lock.
    pub(super) const ZYZ: Self = Self([2, 1, 2]);
    /// `Rz Rx Rz`; with the same lock.
    pub(super) const ZXZ: Self = Self([2, 0, 2]);

    /// The names of all twelve orders.
    pub(super) const NAMES: &'static [&'static str] =
        &["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"];

    /// The order of this name, one of [`NAMES`](Self::NAMES).
    pub(super) fn from_name(name: &str) -> Option<Self> {
        let axis = |letter: u8| usize::from(letter - b'x');
        match name.as_bytes() {
            [a, b, c] if Self::NAMES.contains(&name) => Some(Self([axis(*a), axis(*b), axis(*c)])),
            _ => None,
        }
    }

    /// The same axes the other way round: angles about fixed axes are those about moving axes in reverse.
    pub(super) fn reversed(self) -> Self {
        let [a, b, c] = self.0;
        Self([c, b, a])
    }

    /// The axes, first to last.
    pub(super) fn axes(self) -> [usize; 3] {
        self.0
    }

    /// Whether the first axis is also the last.
    pub(super) fn is_proper(self) -> bool {
        self.0[0] == self.0[2]
    }

    /// The product of the three elementary rotations, angles in radians.
    pub(super) fn rotation(self, angles: [f64; 3]) -> Rotation3<f64> {
        let about = |axis: usize, angle: f64| {
            Rotation3::from_axis_angle(
                &[Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()][axis],
                angle,
            )
        };
        let [i, j, k] = self.0;
        about(i, angles[0]) * about(j, angles[1]) * about(k, angles[2])
    }

    /// The three angles of a rotation, radians: outer ones in `(-pi, pi]`, the middle one in `[-pi/2, pi/2]`, in `[0, pi]`
    /// where the first axis is also the last.
    ///
    /// At the lock the last angle is 0; the first one where the first axis is also the last.
    pub(super) fn angles(self, rotation: &Rotation3<f64>) -> [f64; 3] {
        let [i, j, last] = self.0;
        let k = 3 - i - j;
        // Axes in cyclic order turn to the right as X, Y, Z do; in the other order the outer signs change.
        let sign = if (j + 3 - i) % 3 == 1 { 1.0 } else { -1.0 };
        let r = |row: usize, column: usize| rotation[(row, column)];
        if last == i {
            let sine = r(j, i).hypot(r(k, i));
            let first = if sine > LOCK { r(j, i).atan2(-sign * r(k, i)) } else { 0.0 };
            let (s, c) = first.sin_cos();
            let third = (-sign * (c * r(j, k) + sign * s * r(k, k))).atan2(c * r(j, j) + sign * s * r(k, j));
            [first, sine.atan2(r(i, i)), third]
        } else {
            let cosine = r(i, i).hypot(r(i, j));
            let third = if cosine > LOCK { (-sign * r(i, j)).atan2(r(i, i)) } else { 0.0 };
            let (s, c) = third.sin_cos();
            let first = (sign * (c * r(k, j) + sign * s * r(k, i))).atan2(c * r(j, j) + sign * s * r(j, i));
            [first, (sign * r(i, k)).atan2(cosine), third]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(name: &str) -> Order {
        Order::from_name(name).unwrap()
    }

    /// Angle of the rotation between two.
    fn between(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
        // Small angles would be lost in the cosine.
        let off = (a.matrix() - b.matrix()).norm() / 8f64.sqrt();
        2.0 * off.min(1.0).asin()
    }

    #[test]
    fn every_order_comes_back_near_every_lock() {
        /// Twice the worst of the recipes, at sines that the lock just does not catch.
        const WORST: f64 = 4e-12;
        let outer = [-3.1, -2.0, -0.5, 0.0, 1e-9, 0.7, 1.6, 3.0, std::f64::consts::PI];
        let quarter = std::f64::consts::FRAC_PI_2;
        let near = (1..=16).map(|k| 10f64.powi(-k)).chain([0.0, 0.4, 1.2]);
        let middles: Vec<f64> =
            near.flat_map(|d| [d, -d, quarter - d, quarter + d, -quarter + d, 2.0 * quarter - d]).collect();
        for name in Order::NAMES {
            for &first in &outer {
                for &last in &outer {
                    for &middle in &middles {
                        let rotation = order(name).rotation([first, middle, last]);
                        let back = order(name).rotation(order(name).angles(&rotation));
                        let off = between(&rotation, &back);
                        assert!(off < WORST, "{name} {first} {middle} {last}: {off:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn away_from_the_lock_the_angles_are_those_it_was_made_of() {
        for name in Order::NAMES {
            let angles = [0.3, 0.7, -1.1];
            let got = order(name).angles(&order(name).rotation(angles));
            assert!(got.iter().zip(angles).all(|(g, w)| (g - w).abs() < 1e-14), "{name}: {got:?}");
        }
    }

    #[test]
    fn at_the_lock_one_angle_is_zero() {
        let quarter = std::f64::consts::FRAC_PI_2;
        for name in Order::NAMES {
            let (order, proper) = (order(name), order(name).is_proper());
            for middle in if proper { [0.0, 2.0 * quarter] } else { [quarter, -quarter] } {
                let [first, _, third] = order.angles(&order.rotation([0.4, middle, 0.9]));
                assert!(if proper { first == 0.0 } else { third == 0.0 }, "{name} {first} {third}");
            }
        }
    }

    #[test]
    fn only_the_twelve_orders_have_names() {
        for wrong in ["", "xxy", "zyxz", "ZYX", "abc", "zz", "xyy"] {
            assert_eq!(Order::from_name(wrong), None, "{wrong}");
        }
        assert_eq!((order("zyx"), order("zxz")), (Order::ZYX, Order::ZXZ));
        assert_eq!((order("xyz"), order("zyz")), (Order::XYZ, Order::ZYZ));
    }
}
