//! Single surfaces against the NIST reference pairs: 120 data sets and the fits that NIST computed with 60 digits.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use std::{fs, path::PathBuf};

use nalgebra::{Point3, Unit, Vector3};
use touchref::{
    Shape,
    solvers::element::{Element, ElementKind, fit},
};

/// Positions and sizes (mm) and directions (radians) of a reference pair.
const TOLERANCE: f64 = 1e-9;

struct Pair {
    name: String,
    points: Vec<Point3<f64>>,
    reference: Vec<f64>,
}

/// The pairs of a kind; none where the data are not there.
fn pairs(kind: &str) -> Vec<Pair> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/nist-l2").join(kind);
    let Ok(files) = fs::read_dir(&folder) else { return Vec::new() };
    let mut pairs: Vec<Pair> = files
        .map(|file| file.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "ds"))
        .map(|path| {
            let numbers = |path: &PathBuf| -> Vec<f64> {
                let text = fs::read_to_string(path).unwrap();
                text.split_whitespace().map(|number| number.parse().unwrap()).collect()
            };
            let data = numbers(&path);
            let points = data[1..].chunks_exact(3).map(|p| Point3::new(p[0], p[1], p[2])).collect();
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            Pair { name, points, reference: numbers(&path.with_extension("fit")) }
        })
        .collect();
    pairs.sort_by(|a, b| a.name.cmp(&b.name));
    pairs
}

/// Angle between two directions of either sign, in the form of ISO 10360-6 that loses no digits near zero.
fn angle(one: &Vector3<f64>, other: &Vector3<f64>) -> f64 {
    let apart = (one - other).norm().min((one + other).norm());
    2.0 * (0.5 * apart).asin()
}

fn main_direction(reference: &[f64]) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(reference[3], reference[4], reference[5]))
}

/// How far a fitted element is from its reference: position, direction, size.
fn deviations(element: &Element, pair: &Pair) -> [f64; 3] {
    let reference = &pair.reference;
    let mean = pair.points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / pair.points.len() as f64;
    let at = Point3::new(reference[0], reference[1], reference[2]);
    // The reference's point of its axis nearest the points' mean.
    let foot = |axis: &Unit<Vector3<f64>>| at + **axis * axis.dot(&(mean - at.coords));
    match &element.shape {
        Shape::Plane { point, normal } => {
            let axis = main_direction(reference);
            [axis.dot(&(point - at)).abs(), angle(normal, &axis), 0.0]
        }
        Shape::Sphere { center, radius, .. } => {
            [(center - at).norm(), 0.0, (2.0 * radius - reference[3]).abs()]
        }
        Shape::Cylinder { point, axis, radius, .. } => {
            let expected = main_direction(reference);
            let off = (point - foot(&expected)).norm();
            [off, angle(axis, &expected), (2.0 * radius - reference[6]).abs()]
        }
        Shape::Cone { apex, axis, half_angle, .. } => {
            let expected = main_direction(reference);
            let point = foot(&expected);
            let half = 0.5 * reference[7].to_radians();
            // The radius at that point, orthogonal to the surface; the axis points to growing radius.
            let wanted = reference[6] + expected.dot(&(point - at)) * half.sin();
            let along = axis.dot(&(point - apex));
            let off = (apex + **axis * along - point).norm();
            let size = (along * half_angle.sin() - wanted).abs().max((half_angle - half).abs());
            [off, (**axis - *expected).norm(), size]
        }
        other => panic!("no element: {other:?}"),
    }
}

#[test]
fn every_reference_pair_is_met_without_a_guess() {
    let kinds = [
        ("Plane", ElementKind::Plane),
        ("Sphere", ElementKind::Sphere),
        ("Cylinder", ElementKind::Cylinder),
        ("Cone", ElementKind::Cone),
    ];
    for (folder, kind) in kinds {
        let pairs = pairs(folder);
        if pairs.is_empty() {
            println!("skipped: the NIST reference pairs are not there");
            return;
        }
        assert_eq!(pairs.len(), 30);
        let mut worst = [0.0_f64; 3];
        for pair in &pairs {
            let element = fit(kind, &pair.points).unwrap();
            let off = deviations(&element, pair);
            println!(
                "{}: {} points, {} minima, rms {:.2e}, off {:.1e} {:.1e} {:.1e}",
                pair.name,
                pair.points.len(),
                element.minima,
                element.rms,
                off[0],
                off[1],
                off[2]
            );
            // Six points and six unknowns: several cones may pass through all of them.
            if pair.name == "con7" {
                assert!(element.rms < TOLERANCE, "{}", element.rms);
                continue;
            }
            for (worst, off) in worst.iter_mut().zip(off) {
                *worst = worst.max(off);
            }
        }
        println!(
            "{folder}: worst position {:.1e} mm, direction {:.1e} rad, size {:.1e}",
            worst[0], worst[1], worst[2]
        );
        assert!(worst.iter().all(|worst| *worst < TOLERANCE), "{folder}: {worst:?}");
    }
}
