//! Surfaces as meshes: flat faces, and the edges between them.

use std::{
    collections::BTreeMap,
    f64::consts::{PI, TAU},
};

use nalgebra::{Point3, Unit, Vector3};
use touchref_core::{Extent, Shape, surface::perpendiculars};

/// By which part of itself a surface is drawn beyond its outermost touch.
const MARGIN: f64 = 0.08;
/// Faces about an axis.
const AROUND: usize = 36;
/// Faces from pole to pole of a ball.
const RINGS: usize = 16;
/// Faces along each side of a plane, and along an axis: small ones are sorted by depth more truly than a large one.
const SQUARES: usize = 8;

/// A surface of flat faces.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Corners.
    pub vertices: Vec<Point3<f64>>,
    /// Faces, the indices of their corners counterclockwise as seen from outside.
    pub faces: Vec<Vec<usize>>,
    /// Edges.
    pub edges: Vec<Edge>,
    /// Whether there is material behind its faces, so that they are seen from outside only.
    pub solid: bool,
}

/// An edge of a mesh: drawn where it is a rim, and where it is the outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Indices of its ends.
    pub ends: [usize; 2],
    /// Indices of the faces on either side; the second is missing at a rim.
    pub faces: (usize, Option<usize>),
    /// Whether it is drawn from wherever it is seen: where the surface ends or has a corner.
    pub rim: bool,
}

impl Mesh {
    /// Of a surface, in fixture coordinates: a little beyond the `feet` of its touches, and as far as a probe can reach, if
    /// that is no farther than `reach`.
    #[must_use]
    pub fn of(shape: &Shape, extent: &Extent, feet: &[Point3<f64>], reach: f64) -> Self {
        match shape {
            Shape::Plane { point, normal } => plane(point, normal, extent, feet, reach),
            Shape::Cylinder { point, axis, radius, bore } => {
                let [low, high] = along(point, axis, extent, feet, reach);
                revolved(point, axis, &rings([low, high], |_| *radius), *bore)
            }
            Shape::Cone { apex, axis, half_angle, bore } => {
                let [low, high] = along(apex, axis, extent, feet, reach).map(|height| height.max(0.0));
                revolved(apex, axis, &rings([low, high], |height| height * half_angle.tan()), *bore)
            }
            Shape::Sphere { center, radius, bore } => {
                let rings: Vec<_> = (0..=RINGS)
                    .map(|ring| {
                        let (sin, cos) = (PI * ring as f64 / RINGS as f64).sin_cos();
                        (-radius * cos, radius * sin)
                    })
                    .collect();
                revolved(center, &Vector3::z_axis(), &rings, *bore)
            }
            _ => Self::default(),
        }
    }

    /// Without what lies beyond a plane: where `depth`, the signed distance from it, is positive.
    #[must_use]
    pub fn cut(mut self, depth: impl Fn(&Point3<f64>) -> f64) -> Self {
        let depths: Vec<f64> = self.vertices.iter().map(depth).collect();
        if depths.iter().all(|depth| *depth <= 0.0) {
            return self;
        }
        // Neighbours share the corner in which their common edge is cut.
        let mut cuts: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        let mut kept = Vec::new();
        for face in &self.faces {
            let mut corners = Vec::new();
            for (k, &from) in face.iter().enumerate() {
                let to = face[(k + 1) % face.len()];
                if depths[from] <= 0.0 {
                    corners.push(from);
                }
                if (depths[from] <= 0.0) != (depths[to] <= 0.0) {
                    let vertices = &mut self.vertices;
                    corners.push(*cuts.entry([from.min(to), from.max(to)]).or_insert_with(|| {
                        let part = depths[from] / (depths[from] - depths[to]);
                        vertices.push(vertices[from] + (vertices[to] - vertices[from]) * part);
                        vertices.len() - 1
                    }));
                }
            }
            if corners.len() > 2 {
                kept.push(corners);
            }
        }
        self.faces = kept;
        self.with_edges()
    }

    /// Outward normal of a face, of unit length; zero for one without area.
    #[must_use]
    pub fn normal(&self, face: usize) -> Vector3<f64> {
        let corners = &self.faces[face];
        let at = |k: usize| self.vertices[corners[k % corners.len()]];
        // Newell's: true of any polygon, even one with two corners in one place.
        let area = (0..corners.len()).map(|k| at(k).coords.cross(&at(k + 1).coords)).sum::<Vector3<f64>>();
        area.try_normalize(0.0).unwrap_or_default()
    }

    /// Finds the edges of the faces.
    fn with_edges(mut self) -> Self {
        /// Cosine of the angle between faces from which on their edge is a corner of the surface.
        const CORNER: f64 = 0.7;
        /// An edge shorter than this part of the surface has no length but by rounding.
        const TINY: f64 = 1e-9;
        let mut edges: BTreeMap<[usize; 2], (usize, Option<usize>)> = BTreeMap::new();
        for (index, face) in self.faces.iter().enumerate() {
            for (k, &from) in face.iter().enumerate() {
                let to = face[(k + 1) % face.len()];
                let faces = edges.entry([from.min(to), from.max(to)]).or_insert((index, None));
                if faces.0 != index {
                    faces.1 = Some(index);
                }
            }
        }
        let edge = |(ends, faces): ([usize; 2], (usize, Option<usize>))| {
            let rim = faces.1.is_none_or(|other| self.normal(faces.0).dot(&self.normal(other)) < CORNER);
            Edge { ends, faces, rim }
        };
        // At the poles of a ball and at the tip of a cone corners fall together.
        let size = self.vertices.iter().map(|vertex| (vertex - self.vertices[0]).norm()).fold(0.0, f64::max);
        let long = |([from, to], _): &([usize; 2], _)| {
            (self.vertices[*from] - self.vertices[*to]).norm() > TINY * size
        };
        self.edges = edges.into_iter().filter(long).map(edge).collect();
        self
    }
}

/// Heights above a point of an axis, and the radius at each.
fn rings([low, high]: [f64; 2], radius: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let heights = (0..=SQUARES).map(|step| low + (high - low) * step as f64 / SQUARES as f64);
    heights.map(|height| (height, radius(height))).collect()
}

/// A little beyond the feet of touches, told along a line, and to the ends of what a probe can reach as far as these are
/// within `reach` of them.
fn range(feet: impl Iterator<Item = f64>, ends: [f64; 2], reach: f64) -> [f64; 2] {
    let [low, high] =
        feet.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    if low > high {
        let middle = 0.5 * (ends[0] + ends[1]);
        return [ends[0].max(middle - reach), ends[1].min(middle + reach)];
    }
    let margin = MARGIN * (high - low);
    [(low - margin).min(ends[0].max(low - reach)), (high + margin).max(ends[1].min(high + reach))]
}

fn plane(
    point: &Point3<f64>,
    normal: &Unit<Vector3<f64>>,
    extent: &Extent,
    feet: &[Point3<f64>],
    reach: f64,
) -> Mesh {
    let ends = if let Extent::Disc { radius } = extent { [-radius, *radius] } else { [0.0; 2] };
    let (e1, e2) = perpendiculars(normal);
    let [u, v] = [e1, e2].map(|e| range(feet.iter().map(|foot| e.dot(&(foot - point))), ends, reach));
    let at = |[low, high]: [f64; 2], step: usize| low + (high - low) * step as f64 / SQUARES as f64;
    let corners = (0..=SQUARES).flat_map(|row| (0..=SQUARES).map(move |column| (row, column)));
    let vertices = corners.map(|(row, column)| point + e1 * at(u, row) + e2 * at(v, column)).collect();
    let index = |row: usize, column: usize| row * (SQUARES + 1) + column;
    let squares = (0..SQUARES).flat_map(|row| (0..SQUARES).map(move |column| (row, column)));
    let square = |(row, column)| {
        vec![index(row, column), index(row + 1, column), index(row + 1, column + 1), index(row, column + 1)]
    };
    Mesh { vertices, faces: squares.map(square).collect(), ..Mesh::default() }.with_edges()
}

/// From where to where an axis is drawn, counted from `point`.
fn along(
    point: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
    extent: &Extent,
    feet: &[Point3<f64>],
    reach: f64,
) -> [f64; 2] {
    let ends = if let Extent::Along { from, to } = extent { [*from, *to] } else { [0.0; 2] };
    range(feet.iter().map(|foot| axis.dot(&(foot - point))), ends, reach)
}

/// Rings about an axis, each at its height above `point` and of its radius, and what closes them; of a bore the inside.
fn revolved(point: &Point3<f64>, axis: &Unit<Vector3<f64>>, rings: &[(f64, f64)], bore: bool) -> Mesh {
    let (e1, e2) = perpendiculars(axis);
    let mut mesh = Mesh { solid: true, ..Mesh::default() };
    for (height, radius) in rings {
        for step in 0..AROUND {
            let (sin, cos) = (TAU * step as f64 / AROUND as f64).sin_cos();
            mesh.vertices.push(point + **axis * *height + (e1 * cos + e2 * sin) * *radius);
        }
    }
    let index = |ring: usize, step: usize| ring * AROUND + step % AROUND;
    for ring in 1..rings.len() {
        for step in 0..AROUND {
            mesh.faces.push(vec![
                index(ring - 1, step),
                index(ring - 1, step + 1),
                index(ring, step + 1),
                index(ring, step),
            ]);
        }
    }
    if bore {
        mesh.faces.iter_mut().for_each(|face| face.reverse());
    } else {
        let cap = |ring: usize| (0..AROUND).map(|step| index(ring, step)).collect::<Vec<_>>();
        let ends = [
            (rings[0].1, cap(0).into_iter().rev().collect()),
            (rings[rings.len() - 1].1, cap(rings.len() - 1)),
        ];
        // A ball and the tip of a cone need none.
        let widest = rings.iter().map(|ring| ring.1).fold(0.0, f64::max);
        mesh.faces.extend(ends.into_iter().filter(|(radius, _)| *radius > 1e-9 * widest).map(|(_, cap)| cap));
    }
    mesh.with_edges()
}
