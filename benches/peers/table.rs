//! What was measured, as Markdown.

use std::{env, fmt::Write as _, fs, process::Command};

use super::{
    CERES, CERES_TIGHT, COMPANION, CRATE, CRATE_TIGHT, EVERY_ROOT, Ends, GAUSS_NEWTON, LOCATE, Measured,
    Outcome, REFINEMENT, ROUNDS, SAME, SCIPY, SCIPY_TIGHT, TINY, TINY_TIGHT, Task, UNAIDED,
};

/// Crates whose versions are told.
const CRATES: [&str; 4] = ["levenberg-marquardt", "argmin", "nalgebra", "faer"];

pub(crate) fn markdown(measured: &[Measured<'_>], programs: &[String]) -> String {
    let times = |set: &Measured<'_>, name: &str| set.time(name).map(duration);
    let to = |other: &'static str| {
        move |set: &Measured<'_>, name: &str| set.ratio(name, other).map(|ratio| format!("{}", Short(ratio)))
    };
    let mut text = String::new();
    let _ = write!(
        text,
        "<!-- Written by benches/peers/run. -->\n\n{}\n\n## Promises\n\n{}\n## Median time of a problem\n\n{}\n\
         ## Times as long as touchref's refinement\n\n{}\n## Times as long as TinySolver's refinement\n\n{}\n\
         ## Where they end\n\n{}",
        conditions(programs),
        promises(measured),
        table(measured, times),
        table(measured, to(REFINEMENT)),
        table(measured, to(TINY)),
        ends(measured),
    );
    text
}

/// The machine, the build, the versions, the day.
fn conditions(programs: &[String]) -> String {
    let told = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output().ok();
        output.map_or_else(String::new, |output| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let information = read("/proc/cpuinfo");
    let processor = information.lines().find_map(|line| line.strip_prefix("model name"));
    let processor =
        processor.map_or("a processor without a name", |name| name.trim_matches([' ', '\t', ':']));
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let instructions = if cfg!(target_feature = "avx512f") {
        "AVX-512"
    } else if cfg!(target_feature = "avx2") {
        "AVX2"
    } else {
        "the architecture's oldest instructions"
    };
    let lock = include_str!("../../Cargo.lock");
    let versions = CRATES.map(|name| {
        let after = lock.split(&format!("name = \"{name}\"\nversion = \"")).nth(1).unwrap_or("?");
        format!("{name} {}", after.split('"').next().unwrap_or("?"))
    });
    let load = read("/proc/loadavg");
    format!(
        "{} on {cores} cores of {processor}, {}; load {} at the end.\n\n{}, flags `{}` ({instructions}), touchref {}; {}; {}.\n\n\
         Medians of {ROUNDS} interleaved rounds; ratios are medians of the rounds' own. One thread each.",
        told("date", &["+%Y-%m-%d"]),
        told("uname", &["-sm"]),
        load.split(' ').next().unwrap_or("?"),
        told("rustc", &["--version"]),
        env::var("RUSTFLAGS").unwrap_or_default(),
        env!("CARGO_PKG_VERSION"),
        versions.join(", "),
        programs.join("; "),
    )
}

/// Rows of methods, columns of sets.
fn table(measured: &[Measured<'_>], cell: impl Fn(&Measured<'_>, &str) -> Option<String>) -> String {
    let mut text = head(measured);
    for Outcome { name, ends, .. } in rows(measured) {
        let cells: Vec<String> = match ends {
            Ok(_) => measured.iter().map(|set| cell(set, name).unwrap_or_default()).collect(),
            Err(why) => vec![format!("absent: {why}")],
        };
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
    }
    text
}

/// How many problems each method solved, and how many of them it did not bring to the least-squares frame.
fn ends(measured: &[Measured<'_>]) -> String {
    let mut text = head(measured);
    for Outcome { name, task, ends } in rows(measured) {
        if task == Task::Roots || ends.is_err() {
            continue;
        }
        let cell = |set: &Measured<'_>| {
            let outcome = set.outcomes.iter().find(|outcome| outcome.name == name)?;
            let Ends { solved, refused, elsewhere, farthest } = outcome.ends.clone().ok()?;
            let mut cell = match task {
                Task::Axis => format!("{:.0e} rad", farthest.1),
                _ => format!("{:.0e} mm, {:.0e} rad", farthest.0, farthest.1),
            };
            let _ = match (elsewhere, refused) {
                (0, 0) => write!(cell, "; {solved}"),
                (_, 0) => write!(cell, "; **{elsewhere}** elsewhere of {solved}"),
                _ => write!(cell, "; **{elsewhere}** elsewhere, {refused} refused of {solved}"),
            };
            Some(cell)
        };
        let cells: Vec<String> = measured.iter().map(|set| cell(set).unwrap_or_default()).collect();
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
    }
    let _ = writeln!(
        text,
        "\nThe farthest from the least-squares frame, and the problems solved. Elsewhere: farther than {:.0e} mm or {:.0e} rad, \
         an axis than a degree.",
        SAME.0, SAME.1
    );
    text
}

/// Every method of any set, once.
fn rows(measured: &[Measured<'_>]) -> Vec<Outcome> {
    let mut rows: Vec<Outcome> = Vec::new();
    for outcome in measured.iter().flat_map(|set| &set.outcomes) {
        if rows.iter().all(|row| row.name != outcome.name) {
            rows.push(outcome.clone());
        }
    }
    rows
}

fn head(measured: &[Measured<'_>]) -> String {
    let names: Vec<String> = measured.iter().map(|set| set.set.name.replace('-', " ")).collect();
    format!("| touches | {} |\n|---|{}\n", names.join(" | "), "--:|".repeat(names.len()))
}

/// The bounds that the library sets itself, and what was measured.
fn promises(measured: &[Measured<'_>]) -> String {
    let of = |name: &str| measured.iter().find(|set| set.set.name == name);
    let slower = |set: &str, name: &str, other: &str| of(set).and_then(|set| set.ratio(name, other));
    let mut text = String::from("| | bound | measured | |\n|---|--:|--:|---|\n");
    let mut row = |what: &str, least: bool, bound: f64, unit: &str, value: Option<f64>| {
        let kept =
            value.map_or("absent", |value| if (value >= bound) == least { "kept" } else { "**not kept**" });
        let value = value.map_or_else(String::new, |value| format!("{}{unit}", Short(value)));
        let relation = if least { ">=" } else { "<=" };
        let _ = writeln!(text, "| {what} | {relation} {bound}{unit} | {value} | {kept} |");
    };
    for (set, which) in [("7", "7 touches"), ("7-nominal", "7 nominal touches")] {
        for (peer, bound) in [
            (TINY, 2.0),
            (TINY_TIGHT, 2.0),
            (CERES, 20.0),
            (CERES_TIGHT, 20.0),
            (CRATE, 5.0),
            (CRATE_TIGHT, 5.0),
            (GAUSS_NEWTON, 5.0),
            (SCIPY, 500.0),
            (SCIPY_TIGHT, 500.0),
        ] {
            let what = format!("refinement of {which}: {peer}, times as long");
            row(&what, true, bound, "", slower(set, peer, REFINEMENT));
        }
        let what = format!("closed form, choice and refinement of {which}, in refinements by {TINY}");
        row(&what, false, 1.5, "", slower(set, UNAIDED, TINY));
    }
    let what = format!("honest locate of 7 nominal touches, in refinements by {TINY}");
    row(&what, false, 20.0, "", slower("7-nominal", LOCATE, TINY));
    let microseconds = of("7").and_then(|set| set.time(LOCATE)).map(|time| time / 1e3);
    row("honest locate of 7 touches anywhere", false, 100.0, " us", microseconds);
    for peer in [TINY, TINY_TIGHT] {
        let what = format!("refinement of 1000 touches: {peer}, times as long");
        row(&what, true, 5.0, "", slower("1000", peer, REFINEMENT));
    }
    row(
        &format!("closed form, every frame: {COMPANION}, times as long"),
        true,
        6.0,
        "",
        slower("7", COMPANION, EVERY_ROOT),
    );
    let growth = of("10000").zip(of("1000")).and_then(|(many, some)| {
        let [many, some] = [many, some].map(|set| Some(set.time(REFINEMENT)? / set.set.touches() as f64));
        Some(many? / some?)
    });
    row("refinement: time of a touch, of 10000 over of 1000", false, 1.2, "", growth);
    text
}

/// A number of three digits.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = match self.0 {
            value if value >= 99.95 => 0,
            value if value >= 9.995 => 1,
            _ => 2,
        };
        write!(f, "{:.digits$}", self.0)
    }
}

fn duration(nanoseconds: f64) -> String {
    match nanoseconds {
        time if time < 1e4 => format!("{time:.0} ns"),
        time if time < 1e7 => format!("{} us", Short(time / 1e3)),
        time => format!("{} ms", Short(time / 1e6)),
    }
}
