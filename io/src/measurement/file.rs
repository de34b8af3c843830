//! From the text of a measurement file to a measurement.

use std::{ops::Range, path::Path, sync::Arc};

use nalgebra::Point3;
use touchref_core::{Noise, Probe, parameters::nearest};

use super::{Measurement, NOT_MEASURED, Origin, PlacementSource, TouchRecord, TouchSource};
use crate::{
    Input, InputError, Units,
    log::LogSource,
    parameter,
    source::Source,
    tree,
    walk::{Field, Table},
};

const TOP_KEYS: &[&str] = &["units", "fixture", "probe", "touches", "touch", "log", "placement"];
const PROBE_KEYS: &[&str] = &["tip_radius", "sigma"];
const PLACEMENT_KEYS: &[&str] = &["name", "touches", "touch", "log"];
const TOUCH_KEYS: &[&str] = &["surface", "at", "id", "sigma", "approach", "covariance"];

/// Reads a measurement from its text; a touch table it names is looked for in `folder`.
pub(super) fn read(source: Source, folder: &Path) -> Result<Measurement, InputError> {
    let tree = tree::parse(&source)?;
    let root = Table::root(&source, &tree)?;
    root.only(TOP_KEYS)?;
    let units = read_units(&root.require("units", &format!("one of {}", Units::names()))?)?;
    let fixture_field = root.require("fixture", "a table [fixture] with `kind` and its parameters")?;
    let fixture = fixture_field.table()?;
    let kind = fixture.require("kind", "the name of a fixture; `touchref list fixtures` tells them")?;
    let mut places = Vec::new();
    let parameters = parameter::from_table(&fixture, Some("kind"), "", &mut places)?;
    let probe = root.get("probe").map_or(Ok(Probe::default()), |field| read_probe(&field))?;
    let (touches, surfaces) = read_touches(&source, &root, folder)?;
    let (kind_name, kind) = (kind.text()?.to_owned(), kind.node.span.clone());
    let fixture = fixture_field.node.span.clone();
    let origin = Origin { source, fixture, kind, parameters: places, surfaces };
    Ok(Measurement { units, kind: kind_name, parameters, probe, touches, origin: Some(Arc::new(origin)) })
}

pub(crate) fn read_units(field: &Field<'_>) -> Result<Units, InputError> {
    let name = field.text()?;
    Units::from_name(name).ok_or_else(|| {
        let known = Units::ALL.map(Units::name);
        let lower = name.to_lowercase();
        let near = match lower.get(..3) {
            Some("mil") => Some("mm"),
            Some("mic") => Some("um"),
            _ => nearest(name, known.into_iter()),
        };
        field.wrong(&format!("\"{name}\""), &format!("one of {}", Units::names())).with_nearest(near)
    })
}

fn read_probe(field: &Field<'_>) -> Result<Probe, InputError> {
    let table = field.table()?;
    table.only(PROBE_KEYS)?;
    let mut probe = Probe::default();
    if let Some(field) = table.get("tip_radius") {
        (probe.tip_radius, probe.tip_radius_u) = field.uncertain()?;
        if probe.tip_radius < 0.0 {
            return Err(field.wrong(&probe.tip_radius.to_string(), "a length, 0 or more"));
        }
    }
    if let Some(field) = table.get("sigma") {
        probe.sigma = Some(field.number_where(|sigma| sigma > 0.0, "a length > 0")?);
    }
    Ok(probe)
}

/// Of the surface of each touch that is listed.
type Places = Vec<Range<usize>>;

/// The touches of a measurement, and their places by placement, where there are many.
fn read_touches(
    source: &Source,
    root: &Table<'_>,
    folder: &Path,
) -> Result<(TouchSource, Vec<Places>), InputError> {
    const EXPECTED: &str = "a list of placements, [[placement]]";
    let (touches, surfaces) = read_list_or_table(source, root, folder)?;
    let Some(placements) = root.get("placement") else { return Ok((touches, vec![surfaces])) };
    if touches != TouchSource::Absent {
        return Err(InputError::new(
            "invalid-input",
            "touches are given twice: of one placement (`touch`, `touches`) and of many (`[[placement]]`)",
        )
        .with_help("move the former under a [[placement]] of their own, or remove them")
        .with_key("placement")
        .at(source.place(placements.node.span.clone())));
    }
    let (mut read, mut places) = (Vec::<PlacementSource>::new(), Vec::new());
    for field in placements.list(EXPECTED)? {
        let table = field.table()?;
        table.only(PLACEMENT_KEYS)?;
        let (touches, surfaces) = read_list_or_table(source, &table, folder)?;
        if matches!(&touches, TouchSource::Absent) || touches == TouchSource::Listed(Vec::new()) {
            return Err(
                table.missing("touch", "touches of the placement: [[placement.touch]], or a table `touches`")
            );
        }
        let name = table.get("name");
        let text = name.as_ref().map(Field::text).transpose()?;
        if let (Some(field), Some(text)) = (name, text)
            && read.iter().any(|other| other.name.as_deref() == Some(text))
        {
            return Err(field.wrong(&format!("\"{text}\" again"), "a name that no other placement has"));
        }
        read.push(PlacementSource { name: text.map(str::to_owned), touches });
        places.push(surfaces);
    }
    if read.is_empty() {
        return Err(placements.wrong("empty", EXPECTED));
    }
    Ok((TouchSource::Placed(read), places))
}

/// The touches of one placement, in the file itself, or in a table or a log that it names.
fn read_list_or_table(
    source: &Source,
    root: &Table<'_>,
    folder: &Path,
) -> Result<(TouchSource, Places), InputError> {
    let told = [
        ("touches", "as a table (`touches`)"),
        ("touch", "as a list (`[[touch]]`)"),
        ("log", "as a log (`[log]`)"),
    ];
    let mut given = told.iter().filter_map(|(key, told)| Some((root.get(key)?, *told)));
    let Some((field, first)) = given.next() else { return Ok((TouchSource::Absent, Vec::new())) };
    if let Some((_, second)) = given.next() {
        return Err(InputError::new(
            "invalid-input",
            format!("the touches are given twice: {first} and {second}"),
        )
        .with_help("remove one of the two")
        .with_key(field.path.clone())
        .at(field.place()));
    }
    if root.get("touches").is_some() {
        // In a file `-` is a name like any other: standard input is for the command line.
        return Ok((TouchSource::Table(Input::File(folder.join(field.text()?))), Vec::new()));
    }
    if root.get("log").is_some() {
        return Ok((TouchSource::Log(Box::new(LogSource::read(&field, folder)?)), Vec::new()));
    }
    let mut records = Vec::new();
    let mut surfaces = Vec::new();
    for field in field.list("a list of touches, [[touch]]")? {
        let (record, surface) = read_touch(source, &field.table()?, &field.node.span)?;
        records.push(record);
        surfaces.push(surface);
    }
    Ok((TouchSource::Listed(records), surfaces))
}

/// Reads a single touch.
pub(super) fn read_line(source: &Source) -> Result<TouchRecord, InputError> {
    let tree = tree::parse(source)?;
    read_touch(source, &Table::root(source, &tree)?, &tree.span).map(|(record, _)| record)
}

fn read_touch(
    source: &Source,
    table: &Table<'_>,
    span: &Range<usize>,
) -> Result<(TouchRecord, Range<usize>), InputError> {
    table.only(TOUCH_KEYS)?;
    let surface = table.require("surface", "the name of a surface of the fixture")?;
    let at = table.require("at", "the tip centre [x, y, z]")?;
    if at.text().is_ok_and(|text| text == NOT_MEASURED) {
        return Err(InputError::new("invalid-input", format!("`{}` is not filled in yet", at.path))
            .with_help("write the tip centre that the probe read there: at = [x, y, z]")
            .with_key(at.path.clone())
            .labelled("still to be measured")
            .at(source.place(at.node.span.clone())));
    }
    let at = at.vector()?;
    let noise = match (table.get("sigma"), table.get("covariance")) {
        (None, None) => Noise::OfProbe,
        (Some(sigma), None) => Noise::Sigma(sigma.number_where(|sigma| sigma > 0.0, "a length > 0")?),
        (None, Some(covariance)) => Noise::Covariance(covariance.covariance()?),
        (Some(_), Some(covariance)) => {
            return Err(covariance.wrong("given beside `sigma`", "one of the two"));
        }
    };
    let record = TouchRecord {
        surface: surface.text()?.to_owned(),
        label_found: false,
        at: Point3::from(at),
        noise,
        approach: table.get("approach").map(|field| field.direction()).transpose()?,
        id: table.get("id").map(|field| field.text().map(str::to_owned)).transpose()?,
        placement: None,
        line: Some(source.place(span.clone()).line),
    };
    Ok((record, surface.node.span.clone()))
}

#[cfg(test)]
mod tests {
    use touchref_core::Value;

    use super::*;

    const FULL: &str = r#"
units = "um"
[fixture]
kind = "k"
radius = { value = 15, u = 0.002 }
radii = [1, 2.5, 3]
bore = true
side = "front"
[probe]
tip_radius = { value = 1.5, u = 0.001 }
[[touch]]
surface = "a"
at = [1, 2, 3]
sigma = 0.5
approach = [0, 0, -1e-200]
[[touch]]
surface = "b"
at = [1, 2, 3]
covariance = [[1, 0.5, 0], [0.5, 1, 0], [0, 0, 1]]
id = "second"
"#;

    #[test]
    fn every_key_is_read() {
        let measurement = Measurement::from_text("m.toml", FULL, Path::new("")).unwrap();
        assert_eq!((measurement.units, measurement.kind.as_str()), (Units::Micrometre, "k"));
        let expected = touchref_core::Parameters::new()
            .with("radius", Value::Number { value: 15.0, u: 0.002 })
            .with("radii", [1.0, 2.5, 3.0])
            .with("bore", true)
            .with("side", "front");
        assert_eq!(measurement.parameters(), &expected);
        assert_eq!((measurement.probe.tip_radius, measurement.probe.tip_radius_u), (1.5, 0.001));
        let TouchSource::Listed(touches) = &measurement.touches else { panic!("the touches are listed") };
        assert_eq!((touches[0].noise, touches[0].line), (Noise::Sigma(0.5), Some(11)));
        assert_eq!(touches[0].approach.map(|direction| direction.z), Some(-1.0));
        assert!(
            matches!(touches[1].noise, Noise::Covariance(_)) && touches[1].id.as_deref() == Some("second")
        );
    }

    #[test]
    fn placements_are_read() {
        let text = r#"
units = "mm"
fixture.kind = "k"
[[placement]]
name = "north"
touches = "north.csv"
[[placement]]
[[placement.touch]]
surface = "a"
at = [1, 2, 3]
"#;
        let measurement = Measurement::from_text("m.toml", text, Path::new("folder")).unwrap();
        let TouchSource::Placed(placements) = &measurement.touches else { panic!("there are placements") };
        assert_eq!(placements[0].name.as_deref(), Some("north"));
        assert_eq!(placements[0].touches, TouchSource::Table(Input::File("folder/north.csv".into())));
        let TouchSource::Listed(touches) = &placements[1].touches else { panic!("the touches are listed") };
        assert_eq!((touches.len(), placements[1].name.as_deref()), (1, None));
        let json = r#"{"units": "mm", "fixture": {"kind": "k"}, "placement": [{"name": "north", "touches":
            "north.csv"}, {"touch": [{"surface": "a", "at": [1, 2, 3]}]}]}"#;
        let json = Measurement::from_text("m.json", json, Path::new("folder")).unwrap();
        let TouchSource::Placed(same) = &json.touches else { panic!("there are placements") };
        assert_eq!(same[0], placements[0]);
    }

    #[test]
    fn what_is_wrong_with_placements_has_a_place() {
        const START: &str = "units = \"mm\"\nfixture.kind = \"k\"\n";
        const TOUCH: &str = "touch = [{ surface = \"a\", at = [1, 2, 3] }]\n";
        let table = [
            (format!("{TOUCH}[[placement]]\n{TOUCH}"), "given twice", (4, 1), "placement"),
            (
                format!("[[placement]]\n{TOUCH}touches = \"t.csv\""),
                "given twice",
                (5, 11),
                "placement[0].touches",
            ),
            (format!("[[placement]]\n{TOUCH}nam = \"n\""), "`nam` is not known", (5, 1), "placement[0].nam"),
            (
                "[[placement]]\nname = \"n\"".to_owned(),
                "`placement[0].touch` is missing",
                (3, 1),
                "placement[0].touch",
            ),
            (
                "[[placement]]\ntouch = []".to_owned(),
                "`placement[0].touch` is missing",
                (3, 1),
                "placement[0].touch",
            ),
            ("placement = []".to_owned(), "`placement` is empty", (3, 13), "placement"),
            (
                format!("[[placement]]\nname = \"n\"\n{TOUCH}[[placement]]\nname = \"n\"\n{TOUCH}"),
                "`placement[1].name` is \"n\" again",
                (7, 8),
                "placement[1].name",
            ),
        ];
        for (text, message, (line, column), key) in table {
            let error =
                Measurement::from_text("m.toml", &format!("{START}{text}"), Path::new("")).unwrap_err();
            assert!(error.to_string().contains(message), "{error}");
            let place = error.place().unwrap();
            assert_eq!((place.line, place.column, error.key()), (line, Some(column), Some(key)), "{error}");
        }
    }

    #[test]
    fn a_table_is_looked_for_beside_the_file() {
        let text = "units = \"m\"\ntouches = \"-\"\nfixture.kind = \"k\"";
        let measurement = Measurement::from_text("m.toml", text, Path::new("folder")).unwrap();
        assert_eq!(measurement.touches, TouchSource::Table(Input::File("folder/-".into())));
    }
}
