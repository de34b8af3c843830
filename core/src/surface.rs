//! Touchable surfaces: signed distance, outward normal, curvature and extent.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// Geometry of a surface, in fixture coordinates.
///
/// The **outward normal** points away from the material, to the side where the probe is; the **signed distance**
/// grows along it and is zero on the surface. A `bore` (or socket) is touched from inside: its outward normal
/// points toward the axis or centre.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// The plane through `point` with outward `normal`.
    Plane {
        /// A point of the plane.
        point: Point3<f64>,
        /// Outward normal.
        normal: Unit<Vector3<f64>>,
    },
    /// A circular cylinder.
    Cylinder {
        /// A point of the axis; extents along the axis count from it.
        point: Point3<f64>,
        /// Direction of the axis.
        axis: Unit<Vector3<f64>>,
        /// Radius of the surface.
        radius: f64,
        /// Touched from inside.
        bore: bool,
    },
    /// A sphere.
    Sphere {
        /// Centre.
        center: Point3<f64>,
        /// Radius of the surface.
        radius: f64,
        /// Touched from inside.
        bore: bool,
    },
    /// A circular cone (one nappe).
    Cone {
        /// Apex.
        apex: Point3<f64>,
        /// Direction of the axis, from the apex to growing radius.
        axis: Unit<Vector3<f64>>,
        /// Angle between axis and generator, radians, in `(0, pi/2)`.
        half_angle: f64,
        /// Touched from inside.
        bore: bool,
    },
}

impl Shape {
    /// The surface seen from `p` (fixture coordinates).
    ///
    /// On an axis or a centre, where no normal is defined, an arbitrary one of the possible normals is given.
    #[must_use]
    #[expect(
        clippy::inline_always,
        reason = "in every evaluation of every solver: a call costs as much as it does"
    )]
    #[inline(always)]
    pub fn seen_from(&self, p: &Point3<f64>) -> Proximity {
        match self {
            Shape::Plane { point, normal } => {
                Proximity { distance: normal.dot(&(p - point)), normal: **normal }
            }
            Shape::Cylinder { point, axis, radius, bore } => {
                let (_, rho, out) = about_axis(&(p - point), axis);
                sided(rho - radius, out, *bore)
            }
            Shape::Sphere { center, radius, bore } => {
                let (rho, out) = length_and_direction(&(p - center), &Vector3::z_axis());
                sided(rho - radius, out, *bore)
            }
            Shape::Cone { apex, axis, half_angle, bore } => {
                let (height, rho, out) = about_axis(&(p - apex), axis);
                let (sin, cos) = half_angle.sin_cos();
                sided(rho * cos - height * sin, out * cos - **axis * sin, *bore)
            }
        }
    }

    /// The second derivative of the signed distance at `p` (fixture coordinates), one over length.
    ///
    /// Undefined, and given as if at a distance of the smallest positive number, on an axis or a centre.
    #[must_use]
    pub fn curvature_at(&self, p: &Point3<f64>) -> Matrix3<f64> {
        let around = |axis: &Unit<Vector3<f64>>, q: Vector3<f64>| {
            let (_, rho, out) = about_axis(&q, axis);
            let tangent = axis.cross(&out);
            tangent * tangent.transpose() / rho.max(f64::MIN_POSITIVE)
        };
        let (curvature, bore) = match self {
            Shape::Plane { .. } => return Matrix3::zeros(),
            Shape::Cylinder { point, axis, bore, .. } => (around(axis, p - point), bore),
            Shape::Sphere { center, bore, .. } => {
                let (rho, out) = length_and_direction(&(p - center), &Vector3::z_axis());
                let tangents = Matrix3::identity() - out * out.transpose();
                (tangents / rho.max(f64::MIN_POSITIVE), bore)
            }
            Shape::Cone { apex, axis, half_angle, bore } => (around(axis, p - apex) * half_angle.cos(), bore),
        };
        if *bore { -curvature } else { curvature }
    }
}

/// The part of a surface that a probe can reach; used to simulate and to plan, never to solve.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Extent {
    /// Within `radius` of the plane's `point`.
    Disc {
        /// Radius of the disc.
        radius: f64,
    },
    /// From `from` to `to` along the axis, counted from the cylinder's `point` or the cone's apex.
    Along {
        /// Lower end.
        from: f64,
        /// Upper end.
        to: f64,
    },
    /// Within `half_angle` (radians) of direction `axis`, seen from a sphere's centre.
    Cap {
        /// Middle of the cap.
        axis: Unit<Vector3<f64>>,
        /// Angle from the middle to the rim, radians.
        half_angle: f64,
    },
}

/// One touchable geometric element of a fixture.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// The name that touches refer to.
    pub name: String,
    /// Its geometry.
    pub shape: Shape,
    /// The part a probe can reach.
    pub extent: Extent,
}

/// A surface seen from one point near it.
#[derive(Debug, Clone, Copy)]
pub struct Proximity {
    /// Signed distance from the surface, positive on the probe's side.
    pub distance: f64,
    /// Gradient of the distance: the outward normal at the foot of the point, a unit vector.
    pub normal: Vector3<f64>,
}

impl Surface {
    /// A surface from its parts.
    #[must_use]
    pub fn new(name: impl Into<String>, shape: Shape, extent: Extent) -> Self {
        Self { name: name.into(), shape, extent }
    }

    /// The surface seen from `p` (fixture coordinates): [`Shape::seen_from`].
    #[must_use]
    #[inline]
    pub fn seen_from(&self, p: &Point3<f64>) -> Proximity {
        self.shape.seen_from(p)
    }

    /// A point of the reachable part of the surface (fixture coordinates) for `(u, v)` in the unit square;
    /// uniform in area when `u` and `v` are uniform.
    #[must_use]
    pub fn point_at(&self, u: f64, v: f64) -> Point3<f64> {
        let turn = std::f64::consts::TAU * u;
        match (&self.shape, self.extent) {
            (Shape::Plane { point, normal }, Extent::Disc { radius }) => {
                let (e1, e2) = perpendiculars(normal);
                point + (e1 * turn.cos() + e2 * turn.sin()) * (radius * v.sqrt())
            }
            (Shape::Cylinder { point, axis, radius, .. }, Extent::Along { from, to }) => {
                let (e1, e2) = perpendiculars(axis);
                point + (e1 * turn.cos() + e2 * turn.sin()) * *radius + **axis * (from + (to - from) * v)
            }
            (Shape::Sphere { center, radius, .. }, Extent::Cap { axis, half_angle }) => {
                let (e1, e2) = perpendiculars(&axis);
                // Archimedes: area on a sphere is uniform in height.
                let height = 1.0 - v * (1.0 - half_angle.cos());
                let rim = (1.0 - height * height).max(0.0).sqrt();
                center + (*axis * height + (e1 * turn.cos() + e2 * turn.sin()) * rim) * *radius
            }
            (Shape::Cone { apex, axis, half_angle, .. }, Extent::Along { from, to }) => {
                let (e1, e2) = perpendiculars(axis);
                // The area below a height grows with its square.
                let height = (from * from + (to * to - from * from) * v).sqrt();
                let rim = height * half_angle.tan();
                apex + **axis * height + (e1 * turn.cos() + e2 * turn.sin()) * rim
            }
            // An extent of another kind limits nothing that this shape has: stay at its reference point.
            (Shape::Plane { point, .. }, _) => *point,
            (Shape::Cylinder { point, axis, radius, .. }, _) => point + perpendiculars(axis).0 * *radius,
            (Shape::Sphere { center, radius, .. }, _) => center + Vector3::z() * *radius,
            (Shape::Cone { apex, .. }, _) => *apex,
        }
    }

    /// The centre of a tip of radius `tip_radius` that touches the surface at `point` (both in fixture coordinates).
    #[must_use]
    pub fn tip_center(&self, point: &Point3<f64>, tip_radius: f64) -> Point3<f64> {
        point + self.seen_from(point).normal * tip_radius
    }

    /// The direction of a probe that meets the surface at `point` squarely (fixture coordinates): against the outward normal.
    #[must_use]
    pub fn approach(&self, point: &Point3<f64>) -> Unit<Vector3<f64>> {
        // Zero, not minus zero.
        Unit::new_unchecked(self.seen_from(point).normal.map(|v| 0.0 - v))
    }

    /// The line about which the surface may spin without being changed: point and direction.
    #[must_use]
    pub fn axis(&self) -> Option<(Point3<f64>, Unit<Vector3<f64>>)> {
        match &self.shape {
            Shape::Cylinder { point, axis, .. } => Some((*point, *axis)),
            Shape::Cone { apex, axis, .. } => Some((*apex, *axis)),
            Shape::Plane { .. } | Shape::Sphere { .. } => None,
        }
    }
}

/// Distance and normal of a surface with the material inside, or outside for a bore.
#[inline]
fn sided(distance: f64, normal: Vector3<f64>, bore: bool) -> Proximity {
    if bore { Proximity { distance: -distance, normal: -normal } } else { Proximity { distance, normal } }
}

/// Height along the axis, distance from it, and the direction away from it.
#[inline]
fn about_axis(q: &Vector3<f64>, axis: &Unit<Vector3<f64>>) -> (f64, f64, Vector3<f64>) {
    let height = axis.dot(q);
    let (rho, out) = length_and_direction(&(q - **axis * height), axis);
    (height, rho, out)
}

/// Length and direction; the zero vector gets a direction perpendicular to `unless`.
#[inline]
fn length_and_direction(v: &Vector3<f64>, unless: &Unit<Vector3<f64>>) -> (f64, Vector3<f64>) {
    let length = v.norm();
    (length, if length > 0.0 { v / length } else { perpendiculars(unless).0 })
}

/// Two unit vectors that complete the unit vector `axis` to a right-handed triad `(e1, e2, axis)`.
///
/// For the coordinate axis Z they are X and Y.
#[must_use]
pub fn perpendiculars(axis: &Unit<Vector3<f64>>) -> (Vector3<f64>, Vector3<f64>) {
    let reference = if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let e1 = (reference - **axis * axis.dot(&reference)).normalize();
    (e1, axis.cross(&e1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_6;

    fn every_shape() -> Vec<Surface> {
        let axis = Unit::new_normalize(Vector3::new(0.2, -0.5, 0.8));
        let along = Extent::Along { from: 1.0, to: 9.0 };
        let point = Point3::new(1.0, 2.0, 3.0);
        let mut all =
            vec![Surface::new("plane", Shape::Plane { point, normal: axis }, Extent::Disc { radius: 5.0 })];
        for bore in [false, true] {
            all.push(Surface::new("cylinder", Shape::Cylinder { point, axis, radius: 4.0, bore }, along));
            all.push(Surface::new(
                "sphere",
                Shape::Sphere { center: point, radius: 4.0, bore },
                Extent::Cap { axis, half_angle: 1.0 },
            ));
            all.push(Surface::new(
                "cone",
                Shape::Cone { apex: point, axis, half_angle: FRAC_PI_6, bore },
                along,
            ));
        }
        all
    }

    #[test]
    fn distance_has_the_stated_gradient_and_hessian() {
        // Central differences of step 1e-4: truncation 1e-8 of a third derivative below 1, rounding 1e-12 / step.
        const STEP: f64 = 1e-4;
        const TOLERANCE: f64 = 1e-6;
        for surface in every_shape() {
            let p = Point3::new(3.3, -1.2, 7.1);
            let here = surface.seen_from(&p);
            for axis in 0..3 {
                let d = Vector3::ith(axis, STEP);
                let (up, down) = (surface.seen_from(&(p + d)), surface.seen_from(&(p - d)));
                let slope = (up.distance - down.distance) / (2.0 * STEP);
                assert!((slope - here.normal[axis]).abs() < TOLERANCE, "{}", surface.name);
                let bending = (up.normal - down.normal) / (2.0 * STEP);
                let hessian = surface.shape.curvature_at(&p);
                assert!((bending - hessian.column(axis)).norm() < TOLERANCE, "{}", surface.name);
            }
        }
    }

    #[test]
    fn points_of_a_surface_lie_on_it_and_tips_a_radius_away() {
        for surface in every_shape() {
            for (u, v) in [(0.0, 0.0), (0.3, 0.7), (0.9, 1.0)] {
                let p = surface.point_at(u, v);
                assert!(surface.seen_from(&p).distance.abs() < 1e-13, "{} at {p}", surface.name);
                let tip = surface.tip_center(&p, 0.5);
                assert!((surface.seen_from(&tip).distance - 0.5).abs() < 1e-13, "{}", surface.name);
            }
        }
    }

    /// Equal parts of the unit square are equal areas, and its edges those of the reachable part.
    #[test]
    fn points_of_a_surface_are_uniform_in_area() {
        // Central differences: truncation 1e-8 of third derivatives, rounding 1e-14 / step.
        const STEP: f64 = 1e-4;
        const TOLERANCE: f64 = 1e-5;
        for surface in every_shape() {
            let area = |u: f64, v: f64| {
                let along_u = surface.point_at(u + STEP, v) - surface.point_at(u - STEP, v);
                let along_v = surface.point_at(u, v + STEP) - surface.point_at(u, v - STEP);
                along_u.cross(&along_v).norm() / (4.0 * STEP * STEP)
            };
            let expected = area(0.5, 0.5);
            for (u, v) in [(0.1, 0.2), (0.3, 0.7), (0.9, 0.95)] {
                let off = area(u, v) / expected - 1.0;
                assert!(off.abs() < TOLERANCE, "{} at {u}, {v}: {off:e}", surface.name);
            }
            let heights = |axis: &Vector3<f64>, from: &Point3<f64>| {
                [0.0, 1.0].map(|v| axis.dot(&(surface.point_at(0.3, v) - from)))
            };
            let (edges, stated) = match (&surface.shape, surface.extent) {
                (Shape::Plane { point, .. }, Extent::Disc { radius }) => {
                    ([0.0, 1.0].map(|v| (surface.point_at(0.3, v) - point).norm()), [0.0, radius])
                }
                (Shape::Sphere { center, radius, .. }, Extent::Cap { axis, half_angle }) => {
                    (heights(&axis, center), [*radius, radius * half_angle.cos()])
                }
                (
                    Shape::Cylinder { point, axis, .. } | Shape::Cone { apex: point, axis, .. },
                    Extent::Along { from, to },
                ) => (heights(axis, point), [from, to]),
                _ => unreachable!("every shape has its own extent"),
            };
            for (edge, stated) in edges.into_iter().zip(stated) {
                assert!((edge - stated).abs() < 1e-13, "{}: {edge}, {stated}", surface.name);
            }
        }
    }
}
