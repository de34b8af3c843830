//! `export --to qif` as a user types it. The structure is held against tables taken from the public schema of QIF 3.0, and
//! the numbers against each other: a document must tell by itself what was measured. `tests/oracle/qif_schema.py` validates by the schema
//! itself.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
};

use common::{Folder, example, number, paper};
use roxmltree::{Document, Node};
use serde_json::Value;

const NAMESPACE: &str = "http://qifstandards.org/xsd/qif3";

/// An element, and how often it stands at least and at most.
type Rule = (&'static str, usize, usize);

/// Which elements an element has, in this order. Elements that are not here have none.
const RULES: &[(&str, &[Rule])] = &[
    (
        "QIFDocument",
        &[
            ("QPId", 1, 1),
            ("Header", 0, 1),
            ("SoftwareDefinitions", 0, 1),
            ("AlgorithmDefinitions", 0, 1),
            ("FileUnits", 0, 1),
            ("CoordinateSystems", 0, 1),
            ("Features", 0, 1),
            ("Results", 0, 1),
        ],
    ),
    ("Header", &[("Application", 0, 1), ("Description", 0, 1)]),
    ("Application", &[("Name", 1, 1)]),
    ("SoftwareDefinitions", &[("Software", 1, MANY)]),
    ("Software", &[("VendorName", 1, 1), ("ApplicationName", 1, 1), ("Version", 0, 1)]),
    ("AlgorithmDefinitions", &[("Algorithm", 1, MANY)]),
    ("Algorithm", &[("SoftwareId", 1, 1), ("Name", 1, 1), ("Description", 0, 1)]),
    ("FileUnits", &[("PrimaryUnits", 1, 1)]),
    ("PrimaryUnits", &[("AngularUnit", 0, 1), ("LinearUnit", 0, 1)]),
    ("AngularUnit", UNIT),
    ("LinearUnit", UNIT),
    ("UnitConversion", &[("Factor", 1, 1)]),
    ("CoordinateSystems", &[("CoordinateSystemDefinitions", 1, 1), ("CommonCoordinateSystemId", 0, 1)]),
    ("CoordinateSystemDefinitions", &[("CoordinateSystem", 1, MANY)]),
    ("CoordinateSystem", &[("Name", 0, 1), ("NominalTransform", 0, 1)]),
    ("NominalTransform", &[("Rotation", 0, 1), ("Origin", 0, 1)]),
    ("Rotation", &[("XDirection", 1, 1), ("YDirection", 1, 1), ("ZDirection", 1, 1)]),
    ("Features", &[("FeatureDefinitions", 0, 1), ("FeatureNominals", 0, 1), ("FeatureItems", 0, 1)]),
    ("CylinderFeatureDefinition", &[("InternalExternal", 1, 1), ("Diameter", 1, 1)]),
    ("SphereFeatureDefinition", &[("InternalExternal", 1, 1), ("Diameter", 1, 1)]),
    ("ConeFeatureDefinition", &[("InternalExternal", 1, 1), ("Diameter", 1, 1), ("HalfAngle", 1, 1)]),
    (
        "PlaneFeatureNominal",
        &[("Name", 0, 1), ("FeatureDefinitionId", 1, 1), ("Location", 1, 1), ("Normal", 1, 1)],
    ),
    ("SphereFeatureNominal", &[("Name", 0, 1), ("FeatureDefinitionId", 1, 1), ("Location", 1, 1)]),
    ("CylinderFeatureNominal", &[("Name", 0, 1), ("FeatureDefinitionId", 1, 1), ("Axis", 1, 1)]),
    ("ConeFeatureNominal", &[("Name", 0, 1), ("FeatureDefinitionId", 1, 1), ("Axis", 1, 1)]),
    ("Axis", &[("AxisPoint", 1, 1), ("Direction", 1, 1)]),
    ("PlaneFeatureItem", ITEM),
    ("CylinderFeatureItem", ITEM),
    ("SphereFeatureItem", ITEM),
    ("ConeFeatureItem", ITEM),
    ("DeterminationMode", &[("Checked", 1, 1)]),
    ("Checked", &[("CheckDetails", 0, 1)]),
    ("CheckDetails", &[("Measured", 1, 1)]),
    ("Results", &[("MeasurementResultsSet", 1, 1)]),
    ("MeasurementResultsSet", &[("MeasurementResults", 1, MANY)]),
    (
        "MeasurementResults",
        &[
            ("Attributes", 0, 1),
            ("ThisResultsInstanceQPId", 0, 1),
            ("MeasuredFeatures", 0, 1),
            ("MeasuredPointSets", 0, 1),
            ("ActualTransforms", 0, 1),
            ("CoordinateSystemActualTransformAssociations", 0, 1),
            ("InspectionStatus", 1, 1),
        ],
    ),
    ("PlaneFeatureMeasurement", &measured([("Location", 0, 1), ("Normal", 0, 1)])),
    ("CylinderFeatureMeasurement", &measured([("Axis", 0, 1), ("Diameter", 0, 1)])),
    ("SphereFeatureMeasurement", &measured([("Location", 0, 1), ("Diameter", 0, 1)])),
    ("ConeFeatureMeasurement", &measured([("Axis", 0, 1), ("HalfAngle", 0, 1)])),
    ("PointList", &[("WholePointSetId", 1, MANY)]),
    ("SubstituteFeatureAlgorithm", &[("SubstituteFeatureAlgorithmId", 1, 1)]),
    ("MeasuredPointSets", &[("MeasuredPointSet", 1, MANY)]),
    (
        "MeasuredPointSet",
        &[
            ("Attributes", 0, 1),
            ("CoordinateSystemId", 0, 1),
            ("Points", 1, 1),
            ("Normals", 0, 1),
            ("Compensated", 1, 1),
            ("ProbeRadius", 0, 1),
            ("Deviations", 0, 1),
        ],
    ),
    ("ActualTransforms", &[("Transform", 1, MANY)]),
    ("Transform", &[("Rotation", 0, 1), ("Origin", 0, 1), ("Attributes", 0, 1), ("Name", 0, 1)]),
    (
        "CoordinateSystemActualTransformAssociations",
        &[("CoordinateSystemActualTransformAssociation", 1, MANY)],
    ),
    (
        "CoordinateSystemActualTransformAssociation",
        &[("ActualTransformId", 1, 1), ("CoordinateSystemId", 1, 1)],
    ),
    ("InspectionStatus", &[("OtherInspectionStatus", 1, 1)]),
    ("AttributeUser", &[("UserDataXML", 1, 1)]),
];
const MANY: usize = usize::MAX;
const UNIT: &[Rule] = &[("SIUnitName", 0, 1), ("UnitName", 1, 1), ("UnitConversion", 0, 1)];
const ITEM: &[Rule] = &[
    ("FeatureNominalId", 1, 1),
    ("FeatureName", 1, 1),
    ("CoordinateSystemId", 0, 1),
    ("DeterminationMode", 1, 1),
];

const fn measured(geometry: [Rule; 2]) -> [Rule; 7] {
    [
        ("FeatureItemId", 0, 1),
        ("FeatureName", 0, 1),
        ("ActualTransformId", 0, 1),
        ("PointList", 0, 1),
        ("SubstituteFeatureAlgorithm", 0, 1),
        geometry[0],
        geometry[1],
    ]
}

/// Lists of which the members are one of several elements: what these are called.
const LISTS: &[(&str, &[&str])] = &[
    ("FeatureDefinitions", &["FeatureDefinition"]),
    ("FeatureNominals", &["FeatureNominal"]),
    ("FeatureItems", &["FeatureItem"]),
    ("MeasuredFeatures", &["FeatureMeasurement"]),
    (
        "Attributes",
        &["AttributeStr", "AttributeD1", "AttributeD3", "AttributeI1", "AttributeBool", "AttributeUser"],
    ),
];

/// To which elements an element refers.
const REFERENCES: &[(&str, &str)] = &[
    ("SoftwareId", "Software"),
    ("CommonCoordinateSystemId", "CoordinateSystem"),
    ("CoordinateSystemId", "CoordinateSystem"),
    ("FeatureDefinitionId", "FeatureDefinition"),
    ("FeatureNominalId", "FeatureNominal"),
    ("FeatureItemId", "FeatureItem"),
    ("ActualTransformId", "Transform"),
    ("WholePointSetId", "MeasuredPointSet"),
    ("SubstituteFeatureAlgorithmId", "Algorithm"),
];

fn name<'a>(node: Node<'a, '_>) -> &'a str {
    node.tag_name().name()
}

fn elements<'a>(document: &'a Document<'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    document.descendants().filter(|node| node.is_element() && node.tag_name().namespace() == Some(NAMESPACE))
}

fn children<'a>(node: Node<'a, 'a>) -> Vec<Node<'a, 'a>> {
    node.children().filter(Node::is_element).collect()
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    children(node).into_iter().find(|child| child.tag_name().name() == name)
}

fn text<'a>(node: Node<'a, 'a>, name: &str) -> &'a str {
    child(node, name).and_then(|child| child.text()).unwrap_or_else(|| panic!("no {name}"))
}

fn numbers(text: &str) -> Vec<f64> {
    text.split(' ').map(|number| number.parse().unwrap()).collect()
}

fn vector(text: &str) -> [f64; 3] {
    numbers(text).try_into().unwrap()
}

/// The element of that id.
fn of_id<'a>(document: &'a Document<'a>, id: &str) -> Node<'a, 'a> {
    elements(document).find(|node| node.attribute("id") == Some(id)).unwrap_or_else(|| panic!("no id {id}"))
}

/// Element order and cardinality, counts, ids and references.
fn assert_structure(document: &Document<'_>) {
    let root = document.root_element();
    assert_eq!((name(root), root.tag_name().namespace()), ("QIFDocument", Some(NAMESPACE)));
    assert_eq!(root.attribute("versionQIF"), Some("3.0.0"));
    let ids: Vec<u32> =
        elements(document).filter_map(|node| node.attribute("id")).map(|id| id.parse().unwrap()).collect();
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "ids are unique");
    assert!(!ids.contains(&0));
    assert_eq!(root.attribute("idMax"), Some(ids.iter().max().unwrap().to_string().as_str()));
    for node in elements(document) {
        let of = children(node);
        if let Some(count) = node.attribute("n") {
            assert_eq!(count, of.len().to_string(), "{}", name(node));
            assert_ne!(count, "0", "{}", name(node));
        }
        if let Some((_, members)) = LISTS.iter().find(|(list, _)| *list == name(node)) {
            let is_one = |child: &Node<'_, '_>| members.iter().any(|member| name(*child).ends_with(member));
            assert!(of.iter().all(is_one) && node.attribute("n").is_some(), "{}", name(node));
        } else if name(node) == "UserDataXML" {
            assert!(of.iter().all(|own| own.tag_name().namespace() != Some(NAMESPACE)));
        } else {
            assert_order(node, &of);
        }
        if let Some((_, of_kind)) = REFERENCES.iter().find(|(reference, _)| *reference == name(node)) {
            let referred = of_id(document, node.text().unwrap());
            assert!(name(referred).ends_with(of_kind), "{} refers to {}", name(node), name(referred));
        } else {
            assert!(!name(node).ends_with("Id") || name(node).ends_with("QPId"), "{} is checked", name(node));
        }
    }
}

fn assert_order(node: Node<'_, '_>, of: &[Node<'_, '_>]) {
    let rule = RULES.iter().find(|(element, _)| *element == name(node)).map_or(&[][..], |(_, rule)| rule);
    let mut left = of;
    for (child, least, most) in rule {
        let count = left.iter().take_while(|node| name(**node) == *child).count();
        assert!((*least..=*most).contains(&count), "{} has {count} of {child}", name(node));
        left = &left[count..];
    }
    assert!(left.is_empty(), "{} has {} where it may not", name(node), name(left[0]));
}

type Vector = [f64; 3];

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn rejected(a: Vector, along: Vector) -> Vector {
    let part = dot(a, along);
    minus(a, [along[0] * part, along[1] * part, along[2] * part])
}

/// Signed distance of a point from a measured feature, from what the document alone says.
fn distance(document: &Document<'_>, feature: Node<'_, '_>, at: Vector) -> f64 {
    let nominal = of_id(document, text(of_id(document, text(feature, "FeatureItemId")), "FeatureNominalId"));
    let definition = of_id(document, text(nominal, "FeatureDefinitionId"));
    let size = |name: &str| {
        let told = child(feature, name).or_else(|| child(definition, name));
        told.unwrap().text().unwrap().parse::<f64>().unwrap()
    };
    let side = match child(definition, "InternalExternal").and_then(|side| side.text()) {
        Some("INTERNAL") => -1.0,
        _ => 1.0,
    };
    let axis = || {
        let axis = child(feature, "Axis").unwrap();
        (vector(text(axis, "AxisPoint")), vector(text(axis, "Direction")))
    };
    match name(feature) {
        "PlaneFeatureMeasurement" => {
            dot(minus(at, vector(text(feature, "Location"))), vector(text(feature, "Normal")))
        }
        "SphereFeatureMeasurement" => {
            let off = minus(at, vector(text(feature, "Location")));
            side * (dot(off, off).sqrt() - 0.5 * size("Diameter"))
        }
        "CylinderFeatureMeasurement" => {
            let (point, along) = axis();
            let off = rejected(minus(at, point), along);
            side * (dot(off, off).sqrt() - 0.5 * size("Diameter"))
        }
        "ConeFeatureMeasurement" => {
            let (apex, along) = axis();
            let half_angle = size("HalfAngle").to_radians();
            let (off, height) = (rejected(minus(at, apex), along), dot(minus(at, apex), along));
            side * (dot(off, off).sqrt() * half_angle.cos() - height * half_angle.sin())
        }
        other => panic!("{other}"),
    }
}

/// The document of a result; it is whole, and its points have their deviations from its features.
fn exported(folder: &Folder, located: &Value) -> String {
    /// Rounding of sums and a square root of coordinates below 1000.
    const ROUNDING: f64 = 1e-9;
    /// Rounding of a rotation that became a quaternion and a rotation again.
    const ROTATION: f64 = 1e-14;
    let json = located.to_string();
    let output = folder.run(&["export", "-", "--to", "qif"], json.as_bytes());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty());
    let exported = String::from_utf8(output.stdout).unwrap();
    let document = Document::parse(&exported).unwrap();
    assert_structure(&document);

    let transform = elements(&document).find(|node| name(*node) == "Transform").unwrap();
    let rotation = child(transform, "Rotation").unwrap();
    let frame = |key: &str| serde_json::from_value::<Vector>(located["frame"][key].clone()).unwrap();
    for (element, key) in [("XDirection", "x_axis"), ("YDirection", "y_axis"), ("ZDirection", "z_axis")] {
        let off = minus(vector(text(rotation, element)), frame(key));
        // The quaternion is what counts; the axes printed beside it round otherwise.
        assert!(dot(off, off).sqrt() < ROTATION, "{element}: {off:?}");
    }
    assert_eq!(serde_json::json!(vector(text(transform, "Origin"))), located["frame"]["origin"]);

    let mut told = 0;
    for set in elements(&document).filter(|node| name(*node) == "MeasuredPointSet") {
        let points: Vec<Vector> =
            numbers(text(set, "Points")).chunks(3).map(|point| point.try_into().unwrap()).collect();
        let normals: Vec<Vector> =
            numbers(text(set, "Normals")).chunks(3).map(|normal| normal.try_into().unwrap()).collect();
        let deviations = numbers(text(set, "Deviations"));
        assert_eq!(set.attribute("count"), Some(points.len().to_string().as_str()));
        assert_eq!((normals.len(), deviations.len()), (points.len(), points.len()));
        let radius = child(set, "ProbeRadius").map_or(0.0, |radius| radius.text().unwrap().parse().unwrap());
        assert_eq!(text(set, "Compensated"), if radius > 0.0 { "false" } else { "true" });
        let feature = feature_of(&document, set, located, points[0]);
        for ((at, normal), deviation) in points.iter().zip(&normals).zip(&deviations) {
            let off = distance(&document, feature, *at) - radius - deviation;
            assert!(off.abs() < ROUNDING, "{}: {off}", name(feature));
            // Compensated along its normal a point is as far from the surface as its deviation.
            let surface = minus(*at, normal.map(|v| v * radius));
            assert!((distance(&document, feature, surface) - deviation).abs() < ROUNDING);
            let touch =
                located["touches"].as_array().unwrap().iter().find(|t| t["at"] == serde_json::json!(at));
            assert_eq!(touch.unwrap()["residual"], *deviation);
            told += 1;
        }
    }
    assert_eq!(told, located["touches"].as_array().unwrap().len());
    exported
}

/// The measured feature of a point set: the one that refers to it, or of the surface of its first touch.
fn feature_of<'a>(
    document: &'a Document<'a>,
    set: Node<'_, '_>,
    located: &Value,
    first: Vector,
) -> Node<'a, 'a> {
    let features = || elements(document).filter(|node| name(*node).ends_with("FeatureMeasurement"));
    let refers = |feature: &Node<'a, 'a>| {
        child(*feature, "PointList")
            .is_some_and(|list| text(list, "WholePointSetId") == set.attribute("id").unwrap())
    };
    let touches = located["touches"].as_array().unwrap();
    let touch = touches.iter().find(|touch| touch["at"] == serde_json::json!(first)).unwrap();
    let named = |feature: &Node<'a, 'a>| text(*feature, "FeatureName") == touch["surface"];
    let feature = features().find(refers).or_else(|| features().find(named)).unwrap();
    assert_eq!(text(feature, "FeatureName"), touch["surface"]);
    feature
}

fn located(folder: &Folder, args: &[&str]) -> Value {
    let (status, located) = folder.json(&[&["locate"], args].concat(), b"");
    assert_eq!(status, 0, "{args:?}: {located}");
    located
}

/// A seat, a bore and a face: with each kind of surface that the others do not have.
const SEAT: &str = r#"
units = "mm"
[fixture]
kind = "composite"
surface = [
    { name = "seat", type = "cone", apex = [0, 0, -30], axis = [0, 0, 1], half_angle_deg = 40, bore = true },
    { name = "pin", type = "cylinder", point = [60, 0, 0], axis = [0, 0, 1], radius = { value = 5, u = 0.01 }, from = 0, to = 20 },
    { name = "top", type = "plane", point = [30, 0, 0], normal = [0, 0, 1], within = 80 },
]
[probe]
tip_radius = { value = 1.5, u = 0.001 }
sigma = 0.005
"#;

#[test]
fn every_example_is_exported() {
    let examples =
        ["bore-and-faces", "cube", "nederbragt-ravani", "three-sphere", "tooling-balls", "v-block"];
    let folder = examples.iter().fold(Folder::new(), |folder, name| {
        let file = format!("{name}.toml");
        folder.with(&file, example(&file))
    });
    for name in examples {
        exported(&folder, &located(&folder, &[&format!("{name}.toml")]));
    }
    let folder = folder.with("seat.toml", SEAT);
    let args =
        ["simulate", "seat.toml", "--seed", "3", "--frame", "10,-20,30,0.1,0.2,0.3,0.9", "-o", "seat.csv"];
    let random = ["--layout", "random", "--touches-per-surface", "8,6,5"];
    let simulated = folder.run(&[&args[..], &random].concat(), b"");
    assert_eq!(simulated.status.code(), Some(0), "{}", String::from_utf8_lossy(&simulated.stderr));
    let located = located(&folder, &["seat.toml", "--touches", "seat.csv"]);
    let exported = exported(&folder, &located);
    let document = Document::parse(&exported).unwrap();
    // What was an unknown is measured; what was known is not.
    let measured = |kind: &str, size: &str| {
        let feature = elements(&document).find(|node| name(*node) == format!("{kind}FeatureMeasurement"));
        child(feature.unwrap(), size).map(|size| size.attribute("combinedUncertainty").unwrap().to_owned())
    };
    let adjusted = located["adjustments"].as_array().unwrap();
    let radius = adjusted.iter().find(|one| one["name"] == "pin.radius").unwrap();
    let u: f64 = measured("Cylinder", "Diameter").unwrap().parse().unwrap();
    assert!((u / (2.0 * number(&radius["u"])) - 1.0).abs() < 1e-6, "{u} {radius}");
    assert_eq!(measured("Cone", "HalfAngle"), None);
}

/// Standard uncertainties of places and directions, from the 6x6 covariance by its definition: the fixture moved a little.
#[test]
fn uncertainties_are_those_of_the_covariance() {
    let folder = Folder::new().with("m.toml", example("v-block.toml"));
    let located = located(&folder, &["m.toml"]);
    let exported = exported(&folder, &located);
    let document = Document::parse(&exported).unwrap();
    let covariance = |i: usize, j: usize| number(&located["covariance"]["matrix"][i][j]);
    let origin: Vector = serde_json::from_value(located["frame"]["origin"].clone()).unwrap();
    let cross = |a: Vector, b: Vector| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    // What moves by each of the six motions.
    let spread = |moved: [Vector; 6], k: usize| {
        let sum = (0..6).flat_map(|i| (0..6).map(move |j| (i, j)));
        sum.map(|(i, j)| moved[i][k] * covariance(i, j) * moved[j][k]).sum::<f64>().sqrt()
    };
    let unit = |k: usize| std::array::from_fn::<f64, 3, _>(|i| f64::from(u8::from(i == k)));
    let mut compared = 0;
    for feature in elements(&document).filter(|node| name(*node).ends_with("FeatureMeasurement")) {
        let place = vector(text(feature, "Location"));
        let arm = minus(place, origin);
        let moved = std::array::from_fn(|i| if i < 3 { unit(i) } else { cross(unit(i - 3), arm) });
        let normal = vector(text(feature, "Normal"));
        let turned = std::array::from_fn(|i| if i < 3 { [0.0; 3] } else { cross(unit(i - 3), normal) });
        for (element, of) in [("Location", moved), ("Normal", turned)] {
            for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
                let told =
                    child(feature, element).unwrap().attribute(format!("{axis}CombinedUncertainty").as_str());
                let (told, expected) = (told.unwrap().parse::<f64>().unwrap(), spread(of, k));
                assert!((told - expected).abs() < 1e-9 * expected, "{element} {axis}: {told} {expected}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 18);
    // And the covariance itself, with all that it needs to be read.
    let own = document.descendants().find(|node| name(*node) == "covariance").unwrap();
    let attributes: BTreeMap<&str, &str> = own.attributes().map(|one| (one.name(), one.value())).collect();
    let expected =
        [("about", "origin"), ("axes", "parent"), ("order", "x y z rx ry rz"), ("units", "mm radian")];
    assert_eq!(attributes, BTreeMap::from(expected));
    for (i, row) in children(own).into_iter().enumerate() {
        for (j, told) in numbers(row.text().unwrap()).into_iter().enumerate() {
            assert_eq!(located["covariance"]["matrix"][i][j], told);
        }
    }
}

/// Where a size that is uncertain takes part in where a surface is, a result does not tell how sure that is.
#[test]
fn what_a_result_does_not_tell_is_left_out() {
    let folder = Folder::new().with("m.toml", example("three-sphere.toml"));
    let exported = exported(&folder, &located(&folder, &["m.toml"]));
    let document = Document::parse(&exported).unwrap();
    let uncertain = |ball: &str| {
        let feature = elements(&document)
            .find(|node| name(*node) == "SphereFeatureMeasurement" && text(*node, "FeatureName") == ball);
        child(feature.unwrap(), "Location").unwrap().attribute("xCombinedUncertainty").is_some()
    };
    // `a` is the frame's origin; where the others are depends on their distances.
    assert_eq!(["a", "b", "c"].map(uncertain), [true, false, false]);

    let folder = Folder::new().with("m.toml", paper().replace("sigma = 0.00005", ""));
    let mut unsure = located(&folder, &["m.toml"]);
    unsure["covariance"] = Value::Null;
    let told = self::exported(&folder, &unsure);
    assert!(!told.contains("CombinedUncertainty=") && !told.contains("covariance xmlns"), "{told}");
}

#[test]
fn units_are_told() {
    for (unit, metres) in [("um", "0.000001"), ("mm", "0.001"), ("m", "1"), ("in", "0.0254")] {
        let folder = Folder::new().with("m.toml", paper().replace("\"mm\"", &format!("\"{unit}\"")));
        let exported = exported(&folder, &located(&folder, &["m.toml"]));
        let document = Document::parse(&exported).unwrap();
        let linear = elements(&document).find(|node| name(*node) == "LinearUnit").unwrap();
        assert_eq!((text(linear, "SIUnitName"), text(linear, "UnitName")), ("meter", unit));
        assert_eq!(text(child(linear, "UnitConversion").unwrap(), "Factor"), metres);
    }
}

/// A touch that the frame does not rest on is in no set that a feature refers to.
#[test]
fn excluded_touches_are_apart() {
    let bad =
        example("cube.toml").replacen("[426.5496, -151.5672, 87.7929]", "[426.5496, -151.5672, 88.7929]", 1);
    let folder = Folder::new().with("m.toml", bad);
    let exported = exported(&folder, &located(&folder, &["m.toml", "--solver", "robust"]));
    let document = Document::parse(&exported).unwrap();
    let referred: BTreeSet<&str> = elements(&document)
        .filter(|node| name(*node) == "WholePointSetId")
        .map(|id| id.text().unwrap())
        .collect();
    let sets = elements(&document).filter(|node| name(*node) == "MeasuredPointSet");
    let apart: Vec<Node<'_, '_>> =
        sets.filter(|set| !referred.contains(set.attribute("id").unwrap())).collect();
    let [set] = apart.as_slice() else { panic!("{} sets apart", apart.len()) };
    assert_eq!(text(*set, "Points"), "426.5496 -151.5672 88.7929");
    let used = children(child(*set, "Attributes").unwrap());
    assert_eq!(used[0].attribute("name"), Some("touchref.touch[0].used"));
    assert_eq!(used[0].attribute("value"), Some("false"));
}

/// Whatever a touch is called, the document is well formed and tells it.
#[test]
fn hostile_names_are_escaped() {
    let hostile = "</Points>&lt;\"'><![CDATA[ ]]> é 😀 \t \n \r \u{1} \u{ffff} --> &#0; {{";
    let folder = Folder::new().with("m.toml", paper());
    let mut result = located(&folder, &["m.toml"]);
    result["touches"][0]["id"] = hostile.into();
    result["solver"] = hostile.into();
    result["warnings"] = serde_json::json!([{ "code": hostile, "message": hostile }]);
    let exported = exported(&folder, &result);
    let document = Document::parse(&exported).unwrap();
    let legal = hostile.replace(['\u{1}', '\u{ffff}'], "\u{fffd}");
    let attribute = |name: &str| {
        let told = elements(&document).find(|node| node.attribute("name") == Some(name));
        told.and_then(|told| told.attribute("value"))
    };
    assert_eq!(attribute("touchref.touch[0].id"), Some(legal.as_str()));
    assert_eq!(attribute("touchref.solver"), Some(legal.as_str()));
    assert_eq!(attribute(&format!("touchref.warning.{legal}")), Some(legal.as_str()));
    let algorithm = elements(&document).find(|node| name(*node) == "Algorithm").unwrap();
    assert_eq!(text(algorithm, "Name"), legal);
}

/// The same result gives the same bytes, however it comes; another one has other identifiers.
#[test]
fn identifiers_come_from_the_content() {
    let folder = Folder::new().with("m.toml", paper());
    let printed = folder.run(&["locate", "m.toml", "--format", "json"], b"").stdout;
    let folder = folder.with("r.json", &printed);
    let once = folder.run(&["export", "r.json", "--to", "qif"], b"").stdout;
    let again = folder.run(&["export", "-", "--to", "qif"], &printed).stdout;
    let written = folder.run(&["export", "r.json", "--to", "qif", "-o", "r.qif"], b"");
    assert!(written.status.success() && written.stdout.is_empty());
    assert!(!once.is_empty() && once == again && once == fs::read(folder.0.path().join("r.qif")).unwrap());
    let identifiers = |bytes: &[u8]| {
        let text = String::from_utf8(bytes.to_vec()).unwrap();
        let document = Document::parse(&text).unwrap();
        let all = elements(&document).filter(|node| name(*node).ends_with("QPId"));
        all.map(|node| node.text().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let moved = String::from_utf8(printed).unwrap().replace("\"x4\"", "\"x 4\"");
    let other = folder.run(&["export", "-", "--to", "qif"], moved.as_bytes()).stdout;
    let all = [identifiers(&once), identifiers(&other)].concat();
    assert_eq!((all.len(), all.iter().collect::<BTreeSet<_>>().len()), (4, 4), "{all:?}");
    for identifier in all {
        let parts: Vec<&str> = identifier.split('-').collect();
        assert_eq!(parts.iter().map(|part| part.len()).collect::<Vec<_>>(), [8, 4, 4, 4, 12], "{identifier}");
        // Version 5, and the variant of RFC 9562.
        assert!(parts[2].starts_with('5') && parts[3].starts_with(['8', '9', 'a', 'b']), "{identifier}");
    }
}

#[test]
fn what_cannot_be_exported_is_told() {
    let folder = Folder::new().with("m.toml", paper().replace("sigma = 0.00005", "sigma = 0.1"));
    let refusal = folder.run(&["locate", "m.toml", "--format", "json"], b"").stdout;
    let folder = folder.with("right.toml", paper());
    let right = folder.run(&["locate", "right.toml", "--format", "json"], b"").stdout;
    let right = String::from_utf8(right).unwrap();
    let older = {
        let mut result: Value = serde_json::from_str(&right).unwrap();
        result["touches"][3].as_object_mut().unwrap().remove("at").unwrap();
        result.to_string()
    };
    let surface = right.replace("\"plane\"", "\"plate\"");
    let unit = right.replace("\"units\": \"mm\"", "\"units\": \"cm\"");
    let cases: [(&str, &[u8], &str); 6] = [
        ("qif", &refusal, "a refusal, which has no frame"),
        ("qif", older.as_bytes(), "where its touches were"),
        ("qif", surface.as_bytes(), "`plate`"),
        ("qif", unit.as_bytes(), "unit cm"),
        ("qif", b"{}", "no result of `locate`"),
        ("qiv", right.as_bytes(), "tip: a similar value exists: 'qif'"),
    ];
    for (form, stdin, message) in cases {
        let output = folder.run(&["export", "-", "--to", form], stdin);
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{told}");
        assert!(told.contains(message), "{message}: {told}");
        assert!(told.contains("help: ") || form != "qif", "{told}");
    }
}
