//! QIF 3.0, results: ISO 23952:2020, by its public XML schema (qifstandards.org).
//!
//! The parent is the common coordinate system, in which a QIF document tells whatever was measured. The fixture's frame is
//! a second one: nominally the parent itself, actually where it was located, which an actual transform tells. So nominal
//! features are in fixture coordinates, and measured ones where the located frame puts them. A surface has no place of its
//! own in the model, so neither has a measured feature: what is measured of it is its size, where that was unknown.
//!
//! Touches are point sets, one a surface, of tip centres that are not compensated, with the tip's radius and the surface's
//! normals to compensate along; their deviations are the residuals. Touches that the frame does not rest on are sets of
//! their own, which no feature refers to.
//!
//! `CombinedUncertainty` is a standard uncertainty of a place or a direction of the located fixture, along each of the
//! parent's axes; it is left out where it would need what a result does not tell. The 6x6 covariance has no place in QIF: it
//! is an attribute of the transform. There are no characteristics, as nothing is judged against a tolerance.

use nalgebra::{Matrix3, Matrix6, Point3, Unit, Vector3};
use touchref_core::{Extent, Fixture, Frame, Shape, Surface};
use uuid::Uuid;

use super::{Exporter, xml::Element};
use crate::{
    InputError, SolutionRecord, Units,
    solution::{AdjustmentRecord, CovarianceRecord, ResidualRecord},
};

pub(super) const EXPORTER: Exporter =
    Exporter { name: "qif", summary: "QIF 3.0 results (ISO 23952:2020), an XML document", write };

const NAMESPACE: &str = "http://qifstandards.org/xsd/qif3";
/// Of what QIF has no element for.
const OWN_NAMESPACE: &str = "urn:touchref:qif:1";
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Name of the tip's radius among the adjustments.
const TIP_RADIUS: &str = "tip_radius";

/// What readers of the document need to know of it.
const DESCRIPTION: &str = "The frame of a reference fixture, located by probing. The common coordinate system is the parent, \
     in which the touches were made; the coordinate system of the fixture is nominally the same, and actually where the \
     actual transform puts it. Nominal features are in fixture coordinates; measured features are those of the located \
     fixture. Points are tip centres unless compensated; compensate against the given normals. Deviations are signed \
     distances from the located surfaces less the probe radius. Combined uncertainties are standard uncertainties (k = 1). \
     The covariance of the frame is an attribute of the actual transform. Nothing was judged against a tolerance.";

fn write(record: &SolutionRecord, fixture: &dyn Fixture) -> Result<Vec<u8>, InputError> {
    let wrong = |message: &str| {
        InputError::new("invalid-input", message).with_help(
            "locate again: a result of `touchref locate --format json` tells its touches and its unit",
        )
    };
    let units = Units::from_name(&record.units)
        .ok_or_else(|| wrong(&format!("the result has the unit {}", record.units)).with_key("units"))?;
    let frame = record
        .located_frame()
        .ok_or_else(|| wrong("the result's frame has no rotation").with_key("frame"))?;
    if record.touches.iter().any(|touch| touch.at.is_none()) {
        return Err(wrong("the result does not tell where its touches were").with_key("touches"));
    }
    let mut ids = Ids(0);
    let common = Common {
        record,
        units,
        frame,
        software: ids.next(),
        algorithm: ids.next(),
        parent: ids.next(),
        own: ids.next(),
        transform: ids.next(),
        results: ids.next(),
    };
    let mut features = Vec::new();
    for (index, surface) in fixture.surfaces().iter().enumerate() {
        if record.touches.iter().any(|touch| touch.surface == surface.name) {
            features.push(Feature::new(&common, fixture, index, &mut ids)?);
        }
    }
    let known =
        |touch: &&ResidualRecord| !features.iter().any(|feature| feature.surface.name == touch.surface);
    if let Some(touch) = record.touches.iter().find(known) {
        return Err(fixture.surface_index(&touch.surface).map_or_else(InputError::from, |_| {
            wrong("the fixture has surfaces that QIF has no feature for")
        }));
    }
    let document = common.document(&features, ids.0);
    document.document().map_err(|error| wrong(&format!("the document cannot be written: {error}")))
}

/// The ids given so far, from 1.
struct Ids(usize);

impl Ids {
    fn next(&mut self) -> usize {
        self.0 += 1;
        self.0
    }
}

/// What all parts of the document share.
struct Common<'a> {
    record: &'a SolutionRecord,
    units: Units,
    frame: Frame,
    software: usize,
    algorithm: usize,
    parent: usize,
    own: usize,
    transform: usize,
    results: usize,
}

/// A surface that was touched.
struct Feature<'a> {
    surface: &'a Surface,
    nominal: Geometry,
    /// In fixture coordinates, with the sizes as they were found.
    found: Geometry,
    /// The same surface, to see it from a touch.
    shape: Shape,
    /// Standard uncertainty of its size, where that was an unknown.
    size_u: Option<f64>,
    /// Whether the frame alone says where it is, and no size that is uncertain.
    placed_by_frame: bool,
    definition: usize,
    nominal_id: usize,
    item: usize,
    measurement: usize,
    /// Its touches on which the frame rests, and the others, each with the id of the set where there are any.
    sets: [(Option<usize>, Vec<&'a ResidualRecord>); 2],
}

/// What QIF tells of a surface.
#[derive(Debug, Clone, PartialEq)]
struct Geometry {
    /// How its elements' names begin.
    kind: &'static str,
    /// Of a plane, centre of a sphere, beginning of a cylinder, apex of a cone.
    point: Point3<f64>,
    /// Outward normal of a plane, axis of a cylinder or a cone.
    direction: Option<Unit<Vector3<f64>>>,
    /// Diameter, or half angle of a cone, degrees.
    size: Option<f64>,
    bore: bool,
}

impl Geometry {
    fn new(shape: &Shape, extent: Extent) -> Option<Self> {
        Some(match shape {
            Shape::Plane { point, normal } => {
                Self { kind: "Plane", point: *point, direction: Some(*normal), size: None, bore: false }
            }
            Shape::Cylinder { point, axis, radius, bore } => {
                // QIF's cylinders begin somewhere; this is where touches do.
                let from = if let Extent::Along { from, .. } = extent { from } else { 0.0 };
                let point = point + **axis * from;
                Self {
                    kind: "Cylinder",
                    point,
                    direction: Some(*axis),
                    size: Some(2.0 * radius),
                    bore: *bore,
                }
            }
            Shape::Sphere { center, radius, bore } => Self {
                kind: "Sphere",
                point: *center,
                direction: None,
                size: Some(2.0 * radius),
                bore: *bore,
            },
            Shape::Cone { apex, axis, half_angle, bore } => Self {
                kind: "Cone",
                point: *apex,
                direction: Some(*axis),
                size: Some(half_angle.to_degrees()),
                bore: *bore,
            },
            _ => return None,
        })
    }

    /// Name of one of its elements, as `PlaneFeatureNominal`.
    fn name(&self, aspect: &str) -> String {
        format!("{}Feature{aspect}", self.kind)
    }

    /// The definition's own elements.
    fn definition(&self) -> Vec<Element> {
        let side = || Element::text("InternalExternal", if self.bore { "INTERNAL" } else { "EXTERNAL" });
        match (self.kind, self.size) {
            (_, None) => Vec::new(),
            ("Cone", Some(half_angle)) => {
                vec![side(), Element::text("Diameter", 0), Element::text("HalfAngle", half_angle)]
            }
            (_, Some(diameter)) => vec![side(), Element::text("Diameter", diameter)],
        }
    }

    /// Where it is; `point` and `direction` make an element of each.
    fn place(
        &self,
        point: impl FnOnce(&'static str, &Point3<f64>) -> Element,
        direction: impl FnOnce(&'static str, &Vector3<f64>) -> Element,
    ) -> Vec<Element> {
        match &self.direction {
            None => vec![point("Location", &self.point)],
            Some(normal) if self.kind == "Plane" => {
                vec![point("Location", &self.point), direction("Normal", normal)]
            }
            Some(axis) => {
                let axis = [point("AxisPoint", &self.point), direction("Direction", axis)];
                vec![Element::of("Axis", axis)]
            }
        }
    }
}

impl<'a> Feature<'a> {
    fn new(
        common: &Common<'a>,
        fixture: &'a dyn Fixture,
        index: usize,
        ids: &mut Ids,
    ) -> Result<Self, InputError> {
        let surface = &fixture.surfaces()[index];
        let no_feature = || {
            let message = format!("surface `{}` is of a kind that QIF has no feature for", surface.name);
            InputError::new("invalid-input", message)
        };
        let geometry = |shape: &Shape| Geometry::new(shape, surface.extent).ok_or_else(no_feature);
        let adjusted = |name: &str| common.record.adjustments.iter().find(|one| one.name == name);
        let dimensions = fixture.dimensions();
        let found = |name: &str| adjusted(name).and_then(|one| Some((one.value?, one.u?)));
        let values: Vec<(f64, f64, bool)> = dimensions
            .iter()
            .map(|dimension| match found(&dimension.name) {
                Some((value, u)) => {
                    (value / dimension.quantity.scale(), u / dimension.quantity.scale(), true)
                }
                None => (dimension.value, dimension.u, false),
            })
            .collect();
        let with = |moved: Option<usize>| {
            let values: Vec<f64> = values
                .iter()
                .enumerate()
                .map(|(k, (value, u, _))| if moved == Some(k) { value + u } else { *value })
                .collect();
            fixture.shape_with(index, &values)
        };
        let shape = with(None);
        let here = geometry(&shape)?;
        let (mut variance, mut is_unknown, mut placed_by_frame) = (0.0, false, true);
        for (k, (_, u, unknown)) in values.iter().enumerate() {
            if *u == 0.0 {
                continue;
            }
            let there = geometry(&with(Some(k)))?;
            placed_by_frame &= (there.point, there.direction) == (here.point, here.direction);
            let change = there.size.zip(here.size).map_or(0.0, |(there, here)| there - here);
            variance += change * change;
            is_unknown |= change != 0.0 && *unknown;
        }
        let touched = common.record.touches.iter().filter(|touch| touch.surface == surface.name);
        let (others, used): (Vec<_>, Vec<_>) = touched.partition(|touch| touch.excluded);
        let [definition, nominal_id, item, measurement] = std::array::from_fn(|_| ids.next());
        let sets = [used, others].map(|touches| ((!touches.is_empty()).then(|| ids.next()), touches));
        Ok(Self {
            surface,
            nominal: geometry(&surface.shape)?,
            found: here,
            shape,
            size_u: is_unknown.then(|| variance.sqrt()),
            placed_by_frame,
            definition,
            nominal_id,
            item,
            measurement,
            sets,
        })
    }

    fn definition(&self) -> Element {
        Element::of(self.nominal.name("Definition"), self.nominal.definition()).with("id", self.definition)
    }

    fn nominal(&self) -> Element {
        let place = self.nominal.place(
            |name, point| Element::text(name, numbers(point.iter())),
            |name, direction| Element::text(name, numbers(direction.iter())),
        );
        let known = [
            Element::text("Name", &self.surface.name),
            Element::text("FeatureDefinitionId", self.definition),
        ];
        Element::of(self.nominal.name("Nominal"), known.into_iter().chain(place)).with("id", self.nominal_id)
    }

    fn item(&self, common: &Common<'_>) -> Element {
        let measured = Element::of("CheckDetails", [Element::of("Measured", [])]);
        let children = [
            Element::text("FeatureNominalId", self.nominal_id),
            Element::text("FeatureName", &self.surface.name),
            Element::text("CoordinateSystemId", common.own),
            Element::of("DeterminationMode", [Element::of("Checked", [measured])]),
        ];
        Element::of(self.nominal.name("Item"), children).with("id", self.item)
    }

    fn measurement(&self, common: &Common<'_>) -> Element {
        let mut children = vec![
            Element::text("FeatureItemId", self.item),
            Element::text("FeatureName", &self.surface.name),
            Element::text("ActualTransformId", common.transform),
        ];
        if let [(Some(set), _), _] = &self.sets {
            children.push(Element::list("PointList", [Element::text("WholePointSetId", set)]));
        }
        let algorithm = Element::text("SubstituteFeatureAlgorithmId", common.algorithm);
        children.push(Element::of("SubstituteFeatureAlgorithm", [algorithm]));
        let frame = &common.frame;
        let covariance = common.record.covariance.as_ref().filter(|_| self.placed_by_frame).map(matrix);
        let uncertain = |name, numbers_of: Vector3<f64>, spread: Option<Matrix3<f64>>| {
            let element = Element::text(name, numbers(numbers_of.iter()));
            spread.map_or(element.clone(), |spread| {
                let [x, y, z] = [0, 1, 2].map(|k| spread[(k, k)].max(0.0).sqrt());
                element
                    .with("xCombinedUncertainty", x)
                    .with("yCombinedUncertainty", y)
                    .with("zCombinedUncertainty", z)
            })
        };
        children.extend(self.found.place(
            |name, point| {
                let point = frame.to_parent(point);
                let arm = point - frame.origin;
                uncertain(name, point.coords, covariance.as_ref().map(|covariance| moved(covariance, &arm)))
            },
            |name, direction| {
                let direction = frame.rotation * direction;
                uncertain(
                    name,
                    direction,
                    covariance.as_ref().map(|covariance| turned(covariance, &direction)),
                )
            },
        ));
        if let (Some(size), Some(u)) = (self.found.size, self.size_u) {
            let name = if self.found.kind == "Cone" { "HalfAngle" } else { "Diameter" };
            // QIF has the two together; the estimate has no bias that is known.
            children.push(Element::text(name, size).with("combinedUncertainty", u).with("meanError", 0));
        }
        Element::of(self.found.name("Measurement"), children).with("id", self.measurement)
    }

    /// Its touches, used and left out.
    fn point_sets(&self, common: &Common<'_>) -> Vec<Element> {
        let sets = self.sets.iter().filter_map(|(id, touches)| Some(self.point_set(common, (*id)?, touches)));
        sets.collect()
    }

    fn point_set(&self, common: &Common<'_>, id: usize, touches: &[&ResidualRecord]) -> Element {
        let places: Vec<Point3<f64>> =
            touches.iter().filter_map(|touch| touch.at.map(Point3::from)).collect();
        let normals = places.iter().flat_map(|place| {
            let normal = self.shape.seen_from(&common.frame.to_fixture(place)).normal;
            <[f64; 3]>::from(common.frame.rotation * normal)
        });
        let mut children = vec![
            attributes(touches.iter().flat_map(|touch| of_touch(touch))),
            Element::text("CoordinateSystemId", common.parent),
            Element::text("Points", numbers(places.iter().flat_map(|place| place.iter()))),
            Element::text("Normals", numbers(normals.collect::<Vec<_>>().iter())),
        ];
        match common.tip_radius() {
            radius if radius > 0.0 => {
                children.push(Element::text("Compensated", false));
                children.push(Element::text("ProbeRadius", radius));
            }
            _ => children.push(Element::text("Compensated", true)),
        }
        if let Some(residuals) = touches.iter().map(|touch| touch.residual).collect::<Option<Vec<_>>>() {
            children.push(Element::text("Deviations", numbers(residuals.iter())));
        }
        Element::of("MeasuredPointSet", children).with("count", places.len()).with("id", id)
    }
}

impl Common<'_> {
    /// As found, where it was an unknown.
    fn tip_radius(&self) -> f64 {
        let adjusted = self.record.adjustments.iter().find(|one| one.name == TIP_RADIUS);
        adjusted.and_then(|one| one.value).unwrap_or(self.record.probe.tip_radius)
    }

    /// The same for the same result; `what` tells documents and their parts apart.
    fn uuid(&self, what: &str) -> Uuid {
        let namespace = Uuid::new_v5(&Uuid::NAMESPACE_OID, OWN_NAMESPACE.as_bytes());
        // Keys are strings and numbers are plain, so that writing to memory cannot fail.
        let json = serde_json::to_string(self.record).unwrap_or_default();
        Uuid::new_v5(&namespace, format!("{what} {VERSION}\n{json}").as_bytes())
    }

    fn document(&self, features: &[Feature<'_>], most: usize) -> Element {
        let parts = [
            Element::text("QPId", self.uuid("document")),
            Self::header(),
            self.software(),
            self.algorithm(),
            self.file_units(),
            self.coordinate_systems(),
            Element::of(
                "Features",
                [
                    Element::list("FeatureDefinitions", features.iter().map(Feature::definition)),
                    Element::list("FeatureNominals", features.iter().map(Feature::nominal)),
                    Element::list("FeatureItems", features.iter().map(|feature| feature.item(self))),
                ],
            ),
            Element::of("Results", [Element::list("MeasurementResultsSet", [self.results(features)])]),
        ];
        Element::of("QIFDocument", parts)
            .with("xmlns", NAMESPACE)
            .with("versionQIF", "3.0.0")
            .with("idMax", most)
    }

    fn header() -> Element {
        let application = Element::of("Application", [Element::text("Name", format!("touchref {VERSION}"))]);
        Element::of("Header", [application, Element::text("Description", DESCRIPTION)])
    }

    fn software(&self) -> Element {
        let software = [
            Element::text("VendorName", "touchref"),
            Element::text("ApplicationName", "touchref"),
            Element::text("Version", VERSION),
        ];
        Element::list("SoftwareDefinitions", [Element::of("Software", software).with("id", self.software)])
    }

    fn algorithm(&self) -> Element {
        let algorithm = [
            Element::text("SoftwareId", self.software),
            Element::text("Name", &self.record.solver),
            Element::text(
                "Description",
                "One frame of the whole fixture through all touches, its geometry known.",
            ),
        ];
        Element::list(
            "AlgorithmDefinitions",
            [Element::of("Algorithm", algorithm).with("id", self.algorithm)],
        )
    }

    fn file_units(&self) -> Element {
        let unit = |element, of_si, name, factor: &str| {
            let conversion = Element::of("UnitConversion", [Element::text("Factor", factor)]);
            Element::of(
                element,
                [Element::text("SIUnitName", of_si), Element::text("UnitName", name), conversion],
            )
        };
        // In decimals, not by the nearest number of the machine.
        let metres = match self.units {
            Units::Millimetre => "0.001",
            Units::Metre => "1",
            Units::Micrometre => "0.000001",
            Units::Inch => "0.0254",
        };
        let primary = [
            unit("AngularUnit", "radian", "degree", "0.0174532925199432957692"),
            unit("LinearUnit", "meter", self.units.name(), metres),
        ];
        Element::of("FileUnits", [Element::of("PrimaryUnits", primary)])
    }

    fn coordinate_systems(&self) -> Element {
        let system = |id: usize, name: &str| {
            let transform = Element::of("NominalTransform", transform(&Frame::identity()));
            Element::of("CoordinateSystem", [Element::text("Name", name), transform]).with("id", id)
        };
        let kind = &self.record.fixture.kind;
        let systems = [system(self.parent, "parent"), system(self.own, &format!("fixture {kind}"))];
        Element::of(
            "CoordinateSystems",
            [
                Element::list("CoordinateSystemDefinitions", systems),
                Element::text("CommonCoordinateSystemId", self.parent),
            ],
        )
    }

    fn results(&self, features: &[Feature<'_>]) -> Element {
        let association = [
            Element::text("ActualTransformId", self.transform),
            Element::text("CoordinateSystemId", self.own),
        ];
        let association = Element::of("CoordinateSystemActualTransformAssociation", association);
        let status = "located: the frame passed its checks; nothing was judged against a tolerance";
        let children = [
            attributes(self.summary()),
            Element::text("ThisResultsInstanceQPId", self.uuid("results")),
            Element::list("MeasuredFeatures", features.iter().map(|feature| feature.measurement(self))),
            Element::list("MeasuredPointSets", features.iter().flat_map(|feature| feature.point_sets(self))),
            Element::list("ActualTransforms", [self.actual_transform()]),
            Element::list("CoordinateSystemActualTransformAssociations", [association]),
            Element::of("InspectionStatus", [Element::text("OtherInspectionStatus", status)]),
        ];
        Element::of("MeasurementResults", children).with("id", self.results)
    }

    fn actual_transform(&self) -> Element {
        let covariance = self.record.covariance.as_ref().map(|covariance| {
            let row = |row: &[f64; 6]| Element::text("row", numbers(row.iter()));
            let matrix = Element::of("covariance", covariance.matrix.iter().map(row))
                .with("xmlns", OWN_NAMESPACE)
                .with("order", covariance.order.join(" "))
                .with("units", format!("{} radian", self.units))
                .with("axes", &covariance.axes)
                .with("about", &covariance.about);
            let user = Element::of("AttributeUser", [Element::of("UserDataXML", [matrix])])
                .with("name", "touchref.covariance")
                .with("nameUserAttribute", "touchref.covariance/1");
            attributes([user])
        });
        let name = Element::text("Name", "frame of the fixture");
        Element::of("Transform", transform(&self.frame).into_iter().chain(covariance).chain([name]))
            .with("id", self.transform)
    }

    /// What the result tells besides, and QIF has no element for.
    fn summary(&self) -> Vec<Element> {
        let record = self.record;
        let mut told = vec![string("schema", &record.schema), string("solver", &record.solver)];
        let numbers = [
            ("rms", record.rms),
            ("chi_square", record.chi_square),
            ("p_value", record.p_value),
            ("probe.sigma", record.probe.sigma),
            ("probe.tip_radius_u", Some(record.probe.tip_radius_u)),
            ("covariance.sigma", record.covariance.as_ref().and_then(|covariance| covariance.sigma)),
            ("trust.from_sigma", record.trust.from_sigma),
            ("trust.up_to_sigma", record.trust.up_to_sigma),
        ];
        told.extend(numbers.into_iter().filter_map(|(name, value)| Some(number(name, value?))));
        let degrees = attribute("AttributeI1", "degrees_of_freedom").with("value", record.degrees_of_freedom);
        told.push(degrees);
        for AdjustmentRecord { name, value, u, .. } in &record.adjustments {
            told.extend(value.map(|value| number(&format!("adjusted.{name}"), value)));
            told.extend(u.map(|u| number(&format!("adjusted.{name}_u"), u)));
        }
        if let Some(covariance) = &record.covariance {
            told.push(string("covariance.sigma_source", &covariance.sigma_source));
        }
        told.extend(record.free.iter().map(|motion| string("free", motion)));
        let warnings = record.warnings.iter();
        told.extend(warnings.map(|warning| string(&format!("warning.{}", warning.code), &warning.message)));
        told
    }
}

/// What a point set has no element for, of one of its touches.
fn of_touch(touch: &ResidualRecord) -> Vec<Element> {
    let name = |what: &str| format!("touch[{}].{what}", touch.index);
    let mut told = vec![attribute("AttributeBool", &name("used")).with("value", !touch.excluded)];
    told.extend(touch.id.as_ref().map(|id| string(&name("id"), id)));
    told.extend(touch.sigma.map(|sigma| number(&name("sigma"), sigma)));
    if let Some(approach) = &touch.approach {
        told.push(attribute("AttributeD3", &name("approach")).with("value", numbers(approach.iter())));
    }
    if let Some(rows) = &touch.covariance {
        told.push(string(&name("covariance"), &numbers(rows.iter().flatten())));
    }
    told
}

fn attributes(attributes: impl IntoIterator<Item = Element>) -> Element {
    Element::list("Attributes", attributes)
}

fn attribute(element: &'static str, name: &str) -> Element {
    Element::of(element, []).with("name", format!("touchref.{name}"))
}

fn string(name: &str, value: &str) -> Element {
    attribute("AttributeStr", name).with("value", value)
}

fn number(name: &str, value: f64) -> Element {
    attribute("AttributeD1", name).with("value", value)
}

/// Rotation and origin: of a point of the fixture the coordinates in the common coordinate system.
fn transform(frame: &Frame) -> Vec<Element> {
    let axis = |name, k| Element::text(name, numbers(frame.axis(k).iter()));
    let rotation = [axis("XDirection", 0), axis("YDirection", 1), axis("ZDirection", 2)];
    vec![Element::of("Rotation", rotation), Element::text("Origin", numbers(frame.origin.iter()))]
}

/// Numbers with the digits that round-trip, and no exponent: a decimal has none.
fn numbers<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> String {
    numbers.into_iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

fn matrix(covariance: &CovarianceRecord) -> Matrix6<f64> {
    Matrix6::from_fn(|row, column| covariance.matrix[row][column])
}

/// Covariance of a point of the fixture at the end of `arm` from its origin; all in the parent.
fn moved(covariance: &Matrix6<f64>, arm: &Vector3<f64>) -> Matrix3<f64> {
    let turn = -arm.cross_matrix();
    let block = |row, column| covariance.fixed_view::<3, 3>(row, column);
    block(0, 0) + turn * block(3, 0) + block(0, 3) * turn.transpose() + turn * block(3, 3) * turn.transpose()
}

/// Covariance of a direction of the fixture, in the parent.
fn turned(covariance: &Matrix6<f64>, direction: &Vector3<f64>) -> Matrix3<f64> {
    let turn = -direction.cross_matrix();
    turn * covariance.fixed_view::<3, 3>(3, 3) * turn.transpose()
}
