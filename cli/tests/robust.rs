//! `--solver robust` as a user types it: a bad touch is told loudly, labels are found or told to be wrong.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{fs, path::Path};

use common::{Folder, TABLE, without_touches};

/// The cube that comes with the project, touched nine times.
fn cube() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/cube.toml");
    fs::read_to_string(path).unwrap()
}

/// The same with its first touch a millimetre too high.
fn with_a_bad_touch() -> String {
    let bad = cube().replacen(
        "at = [426.5496, -151.5672, 87.7929]",
        "id = \"chip\"\nat = [426.5496, -151.5672, 88.7929]",
        1,
    );
    assert_ne!(bad, cube());
    bad
}

#[test]
fn a_bad_touch_is_left_out_loudly() {
    let folder = Folder::new().with("m.toml", with_a_bad_touch());
    let (status, refused) = folder.json(&["locate", "m.toml"], b"");
    assert_eq!((status, refused["error"]["code"].as_str()), (1, Some("inconsistent")));

    let (status, result) = folder.json(&["locate", "m.toml", "--solver", "robust"], b"");
    assert_eq!(status, 0, "{result}");
    let touches = result["touches"].as_array().unwrap();
    let excluded: Vec<bool> =
        touches.iter().map(|touch| touch["excluded"].as_bool().unwrap_or(false)).collect();
    assert_eq!(excluded, [true, false, false, false, false, false, false, false, false]);
    assert!(touches[1].get("excluded").is_none(), "only for those that are");
    assert!(touches[0]["residual"].as_f64().unwrap() > 0.9);
    assert_eq!(result["degrees_of_freedom"], 2);
    assert!(result["rms"].as_f64().unwrap() < 0.02);
    let codes: Vec<&str> = result["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|warning| warning["code"].as_str().unwrap())
        .collect();
    assert!(codes.contains(&"touch-excluded"), "{codes:?}");

    let output = folder.run(&["locate", "m.toml", "--solver", "robust"], b"");
    let [text, notes] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(text.contains("A touch is left out as bad. Touch 0 `chip` lies"), "{text}");
    assert!(text.contains("8 of 9 touches, solver robust") && text.contains("left out\n"), "{text}");
    assert!(notes.contains("warning: touch 0 on `+z` is left out as bad"), "{notes}");
}

#[test]
fn suspects_are_listed() {
    // Seven touches, the fourth a tenth off.
    let table = TABLE.replace("3.5270,3.2000,3.1082", "3.6270,3.2000,3.1082");
    let folder = Folder::new().with("m.toml", without_touches()).with("t.csv", table);
    let args = ["locate", "m.toml", "--touches", "t.csv", "--solver", "robust"];
    let (status, refused) = folder.json(&args, b"");
    let error = &refused["error"];
    assert_eq!((status, error["code"].as_str()), (1, Some("inconsistent")), "{error}");
    assert!(error["message"].as_str().unwrap().contains("noticed, but never told"), "{error}");
    assert_eq!(error["touches"].as_array().unwrap().len(), 7);
    assert_eq!((&error["touches"][3]["id"], &error["touches"][3]["line"]), (&"x4".into(), &5.into()));
    // No one of them is the place of an error in the input.
    assert!(error.get("line").is_none(), "{error}");
}

#[test]
fn missing_labels_are_found() {
    // A question mark, an empty cell; all others as they are.
    let table = TABLE.replacen("cylinder,", "?,", 1).replacen("plane,", ",", 1);
    let toml = cube().replacen("surface = \"+z\"", "surface = \"?\"", 1);
    let folder = Folder::new().with("m.toml", without_touches()).with("t.csv", table).with("cube.toml", toml);
    for (args, open, surface) in [
        (&["locate", "m.toml", "--touches", "t.csv"][..], [0, 4], ["cylinder", "plane"]),
        (&["locate", "cube.toml"], [0, 0], ["+z", "+z"]),
    ] {
        let (status, refused) = folder.json(args, b"");
        let error = &refused["error"];
        assert_eq!((status, error["code"].as_str()), (2, Some("unknown-surface")), "{error}");
        assert!(error["help"].as_str().unwrap().contains("--solver robust"), "{error}");

        let (status, result) = folder.json(&[args, &["--solver", "robust"]].concat(), b"");
        assert_eq!(status, 0, "{result}");
        for (index, touch) in result["touches"].as_array().unwrap().iter().enumerate() {
            let found = open.contains(&index);
            assert_eq!(touch["label_found"].as_bool(), found.then_some(true), "{touch}");
        }
        for (index, surface) in open.into_iter().zip(surface) {
            assert_eq!(result["touches"][index]["surface"], surface);
        }
        let warnings = result["warnings"].as_array().unwrap();
        assert!(warnings.iter().any(|warning| warning["code"] == "label-found"), "{warnings:?}");
        let text =
            String::from_utf8(folder.run(&[args, &["--solver", "robust"]].concat(), b"").stdout).unwrap();
        assert!(text.contains("surface found"), "{text}");
    }
}

#[test]
fn labels_that_are_not_clear_are_refused() {
    let table: String =
        TABLE.lines().map(|line| line.replace("cylinder,", "?,").replace("plane,", "?,") + "\n").collect();
    // So much noise that several labellings fit.
    let folder = Folder::new().with("m.toml", without_touches()).with("t.csv", table);
    let args = ["locate", "m.toml", "--touches", "t.csv", "--solver", "robust", "--sigma", "0.1"];
    let (status, refused) = folder.json(&args, b"");
    let error = &refused["error"];
    assert_eq!((status, error["code"].as_str()), (1, Some("ambiguous")), "{error}");
    assert!(error["message"].as_str().unwrap().contains("labellings fit"), "{error}");
    assert_eq!(error["touches"].as_array().unwrap().len(), 7);
}
