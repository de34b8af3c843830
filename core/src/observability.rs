//! What touches see: rank, condition, and the weakest or free motion told in words.

use std::fmt;

use nalgebra::{DMatrix, Matrix6, Point3, Vector3, Vector6};

use crate::{Fixture, Frame, Freedom, Problem, Shape, Twist};

/// Smallest over largest singular value of the scaled Jacobian below which a motion counts as free.
///
/// A layout that is singular in exact arithmetic shows up as a double root, which double precision places to about
/// the square root of its rounding (1.5e-8) times the equations' amplification; 1e-6 leaves room for that, and lies
/// a factor 100 beyond the condition at which any sound layout was seen (below 1e4).
pub const RANK_TOLERANCE: f64 = 1e-6;

/// What the touches determine at a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Observability {
    /// How many motions the touches determine: six, less what the fixture leaves free, when all.
    pub rank: usize,
    /// Largest over smallest singular value of the weighted Jacobian, rotations scaled by the fixture's
    /// [`size`](Fixture::size); infinite when the smallest is zero.
    pub condition: f64,
    /// The motion that the touches see least, or not at all.
    pub weakest: Motion,
}

/// A motion of the fixture, or of one of its surfaces where the words say so; `Display` tells it in words: "rotation
/// about the axis of `cylinder`", "slide along ...".
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Along the **parent's** axes, about the point [`about`](Self::about).
    pub twist: Twist,
    /// The point, in the parent, that the twist's translation moves.
    pub about: Point3<f64>,
    manner: Manner,
}

/// What a motion is mostly, and what of the fixture it follows, if anything.
#[derive(Debug, Clone, PartialEq)]
enum Manner {
    Slide {
        along: Option<String>,
    },
    Turn {
        about: Option<String>,
        /// How far it slides along the axis meanwhile, per radian, where that matters.
        slide: Option<f64>,
    },
    /// Of a surface by itself, about the line that some of its geometry lies on.
    TurnOfSurface {
        surface: String,
        which: &'static str,
    },
}

impl Motion {
    /// A motion that follows nothing of a fixture by name.
    #[must_use]
    pub fn new(twist: Twist, about: Point3<f64>) -> Self {
        let (v, w) = (twist.translation, twist.rotation);
        let manner = if w == Vector3::zeros() {
            Manner::Slide { along: None }
        } else {
            Manner::Turn {
                about: None,
                slide: Some(w.dot(&v) / w.norm_squared()).filter(|slide| *slide != 0.0),
            }
        };
        Self { twist, about, manner }
    }

    /// A motion told along the fixture's axes about its origin.
    #[must_use]
    pub fn of_fixture(fixture: &dyn Fixture, frame: &Frame, twist: &Twist) -> Self {
        let in_parent = Twist {
            translation: frame.rotation * twist.translation,
            rotation: frame.rotation * twist.rotation,
        };
        Self { twist: in_parent, about: frame.origin, manner: Manner::of(fixture, twist) }
    }

    /// A turn of one surface by itself, before any frame is known: about the line through `point` along `direction`
    /// (parent), of which `which` is told.
    #[must_use]
    pub fn rotation_of(
        surface: &str,
        point: &Point3<f64>,
        direction: &Vector3<f64>,
        which: &'static str,
    ) -> Self {
        let twist = Twist { translation: Vector3::zeros(), rotation: *direction };
        Self { twist, about: *point, manner: Manner::TurnOfSurface { surface: surface.to_owned(), which } }
    }
}

impl fmt::Display for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Twist { translation: v, rotation: w } = self.twist;
        // The screw axis: the points that move only along it.
        let line = || Line { point: self.about + w.cross(&v) / w.norm_squared(), direction: w.normalize() };
        match &self.manner {
            Manner::Slide { along: Some(name) } => write!(f, "slide along {name}"),
            Manner::Slide { along: None } => {
                let d = v.normalize();
                write!(f, "slide along ({:.4}, {:.4}, {:.4})", d.x, d.y, d.z)
            }
            Manner::Turn { about, slide } => {
                match about {
                    Some(name) => write!(f, "rotation about {name}")?,
                    None => write!(f, "rotation about {}", line())?,
                }
                match slide {
                    Some(slide) => write!(f, ", with a slide of {slide:.3} along it per radian"),
                    None => Ok(()),
                }
            }
            Manner::TurnOfSurface { surface, which } => {
                let line = Line { point: self.about, direction: w };
                write!(f, "rotation of `{surface}` about {line}, which {which}")
            }
        }
    }
}

/// A line of the parent.
struct Line {
    point: Point3<f64>,
    direction: Vector3<f64>,
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { point: p, direction: d } = self;
        write!(
            f,
            "the line through ({:.4}, {:.4}, {:.4}) along ({:.4}, {:.4}, {:.4})",
            p.x, p.y, p.z, d.x, d.y, d.z
        )
    }
}

impl Manner {
    /// Of a twist along the fixture's axes about its origin.
    fn of(fixture: &dyn Fixture, twist: &Twist) -> Self {
        /// A motion that turns the fixture by less than this part of how it moves it is told as a slide.
        const MOSTLY: f64 = 0.02;
        /// A motion this near (parts of the fixture's size, or radians) to a surface's axis or normal follows it.
        const NEAR: f64 = 0.02;
        let size = fixture.size();
        let (v, w) = (twist.translation, twist.rotation);
        let turn = w.norm();
        if turn * size <= MOSTLY * v.norm() {
            let direction = v.normalize();
            let along = fixture.surfaces().iter().find_map(|surface| match &surface.shape {
                Shape::Cylinder { axis, .. } | Shape::Cone { axis, .. }
                    if axis.cross(&direction).norm() < NEAR =>
                {
                    Some(format!("the axis of `{}`", surface.name))
                }
                Shape::Plane { normal, .. } if normal.cross(&direction).norm() < NEAR => {
                    Some(format!("the normal of `{}`", surface.name))
                }
                _ => None,
            });
            return Self::Slide { along };
        }
        let direction = w / turn;
        let on_axis = Point3::from(w.cross(&v) / (turn * turn));
        let about = fixture.surfaces().iter().find_map(|surface| {
            let (point, axis) = surface.axis()?;
            let along = axis.cross(&direction).norm() < NEAR;
            let through = (point - on_axis).cross(&axis).norm() < NEAR * size;
            (along && through).then(|| format!("the axis of `{}`", surface.name))
        });
        let slide = direction.dot(&v) / turn;
        Self::Turn { about, slide: (slide.abs() > MOSTLY * size).then_some(slide) }
    }
}

impl Observability {
    /// What the touches of `problem` determine when the fixture stands at `frame`.
    #[must_use]
    pub fn at(problem: &Problem<'_>, frame: &Frame) -> Self {
        let touches = problem.touches().len();
        let mut jacobian = DMatrix::zeros(touches.max(6), 6);
        for index in 0..touches {
            let contact = problem.contact(frame, index);
            let gradient = problem.fixture().freedom().without(&contact.gradient().into());
            let row = gradient.transpose() / contact.sigma;
            jacobian.row_mut(index).copy_from(&row);
        }
        let r: Matrix6<f64> = jacobian.qr().r().fixed_view::<6, 6>(0, 0).into();
        Self::from_square_root(problem.fixture(), frame, &r)
    }

    /// From the square root of the information: any matrix `r` with `r^T r = J^T W J`, over twists along the
    /// fixture's axes about its origin.
    #[must_use]
    pub fn from_square_root(fixture: &dyn Fixture, frame: &Frame, r: &Matrix6<f64>) -> Self {
        let (singular_values, twist) = weakest_motion(r, fixture.size(), fixture.freedom());
        Self::from_singular_values(fixture, frame, &singular_values, &twist)
    }

    /// From what [`weakest_motion`] tells.
    #[must_use]
    pub fn from_singular_values(
        fixture: &dyn Fixture,
        frame: &Frame,
        singular: &Vector6<f64>,
        twist: &Twist,
    ) -> Self {
        let (largest, smallest) = (singular.max(), singular.min());
        let seen = singular.iter().filter(|s| **s > RANK_TOLERANCE * largest).count();
        let rank = seen - fixture.freedom().count().min(seen);
        let condition = if smallest > 0.0 { largest / smallest } else { f64::INFINITY };
        let weakest = Motion::of_fixture(fixture, frame, twist);
        Self { rank, condition, weakest }
    }
}

/// Singular values of `r` with rotations scaled by `size`, and the unit twist along the least of them.
///
/// What a fixture leaves free, so that its columns and rows of `r` are zero, is neither the weakest nor the strongest. An
/// `r` that is not finite shows nothing: all singular values are zero, and any motion is the weakest.
#[must_use]
pub fn weakest_motion(r: &Matrix6<f64>, size: f64, freedom: Freedom) -> (Vector6<f64>, Twist) {
    if !r.iter().all(|v| v.is_finite()) {
        // The decomposition would never settle.
        return (Vector6::zeros(), Twist::from(Vector6::x()));
    }
    let mut scaled = *r;
    scaled.fixed_view_mut::<6, 3>(0, 3).scale_mut(1.0 / size);
    if freedom != Freedom::NONE {
        // The length of a column lies between the singular values.
        let between = scaled.column_iter().map(|column| column.norm()).fold(0.0, f64::max);
        for index in (0..6).filter(|index| freedom.is_free(*index)) {
            scaled[(index, index)] = between;
        }
    }
    let svd = scaled.svd_unordered(false, true);
    let least = svd.singular_values.imin();
    let direction: Vector6<f64> = match svd.v_t {
        Some(v_t) => v_t.row(least).transpose(),
        None => Vector6::zeros(),
    };
    let mut twist = Twist::from(direction);
    twist.rotation /= size;
    (svd.singular_values, twist)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coordinates whose squares overflow must not keep anyone waiting.
    #[test]
    fn numbers_that_are_not_finite_show_nothing() {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut r = Matrix6::identity();
            r[(1, 4)] = bad;
            let (singular, twist) = weakest_motion(&r, 2.0, Freedom::NONE);
            assert_eq!(singular, Vector6::zeros());
            assert!((Vector6::from(twist).norm() - 1.0).abs() < 1e-15);
        }
    }
}
