//! Whether a fixture has moved, as a user asks.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::fs;

use common::{Folder, example};
use serde_json::{Value, json};

const HERE: &str = "412.6,-188.3,95.2,0.1,0.2,-0.05,0.97";
const MOVED: &str = "412.65,-188.3,95.2,0.1,0.2,-0.05,0.97";

/// Measures three balls at a frame, and keeps the result as `NAME.json`.
fn measure(folder: &Folder, name: &str, frame: &str, seed: &str, more: &[&str]) -> Value {
    let frame = format!("--frame={frame}");
    let table = folder.run(&[&["simulate", "m.toml", &frame, "--seed", seed], more].concat(), b"").stdout;
    let (status, result) =
        folder.json(&[&["locate", "m.toml", "--touches", "-", "--record", "h.db"], more].concat(), &table);
    assert_eq!(status, 0, "{result}");
    fs::write(folder.0.path().join(format!("{name}.json")), result.to_string()).unwrap();
    result
}

fn balls() -> Folder {
    Folder::new().with("m.toml", example("three-sphere.toml"))
}

fn rewritten(folder: &Folder, name: &str, result: &Value) {
    fs::write(folder.0.path().join(name), result.to_string()).unwrap();
}

const TIP: [&str; 2] = ["--tip-radius", "1.5+-0.02"];

#[test]
fn two_results_are_held_against_each_other() {
    let folder = balls();
    let before = measure(&folder, "a", HERE, "1", &[]);
    measure(&folder, "b", HERE, "2", &[]);
    let after = measure(&folder, "c", MOVED, "3", &[]);

    let (status, still) = folder.json(&["compare", "a.json", "b.json"], b"");
    assert_eq!(
        (status, &still["moved"], &still["schema"]),
        (0, &json!(false), &json!("touchref.comparison/1"))
    );
    let change = &still["comparisons"][0];
    // 22.458: chi-square of six degrees of freedom at 1e-3.
    assert!((change["limit"].as_f64().unwrap() - 22.458).abs() < 1e-3, "{change}");
    assert_eq!((&change["distribution"], &change["words"]), (&json!("chi-square"), &Value::Null));

    let args = ["compare", "a.json", "c.json", "--at", "0,0,0", "--at", "-10, 100,5"];
    let (status, moved) = folder.json(&args, b"");
    assert_eq!((status, &moved["moved"], &moved["first_moved"]), (1, &json!(true), &json!(0)), "{moved}");
    let change = &moved["comparisons"][0];
    assert!(change["p_value"].as_f64().unwrap() < 1e-6 && change["exceeded"] == true);
    let close = |got: &Value, want: f64| assert!((got.as_f64().unwrap() - want).abs() < 1e-9, "{got} {want}");
    for k in 0..3 {
        let origin = |result: &Value| result["frame"]["origin"][k].as_f64().unwrap();
        close(&change["motion"]["translation"][k], origin(&after) - origin(&before));
        close(&change["points"][0]["moved"][k], origin(&after) - origin(&before));
        let at = |result: &Value| {
            let row = |j: usize| result["frame"]["matrix"][k][j].as_f64().unwrap();
            -10.0 * row(0) + 100.0 * row(1) + 5.0 * row(2) + row(3)
        };
        close(&change["points"][1]["moved"][k], at(&after) - at(&before));
    }
    assert!(
        (change["shift"]["value"].as_f64().unwrap() - 0.05).abs()
            < 4.0 * change["shift"]["u"].as_f64().unwrap()
    );
    let explanations = change["explanations"].as_array().unwrap();
    assert_eq!((explanations.len(), &explanations[0]["surface"]), (4, &Value::Null));
    assert_eq!(explanations[0]["explains"], true, "{change}");

    let output = folder.run(&args, b"");
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1));
    for part in
        ["The fixture has moved.", "as a whole", "turn (deg)", "(-10, 100, 5)", "6 degrees of freedom"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let text = String::from_utf8(folder.run(&["compare", "a.json", "b.json"], b"").stdout).unwrap();
    assert!(text.starts_with("Nothing has moved."), "{text}");
}

/// The same tip errs alike in both: what that does to the frame is no uncertainty of the motion.
#[test]
fn a_common_tip_hides_no_motion() {
    let folder = balls();
    for (name, seed) in [("a", "1"), ("b", "2")] {
        measure(&folder, name, HERE, seed, &TIP);
    }
    let distance = |args: &[&str]| {
        let (_, result) = folder.json(&[&["compare"], args].concat(), b"");
        (result["comparisons"][0]["squared_distance"].as_f64().unwrap(), result)
    };
    let (common, result) = distance(&["a.json", "b.json"]);
    assert_eq!(result["common"], json!(["ab", "bc", "ca", "tip_radius"]));
    assert_eq!(result["warnings"], json!([]));
    let (independent, result) = distance(&["a.json", "b.json", "--independent"]);
    assert!(independent < common && result["common"] == json!([]) && result["warnings"] == json!([]));
    // An older result does not tell its touches.
    let mut older: Value =
        serde_json::from_slice(&fs::read(folder.0.path().join("b.json")).unwrap()).unwrap();
    for touch in older["touches"].as_array_mut().unwrap() {
        touch.as_object_mut().unwrap().remove("at");
    }
    rewritten(&folder, "old.json", &older);
    let (of_older, result) = distance(&["a.json", "old.json"]);
    assert!((of_older - independent).abs() < 1e-9 && result["common"] == json!([]));
    assert_eq!(result["warnings"][0]["code"], "common-errors");
}

/// A bore whose spin no touch sees: five motions count, and the surfaces are read back from the result.
#[test]
fn a_composite_that_leaves_its_spin_free() {
    let folder = Folder::new().with("m.toml", example("bore-and-faces.toml"));
    let located = |args: &[&str], name: &str| {
        let (status, result) = folder.json(&[&["locate"], args].concat(), b"");
        assert_eq!(status, 0, "{result}");
        rewritten(&folder, name, &result);
    };
    located(&["m.toml"], "a.json");
    let turned = "--frame=-75.0,310.0,120.0,0.3,0.1,0.2,0.9";
    fs::write(
        folder.0.path().join("t.csv"),
        folder.run(&["simulate", "m.toml", turned, "--seed", "3"], b"").stdout,
    )
    .unwrap();
    located(&["m.toml", "--touches", "t.csv"], "b.json");
    let (status, result) = folder.json(&["compare", "a.json", "b.json"], b"");
    let change = &result["comparisons"][0];
    assert_eq!((status, &change["degrees_of_freedom"]), (0, &json!(5)), "{result}");
    assert_eq!(result["common"], json!(["bore.radius"]), "{result}");
}

#[test]
fn noise_that_residuals_tell_makes_an_f_ratio() {
    let folder = Folder::new().with("m.toml", example("three-sphere.toml").replace("sigma = ", "# sigma = "));
    for (name, seed) in [("a", "1"), ("b", "2")] {
        let frame = format!("--frame={HERE}");
        let table =
            folder.run(&["simulate", "m.toml", &frame, "--seed", seed, "--sigma", "0.005"], b"").stdout;
        let (status, result) = folder.json(&["locate", "m.toml", "--touches", "-"], &table);
        assert_eq!(status, 0, "{result}");
        rewritten(&folder, &format!("{name}.json"), &result);
    }
    let (status, result) = folder.json(&["compare", "a.json", "b.json"], b"");
    let change = &result["comparisons"][0];
    assert_eq!((status, &change["distribution"]), (0, &json!("F")), "{result}");
    let degrees = |file: &str| {
        let result: Value = serde_json::from_slice(&fs::read(folder.0.path().join(file)).unwrap()).unwrap();
        result["degrees_of_freedom"].as_u64().unwrap()
    };
    assert_eq!(change["degrees_of_freedom_of_noise"], degrees("a.json") + degrees("b.json"));
}

#[test]
fn a_series_is_held_against_its_baseline() {
    let folder = balls();
    for seed in ["1", "2", "3", "4"] {
        measure(&folder, seed, HERE, seed, &TIP);
    }
    measure(&folder, "5", MOVED, "5", &TIP);
    let (status, result) = folder.json(&["compare", "h.db", "--baseline", "3", "--alpha", "0.01"], b"");
    assert_eq!((status, &result["first_moved"]), (1, &json!(1)), "{result}");
    assert_eq!(result["baseline"]["results"], json!(["h.db#1", "h.db#2", "h.db#3"]));
    assert_eq!(result["baseline"]["agreement"]["degrees_of_freedom"], 12);
    assert_eq!(result["baseline"]["agreement"]["exceeded"], false);
    // 1 - 0.99^2.
    assert!((result["alpha_of_series"].as_f64().unwrap() - 0.0199).abs() < 1e-12, "{result}");
    let (_, series) =
        folder.json(&["compare", "h.db", "--baseline", "3", "--alpha", "0.0199", "--series"], b"");
    assert!((series["alpha"].as_f64().unwrap() - 0.01).abs() < 1e-12, "{series}");
    let text = String::from_utf8(folder.run(&["compare", "h.db", "--baseline", "3"], b"").stdout).unwrap();
    for part in ["h.db#5", "Results in order", "the mean of h.db#1, h.db#2, h.db#3", "at most"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // A baseline with the moved one in it is none.
    let args = ["compare", "1.json", "5.json", "2.json", "--baseline", "2"];
    let (status, result) = folder.json(&args, b"");
    assert_eq!((status, &result["baseline"]["agreement"]["exceeded"]), (1, &json!(true)), "{result}");
    assert!(String::from_utf8(folder.run(&args, b"").stdout).unwrap().starts_with("The baseline has moved"));
}

#[test]
fn wrong_calls_are_told() {
    let folder = balls().with("m-ball.toml", example("three-sphere.toml")).with("text.txt", "{}");
    let good = measure(&folder, "a", HERE, "1", &[]);
    let with = |name: &str, change: &dyn Fn(&mut Value)| {
        let mut result = good.clone();
        change(&mut result);
        rewritten(&folder, name, &result);
    };
    with("inch.json", &|result| result["units"] = json!("in"));
    with("other.json", &|result| result["fixture"]["kind"] = json!("cube"));
    with("size.json", &|result| result["fixture"]["parameters"]["radius"] = json!(12.8));
    with("none.json", &|result| result["covariance"] = Value::Null);
    with("flat.json", &|result| {
        for k in 0..6 {
            result["covariance"]["matrix"][2][k] = json!(0.0);
            result["covariance"]["matrix"][k][2] = json!(0.0);
        }
        for touch in result["touches"].as_array_mut().unwrap() {
            touch.as_object_mut().unwrap().remove("at");
        }
    });
    with("error.json", &|result| result["schema"] = json!("touchref.error/1"));
    with("surface.json", &|result| result["touches"][0]["surface"] = json!("d"));
    with("turn.json", &|result| result["frame"]["quaternion_xyzw"] = json!([0, 0, 0, 0]));
    let cases: [(&[&str], &str, &str); 14] = [
        (&["a.json"], "invalid-input", "1 results are given"),
        (&["a.json", "a.json", "--baseline", "2"], "invalid-input", "make the baseline"),
        (&["a.json", "inch.json"], "invalid-input", "different units: mm and in"),
        (&["a.json", "other.json"], "invalid-input", "three-sphere and cube"),
        (&["a.json", "size.json"], "invalid-input", "radius is 12.7 and 12.8"),
        (&["a.json", "none.json"], "invalid-input", "none.json has no covariance"),
        (&["flat.json", "flat.json"], "invalid-input", "singular"),
        (&["a.json", "error.json"], "invalid-input", "its schema is touchref.error/1"),
        (&["a.json", "text.txt"], "invalid-input", "missing field `schema`"),
        (&["a.json", "surface.json"], "unknown-surface", "`d`"),
        (&["a.json", "turn.json"], "invalid-input", "no rotation"),
        (&["a.json", "h.db#7"], "invalid-input", "no frame of number 7"),
        (&["a.json", "a.json", "--last", "2"], "invalid-input", "none is given"),
        (&["a.json", "gone.json"], "unreadable", "gone.json"),
    ];
    for (args, code, part) in cases {
        let (status, result) = folder.json(&[&["compare"], args].concat(), b"");
        let error = &result["error"];
        assert_eq!((status, error["code"].as_str()), (2, Some(code)), "{args:?}: {result}");
        assert!(error["message"].as_str().unwrap().contains(part), "{args:?}: {result}");
    }
    for wrong in
        [["--alpha", "0"], ["--alpha", "x"], ["--at", "1,2"], ["--at", "1,2,nan"], ["--baseline", "0"]]
    {
        let (status, result) = folder.json(&[&["compare", "a.json", "a.json"], &wrong[..]].concat(), b"");
        assert_eq!((status, result["error"]["code"].as_str()), (2, Some("usage")), "{wrong:?}");
    }
}
