//! An integrator's own binary: the whole command line, with a fixture of the house linked in.
//!
//! ```text
//! cargo run -p touchref-cli --example own_binary -- describe corner
//! cargo run -p touchref-cli --example own_binary -- simulate --fixture corner -p edge=80 --sigma 0.01
//! ```

use std::process::ExitCode;

use nalgebra::{Point3, Vector3};
use touchref::{
    Extent, Fixture, FixturePlugin, ParameterKind, ParameterSpec, Parameters, Requirement, Shape, Surface,
    register_fixture,
};

/// Three faces that meet at a right-angled corner, each a square of `edge`.
#[derive(Debug)]
struct Corner {
    parameters: Parameters,
    surfaces: Vec<Surface>,
    requirement: Requirement,
}

static PLUGIN: FixturePlugin = FixturePlugin {
    name: "corner",
    summary: "three faces that meet at a right-angled corner",
    origin: module_path!(),
    parameters: &[ParameterSpec {
        name: "edge",
        kind: ParameterKind::Length,
        default: Some("50"),
        meaning: "edge of each face",
    }],
    surfaces: &[("x", "the face across X"), ("y", "the face across Y"), ("z", "the face across Z")],
    touches: "3 on `z`, 2 on `y`, 1 on `x`, or more",
    frame: "origin at the corner, axes along the outward normals",
    drawing: "      Z\n      |__ Y\n     /\n    X",
    reference: "house standard 12-3",
    build: |parameters| Ok(Box::new(Corner::new(parameters))),
};
register_fixture!(PLUGIN);

impl Corner {
    fn new(parameters: &Parameters) -> Self {
        let half = 0.5 * parameters.number("edge");
        let faces = [("x", Vector3::x_axis()), ("y", Vector3::y_axis()), ("z", Vector3::z_axis())];
        let surfaces = faces.map(|(name, normal)| {
            let middle = Point3::from(normal.map(|v| if v == 0.0 { -half } else { 0.0 }));
            Surface::new(name, Shape::Plane { point: middle, normal }, Extent::Disc { radius: half })
        });
        Self {
            parameters: parameters.clone(),
            surfaces: surfaces.into(),
            requirement: Requirement::counts(&[1, 2, 3]),
        }
    }
}

impl Fixture for Corner {
    fn kind(&self) -> &'static str {
        PLUGIN.name
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    fn requirement(&self) -> &Requirement {
        &self.requirement
    }

    fn size(&self) -> f64 {
        self.parameters.number("edge")
    }

    fn nominal_layout(&self) -> Vec<(usize, Point3<f64>)> {
        let on = |surface: usize, u| (surface, self.surfaces[surface].point_at(u, 0.8));
        vec![on(2, 0.0), on(2, 0.33), on(2, 0.67), on(1, 0.0), on(1, 0.5), on(0, 0.25)]
    }
}

fn main() -> ExitCode {
    touchref_cli::run(touchref::registry(), std::env::args_os())
}
