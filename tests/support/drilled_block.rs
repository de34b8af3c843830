//! A block with a bore and two opposed faces at a known distance: the fixture of which touches alone tell both the
//! radius and the tip, as the bore shows their difference and the faces the tip.

use nalgebra::{Matrix3, Point3, Vector3};
use touchref::{
    ClosedForm, Dimension, Extent, Fixture, FixturePlugin, Frame, MAX_MEASURES, ParameterError,
    ParameterKind, ParameterSpec, Parameters, Problem, Quantity, Requirement, Root, RootKind, Shape,
    SolveError, Surface,
};

/// The plugin; not registered, as only its own tests know it.
pub(crate) static PLUGIN: FixturePlugin = FixturePlugin {
    name: "drilled-block",
    summary: "a bore, two opposed faces and a top",
    origin: module_path!(),
    parameters: &[ParameterSpec {
        name: "radius",
        kind: ParameterKind::Length,
        default: None,
        meaning: "radius of the bore",
    }],
    surfaces: &[("bore", "about Z"), ("top", "z = 0"), ("left", "x = -20"), ("right", "x = 20")],
    touches: "4 in the bore, 3 on top, 2 on the left and 1 on the right, or more",
    frame: "origin where the bore's axis meets the top; Z out of the top, X from left to right",
    drawing: "",
    reference: "none",
    build: |parameters| Ok(Box::new(DrilledBlock::new(parameters)?)),
};

const HALF: f64 = 20.0;
const BORE: usize = 0;
const TOP: usize = 1;
const LEFT: usize = 2;
const RIGHT: usize = 3;

#[derive(Debug)]
struct DrilledBlock {
    parameters: Parameters,
    surfaces: Vec<Surface>,
    dimensions: [Dimension; 1],
    requirement: Requirement,
}

impl DrilledBlock {
    fn new(parameters: &Parameters) -> Result<Self, ParameterError> {
        let parameters = parameters.checked(PLUGIN.parameters)?;
        let (value, u) = parameters.uncertain("radius");
        let plane = |name: &str, normal: Vector3<f64>, off: f64, radius: f64| {
            let normal = nalgebra::Unit::new_normalize(normal);
            let depth = if normal.z == 0.0 { -15.0 } else { 0.0 };
            let point = Point3::from(*normal * off + Vector3::z() * depth);
            Surface::new(name, Shape::Plane { point, normal }, Extent::Disc { radius })
        };
        let surfaces = vec![
            Surface::new("bore", bore(value), Extent::Along { from: -25.0, to: -5.0 }),
            plane("top", Vector3::z(), 0.0, 15.0),
            plane("left", -Vector3::x(), HALF, 10.0),
            plane("right", Vector3::x(), HALF, 10.0),
        ];
        let dimensions = [Dimension { name: "radius".into(), value, u, quantity: Quantity::Length }];
        let requirement = Requirement::counts(&[4, 3, 2, 1]);
        Ok(Self { parameters, surfaces, dimensions, requirement })
    }
}

fn bore(radius: f64) -> Shape {
    Shape::Cylinder { point: Point3::origin(), axis: Vector3::z_axis(), radius, bore: true }
}

impl Fixture for DrilledBlock {
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
        HALF
    }
    fn dimensions(&self) -> &[Dimension] {
        &self.dimensions
    }
    fn shape_with(&self, surface: usize, values: &[f64]) -> Shape {
        if surface == BORE { bore(values[0]) } else { self.surfaces[surface].shape.clone() }
    }
    fn dimension_gradient(&self, _: usize, surface: usize, _: &Point3<f64>, _: &[f64]) -> f64 {
        f64::from(u8::from(surface == BORE))
    }
    fn closed_form(&self) -> Option<&dyn ClosedForm> {
        Some(self)
    }
    fn nominal_layout(&self) -> Vec<(usize, Point3<f64>)> {
        let on = |surface: usize, u: f64, v: f64| (surface, self.surfaces[surface].point_at(u, v));
        let thirds = [0.0, 1.0 / 3.0, 2.0 / 3.0];
        let ring = |v: f64| thirds.map(|u| on(BORE, u + 0.5 * v, v));
        let faces = [TOP, LEFT, RIGHT].into_iter().flat_map(|face| thirds.map(|u| on(face, u, 1.0)));
        ring(0.0).into_iter().chain(ring(1.0)).chain(faces).collect()
    }
}

impl ClosedForm for DrilledBlock {
    fn measured(&self) -> &'static [usize] {
        &[]
    }

    /// One frame: the top's normal, the way from the left to the right, and the middle of the bore's touches, whose
    /// rings are even. A start, not an exact answer.
    fn roots(&self, problem: &Problem<'_>, emit: &mut dyn FnMut(Root)) -> Result<(), SolveError> {
        problem.require_enough()?;
        let mean = |surface: usize| {
            let (mut sum, mut count) = (Vector3::zeros(), 0.0);
            for (_, touch) in problem.touches_on(surface) {
                sum += touch.at.coords;
                count += 1.0;
            }
            sum / count
        };
        let [bore, top, left, right] = [BORE, TOP, LEFT, RIGHT].map(mean);
        let off = |touch: &touchref::Touch| touch.at.coords - top;
        let scatter: Matrix3<f64> =
            problem.touches_on(TOP).map(|(_, touch)| off(touch) * off(touch).transpose()).sum();
        let eigen = scatter.symmetric_eigen();
        let normal: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
        let z = if normal.dot(&(top - bore)) > 0.0 { normal } else { -normal };
        let origin = bore + z * (z.dot(&(top - bore)) - problem.probe().tip_radius);
        if let Some(frame) = Frame::from_z_and_x(origin.into(), z, right - left) {
            emit(Root { frame, measures: [0.0; MAX_MEASURES], kind: RootKind::Real });
        }
        Ok(())
    }
}
