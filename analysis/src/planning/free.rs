//! What touches leave free, told motion by motion.

use nalgebra::{DMatrix, Point3, Vector3, Vector6};
use touchref_core::{Frame, Motion, Problem, RANK_TOLERANCE, Shape, Twist};

/// A motion with a name counts as one of those that are free when all but this part of it is (a double root blurs them).
const NEAR: f64 = 1e-5;
/// Of a motion, the least part that others do not make up already.
const NEW: f64 = 0.2;

/// Motions that the touches of `problem` leave free when the fixture stands at `frame`, beside those that the fixture does:
/// as many as are independent, those along and about the axes of fixture and surfaces first.
#[must_use]
pub fn free_motions(problem: &Problem<'_>, frame: &Frame) -> Vec<Motion> {
    let fixture = problem.fixture();
    let freedom = fixture.freedom();
    let touches = problem.touches().len();
    // What the fixture leaves free is not to be told: it counts as seen.
    let mut jacobian = DMatrix::zeros(touches + 6, 6);
    for index in 0..touches {
        let gradient = freedom.without(&problem.contact(frame, index).gradient().into());
        jacobian.row_mut(index).copy_from(&scaled(&gradient, 1.0 / fixture.size()).transpose());
    }
    for index in (0..6).filter(|index| freedom.is_free(*index)) {
        jacobian[(touches + index, index)] = 1.0;
    }
    let svd = jacobian.svd(false, true);
    let Some(rows) = svd.v_t else { return Vec::new() };
    let largest = svd.singular_values.max();
    let unseen = (0..6).filter(|k| svd.singular_values[*k] <= RANK_TOLERANCE * largest);
    let unseen: Vec<Vector6<f64>> =
        unseen.map(|k| Vector6::from_iterator(rows.row(k).iter().copied())).collect();
    let within = |motion: &Vector6<f64>| -> Vector6<f64> { unseen.iter().map(|v| v * v.dot(motion)).sum() };

    let mut told: Vec<Vector6<f64>> = Vec::new();
    // Each perpendicular to those before: what is new of it.
    let mut basis: Vec<Vector6<f64>> = Vec::new();
    let named = named(problem).into_iter().map(|motion| scaled(&motion, fixture.size()).normalize());
    let named = named.filter(|motion| (within(motion) - motion).norm() < NEAR);
    for motion in named.chain(unseen.iter().copied()) {
        let rest: Vector6<f64> = motion - basis.iter().map(|v| v * v.dot(&motion)).sum::<Vector6<f64>>();
        if told.len() < unseen.len() && rest.norm() > NEW {
            basis.push(rest.normalize());
            told.push(scaled(&motion, 1.0 / fixture.size()));
        }
    }
    told.iter().map(|motion| Motion::of_fixture(fixture, frame, &Twist::from(*motion))).collect()
}

/// A motion with its rotation by so much larger.
fn scaled(motion: &Vector6<f64>, by: f64) -> Vector6<f64> {
    let mut scaled = *motion;
    scaled.fixed_rows_mut::<3>(3).scale_mut(by);
    scaled
}

/// Motions that have a name, along the fixture's axes about its origin: slides along its axes and those of surfaces, and
/// turns about axes and normals of surfaces, about lines through centres, and about its own axes.
fn named(problem: &Problem<'_>) -> Vec<Vector6<f64>> {
    let slide = |along: Vector3<f64>| Twist { translation: along, rotation: Vector3::zeros() }.into();
    let turn = |point: &Point3<f64>, about: Vector3<f64>| {
        Twist { translation: point.coords.cross(&about), rotation: about }.into()
    };
    let axes = || (0..3).map(|axis| Vector3::ith(axis, 1.0));
    let mut named: Vec<Vector6<f64>> = axes().map(slide).collect();
    for surface in problem.fixture().surfaces() {
        match &surface.shape {
            Shape::Plane { point, normal } => named.push(turn(point, **normal)),
            Shape::Sphere { center, .. } => named.extend(axes().map(|axis| turn(center, axis))),
            _ => {
                if let Some((point, axis)) = surface.axis() {
                    named.extend([slide(*axis), turn(&point, *axis)]);
                }
            }
        }
    }
    named.extend(axes().map(|axis| turn(&Point3::origin(), axis)));
    named
}
