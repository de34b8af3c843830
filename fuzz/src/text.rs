//! What reads text: importers, measurements, tables, results, dialects, frames.

use std::{borrow::Cow, io::Cursor, path::Path, sync::LazyLock};

use miette::{GraphicalReportHandler, GraphicalTheme};
use nalgebra::Point3;
use touchref::{
    Dialect, DialectError, Fixture, Frame, Literal, ParameterKind, Problem, Registry, Touch, Units,
    io::{
        CalibrationRecord, ErrorRecord, FrameRecord, InputError, Measurement, SolutionRecord, TouchRecord,
        TouchSource, dialect as dialects,
        log::{self, Column, Columns, MachineLog, Position},
        read_frame,
        table::TableReader,
        write::{self, Row, TableWriter},
    },
};

/// All plugins.
pub(super) static REGISTRY: LazyLock<Registry> =
    LazyLock::new(|| touchref::registry().expect("the built-in plugins have names of their own"));

/// Text as a file may hold it; bytes that are none are replaced.
fn text(data: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(data)
}

/// A refusal can be told, to people and to programs; a place that it has lies in the text.
fn is_told(error: &InputError, text: &[u8]) {
    assert!(!error.to_string().is_empty() && !error.code().is_empty());
    if let Some(place) = error.place() {
        let lines = text.split(|byte| *byte == b'\n').count();
        assert!((1..=lines).contains(&place.line), "line {} of {lines}: {error}", place.line);
        assert!(place.offset + place.length <= text.len(), "{place:?}: {error}");
        assert!(place.column != Some(0), "{error}");
    }
    let mut shown = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::none());
    handler.render_report(&mut shown, error).expect("a refusal can be shown");
    serde_json::to_string(&ErrorRecord::from(error)).expect("a refusal is JSON");
}

/// The same, of an input that has a name.
fn is_told_of(error: &InputError, file: &str, text: &[u8]) {
    assert_eq!(error.file(), Some(file), "{error}");
    is_told(error, text);
}

fn is_finite(point: &Point3<f64>) -> bool {
    point.iter().all(|v| v.is_finite())
}

/// A log of a machine, by the importer of this name.
pub(super) fn log(format: &str, data: &[u8]) {
    const FILE: &str = "probe.log";
    let importer = log::find(format).expect("the format is known");
    let named = |names: [&str; 3]| names.map(|name| Column::Named(name.to_owned()));
    let numbered = [1, 2, 3].map(Column::Numbered);
    let columns = if importer.takes_columns() {
        let of_example = Columns {
            name: Some(Column::Named("Punkt".to_owned())),
            ..Columns::of(named(["X [mm]", "Y [mm]", "Z [mm]"]))
        };
        let normal = [4, 5, 6].map(Column::Numbered);
        let with_normals = Columns { normal: Some(normal), ..Columns::of(numbered.clone()) };
        vec![Some(of_example), Some(Columns::of(numbered)), Some(with_normals)]
    } else {
        vec![None]
    };
    let text = text(data);
    for columns in columns {
        let read = || MachineLog::from_text(importer, FILE, &text, columns.as_ref());
        let log = match read() {
            Ok(log) => log,
            Err(error) => {
                is_told_of(&error, FILE, text.as_bytes());
                continue;
            }
        };
        assert_eq!(read().as_ref(), Ok(&log), "the same text is the same log");
        let lines = text.matches('\n').count() + 1;
        let mut before = 1;
        for point in log.points() {
            assert!((before..=lines).contains(&point.line), "line {} of {lines}", point.line);
            before = point.line;
            match &point.position {
                Position::At(at) => assert!(is_finite(at), "{at}"),
                Position::Unusable(fault) | Position::Empty(fault) => assert!(!fault.message().is_empty()),
            }
            assert!(point.approach.is_none_or(|direction| (direction.norm() - 1.0).abs() < 1e-9));
        }
    }
}

/// Whether all touches stand in the measurement itself: no other file is to be read.
fn is_listed(source: &TouchSource) -> bool {
    match source {
        TouchSource::Absent | TouchSource::Listed(_) => true,
        TouchSource::Placed(placements) => placements.iter().all(|one| is_listed(&one.touches)),
        _ => false,
    }
}

/// A measurement and its fixture, where they are ones; both checked.
fn measured(file: &str, text: &str) -> Option<(Measurement, Box<dyn Fixture>)> {
    let read = || Measurement::from_text(file, text, Path::new(""));
    let measurement = match read() {
        Ok(measurement) => measurement,
        Err(error) => {
            is_told_of(&error, file, text.as_bytes());
            return None;
        }
    };
    assert_eq!(read().as_ref(), Ok(&measurement), "the same text is the same measurement");
    match measurement.fixture(&REGISTRY) {
        Ok(fixture) => Some((measurement, fixture)),
        Err(error) => {
            is_told_of(&error, file, text.as_bytes());
            None
        }
    }
}

fn are_sound(touches: &[Touch], fixture: &dyn Fixture) {
    for touch in touches {
        assert!(touch.surface < fixture.surfaces().len() && is_finite(&touch.at), "{touch:?}");
        assert!(touch.approach.is_none_or(|direction| (direction.norm() - 1.0).abs() < 1e-9), "{touch:?}");
    }
}

/// A measurement file; what is written of it reads back the same.
pub(super) fn measurement(file: &str, data: &[u8]) {
    let text = text(data);
    let Some((measurement, fixture)) = measured(file, &text) else { return };
    if !is_listed(&measurement.touches) {
        return;
    }
    match measurement.touches(&*fixture) {
        Ok(touches) => {
            are_sound(&touches.touches, &*fixture);
            if let Err(error) = Problem::new(&*fixture, &touches.touches, measurement.probe) {
                is_told(&error.into(), text.as_bytes());
            }
        }
        Err(error) => is_told(&error, text.as_bytes()),
    }
    if let TouchSource::Listed(records) = &measurement.touches {
        let Measurement { kind, units, probe, .. } = &measurement;
        let written = write::measurement(kind, measurement.parameters(), *units, probe, records);
        let again = Measurement::from_text("again.toml", &written, Path::new(""))
            .unwrap_or_else(|error| panic!("{error}\n{written}"));
        assert_eq!((&again.kind, again.units, again.probe), (kind, *units, *probe), "{written}");
        assert_eq!(again.parameters(), measurement.parameters(), "{written}");
        let unplaced = |source: &TouchSource| match source {
            TouchSource::Listed(records) => {
                records.iter().map(|record| TouchRecord { line: None, ..record.clone() }).collect()
            }
            _ => Vec::new(),
        };
        assert_eq!(unplaced(&again.touches), unplaced(&measurement.touches), "{written}");
    }
}

/// Many placements in a measurement file, or the JSON of what they told.
pub(super) fn calibration(data: &[u8]) {
    const FILE: &str = "calibration.toml";
    let text = text(data);
    if text.starts_with('{') {
        if let Ok(record) = serde_json::from_str::<CalibrationRecord>(&text) {
            let written = serde_json::to_string(&record).expect("a record is JSON");
            assert_eq!(serde_json::from_str::<CalibrationRecord>(&written).ok(), Some(record), "{written}");
        }
        return;
    }
    let Some((measurement, fixture)) = measured(FILE, &text) else { return };
    if !is_listed(&measurement.touches) {
        return;
    }
    match measurement.placements(&*fixture) {
        Ok(placements) => {
            assert!(!placements.is_empty());
            for placement in placements {
                are_sound(&placement.touches.touches, &*fixture);
                assert_eq!(placement.touches.records.len(), placement.touches.touches.len());
            }
        }
        Err(error) => is_told(&error, text.as_bytes()),
    }
}

/// A touch table; what is written of it reads back the same.
pub(super) fn touch_table(data: &[u8]) {
    const FILE: &str = "touches.csv";
    const SURFACES: [&str; 3] = ["cylinder", "plane", "+x"];
    let read = |bytes: &[u8]| -> Result<Vec<TouchRecord>, InputError> {
        TableReader::new(Box::new(Cursor::new(bytes.to_vec())), FILE, &SURFACES)?.collect()
    };
    let records = match read(data) {
        Ok(records) => records,
        Err(error) => return is_told_of(&error, FILE, data),
    };
    assert_eq!(read(data).as_ref(), Ok(&records), "the same bytes are the same table");
    let mut written = Vec::new();
    let columns = write::Columns { id: true, placement: false };
    let mut table = TableWriter::new(&mut written, &[], columns).expect("memory can be written");
    for record in &records {
        assert!(is_finite(&record.at) && record.line.is_some(), "{record:?}");
        assert!(!record.is_labelled() || SURFACES.contains(&record.surface.as_str()), "{record:?}");
        let row = Row { surface: &record.surface, at: record.at, id: record.id.as_deref(), placement: None };
        table.write(&row).expect("memory can be written");
    }
    table.finish().expect("memory can be written");
    let again = read(&written).unwrap_or_else(|error| panic!("{error}"));
    // A byte order mark that begins a line is none of its text.
    let id = |record: &TouchRecord| {
        let id = record.id.as_deref().unwrap_or_default();
        id.trim_start_matches('\u{feff}').trim().to_owned()
    };
    let told = |records: &[TouchRecord]| -> Vec<(String, Point3<f64>, String)> {
        records.iter().map(|record| (record.surface.clone(), record.at, id(record))).collect()
    };
    assert_eq!(told(&again), told(&records), "{}", String::from_utf8_lossy(&written));
}

/// A result file read back.
pub(super) fn result(data: &[u8]) {
    const FILE: &str = "result.json";
    let text = text(data);
    let record = match SolutionRecord::from_text(FILE, &text) {
        Ok(record) => record,
        Err(error) => return is_told_of(&error, FILE, text.as_bytes()),
    };
    let written = serde_json::to_string(&record).expect("a record is JSON");
    assert_eq!(SolutionRecord::from_text(FILE, &written).as_ref(), Ok(&record), "{written}");
    assert!(record.located_frame().is_some_and(|frame| frame.is_sound()), "{:?}", record.frame);
    match record.fixture.build(&REGISTRY) {
        Ok(fixture) => {
            if let Ok(Some(touches)) = record.used_touches(&*fixture) {
                // What is no measurement is refused there.
                let _ = Problem::new(&*fixture, &touches, record.probe.into());
            }
        }
        Err(error) => is_told(&error, text.as_bytes()),
    }
}

/// Every dialect, those with words to choose in each of them.
static DIALECTS: LazyLock<Vec<(String, Box<dyn Dialect>)>> = LazyLock::new(|| {
    let calls = REGISTRY.dialects().iter().flat_map(|plugin| {
        let needed = plugin.parameters.iter().filter(|spec| spec.default.is_none());
        needed.fold(vec![plugin.name.to_owned()], |calls, spec| {
            let ParameterKind::Choice(words) = spec.kind else { panic!("{} needs a value", spec.name) };
            calls.iter().flat_map(|call| words.iter().map(move |word| format!("{call}:{word}"))).collect()
        })
    });
    let found = calls.map(|call| {
        let dialect = dialects::find(&REGISTRY, &call).expect("the dialect is known");
        (call, dialect)
    });
    found.collect()
});

/// A literal, read in every dialect; what is read can be printed, and that is the same frame.
pub(super) fn dialect(data: &[u8]) {
    let text = text(data);
    for (name, dialect) in DIALECTS.iter() {
        let Some(read) = dialect.parse(&text).filter(Frame::is_sound) else { continue };
        // In the unit of the dialect itself nothing is converted.
        let units = dialect.convention().units.unwrap_or(Units::Millimetre);
        let literal = match Literal::new(name, &**dialect, &read, units, &[]) {
            Ok(literal) => literal,
            // What has no words for some frames says so.
            Err(DialectError::Lossy { lost, .. }) if lost.omission.is_some() => continue,
            Err(error) => panic!("{error}: read from {text}"),
        };
        let again = dialect.parse(&literal.text).expect("a literal was read back");
        Literal::new(name, &**dialect, &again, units, &[]).unwrap_or_else(|error| panic!("{error}"));
    }
}

/// The argument FRAME, as seven numbers.
pub(super) fn frame(data: &[u8]) {
    let text = text(data);
    // What may be the path of a file elsewhere is not opened.
    if text.contains(['/', '\\']) {
        return;
    }
    match read_frame(&text) {
        Ok(frame) => {
            assert!(frame.is_sound(), "{text}: {frame:?}");
            let FrameRecord { origin, quaternion_xyzw, .. } = FrameRecord::from(&frame);
            let numbers = origin.iter().chain(&quaternion_xyzw).map(f64::to_string);
            let again =
                read_frame(&numbers.collect::<Vec<_>>().join(",")).expect("seven numbers are a frame");
            assert_eq!(again.origin, frame.origin);
            assert!((again.rotation.matrix() - frame.rotation.matrix()).abs().max() < 1e-14, "{text}");
        }
        Err(error) => is_told(&error, &[]),
    }
}
