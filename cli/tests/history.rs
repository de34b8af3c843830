//! What `locate --record` keeps, and `history` gives back; whatever happens to the process.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{
    fs,
    io::Read,
    path::Path,
    process::{Command, Stdio},
    thread::sleep,
    time::Instant,
};

use common::{Folder, paper};
use serde_json::{Value, json};

fn folder() -> Folder {
    let ambiguous = paper().replace("sigma = 0.00005", "sigma = 0.1");
    assert_ne!(ambiguous, paper());
    Folder::new().with("m.toml", paper()).with("ambiguous.toml", ambiguous)
}

fn note(folder: &Folder, args: &[&str]) -> (i32, String) {
    let output = folder.run(args, b"");
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn frames_and_refusals_are_kept_listed_and_exported() {
    let folder = folder();
    let printed =
        folder.run(&["locate", "m.toml", "--record", "h.db", "--name", "cell, 1", "--format", "json"], b"");
    assert_eq!(String::from_utf8(printed.stderr).unwrap(), "recorded as 1 in h.db\n");
    let (status, told) = note(&folder, &["locate", "ambiguous.toml", "--record", "h.db"]);
    assert!(
        status == 1 && told.starts_with("recorded as 2 in h.db\n") && told.contains("No frame to trust"),
        "{told}"
    );
    assert_eq!(note(&folder, &["locate", "m.toml", "--record", "h.db"]).0, 0);

    let (status, listed) = folder.json(&["history", "h.db"], b"");
    assert_eq!((status, &listed["schema"]), (0, &json!("touchref.history/1")));
    let results = listed["results"].as_array().unwrap();
    let field = |key: &str| results.iter().map(|result| result[key].clone()).collect::<Vec<_>>();
    assert_eq!(field("number"), [1, 2, 3]);
    assert_eq!(field("status"), ["ok", "ambiguous", "ok"]);
    assert_eq!(field("name"), [json!("cell, 1"), Value::Null, Value::Null]);
    assert_eq!(field("measurement"), ["m.toml", "ambiguous.toml", "m.toml"]);
    assert_eq!(results[0]["result"], serde_json::from_slice::<Value>(&printed.stdout).unwrap());
    assert_eq!(results[1]["result"]["schema"], "touchref.error/1");
    assert_eq!(results[0]["origin"], results[0]["result"]["frame"]["origin"]);
    assert_eq!(results[1]["origin"], Value::Null);

    let text = String::from_utf8(folder.run(&["history", "h.db"], b"").stdout).unwrap();
    assert!(text.contains("cell, 1") && text.contains("ambiguous") && text.contains("2.900"), "{text}");
    let csv = String::from_utf8(folder.run(&["history", "h.db", "--format", "csv"], b"").stdout).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines[0], "number,time,name,measurement,fixture,status,units,x,y,z");
    assert!(lines[1].contains(",\"cell, 1\",m.toml,cylinder-plane,ok,mm,"), "{csv}");
    assert!(lines[2].ends_with(",,ambiguous.toml,cylinder-plane,ambiguous,mm,,,"), "{csv}");

    let (_, last) = folder.json(&["history", "h.db", "--last", "1", "--fixture", "cylinder-plane"], b"");
    assert_eq!(last["results"][0]["number"], 3);
    let (_, none) = folder.json(&["history", "h.db", "--until", "2020-01-01"], b"");
    assert_eq!(none["results"], json!([]));

    let (status, told) = note(&folder, &["history", "h.db", "--export", "out/put"]);
    assert!(
        status == 0 && told.contains("2 result files") && told.contains("refusals left out: 1"),
        "{told}"
    );
    assert_eq!(fs::read(folder.0.path().join("out/put/000001.json")).unwrap(), printed.stdout);
    assert!(folder.0.path().join("out/put/000003.json").exists());
    assert_eq!(fs::read_dir(folder.0.path().join("out/put")).unwrap().count(), 2);
    // What is exported, and what the store holds, is what `compare` reads.
    for results in [&["out/put/000001.json", "h.db#3"][..], &["h.db"], &["h.db", "--last", "2"]] {
        let (status, compared) = folder.json(&[&["compare"], results].concat(), b"");
        assert_eq!((status, &compared["moved"]), (0, &json!(false)), "{results:?}: {compared}");
    }
}

/// A result that cannot be kept is not printed: who asks for a record relies on it.
#[test]
fn what_cannot_be_kept_is_told() {
    let folder = folder().with("notes.txt", "not a store, but long enough to be taken for one");
    for (store, code, part) in [
        ("notes.txt", "invalid-input", "is no store of results"),
        ("no/such/folder.db", "unreadable", "cannot open"),
        (".", "unreadable", "cannot open"),
    ] {
        let (status, result) = folder.json(&["locate", "m.toml", "--record", store], b"");
        let error = &result["error"];
        assert_eq!((status, error["code"].as_str()), (2, Some(code)), "{result}");
        assert_eq!(error["key"], "record", "{result}");
        assert!(error["message"].as_str().unwrap().contains(part), "{result}");
        let plain = folder.run(&["locate", "m.toml", "--record", store], b"");
        assert!(plain.stdout.is_empty());
    }
    for (args, key) in [
        (&["history", "none.db"][..], Value::Null),
        (&["history", "m.toml"], Value::Null),
        (&["history", "none.db", "--last", "0"], json!("--last <N>")),
        (&["locate", "m.toml", "--name", "x"], json!("--record <FILE>")),
    ] {
        let (status, result) = folder.json(args, b"");
        assert_eq!(status, 2, "{args:?}: {result}");
        assert_eq!(result["error"]["key"], key, "{args:?}: {result}");
    }
    note(&folder, &["locate", "m.toml", "--record", "h.db"]);
    let (status, result) = folder.json(&["history", "h.db", "--since", "yesterday"], b"");
    assert_eq!((status, &result["error"]["key"]), (2, &json!("since")), "{result}");
}

/// Killed at a hundred moments from its start to beyond its end, one process of it at a time: every number that was told is
/// there.
#[test]
fn what_was_told_as_recorded_survives_a_kill() {
    const KILLS: u32 = 100;
    let folder = folder();
    let command = || {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("touchref"));
        command.current_dir(folder.0.path()).args(["locate", "m.toml", "--record", "h.db"]);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command
    };
    let start = Instant::now();
    assert!(command().output().unwrap().status.success());
    let whole = start.elapsed();
    let mut told = vec![1];
    for kill in 0..KILLS {
        let mut child = command().spawn().unwrap();
        sleep(whole.mul_f64(2.0 * f64::from(kill) / f64::from(KILLS)));
        child.kill().unwrap();
        child.wait().unwrap();
        let mut text = String::new();
        child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        let number = text.strip_prefix("recorded as ").and_then(|rest| rest.split(' ').next());
        told.extend(number.map(|number| number.parse::<i64>().unwrap()));
    }
    let (status, listed) = folder.json(&["history", "h.db"], b"");
    assert_eq!(status, 0, "{listed}");
    let results = listed["results"].as_array().unwrap();
    for number in &told {
        let kept = results.iter().find(|result| result["number"] == *number);
        assert_eq!(kept.unwrap()["result"]["schema"], "touchref.solution/1", "{number}");
    }
    // Some died before they told, some after: the sweep is over the moments that matter.
    assert!(told.len() > 1 && told.len() < KILLS as usize, "{} told", told.len());
    let store = rusqlite::Connection::open(Path::new(folder.0.path()).join("h.db")).unwrap();
    let check: String = store.pragma_query_value(None, "integrity_check", |row| row.get(0)).unwrap();
    assert_eq!(check, "ok");
}
