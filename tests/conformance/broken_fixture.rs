//! Fixtures that break one promise each: the check that is meant for it says so.

use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;
use touchref::{
    ClosedForm, Dimension, Extent, Fixture, FixturePlugin, Frame, ParameterError, Parameters, Probe, Problem,
    Requirement, Root, Shape, SolveError, Surface, conformance::Suite, fixtures::cylinder_plane,
};

/// What is wrong, and the check that must say so.
macro_rules! faults {
    ($($(#[$doc:meta])* $fault:ident: $check:literal,)*) => {
        #[derive(Debug, Clone, Copy, PartialEq)]
        enum Fault {
            None,
            $($(#[$doc])* $fault,)*
        }

        const FAULTS: &[(Fault, &str, Build)] =
            &[$((Fault::$fault, $check, |parameters| Broken::built(Fault::$fault, parameters)),)*];
    };
}

faults! {
    /// It goes by another name.
    Name: "description",
    /// A surface does.
    SurfaceName: "description",
    /// It forgets what it was built from.
    ParametersLost: "parameters",
    /// It says that it was built from something else.
    ParametersChanged: "parameters",
    /// Five touches are to be enough.
    FiveTouches: "requirement",
    /// A count for one surface is missing.
    ShortRow: "requirement",
    /// The plane's normal is a thousandth too long.
    LongNormal: "surfaces",
    /// A plane that reaches along an axis.
    ForeignExtent: "surfaces",
    /// A point of the nominal layout is beside its surface.
    NominalBeside: "nominal-layout",
    /// The nominal layout is a ring about the axis.
    NominalRing: "nominal-layout",
    /// A gradient over a dimension is a thousandth too large.
    Gradient: "dimensions",
    /// Shapes do not follow the dimensions.
    Rigid: "dimensions",
    /// A dimension forgets its uncertainty.
    Certain: "dimensions",
    /// The plane can be touched 30 units from the origin, whatever the unit.
    FixedReach: "unit",
    /// The root whose radius is nearest the known one is missing.
    MissingRoot: "roots",
    /// The plane's normal points into the material.
    FlippedNormal: "roots",
    /// The equations take tip centres for surface points.
    TipIgnored: "roots",
    /// The radius of a root is that of the tip's path.
    PathForRadius: "roots",
    /// The first touch decides whether the last root is told.
    OrderDependent: "invariance",
    /// Roots are told where their origin is in front of the parent's.
    ParentDependent: "invariance",
    /// Radii above 50 units are taken to be impossible.
    UnitAssumed: "invariance",
    /// Only the root farthest from the known radius is a candidate.
    FarCandidate: "candidates",
    /// The search is hardly ever done.
    LazySearch: "candidates",
    /// The fixture objects to every frame.
    Objects: "objection",
    /// Touches that coincide make it panic.
    Panics: "wild-touches",
    /// Touches far away give a frame that is none.
    NotANumber: "wild-touches",
}

type Build = fn(&Parameters) -> Result<Box<dyn Fixture>, ParameterError>;

/// `cylinder-plane` with a fault.
#[derive(Debug)]
struct Broken {
    fault: Fault,
    sound: Box<dyn Fixture>,
    parameters: Parameters,
    surfaces: Vec<Surface>,
    requirement: Requirement,
    dimensions: Vec<Dimension>,
}

const PLANE: usize = 1;
const RADIUS: usize = 0;

impl Broken {
    #[allow(clippy::unnecessary_wraps)] // The shape that plugins share.
    fn built(fault: Fault, parameters: &Parameters) -> Result<Box<dyn Fixture>, ParameterError> {
        let sound = cylinder_plane::PLUGIN.build(parameters)?;
        let mut broken = Self {
            fault,
            parameters: sound.parameters().clone(),
            surfaces: sound.surfaces().to_vec(),
            requirement: sound.requirement().clone(),
            dimensions: sound.dimensions().to_vec(),
            sound,
        };
        broken.surfaces[PLANE].shape = broken.plane(&broken.surfaces[PLANE].shape);
        match fault {
            Fault::SurfaceName => "face".clone_into(&mut broken.surfaces[PLANE].name),
            Fault::ParametersLost => broken.parameters = Parameters::new(),
            Fault::ParametersChanged => broken.parameters.set("angle_deg", 44.0.into()),
            Fault::FiveTouches => broken.requirement = Requirement::counts(&[3, 2]),
            Fault::ShortRow => broken.requirement = Requirement::counts(&[7]),
            Fault::ForeignExtent => broken.surfaces[PLANE].extent = Extent::Along { from: 0.0, to: 1.0 },
            Fault::FixedReach => broken.surfaces[PLANE].extent = Extent::Disc { radius: 30.0 },
            Fault::Certain => broken.dimensions[RADIUS].u = 0.0,
            _ => {}
        }
        Ok(Box::new(broken))
    }

    fn plane(&self, shape: &Shape) -> Shape {
        let Shape::Plane { point, normal } = shape else { return shape.clone() };
        let scale = match self.fault {
            Fault::LongNormal => 1.001,
            Fault::FlippedNormal => -1.0,
            _ => 1.0,
        };
        Shape::Plane { point: *point, normal: Unit::new_unchecked(**normal * scale) }
    }

    fn off(&self, root: &Root) -> f64 {
        (root.measures[0] - self.dimensions[RADIUS].value).abs()
    }

    fn sound_roots(&self, problem: &Problem<'_>) -> Result<Vec<Root>, SolveError> {
        let mut roots = Vec::new();
        self.sound.closed_form().unwrap().roots(problem, &mut |root| roots.push(root))?;
        Ok(roots)
    }
}

impl Fixture for Broken {
    fn kind(&self) -> &'static str {
        if self.fault == Fault::Name { "plane-cylinder" } else { self.sound.kind() }
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
        self.sound.size()
    }

    fn dimensions(&self) -> &[Dimension] {
        &self.dimensions
    }

    fn shape_with(&self, surface: usize, values: &[f64]) -> Shape {
        if self.fault == Fault::Rigid {
            return self.surfaces[surface].shape.clone();
        }
        self.plane(&self.sound.shape_with(surface, values))
    }

    fn dimension_gradient(&self, dimension: usize, surface: usize, at: &Point3<f64>, values: &[f64]) -> f64 {
        let scale = match self.fault {
            Fault::Gradient => 1.001,
            Fault::FlippedNormal if surface == PLANE => -1.0,
            _ => 1.0,
        };
        self.sound.dimension_gradient(dimension, surface, at, values) * scale
    }

    fn objection(&self, problem: &Problem<'_>, frame: &Frame) -> Option<String> {
        let objects = self.fault == Fault::Objects;
        objects.then(|| "no".to_owned()).or_else(|| self.sound.objection(problem, frame))
    }

    fn closed_form(&self) -> Option<&dyn ClosedForm> {
        Some(self)
    }

    fn nominal_layout(&self) -> Vec<(usize, Point3<f64>)> {
        let mut layout = self.sound.nominal_layout();
        match self.fault {
            Fault::NominalBeside => layout[0].1 += Vector3::new(0.01, 0.01, 0.0),
            Fault::NominalRing => layout[..4].iter_mut().for_each(|(_, at)| at.z = -3.0 * self.size()),
            _ => {}
        }
        layout
    }
}

impl ClosedForm for Broken {
    fn measured(&self) -> &'static [usize] {
        self.sound.closed_form().unwrap().measured()
    }

    fn roots(&self, problem: &Problem<'_>, emit: &mut dyn FnMut(Root)) -> Result<(), SolveError> {
        let touches = problem.touches();
        let coincident = touches[1..].iter().any(|touch| touch.at == touches[0].at);
        assert!(self.fault != Fault::Panics || !coincident, "touches coincide");
        let surface_points = Probe { tip_radius: 0.0, ..*problem.probe() };
        let without_tip = Problem::new(&*self.sound, touches, surface_points).unwrap();
        let mut roots =
            self.sound_roots(if self.fault == Fault::TipIgnored { &without_tip } else { problem })?;
        roots.sort_by(|a, b| self.off(a).total_cmp(&self.off(b)));
        match self.fault {
            Fault::MissingRoot => drop(roots.drain(..1.min(roots.len()))),
            Fault::OrderDependent if touches[0].at.x > touches[1].at.x => drop(roots.pop()),
            Fault::ParentDependent => roots.retain(|root| root.frame.origin.x > 0.0),
            Fault::UnitAssumed => roots.retain(|root| root.measures[0].abs() < 50.0),
            Fault::PathForRadius => {
                for root in &mut roots {
                    root.measures[0] += problem.probe().tip_radius;
                }
            }
            Fault::NotANumber if touches[0].at.coords.norm() > 1e12 => {
                for root in &mut roots {
                    root.frame.origin.x = f64::NAN;
                }
            }
            _ => {}
        }
        roots.into_iter().for_each(emit);
        Ok(())
    }

    fn candidates(
        &self,
        problem: &Problem<'_>,
        noise: f64,
        emit: &mut dyn FnMut(Frame),
    ) -> Result<f64, SolveError> {
        /// No fault needs more noise than is stated, and beyond it the search is slow.
        const MOST_NOISE: f64 = 1.0;
        match self.fault {
            Fault::FarCandidate => {
                let roots = self.sound_roots(problem)?;
                let farthest = roots.iter().max_by(|a, b| self.off(a).total_cmp(&self.off(b)));
                if let Some(root) = farthest {
                    emit(root.frame);
                }
                Ok(f64::INFINITY)
            }
            Fault::LazySearch => Ok(0.0),
            _ => self.sound.closed_form().unwrap().candidates(problem, noise.min(MOST_NOISE), emit),
        }
    }
}

fn plugin(build: Build) -> FixturePlugin {
    let sound = &cylinder_plane::PLUGIN;
    FixturePlugin {
        name: sound.name,
        summary: sound.summary,
        origin: module_path!(),
        parameters: sound.parameters,
        surfaces: sound.surfaces,
        touches: sound.touches,
        frame: sound.frame,
        drawing: sound.drawing,
        reference: sound.reference,
        build,
    }
}

#[test]
fn every_fault_of_a_fixture_is_caught_by_the_check_meant_for_it() {
    let parameters = Parameters::new().with("radius", 20.0);
    FAULTS.par_iter().for_each(|(fault, check, build)| {
        let report = Suite::default().fixture(&plugin(*build), &parameters);
        println!("{fault:?}: {:?}", report.failed());
        assert!(report.failed().contains(check), "{fault:?} must fail `{check}`: {report}");
    });
}

/// The wrapper itself breaks nothing.
#[test]
fn without_a_fault_nothing_is_caught() {
    let parameters = Parameters::new().with("radius", 20.0);
    let plugin = plugin(|parameters| Broken::built(Fault::None, parameters));
    Suite::default().fixture(&plugin, &parameters).assert_passed();
}
