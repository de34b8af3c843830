//! `gauge` as a user types it.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use common::Folder;
use serde_json::Value;

fn figures(result: &Value) -> impl Iterator<Item = &Value> {
    result["examples"].as_array().unwrap().iter().flat_map(|example| example["figures"].as_array().unwrap())
}

#[test]
fn the_published_examples_are_reproduced() {
    let (status, result) = Folder::new().json(&["gauge", "--samples", "50000"], b"");
    assert_eq!((status, result["schema"].as_str()), (0, Some("touchref.gauge/1")));
    assert_eq!(
        (&result["samples"], &result["seed"], &result["diff"]),
        (&50_000.into(), &0.into(), &0.into())
    );
    let count = |verdict: &str| figures(&result).filter(|figure| figure["verdict"] == verdict).count() as u64;
    assert!(figures(&result).count() >= 30);
    for (key, verdict) in [("pass", "PASS"), ("note", "NOTE"), ("diff", "DIFF")] {
        assert_eq!(result[key].as_u64().unwrap(), count(verdict), "{key}");
    }
    assert!(count("NOTE") >= 4);
    for figure in figures(&result) {
        assert_eq!(figure["verdict"] == "NOTE", figure["reason"].is_string(), "{figure}");
        let within = figure["difference"].as_f64().unwrap().abs() <= figure["tolerance"].as_f64().unwrap();
        assert_eq!(figure["verdict"] == "PASS", within, "{figure}");
    }
}

#[test]
fn it_depends_on_its_seed_and_on_nothing_else() {
    let folder = Folder::new();
    let run = |args: &[&str]| folder.json(&[&["gauge", "--samples", "2000"], args].concat(), b"").1;
    let first = run(&[]);
    assert_eq!(first, run(&["--seed", "0"]));
    assert_ne!(first, run(&["--seed", "1"]));
}

#[test]
fn people_see_each_document_the_reasons_and_no_bar_in_a_pipe() {
    let output = Folder::new().run(&["gauge", "--samples", "2000"], b"");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("No figure differs. Of "), "{text}");
    for part in
        ["\nGUM, JCGM 100:2008\n", "\nNIST Technical Note 1900\n", "  NOTE u(X): ", "0.29558", "2000 trials"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(output.stderr.is_empty());
}

#[test]
fn samples_that_tell_nothing_are_refused() {
    for (samples, key) in
        [("10", "samples"), ("0", "--samples <N>"), ("many", "--samples <N>"), ("1e30", "--samples <N>")]
    {
        let (status, result) = Folder::new().json(&["gauge", "--samples", samples], b"");
        assert_eq!((status, result["error"]["key"].as_str()), (2, Some(key)), "{samples}: {result}");
    }
}
