//! `--dialect` as a user types it.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::fmt::Write;

use common::{Folder, paper};
use serde_json::Value;

/// How each of the listed dialects is asked for: `euler` needs to be told more.
fn asked_for(listed: &Value) -> Vec<String> {
    let names = listed["dialects"].as_array().unwrap().iter().map(|item| item["name"].as_str().unwrap());
    names
        .map(|name| if name == "euler" { "euler:zyx:intrinsic:deg".to_owned() } else { name.to_owned() })
        .collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// All but the one that cannot: the paper's fixture is tilted.
#[test]
fn everything_listed_tells_the_papers_frame() {
    let folder = Folder::new().with("m.toml", paper());
    let (_, listed) = folder.json(&["list", "dialects"], b"");
    let names: Vec<String> = asked_for(&listed).into_iter().filter(|name| name != "linuxcnc").collect();
    assert!(names.len() > 20, "{names:?}");
    let mut args = vec!["locate", "m.toml"];
    for name in &names {
        args.extend(["--dialect", name]);
    }
    let (status, result) = folder.json(&args, b"");
    assert_eq!(status, 0, "{result}");
    let text = String::from_utf8(folder.run(&args, b"").stdout).unwrap();
    for name in &names {
        let (literal, note) = (result["dialects"][name].as_str().unwrap(), &result["dialect_notes"][name]);
        // To copy: as it is, at the margin.
        assert!(text.contains(&format!("For {name}\n{literal}\n")), "{name}: {text}");
        for key in ["parent", "units", "convention", "digits", "usage"] {
            assert!(!note[key].as_str().unwrap().is_empty(), "{name}: {key} of {note}");
        }
        let loss = note["rounding_loss"].as_f64().unwrap();
        assert!((0.0..1e-3).contains(&loss), "{name}: {note}");
        assert!((note["farthest_touch"].as_f64().unwrap() - 3.162).abs() < 1e-3, "{name}: {note}");
    }
    assert_eq!(result["dialects"].as_object().unwrap().len(), names.len());
    assert!(text.contains("read back, it differs from the frame by at most 0 mm"), "{text}");

    // The same frame as in the rest of the record.
    let kuka = result["dialects"]["kuka"].as_str().unwrap();
    assert_eq!(kuka, "{X 2.9000,Y 3.8000,Z 4.2249,A 105.709081,B 33.794454,C 26.824111}");
    let matrix: Value = serde_json::from_str(result["dialects"]["matrix"].as_str().unwrap()).unwrap();
    for (row, expected) in
        matrix.as_array().unwrap().iter().zip(result["frame"]["matrix"].as_array().unwrap())
    {
        assert_eq!(numbers(row), numbers(expected));
    }
    assert!(result["dialect_notes"]["matrix"]["rounding_loss"] == 0.0);
}

/// What `quaternion` prints is what `--near` takes.
#[test]
fn a_frame_goes_out_and_in() {
    let folder = Folder::new().with("m.toml", paper());
    let (_, result) = folder.json(&["locate", "m.toml", "--dialect", "quaternion"], b"");
    let literal = result["dialects"]["quaternion"].as_str().unwrap();
    let (status, _) = folder.json(&["locate", "m.toml", "--near", literal], b"");
    assert_eq!(status, 0);
}

#[test]
fn without_dialects_the_record_is_as_before() {
    let (_, result) = Folder::new().with("m.toml", paper()).json(&["locate", "m.toml"], b"");
    assert_eq!(result["dialects"], serde_json::json!({}));
    assert!(result.get("dialect_notes").is_none());
}

#[test]
fn a_tilt_is_refused_with_its_size() {
    let folder = Folder::new().with("m.toml", paper());
    let args = ["locate", "m.toml", "--dialect", "kuka", "--dialect", "linuxcnc"];
    let (status, result) = folder.json(&args, b"");
    let error = &result["error"];
    assert_eq!(
        (status, error["code"].as_str(), error["key"].as_str()),
        (1, Some("not-representable"), Some("dialect"))
    );
    // The angle between the axis of the paper and Z.
    let tilt = 0.7416_f64.acos().to_degrees();
    assert!((error["value"].as_f64().unwrap() - tilt).abs() < 0.01, "{error}");
    assert!(error["bound"].as_f64().unwrap() < 0.0011, "{error}");
    let output = folder.run(&args, b"");
    assert!(output.stdout.is_empty() && output.status.code() == Some(1));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("tilt of 42.13") && told.contains("linuxcnc-g68"), "{told}");
}

/// A cube that stands level, its corner at the origin.
#[test]
fn a_level_fixture_is_a_work_offset() {
    const TABLE: &str = "surface,x,y,z\n+z,-10,-10,1.5\n+z,-40,-10,1.5\n+z,-10,-40,1.5\n+y,-10,1.5,-10\n\
                         +y,-40,1.5,-10\n+x,1.5,-10,-10\n";
    let args =
        "locate --fixture cube -p edge=50 --touches - --tip-radius 1.5 --sigma 0.005 --dialect linuxcnc:3";
    let (status, result) = Folder::new().json(&args.split(' ').collect::<Vec<_>>(), TABLE.as_bytes());
    assert_eq!(status, 0, "{result}");
    let literal = "G21\nG10 L2 P3 X0.000000 Y0.000000 Z0.000000 R0.000000";
    assert_eq!(result["dialects"]["linuxcnc:3"], literal);
    assert_eq!(result["dialect_notes"]["linuxcnc:3"]["leaves_out"], "tilt");
}

#[test]
fn names_and_values_that_are_wrong_are_told() {
    let folder = Folder::new().with("m.toml", paper());
    for (name, code, nearest) in [
        ("kukka", "unknown-dialect", Some("kuka")),
        ("ros", "unknown-dialect", Some("ros2")),
        ("euler:zyy:intrinsic:deg", "invalid-input", Some("zyx")),
        ("euler", "invalid-input", None),
        ("fanuc:0", "invalid-input", None),
    ] {
        let (status, result) = folder.json(&["locate", "m.toml", "--dialect", name], b"");
        let error = &result["error"];
        assert_eq!(
            (status, error["code"].as_str(), error["nearest"].as_str()),
            (2, Some(code), nearest),
            "{error}"
        );
        assert_eq!(error["key"], "dialect", "{error}");
    }
}

#[test]
fn everything_listed_can_be_described() {
    let folder = Folder::new();
    let (_, listed) = folder.json(&["list", "dialects"], b"");
    for item in listed["dialects"].as_array().unwrap() {
        let name = item["name"].as_str().unwrap();
        let (status, described) = folder.json(&["describe", name], b"");
        assert_eq!((status, described["kind"].as_str()), (0, Some("dialect")), "{described}");
        assert!(described["call"].as_str().unwrap().starts_with(name), "{described}");
        let output = folder.run(&["describe", name], b"");
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.contains(described["example"].as_str().unwrap()), "{text}");
    }
    let (_, euler) = folder.json(&["describe", "euler"], b"");
    assert_eq!(euler["call"], "euler:<order>:<intrinsic|extrinsic>:<deg|rad>");
    let (_, error) = folder.json(&["describe", "kukka"], b"");
    assert_eq!(error["error"]["nearest"], "kuka");
}

/// The example of Siemens' `MEAFRAME` (SINUMERIK job planning manual): three ideal points and where they were measured.
///
/// A point is three planes through it, so that the misfit is the points' squared distances. The expected numbers are those
/// of W. Kabsch's closed form by a singular value decomposition, made without touchref; what the control's own measure of
/// quality is made of is not published.
#[test]
fn the_points_of_meaframe_are_fitted() {
    const IDEAL: [[f64; 3]; 3] = [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
    const MEASURED: [[f64; 3]; 3] = [[10.1, 0.2, -0.2], [-0.2, 10.2, 0.1], [-0.2, 0.2, 9.8]];
    let (mut surfaces, mut touches) = (String::new(), String::new());
    for (number, (ideal, measured)) in IDEAL.iter().zip(MEASURED).enumerate() {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let name = format!("{name}{number}");
            let normal = [0, 1, 2].map(|other| f64::from(u8::from(other == axis)));
            writeln!(surfaces, "[[fixture.surface]]\nname = {name:?}\ntype = \"plane\"").unwrap();
            writeln!(surfaces, "point = {ideal:?}\nnormal = {normal:?}").unwrap();
            writeln!(touches, "[[touch]]\nsurface = {name:?}\nat = {measured:?}").unwrap();
        }
    }
    let measurement =
        format!("units = \"mm\"\n[fixture]\nkind = \"composite\"\n{surfaces}[probe]\nsigma = 0.2\n{touches}");
    let folder = Folder::new().with("m.toml", &measurement);
    let (status, result) = folder
        .json(&["locate", "m.toml", "--dialect", "siemens", "--dialect", "euler:zyx:intrinsic:deg"], b"");
    assert_eq!(status, 0, "{result}");
    assert_eq!(
        result["dialects"]["siemens"],
        "$P_UIFR[1]=CTRANS(X,-0.0676,Y,0.2353,Z,-0.1667):CROT(X,0.867468,Y,-0.285879,Z,0.268755)"
    );
    let found = result["dialects"]["euler:zyx:intrinsic:deg"].as_str().unwrap();
    let found: Vec<f64> = found.split_whitespace().map(|number| number.parse().unwrap()).collect();
    let expected = [-0.067_644, 0.235_327, -0.166_673, 0.268_755, -0.285_879, 0.867_468];
    for (found, expected) in found.iter().zip(expected) {
        // Half a unit of the expected number's last digit, and the rounding of that.
        assert!((found - expected).abs() < 0.501e-6, "{found} and {expected}");
    }
}
