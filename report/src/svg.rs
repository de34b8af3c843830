//! A picture of a scene as SVG: from one side, without perspective, and by itself, so that it needs no style sheet.
//!
//! Its colours are attributes, which the rules of a style sheet replace: a page recolours it by its classes.

use std::fmt::Write as _;

use maud::{Markup, html};
use nalgebra::{Matrix2, Point3, Vector2, Vector3};

use touchref_core::Frame;

use crate::scene::{Ellipsoid, Ghost, Mesh, Patch, Scene};

/// Shades of a surface, from the darkest; class `shade-0` and so on.
const SHADES: [&str; 8] =
    ["#b4c1ce", "#bcc8d4", "#c5d0da", "#cdd7e0", "#d6dee6", "#dee5ec", "#e6ecf1", "#eef2f6"];
/// Colours of the fixture's X, Y and Z axes; class `axis-x` and so on.
const AXES: [(&str, &str); 3] = [("X", "#b3261e"), ("Y", "#2b7a33"), ("Z", "#1f5fbf")];
/// Size of the picture.
const SIZE: Vector2<f64> = Vector2::new(760.0, 540.0);
/// What stays free about it: room for words.
const FREE: f64 = 34.0;
/// With more touches than this their numbers would cover each other.
const MOST_NUMBERED: usize = 24;
/// Length of a drawn normal, as a part of the scene.
pub(crate) const NORMAL: f64 = 0.13;

/// The picture of a scene from where it is seen best, told as `title`.
#[must_use]
pub fn picture(scene: &Scene, title: &str) -> Markup {
    let picture = Picture::new(scene);
    html! {
        svg class="scene" xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (SIZE.x) " " (SIZE.y) }
            width=(SIZE.x) height=(SIZE.y) role="img" font-family="system-ui, sans-serif" font-size="13" {
            title { (title) }
            g class="ghosts" fill="none" stroke="#8a8f98" stroke-width="1" stroke-dasharray="3 3" {
                @for ghost in &scene.ghosts { (picture.ghost(ghost)) }
            }
            g class="surfaces" opacity="0.92" stroke-linejoin="round" { (picture.surfaces()) }
            path class="hidden" d=(picture.rims(&scene.frame)) fill="none" stroke="#66707c" stroke-width="0.8" stroke-dasharray="2 3" {}
            g class="axes" stroke-width="2" { (picture.axes()) }
            g class="ellipsoids" fill="#6d4bb0" fill-opacity="0.12" stroke="#6d4bb0" {
                @for ellipsoid in &scene.ellipsoids { (picture.ellipsoid(ellipsoid)) }
            }
            g class="touches" { (picture.touches()) }
            g class="parent" stroke="#5f6670" stroke-width="1.2" { (picture.parent()) }
        }
    }
}

/// How a scene is laid onto the picture.
struct Picture<'a> {
    scene: &'a Scene,
    /// To the right, up, and toward the viewer.
    axes: [Vector3<f64>; 3],
    /// Of what is drawn, on the picture's plane.
    middle: Vector2<f64>,
    scale: f64,
}

impl<'a> Picture<'a> {
    fn new(scene: &'a Scene) -> Self {
        let mut picture = Self { scene, axes: scene.view.axes(), middle: Vector2::zeros(), scale: 1.0 };
        let corners = scene.patches.iter().flat_map(|patch| &patch.mesh.vertices);
        let corners = corners.map(|corner| scene.frame.to_parent(corner));
        let marks = scene.touches.iter().map(|touch| touch.foot + touch.normal * NORMAL * scene.radius);
        let ends = (0..3).map(|k| picture.end_of_axis(k));
        let all: Vec<_> = corners.chain(marks).chain(ends).map(|point| picture.flat(&point)).collect();
        let (low, high) = all.iter().fold((all[0], all[0]), |(low, high), at| (low.inf(at), high.sup(at)));
        let room = (SIZE - Vector2::repeat(2.0 * FREE)).component_div(&(high - low));
        picture.middle = 0.5 * (low + high);
        picture.scale = room.min().min(1e12 / scene.radius);
        picture
    }

    fn end_of_axis(&self, axis: usize) -> Point3<f64> {
        self.scene.frame.origin + self.scene.frame.axis(axis) * self.scene.axis
    }

    /// A point of the parent on the picture's plane, up and to the right.
    fn flat(&self, point: &Point3<f64>) -> Vector2<f64> {
        let from_center = point - self.scene.center;
        Vector2::new(self.axes[0].dot(&from_center), self.axes[1].dot(&from_center))
    }

    /// Where a point of the parent is in the picture.
    fn at(&self, point: &Point3<f64>) -> Vector2<f64> {
        let flat = (self.flat(point) - self.middle) * self.scale;
        0.5 * SIZE + Vector2::new(flat.x, -flat.y)
    }

    fn depth(&self, point: &Point3<f64>) -> f64 {
        self.axes[2].dot(&(point - self.scene.center))
    }

    fn faces_viewer(&self, direction: &Vector3<f64>) -> bool {
        self.axes[2].dot(direction) > 0.0
    }

    fn path<'p>(&self, points: impl IntoIterator<Item = &'p Point3<f64>>) -> String {
        let mut path = String::new();
        for point in points {
            let at = self.at(point);
            // Writing to a string cannot fail.
            let _ = write!(path, "{}{:.1} {:.1}", if path.is_empty() { "M" } else { "L" }, at.x, at.y);
        }
        path
    }

    /// Surfaces from the back to the front; those that lie on one side of a plane by that, whatever their depths.
    fn ordered(&self) -> Vec<&'a Patch> {
        let patches = &self.scene.patches;
        let faces_viewer = |plane: usize| {
            let normal = (!patches[plane].mesh.faces.is_empty()).then(|| patches[plane].mesh.normal(0));
            normal.is_some_and(|normal| self.faces_viewer(&(self.scene.frame.rotation * normal)))
        };
        // Whether one hides the other, as far as a plane tells.
        let hides = |one: usize, other: usize| match (patches[one].above[other], patches[other].above[one]) {
            (Some(above), _) => above == faces_viewer(other),
            (None, Some(above)) => above != faces_viewer(one),
            (None, None) => false,
        };
        let depth = |patch: &usize| {
            let vertices = &patches[*patch].mesh.vertices;
            let depths = vertices.iter().map(|vertex| self.depth(&self.scene.frame.to_parent(vertex)));
            depths.sum::<f64>() / vertices.len().max(1) as f64
        };
        let mut left: Vec<usize> = (0..patches.len()).collect();
        left.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        let mut ordered = Vec::new();
        while !left.is_empty() {
            // Where each hides another one, the farthest.
            let free =
                left.iter().position(|one| left.iter().all(|other| other == one || !hides(*one, *other)));
            ordered.push(&patches[left.remove(free.unwrap_or(0))]);
        }
        ordered
    }

    /// Faces and the edges that are seen.
    fn surfaces(&self) -> Markup {
        html! { @for patch in self.ordered() { (self.surface(patch)) } }
    }

    fn surface(&self, patch: &Patch) -> Markup {
        /// By how much an edge is nearer than its faces, as a part of the scene.
        const NEARER: f64 = 0.03;
        let mut drawn: Vec<(f64, Markup)> = Vec::new();
        let placed = Placed::of(patch, &self.scene.frame);
        for (index, face) in patch.mesh.faces.iter().enumerate() {
            let seen = self.faces_viewer(&placed.normals[index]);
            if !seen && patch.mesh.solid {
                continue;
            }
            let corners = || face.iter().map(|corner| &placed.vertices[*corner]);
            let depth = corners().map(|corner| self.depth(corner)).sum::<f64>() / face.len() as f64;
            let shade = self.shade(&placed.normals[index]);
            let (class, colour) =
                if seen { (format!("shade-{shade}"), SHADES[shade]) } else { ("back".to_owned(), "#aab4be") };
            let path = self.path(corners()) + "Z";
            drawn.push((depth, html! { path class=(class) d=(path) fill=(colour) stroke=(colour) {} }));
        }
        for edge in &patch.mesh.edges {
            let seen = |face: usize| self.faces_viewer(&placed.normals[face]);
            let (first, second) = (seen(edge.faces.0), edge.faces.1.map(seen));
            let outline = second.is_some_and(|second| first != second);
            let in_sight = first || second == Some(true) || !patch.mesh.solid;
            if in_sight && (edge.rim || outline) {
                let ends = edge.ends.map(|end| placed.vertices[end]);
                let depth = 0.5 * (self.depth(&ends[0]) + self.depth(&ends[1])) + NEARER * self.scene.radius;
                drawn.push((depth, html! { path class="edge" d=(self.path(&ends)) stroke="#66707c" {} }));
            }
        }
        drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
        html! { @for (_, item) in &drawn { (item) } }
    }

    /// How bright a face is by the light from the upper left behind the viewer.
    fn shade(&self, normal: &Vector3<f64>) -> usize {
        let light = (self.axes[2] * 0.8 + self.axes[1] * 0.5 - self.axes[0] * 0.33).normalize();
        let brightest = SHADES.len() - 1;
        let bright = (normal.dot(&light).max(0.0) * brightest as f64).round();
        (0..brightest).find(|step| *step as f64 >= bright).unwrap_or(brightest)
    }

    /// Where the surfaces end when the fixture stands at `frame`, also behind others.
    fn rims(&self, frame: &Frame) -> String {
        let rims = |patch: &Patch| {
            let rims = patch.mesh.edges.iter().filter(|edge| edge.rim);
            rims.map(|edge| self.path(&edge.ends.map(|end| frame.to_parent(&patch.mesh.vertices[end]))))
                .collect::<String>()
        };
        self.scene.patches.iter().map(rims).collect()
    }

    fn ghost(&self, ghost: &Ghost) -> Markup {
        let frame = &ghost.frame;
        let axes = (0..3).map(|k| self.path(&[frame.origin, frame.origin + frame.axis(k) * self.scene.axis]));
        html! { path d=(self.rims(frame) + &axes.collect::<String>()) { title { "rejected: " (ghost.reason) } } }
    }

    fn axes(&self) -> Markup {
        let from = self.at(&self.scene.frame.origin);
        html! {
            @for (axis, (name, colour)) in AXES.iter().enumerate() {
                @let to = self.at(&self.end_of_axis(axis));
                @let label = to + (to - from).try_normalize(1.0).unwrap_or_default() * 10.0;
                g class={ "axis-" (name.to_lowercase()) } stroke=(colour) fill=(colour) {
                    (line(from, to))
                    text x=(tenth(label.x)) y=(tenth(label.y + 4.5)) text-anchor="middle" stroke="none" font-weight="600" { (name) }
                }
            }
        }
    }

    fn ellipsoid(&self, ellipsoid: &Ellipsoid) -> Markup {
        let scale = self.scale * self.scene.ellipsoids_magnified;
        let row = |k: usize| ellipsoid.half_axes.tr_mul(&self.axes[k]) * scale;
        let (right, up) = (row(0), row(1));
        // What a projected ball is: the ellipse of the half axes' own squares.
        let flat = Matrix2::new(right.dot(&right), -right.dot(&up), -right.dot(&up), up.dot(&up));
        let eigen = flat.symmetric_eigen();
        let [a, b] = [0, 1].map(|k| eigen.eigenvalues[k].max(0.0).sqrt());
        let turn = eigen.eigenvectors[(1, 0)].atan2(eigen.eigenvectors[(0, 0)]).to_degrees();
        let at = self.at(&ellipsoid.at);
        html! {
            ellipse rx=(tenth(a)) ry=(tenth(b))
                transform={ "translate(" (tenth(at.x)) " " (tenth(at.y)) ") rotate(" (tenth(turn)) ")" } {}
        }
    }

    fn touches(&self) -> Markup {
        /// A tip of a radius below this is hidden behind the mark of its touch.
        const SEEN: f64 = 4.0;
        let numbered = self.scene.touches.len() <= MOST_NUMBERED;
        let tip_radius = self.scene.tip_radius * self.scale;
        html! {
            @for (index, touch) in self.scene.touches.iter().enumerate() {
                @let foot = self.at(&touch.foot);
                @let end = self.at(&(touch.foot + touch.normal * NORMAL * self.scene.radius));
                @let off = self.at(&(touch.foot + touch.normal * touch.residual * self.scene.residuals_magnified));
                @let seen = self.faces_viewer(&touch.normal);
                @let (class, colour) = if touch.excluded { ("touch excluded", "#b3261e") } else { ("touch", "#1d2733") };
                g class=(class) opacity=(if seen { "1" } else { "0.45" }) stroke=(colour) fill=(colour) {
                    title { (touch.text) }
                    g class="normal" stroke-width="1" { (line(foot, end)) }
                    @if tip_radius > SEEN {
                        @let tip = self.at(&touch.tip);
                        circle class="tip" cx=(tenth(tip.x)) cy=(tenth(tip.y)) r=(tenth(tip_radius)) fill="none" stroke="#8a8f98" stroke-width="0.8" {}
                    }
                    @if !touch.excluded {
                        g class="residual" stroke="#c2571a" stroke-width="4" stroke-linecap="round" { (line(foot, off)) }
                    }
                    circle cx=(tenth(foot.x)) cy=(tenth(foot.y)) r="3.6" fill=(if touch.excluded { "#ffffff" } else { colour }) {}
                    @if numbered {
                        @let label = end + (end - foot).try_normalize(1.0).unwrap_or(Vector2::new(0.6, -0.8)) * 8.0;
                        text x=(tenth(label.x)) y=(tenth(label.y + 4.0)) text-anchor="middle" stroke="none" font-size="12" { (index) }
                    }
                }
            }
        }
    }

    /// The parent's axes, in the corner.
    fn parent(&self) -> Markup {
        const LENGTH: f64 = 30.0;
        let from = Vector2::new(54.0, SIZE.y - 48.0);
        html! {
            @for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                @let flat = Vector2::new(self.axes[0][axis], -self.axes[1][axis]);
                @let to = from + flat * LENGTH;
                @let label = from + flat * (LENGTH + 9.0);
                (line(from, to))
                text x=(tenth(label.x)) y=(tenth(label.y + 4.0)) text-anchor="middle" stroke="none" fill="#5f6670" font-size="12" { (name) }
            }
            text x="54" y=(SIZE.y - 6.0) text-anchor="middle" stroke="none" fill="#5f6670" font-size="11" { "parent" }
        }
    }
}

/// A mesh placed in the parent.
struct Placed {
    vertices: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
}

impl Placed {
    fn of(patch: &Patch, frame: &Frame) -> Self {
        let Mesh { vertices, faces, .. } = &patch.mesh;
        Self {
            vertices: vertices.iter().map(|vertex| frame.to_parent(vertex)).collect(),
            normals: (0..faces.len()).map(|face| frame.rotation * patch.mesh.normal(face)).collect(),
        }
    }
}

fn line(from: Vector2<f64>, to: Vector2<f64>) -> Markup {
    html! { line x1=(tenth(from.x)) y1=(tenth(from.y)) x2=(tenth(to.x)) y2=(tenth(to.y)) {} }
}

/// A coordinate of the picture: tenths are finer than what is seen.
fn tenth(value: f64) -> String {
    format!("{value:.1}")
}
