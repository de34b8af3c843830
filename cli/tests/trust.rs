//! `uncertainty` and `reliability` as a user types them: what they print of measurements in the examples.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use common::{Folder, number, paper};
use serde_json::Value;

fn example(name: &str) -> Folder {
    Folder::new().with("m.toml", common::example(name))
}

fn text(folder: &Folder, args: &[&str]) -> String {
    let output = folder.run(args, b"");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// What `locate` states is what holds at the origin; every source has its share; draws agree.
#[test]
fn uncertainty_is_that_of_the_frame_and_its_sources() {
    let folder = example("three-sphere.toml");
    let (status, located) = folder.json(&["locate", "m.toml"], b"");
    assert_eq!(status, 0);
    let (status, told) = folder.json(&["uncertainty", "m.toml", "--at", "0,0,0", "--at", "300,0,0"], b"");
    assert_eq!((status, told["schema"].as_str()), (0, Some("touchref.uncertainty/1")), "{told}");
    for k in 0..3 {
        let variance = number(&located["covariance"]["matrix"][k][k]);
        assert!((number(&told["points"][0]["u"][k]) / variance.sqrt() - 1.0).abs() < 1e-3, "{k}");
        let turn = number(&located["covariance"]["matrix"][k + 3][k + 3]);
        assert!((number(&told["rotation"]["u"][k]) / turn.sqrt() - 1.0).abs() < 1e-3, "{k}");
    }
    for quantity in told["points"].as_array().unwrap().iter().chain([&told["rotation"]]) {
        let budget = quantity["budget"].as_array().unwrap();
        let sources: Vec<&str> = budget.iter().map(|part| part["source"].as_str().unwrap()).collect();
        assert_eq!(sources, ["touches on `a`", "touches on `b`", "touches on `c`", "ab", "bc", "ca"]);
        let sum: f64 = budget.iter().map(|part| number(&part["share"])).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        let worst = &quantity["worst"];
        assert!((number(&worst["expanded"]) / number(&worst["u"]) - 1.959_964).abs() < 1e-6);
    }
    let drawn = &told["monte_carlo"];
    assert_eq!(
        (&drawn["validated"], &drawn["stable"], &drawn["failed"]),
        (&true.into(), &true.into(), &0.into())
    );
    assert_eq!(drawn["quantities"].as_array().unwrap().len(), 9);
}

#[test]
fn uncertainty_in_words() {
    let folder = example("three-sphere.toml");
    let text = text(&folder, &["uncertainty", "m.toml", "--at", "300,0,0", "--samples", "20000"]);
    for part in [
        "Known to +-0.0316 mm at 300, 0, 0, along the fixture's Z axis (95 % coverage, k = 1.96).",
        "Monte Carlo\nagrees.",
        "touches on `b`          71.4",
        "20000 draws, seed 0, stable to one digit",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// Noise that bends the distances: the intervals of first order are not true, and that is said.
#[test]
fn intervals_that_draws_deny_are_not_validated() {
    let folder = example("three-sphere.toml");
    let args = ["uncertainty", "m.toml", "--at", "300,0,0", "--digits", "2", "--samples", "20000"];
    let (status, told) = folder.json(&[&args[..], &["--sigma", "0.1"]].concat(), b"");
    assert_eq!((status, &told["monte_carlo"]["validated"]), (0, &false.into()), "{told}");
    assert_eq!(told["warnings"][0]["code"], "first-order-doubtful");
}

/// One degree of freedom: Student's factor, and no draws, as their sigma has no variance.
#[test]
fn a_sigma_from_residuals_has_few_degrees_of_freedom() {
    let without = paper().lines().filter(|line| !line.starts_with("sigma")).collect::<Vec<_>>().join("\n");
    let folder = Folder::new().with("m.toml", without);
    let (status, told) = folder.json(&["uncertainty", "m.toml"], b"");
    assert_eq!((status, &told["degrees_of_freedom"]), (0, &1.into()), "{told}");
    assert!((number(&told["coverage_factor"]) - 12.706).abs() < 1e-3);
    assert_eq!(
        (told["monte_carlo"].clone(), told["sigma_source"].as_str()),
        (Value::Null, Some("residuals"))
    );
    assert_eq!(told["warnings"][0]["code"], "no-monte-carlo");
    // What is noticed without a sigma nobody can tell.
    let (status, refused) = folder.json(&["reliability", "m.toml"], b"");
    assert_eq!((status, refused["error"]["code"].as_str()), (2, Some("missing-key")));
    assert_eq!(refused["error"]["key"], "probe.sigma");
}

/// The paper's layout: four of the seven touches are checked by nothing.
#[test]
fn reliability_flags_what_nothing_checks() {
    let folder = Folder::new().with("m.toml", paper());
    let (status, told) = folder.json(&["reliability", "m.toml", "--at", "10,0,0"], b"");
    assert_eq!((status, told["schema"].as_str()), (0, Some("touchref.reliability/1")), "{told}");
    let observations = told["observations"].as_array().unwrap();
    let sum: f64 = observations.iter().map(|of| number(&of["redundancy"])).sum();
    assert!((sum - 1.0).abs() < 1e-9);
    for of in observations {
        let unchecked = number(&of["redundancy"]) < 1e-6;
        assert_eq!(of["smallest_detectable"].is_null(), unchecked, "{of}");
        assert_eq!(of["undetected"].is_null(), unchecked, "{of}");
        // One check: what is noticed is never told apart.
        assert!(of["confused_with"].as_array().unwrap().iter().all(|other| other["always"] == true));
    }
    let text = text(&folder, &["reliability", "m.toml"]);
    for part in
        ["No other touch checks 1 on cylinder, 4 on plane", "any goes unnoticed", "2 on cylinder (always)"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// A size that is stated is an observation, too: the touches check it.
#[test]
fn reliability_of_what_is_stated() {
    let (status, told) = example("three-sphere.toml")
        .json(&["reliability", "m.toml", "--alpha", "0.01", "--power", "0.9"], b"");
    assert_eq!(status, 0);
    assert!((number(&told["noncentrality"]) - 3.857).abs() < 1e-3);
    let kinds: Vec<&str> =
        told["observations"].as_array().unwrap().iter().map(|of| of["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds[9..], ["ab", "bc", "ca"]);
}

/// Nothing is told of a frame that is not accepted.
#[test]
fn a_frame_that_is_refused_has_no_uncertainty() {
    let folder = Folder::new().with("m.toml", paper());
    for command in ["uncertainty", "reliability"] {
        let (status, told) = folder.json(&[command, "m.toml", "-p", "radius=1.5"], b"");
        assert_eq!(status, 1, "{told}");
        assert_eq!(told["schema"], "touchref.error/1");
    }
}
