//! What may be touched and what for, from the arguments that `plan` and `guide` share.

use nalgebra::{Point3, Unit, Vector3};
use touchref::{
    Extent, Fixture, Frame, Probe, Shape, Solver,
    analysis::planning::{Cone, Criterion, LEAST_REDUNDANCY, Planner, Reach, default_points},
    io::InputError,
    statistics::student_factor,
};

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    points::{PointArgs, point},
    setup::{Setup, missing_sigma, name_and_value},
};

/// Coverage probability of expanded uncertainties.
const COVERAGE: f64 = 0.95;

/// By which a standard uncertainty is multiplied to be expanded, for a stated sigma.
pub(crate) fn coverage_factor() -> f64 {
    student_factor(COVERAGE, f64::INFINITY)
}

/// Refuses a target where no sigma is stated to predict by.
pub(crate) fn can_aim(setup: &Setup) -> Result<(), InputError> {
    let message = || "no sigma is stated, so no uncertainty can be aimed at".to_owned();
    setup.measurement.probe.sigma.map_or_else(|| Err(missing_sigma(message())), |_| Ok(()))
}

/// What may be touched, and where the frame is used.
#[derive(Debug, clap::Args)]
pub(crate) struct PlanningArgs {
    #[command(flatten)]
    points: PointArgs,
    /// What is made small: the uncertainty of the worst point along its worst direction, or the volume of the confidence
    /// region of the frame (D-optimal)
    #[arg(long, value_enum, value_name = "CRITERION", default_value_t)]
    criterion: CriterionArg,
    /// Side from which the probe comes, in fixture coordinates: 0,0,1 is against the Z axis; with --cone
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = direction, requires = "cone")]
    from: Option<Unit<Vector3<f64>>>,
    /// Largest angle between that side and the normal of a surface where it is touched, degrees; with --from
    #[arg(long, value_name = "DEG", value_parser = cone_angle, requires = "from")]
    cone: Option<f64>,
    /// What of a surface is reached, instead of what the fixture states: `plane=RADIUS` around the plane's point,
    /// `cylinder=FROM,TO` along an axis, `ball=DEG` around the middle of a sphere's cap; may be repeated
    #[arg(long = "extent", value_name = "SURFACE=NUMBERS", allow_hyphen_values = true, value_parser = name_and_value)]
    extents: Vec<(String, String)>,
    /// Least redundancy number asked of every touch where their count allows it; 0 asks for none
    #[arg(long, value_name = "R", default_value_t = LEAST_REDUNDANCY, value_parser = redundancy)]
    redundancy: f64,
}

/// A criterion, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum CriterionArg {
    /// The worst point of use
    #[default]
    Worst,
    /// The volume of the confidence region
    Volume,
}

fn direction(text: &str) -> Result<Unit<Vector3<f64>>, String> {
    let direction = point(text)?.coords;
    touchref::direction(direction).ok_or_else(|| "expected a direction, not all zero".to_owned())
}

fn number_where(text: &str, right: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|value| right(*value)).ok_or_else(|| expected.to_owned())
}

fn cone_angle(text: &str) -> Result<f64, String> {
    number_where(text, |angle| angle > 0.0 && angle <= 180.0, "expected degrees, above 0 and at most 180")
}

fn redundancy(text: &str) -> Result<f64, String> {
    number_where(text, |least| (0.0..1.0).contains(&least), "expected a number from 0 to below 1")
}

/// A length above 0, for an argument.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    number_where(text, |length| length > 0.0 && length.is_finite(), "expected a length > 0")
}

impl PlanningArgs {
    /// Which criterion.
    pub(crate) fn criterion(&self) -> CriterionArg {
        self.criterion
    }

    /// The least redundancy number asked for.
    pub(crate) fn redundancy(&self) -> f64 {
        self.redundancy
    }

    /// Points of use.
    pub(crate) fn points(&self, fixture: &dyn Fixture) -> Vec<Point3<f64>> {
        self.points.given().unwrap_or_else(|| default_points(fixture))
    }

    /// The planner that they describe.
    pub(crate) fn planner<'a>(
        &self,
        setup: &'a Setup,
        solver: &'a dyn Solver,
    ) -> Result<Planner<'a>, InputError> {
        let fixture = &*setup.fixture;
        let mut reach = Reach::of(fixture);
        for (name, text) in &self.extents {
            let surface =
                fixture.surface_index(name).map_err(|error| InputError::from(error).with_key("extent"))?;
            reach = reach.with_extent(surface, extent(fixture, surface, text)?);
        }
        if let (Some(from), Some(cone)) = (self.from, self.cone) {
            reach = reach.with_cone(Cone { along: -from, half_angle: cone.to_radians() });
        }
        Ok(Planner {
            fixture,
            probe: setup.measurement.probe,
            solver,
            reach,
            points: self.points(fixture),
            criterion: match self.criterion {
                CriterionArg::Worst => Criterion::Worst,
                CriterionArg::Volume => Criterion::Volume,
            },
            least_redundancy: self.redundancy,
        })
    }
}

/// What of a surface is reached, from text.
fn extent(fixture: &dyn Fixture, surface: usize, text: &str) -> Result<Extent, InputError> {
    let surface = &fixture.surfaces()[surface];
    let numbers = text.split(',').map(|number| number.trim().parse::<f64>().ok().filter(|v| v.is_finite()));
    let numbers: Option<Vec<f64>> = numbers.collect();
    let (found, expected) = match (&surface.shape, surface.extent, numbers.as_deref()) {
        (Shape::Plane { .. }, _, Some(&[radius])) if radius > 0.0 => (Some(Extent::Disc { radius }), ""),
        (Shape::Plane { .. }, ..) => (None, "a radius > 0"),
        (Shape::Sphere { .. }, Extent::Cap { axis, .. }, Some(&[angle])) if angle > 0.0 && angle <= 180.0 => {
            (Some(Extent::Cap { axis, half_angle: angle.to_radians() }), "")
        }
        (Shape::Sphere { .. }, ..) => (None, "degrees, above 0 and at most 180"),
        (Shape::Cone { .. }, _, Some(&[from, to])) if from >= 0.0 && from < to => {
            (Some(Extent::Along { from, to }), "")
        }
        (Shape::Cone { .. }, ..) => (None, "FROM,TO along the axis from the apex, 0 <= FROM < TO"),
        (_, _, Some(&[from, to])) if from < to => (Some(Extent::Along { from, to }), ""),
        _ => (None, "FROM,TO along the axis, FROM < TO"),
    };
    found.ok_or_else(|| {
        let message = format!("the extent of `{}` is `{text}`; expected {expected}", surface.name);
        InputError::new("invalid-input", message).with_key("extent")
    })
}

/// A place to touch.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlaceRecord {
    /// Name of the surface.
    pub(crate) surface: String,
    /// Where the surface is met, in fixture coordinates.
    pub(crate) contact: [f64; 3],
    /// Centre of the tip there, in fixture coordinates.
    pub(crate) tip: [f64; 3],
    /// Direction of the probe's motion, in fixture coordinates.
    pub(crate) approach: [f64; 3],
    /// The same in the parent, where a frame is known or expected.
    pub(crate) parent: Option<InParent>,
}

/// A place to touch, in the parent.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct InParent {
    /// Centre of the tip.
    pub(crate) tip: [f64; 3],
    /// Direction of the probe's motion, a unit vector.
    pub(crate) approach: [f64; 3],
}

impl PlaceRecord {
    pub(crate) fn new(
        fixture: &dyn Fixture,
        probe: &Probe,
        surface: usize,
        contact: &Point3<f64>,
        frame: Option<&Frame>,
    ) -> Self {
        let surface = &fixture.surfaces()[surface];
        let tip = surface.tip_center(contact, probe.tip_radius);
        let approach = surface.approach(contact).into_inner();
        Self {
            surface: surface.name.clone(),
            contact: (*contact).into(),
            tip: tip.into(),
            approach: approach.into(),
            parent: frame.map(|frame| InParent {
                tip: frame.to_parent(&tip).into(),
                approach: (frame.rotation * approach).into(),
            }),
        }
    }
}
