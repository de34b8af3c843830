//! From the text of a measurement file to a measurement.

use std::{ops::Range, path::Path, sync::Arc};

use nalgebra::Point3;
use touchref_core::{Noise, Parameters, Probe, parameters::nearest};

use super::{Measurement, Origin, TouchRecord, TouchSource};
use crate::{
    Input, InputError, Units, parameter,
    source::Source,
    tree,
    walk::{Field, Table},
};

const TOP_KEYS: &[&str] = &["units", "fixture", "probe", "touches", "touch"];
const PROBE_KEYS: &[&str] = &["tip_radius", "sigma"];
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
    let mut parameters = Parameters::new();
    let mut places = Vec::new();
    for (entry, field) in fixture.fields("kind") {
        parameters.set(&entry.key, parameter::from_field(&field)?);
        places.push((entry.key.clone(), entry.key_span.clone(), field.node.span.clone()));
    }
    let probe = root.get("probe").map_or(Ok(Probe::default()), |field| read_probe(&field))?;
    let (touches, surfaces) = read_touches(&source, &root, folder)?;
    let (kind_name, kind) = (kind.text()?.to_owned(), kind.node.span.clone());
    let fixture = fixture_field.node.span.clone();
    let origin = Origin { source, fixture, kind, parameters: places, surfaces };
    Ok(Measurement { units, kind: kind_name, parameters, probe, touches, origin: Some(Arc::new(origin)) })
}

fn read_units(field: &Field<'_>) -> Result<Units, InputError> {
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

fn read_touches(
    source: &Source,
    root: &Table<'_>,
    folder: &Path,
) -> Result<(TouchSource, Vec<Range<usize>>), InputError> {
    let (table, list) = (root.get("touches"), root.get("touch"));
    match (table, list) {
        (None, None) => Ok((TouchSource::Absent, Vec::new())),
        (Some(table), None) => {
            // In a file `-` is a name like any other: standard input is for the command line.
            Ok((TouchSource::Table(Input::File(folder.join(table.text()?))), Vec::new()))
        }
        (None, Some(list)) => {
            let mut records = Vec::new();
            let mut surfaces = Vec::new();
            for field in list.list("a list of touches, [[touch]]")? {
                let (record, surface) = read_touch(source, &field)?;
                records.push(record);
                surfaces.push(surface);
            }
            Ok((TouchSource::Listed(records), surfaces))
        }
        (Some(table), Some(_)) => Err(InputError::new(
            "invalid-input",
            "the touches are given twice: as a table (`touches`) and as a list (`[[touch]]`)",
        )
        .with_help("remove one of the two")
        .with_key("touches")
        .at(source.place(table.node.span.clone()))),
    }
}

fn read_touch(source: &Source, field: &Field<'_>) -> Result<(TouchRecord, Range<usize>), InputError> {
    let table = field.table()?;
    table.only(TOUCH_KEYS)?;
    let surface = table.require("surface", "the name of a surface of the fixture")?;
    let at = table.require("at", "the tip centre [x, y, z]")?.vector()?;
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
        line: Some(source.place(field.node.span.clone()).line),
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
        let expected = Parameters::new()
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
    fn a_table_is_looked_for_beside_the_file() {
        let text = "units = \"m\"\ntouches = \"-\"\nfixture.kind = \"k\"";
        let measurement = Measurement::from_text("m.toml", text, Path::new("folder")).unwrap();
        assert_eq!(measurement.touches, TouchSource::Table(Input::File("folder/-".into())));
    }
}
