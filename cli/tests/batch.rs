//! Many placements, from a table to a table, as a user asks.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{
    fmt::Write as _,
    fs::{self, File},
    path::PathBuf,
    process::{Command, Stdio},
    sync::Arc,
    thread::sleep,
    time::Instant,
};

use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, cast::AsArray, types::Float64Type};
use common::{Folder, TABLE, number, without_touches};
use parquet::arrow::{ArrowWriter, arrow_reader::ParquetRecordBatchReaderBuilder};
use serde_json::{Value, json};

/// The paper's touches, moved along x by as much as the placement's number says; one row in `broken` has another x.
fn rows(placements: usize, broken: Option<(usize, &str)>) -> Vec<[String; 5]> {
    let touches = TABLE.lines().skip(1).enumerate();
    let touches: Vec<(usize, Vec<&str>)> =
        touches.map(|(index, line)| (index, line.split(',').collect())).collect();
    let placed = (0..placements).flat_map(|placement| touches.iter().map(move |touch| (placement, touch)));
    placed
        .map(|(placement, (index, fields))| {
            let x = fields[1].parse::<f64>().unwrap() + placement as f64;
            let x = match broken {
                Some((row, text)) if row == placement * touches.len() + index => text.to_owned(),
                _ => x.to_string(),
            };
            [format!("p{placement}"), fields[0].to_owned(), x, fields[2].to_owned(), fields[3].to_owned()]
        })
        .collect()
}

fn csv(rows: &[[String; 5]]) -> String {
    let lines: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    format!("placement,surface,x,y,z\n{}\n", lines.join("\n"))
}

fn ndjson(rows: &[[String; 5]]) -> String {
    rows.iter().fold(String::new(), |mut text, [placement, surface, x, y, z]| {
        writeln!(text, r#"{{"placement":"{placement}","surface":"{surface}","x":{x},"y":{y},"z":{z}}}"#)
            .unwrap();
        text
    })
}

fn record_batch(rows: &[[String; 5]]) -> RecordBatch {
    let texts = |column: usize| Arc::new(StringArray::from_iter_values(rows.iter().map(|row| &row[column])));
    let numbers = |column: usize| {
        Arc::new(Float64Array::from_iter_values(rows.iter().map(|row| row[column].parse::<f64>().unwrap())))
    };
    let columns: [(&str, ArrayRef); 5] = [
        ("placement", texts(0)),
        ("surface", texts(1)),
        ("x", numbers(2)),
        ("y", numbers(3)),
        ("z", numbers(4)),
    ];
    RecordBatch::try_from_iter(columns).unwrap()
}

/// Two row groups.
fn parquet(rows: &[[String; 5]]) -> Vec<u8> {
    let batch = record_batch(rows);
    let mut writer = ArrowWriter::try_new(Vec::new(), batch.schema(), None).unwrap();
    let half = rows.len() / 2;
    writer.write(&batch.slice(0, half)).unwrap();
    writer.flush().unwrap();
    writer.write(&batch.slice(half, rows.len() - half)).unwrap();
    writer.into_inner().unwrap()
}

fn folder(name: &str, table: impl AsRef<[u8]>) -> Folder {
    Folder::new().with("m.toml", without_touches()).with(name, table)
}

fn batch(folder: &Folder, table: &str, output: &str) -> (i32, Value) {
    folder.json(&["batch", table, "--measurement", "m.toml", "-o", output], b"")
}

fn path(folder: &Folder, name: &str) -> PathBuf {
    folder.0.path().join(name)
}

/// Placement, status and x of every row, from any form.
fn read(folder: &Folder, name: &str) -> Vec<(String, String, Option<f64>)> {
    if name.ends_with("parquet") {
        let file = File::open(path(folder, name)).unwrap();
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).unwrap().build().unwrap();
        let of = |batch: RecordBatch| -> Vec<_> {
            let text = |column: &str| batch.column_by_name(column).unwrap().as_string::<i32>().clone();
            let x = batch.column_by_name("x").unwrap().as_primitive::<Float64Type>().clone();
            text("placement")
                .iter()
                .zip(text("status").iter())
                .zip(x.iter())
                .map(|((name, status), x)| (name.unwrap().to_owned(), status.unwrap().to_owned(), x))
                .collect()
        };
        return reader.flat_map(|batch| of(batch.unwrap())).collect();
    }
    let text = fs::read_to_string(path(folder, name)).unwrap();
    if name.ends_with("csv") {
        let mut lines = text.lines();
        assert!(lines.next().unwrap().starts_with("placement,status,x,y,z,qx,qy,qz,qw,chi_square,"));
        return lines
            .map(|line| {
                let fields: Vec<&str> = line.split(',').collect();
                (fields[0].to_owned(), fields[1].to_owned(), fields[2].parse().ok())
            })
            .collect();
    }
    let objects = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    objects
        .map(|object| (text(&object["placement"]), text(&object["status"]), object["x"].as_f64()))
        .collect()
}

#[test]
fn every_form_gives_the_frames_of_locate() {
    let rows = rows(30, None);
    let folder =
        folder("t.csv", csv(&rows)).with("t.ndjson", ndjson(&rows)).with("t.parquet", parquet(&rows));
    let mut all = Vec::new();
    for table in ["t.csv", "t.ndjson", "t.parquet"] {
        for output in ["f.csv", "f.ndjson", "f.parquet"] {
            let (status, summary) = batch(&folder, table, output);
            assert_eq!(status, 0, "{summary}");
            assert_eq!((&summary["placements"], &summary["status"]), (&json!(30), &json!({"ok": 30})));
            all.push(read(&folder, output));
        }
    }
    assert!(all.iter().all(|frames| *frames == all[0]), "{all:?}");
    for (placement, (name, _, x)) in all[0].iter().enumerate() {
        assert_eq!(*name, format!("p{placement}"));
        let own: String = csv(&rows[7 * placement..7 * (placement + 1)]);
        fs::write(path(&folder, "one.csv"), own).unwrap();
        let (_, located) = folder
            .json(&["locate", "m.toml", "--touches", "one.csv", "--solver-parameter", "margin=near"], b"");
        assert_eq!(*x, Some(number(&located["frame"]["origin"][0])), "{name}");
    }
}

/// From standard input, with semicolons and decimal commas; what is not used is told.
#[test]
fn touches_come_from_standard_input_too() {
    let folder = folder("t.csv", "");
    let text = csv(&rows(2, None)).replace(',', ";").replace('.', ",").replace("z\n", "z;shift\n");
    let text: Vec<String> = text
        .lines()
        .map(|line| {
            if line.starts_with('p') && !line.contains("shift") {
                format!("{line};1")
            } else {
                line.to_owned()
            }
        })
        .collect();
    let args = ["batch", "-", "--measurement", "m.toml", "-o", "f.csv"];
    let output = folder.run(&args, text.join("\n").as_bytes());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(
        String::from_utf8_lossy(&output.stderr),
        "warning: column `shift` of standard input is not used\n"
    );
    assert!(String::from_utf8_lossy(&output.stdout).starts_with("2 of 2 placements located, in f.csv"));
    assert_eq!(read(&folder, "f.csv").len(), 2);
}

#[test]
fn a_wrong_touch_is_a_row_with_its_place() {
    let wrong = |text| rows(5, Some((17, text)));
    let folder = folder("t.csv", csv(&wrong("NaN")))
        .with("t.ndjson", ndjson(&wrong("null")))
        .with("t.parquet", parquet(&wrong("NaN")));
    let places = [
        ("t.csv", "line 19, column `x` is `NaN`; expected a finite number"),
        ("t.ndjson", "t.ndjson, line 18, column `x` is empty; expected a finite number"),
        ("t.parquet", "t.parquet, row group 1, row 17, column `x` is NaN; expected a finite number"),
    ];
    for (table, message) in places {
        let (status, summary) = batch(&folder, table, "f.ndjson");
        assert_eq!(status, 0, "{summary}");
        assert_eq!(summary["status"], json!({"ok": 4, "invalid-input": 1}), "{table}");
        let text = fs::read_to_string(path(&folder, "f.ndjson")).unwrap();
        let row: Value = serde_json::from_str(text.lines().nth(2).unwrap()).unwrap();
        assert_eq!((&row["placement"], &row["status"]), (&json!("p2"), &json!("invalid-input")));
        assert_eq!(
            (row["message"].as_str().unwrap(), &row["x"], &row["cov_x_x"]),
            (message, &Value::Null, &Value::Null)
        );
    }
}

#[test]
fn a_wrong_table_is_refused_and_leaves_nothing() {
    let good = rows(40, None);
    let mut swapped = good.clone();
    swapped.swap(3, 17);
    let mut damaged = parquet(&good);
    // The bytes of the first column that holds coordinates, in the first row group.
    let metadata = ParquetRecordBatchReaderBuilder::try_new(bytes(&damaged)).unwrap();
    let x = metadata.metadata().row_group(0).column(2);
    let (start, length) = x.byte_range();
    let (start, end) = (usize::try_from(start).unwrap(), usize::try_from(start + length).unwrap());
    damaged[start..end].fill(0xa5);
    let cut = parquet(&good)[..900].to_vec();
    let folder = folder("swapped.csv", csv(&swapped))
        .with("short.csv", "placement,surface,x,y\np,plane,1,2\n")
        .with("no.csv", TABLE)
        .with("uncut.csv", "placement,surface,x,y,z\np,plane,1,2\n")
        .with("empty.csv", "")
        .with("header.csv", "placement,surface,x,y,z\n")
        .with("units.csv", "placement,surface,x,y,z,units\np,plane,1,2,3,inch\n")
        .with("bad.ndjson", "{\"placement\":\"a\",\"surface\":\"plane\",\"x\":NaN}\n")
        .with(
            "mixed.ndjson",
            ndjson(&good) + "{\"placement\":4,\"surface\":\"plane\",\"x\":1,\"y\":2,\"z\":3}\n",
        )
        .with("damaged.parquet", damaged)
        .with("cut.parquet", cut)
        .with("csv.parquet", csv(&good))
        .with("t.xlsx", "");
    let cases = [
        ("swapped.csv", "f.csv", "invalid-input", "line 6: placement `p0` comes again"),
        ("short.csv", "f.csv", "missing-column", "column `z` is missing"),
        ("no.csv", "f.csv", "missing-column", "column `placement` is missing"),
        ("uncut.csv", "f.csv", "invalid-input", "this line has 4 fields; the header has 5 columns"),
        ("empty.csv", "f.csv", "invalid-input", "the touch table is empty"),
        ("header.csv", "f.csv", "too-few-touches", "the table has columns but no touches"),
        ("bad.ndjson", "f.csv", "invalid-input", "bad.ndjson, line 1: column "),
        (
            "mixed.ndjson",
            "f.csv",
            "invalid-input",
            "mixed.ndjson, line 281: placements are called by numbers, or by texts",
        ),
        (
            "damaged.parquet",
            "f.parquet",
            "unreadable",
            "cannot read damaged.parquet, row group 0, column `x`: ",
        ),
        ("cut.parquet", "f.parquet", "unreadable", "cannot read cut.parquet as Parquet: "),
        ("csv.parquet", "f.parquet", "unreadable", "cannot read csv.parquet as Parquet: "),
        ("gone.parquet", "f.parquet", "unreadable", "cannot read gone.parquet: "),
        ("t.xlsx", "f.csv", "invalid-input", "the name t.xlsx does not tell what form the table has"),
        ("swapped.csv", "f.xml", "invalid-input", "the name f.xml does not tell what form the table has"),
        ("swapped.csv", "none/f.csv", "unwritable", "cannot write none/f.csv: "),
    ];
    for (table, output, code, message) in cases {
        let (status, error) = batch(&folder, table, output);
        assert_eq!((status, error["error"]["code"].as_str().unwrap()), (2, code), "{table}: {error}");
        let told = error["error"]["message"].as_str().unwrap();
        assert!(told.starts_with(message), "{table}: {told}");
        assert!(!path(&folder, output).exists(), "{table} left {output}");
    }
    let (_, summary) = batch(&folder, "units.csv", "f.csv");
    assert_eq!(summary["status"], json!({"invalid-input": 1}));
}

fn bytes(of: &[u8]) -> bytes::Bytes {
    bytes::Bytes::copy_from_slice(of)
}

/// Killed at many moments: the output is whole or not there, and a file that was there before is as it was.
#[test]
fn a_kill_leaves_no_half_of_a_table() {
    const KILLS: u32 = 25;
    const PLACEMENTS: usize = 600;
    let folder = folder("t.parquet", parquet(&rows(PLACEMENTS, None))).with("old.csv", "before\n");
    let command = |output: &str| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("touchref"));
        command.current_dir(folder.0.path()).args([
            "batch",
            "t.parquet",
            "--measurement",
            "m.toml",
            "-o",
            output,
        ]);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let start = Instant::now();
    assert!(command("whole.csv").status().unwrap().success());
    let whole_time = start.elapsed();
    let whole = fs::read(path(&folder, "whole.csv")).unwrap();
    assert_eq!(read(&folder, "whole.csv").len(), PLACEMENTS);
    let mut kept = 0;
    for kill in 0..KILLS {
        fs::write(path(&folder, "old.csv"), "before\n").unwrap();
        let mut child = command("old.csv").spawn().unwrap();
        sleep(whole_time.mul_f64(1.5 * f64::from(kill) / f64::from(KILLS)));
        child.kill().unwrap();
        child.wait().unwrap();
        let now = fs::read(path(&folder, "old.csv")).unwrap();
        assert!(now == whole || now == b"before\n", "kill {kill} left {} bytes", now.len());
        kept += u32::from(now == whole);
    }
    assert!(kept > 0 && kept < KILLS, "{kept} of {KILLS} came to their end");
}
