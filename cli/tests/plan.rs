//! `plan` as a user types it: what it prints and writes, and what is told of wrong arguments.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::fs;

use common::{Folder, number, paper, without_touches};
use serde_json::Value;

const CUBE: &str =
    "units = \"mm\"\n[fixture]\nkind = \"cube\"\nedge = 50.0\n[probe]\ntip_radius = 1.5\nsigma = 0.005\n";
const NEAR: &str = "10,20,30,0,0,1,1";

fn folder() -> Folder {
    Folder::new().with("m.toml", CUBE)
}

fn triple(value: &Value) -> [f64; 3] {
    std::array::from_fn(|k| number(&value[k]))
}

#[test]
fn a_plan_tells_touches_uncertainties_and_other_layouts() {
    let folder = folder();
    let args = [
        "plan",
        "m.toml",
        "--touches-per-surface",
        "3,0,2,0,2,0",
        "--at",
        "0,0,500",
        "--redundancy",
        "0",
        "--near",
        NEAR,
    ];
    let (status, result) = folder.json(&args, b"");
    assert_eq!((status, result["schema"].as_str()), (0, Some("touchref.plan/1")), "{result}");
    let touches = result["touches"].as_array().unwrap();
    assert_eq!(touches.len(), 7);
    for touch in touches {
        let (contact, tip, approach) =
            (triple(&touch["contact"]), triple(&touch["tip"]), triple(&touch["approach"]));
        for k in 0..3 {
            assert!((contact[k] - tip[k] - 1.5 * approach[k]).abs() < 1e-9, "{touch}");
        }
        // A quarter turn about Z, and moved.
        let [x, y, z] = triple(&touch["parent"]["tip"]);
        assert!(
            (x - 10.0 + tip[1]).abs() + (y - 20.0 - tip[0]).abs() + (z - 30.0 - tip[2]).abs() < 1e-9,
            "{touch}"
        );
    }
    assert_eq!(result["points"].as_array().unwrap().len(), 1);
    let u = number(&result["points"][0]["u"]);
    assert!(
        (u - number(&result["worst"])).abs() < 1e-15
            && (u / 0.005 - number(&result["points"][0]["u_over_sigma"])).abs() < 1e-9
    );
    assert!(
        number(&result["naive_over_plan"]) > 1.0 && number(&result["random_median_over_plan"]) > 2.0,
        "{result}"
    );
    let text = String::from_utf8(folder.run(&args, b"").stdout).unwrap();
    for part in [
        "Planned. 7 touches",
        "tip centre",
        "approach",
        "redundancy",
        "Expected in the parent",
        "median of random",
        "one frame stands",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(text.is_ascii(), "{text}");
}

/// What is written is refused until it is filled in, and then located.
#[test]
fn a_written_measurement_is_filled_in() {
    let folder = folder();
    let args = [
        "plan",
        "m.toml",
        "--touches-per-surface",
        "3,0,2,0,2,0",
        "--redundancy",
        "0",
        "-o",
        "p.toml",
        "--table",
        "p.csv",
        "--near",
        NEAR,
    ];
    let (status, result) = folder.json(&args, b"");
    assert_eq!(status, 0, "{result}");
    let (status, refused) = folder.json(&["locate", "p.toml"], b"");
    let told = (status, refused["error"]["code"].as_str(), refused["error"]["key"].as_str());
    assert_eq!(told, (2, Some("invalid-input"), Some("touch[0].at")), "{refused}");
    assert!(refused["error"]["message"].as_str().unwrap().contains("not filled in"), "{refused}");
    let (status, refused) = folder.json(&["locate", "m.toml", "--touches", "p.csv"], b"");
    assert_eq!(
        (status, refused["error"]["key"].as_str(), refused["error"]["line"].as_u64()),
        (2, Some("x"), Some(2)),
        "{refused}"
    );

    let (mut measurement, table) =
        ["p.toml", "p.csv"].map(|name| fs::read_to_string(folder.0.path().join(name)).unwrap()).into();
    let mut filled = String::new();
    for (index, line) in table.lines().enumerate() {
        if index == 0 {
            filled.push_str(line);
            filled.push('\n');
            continue;
        }
        let [x, y, z] = triple(&result["touches"][index - 1]["parent"]["tip"]);
        measurement = measurement.replacen("at = \"?\"", &format!("at = [{x}, {y}, {z}]"), 1);
        filled.push_str(&line.replacen(",,,", &format!(",{x},{y},{z}"), 1));
        filled.push('\n');
    }
    let folder = folder.with("p.toml", measurement).with("p.csv", filled);
    for args in [&["locate", "p.toml"][..], &["locate", "m.toml", "--touches", "p.csv"]] {
        let (status, located) = folder.json(args, b"");
        assert_eq!(status, 0, "{args:?} {located}");
        let origin = triple(&located["frame"]["origin"]);
        assert!(
            (origin[0] - 10.0).abs() + (origin[1] - 20.0).abs() + (origin[2] - 30.0).abs() < 1e-6,
            "{located}"
        );
    }
}

#[test]
fn a_target_is_an_expanded_uncertainty() {
    let folder = folder();
    let (status, result) = folder.json(&["plan", "m.toml", "--target", "0.022", "--at", "0,0,0"], b"");
    assert_eq!(status, 0, "{result}");
    assert!(1.96 * number(&result["worst"]) <= 0.022, "{result}");
    let (status, result) = folder.json(
        &["plan", "m.toml", "--target", "1e-6", "--at", "0,0,0", "--from", "1,1,1", "--cone", "60"],
        b"",
    );
    assert_eq!((status, result["error"]["code"].as_str()), (1, Some("not-met")), "{result}");
}

#[test]
fn without_a_sigma_ratios_are_told() {
    let folder = Folder::new().with("m.toml", CUBE.replace("sigma = 0.005", ""));
    let (status, result) = folder.json(&["plan", "m.toml"], b"");
    assert_eq!(status, 0, "{result}");
    assert!(result["worst"].is_null() && result["points"][0]["u"].is_null(), "{result}");
    assert!(number(&result["points"][0]["u_over_sigma"]) > 0.0 && number(&result["naive_over_plan"]) > 0.0);
    let text = String::from_utf8(folder.run(&["plan", "m.toml"], b"").stdout).unwrap();
    assert!(text.contains("no sigma is stated"), "{text}");
}

/// The paper's touches with a probe that is too rough, and the touch that tells the frames apart.
#[test]
fn the_next_touch_of_a_measurement() {
    let folder = Folder::new().with("m.toml", paper());
    let (status, result) = folder.json(&["plan", "m.toml", "--next"], b"");
    assert_eq!((status, result["next"]["effect"].as_str()), (0, Some("reduces")), "{result}");
    assert!(number(&result["next"]["worst_after"]) < number(&result["next"]["worst_before"]));
    let args = ["plan", "m.toml", "--next", "--sigma", "0.05"];
    let (status, result) = folder.json(&args, b"");
    assert_eq!((status, result["next"]["effect"].as_str()), (0, Some("separates")), "{result}");
    assert!(number(&result["next"]["sigmas"]) > 5.0 && number(&result["next"]["frames"]) > 1.0, "{result}");
    let text = String::from_utf8(folder.run(&args, b"").stdout).unwrap();
    assert!(
        text.contains("Ambiguous.") && text.contains("Touch next") && text.contains("the parent tip centre"),
        "{text}"
    );
}

#[test]
fn wrong_arguments_are_told() {
    let bare =
        Folder::new().with("m.toml", without_touches()).with("n.toml", CUBE.replace("sigma = 0.005", ""));
    let table: &[(&[&str], i32, &str, &str)] = &[
        (&["--touches-per-surface", "4"], 2, "invalid-input", "touches-per-surface"),
        (&["--touches-per-surface", "4,2"], 2, "too-few-touches", ""),
        (&["--touches-per-surface", "4,x"], 2, "usage", "--touches-per-surface <A,B,...>"),
        (&["--touches-per-surface", "4,3", "--total", "8"], 2, "usage", ""),
        (&["--total", "3"], 2, "too-few-touches", ""),
        (&["--total", "-3"], 2, "usage", ""),
        (&["--target", "0"], 2, "usage", "--target <U>"),
        (&["--target", "nan"], 2, "usage", "--target <U>"),
        (&["--at", "1,2"], 2, "usage", "--at <X,Y,Z>"),
        (&["--criterion", "best"], 2, "usage", "--criterion <CRITERION>"),
        (&["--from", "0,0,1"], 2, "usage", ""),
        (&["--cone", "30"], 2, "usage", ""),
        (&["--from", "0,0,0", "--cone", "30"], 2, "usage", "--from <X,Y,Z>"),
        (&["--from", "0,0,1", "--cone", "200"], 2, "usage", "--cone <DEG>"),
        (&["--from", "0,0,-1", "--cone", "10"], 2, "invalid-input", "cone"),
        (&["--extent", "cylindr=1,2"], 2, "unknown-surface", "extent"),
        (&["--extent", "cylinder=2,1"], 2, "invalid-input", "extent"),
        (&["--extent", "plane=-1"], 2, "invalid-input", "extent"),
        (&["--extent", "plane"], 2, "usage", "--extent <SURFACE=NUMBERS>"),
        (&["--redundancy", "1"], 2, "usage", "--redundancy <R>"),
        (&["--near", "1,2"], 2, "invalid-input", "near"),
        (&["--next"], 2, "too-few-touches", ""),
        (&["--next", "-o", "x.toml"], 2, "usage", ""),
        (&["-o", "no/such/folder.toml"], 2, "unwritable", ""),
    ];
    for (args, expected, code, key) in table {
        let (status, result) = bare.json(&[&["plan", "m.toml"], *args].concat(), b"");
        assert_eq!(
            (status, result["error"]["code"].as_str()),
            (*expected, Some(*code)),
            "{args:?}: {result}"
        );
        if !key.is_empty() {
            assert_eq!(result["error"]["key"].as_str(), Some(*key), "{args:?}: {result}");
        }
    }
    let (status, result) = bare.json(&["plan", "n.toml", "--target", "1"], b"");
    assert_eq!((status, result["error"]["key"].as_str()), (2, Some("probe.sigma")), "{result}");
    // A probe so rough that no layout stands.
    let output = bare.run(&["plan", "m.toml", "--sigma", "0.4", "--redundancy", "0"], b"");
    assert_eq!((output.status.code(), output.stdout.as_slice()), (Some(1), &b""[..]));
    assert!(String::from_utf8_lossy(&output.stderr).contains("No plan:"), "{output:?}");
}
