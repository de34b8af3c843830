//! One surface by itself: a plane, sphere, cylinder or cone through points, its sizes free, without a starting guess.
//!
//! Minimises the sum of squared orthogonal distances (Gaussian association, as in ISO 10360-6). Distances and their
//! derivatives are those of a frame that is fitted to the surface, with only those motions that the surface shows: a
//! cylinder neither slides along its axis nor turns about it. Starts are directions all over a half sphere (for a cone,
//! a whole one), each with the size that a linear equation gives; every distinct minimum is counted.
//!
//! A. B. Forbes, "Least-squares best-fit geometric elements", NPL report DITC 140/89 (1991), for the unknowns; C. M.
//! Shakarji, "Least-squares fitting algorithms of the NIST algorithm testing system", J. Res. NIST 103 (1998) 633.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{DMatrix, DVector, Matrix3, Point3, Unit, Vector3, Vector6};
use thiserror::Error;
use touchref_core::{Contact, Frame, Shape, Twist};

use crate::{
    levenberg_marquardt::{SumOfSquares, damped_step, descend},
    model::{Normal, Row},
};

/// Which surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElementKind {
    /// A plane: three points or more.
    Plane,
    /// A sphere: four or more.
    Sphere,
    /// A circular cylinder: five or more.
    Cylinder,
    /// A circular cone: six or more.
    Cone,
}

impl ElementKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Plane, Self::Sphere, Self::Cylinder, Self::Cone];

    /// In a word, for messages and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::Sphere => "sphere",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
        }
    }

    /// The fewest points that determine one: as many as unknowns.
    #[must_use]
    pub fn fewest(self) -> usize {
        match self {
            Self::Plane => 3,
            Self::Sphere => 4,
            Self::Cylinder => 5,
            Self::Cone => 6,
        }
    }
}

/// A surface fitted to points.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    /// The surface, as one touched from outside; a cone's direction points to growing radius.
    pub shape: Shape,
    /// The point of its axis, or of a plane, that is nearest the points' mean; a sphere's centre.
    pub point: Point3<f64>,
    /// Root mean square of the points' distances.
    pub rms: f64,
    /// Distinct minima seen, this lowest one included.
    pub minima: usize,
    /// Root mean square of the points' distances at the next lowest one, if there is one.
    pub second_rms: Option<f64>,
    /// From the residuals; `None` where there are no more points than unknowns.
    pub covariance: Option<ElementCovariance>,
}

/// Covariances of what describes an element, along the axes of the points' coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementCovariance {
    /// Of its point: across the axis, or along a plane's normal; of a sphere's centre.
    pub point: Matrix3<f64>,
    /// Of its direction, radians; zero for a sphere.
    pub direction: Matrix3<f64>,
    /// Variances of its radius (a cone's: at its point) and of a cone's half-angle (radians), where it has them.
    pub sizes: [f64; 2],
}

/// Why no surface is determined.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum ElementError {
    /// Fewer points than unknowns.
    #[error("{} points for a {}; at least {}", .count, .kind.name(), .kind.fewest())]
    TooFew {
        /// The surface wanted.
        kind: ElementKind,
        /// How many points there are.
        count: usize,
    },
    /// A coordinate that is no number.
    #[error("point {index} is not finite")]
    NotFinite {
        /// The first such point, counted from 0.
        index: usize,
    },
    /// The points leave it free: a line for a plane, a plane for a sphere, and so on.
    #[error("the points do not determine a {}: they lie in a point, a line or a plane, or fit none better than a flat one", .kind.name())]
    Degenerate {
        /// The surface wanted.
        kind: ElementKind,
    },
}

/// Fits a surface to points.
///
/// # Errors
/// [`ElementError`]: too few points, one that is not finite, or points that leave the surface free.
pub fn fit(kind: ElementKind, points: &[Point3<f64>]) -> Result<Element, ElementError> {
    if points.len() < kind.fewest() {
        return Err(ElementError::TooFew { kind, count: points.len() });
    }
    if let Some(index) = points.iter().position(|point| !point.coords.iter().all(|v| v.is_finite())) {
        return Err(ElementError::NotFinite { index });
    }
    match kind {
        ElementKind::Plane => Cloud::of(points).fit::<3>(kind),
        ElementKind::Sphere => Cloud::of(points).fit::<4>(kind),
        ElementKind::Cylinder => Cloud::of(points).fit::<5>(kind),
        ElementKind::Cone => Cloud::of(points).fit::<6>(kind),
    }
    .ok_or(ElementError::Degenerate { kind })
}

/// Points about their mean, in units of their extent.
struct Cloud {
    mean: Point3<f64>,
    extent: f64,
    points: Vec<Vector3<f64>>,
}

/// A surface under way: a frame with its Z along the axis or normal, its origin on the surface's axis, in its plane or at
/// its centre; the radius there, and a cone's half-angle, positive where the radius grows along Z.
#[derive(Debug, Clone, Copy)]
struct State {
    frame: Frame,
    sizes: [f64; 2],
}

/// The points' squared distances from a surface of this kind, over `P` unknowns: sizes first, then the motions that the
/// surface shows.
struct Misfit<'a> {
    kind: ElementKind,
    points: &'a [Vector3<f64>],
}

/// How many sizes are unknown, and which components of a twist along the frame's axes the surface shows.
fn unknowns(kind: ElementKind) -> (usize, &'static [usize]) {
    match kind {
        ElementKind::Plane => (0, &[2, 3, 4]),
        ElementKind::Sphere => (1, &[0, 1, 2]),
        ElementKind::Cylinder => (1, &[0, 1, 3, 4]),
        ElementKind::Cone => (2, &[0, 1, 3, 4]),
    }
}

impl Misfit<'_> {
    #[inline]
    fn row<const P: usize>(&self, at: &State, point: &Vector3<f64>) -> Row<P> {
        let p = at.frame.rotation.matrix().tr_mul(&(point - at.frame.origin.coords));
        let [radius, angle] = at.sizes;
        let across = p.xy().norm();
        let out = if across > 0.0 { Vector3::new(p.x / across, p.y / across, 0.0) } else { Vector3::x() };
        // Distance, outward normal, and derivatives over the sizes.
        let (distance, normal, by_size) = match self.kind {
            ElementKind::Plane => (p.z, Vector3::z(), [0.0; 2]),
            ElementKind::Sphere => {
                let length = p.norm();
                let out = if length > 0.0 { p / length } else { Vector3::x() };
                (length - radius, out, [-1.0, 0.0])
            }
            ElementKind::Cylinder => (across - radius, out, [-1.0, 0.0]),
            ElementKind::Cone => {
                let (sin, cos) = angle.sin_cos();
                let over = across - radius;
                let normal = out * cos - Vector3::z() * sin;
                (over * cos - p.z * sin, normal, [-cos, -over * sin - p.z * cos])
            }
        };
        let by_twist = Contact { at: p.into(), residual: distance, normal, sigma: 1.0 }.gradient();
        let (sizes, moves) = unknowns(self.kind);
        let mut gradient = [0.0; P];
        gradient[..sizes].copy_from_slice(&by_size[..sizes]);
        for (slot, component) in gradient[sizes..].iter_mut().zip(moves) {
            *slot = by_twist[*component];
        }
        Row { residual: distance, gradient }
    }
}

impl<const P: usize> SumOfSquares<Normal<P>> for Misfit<'_> {
    type At = State;

    fn linear(&self, at: &State) -> Normal<P> {
        let mut normal = Normal::NOTHING;
        for point in self.points {
            normal.add(&self.row(at, point));
        }
        normal
    }

    fn moved(&self, at: &State, step: &[f64; P]) -> State {
        let (count, moves) = unknowns(self.kind);
        let mut sizes = at.sizes;
        for (size, step) in sizes.iter_mut().zip(&step[..count]) {
            *size += step;
        }
        let mut twist = [0.0; 6];
        for (component, step) in moves.iter().zip(&step[count..]) {
            twist[*component] = *step;
        }
        State { frame: at.frame.moved(&Twist::from(Vector6::from(twist))), sizes }
    }

    /// The points' extent is one, so lengths and radians weigh alike.
    fn length(&self, step: &[f64; P]) -> f64 {
        step.iter().map(|v| v * v).sum::<f64>().sqrt()
    }
}

/// A local minimum.
struct Minimum {
    at: State,
    /// Sum of squared distances.
    square: f64,
    /// Of the unknowns, for residuals of variance one.
    covariance: DMatrix<f64>,
}

impl Cloud {
    fn of(points: &[Point3<f64>]) -> Self {
        let count = points.len() as f64;
        // From the first point on: a far origin costs no digits.
        let sum: Vector3<f64> = points.iter().map(|point| point - points[0]).sum();
        let mean = points[0] + sum / count;
        let points: Vec<Vector3<f64>> = points.iter().map(|point| point - mean).collect();
        let extent = (points.iter().map(Vector3::norm_squared).sum::<f64>() / count).sqrt();
        let extent = if extent > 0.0 { extent } else { 1.0 };
        Self { mean, extent, points: points.iter().map(|point| point / extent).collect() }
    }

    fn fit<const P: usize>(&self, kind: ElementKind) -> Option<Element> {
        /// Surfaces nearer to each other than this part of the extent are one.
        const SAME: f64 = 1e-5;
        let misfit = Misfit { kind, points: &self.points };
        let mut ends: Vec<State> = Vec::new();
        let mut minima: Vec<(State, f64)> = Vec::new();
        for start in self.starts(kind) {
            let end = standard(kind, descend::<Normal<P>, State>(&misfit, start).at);
            if !is_bounded(&end) || ends.iter().any(|other| distance(other, &end) < SAME) {
                continue;
            }
            ends.push(end);
            let Some(at) = settled::<P>(&misfit, end) else { continue };
            if !minima.iter().any(|(other, _)| distance(other, &at) < SAME) {
                minima.push((at, SumOfSquares::<Normal<P>>::linear(&misfit, &at).chi_square));
            }
        }
        minima.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (best, _) = minima.first()?;
        let best = self.polished::<P>(&misfit, *best)?;
        let squares: Vec<f64> = minima.iter().map(|(_, square)| *square).collect();
        Some(self.element(kind, &best, &squares))
    }

    /// Undamped steps by orthogonal factors from a minimum to where rounding ends them; `None` where the points leave an
    /// unknown free.
    fn polished<const P: usize>(&self, misfit: &Misfit<'_>, from: State) -> Option<Minimum> {
        /// Least over largest diagonal element of the triangular factor below which an unknown is free.
        const FREE: f64 = 1e-9;
        let (mut at, mut last) = (from, f64::INFINITY);
        loop {
            let rows: Vec<Row<P>> = self.points.iter().map(|point| misfit.row(&at, point)).collect();
            let jacobian = DMatrix::from_fn(rows.len(), P, |i, j| rows[i].gradient[j]);
            let mut residuals = DVector::from_fn(rows.len(), |i, _| rows[i].residual);
            let square = residuals.norm_squared();
            let qr = jacobian.qr();
            let r = qr.r();
            let diagonal = r.diagonal().abs();
            if diagonal.min().partial_cmp(&(FREE * diagonal.max())) != Some(std::cmp::Ordering::Greater) {
                return None;
            }
            qr.q_tr_mul(&mut residuals);
            let step = r.solve_upper_triangular(&residuals.rows(0, P))?;
            let step: [f64; P] = std::array::from_fn(|i| -step[i]);
            let length = SumOfSquares::<Normal<P>>::length(misfit, &step);
            // It no longer shrinks: rounding.
            if length >= last || length <= f64::EPSILON {
                let inverse = r.try_inverse()?;
                return Some(Minimum { at, square, covariance: &inverse * inverse.transpose() });
            }
            at = standard(misfit.kind, SumOfSquares::<Normal<P>>::moved(misfit, &at, &step));
            last = length;
        }
    }

    /// Starts that together lie in the basin of every good fit.
    fn starts(&self, kind: ElementKind) -> Vec<State> {
        let flat = self.scatter().symmetric_eigen();
        let thin: Vector3<f64> = flat.eigenvectors.column(flat.eigenvalues.imin()).into();
        match kind {
            ElementKind::Plane => state(Vector3::zeros(), &thin, [0.0; 2]).into_iter().collect(),
            ElementKind::Sphere => {
                /// Distances of a start's centre from a flat cap, in extents.
                const OFF: [f64; 8] = [-8.0, -4.0, -2.0, -1.0, 1.0, 2.0, 4.0, 8.0];
                let centers = self.algebraic_center().into_iter().chain(OFF.map(|off| thin * off));
                let start = |center: Vector3<f64>| {
                    let radius = self.points.iter().map(|p| (p - center).norm()).sum::<f64>();
                    state(center, &Vector3::z(), [radius / self.points.len() as f64, 0.0])
                };
                centers.filter_map(start).collect()
            }
            ElementKind::Cylinder | ElementKind::Cone => {
                let starts = self.directions().flat_map(|axis| self.starts_along(kind, &axis));
                starts.collect()
            }
        }
    }

    fn scatter(&self) -> Matrix3<f64> {
        self.points.iter().map(|p| p * p.transpose()).sum()
    }

    /// Directions all over a half sphere, more of them where the points are few and minima many.
    fn directions(&self) -> impl Iterator<Item = Unit<Vector3<f64>>> + use<> {
        /// Few points.
        const FEW: usize = 20;
        const DIRECTIONS: [usize; 2] = [400, 100];
        const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
        let count = DIRECTIONS[usize::from(self.points.len() > FEW)];
        (0..count).map(move |k| {
            let z = (k as f64 + 0.5) / count as f64;
            let (sin, cos) = (GOLDEN_ANGLE * k as f64).sin_cos();
            let across = (1.0 - z * z).sqrt();
            Unit::new_unchecked(Vector3::new(across * cos, across * sin, z))
        })
    }

    /// The centre of the sphere nearest the points in the algebraic sense: `|p|^2 = 2 c . p + k`.
    fn algebraic_center(&self) -> Option<Vector3<f64>> {
        let rows = self.points.iter().map(|p| ([2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0], p.norm_squared()));
        let [x, y, z, _] = linear(rows)?;
        Some(Vector3::new(x, y, z))
    }

    /// For an axis of this direction, what linear equations give in the plane across it: `x^2 + y^2 = 2 a x + 2 b y + k`
    /// for a cylinder, with `t^2 z^2 + e z` besides for a cone of slope `t`.
    fn starts_along(
        &self,
        kind: ElementKind,
        axis: &Unit<Vector3<f64>>,
    ) -> impl Iterator<Item = State> + use<> {
        /// Half-angles of a cone that is nearly a cylinder, radians.
        const SLIGHT: [f64; 2] = [-0.1, 0.1];
        let (u, v) = touchref_core::surface::perpendiculars(axis);
        let seen = || self.points.iter().map(|p| (u.dot(p), v.dot(p), axis.dot(p)));
        let at = |a: f64, b: f64, sizes: [f64; 2]| state(u * a + v * b, axis, sizes);
        let circle = linear(seen().map(|(x, y, _)| ([2.0 * x, 2.0 * y, 1.0], x * x + y * y)));
        let circle = circle.map(|[a, b, k]| (a, b, (k + a * a + b * b).max(0.0).sqrt()));
        let mut starts = [None; 3];
        match (kind, circle) {
            (ElementKind::Cone, circle) => {
                let cone = linear(seen().map(|(x, y, z)| ([2.0 * x, 2.0 * y, 1.0, z * z, z], x * x + y * y)));
                if let Some([a, b, k, squared, slope]) = cone {
                    let radius = (k + a * a + b * b).max(0.0).sqrt();
                    let angle = squared.max(0.0).sqrt().atan().copysign(slope);
                    starts[0] = at(a, b, [radius, angle]);
                }
                if let Some((a, b, radius)) = circle {
                    starts[1] = at(a, b, [radius, SLIGHT[0]]);
                    starts[2] = at(a, b, [radius, SLIGHT[1]]);
                }
            }
            (_, Some((a, b, radius))) => starts[0] = at(a, b, [radius, 0.0]),
            _ => {}
        }
        starts.into_iter().flatten()
    }

    /// A fitted surface in the points' own coordinates.
    fn element(&self, kind: ElementKind, minimum: &Minimum, squares: &[f64]) -> Element {
        let rms = |square: f64| (square / self.points.len() as f64).sqrt() * self.extent;
        let Minimum { at, square, covariance } = minimum;
        let point = self.mean + at.frame.origin.coords * self.extent;
        let axis = Unit::new_normalize(at.frame.axis(2));
        let radius = at.sizes[0] * self.extent;
        let shape = match kind {
            ElementKind::Plane => Shape::Plane { point, normal: axis },
            ElementKind::Sphere => Shape::Sphere { center: point, radius, bore: false },
            ElementKind::Cylinder => Shape::Cylinder { point, axis, radius, bore: false },
            ElementKind::Cone => {
                let apex = point - *axis * (radius / at.sizes[1].tan());
                Shape::Cone { apex, axis, half_angle: at.sizes[1], bore: false }
            }
        };
        let free = self.points.len() - kind.fewest();
        let variance = (free > 0).then(|| square / free as f64);
        Element {
            shape,
            point,
            rms: rms(*square),
            minima: squares.len(),
            second_rms: squares.get(1).copied().map(rms),
            covariance: variance.map(|variance| self.covariance(kind, at, &(covariance * variance))),
        }
    }

    fn covariance(&self, kind: ElementKind, at: &State, covariance: &DMatrix<f64>) -> ElementCovariance {
        let (count, moves) = unknowns(kind);
        let axes = [0, 1, 2].map(|k| at.frame.axis(k));
        let (mut point, mut direction) = (DMatrix::zeros(3, moves.len()), DMatrix::zeros(3, moves.len()));
        for (k, component) in moves.iter().enumerate() {
            match component {
                0..3 => point.set_column(k, &(axes[*component] * self.extent)),
                // A turn about X moves Z against Y, one about Y along X.
                3 => direction.set_column(k, &-axes[1]),
                _ => direction.set_column(k, &axes[0]),
            }
        }
        let motions = covariance.view((count, count), (moves.len(), moves.len())).into_owned();
        let carried = |to: &DMatrix<f64>| {
            let carried = to * &motions * to.transpose();
            Matrix3::from_fn(|i, j| carried[(i, j)])
        };
        let mut sizes = [0.0; 2];
        for (k, size) in sizes.iter_mut().enumerate().take(count) {
            // The radius is a length, the half-angle none.
            let unit = if k == 0 { self.extent } else { 1.0 };
            *size = covariance[(k, k)] * unit * unit;
        }
        ElementCovariance { point: carried(&point), direction: carried(&direction), sizes }
    }
}

/// The minimum next to where a descent ended, by Newton's steps with the second derivative of the whole misfit: also where
/// residuals are so large that undamped steps of the linear model do not settle. `None` where the misfit has no minimum
/// there: a saddle, or a valley toward a flat surface.
#[allow(clippy::needless_range_loop)] // Triangular indices read as in the books.
fn settled<const P: usize>(misfit: &Misfit<'_>, from: State) -> Option<State> {
    /// Four or five are usual.
    const STEPS: usize = 30;
    /// A step this short squares itself below rounding.
    const SHORT: f64 = 1e-9;
    /// Of the central differences.
    const DIFFERENCE: f64 = 1e-6;
    let gradient = |at: &State| SumOfSquares::<Normal<P>>::linear(misfit, at).gradient;
    let mut at = from;
    for _ in 0..STEPS {
        let beside = |j: usize, by: f64| {
            let mut step = [0.0; P];
            step[j] = by;
            gradient(&misfit.moved(&at, &step))
        };
        let columns: [[f64; P]; P] = std::array::from_fn(|j| {
            let (up, down) = (beside(j, DIFFERENCE), beside(j, -DIFFERENCE));
            std::array::from_fn(|i| (up[i] - down[i]) / (2.0 * DIFFERENCE))
        });
        let mut normal = Normal { gradient: gradient(&at), ..Normal::NOTHING };
        for i in 0..P {
            for j in i..P {
                normal.matrix[i][j] = 0.5 * (columns[i][j] + columns[j][i]);
            }
        }
        let step = damped_step(&normal, 0.0)?;
        at = standard(misfit.kind, misfit.moved(&at, &step));
        if !is_bounded(&at) {
            return None;
        }
        if SumOfSquares::<Normal<P>>::length(misfit, &step) < SHORT {
            return Some(at);
        }
    }
    None
}

/// A state whose axis has this direction and passes through a point.
fn state(origin: Vector3<f64>, axis: &Vector3<f64>, sizes: [f64; 2]) -> Option<State> {
    let axis = Unit::try_new(*axis, f64::MIN_POSITIVE)?;
    let (u, _) = touchref_core::surface::perpendiculars(&axis);
    let frame = Frame::from_z_and_x(origin.into(), *axis, u)?;
    Some(State { frame, sizes })
}

/// The same surface with its origin where it is nearest the mean of the points.
fn foot(kind: ElementKind, mut at: State) -> State {
    let axis = at.frame.axis(2);
    let along = axis.dot(&at.frame.origin.coords);
    match kind {
        ElementKind::Plane => at.frame.origin = Point3::from(axis * along),
        ElementKind::Sphere => {}
        ElementKind::Cylinder | ElementKind::Cone => {
            at.frame.origin -= axis * along;
            at.sizes[0] -= along * at.sizes[1].tan();
        }
    }
    at
}

/// The same surface told in one way: radii positive, a cone's direction to growing radius, others' into the half space of
/// positive coordinates.
fn standard(kind: ElementKind, at: State) -> State {
    /// A component of a direction smaller than this may be zero, and does not tell its half space.
    const NOTHING: f64 = 1e-3;
    let State { frame, sizes: [mut radius, mut angle] } = foot(kind, at);
    let mut axis = frame.axis(2);
    // A cone of negative radius is the other nappe, turned round.
    if radius < 0.0 {
        (radius, angle) = (-radius, -angle);
    }
    angle = (angle + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2;
    let first = axis.iter().find(|v| v.abs() > NOTHING).copied().unwrap_or(1.0);
    let turn = if kind == ElementKind::Cone { angle < 0.0 } else { first < 0.0 };
    if turn && kind != ElementKind::Sphere {
        (axis, angle) = (-axis, -angle);
    }
    state(frame.origin.coords, &axis, [radius, angle]).unwrap_or(at)
}

/// How far apart two surfaces of a kind are: lengths in extents, plus radians.
fn distance(one: &State, other: &State) -> f64 {
    let sizes = (one.sizes[0] - other.sizes[0]).abs() + (one.sizes[1] - other.sizes[1]).abs();
    let turn = one.frame.axis(2).cross(&other.frame.axis(2)).norm();
    (one.frame.origin - other.frame.origin).norm() + sizes + turn
}

/// Whether it is a surface and not on its way to a flat one.
fn is_bounded(at: &State) -> bool {
    /// In extents.
    const FAR: f64 = 1e4;
    at.frame.is_sound() && at.frame.origin.coords.norm() < FAR && at.sizes[0] < FAR
}

/// Solves linear equations `row . x = right` by least squares, as normal equations: for starts.
fn linear<const P: usize>(rows: impl Iterator<Item = ([f64; P], f64)>) -> Option<[f64; P]> {
    let mut normal = Normal::NOTHING;
    for (gradient, right) in rows {
        normal.add(&Row { residual: -right, gradient });
    }
    damped_step(&normal, 0.0)
}
