//! `corner`: three mutually perpendicular planes, touched 3-2-1 as in every machine shop.

use nalgebra::{Point3, Vector3};
use touchref::{
    ClosedForm, Extent, Fixture, FixturePlugin, Frame, MAX_MEASURES, ParameterError, ParameterKind,
    ParameterSpec, Parameters, Problem, Requirement, Root, RootKind, Shape, SolveError, Surface,
};

/// The plugin.
pub(crate) static PLUGIN: FixturePlugin = FixturePlugin {
    name: "corner",
    summary: "three mutually perpendicular planes: three touches, two and one",
    origin: module_path!(),
    parameters: &[ParameterSpec {
        name: "reach",
        kind: ParameterKind::Length,
        default: Some("50"),
        meaning: "how far from the corner the planes can be touched",
    }],
    surfaces: &[
        ("x", "the plane across the frame's X, outward normal X"),
        ("y", "the plane across the frame's Y, outward normal Y"),
        ("z", "the plane across the frame's Z, outward normal Z"),
    ],
    touches: "3 on `x`, 2 on `y` and 1 on `z`, or more",
    frame: "origin at the corner; X, Y and Z along the outward normals",
    drawing: r"
          Z
          ^
          |
        __|__
       /__z_/|
       |    |y --> Y
       |_x__|/
         /
        v X
",
    reference: "none",
    build: |parameters| Ok(Box::new(Corner::new(parameters)?)),
};
touchref::register_fixture!(PLUGIN);

/// Three mutually perpendicular planes.
#[derive(Debug)]
pub(crate) struct Corner {
    parameters: Parameters,
    surfaces: Vec<Surface>,
    requirement: Requirement,
}

impl Corner {
    fn new(parameters: &Parameters) -> Result<Self, ParameterError> {
        let parameters = parameters.checked(PLUGIN.parameters)?;
        let reach = parameters.number("reach");
        let normals = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
        let surfaces = ["x", "y", "z"].into_iter().zip(normals).map(|(name, normal)| {
            // The middle of the face: half the reach from both edges.
            let point = Point3::from((normal.into_inner() - Vector3::repeat(1.0)) * (0.5 * reach));
            Surface::new(name, Shape::Plane { point, normal }, Extent::Disc { radius: 0.5 * reach })
        });
        let surfaces = surfaces.collect();
        Ok(Self { parameters, surfaces, requirement: Requirement::counts(&[3, 2, 1]) })
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
        self.parameters.number("reach")
    }

    fn closed_form(&self) -> Option<&dyn ClosedForm> {
        Some(self)
    }

    fn nominal_layout(&self) -> Vec<(usize, Point3<f64>)> {
        // Two touches on `y` one above the other, in a line along Z: they tell the turn about X.
        let places = [(0, 0.0), (0, 1.0 / 3.0), (0, 2.0 / 3.0), (1, 0.25), (1, 0.75), (2, 0.0)];
        places.map(|(surface, u)| (surface, self.surfaces[surface].point_at(u, 1.0))).to_vec()
    }
}

/// The first three, two and one touches; what there are more of is the solver's to weigh.
impl ClosedForm for Corner {
    fn measured(&self) -> &'static [usize] {
        &[]
    }

    /// One root. Touches in a line leave a normal open: it is chosen, and the solver sees from the frame that it could
    /// turn.
    fn roots(&self, problem: &Problem<'_>, emit: &mut dyn FnMut(Root)) -> Result<(), SolveError> {
        let on = |surface| problem.touches_on(surface).map(|(_, touch)| touch.at);
        let (mut on_x, mut on_y, mut on_z) = (on(0), on(1), on(2));
        let (Some(x1), Some(x2), Some(x3)) = (on_x.next(), on_x.next(), on_x.next()) else { return Ok(()) };
        let (Some(y1), Some(y2), Some(z1)) = (on_y.next(), on_y.next(), on_z.next()) else { return Ok(()) };
        // Outward of a face is away from the touches on the others.
        let away = |surface: usize, from: Point3<f64>| -> Vector3<f64> {
            let others = problem.touches().iter().filter(|touch| touch.surface != surface);
            others.map(|touch| from - touch.at).sum()
        };

        let x = across(&(x2 - x1), &(x3 - x1), &away(0, x1));
        let y = across(&x, &(y2 - y1), &away(1, y1));
        let z = x.cross(&y);
        if z.dot(&away(2, z1)) < 0.0 {
            return Err(SolveError::InvalidTouches {
                problem: "the faces `x`, `y`, `z` make a left-handed corner".to_owned(),
                help: "exchange the labels of two faces".to_owned(),
                touches: Vec::new(),
            });
        }
        let tip = problem.probe().tip_radius;
        let corner = [(x, x1), (y, y1), (z, z1)].map(|(n, at)| n * (n.dot(&at.coords) - tip));
        let origin = Point3::from(corner[0] + corner[1] + corner[2]);
        if let Some(frame) = Frame::from_z_and_x(origin, z, x) {
            emit(Root { frame, measures: [0.0; MAX_MEASURES], kind: RootKind::Real });
        }
        Ok(())
    }
}

/// The unit vector across `a` and `b` on the side of `away`; where these are parallel to rounding, what of `away` is
/// across `a`.
fn across(a: &Vector3<f64>, b: &Vector3<f64>, away: &Vector3<f64>) -> Vector3<f64> {
    const PARALLEL: f64 = 1e-9;
    let normal = a.cross(b);
    let normal = if normal.norm() > PARALLEL * a.norm() * b.norm() { normal } else { a.cross(away).cross(a) };
    normal.normalize() * normal.dot(away).signum()
}
