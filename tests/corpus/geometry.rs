//! What a touch resists, once more and without the library: to judge the motion that a refusal tells.

use nalgebra::{DMatrix, DVector, Matrix3, Point3, Rotation3, Vector3};
use rand::RngExt;
use serde::Deserialize;
use touchref::analysis::simulation::generator;

/// A surface in fixture coordinates.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Geometry {
    /// About the z axis, of this radius.
    Cylinder(f64),
    /// Through a point, with an outward normal.
    Plane([f64; 3], [f64; 3]),
    /// About a centre, of this radius.
    Sphere([f64; 3], f64),
}

impl Geometry {
    /// Signed distance of a point, and the outward normal there.
    pub(crate) fn seen_from(&self, p: &Point3<f64>) -> (f64, Vector3<f64>) {
        let (away, radius) = match self {
            Self::Plane(point, normal) => {
                let normal = Vector3::from(*normal);
                return (normal.dot(&(p - Point3::from(*point))), normal);
            }
            Self::Cylinder(radius) => (Vector3::new(p.x, p.y, 0.0), radius),
            Self::Sphere(center, radius) => (p - Point3::from(*center), radius),
        };
        (away.norm() - radius, away.normalize())
    }
}

/// A motion of all points by `velocity + rotation x (p - about)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moving {
    pub(crate) velocity: Vector3<f64>,
    pub(crate) rotation: Vector3<f64>,
    pub(crate) about: Point3<f64>,
}

impl Moving {
    fn of(&self, p: &Point3<f64>) -> Vector3<f64> {
        self.velocity + self.rotation.cross(&(p - self.about))
    }

    /// Its length for a fixture of this size.
    pub(crate) fn extent(&self, size: f64) -> f64 {
        self.velocity.norm().hypot(self.rotation.norm() * size)
    }

    /// How far it moves the one of these points that it moves most, for a motion of length one.
    pub(crate) fn moves(&self, points: &[Point3<f64>], size: f64) -> f64 {
        points.iter().map(|p| self.of(p).norm()).fold(0.0, f64::max) / self.extent(size)
    }
}

/// The least that some touch resists a motion of length one at any frame whose origin is where the motion is told about and
/// which fits every touch to `fits` (parts of the size); infinite where none was found.
///
/// Which frame that is, is not told: it is looked for among all rotations.
pub(crate) fn resistance(touches: &[(&Geometry, Point3<f64>)], motion: &Moving, size: f64, fits: f64) -> f64 {
    const STARTS: u64 = 200;
    const STEPS: usize = 60;
    let length = motion.extent(size);
    // Residuals in parts of the size, then what each touch resists.
    let seen = |rotation: &Rotation3<f64>| {
        let (mut off, mut resisted) = (Vec::new(), Vec::new());
        for (surface, at) in touches {
            let (distance, normal) =
                surface.seen_from(&Point3::from(rotation.inverse() * (at - motion.about)));
            off.push(distance / size);
            resisted.push((rotation * normal).dot(&motion.of(at)) / length);
        }
        off.extend(resisted);
        DVector::from_vec(off)
    };
    let turned = |rotation: &Rotation3<f64>, by: &Vector3<f64>| Rotation3::new(*by) * rotation;
    let mut least = f64::INFINITY;
    for start in 0..STARTS {
        let mut rng = generator(71, start);
        let mut uniform = || rng.random_range(-1.0..1.0);
        let random = Matrix3::from_fn(|_, _| uniform());
        let mut rotation = Rotation3::from_matrix_eps(&random, 1e-12, 100, Rotation3::identity());
        let mut values = seen(&rotation);
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            const STEP: f64 = 1e-6;
            let mut slopes = DMatrix::zeros(values.len(), 3);
            for k in 0..3 {
                let by = Vector3::ith(k, STEP);
                let slope = (seen(&turned(&rotation, &by)) - seen(&turned(&rotation, &-by))) / (2.0 * STEP);
                slopes.set_column(k, &slope);
            }
            let matrix = slopes.tr_mul(&slopes) + DMatrix::identity(3, 3) * damping;
            let Some(step) = matrix.lu().solve(&-slopes.tr_mul(&values)) else { break };
            let there = turned(&rotation, &Vector3::new(step[0], step[1], step[2]));
            let tried = seen(&there);
            if tried.norm() < values.norm() {
                (rotation, values) = (there, tried);
                damping = f64::max(damping * 0.2, 1e-15);
            } else {
                damping *= 5.0;
            }
            if step.norm() < 1e-14 {
                break;
            }
        }
        if values.rows(0, touches.len()).amax() < fits {
            least = least.min(values.rows(touches.len(), touches.len()).amax());
        }
    }
    least
}
