//! `calibrate` as a user types it: what it prints, and what is told of measurements that give no calibration.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{fmt::Write as _, fs};

use common::{Folder, TABLE, number, paper};

/// The worked example.
fn example() -> String {
    common::example("calibration.toml")
}

fn folder() -> Folder {
    Folder::new().with("m.toml", example())
}

/// Radius 20.0031 and tip 1.4982 were simulated.
#[test]
fn the_example_is_calibrated() {
    let (status, result) = folder().json(&["calibrate", "m.toml"], b"");
    assert_eq!((status, result["schema"].as_str()), (0, Some("touchref.calibration/1")), "{result}");
    for (parameter, (name, truth)) in
        result["parameters"].as_array().unwrap().iter().zip([("radius", 20.0031), ("tip_radius", 1.4982)])
    {
        assert_eq!(parameter["name"], name);
        assert!((number(&parameter["value"]) - truth).abs() < 2.5 * number(&parameter["u"]), "{parameter}");
        assert!(number(&parameter["u"]) < number(&parameter["nominal_u"]), "{parameter}");
        let moved =
            (number(&parameter["value"]) - number(&parameter["nominal"])) / number(&parameter["nominal_u"]);
        assert!((number(&parameter["moved"]) - moved).abs() < 1e-9, "{parameter}");
    }
    let correlation = number(&result["correlations"][0][1]);
    let u = |k: usize| number(&result["parameters"][k]["u"]);
    assert!((number(&result["covariance"][0][1]) / (u(0) * u(1)) - correlation).abs() < 1e-9);
    assert!(number(&result["p_value"]) > 1e-3 && result["degrees_of_freedom"] == 24);
    let placements = result["placements"].as_array().unwrap();
    assert_eq!((placements.len(), placements[2]["name"].as_str()), (6, Some("east")));
    assert_eq!(placements[2]["touches"].as_array().unwrap().len(), 10);
    assert_eq!(placements[2]["covariance"]["order"][0], "x");
}

#[test]
fn text_tells_parameters_correlations_and_placements() {
    let folder = folder();
    let text = String::from_utf8(folder.run(&["calibrate", "m.toml"], b"").stdout).unwrap();
    for part in [
        "Calibrated. 6 placements, 60 touches: chi-square",
        "Parameters (mm, degrees)",
        "nominal",
        "moved",
        "Correlations",
        "Placements",
        "north, turned",
        "sigma 0.005 mm, tip radius 1.5 +- 0.002 mm",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let free = folder.run(&["calibrate", "m.toml", "--free", "radius"], b"").stdout;
    assert!(String::from_utf8(free).unwrap().contains(" free "));
    assert!(folder.run(&["calibrate", "m.toml", "-o", "result.txt"], b"").stdout.is_empty());
    assert_eq!(fs::read_to_string(folder.0.path().join("result.txt")).unwrap(), text);
}

/// A table with a column `placement` says the same as sections of the file.
#[test]
fn a_table_of_placements_is_taken() {
    let folder = folder();
    let (_, sections) = folder.json(&["calibrate", "m.toml"], b"");
    let mut table = "placement,surface,x,y,z\n".to_owned();
    let mut name = String::new();
    for line in example().lines() {
        if let Some(text) = line.strip_prefix("name = ") {
            name = text.to_owned();
        } else if let Some((surface, at)) = line.split_once(", at = [") {
            let surface = surface.trim_start_matches("    { surface = ");
            let at = at.trim_end_matches("] },").replace(", ", ",");
            writeln!(table, "{name},{surface},{at}").unwrap();
        }
    }
    let head = example().split("[[placement]]").next().unwrap().to_owned();
    let folder = folder.with("t.csv", &table).with("head.toml", &head);
    let (status, result) = folder.json(&["calibrate", "head.toml", "--touches", "t.csv"], b"");
    assert_eq!((status, &result), (0, &sections));
    let named = format!("touches = \"t.csv\"\n{head}");
    assert_eq!(folder.with("named.toml", named).json(&["calibrate", "named.toml"], b""), (0, sections));
}

#[test]
fn what_is_not_told_apart_is_named() {
    let (status, result) =
        folder().json(&["calibrate", "m.toml", "--free", "radius", "--free", "tip_radius"], b"");
    let error = &result["error"];
    assert_eq!((status, error["code"].as_str()), (1, Some("degenerate")), "{result}");
    assert_eq!(error["parameters"], serde_json::json!(["radius", "tip_radius"]));
    let message = error["message"].as_str().unwrap();
    assert!(message.contains("only radius + tip_radius is seen"), "{message}");
}

#[test]
fn a_placement_that_does_not_fit_is_named() {
    let bent =
        example().replacen("name = \"south\"\ntouch = [\n    { surface = \"cylinder\", at = [", "&", 1);
    let at = bent.find('&').unwrap();
    let (before, after) = bent.split_at(at);
    let (first, rest) = after[1..].split_once(',').unwrap();
    let first = first.parse::<f64>().unwrap() + 0.3;
    let start = "name = \"south\"\ntouch = [\n    { surface = \"cylinder\", at = [";
    let folder = Folder::new().with("m.toml", format!("{before}{start}{first},{rest}"));
    let (status, result) = folder.json(&["calibrate", "m.toml"], b"");
    let error = &result["error"];
    assert_eq!((status, error["code"].as_str()), (1, Some("inconsistent")), "{result}");
    assert_eq!(error["placement"], serde_json::json!({ "index": 3, "name": "south" }));
    let text = folder.run(&["calibrate", "m.toml"], b"");
    assert!(text.stdout.is_empty());
    assert!(String::from_utf8(text.stderr).unwrap().contains("placement 3 is `south`"));
}

/// What is one placement is for `locate`, what are many for `calibrate`; and other calls that are wrong.
#[test]
fn wrong_calls_are_told() {
    let both = format!("placement,{TABLE}").replace("\ncyl", "\n0,cyl").replace("\npl", "\n1,pl");
    let unnamed = both.replacen("\n0,", "\n,", 1);
    let head = paper().split("[[touch]]").next().unwrap().to_owned();
    let no_sigma = example().replace("sigma = 0.005", "");
    let folder = folder()
        .with("one.toml", paper())
        .with("head.toml", head)
        .with("both.csv", both)
        .with("unnamed.csv", unnamed)
        .with("no-sigma.toml", no_sigma)
        .with("short.toml", example().replacen("    { surface = \"plane\"", "#", 2));
    let cases: [(&[&str], &str, &str, &str); 8] = [
        (&["locate", "m.toml"], "invalid-input", "placement", "touchref calibrate"),
        (
            &["locate", "head.toml", "--touches", "both.csv"],
            "invalid-input",
            "placement",
            "touchref calibrate",
        ),
        (&["calibrate", "one.toml", "--free", "radius"], "invalid-input", "placement", "touchref locate"),
        (
            &["calibrate", "head.toml", "--touches", "unnamed.csv"],
            "invalid-input",
            "placement",
            "[[placement]]",
        ),
        (&["calibrate", "m.toml", "--free", "radus"], "unknown-name", "free", "radius"),
        (&["calibrate", "no-sigma.toml"], "invalid-input", "", "state a sigma"),
        (&["calibrate", "head.toml"], "too-few-touches", "", "--touches TABLE"),
        (&["calibrate", "short.toml"], "too-few-touches", "", "missing touches"),
    ];
    for (args, code, key, help) in cases {
        let (status, result) = folder.json(args, b"");
        let error = &result["error"];
        assert_eq!((status, error["code"].as_str()), (2, Some(code)), "{args:?}: {result}");
        assert_eq!(error["key"].as_str().unwrap_or(""), key, "{args:?}: {result}");
        assert!(error["help"].as_str().unwrap().contains(help), "{args:?}: {result}");
    }
    let (_, result) = folder.json(&["calibrate", "short.toml"], b"");
    assert_eq!(result["error"]["placement"], serde_json::json!({ "index": 0, "name": "north" }));
}
