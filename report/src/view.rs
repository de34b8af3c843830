//! The scene as JSON, for the script of the page.
//!
//! Places are whole millionths of the scene's radius from its centre: short, and finer than what is seen.

use nalgebra::{Matrix3, Point3, Vector3};
use serde_json::{Value, json};
use touchref_core::Frame;

use crate::{
    scene::{Mesh, Scene},
    svg::NORMAL,
};

/// Parts of the scene's radius that places are told in.
const PARTS: f64 = 1e6;

/// The scene for the script; everything in the parent, as seen from the scene's centre.
pub(crate) fn json(scene: &Scene) -> Value {
    let length = |length: f64| part(length / scene.radius);
    let vector = |vector: Vector3<f64>| vector.iter().copied().map(length).collect::<Vec<i64>>();
    let place = |point: &Point3<f64>| vector(point - scene.center);
    let direction = |direction: &Vector3<f64>| direction.iter().copied().map(part).collect::<Vec<i64>>();
    let patches = scene.patches.iter().map(|patch| {
        let Mesh { vertices, faces, edges, solid } = &patch.mesh;
        let normals = (0..faces.len()).map(|face| direction(&(scene.frame.rotation * patch.mesh.normal(face))));
        let edges = edges.iter().map(|edge| {
            let [from, to] = edge.ends;
            json!([from, to, edge.faces.0, edge.faces.1, edge.rim])
        });
        json!({
            "name": patch.name,
            "solid": solid,
            "above": patch.above,
            "vertices": vertices.iter().map(|vertex| place(&scene.frame.to_parent(vertex))).collect::<Vec<_>>(),
            "faces": faces,
            "normals": normals.collect::<Vec<_>>(),
            "edges": edges.collect::<Vec<_>>(),
        })
    });
    let touches = scene.touches.iter().map(|touch| {
        json!({
            "text": touch.text,
            "foot": place(&touch.foot),
            "normal": direction(&touch.normal),
            "tip": place(&touch.tip),
            "residual": length(touch.residual * scene.residuals_magnified),
            "excluded": touch.excluded,
        })
    });
    let ellipsoids = scene.ellipsoids.iter().map(|ellipsoid| {
        let half_axes = ellipsoid.half_axes.column_iter();
        let half_axes = half_axes.map(|axis| vector(axis.into_owned() * scene.ellipsoids_magnified));
        json!({ "at": place(&ellipsoid.at), "half_axes": half_axes.collect::<Vec<_>>() })
    });
    let ghosts = scene.ghosts.iter().map(|ghost| {
        let Frame { rotation, origin } = ghost.frame;
        let turn: Matrix3<f64> = rotation.matrix() * scene.frame.rotation.matrix().transpose();
        json!({
            "reason": ghost.reason,
            "origin": place(&origin),
            // Leads from the frame's own places, as seen from its origin, to those of the ghost.
            "turn": turn.row_iter().map(|row| direction(&row.transpose())).collect::<Vec<_>>(),
        })
    });
    json!({
        "parts": PARTS,
        "view": [scene.view.azimuth, scene.view.elevation],
        "origin": place(&scene.frame.origin),
        "axes": (0..3).map(|k| vector(scene.frame.axis(k) * scene.axis)).collect::<Vec<_>>(),
        "normal": part(NORMAL),
        "tip_radius": length(scene.tip_radius),
        "patches": patches.collect::<Vec<_>>(),
        "touches": touches.collect::<Vec<_>>(),
        "ellipsoids": ellipsoids.collect::<Vec<_>>(),
        "ghosts": ghosts.collect::<Vec<_>>(),
    })
}

#[expect(clippy::cast_possible_truncation, reason = "beyond the scene a place may be anywhere: it saturates")]
fn part(value: f64) -> i64 {
    (value * PARTS).round() as i64
}
