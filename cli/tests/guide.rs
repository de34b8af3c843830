//! `guide` as a user and as a cell controller call it: scripted runs from the first touch to the stop.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{fs, path::Path};

use common::{Folder, TABLE, without_touches};
use serde_json::Value;

const CUBE: &str =
    "units = \"mm\"\n[fixture]\nkind = \"cube\"\nedge = 50.0\n[probe]\ntip_radius = 0.0\nsigma = 0.005\n";

/// Answers of a run in JSON, one a line.
fn answers(folder: &Folder, args: &[&str], stdin: &str) -> (i32, Vec<Value>) {
    let output = folder.run(&[&["guide"], args, &["--format", "json"]].concat(), stdin.as_bytes());
    let text = String::from_utf8(output.stdout).unwrap();
    let lines =
        text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {text}")));
    (output.status.code().unwrap(), lines.collect())
}

/// The paper's touches, one after the other: what is still free after each, and the frame at the end.
#[test]
fn a_scripted_run_from_the_first_touch_to_the_stop() {
    let folder = Folder::new().with("m.toml", without_touches());
    let (status, answers) = answers(&folder, &["m.toml"], TABLE);
    // Before the first touch, and after each.
    assert_eq!((status, answers.len()), (0, 8), "{answers:?}");
    for (made, answer) in answers.iter().enumerate() {
        assert_eq!(answer["schema"], "touchref.guide/1");
        assert_eq!((answer["touches"].as_u64(), answer["unknowns"].as_u64()), (Some(made as u64), Some(6)));
        let free: Vec<&str> =
            answer["free"].as_array().unwrap().iter().map(|free| free.as_str().unwrap()).collect();
        if made == 7 {
            assert_eq!(answer["state"], "done", "{answer}");
            let x = answer["solution"]["frame"]["origin"][0].as_f64().unwrap();
            assert!((x - 2.9).abs() < 1e-3 && answer["expanded"].as_f64().unwrap() > 0.0, "{answer}");
            assert!(answer["next"].is_null());
            continue;
        }
        assert_eq!(answer["state"], "free", "{answer}");
        assert!(answer["next"]["contact"].is_array() && answer["missing"].is_string(), "{answer}");
        if made > 0 {
            // Each touch takes one motion.
            assert_eq!(free.len(), 6 - made, "{answer}");
        }
        if (1..5).contains(&made) {
            assert!(free.contains(&"slide along the axis of `cylinder`"), "{free:?}");
            assert!(free.contains(&"rotation about the axis of `cylinder`"), "{free:?}");
        }
    }
    let output = folder.run(&["guide", "m.toml"], TABLE.as_bytes());
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().take(8).collect();
    let beginnings = [
        "no touch yet: all 6 motions are free. Needed: `cylinder` has 0 of 4 touches, `plane` has 0 of 3 touches. Touch next: `",
        "touch 0 on `cylinder`: 5 of 6 motions free: slide along the axis of `cylinder`; rotation about the axis of `cylinder`;",
        "touch 1 on `cylinder`: 4 of 6 motions free: slide along the axis of `cylinder`; rotation about the axis of `cylinder`;",
        "touch 2 on `cylinder`: 3 of 6 motions free: slide along the axis of `cylinder`; rotation about the axis of `cylinder`;",
        "touch 3 on `cylinder`: 2 of 6 motions free: slide along the axis of `cylinder`; rotation about the axis of `cylinder`. Needed: `plane` has 0 of 3 touches. Touch next: `plane` at (",
        "touch 4 on `plane`: 1 of 6 motions free: ",
        "touch 5 on `plane`: no motion is free to first order. Needed: `plane` has 2 of 3 touches. Touch next: `plane` at (",
        "touch 6 on `plane`: one frame fits, sure to ",
    ];
    for (line, beginning) in lines.iter().zip(beginnings) {
        assert!(line.starts_with(beginning), "{line}\n{beginning}");
    }
    assert!(lines[7].ends_with("Done.") && text.contains("Frame found."), "{text}");
}

/// Every message of a run, as it stands in `transcripts/`: simulated touches, with two lines that are wrong and one touch
/// that is taken back, until the target is met half a length away.
#[test]
fn every_message_of_a_scripted_run() {
    let [measurement, touches, transcript] = ["toml", "csv", "txt"].map(|kind| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/transcripts/guide").with_extension(kind);
        fs::read_to_string(path).unwrap()
    });
    let folder = Folder::new().with("m.toml", measurement);
    let args = ["guide", "m.toml", "--at", "200,0,0", "--target", "1", "--near", "0,0,0,0,0,0,1"];
    let output = folder.run(&args, touches.as_bytes());
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    let (messages, frame) = text.split_once("\n\n").unwrap();
    for (told, expected) in messages.lines().zip(transcript.lines()) {
        assert_eq!(told, expected);
    }
    assert_eq!(messages.lines().count(), transcript.lines().count());
    assert!(frame.starts_with("Frame found."), "{frame}");
}

/// What is told of touches that give no frame yet, and what to do about it.
#[test]
fn refusals_say_where_to_touch_next() {
    let folder = Folder::new().with("m.toml", without_touches());
    let wrong = TABLE.replace("2.9270", "2.9470");
    for (table, sigma, parts) in [
        (
            TABLE,
            "0.016",
            [
                "touch 6 on `plane`: more than one frame fits: the next best would be excluded only up to a sigma of 0.01373, \
                 the stated is 0.01600. Touch next: `",
                " standard deviations).",
            ],
        ),
        (
            wrong.as_str(),
            "0.00005",
            [
                "touch 6 on `plane`: the touches contradict the fixture: chi-square 22424 with 1 degree of freedom",
                "Touch there again, or `undo` it. Touch next: `",
            ],
        ),
        (
            TABLE,
            "0.16",
            [
                "touch 6 on `plane`: the layout of the touches leaves a motion free: rotation of `plane` about the line",
                "Touch next: `",
            ],
        ),
    ] {
        let output = folder.run(&["guide", "m.toml", "--sigma", sigma], table.as_bytes());
        assert_eq!(output.status.code(), Some(1));
        let text = String::from_utf8(output.stdout).unwrap();
        let last: Vec<&str> = text.lines().rev().take(2).collect();
        assert!(last[0].starts_with("The touches ended before the frame was found"), "{}", last[0]);
        assert!(parts.iter().all(|part| last[1].contains(part)), "{}", last[1]);
    }
}

/// A target that is not met at the end of the touches; lines that are wrong are told and skipped, and a touch is taken back.
#[test]
fn an_unfinished_run_has_status_1() {
    let folder = Folder::new().with("m.toml", CUBE);
    let touches = "+z,-5,-5,0\n\n# a comment\n+y,1,2\n{\"undo\": true}\n{\"surface\": \"+z\", \"at\": [-5, -5, 0]}\n\
                   {\"surface\": \"z\", \"at\": [0, 0, 0]}\n{\"surface\": \"+z\"}\nundo\n+z,1,2,x\n";
    let (status, answers) =
        answers(&folder, &["m.toml", "--near", "0,0,0,0,0,0,1", "--target", "1e-9"], touches);
    let told: Vec<(Option<u64>, &str, u64)> = answers
        .iter()
        .map(|answer| {
            (answer["line"].as_u64(), answer["state"].as_str().unwrap(), answer["touches"].as_u64().unwrap())
        })
        .collect();
    let expected = [
        (None, "free", 0),
        (Some(1), "free", 1),
        (Some(4), "error", 1),
        (Some(5), "free", 0),
        (Some(6), "free", 1),
        (Some(7), "error", 1),
        (Some(8), "error", 1),
        (Some(9), "free", 0),
        (Some(10), "error", 0),
        (None, "unfinished", 0),
    ];
    assert_eq!((status, told.as_slice()), (1, expected.as_slice()), "{answers:#?}");
    assert!(answers[1]["next"]["parent"]["tip"].is_array(), "{}", answers[1]);
    assert_eq!(answers[5]["error"]["nearest"], "+z", "{}", answers[5]);
    assert_eq!(answers[2]["error"]["line"], 4, "{}", answers[2]);
    let undone = |index: usize| {
        (answers[index]["undone"]["touch"].as_u64(), answers[index]["undone"]["surface"].as_str())
    };
    assert_eq!([undone(3), undone(7)], [(Some(0), Some("+z")); 2]);
    assert!(answers[4]["undone"].is_null(), "{}", answers[4]);
    let output = folder.run(&["guide", "m.toml"], b"undo\n+z,-5,-5,0\nundo\n");
    let text = String::from_utf8(output.stdout).unwrap();
    let told: Vec<&str> = text.lines().collect();
    assert!(told[1].starts_with("there was no touch to take back; no touch yet: "), "{text}");
    assert!(told[3].starts_with("touch 0 on `+z` is taken back; no touch yet: "), "{text}");
}

#[test]
fn wrong_calls_are_told() {
    let folder = Folder::new().with("m.toml", CUBE.replace("sigma = 0.005", ""));
    for (args, key) in [
        (&["guide", "-"][..], None),
        (&["guide", "m.toml", "--touches", "-"], None),
        (&["guide", "m.toml", "--target", "1"], Some("probe.sigma")),
        (&["guide", "m.toml", "--target", "-1"], Some("--target <U>")),
        (&["guide", "m.toml", "--near", "1"], Some("near")),
    ] {
        let (status, result) = folder.json(args, b"");
        assert_eq!(status, 2, "{args:?}: {result}");
        assert!(key.is_none_or(|key| result["error"]["key"] == key), "{args:?}: {result}");
    }
}
