//! How many instructions the hot paths execute, counted by valgrind's callgrind: the same number on every run, however busy
//! the machine. Held against `counts.json`, which is kept; a path that has become slower fails.
//!
//! ```text
//! cargo build --release -p touchref-cli -p touchref-instructions
//! target/release/touchref-instructions              # count, and compare
//! target/release/touchref-instructions --renew      # count, and keep the numbers
//! ```
//!
//! The program runs itself under callgrind, which counts inside `cases::measured` only and writes a file whenever that
//! returns; and the command line beside it, which is counted from its first instruction to its last. The numbers are those
//! of one architecture and one compiler, and tell nothing of memory, branches or waiting: that is what the other benches
//! are for.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A bench may panic, and prints its figures.

mod cases;

use std::{
    env,
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

use serde_json::{Map, Value};

/// A count above the kept one by more than this fails, in parts of it. Repeated runs agree to 0.001 %; the rest is left to what
/// changes elsewhere do to inlining.
const SLOWER: f64 = 0.05;
/// The same for another compiler than that of the kept counts: inlining and vectorisation are its own.
const SLOWER_BY_COMPILER: f64 = 0.15;
/// A count below the kept one by more than this asks to keep the new one: else a later loss would go unnoticed.
const FASTER: f64 = 0.10;
/// Placements of the batch: one piece of its work.
const PLACEMENTS: u64 = 256;
/// The argument with which the program runs itself.
const COUNTED: &str = "--counted";
/// The argument that keeps the counts.
const RENEW: &str = "--renew";
/// The C library picks its functions by what the processor can do: held to what every one can.
const PROCESSOR: (&str, &str) =
    ("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL,-ERMS,-FSRM");

fn main() -> ExitCode {
    match env::args().nth(1).as_deref() {
        Some(COUNTED) => cases::run(),
        Some(RENEW) => {
            fs::write(kept_in(), told(&counts())).unwrap();
            println!("{} is new", kept_in().display());
        }
        Some(other) => panic!("unknown argument {other}; expected {RENEW} or none"),
        None => return compare(&counts()),
    }
    ExitCode::SUCCESS
}

/// The file of kept counts.
fn kept_in() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("counts.json")
}

/// The compiler on the path, and what it compiles for.
fn compiler() -> String {
    let told = Command::new("rustc").arg("--version").output().expect("rustc is on the path");
    let words = String::from_utf8(told.stdout).unwrap();
    let version = words.split_whitespace().nth(1).expect("rustc tells its version");
    format!("rustc {version}, {}-{}", env::consts::ARCH, env::consts::OS)
}

/// Instructions by case: one call each of the library's paths, and whole runs of the command line.
fn counts() -> Vec<(String, u64)> {
    let program = env::current_exe().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let measured = concat!(env!("CARGO_CRATE_NAME"), "::cases::measured");
    let inside = [format!("--toggle-collect={measured}"), format!("--dump-after={measured}")];
    let names = counted(&folder.path().join("own"), &inside, &[program.as_ref(), COUNTED.as_ref()]);
    let part = |number: usize| folder.path().join(format!("own.{number}"));
    let own = (1..).zip(names.lines());
    let mut counts: Vec<(String, u64)> =
        own.map(|(number, name)| (name.to_owned(), total(&part(number)) / cases::MEASUREMENTS)).collect();

    let command_line = program.with_file_name(format!("touchref{}", env::consts::EXE_SUFFIX));
    assert!(command_line.exists(), "{} is missing: cargo build --release", command_line.display());
    let paper = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/nederbragt-ravani.toml");
    let [table, frames, out] = ["table.csv", "frames.csv", "out"].map(|name| folder.path().join(name));
    fs::write(&table, cases::table(PLACEMENTS)).unwrap();
    let locate: [&OsStr; 2] = ["locate".as_ref(), paper.as_ref()];
    let batch: [&OsStr; 8] = [
        "batch".as_ref(),
        table.as_ref(),
        "--measurement".as_ref(),
        paper.as_ref(),
        "--output".as_ref(),
        frames.as_ref(),
        "--threads".as_ref(),
        "1".as_ref(),
    ];
    let runs = [
        ("touchref locate, the paper's example".to_owned(), &locate[..]),
        (format!("touchref batch, {PLACEMENTS} placements"), &batch[..]),
    ];
    for (name, arguments) in runs {
        let line: Vec<&OsStr> =
            [command_line.as_ref()].into_iter().chain(arguments.iter().copied()).collect();
        counted(&out, &[], &line);
        counts.push((name, total(&out)));
    }
    counts
}

/// Runs a program under callgrind, which writes to files of this name, and returns what the program printed.
fn counted(out: &Path, options: &[String], line: &[&OsStr]) -> String {
    let run = Command::new("valgrind")
        .args(["--tool=callgrind", "--quiet"])
        .args(options)
        .arg(format!("--callgrind-out-file={}", out.display()))
        .args(line)
        .env(PROCESSOR.0, PROCESSOR.1)
        .output()
        .expect("valgrind is installed (Debian: valgrind)");
    let told = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{line:?} under valgrind: {}\n{told}", run.status);
    String::from_utf8(run.stdout).unwrap()
}

/// The instructions that a file of callgrind tells.
fn total(out: &Path) -> u64 {
    let text = fs::read_to_string(out).unwrap_or_else(|error| panic!("valgrind has not counted: {error}"));
    let total = text.lines().find_map(|line| line.strip_prefix("totals: ")).expect("a total");
    let total = total.trim().parse().unwrap();
    assert!(total > 0, "valgrind has counted nothing: {}", out.display());
    total
}

/// The counts as they are kept.
fn told(counts: &[(String, u64)]) -> String {
    let instructions: Map<String, Value> =
        counts.iter().map(|(name, count)| (name.clone(), Value::from(*count))).collect();
    let kept = serde_json::json!({ "compiler": compiler(), "instructions": instructions });
    format!("{kept:#}\n")
}

/// Prints counts beside the kept ones, and fails where they differ by too much.
fn compare(counts: &[(String, u64)]) -> ExitCode {
    let file: Value = serde_json::from_str(&fs::read_to_string(kept_in()).unwrap()).unwrap();
    let (kept, kept_with) = (file["instructions"].as_object().unwrap(), file["compiler"].as_str().unwrap());
    let compiler = compiler();
    let slower = if kept_with == compiler { SLOWER } else { SLOWER_BY_COMPILER };
    let mut faults = Vec::new();
    println!("{:<40} {:>12} {:>12} {:>10}", "instructions", "kept", "now", "change");
    for (name, now) in counts {
        let Some(kept) = kept.get(name).and_then(Value::as_u64) else {
            println!("{name:<40} {:>12} {now:>12}", "-");
            faults.push(format!("`{name}` is not kept"));
            continue;
        };
        let change = *now as f64 / kept as f64 - 1.0;
        let percent = 100.0 * change;
        let verdict = if change > slower {
            faults.push(format!("`{name}` takes {percent:.1} % more instructions"));
            "  slower"
        } else if change < -FASTER {
            faults.push(format!("`{name}` takes {:.1} % fewer instructions: keep that", -percent));
            "  faster"
        } else {
            ""
        };
        println!("{name:<40} {kept:>12} {now:>12} {percent:>+8.2} %{verdict}");
    }
    let gone = kept.keys().filter(|name| counts.iter().all(|(known, _)| known != *name));
    faults.extend(gone.map(|name| format!("`{name}` is kept, but no case")));
    println!("kept with {kept_with}; now {compiler}: up to {:.0} % more pass", 100.0 * slower);
    if faults.is_empty() {
        return ExitCode::SUCCESS;
    }
    println!("\n{}\n\nwhere that is meant, and said why: touchref-instructions {RENEW}", faults.join("\n"));
    ExitCode::FAILURE
}
