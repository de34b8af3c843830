//! The subcommands as a user types them.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
};

use common::{Folder, TABLE, paper, without_touches};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Origin and axis as printed in the paper, to its printed digits.
fn assert_papers_frame(result: &Value) {
    // Half a unit of the fourth digit of the touches, amplified by the layout's condition of about 11.
    const TOLERANCE: f64 = 5e-4;
    let near = |got: Vec<f64>, want: [f64; 3]| {
        assert!(got.iter().zip(want).all(|(g, w)| (g - w).abs() < TOLERANCE), "{got:?} {want:?}");
    };
    assert_eq!(result["schema"], "touchref.solution/1", "{result}");
    near(numbers(&result["frame"]["origin"]), [2.9000, 3.8000, 4.2249]);
    near(numbers(&result["frame"]["z_axis"]), [0.3000, 0.6000, 0.7416]);
}

#[test]
fn the_paper_in_every_form_of_input() {
    let json = serde_json::json!({
        "units": "mm",
        "fixture": { "kind": "cylinder-plane", "radius": 1, "angle_deg": 45 },
        "probe": { "sigma": 5e-5 },
        "touch": [
            { "surface": "cylinder", "at": [2.9270, 2.0000, 1.6250] },
            { "surface": "cylinder", "at": [1.7750, 2.8000, 1.4438] },
            { "surface": "cylinder", "at": [1.3730, 2.6000, 3.1166] },
            { "surface": "cylinder", "at": [3.5270, 3.2000, 3.1082] },
            { "surface": "plane", "at": [2.8250, 2.4000, 4.0395] },
            { "surface": "plane", "at": [3.9020, 5.2000, 4.0353] },
            { "surface": "plane", "at": [2.0480, 5.2000, 4.7853] },
        ],
    })
    .to_string();
    let semicolons = TABLE.replace(',', ";").replace('.', ",");
    let with_more = TABLE
        .lines()
        .enumerate()
        .map(|(i, line)| if i == 0 { format!("{line},qif_feature\r\n") } else { format!("{line},CYL_1\r\n") })
        .collect::<String>();
    let folder = Folder::new()
        .with("m.toml", paper())
        .with("bom.toml", format!("\u{feff}{}", paper().replace('\n', "\r\n")))
        .with("m.json", &json)
        .with("bare.toml", without_touches())
        .with("named.toml", format!("touches = \"t.csv\"\n{}", without_touches()))
        .with("t.csv", TABLE)
        .with("semicolons.csv", format!("\u{feff}# comment\r\n{semicolons}"))
        .with("tabs.csv", TABLE.replace(',', "\t"))
        .with("more.csv", with_more);
    let arguments = ["--fixture", "cylinder-plane", "-p", "radius=1", "-p", "angle_deg=45"];
    let from_arguments = [&["locate"], &arguments[..], &["--touches", "t.csv", "--sigma", "5e-5"]].concat();
    let cases: &[(&[&str], &str)] = &[
        (&["locate", "m.toml"], ""),
        (&["locate", "bom.toml"], ""),
        (&["locate", "m.json"], ""),
        (&["locate", "-"], &paper()),
        (&["locate", "-"], &json),
        (&["locate", "named.toml"], ""),
        (&["locate", "bare.toml", "--touches", "t.csv"], ""),
        (&["locate", "bare.toml", "--touches", "-"], TABLE),
        (&["locate", "bare.toml", "--touches", "semicolons.csv"], ""),
        (&["locate", "bare.toml", "--touches", "tabs.csv"], ""),
        (&["locate", "bare.toml", "--touches", "more.csv"], ""),
        (&from_arguments, ""),
    ];
    for (args, stdin) in cases {
        let (status, result) = folder.json(args, stdin.as_bytes());
        assert_eq!(status, 0, "{args:?}: {result}");
        assert_papers_frame(&result);
    }
}

/// The example of three balls: where its comment says that they stand, in every way to state their radii.
#[test]
fn three_balls_in_every_form_of_input() {
    // Ten standard deviations.
    const TOLERANCE: f64 = 0.05;
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/three-sphere.toml");
    let example = fs::read_to_string(file).unwrap();
    let listed = example.replace("radius = 12.7", "radii = [12.7, 12.7, 12.7]");
    let without = example.replace("radius = 12.7\n", "");
    let folder =
        Folder::new().with("one.toml", &example).with("three.toml", &listed).with("none.toml", &without);
    let radii = serde_json::json!([12.7, 12.7, 12.7]);
    let cases: [(&[&str], &str, Value); 5] = [
        (&["one.toml"], "radius", 12.7.into()),
        (&["three.toml"], "radii", radii.clone()),
        (&["none.toml", "-p", "radius=12.7"], "radius", 12.7.into()),
        (&["none.toml", "-p", "radii=[12.7, 12.7, 12.7]"], "radii", radii.clone()),
        (&["none.toml", "-p", "radii=12.7,12.7,12.7"], "radii", radii),
    ];
    for (args, name, value) in cases {
        let (status, result) = folder.json(&[&["locate"], args].concat(), b"");
        assert_eq!(status, 0, "{args:?}: {result}");
        assert_eq!(result["fixture"]["parameters"][name], value, "{args:?}");
        assert_eq!(result["roots"].as_array().unwrap().len(), 8);
        let origin = numbers(&result["frame"]["origin"]);
        let off = origin.iter().zip([412.6, -188.3, 95.2]).map(|(got, want)| (got - want).abs());
        assert!(off.fold(0.0, f64::max) < TOLERANCE, "{origin:?}");
        let text = folder.run(&[&["locate"], args].concat(), b"").stdout;
        let text = String::from_utf8(text).unwrap();
        assert!(text.contains(&format!("{name} = ")) && text.contains("ab = 110.004 +- 0.001"), "{text}");
    }
}

#[test]
fn arguments_take_the_place_of_the_file() {
    let folder = Folder::new().with("m.toml", paper().replace("radius = 1.0", "radius = 7.0"));
    let args = ["locate", "m.toml", "-p", "radius=1.0+-0.001", "--sigma", "1e-4", "--tip-radius", "0"];
    let (_, result) = folder.json(&args, b"");
    assert_papers_frame(&result);
    assert_eq!(result["fixture"]["parameters"]["radius"], serde_json::json!({ "value": 1.0, "u": 0.001 }));
    assert_eq!(result["probe"]["sigma"], 1e-4);
    let text = String::from_utf8(folder.run(&args, b"").stdout).unwrap();
    assert!(text.contains("radius = 1.0 +- 0.001"), "{text}");
}

#[test]
fn columns_that_are_not_used_are_told() {
    let table = TABLE.replace("id", "qif_feature");
    let folder = Folder::new().with("m.toml", without_touches());
    let args = ["locate", "m.toml", "--touches", "-"];
    let (_, result) = folder.json(&args, table.as_bytes());
    let warnings = result["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|warning| warning["code"] == "ignored-column"), "{warnings:?}");
    let output = folder.run(&args, table.as_bytes());
    assert!(String::from_utf8_lossy(&output.stderr).contains("`qif_feature`"));
}

#[test]
fn text_is_plain_ascii_in_a_pipe_and_names_what_counts() {
    let folder = Folder::new().with("m.toml", paper());
    let output = folder.run(&["locate", "m.toml"], b"");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.is_ascii() && !text.contains('\u{1b}'), "{text}");
    for part in ["Frame found.", "0.00005 mm", "2.900", "Z axis", "chi-square", "condition", "radius", "x7"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn a_refusal_prints_no_frame_and_has_status_1() {
    // A radius between those of two roots fits neither.
    let folder = Folder::new().with("m.toml", paper().replace("radius = 1.0", "radius = 1.04"));
    let output = folder.run(&["locate", "m.toml"], b"");
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("No frame to trust") && told.contains("What to do"), "{told}");
    let (status, result) = folder.json(&["locate", "m.toml"], b"");
    let error = &result["error"];
    assert_eq!((status, error["code"].as_str()), (1, Some("inconsistent")), "{result}");
    assert!(error["roots"].as_array().unwrap().len() >= 2 && error["trust"].is_object(), "{error}");
}

#[test]
fn a_result_file_is_a_frame() {
    let folder = Folder::new().with("m.toml", paper());
    let result = folder.run(&["locate", "m.toml", "--format", "json"], b"").stdout;
    let folder = folder.with("r.json", result);
    let (status, again) = folder.json(&["locate", "m.toml", "--near", "r.json"], b"");
    assert_eq!(status, 0);
    assert_papers_frame(&again);
}

#[test]
fn what_is_simulated_can_be_located() {
    let folder = Folder::new().with("m.toml", paper());
    let frame = "-10,20,300,0.5,-0.5,0.5,0.5";
    let layouts: &[&[&str]] = &[&[], &["--layout", "random", "--touches-per-surface", "8,6"]];
    for layout in layouts {
        let args =
            [&["simulate", "m.toml", "--seed", "5", "--frame", frame, "-o", "t.csv"], *layout].concat();
        let output = folder.run(&args, b"");
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stdout.is_empty());
        let (status, result) = folder.json(&["locate", "m.toml", "--touches", "t.csv"], b"");
        assert_eq!(status, 0, "{result}");
        let quaternion = numbers(&result["frame"]["quaternion_xyzw"]);
        for (got, want) in quaternion.iter().zip([0.5, -0.5, 0.5, 0.5]) {
            // The paper's sigma is 1e-4 of its radius; a layout may lose a factor of ten.
            assert!((got - want).abs() < 1e-3, "{layout:?} {quaternion:?}");
        }
    }
}

#[test]
fn a_seed_decides_and_placements_are_told_apart() {
    let folder = Folder::new().with("m.toml", paper());
    let run = |args: &[&str]| {
        let output = folder.run(&[&["simulate", "m.toml"], args].concat(), b"");
        String::from_utf8(output.stdout).unwrap()
    };
    assert_eq!(run(&["--seed", "1"]), run(&["--seed", "1"]));
    assert_ne!(run(&["--seed", "1"]), run(&["--seed", "2"]));
    let three = run(&["--seed", "1", "--count", "3"]);
    let rows: Vec<&str> = three.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(rows.len(), 1 + 3 * 7, "{three}");
    assert!(
        rows[0].starts_with("placement,id,surface,x,y,z") && rows[21].starts_with("2,x7,plane,"),
        "{three}"
    );
    assert!(three.starts_with("# ") && three.contains("seed 1, sigma 0.00005 mm"), "{three}");
}

#[test]
fn simulation_needs_a_sigma_and_somewhere_to_write() {
    let folder = Folder::new().with("m.toml", paper().replace("sigma = 0.00005", ""));
    assert_eq!(folder.run(&["simulate", "m.toml"], b"").status.code(), Some(2));
    let output = folder.run(&["simulate", "m.toml", "--sigma", "1e-4", "-o", "no/such/folder/t.csv"], b"");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot write"));
    assert_eq!(fs::read_dir(folder.0.path()).unwrap().count(), 1, "nothing is left behind");
}

/// What `study` prints as JSON for the paper's measurement and these further arguments.
fn study(folder: &Folder, args: &[&str]) -> Value {
    let (status, result) = folder.json(&[&["study", "m.toml", "--trials", "300"], args].concat(), b"");
    assert_eq!(status, 0, "{args:?}: {result}");
    result
}

#[test]
fn a_study_tells_how_often_frames_are_right_refused_or_wrong() {
    let folder = Folder::new().with("m.toml", paper());
    let layouts = [
        ("measurement", &[][..]),
        ("nominal", &["--layout", "nominal"]),
        ("random", &["--layout", "random"]),
    ];
    for (layout, args) in layouts {
        let result = study(&folder, args);
        let number = |key: &str| result[key].as_u64().unwrap();
        assert_eq!((&result["schema"], &result["layout"]), (&"touchref.study/1".into(), &layout.into()));
        assert_eq!((number("trials"), number("seed"), number("wrong")), (300, 0, 0), "{result}");
        assert_eq!(result["sigma"], 5e-5);
        assert!(result["solver"].is_string() && result["units"] == "mm", "{result}");
        assert_eq!(result["fixture"]["kind"], "cylinder-plane");
        assert_eq!(result["touches_per_surface"], serde_json::json!({ "cylinder": 4, "plane": 3 }));
        let refused = result["refused"].as_object().unwrap().values().map(|n| n.as_u64().unwrap());
        assert_eq!(number("accepted") + refused.sum::<u64>(), 300, "{result}");
        assert!(number("accepted") > 150, "{result}");
        for (of, u, expected) in [
            (&result["nees_mean"], &result["nees_mean_u"], 6.0),
            (&result["coverage_95"], &result["coverage_95_u"], 0.95),
        ] {
            let (of, u) = (of.as_f64().unwrap(), u.as_f64().unwrap());
            // Five standard deviations.
            assert!((of - expected).abs() < 5.0 * u, "{layout}: {of} +- {u}");
        }
        for part in ["translation", "rotation"] {
            let (ratio, u) = (&result["rms_over_bound"][part], &result["rms_over_bound_u"][part]);
            let (ratio, u) = (ratio.as_f64().unwrap(), u.as_f64().unwrap());
            assert!(ratio > 1.0 - 5.0 * u, "{layout}, {part}: {ratio} +- {u}");
        }
        let at_most = result["wrong_rate_at_most"].as_f64().unwrap() * number("accepted") as f64;
        assert!((at_most - 2.9957).abs() < 1e-3, "the rule of three: {at_most}");
    }
}

#[test]
fn a_study_depends_on_its_seed_and_on_nothing_else() {
    let folder = Folder::new().with("m.toml", paper());
    let run = |args: &[&str]| study(&folder, &[&["--layout", "random"], args].concat());
    let one = run(&["--seed", "3", "--threads", "1"]);
    assert_eq!(one, run(&["--seed", "3", "--threads", "2"]));
    assert_eq!(one, run(&["--seed", "3"]));
    assert_ne!(one["nees_mean"], run(&["--seed", "4"])["nees_mean"]);
}

#[test]
fn a_study_for_people_names_what_counts_and_shows_no_bar_in_a_pipe() {
    let folder = Folder::new().with("m.toml", paper());
    let output = folder.run(&["study", "m.toml", "--trials", "200", "--layout", "nominal"], b"");
    let (text, complaint) = (String::from_utf8(output.stdout).unwrap(), output.stderr);
    assert!(text.is_ascii() && complaint.is_empty(), "{text}{}", String::from_utf8_lossy(&complaint));
    for part in
        ["No frame was wrong.", "accepted", "95 % confidence", "NEES", "bound", "seed 0", "radius = 1.0"]
    {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn a_study_without_a_frame_has_no_numbers_to_tell() {
    let folder = Folder::new().with("m.toml", paper());
    let result = study(&folder, &["--layout", "nominal", "--sigma", "50"]);
    assert_eq!(result["accepted"], 0);
    for key in ["nees_mean", "nees_mean_u", "coverage_95", "coverage_95_u", "wrong_rate_at_most"] {
        assert!(result[key].is_null(), "{key}: {result}");
    }
    assert_eq!(result["rms_over_bound"], serde_json::json!({ "translation": null, "rotation": null }));
    let output =
        folder.run(&["study", "m.toml", "--trials", "20", "--layout", "nominal", "--sigma", "50"], b"");
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8(output.stdout).unwrap().starts_with("No frame was handed out"));
}

#[test]
fn a_study_of_a_measurement_needs_its_frame_and_a_sigma() {
    let refused = paper().replace("radius = 1.0", "radius = 1.04");
    let folder = Folder::new().with("m.toml", &refused).with("t.csv", TABLE);
    let (status, result) = folder.json(&["study", "m.toml", "--trials", "9"], b"");
    assert_eq!((status, result["error"]["code"].as_str()), (1, Some("inconsistent")), "{result}");
    // Where it stands matters to the measurement's own layout only.
    assert_eq!(study(&folder, &["--layout", "random"])["layout"], "random");

    let folder = Folder::new().with("m.toml", paper().replace("sigma = 0.00005", ""));
    for layout in ["nominal", "random", "measurement"] {
        let (status, result) = folder.json(&["study", "m.toml", "--layout", layout], b"");
        assert_eq!((status, result["error"]["key"].as_str()), (2, Some("probe.sigma")), "{result}");
        assert!(result["error"]["help"].as_str().unwrap().contains("--sigma"));
    }
    // Touches that say themselves how sure they are need no sigma of the probe.
    let table: String = TABLE
        .lines()
        .enumerate()
        .map(|(row, line)| line.to_owned() + if row == 0 { ",sigma\n" } else { ",0.00005\n" })
        .collect();
    let bare = without_touches().replace("sigma = 0.00005", "");
    let folder = Folder::new().with("m.toml", bare).with("t.csv", table);
    let result = study(&folder, &["--touches", "t.csv"]);
    assert!(result["probe"]["sigma"].is_null() && result["accepted"].as_u64() > Some(250), "{result}");
    assert!((result["sigma"].as_f64().unwrap() - 5e-5).abs() < 1e-15);
}

#[test]
fn random_touches_are_as_many_as_were_measured_or_as_asked_for() {
    let more = format!("{TABLE}plane,2.9250,3.8000,4.2148,x8\n");
    let folder = Folder::new().with("m.toml", without_touches()).with("t.csv", more);
    let counts = |args: &[&str]| {
        let result = study(&folder, &[&["--layout", "random"], args].concat());
        result["touches_per_surface"].clone()
    };
    assert_eq!(counts(&["--touches", "t.csv"]), serde_json::json!({ "cylinder": 4, "plane": 4 }));
    assert_eq!(counts(&["--touches-per-surface", "6,5"]), serde_json::json!({ "cylinder": 6, "plane": 5 }));
    assert_eq!(counts(&[]), serde_json::json!({ "cylinder": 4, "plane": 3 }));
}

#[test]
fn the_example_of_every_fixture_is_a_measurement() {
    let (_, listed) = Folder::new().json(&["list", "fixtures"], b"");
    for fixture in listed["fixtures"].as_array().unwrap() {
        let name = fixture["name"].as_str().unwrap();
        let (_, described) = Folder::new().json(&["describe", name], b"");
        let example = described["example"].as_str().unwrap();
        let output = Folder::new().run(&["locate", "-"], example.as_bytes());
        // Whether a solver trusts so few touches is its own matter: no word of the example is wrong.
        assert!(
            matches!(output.status.code(), Some(0 | 1)),
            "{name}\n{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
}

#[test]
fn everything_listed_can_be_described() {
    let (status, listed) = Folder::new().json(&["list"], b"");
    assert_eq!((status, listed["dialects"].is_array()), (0, true));
    let kinds = ["fixture", "solver", "dialect"].map(|kind| (kind, "Parameters"));
    for (kind, heading) in kinds.into_iter().chain([("log", "In a measurement file")]) {
        let list = format!("{kind}s");
        for item in listed[&list].as_array().unwrap() {
            let name = item["name"].as_str().unwrap();
            let output = Folder::new().run(&["describe", name], b"");
            let text = String::from_utf8(output.stdout).unwrap();
            assert!(text.starts_with(&format!("{kind} {name}\n")) && text.contains(heading), "{text}");
        }
    }
    let (_, only) = Folder::new().json(&["list", "dialects"], b"");
    assert!(only.get("fixtures").is_none());
}

#[test]
fn completions_and_manual_pages_come_from_the_same_definition() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.run(&["completions", shell], b"").stdout;
        assert!(String::from_utf8(script).unwrap().contains("locate"), "{shell}");
    }
    assert!(String::from_utf8(folder.run(&["man"], b"").stdout).unwrap().contains("touchref"));
    assert_eq!(folder.run(&["man", "."], b"").status.code(), Some(0));
    for page in ["touchref-locate.1", "touchref-study.1"] {
        assert!(folder.0.path().join(page).exists(), "{page}");
    }
}

#[test]
fn help_and_version_go_to_standard_output() {
    for args in
        [&["--help"][..], &["locate", "--help"], &["--version"], &["locate", "--help", "--format", "json"]]
    {
        let output = Folder::new().run(args, b"");
        assert_eq!(output.status.code(), Some(0));
        assert!(String::from_utf8(output.stdout).unwrap().contains("touchref"), "{args:?}");
    }
}

#[test]
fn a_table_of_many_rows_is_read() {
    use std::fmt::Write as _;
    let mut table = String::from("surface,x,y,z\n");
    for row in 0..200_000 {
        writeln!(table, "plane,{row},1,2").unwrap();
    }
    table.push_str("plane,1,2,oops\n");
    let folder = Folder::new().with("m.toml", without_touches());
    let (status, result) = folder.json(&["locate", "m.toml", "--touches", "-"], table.as_bytes());
    assert_eq!((status, result["error"]["line"].as_u64()), (2, Some(200_002)), "{result}");
}

#[test]
fn a_reader_that_has_enough_ends_the_command_quietly() {
    let folder = Folder::new().with("m.toml", paper());
    let mut child = Command::new(assert_cmd::cargo::cargo_bin!("touchref"))
        .current_dir(folder.0.path())
        .args(["simulate", "m.toml", "--count", "100000"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Closing the pipe unread is what `| head` does after its lines.
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}
