//! Motions that a fixture leaves free by its nature: the spin of a bore about its own axis.

use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3, Vector6};

use crate::Frame;

/// Names of the motions along and about the fixture's axes, in the order of a [`crate::Twist`].
pub const MOTIONS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Motions along the fixture's own axes about its origin that move none of its surfaces off itself, so that no touch can
/// see them and a frame need not fix them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Freedom([bool; 6]);

impl Freedom {
    /// Nothing is free.
    pub const NONE: Self = Self([false; 6]);

    /// These of [`MOTIONS`] are free; `None` for a name that is none of them, and for turns about two axes, which make
    /// the third.
    #[must_use]
    pub fn from_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<Self> {
        let mut free = [false; 6];
        for name in names {
            free[MOTIONS.iter().position(|motion| *motion == name)?] = true;
        }
        let turns = free[3..].iter().filter(|turn| **turn).count();
        (turns != 2).then_some(Self(free))
    }

    /// Whether motion `index` of [`MOTIONS`] is free.
    #[must_use]
    #[inline]
    pub fn is_free(&self, index: usize) -> bool {
        self.0[index]
    }

    /// How many are free.
    #[must_use]
    #[inline]
    pub fn count(&self) -> usize {
        self.0.iter().filter(|free| **free).count()
    }

    /// The names of the free ones.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + '_ {
        MOTIONS.into_iter().zip(self.0).filter(|(_, free)| *free).map(|(name, _)| name)
    }

    /// A motion along the fixture's axes without what is free of it.
    #[must_use]
    pub fn without(&self, motion: &Vector6<f64>) -> Vector6<f64> {
        Vector6::from_fn(|i, _| if self.0[i] { 0.0 } else { motion[i] })
    }

    /// Of all the frames that `frame` may be without any touch seeing it, the one that stands nearest `to`: turned
    /// least from its axes, the origin as near to its origin as it gets.
    #[must_use]
    pub fn nearest(&self, frame: &Frame, to: &Frame) -> Frame {
        let turns = self.0[3..].iter().filter(|turn| **turn).count();
        let seen = frame.rotation.inverse() * to.rotation;
        let turn = match turns {
            0 => Rotation3::identity(),
            1 => {
                let about = (0..3).find(|axis| self.0[3 + axis]).unwrap_or(0);
                turn_about(about, seen.matrix())
            }
            _ => seen,
        };
        let offset = frame.rotation.inverse() * (to.origin - frame.origin);
        let slide = Vector3::from_fn(|i, _| if self.0[i] { offset[i] } else { 0.0 });
        Frame { rotation: frame.rotation * turn, origin: frame.origin + frame.rotation * slide }
    }
}

/// The turn about a coordinate axis that comes nearest the rotation `seen`: it has the largest trace of `turn^T seen`.
fn turn_about(axis: usize, seen: &Matrix3<f64>) -> Rotation3<f64> {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let (sin, cos) = (seen[(k, j)] - seen[(j, k)], seen[(j, j)] + seen[(k, k)]);
    // Half a turn about a perpendicular axis is as far from every one.
    let angle = if sin == 0.0 && cos == 0.0 { 0.0 } else { sin.atan2(cos) };
    Rotation3::from_axis_angle(&Unit::new_unchecked(Vector3::ith(axis, 1.0)), angle)
}

impl Frame {
    /// The parent's axes, at a point of it.
    #[must_use]
    pub fn parallel_at(origin: Point3<f64>) -> Self {
        Self { rotation: Rotation3::identity(), origin }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Twist;

    #[test]
    fn a_free_motion_brings_a_frame_as_near_as_it_goes() {
        let frame = Frame::from_quaternion_xyzw(Point3::new(1.0, 2.0, 3.0), [0.1, -0.4, 0.3, 0.8]).unwrap();
        let to = Frame::from_quaternion_xyzw(Point3::new(-4.0, 0.5, 9.0), [0.2, 0.3, -0.1, 0.9]).unwrap();
        for names in [&["rz"][..], &["z", "rz"], &["x", "y", "rz"], &["rx", "ry", "rz"], &["x"], &["ry"]] {
            let freedom = Freedom::from_names(names.iter().copied()).unwrap();
            assert_eq!(freedom.names().collect::<Vec<_>>(), names);
            let near = freedom.nearest(&frame, &to);
            let angle = |frame: &Frame| frame.rotation.rotation_to(&to.rotation).angle();
            // No free motion brings it nearer.
            for index in (0..6).filter(|index| freedom.is_free(*index)) {
                for step in [1e-3, -1e-3] {
                    let moved = near.moved(&Twist::from(Vector6::ith(index, step)));
                    assert!(angle(&moved) >= angle(&near) - 1e-12, "{names:?}");
                    assert!((moved.origin - to.origin).norm() >= (near.origin - to.origin).norm() - 1e-12);
                }
            }
            assert!((freedom.nearest(&near, &to).twist_to(&near)).extent(1.0) < 1e-14);
        }
        assert_eq!(Freedom::from_names(["rx", "ry"]), None);
        assert_eq!(Freedom::from_names(["w"]), None);
        assert_eq!(Freedom::NONE.nearest(&frame, &to), frame);
    }
}
