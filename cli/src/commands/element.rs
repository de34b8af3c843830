//! `element`: one surface through touches, its sizes free.

use std::{collections::BTreeSet, io, path::PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use schemars::JsonSchema;
use serde::Serialize;
use touchref::{
    Shape,
    io::{Input, InputError, table::TableReader},
    solvers::element::{Element, ElementCovariance, ElementError, ElementKind, fit},
};

use crate::{
    args::Format,
    failure::Failure,
    output::Output,
    text::{self, Look},
};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.element/1";

/// Fit one surface to touches: a plane, sphere, cylinder or cone, its sizes free, without a starting guess
///
/// The surface is the one through the tip centres: where the tip has a radius, a size counts it in. Minimises the sum of
/// squared distances, from starts all around; says how many distinct minima it saw.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref element plane touches.csv --surface plane")]
pub(crate) struct Args {
    /// Kind of surface
    #[arg(value_name = "KIND", value_parser = kinds())]
    kind: ElementKind,
    /// Table of points (CSV) with columns x, y and z, or - for standard input
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// Only the points whose column `surface` says this
    #[arg(long, value_name = "NAME", allow_hyphen_values = true)]
    surface: Option<String>,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

fn kinds() -> impl TypedValueParser<Value = ElementKind> {
    let named = |name: &str| ElementKind::ALL.into_iter().find(|kind| kind.name() == name);
    PossibleValuesParser::new(ElementKind::ALL.map(ElementKind::name))
        .map(move |name| named(&name).unwrap_or(ElementKind::Plane))
}

/// The JSON of `element`: the keys that the element has. Standard uncertainties are from the residuals, and absent where
/// there are no more points than unknowns.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ElementRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// Kind of surface.
    #[schemars(extend("enum" = ElementKind::ALL.map(ElementKind::name)))]
    pub(crate) element: &'static str,
    /// How many points it goes through.
    pub(crate) points: usize,
    /// Nearest the points' mean: of an axis, of a plane; a sphere's centre.
    pub(crate) point: [f64; 3],
    /// Of a plane's normal, of an axis; of a cone to growing radius: a unit vector.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) direction: Option<[f64; 3]>,
    /// Radius of the sphere or cylinder through the points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) radius: Option<f64>,
    /// Its standard uncertainty.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) radius_u: Option<f64>,
    /// Of a cone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) apex: Option<[f64; 3]>,
    /// Angle between axis and surface of a cone, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) half_angle_deg: Option<f64>,
    /// Its standard uncertainty, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) half_angle_deg_u: Option<f64>,
    /// Of `point`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) point_covariance: Option<[[f64; 3]; 3]>,
    /// Of `direction`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) direction_covariance: Option<[[f64; 3]; 3]>,
    /// Root mean square of the distances.
    pub(crate) rms: f64,
    /// Distinct minima that were seen.
    pub(crate) minima: usize,
    /// Of the next lowest minimum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) second_rms: Option<f64>,
}

impl ElementRecord {
    fn new(kind: ElementKind, points: usize, element: &Element) -> Self {
        let (direction, radius, apex, half_angle) = match &element.shape {
            Shape::Plane { normal, .. } => (Some(normal), None, None, None),
            Shape::Sphere { radius, .. } => (None, Some(*radius), None, None),
            Shape::Cylinder { axis, radius, .. } => (Some(axis), Some(*radius), None, None),
            Shape::Cone { apex, axis, half_angle, .. } => (Some(axis), None, Some(apex), Some(*half_angle)),
            _ => (None, None, None, None),
        };
        let covariance = |of: fn(&ElementCovariance) -> _| {
            element.covariance.as_ref().map(of).map(|matrix: nalgebra::Matrix3<f64>| {
                std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
            })
        };
        let size_u = |k: usize| element.covariance.map(|covariance| covariance.sizes[k].sqrt());
        Self {
            schema: SCHEMA,
            element: kind.name(),
            points,
            point: element.point.into(),
            direction: direction.map(|direction| direction.into_inner().into()),
            radius,
            radius_u: radius.and_then(|_| size_u(0)),
            apex: apex.map(|apex| (*apex).into()),
            half_angle_deg: half_angle.map(f64::to_degrees),
            half_angle_deg_u: half_angle.and_then(|_| size_u(1)).map(f64::to_degrees),
            point_covariance: covariance(|covariance| covariance.point),
            direction_covariance: direction.and_then(|_| covariance(|covariance| covariance.direction)),
            rms: element.rms,
            minima: element.minima,
            second_rms: element.second_rms,
        }
    }
}

impl Args {
    pub(crate) fn run(self) -> Result<Output, Failure> {
        let mut reader = TableReader::of_points(&Input::from(self.table))?;
        let (mut points, mut surfaces) = (Vec::new(), BTreeSet::new());
        for record in &mut reader {
            let record = record?;
            if self.surface.as_ref().is_none_or(|wanted| *wanted == record.surface) {
                points.push(record.at);
            }
            surfaces.insert(record.surface);
        }
        let list = || surfaces.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        match &self.surface {
            Some(wanted) if !surfaces.contains(wanted) => {
                let known = surfaces.iter().map(String::as_str);
                return Err(InputError::unknown("unknown-surface", "surface", wanted, known).into());
            }
            None if surfaces.len() > 1 => {
                let message = format!("the table has points of several surfaces: {}", list());
                let error = InputError::new("invalid-input", message).with_key("surface");
                return Err(error.with_help("choose one of them by --surface").into());
            }
            _ => {}
        }
        let element = fit(self.kind, &points).map_err(|error| match error {
            ElementError::Degenerate { .. } => Failure::Undetermined(error),
            ElementError::TooFew { .. } => InputError::new("too-few-touches", error.to_string()).into(),
            other => InputError::new("invalid-input", other.to_string()).into(),
        })?;
        let record = ElementRecord::new(self.kind, points.len(), &element);
        let notes = reader.warnings().iter().map(|warning| format!("warning: {}", warning.message));
        Ok(match self.format {
            Format::Json => Output::json(&record),
            Format::Text => Output::bytes(text::element(&record, Look::of(&io::stdout()))).with_notes(notes),
        })
    }
}
