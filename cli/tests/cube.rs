//! `cube` as a user types it: surfaces whose names begin with a sign, and what is told of wrong ones.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use common::Folder;
use serde_json::Value;

/// The example that comes with the project.
fn example() -> String {
    common::example("cube.toml")
}

/// The example without its touches.
fn without_touches() -> String {
    example().split("[[touch]]").next().unwrap().to_owned()
}

/// Origin and quaternion that the example was simulated with, from its own comment.
fn truth() -> Vec<f64> {
    let line = example().lines().find_map(|line| line.split_once("qw = ").map(|(_, text)| text.to_owned()));
    line.unwrap().split(',').map(|number| number.parse().unwrap()).collect()
}

/// A frame near the truth.
fn assert_located((status, result): (i32, Value)) {
    /// mm and halves of radians: the noise is 0.005 mm on an edge of 50 mm.
    const TOLERANCE: [f64; 2] = [0.05, 0.001];
    assert_eq!(status, 0, "{result}");
    let numbers = |key: &str| -> Vec<f64> {
        result["frame"][key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let got = [numbers("origin"), numbers("quaternion_xyzw")].concat();
    for (index, (got, want)) in got.iter().zip(truth()).enumerate() {
        assert!((got - want).abs() < TOLERANCE[usize::from(index > 2)], "{got} {want}: {result}");
    }
}

#[test]
fn the_example_is_located() {
    let folder = Folder::new().with("m.toml", example());
    assert_located(folder.json(&["locate", "m.toml"], b""));
}

/// Names that begin with a sign are names, whatever the delimiter, and quoted as spreadsheets do.
#[test]
fn tables_whose_lines_begin_with_a_sign_are_read() {
    let folder = Folder::new().with("m.toml", without_touches());
    let frame = truth().iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    // All six faces, in the fixture's order: `-x`, `-y` and `-z` too.
    let args = [
        "simulate",
        "m.toml",
        "--frame",
        &frame,
        "--layout",
        "random",
        "--touches-per-surface",
        "3,2,4,3,3,1",
    ];
    let output = folder.run(&args, b"");
    let table = String::from_utf8(output.stdout).unwrap();
    for face in ["+x", "-x", "+y", "-y", "+z", "-z"] {
        assert!(table.lines().any(|line| line.starts_with(&format!("{face},"))), "{face}: {table}");
    }
    let quoted = table
        .lines()
        .map(|line| {
            if line.starts_with(['+', '-']) {
                format!("\"{}\"{}\n", &line[..2], &line[2..])
            } else {
                format!("{line}\n")
            }
        })
        .collect::<String>();
    let semicolons = table.replace(',', ";").replace('.', ",");
    for table in [&table, &quoted, &semicolons, &table.replace(',', "\t"), &table.replace(',', " , ")] {
        assert_located(folder.json(&["locate", "m.toml", "--touches", "-"], table.as_bytes()));
    }
}

#[test]
fn wrong_parameters_and_names_are_told() {
    let table = [
        ("edge = 50.0", "edge = 0", "invalid-input", "fixture.edge", ""),
        ("edge = 50.0", "edge = -50.0", "invalid-input", "fixture.edge", ""),
        ("edge = 50.0", "edge = inf", "invalid-input", "fixture.edge", ""),
        ("edge = 50.0", "edge = { value = 50.0, u = -1 }", "invalid-input", "fixture.edge.u", ""),
        ("edge = 50.0", "edges = 50.0", "unknown-key", "fixture.edges", "edge"),
        ("edge = 50.0", "", "missing-key", "fixture.edge", ""),
        ("edge = 50.0", "edge = 50.0\nradius = 1", "unknown-key", "fixture.radius", ""),
        ("\"+x\"", "\"x\"", "unknown-surface", "touch[3].surface", "+x"),
        ("\"+x\"", "\"-X\"", "unknown-surface", "touch[3].surface", "-x"),
        ("\"cube\"", "\"cub\"", "unknown-fixture", "fixture.kind", "cube"),
    ];
    for (part, replacement, code, key, nearest) in table {
        assert!(example().contains(part), "{part}");
        let folder = Folder::new().with("m.toml", example().replacen(part, replacement, 1));
        let (status, result) = folder.json(&["locate", "m.toml"], b"");
        let text = |key: &str| result["error"][key].as_str().unwrap_or("").to_owned();
        let told = (status, text("code"), text("key"), text("nearest"));
        assert_eq!(told, (2, code.to_owned(), key.to_owned(), nearest.to_owned()), "{replacement}: {result}");
    }
}

#[test]
fn a_left_handed_corner_is_wrong_input_and_helped() {
    let swapped = example().replace("\"+x\"", "\"?\"").replace("\"+y\"", "\"+x\"").replace("\"?\"", "\"+y\"");
    let folder = Folder::new().with("m.toml", swapped);
    let output = folder.run(&["locate", "m.toml"], b"");
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("left-handed") && told.contains("exchange the labels"), "{told}");
}

#[test]
fn too_few_touches_are_told_by_the_faces_that_lack_them() {
    let keep = example().replace("\"+y\"", "\"+x\"");
    let folder = Folder::new().with("m.toml", keep);
    let (status, result) = folder.json(&["locate", "m.toml"], b"");
    assert_eq!((status, result["error"]["code"].as_str()), (2, Some("too-few-touches")), "{result}");
    assert!(result["error"]["message"].as_str().unwrap().contains("`+y` has 0 of 1 touches"), "{result}");
}
