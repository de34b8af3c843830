use proptest::{prelude::*, sample::Index, test_runner::RngSeed};

use super::*;

/// A log of each format, with the paper's seven touches in it: format, name, text, row of each touch from 1, factor from
/// the log's unit to the paper's.
type Sample = (&'static str, &'static str, &'static str, [usize; 7], f64);

const SAMPLES: &[Sample] = &[
    ("kuka-dat", "probe.dat", include_str!("../../../examples/logs/probe.dat"), [2, 3, 4, 5, 6, 7, 8], 1.0),
    ("abb-mod", "probe.mod", include_str!("../../../examples/logs/probe.mod"), [2, 3, 4, 5, 6, 7, 8], 1.0),
    ("fanuc-ls", "probe.ls", include_str!("../../../examples/logs/probe.ls"), [1, 2, 3, 4, 5, 6, 7], 1.0),
    (
        "fanuc-posreg",
        "posreg.va",
        include_str!("../../../examples/logs/posreg.va"),
        [2, 3, 4, 5, 6, 7, 8],
        1.0,
    ),
    (
        "urscript",
        "probe.script",
        include_str!("../../../examples/logs/probe.script"),
        [1, 2, 3, 4, 5, 6, 7],
        1e3,
    ),
    ("ur-rtde", "rtde.csv", include_str!("../../../examples/logs/rtde.csv"), [1, 2, 3, 4, 5, 6, 7], 1e3),
    (
        "linuxcnc-probe",
        "probe-results.txt",
        include_str!("../../../examples/logs/probe-results.txt"),
        [1, 2, 3, 4, 5, 6, 7],
        1.0,
    ),
    ("grbl", "grbl.log", include_str!("../../../examples/logs/grbl.log"), [1, 2, 3, 4, 6, 7, 8], 1.0),
    ("dmis", "probe.dmo", include_str!("../../../examples/logs/probe.dmo"), [1, 2, 3, 4, 5, 6, 7], 1.0),
    ("csv", "export.csv", include_str!("../../../examples/logs/export.csv"), [1, 2, 3, 4, 5, 6, 7], 1.0),
];

/// The paper's touches.
const PAPER: [[f64; 3]; 7] = [
    [2.9270, 2.0000, 1.6250],
    [1.7750, 2.8000, 1.4438],
    [1.3730, 2.6000, 3.1166],
    [3.5270, 3.2000, 3.1082],
    [2.8250, 2.4000, 4.0395],
    [3.9020, 5.2000, 4.0353],
    [2.0480, 5.2000, 4.7853],
];

fn columns() -> Columns {
    let named = |name: &str| Column::Named(name.to_owned());
    Columns { name: Some(named("Punkt")), ..Columns::of(["X [mm]", "Y [mm]", "Z [mm]"].map(named)) }
}

fn read(format: &str, text: &str) -> Result<MachineLog, InputError> {
    let importer = find(format).unwrap();
    MachineLog::from_text(importer, "log", text, importer.takes_columns().then(columns).as_ref())
}

#[test]
fn a_log_of_each_format_has_the_points_of_the_paper() {
    assert_eq!(SAMPLES.len(), ALL.len(), "every importer has a sample");
    for (format, _, text, rows, factor) in SAMPLES {
        for text in [(*text).to_owned(), text.replace("\r\n", "\n"), text.replace('\n', "\r\n")] {
            let log = read(format, &text).unwrap();
            for (row, [x, y, z]) in rows.iter().zip(PAPER) {
                let Position::At(at) = log.points()[row - 1].position else { panic!("{format}: row {row}") };
                let off = (at * *factor - Point3::new(x, y, z)).norm();
                assert!(off < 1e-12, "{format}: row {row}: {at}");
            }
            let usable =
                log.points().iter().filter(|point| matches!(point.position, Position::At(_))).count();
            assert_eq!(usable, 7, "{format}");
        }
    }
}

#[test]
fn points_keep_what_the_log_tells_of_them() {
    let told = |format: &str, row: usize| {
        let (.., text, _, _) = SAMPLES.iter().find(|sample| sample.0 == format).unwrap();
        let point = read(format, text).unwrap().points()[row - 1].clone();
        let (name, base, tool) = (point.name.unwrap_or_default(), point.base, point.tool);
        (name, base.unwrap_or_default(), tool.unwrap_or_default(), point.line, point.units)
    };
    let expected = |name: &str, base: &str, tool: &str, line, units| {
        (name.to_owned(), base.to_owned(), tool.to_owned(), line, units)
    };
    assert_eq!(told("kuka-dat", 2), expected("XP1", "3", "1", 14, None));
    assert_eq!(told("abb-mod", 3), expected("p2", "", "", 10, None));
    assert_eq!(told("abb-mod", 7), expected("plane_touch{2}", "", "", 15, None));
    assert_eq!(told("fanuc-ls", 2), expected("P[2]", "2", "4", 22, None));
    assert_eq!(told("fanuc-posreg", 5), expected("PR[5]", "", "", 18, None));
    assert_eq!(told("urscript", 7), expected("touch_7", "", "", 9, None));
    assert_eq!(told("ur-rtde", 7), expected("", "", "", 8, None));
    assert_eq!(told("linuxcnc-probe", 7), expected("", "", "", 7, None));
    assert_eq!(told("grbl", 1), expected("", "", "", 6, Some(Units::Millimetre)));
    assert_eq!(told("dmis", 3), expected("T3", "MCS", "", 9, Some(Units::Millimetre)));
    assert_eq!(told("csv", 1), expected("Z1", "", "", 2, None));
}

#[test]
fn the_unit_that_was_set_last_counts() {
    let log = read("grbl", "$13=0\n[PRB:1.0,2.0,3.0:1]\n>>> $13=1\n[PRB:1.0,2.0,3.0:1]").unwrap();
    let units: Vec<_> = log.points().iter().map(|point| point.units).collect();
    assert_eq!(units, [Some(Units::Millimetre), Some(Units::Inch)]);
}

#[test]
fn the_normal_of_a_surface_points_against_the_probing() {
    let text = "UNITS/MM\nPTMEAS/CART,1,2,3,0,0,1";
    assert_eq!(read("dmis", text).unwrap().points()[0].approach.unwrap().into_inner(), -Vector3::z());
    let [of, csv] =
        [["X", "Y", "Z"], ["I", "J", "K"]].map(|names| names.map(|name| Column::Named(name.to_owned())));
    for (normal, sign) in [(true, -1.0), (false, 1.0)] {
        let columns = Columns {
            approach: (!normal).then(|| csv.clone()),
            normal: normal.then(|| csv.clone()),
            ..Columns::of(of.clone())
        };
        let log =
            MachineLog::from_text(find("csv").unwrap(), "log", "X,Y,Z,I,J,K\n1,2,3,0,3,0", Some(&columns));
        assert_eq!(log.unwrap().points()[0].approach.unwrap().into_inner(), Vector3::y() * sign);
    }
}

/// Format, text, and what is said of its first point that has no position, with the text that it points to.
const TRAPS: &[(&str, &str, &str, &str)] = &[
    ("kuka-dat", "DECL E6POS XP1", "declared, never taught", "XP1"),
    ("kuka-dat", "DECL E6AXIS XP1={A1 0.0,A2 -90.0}", "joint angles", "A1"),
    ("kuka-dat", "DECL E6POS XP1={X 1.0,Y 2.0}", "no Z", "XP1"),
    ("kuka-dat", "DECL E6POS XP1={X 1.0,Y 2.0,Z 1.0,X 2.0}", "X is there twice", "X"),
    ("kuka-dat", "DECL E6POS XP1={X 1.0,Y NaN,Z 1.0}", "`NaN`", "NaN"),
    (
        "kuka-dat",
        "DECL E6POS XP1={X 1.0,Y 2.0,Z 3.0}\nDECL FDAT FP1={TOOL_NO 1,BASE_NO -1}",
        "BASE_NO is `-1`",
        "-1",
    ),
    (
        "kuka-dat",
        "DECL E6POS XP1={X 1.0,Y 2.0,Z 3.0}\nDECL FDAT FP1={TOOL_NO 1,BASE_NO 0,IPO_FRAME #TCP}",
        "IPO_FRAME",
        "#TCP",
    ),
    ("kuka-dat", "E6POS P[2]\nP[1]={X 1,Y 2,Z 3}\nP[2]={E6POS: X 1,Y 2,Z ****}", "`****`", "****"),
    ("abb-mod", "VAR robtarget p1;", "declared, never taught", "p1"),
    ("abb-mod", "CONST jointtarget p1:=[[0,0],[9E9]];", "joint angles", "[[0,0],[9E9]]"),
    ("abb-mod", "VAR robtarget p1:=[[0,0,0],[0,0,0,0],[0,0,0,0],[9E9]];", "never taught", "[0,0,0,0]"),
    ("abb-mod", "CONST pos p1:=[9E9,9E9,9E9];", "not defined", "[9E9,9E9,9E9]"),
    (
        "abb-mod",
        "CONST robtarget p1:=[[1,2],[1,0,0,0],[0],[0]];",
        "three coordinates",
        "[[1,2],[1,0,0,0],[0],[0]]",
    ),
    ("abb-mod", "CONST robtarget p1:=Offs(p0,0,0,1);", "not written out", "p1:=Offs"),
    ("abb-mod", "CONST robtarget p1:=[[1,2,\"3\"],[1,0,0,0],[0],[0]];", "not written out", "p1:=[[1,2,"),
    ("abb-mod", "CONST pos p{2}:=[[1,2,3],[1,2,inf]];", "`inf`", "inf"),
    ("fanuc-ls", "/POS\nP[1]{\n GP1:\n UF : 0, UT : 1,\n J1= 1.0 deg\n};", "joint angles", "J1"),
    (
        "fanuc-ls",
        "/POS\nP[1]{\n GP1:\n UF : 0, UT : 1,\n X = ******** mm, Y = 1 mm, Z = 1 mm\n};",
        "no value here",
        "********",
    ),
    ("fanuc-ls", "/POS\nP[1]{\n GP1:\n UF : F, UT : 1,\n X = 1 mm, Y = 1 mm, Z = 1 mm\n};", "UF is `F`", "F"),
    (
        "fanuc-ls",
        "/POS\nP[1]{\n GP1:\n X = 1 mm, Y = 1 mm, Z = 1 mm\n GP2:\n X = 1 mm\n};",
        "two motion groups",
        "1",
    ),
    ("fanuc-ls", "/POS\nP[1]{\n GP1:\n UF : 0, UT : 1\n};", "no X", "P[1]"),
    ("fanuc-posreg", "[*POSREG*]$POSREG\n [1,1] = 'a' Uninitialized", "uninitialised", "[1,1]"),
    ("fanuc-posreg", " [1,1] = ''\n X: *** Y: 1 Z: 1", "no value here", "***"),
    ("fanuc-posreg", " [1,1] = ''  Group: 1\n  J1 =  0.0 deg", "joint angles", "J1"),
    ("urscript", "a = p[0,0,0,0,0,0]", "never set", "p[0,0,0,0,0,0]"),
    ("urscript", "a = p[0.1,0.2,0.3]", "expected p[", "p[0.1,0.2,0.3]"),
    ("urscript", "a = p[100,200,300,0,0,0]", "millimetres", "p[100,200,300,0,0,0]"),
    ("urscript", "movel(p[0.1,0.2,0.3,0,0,0])", "within an expression", "p[0.1,0.2,0.3,0,0,0]"),
    ("urscript", "a = pose_add(b, p[0.1,0.2,0.3,0,0,0])", "within an expression", "p[0.1,0.2,0.3,0,0,0]"),
    ("ur-rtde", "tcp_0,tcp_1,tcp_2\n0,0,0", "never set", "0,0,0"),
    ("ur-rtde", "tcp_0,tcp_1,tcp_2\n100,2,3", "millimetres", "100,2,3"),
    ("ur-rtde", "TCP X (m),TCP Y (m),TCP Z (m)\n0.1,0.2,-", "`-`", "-"),
    ("linuxcnc-probe", "1 2 nan 0 0 0 0 0 0", "`nan`", "nan"),
    ("grbl", "[PRB:1,2,3:0]", "missed", "0"),
    ("grbl", "[PRB:1,2,3:2]", "flag is `2`", "2"),
    ("grbl", "[PRB:1,2,x:1]", "`x`", "x"),
    ("grbl", "[PRB:1,5,2,5,3,5:1]", "decimal commas", "[PRB:1,5,2,5,3,5:1]"),
    ("dmis", "PTMEAS/CART,1,5,2,5,3,5", "no unit vector", "5,3,5"),
    ("kuka-dat", "DECL E6POS XP1={X 1,5,Y 2,5,Z 3,5}", "not written as", "X 1,"),
    ("kuka-dat", "DECL E6POS XP1={X 1.0,Y 2.0,Z 3.0", "not written as", "X 1.0,Y 2.0,Z 3.0"),
    (
        "kuka-dat",
        "DECL E6POS XP1={X 1,Y 2,Z 3}\nDECL FDAT FP1={TOOL_NO 1 BASE_NO 0}",
        "not written as",
        "TOOL_NO 1 ",
    ),
    ("fanuc-ls", "/POS\nP[1]{\n GP1:\n X = 1,5 mm, Y = 1 mm, Z = 1 mm\n};", "`1,5`", "1,5"),
    ("fanuc-ls", "/POS\nP[1]{\n GP1:\n X = 1.5 in, Y = 1 in, Z = 1 in\n};", "expected mm", "in"),
    ("fanuc-posreg", " [1,1] = ''\n X: 2,5 Y: 1 Z: 1", "`2,5`", "2,5"),
    ("dmis", "PTMEAS/POL,1,2,3", "Cartesian", "PTMEAS/POL,1,2,3"),
    ("dmis", "PTMEAS/CART,1,2", "expected x,y,z", "PTMEAS/CART,1,2"),
    ("dmis", "PTMEAS/CART,1,2,3,0,0,0", "no unit vector", "0,0,0"),
    ("dmis", "GOTO/1,2,9\nPTMEAS/CART,1,2,3,0,0,1", "where the probe is sent", "PTMEAS/CART,1,2,3,0,0,1"),
    ("csv", "Punkt;X [mm];Y [mm];Z [mm]\na;1,5;2,5;", "an empty field", ""),
    ("csv", "Punkt;X [mm];Y [mm];Z [mm]\na;1,5; 2,5,1;3", "`2,5,1`", "2,5,1"),
];

#[test]
fn what_is_no_position_is_told_where_it_stands() {
    for (format, text, message, at) in TRAPS {
        let log = read(format, text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let faults = log.points().iter().filter_map(|point| match &point.position {
            Position::At(_) => None,
            Position::Unusable(fault) | Position::Empty(fault) => Some(fault.clone()),
        });
        let fault = faults.clone().next().unwrap_or_else(|| panic!("{text}: is taken as a position"));
        assert!(fault.message().contains(message), "{text}: {}", fault.message());
        assert_eq!(&text[fault.span.clone()], *at, "{text}");
        assert_eq!(log.fault(&fault).place().unwrap().offset, fault.span.start, "{text}");
    }
}

/// Format, text, code, line and column (0: none), and what is said.
const REFUSED: &[(&str, &str, &str, usize, usize, &str)] = &[
    ("kuka-dat", "", "too-few-touches", 0, 0, "no points"),
    ("kuka-dat", "DEFDAT P\nENDDAT", "too-few-touches", 0, 0, "no points"),
    ("fanuc-ls", "/PROG A\n/MN\n/END", "invalid-input", 0, 0, "/POS"),
    ("linuxcnc-probe", "1 2 3 0 0 0 0 0 0\n1 2 3", "invalid-input", 2, 1, "3 fields"),
    ("linuxcnc-probe", "1 2 3 0 0 0 0 0 0 0", "invalid-input", 1, 1, "10 fields"),
    ("linuxcnc-probe", "1,2,3,0,0,0,0,0,0", "invalid-input", 1, 1, "17 fields"),
    ("grbl", "ok\n10:00 [PRB:1,2,3:", "invalid-input", 2, 7, "not whole"),
    ("grbl", "[PRB:1,2:1]", "invalid-input", 1, 1, "not whole"),
    ("grbl", "[PRB:1,2,3]", "invalid-input", 1, 1, "not whole"),
    ("dmis", "UNITS/FEET\n", "invalid-input", 1, 7, "`FEET`"),
    ("ur-rtde", "timestamp,target_TCP_pose_0\n1,2", "missing-column", 0, 0, "no columns"),
    ("ur-rtde", "tcp_0,tcp_1,actual_TCP_pose_0\n1,2,3", "missing-column", 0, 0, "more than one"),
    ("ur-rtde", "tcp_0,tcp_1\n1,2", "missing-column", 1, 0, "`tcp_2`"),
    ("csv", "Punkt;X [mm];Y;Z [mm]\n", "missing-column", 1, 0, "`Y [mm]`"),
    ("csv", "Punkt;X [mm];Y [mm];Z [mm];Y [mm]\n", "invalid-input", 1, 0, "twice"),
    ("csv", "Punkt,X [mm],Y [mm],Z [mm]\na,1,5,2,5,3,5", "invalid-input", 2, 0, "7 fields"),
    ("csv", "Punkt,X [mm],Y [mm],Z [mm]\n\"a,1.5,2.5,3.5", "invalid-input", 2, 1, "quote"),
];

#[test]
fn what_is_no_log_of_the_format_is_refused() {
    for (format, text, code, line, column, message) in REFUSED {
        let error = read(format, text).unwrap_err();
        let place = error.place().map_or((0, 0), |place| (place.line, place.column.unwrap_or(0)));
        assert_eq!((error.code(), place), (*code, (*line, *column)), "{text}: {error}");
        assert!(error.to_string().contains(message), "{text}: {error}");
    }
    let numbered = Columns::of([1, 2, 3].map(Column::Numbered));
    let csv = |text: &str| MachineLog::from_text(find("csv").unwrap(), "log", text, Some(&numbered));
    assert!(csv("1.0,2,3,9\n4.5,5,6,9").is_ok());
    assert!(csv("1,5,2,5,3,5").unwrap_err().to_string().contains("decimal commas"));
    assert!(csv("1.0,2").unwrap_err().to_string().contains("column 3"));
}

/// Reads a text by every importer; whatever is said of it has a place in it.
fn survives(text: &str) {
    let read_all = ALL.iter().flat_map(|importer| {
        let numbered = Columns::of([1, 2, 3].map(Column::Numbered));
        let columns: Vec<Option<Columns>> =
            if importer.takes_columns() { vec![Some(columns()), Some(numbered)] } else { vec![None] };
        columns.into_iter().map(|columns| MachineLog::from_text(importer, "log", text, columns.as_ref()))
    });
    for log in read_all.flatten() {
        let mut before = 1;
        for point in log.points() {
            assert!(point.line >= before, "points come in the order of the text");
            before = point.line;
            match &point.position {
                Position::At(at) => assert!(at.iter().all(|v| v.is_finite())),
                Position::Unusable(fault) | Position::Empty(fault) => {
                    let _ = log.fault(fault);
                }
            }
        }
    }
}

/// The same texts in every run.
fn cases() -> ProptestConfig {
    ProptestConfig {
        cases: 400,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(25),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn arbitrary_text_is_read_or_refused(text in any::<String>()) {
        survives(&text);
    }

    #[test]
    fn signs_of_the_formats_are_read_or_refused(
        text in "([ \t\r\n;:,=/!#$'\"*]|\\[|\\]|\\{|\\}|P\\[|p\\[|\\[PRB:|DECL |FDAT |PERS |pos |/POS\n|GP1:|X|Y|Z|1.5|ä|9E9|PTMEAS/CART|FA\\(|UNITS/){0,60}",
    ) {
        survives(&text);
    }

    #[test]
    fn damaged_logs_are_read_or_refused(
        sample in any::<Index>(),
        other in any::<Index>(),
        cuts in prop::collection::vec((any::<Index>(), 0_usize..40, "[ -~\u{e4}\n\r]{0,6}"), 1..6),
    ) {
        let mut chars: Vec<char> = sample.get(SAMPLES).2.chars().collect();
        for (at, length, put) in &cuts {
            let from = at.index(chars.len() + 1);
            let to = (from + length).min(chars.len());
            chars.splice(from..to, put.chars());
        }
        let rest: String = chars.iter().collect();
        survives(&rest);
        // One log behind another.
        survives(&format!("{rest}{}", other.get(SAMPLES).2));
    }
}

#[test]
fn a_deep_list_and_a_long_log_are_read() {
    survives(&format!("CONST pos p:={}", "[".repeat(200_000)));
    let long = "[PRB:1.5,2,3:0]\n".repeat(200_000);
    assert_eq!(read("grbl", &long).unwrap().points()[199_999].line, 200_000);
}
