//! Touches from machines' logs: each format gives the paper's frame; what a log does not tell, or tells wrongly, is an
//! error with its place.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{fs, path::Path};

use common::{Folder, paper, without_touches};
use rayon::prelude::*;
use serde_json::Value;

/// Each log of the paper's touches, and how it is mapped.
const LOGS: &[(&str, &str)] = &[
    (
        "probe.dat",
        "format = \"kuka-dat\"\nbase = 3\ntool = 1\n\
         touch = [{ surface = \"cylinder\", points = [\"XP1\", \"XP2\"], rows = \"4-5\" }, \
         { surface = \"plane\", points = [\"XP5\", \"XP6\", \"XP7\"] }]\nignore = { points = [\"XHOME\"] }",
    ),
    (
        "probe.mod",
        "format = \"abb-mod\"\nbase = \"wRef\"\n\
         touch = [{ surface = \"cylinder\", points = [\"p1\", \"p2\", \"p3\", \"p4\"] }, \
         { surface = \"plane\", points = [\"plane_touch{1}\", \"plane_touch{2}\", \"plane_touch{3}\"] }]\n\
         ignore = { points = [\"jHome\"] }",
    ),
    (
        "probe.ls",
        "format = \"fanuc-ls\"\nbase = 2\n\
         touch = [{ surface = \"cylinder\", points = [\"P[1]\", \"P[2]\", \"P[3]\", \"P[4]\"] }, \
         { surface = \"plane\", rows = \"5, 6, 7\" }]\nignore = { rows = \"8\" }",
    ),
    (
        "posreg.va",
        "format = \"fanuc-posreg\"\nbase = 2\nunits = \"mm\"\n\
         touch = [{ surface = \"cylinder\", points = [\"PR[2]\", \"PR[3]\", \"PR[4]\", \"PR[5]\"] }, \
         { surface = \"plane\", rows = \"6-8\" }]\nignore = { rows = \"1\" }",
    ),
    (
        "probe.script",
        "format = \"urscript\"\nbase = \"base\"\n\
         touch = [{ surface = \"plane\", points = [\"touch_5\", \"touch_6\", \"touch_7\"] }, \
         { surface = \"cylinder\", rows = \"1-4\" }]\nignore = { rows = \"8\" }",
    ),
    ("rtde.csv", "format = \"ur-rtde\"\n{rows}"),
    ("probe-results.txt", "format = \"linuxcnc-probe\"\nunits = \"mm\"\nbase = \"G54\"\n{rows}"),
    (
        "grbl.log",
        "format = \"grbl\"\ntouch = [{ surface = \"cylinder\", rows = \"1-4\" }, \
         { surface = \"plane\", rows = \"6-8\" }]\nignore = { rows = \"5\" }",
    ),
    (
        "probe.dmo",
        "format = \"dmis\"\nbase = \"MCS\"\ncompensated = true\n\
         touch = [{ surface = \"cylinder\", points = [\"T1\", \"T2\", \"T3\", \"T4\"] }, \
         { surface = \"plane\", rows = \"5-7\" }]",
    ),
    (
        "export.csv",
        "format = \"csv\"\nunits = \"mm\"\nbase = 0\n\
         columns = { at = [\"X [mm]\", \"Y [mm]\", \"Z [mm]\"], name = \"Punkt\" }\n{rows}",
    ),
];

/// The mapping of logs that have the seven touches and nothing else.
const ROWS: &str =
    "touch = [{ surface = \"cylinder\", rows = \"1-4\" }, { surface = \"plane\", rows = \"5-7\" }]";

fn log(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/logs").join(name)).unwrap()
}

/// The paper's measurement with its touches in a log; `section` goes below the name of the file.
fn measurement(file: &str, section: &str) -> String {
    format!("{}[log]\nfile = \"{file}\"\n{}\n", without_touches(), section.replace("{rows}", ROWS))
}

/// Line of the first key of the section `[log]`.
fn first_line() -> u64 {
    without_touches().lines().count() as u64 + 2
}

fn locate(file: &str, log: &str, measurement: &str) -> (i32, Value) {
    let folder = Folder::new().with(file, log).with("m.toml", measurement);
    folder.json(&["locate", "m.toml"], b"")
}

/// The numbers of a frame.
fn matrix(result: &Value) -> Vec<f64> {
    let rows = result["frame"]["matrix"].as_array().unwrap();
    rows.iter().flat_map(|row| row.as_array().unwrap()).map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn a_log_of_each_format_locates_to_the_frame_of_the_paper() {
    // Lengths from metres are rounded twice; the solver's own steps end within its tolerance.
    const SAME: f64 = 1e-9;
    let (_, expected) = Folder::new().with("m.toml", paper()).json(&["locate", "m.toml"], b"");
    let (_, listed) = Folder::new().json(&["list", "logs"], b"");
    assert_eq!(listed["logs"].as_array().unwrap().len(), LOGS.len(), "every format has a log");
    LOGS.par_iter().for_each(|(file, section)| {
        for units in ["mm", "m"] {
            let measurement = measurement(file, section);
            let scale = if units == "m" { 1e-3 } else { 1.0 };
            let measurement = if units == "m" {
                let metres = measurement.replacen("units = \"mm\"", "units = \"m\"", 1);
                metres.replace("radius = 1.0", "radius = 0.001").replace("0.00005", "0.00000005")
            } else {
                measurement
            };
            let (status, result) = locate(file, &log(file), &measurement);
            assert_eq!(status, 0, "{file}: {result}");
            for (index, (found, expected)) in matrix(&result).iter().zip(matrix(&expected)).enumerate() {
                let expected = if index % 4 == 3 && index < 12 { expected * scale } else { expected };
                assert!((found - expected).abs() < SAME, "{file} in {units}: {found}, {expected}");
            }
        }
    });
}

#[test]
fn touches_keep_the_names_and_order_of_the_log() {
    let ids = |file: &str| {
        let (_, section) = LOGS.iter().find(|(name, _)| *name == file).unwrap();
        let (_, result) = locate(file, &log(file), &measurement(file, section));
        let touches = result["touches"].as_array().unwrap().clone();
        touches.iter().map(|touch| touch["id"].as_str().unwrap().to_owned()).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(ids("probe.dat"), "XP1 XP2 XP3 XP4 XP5 XP6 XP7");
    assert_eq!(ids("probe.script"), "touch_1 touch_2 touch_3 touch_4 touch_5 touch_6 touch_7");
    assert_eq!(ids("grbl.log"), "1 2 3 4 6 7 8");
    assert_eq!(ids("probe.dmo"), "T1 T2 T3 T4 5 6 7");
}

#[test]
fn the_example_is_located_and_its_points_listed() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/logs");
    let path = |name: &str| examples.join(name).to_str().unwrap().to_owned();
    let (status, result) = Folder::new().json(&["locate", &path("kuka.toml")], b"");
    assert_eq!((status, result["touches"].as_array().unwrap().len()), (0, 7), "{result}");
    let (status, listed) = Folder::new().json(&["log", &path("grbl.log"), "--from", "grbl"], b"");
    assert_eq!((status, &listed["schema"]), (0, &Value::from("touchref.log/1")));
    let (fifth, sixth) = (&listed["points"][4], &listed["points"][5]);
    assert_eq!((fifth["row"].as_u64(), fifth["at"].is_null()), (Some(5), true));
    assert!(fifth["unusable"].as_str().unwrap().contains("missed"));
    assert_eq!(sixth["at"], serde_json::json!([2.825, 2.4, 4.0395]));
    let text = Folder::new().run(&["log", &path("probe.dat"), "--from", "kuka-dat"], b"");
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.contains("XP7") && text.contains("joint angles") && text.is_ascii(), "{text}");
    let table = ["log", &path("export.csv"), "--from", "csv", "--columns", "X [mm],Y [mm],Z [mm]"];
    let (status, listed) = Folder::new().json(&table, b"");
    assert_eq!((status, listed["points"].as_array().unwrap().len()), (0, 7), "{listed}");
}

#[test]
fn a_frame_that_only_the_log_tells_is_told() {
    let (file, section) = LOGS[0];
    let (status, result) = locate(file, &log(file), &measurement(file, &section.replace("base = 3\n", "")));
    assert_eq!(status, 0, "{result}");
    let warnings = result["warnings"].to_string();
    assert!(warnings.contains("log-frame") && warnings.contains("base 3, taken with tool 1"), "{warnings}");
}

#[test]
fn placements_may_be_logs() {
    let placement = |file: &str| {
        format!(
            "[[placement]]\n[placement.log]\nfile = \"{file}\"\nformat = \"linuxcnc-probe\"\nunits = \"mm\"\nbase = \"G54\"\n{ROWS}\n"
        )
    };
    let text = format!("{}{}{}", without_touches(), placement("a.txt"), placement("b.txt"));
    let folder = Folder::new().with("a.txt", log("probe-results.txt")).with("m.toml", text);
    let (status, error) = folder.json(&["calibrate", "m.toml"], b"");
    assert_eq!((status, &error["error"]["code"]), (2, &Value::from("unreadable")), "{error}");
    assert!(error["error"]["file"].as_str().unwrap().contains("b.txt"), "{error}");
}

/// A part of a log and what it is replaced by, a part of its section and what it is replaced by; then what is told:
/// log | part | replacement | part of the section | replacement | code | file, line, what it points to | key | nearest
///
/// In the section the line counts from its first key on, from 0.
const WRONG: &str = r#"
probe.dat | | | points = ["XP1", | points = ["XP11", | unknown-point | m.toml 3 "XP11" | log.touch[0].points[0] | XP1
probe.dat | | | "XP2"], rows = "4-5" | "XP1"], rows = "3-5" | invalid-input | m.toml 3 "XP1" | log.touch[0].points[1] |
probe.dat | | | rows = "4-5" | rows = "3-5" | invalid-input | m.toml 3 "3-5" | log.touch[0].rows |
probe.dat | | | rows = "4-5" | rows = "5" | invalid-input | probe.dat 19 XP3 | log.touch |
probe.dat | | | rows = "4-5" | rows = "5-4" | invalid-input | m.toml 3 "5-4" | log.touch[0].rows |
probe.dat | | | rows = "4-5" | rows = "0-4" | invalid-input | m.toml 3 "0-4" | log.touch[0].rows |
probe.dat | | | rows = "4-5" | rows = "4-5, 9" | invalid-input | m.toml 3 "4-5, 9" | log.touch[0].rows |
probe.dat | | | rows = "4-5" | row = "4-5" | unknown-key | m.toml 3 row | log.touch[0].row | rows
probe.dat | | | "plane", points | "plain", points | unknown-surface | m.toml 3 "plain" | log.touch[1].surface | plane
probe.dat | | | ignore = { points = ["XHOME"] } | | invalid-input | probe.dat 12 XHOME | log.touch |
probe.dat | | | ignore = { points = ["XHOME"] } | ignore = { points = ["XHOME", "XP7"] } | invalid-input | m.toml 4 "XP7" | log.ignore.points[1] |
probe.dat | | | points = ["XP1", "XP2"] | points = ["XHOME", "XP1", "XP2"] | invalid-input | m.toml 4 "XHOME" | log.ignore.points[0] |
probe.dat | | | base = 3 | base = 2 | invalid-input | probe.dat 14 XP1 | log.base |
probe.dat | | | tool = 1 | tool = 2 | invalid-input | probe.dat 14 XP1 | log.tool |
probe.dat | | | base = 3 | base = -1 | invalid-input | m.toml 1 -1 | log.base |
probe.dat | FP6={TOOL_NO 1,BASE_NO 3 | FP6={TOOL_NO 1,BASE_NO 0 | base = 3\n | | invalid-input | probe.dat 25 XP6 | log.base |
probe.dat | FP6={TOOL_NO 1 | FP6={TOOL_NO 2 | tool = 1\n | | invalid-input | probe.dat 25 XP6 | log.tool |
probe.dat | DECL FDAT FP7 | ;DECL FDAT FP7 | | | invalid-input | probe.dat 27 XP7 | log.base |
probe.dat | BASE_NO 3,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}\nDECL E6POS XP6 | BASE_NO 3,IPO_FRAME #TCP,POINT2[] " "}\nDECL E6POS XP6 | | | invalid-input | probe.dat 24 #TCP | log.touch[1] |
probe.dat | XP6={X 3.9020,Y 5.2000,Z 4.0353 | XP6={X 2.8250,Y 2.4000,Z 4.0395 | "XP5", "XP6", | "XP5", | invalid-input | probe.dat 25 XP6 | log.touch |
probe.dat | XP5={X 2.8250,Y 2.4000,Z 4.0395 | XP5={X 3.5270,Y 3.2000,Z 3.1082 | | | invalid-input | probe.dat 23 XP5 | |
probe.dat | XP3= | XP2= | | | invalid-input | m.toml 3 "XP2" | log.touch[0].points[1] |
probe.dat | | | format = "kuka-dat" | format = "kuka-dta" | unknown-log | m.toml 0 "kuka-dta" | log.format | kuka-dat
probe.dat | | | format = "kuka-dat"\n | | missing-key | m.toml -2 [log] | log.format |
probe.dat | | | format = "kuka-dat" | formt = "kuka" | unknown-key | m.toml 0 formt | log.formt | format
probe.dat | | | format = "kuka-dat" | format = "kuka-dat"\nunits = "in" | invalid-input | m.toml 1 "in" | log.units |
probe.dat | | | format = "kuka-dat" | format = "kuka-dat"\nunits = "inch" | invalid-input | m.toml 1 "inch" | log.units | in
probe.dat | | | format = "kuka-dat" | format = "kuka-dat"\ncolumns = { at = [1, 2, 3] } | invalid-input | m.toml 1 { at = [1, 2, 3] } | log.columns |
probe.dat | | | format = "kuka-dat" | format = "kuka-dat"\ncompensated = 1 | invalid-input | m.toml 1 1 | log.compensated |
probe.dat | DEFDAT | DEF\xffDAT | | | invalid-input | probe.dat 4 | |
probe.mod | | | base = "wRef"\n | | missing-key | m.toml -2 [log] | log.base |
probe.mod | [0,0.707107,0.707107,0],\n | [0,0,0,0],\n | | | invalid-input | probe.mod 11 [0,0,0,0] | log.touch[0] |
probe.mod | 2.4,4.0395] | 2.4,9E9] | | | invalid-input | probe.mod 14 [2.825,2.4,9E9] | log.touch[1] |
probe.mod | | | points = ["jHome"] | points = ["jHome", "pNext"] | | | |
probe.mod | | | "plane_touch{2}", | "pNext", "plane_touch{2}", | invalid-input | probe.mod 17 pNext | log.touch[1] |
probe.ls | UF : 2, UT : 4,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX =     2.8250 | UF : 1, UT : 4,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX =     2.8250 | base = 2\n | | invalid-input | probe.ls 44 P[5] | log.base |
probe.ls | Y =     5.2000 | Y =  ******** | | | invalid-input | probe.ls 53 ******** | log.touch[1] |
probe.ls | | | ignore = { rows = "8" } | ignore = { rows = "9" } | invalid-input | m.toml 3 "9" | log.ignore.rows |
posreg.va | | | base = 2\n | | missing-key | m.toml -2 [log] | log.base |
posreg.va | | | rows = "6-8" | rows = "6-9" | invalid-input | posreg.va 35 [1,9] | log.touch[1] |
posreg.va | Y:     5.2000   Z:     4.0353 | Y: ****   Z:     4.0353 | | | invalid-input | posreg.va 29 **** | log.touch[1] |
probe.script | | | base = "base"\n | | missing-key | m.toml -2 [log] | log.base |
probe.script | | | ignore = { rows = "8" } | | invalid-input | probe.script 10 p[0.1, 0.2, 0.3, 2.2214, -2.2214, 0.0] | log.touch |
probe.script | p[0.0028250, 0.0024000, 0.0040395 | p[2825.0, 2400.0, 4039.5 | | | invalid-input | probe.script 7 p[2825.0, 2400.0, 4039.5, 2.2214, -2.2214, 0.0] | log.touch[0] |
rtde.csv | 0.0029270 | 0,0029270 | | | invalid-input | rtde.csv 2 0,0029270 | log.touch[0] |
rtde.csv | actual_TCP_pose_0 | tcp_0 | | | missing-column | rtde.csv | actual_TCP_pose_0 |
rtde.csv | | | format = "ur-rtde" | format = "ur-rtde"\nbase = "base" | invalid-input | m.toml 1 "base" | log.base |
rtde.csv | | | format = "ur-rtde" | format = "ur-rtde"\nunits = "mm" | invalid-input | m.toml 1 "mm" | log.units |
probe-results.txt | | | units = "mm"\n | | missing-key | m.toml -2 [log] | log.units |
probe-results.txt | | | base = "G54"\n | | missing-key | m.toml -2 [log] | log.base |
probe-results.txt | 2.825000 2.400000 4.039500 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000\n | | | | invalid-input | m.toml 3 "5-7" | log.touch[1].rows |
probe-results.txt | 2.825000 2.400000 | 2.825000 | | | invalid-input | probe-results.txt 5 2.825000 4.039500 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000 | |
probe-results.txt | | | rows = "5-7" | points = ["P5"] | unknown-point | m.toml 3 "P5" | log.touch[1].points[0] |
grbl.log | | | rows = "6-8" | rows = "5-8" | invalid-input | m.toml 2 "5" | log.ignore.rows |
grbl.log | 3.1166:1] | 3.1166:0] | | | invalid-input | grbl.log 12 0 | log.touch[0] |
grbl.log | | | \nignore = { rows = "5" } | | invalid-input | grbl.log 16 [PRB:2.8250,2.4000,-20.0000:0] | log.touch |
grbl.log | $13=0 | $13=1 | format = "grbl" | format = "grbl"\nunits = "mm" | invalid-input | m.toml 1 "mm" | log.units |
grbl.log | $13=0 | $12=0 | | | missing-key | m.toml -2 [log] | log.units |
probe.dmo | UNITS/MM | UNITS/CM | | | invalid-input | probe.dmo 3 CM | |
probe.dmo | UNITS/MM,ANGDEC\n | | | | missing-key | m.toml -2 [log] | log.units |
probe.dmo | MEAS/PLANE | GOTO/1,2,3\nMEAS/PLANE | | | invalid-input | probe.dmo 15 PTMEAS/CART,2.8250,2.4000,4.0395,0.3,0.5,0.8 | log.touch[1] |
probe.dmo | MEAS/PLANE | D(PART)=DATSET/DAT(A)\nMEAS/PLANE | base = "MCS"\n | | invalid-input | probe.dmo 15 PTMEAS/CART,2.8250,2.4000,4.0395,0.3,0.5,0.8 | log.base |
export.csv | | | units = "mm"\n | | missing-key | m.toml -2 [log] | log.units |
export.csv | | | "Y [mm]" | "Y" | missing-column | export.csv 1 | Y | Y [mm]
export.csv | 2,4000 | 2.400,0 | | | invalid-input | export.csv 6 2.400,0 | log.touch[1] |
export.csv | | | columns = { at = ["X [mm]", "Y [mm]", "Z [mm]"], name = "Punkt" }\n | | missing-key | m.toml -2 [log] | log.columns |
export.csv | | | name = "Punkt" | name = 1 | invalid-input | m.toml 3 { at = ["X [mm]", "Y [mm]", "Z [mm]"], name = 1 } | log.columns |
export.csv | | | name = "Punkt" | approach = ["X [mm]", "Y [mm]"] | invalid-input | m.toml 3 ["X [mm]", "Y [mm]"] | log.columns.approach |
"#;

/// A row of the table, its columns trimmed of the blanks around them.
struct Wrong {
    log: String,
    text: Vec<u8>,
    measurement: String,
    told: [String; 4],
}

fn wrong_cases() -> Vec<Wrong> {
    let escaped = |text: &str| text.trim().replace("\\n", "\n").replace("\\t", "\t");
    let rows = WRONG.lines().filter(|line| !line.is_empty()).map(|line| {
        let fields: Vec<String> = line.split(" |").map(escaped).collect();
        let [file, from, to, section_from, section_to, told @ ..] = fields.as_slice() else {
            panic!("{line}")
        };
        let (_, section) = LOGS.iter().find(|(name, _)| name == file).unwrap();
        let section = section.replace("{rows}", ROWS);
        assert!(section.contains(section_from.as_str()) && log(file).contains(from.as_str()), "{line}");
        let text = if from.is_empty() { log(file) } else { log(file).replacen(from, to, 1) };
        let section =
            if section_from.is_empty() { section } else { section.replacen(section_from, section_to, 1) };
        let bytes = match text.split_once("\\xff") {
            Some((before, after)) => [before.as_bytes(), b"\xff", after.as_bytes()].concat(),
            None => text.into_bytes(),
        };
        let mut told = told.to_vec();
        told.resize(4, String::new());
        Wrong {
            log: file.clone(),
            text: bytes,
            measurement: measurement(file, &section),
            told: told.try_into().unwrap(),
        }
    });
    rows.collect()
}

/// What an error points to; its line and column are those of its offset. Nothing where the whole line is meant.
fn pointed_to(content: &[u8], error: &Value) -> String {
    let [line, offset, length] =
        ["line", "offset", "length"].map(|key| usize::try_from(error[key].as_u64().unwrap()).unwrap());
    let before = String::from_utf8_lossy(&content[..offset]);
    let before = before.trim_start_matches('\u{feff}');
    assert_eq!(line, before.matches('\n').count() + 1, "{error}");
    let Some(column) = error["column"].as_u64().map(|column| usize::try_from(column).unwrap()) else {
        return String::new();
    };
    assert_eq!(column, before.chars().rev().take_while(|c| *c != '\n').count() + 1, "{error}");
    let text = String::from_utf8_lossy(&content[offset..offset + length]).into_owned();
    text.lines().next().unwrap_or("").to_owned()
}

#[test]
fn what_a_log_or_its_mapping_gets_wrong_is_told_with_its_place() {
    let complaints: Vec<String> = wrong_cases()
        .par_iter()
        .filter_map(|case| {
            let folder = Folder::new().with(&case.log, &case.text).with("m.toml", &case.measurement);
            let (status, printed) = folder.json(&["locate", "m.toml"], b"");
            let error = &printed["error"];
            let text = |key: &str| error[key].as_str().unwrap_or("").to_owned();
            let content = if text("file") == "m.toml" { case.measurement.as_bytes() } else { &case.text };
            let place = match error["line"].as_i64() {
                None => text("file"),
                Some(line) => {
                    let from =
                        if text("file") == "m.toml" { i64::try_from(first_line()).unwrap() + 1 } else { 0 };
                    format!("{} {} {}", text("file"), line - from, pointed_to(content, error))
                        .trim()
                        .to_owned()
                }
            };
            let told = [text("code"), place, text("key"), text("nearest")];
            let expected_status = if case.told[0].is_empty() { 0 } else { 2 };
            (told != case.told || status != expected_status)
                .then(|| format!("{}: {told:?}, expected {:?}: {}", case.log, case.told, error["message"]))
        })
        .collect();
    assert!(complaints.is_empty(), "{} cases\n{}", complaints.len(), complaints.join("\n"));
}

#[test]
fn a_tip_with_a_radius_needs_tip_centres() {
    let case = |file: &str, section: &str, radius: &str| {
        let folder = Folder::new().with(file, log(file)).with("m.toml", measurement(file, section));
        let (_, printed) = folder.json(&["locate", "m.toml", "--tip-radius", radius], b"");
        (printed["error"]["code"].clone(), printed["error"]["key"].clone())
    };
    let (file, section) = LOGS[8];
    let none = (Value::Null, Value::Null);
    assert_eq!(case(file, section, "0.0"), none);
    assert_eq!(case(file, section, "0.1"), ("invalid-input".into(), "log.compensated".into()));
    let open = section.replace("compensated = true\n", "");
    assert_eq!(case(file, &open, "0.0"), none);
    assert_eq!(case(file, &open, "0.1"), ("missing-key".into(), "log.compensated".into()));
    // A robot's position is that of its tool centre point: nothing is refused for the tip.
    let (file, section) = LOGS[0];
    assert_ne!(case(file, section, "0.1").1, Value::from("log.compensated"));
}

#[test]
fn one_place_touched_twice_is_told() {
    let (file, section) = LOGS[6];
    let repeated = format!("{}2.048000 5.200000 4.785300 0 0 0 0 0 0\n", log(file));
    let section = measurement(file, section).replace("5-7", "5-8");
    let (status, result) = locate(file, &repeated, &section);
    assert_eq!(status, 0, "{result}");
    assert!(result["warnings"].to_string().contains("repeated-touch"), "{result}");
}

#[test]
fn calls_of_log_are_checked() {
    let folder = Folder::new().with("a.txt", "X,Y,Z\n1.0,2,3\n");
    let code = |args: &[&str]| {
        let (status, printed) = folder.json(args, b"");
        assert_eq!(status, 2, "{printed}");
        let text = |key: &str| printed["error"][key].as_str().unwrap_or("").to_owned();
        format!("{} {} {}", text("code"), text("key"), text("nearest"))
    };
    assert_eq!(code(&["log", "a.txt", "--from", "csv"]), "invalid-input columns ");
    assert_eq!(code(&["log", "a.txt", "--from", "grbl", "--columns", "1,2,3"]), "invalid-input columns ");
    assert_eq!(code(&["log", "a.txt", "--from", "csv", "--columns", "X,Y"]), "usage --columns <X,Y,Z> ");
    assert_eq!(code(&["log", "a.txt", "--from", "csv", "--columns", "X,Y,ZZ"]), "missing-column ZZ Z");
    assert_eq!(code(&["log", "a.txt", "--from", "kuka-dta"]), "usage --from <FORMAT> kuka-dat");
    assert_eq!(code(&["log", "none.txt", "--from", "kuka-dat"]), "unreadable  ");
    assert_eq!(code(&["log", "a.txt", "--from", "kuka-dat"]), "too-few-touches  ");
    assert_eq!(code(&["describe", "kuka-dta"]), "unknown-name name kuka-dat");
    let (status, described) = folder.json(&["describe", "grbl"], b"");
    assert_eq!(
        (status, &described["kind"], &described["frame"]),
        (0, &"log".into(), &"machine coordinates".into())
    );
}
