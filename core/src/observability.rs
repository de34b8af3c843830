//! What touches see: rank, condition, and the weakest or free motion told in words.

use std::fmt;

use nalgebra::{DMatrix, Matrix3, Matrix6, Point3, Vector3, Vector6};

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
        Self { twist: twist.turned(&frame.rotation), about: frame.origin, manner: Manner::of(fixture, twist) }
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
                write!(f, "slide along {}", Triple(&v.normalize()))
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

/// A direction of the parent in words: the axis of a surface, the normal of a plane, or the axis of fixture or parent that
/// lies nearest, and how far off that is: "the axis of `cylinder`", "12 degrees off the fixture's Z axis".
#[must_use]
pub fn direction_in_words(fixture: &dyn Fixture, frame: &Frame, direction: &Vector3<f64>) -> String {
    /// A direction this near to a named one (radians) is that.
    const NEAR: f64 = 0.02;
    const AXES: [&str; 3] = ["X", "Y", "Z"];
    let of_surfaces = fixture.surfaces().iter().filter_map(|surface| {
        let (direction, which) = match (&surface.shape, surface.axis()) {
            (Shape::Plane { normal, .. }, _) => (*normal, "normal"),
            (_, axis) => (axis?.1, "axis"),
        };
        Some((frame.rotation * direction.into_inner(), format!("the {which} of `{}`", surface.name)))
    });
    let of_frames = [(frame.rotation.into_inner(), "fixture"), (Matrix3::identity(), "parent")];
    let of_frames = of_frames.into_iter().flat_map(|(axes, whose)| {
        let named = AXES.into_iter().enumerate();
        named.map(move |(k, name)| (axes.column(k).into_owned(), format!("the {whose}'s {name} axis")))
    });
    let off = |axis: &Vector3<f64>| axis.cross(direction).norm().atan2(axis.dot(direction).abs());
    let named = of_surfaces.chain(of_frames).map(|(axis, name)| (off(&axis), name));
    // Of two that are as near, the first: surfaces tell most.
    let nearest = named.reduce(|best, next| if next.0 < best.0 - NEAR { next } else { best });
    match nearest {
        Some((angle, name)) if angle < NEAR => name,
        Some((angle, name)) => format!("{:.0} degrees off {name}", angle.to_degrees()),
        None => "no direction".to_owned(),
    }
}

/// A line of the parent.
struct Line {
    point: Point3<f64>,
    direction: Vector3<f64>,
}

/// Three numbers with four digits after the point; no negative zero.
struct Triple<'a>(&'a Vector3<f64>);

impl fmt::Display for Triple<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Less is written as zero.
        const HALF: f64 = 0.5e-4;
        let [x, y, z]: [f64; 3] = self.0.map(|v| if v.abs() < HALF { 0.0 } else { v }).into();
        write!(f, "({x:.4}, {y:.4}, {z:.4})")
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the line through {} along {}", Triple(&self.point.coords), Triple(&self.direction))
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
    let mut scaled = *r;
    scaled.fixed_view_mut::<6, 3>(0, 3).scale_mut(1.0 / size);
    if !scaled.iter().all(|v| v.is_finite()) {
        // The decomposition would never settle.
        return (Vector6::zeros(), Twist::from(Vector6::x()));
    }
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
    use crate::{Dimension, Parameters, Requirement, Surface};

    /// A plane whose normal is Z, and nothing else.
    #[derive(Debug)]
    struct Plate(Parameters, [Surface; 1], Requirement);

    impl Fixture for Plate {
        fn kind(&self) -> &'static str {
            "plate"
        }
        fn parameters(&self) -> &Parameters {
            &self.0
        }
        fn surfaces(&self) -> &[Surface] {
            &self.1
        }
        fn requirement(&self) -> &Requirement {
            &self.2
        }
        fn size(&self) -> f64 {
            1.0
        }
        fn dimensions(&self) -> &[Dimension] {
            &[]
        }
        fn nominal_layout(&self) -> Vec<(usize, Point3<f64>)> {
            Vec::new()
        }
    }

    #[test]
    fn directions_have_the_name_of_what_is_nearest() {
        let shape = Shape::Plane { point: Point3::origin(), normal: Vector3::z_axis() };
        let surface = Surface::new("top", shape, crate::Extent::Disc { radius: 1.0 });
        let plate = Plate(Parameters::new(), [surface], Requirement::counts(&[3]));
        // The fixture's X, Y, Z are the parent's Y, Z, X.
        let axes = nalgebra::Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(axes);
        let frame = Frame { rotation, origin: Point3::new(1.0, 2.0, 3.0) };
        let table = [
            ([1.0, 0.0, 0.0], "the normal of `top`"),
            ([-1.0, 0.01, 0.0], "the normal of `top`"),
            ([0.0, 2.0, 0.0], "the fixture's X axis"),
            ([1.0, 0.18, 0.0], "10 degrees off the normal of `top`"),
        ];
        for (direction, expected) in table {
            assert_eq!(direction_in_words(&plate, &frame, &direction.into()), expected);
        }
    }

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
