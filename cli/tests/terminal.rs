//! What the terminal sees: what goes to standard error, tables that fit, help that is true, completions and manual pages.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{
    collections::BTreeSet,
    fs,
    path::Path,
    process::{Command, Output, Stdio},
};

use common::{Folder, TABLE, example, paper, without_touches};

const SUBCOMMANDS: [&str; 21] = [
    "locate",
    "list",
    "describe",
    "simulate",
    "study",
    "plan",
    "guide",
    "uncertainty",
    "reliability",
    "element",
    "calibrate",
    "gauge",
    "log",
    "compare",
    "history",
    "report",
    "export",
    "schema",
    "batch",
    "completions",
    "man",
];

fn told(output: &[u8]) -> String {
    String::from_utf8(output.to_vec()).unwrap()
}

/// Whether there is such a program; what it would check is not checked where there is none.
fn is_installed(program: &str) -> bool {
    Command::new(program)
        .arg("--version")
        .stdin(Stdio::null())
        .output()
        .is_ok_and(|output| output.status.success())
}

fn run(program: &str, args: &[&str], folder: &Path) -> Output {
    Command::new(program).args(args).current_dir(folder).stdin(Stdio::null()).output().unwrap()
}

#[test]
fn quiet_leaves_nothing_but_errors_on_standard_error() {
    let folder = Folder::new().with("m.toml", paper());
    for args in
        [&["locate", "m.toml"][..], &["plan", "m.toml", "--next"], &["locate", "m.toml", "--record", "r.db"]]
    {
        let loud = folder.run(args, b"");
        let quiet = folder.run(&[args, &["--quiet"]].concat(), b"");
        assert_eq!((loud.status.code(), quiet.status.code()), (Some(0), Some(0)), "{args:?}");
        assert_eq!(told(&quiet.stderr), "", "{args:?}");
        if args[0] == "locate" {
            assert_eq!(quiet.stdout, loud.stdout);
            assert!(told(&loud.stderr).contains("warning: "), "{args:?}");
        }
    }
    let refused = folder.run(&["-q", "locate", "m.toml", "-p", "radius=1.04"], b"");
    assert!(refused.status.code() == Some(1) && told(&refused.stderr).contains("No frame to trust"));
    let (status, error) = folder.json(&["locate", "m.toml", "-q", "-v"], b"");
    assert_eq!((status, error["error"]["code"].as_str()), (2, Some("usage")), "{error}");
}

/// `plan` tells what there is to doubt about the measurement, like every other command.
#[test]
fn a_plan_tells_the_warnings_of_its_measurement() {
    let folder = Folder::new().with("m.toml", without_touches());
    let table = TABLE.replace("id", "qif_feature");
    let output = folder.run(&["plan", "m.toml", "--touches", "-", "--next"], table.as_bytes());
    assert_eq!(output.status.code(), Some(0), "{}", told(&output.stderr));
    assert!(told(&output.stderr).contains("`qif_feature`"), "{}", told(&output.stderr));
}

/// The steps that are told are those that were made: as many as the result counts, each downhill, the last at its misfit.
#[test]
fn verbose_tells_starts_minima_and_every_step() {
    /// Of a misfit: that of the last step is predicted to this part, where the criterion ends the iteration.
    const LEFT: f64 = 1e-8;
    for (name, solvers) in [
        ("nederbragt-ravani.toml", ["least-squares", "global", "robust"]),
        ("bore-and-faces.toml", ["least-squares", "global", "robust"]),
    ] {
        let folder = Folder::new().with("m.toml", example(name));
        for solver in solvers {
            let args = ["locate", "m.toml", "--solver", solver];
            let (_, plain) = folder.json(&args, b"");
            assert!(plain["iteration"]["history"].is_null(), "nobody asked");
            let (status, mut result) = folder.json(&[&args[..], &["--verbose"]].concat(), b"");
            assert_eq!(status, 0, "{result}");
            let history = result["iteration"]["history"].take();
            let history = history.as_array().unwrap();
            assert_eq!(
                history.len() as u64,
                result["iteration"]["steps"].as_u64().unwrap(),
                "{name}, {solver}"
            );
            let chi_square = |step: &serde_json::Value| step["chi_square"].as_f64().unwrap();
            let falls = |two: &[serde_json::Value]| chi_square(&two[1]) <= chi_square(&two[0]) * (1.0 + LEFT);
            assert!(history.windows(2).all(falls), "{history:?}");
            let off = chi_square(history.last().unwrap()) - result["chi_square"].as_f64().unwrap();
            assert!(off.abs() < 1e-6, "{name}, {solver}: {off}");
            result["iteration"].as_object_mut().unwrap().remove("history");
            assert_eq!(result, plain, "the result is the same");
            let output = folder.run(&[&args[..], &["-v"]].concat(), b"");
            let error = told(&output.stderr);
            for part in
                [&format!("How solver {solver} found the frame"), "starts: ", "damping", "ended by `cost`"]
            {
                assert!(error.contains(part), "{part}: {error}");
            }
        }
    }
    let folder = Folder::new().with("m.toml", paper());
    let output = folder.run(&["locate", "m.toml", "-v", "--solver", "closed-form"], b"");
    assert!(told(&output.stderr).contains("no iteration"), "{}", told(&output.stderr));
}

/// A folder with the examples, a table and a store, as the examples of `--help` name them.
fn with_examples() -> Folder {
    let folder = Folder::new().with("touches.csv", TABLE);
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let copied = folder.0.path().join("examples");
    fs::create_dir_all(copied.join("logs")).unwrap();
    for part in ["", "logs"] {
        for entry in fs::read_dir(examples.join(part)).unwrap().map(Result::unwrap) {
            if entry.path().is_file() {
                fs::copy(entry.path(), copied.join(part).join(entry.file_name())).unwrap();
            }
        }
    }
    for _ in 0..6 {
        let args = ["locate", "examples/three-sphere.toml", "--record", "cell.db", "--format", "json"];
        let result = folder.run(&args, b"").stdout;
        for name in ["before.json", "after.json"] {
            fs::write(folder.0.path().join(name), &result).unwrap();
        }
    }
    let simulated = folder.run(&["simulate", "examples/cube.toml", "--count", "3"], b"").stdout;
    fs::write(folder.0.path().join("placements.csv"), simulated).unwrap();
    folder
}

/// The words of a line as a shell takes them.
fn words(line: &str) -> Vec<String> {
    let parts = line.split('"').enumerate();
    parts
        .flat_map(|(index, part)| match index % 2 {
            0 => part.split_whitespace().map(str::to_owned).collect(),
            _ => vec![part.to_owned()],
        })
        .collect()
}

#[test]
fn the_examples_of_help_work() {
    let folder = with_examples();
    for subcommand in SUBCOMMANDS {
        let help = told(&folder.run(&[subcommand, "--help"], b"").stdout);
        let (_, examples) =
            help.split_once("\nExamples:\n").unwrap_or_else(|| panic!("{subcommand}: {help}"));
        for line in examples.lines().filter(|line| !line.trim().is_empty()) {
            let call = words(line.trim().strip_prefix("touchref ").unwrap_or_else(|| panic!("{line}")));
            let call: Vec<&str> = call.iter().map(String::as_str).collect();
            let output = folder.run(&call, b"");
            // `guide` ends with the touches, here none beside the measurement's.
            assert_eq!(output.status.code(), Some(0), "{line}: {}", told(&output.stderr));
        }
    }
}

/// The long options of a help text.
fn options(help: &str) -> BTreeSet<String> {
    let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let options =
        lines.flat_map(|line| line.split([' ', ',', '=', '.', '[']).filter(|word| word.starts_with("--")));
    options.map(str::to_owned).collect()
}

#[test]
fn manual_pages_have_every_option_and_are_set_without_a_warning() {
    let folder = Folder::new();
    fs::create_dir(folder.0.path().join("man")).unwrap();
    assert_eq!(folder.run(&["man", "man"], b"").status.code(), Some(0));
    let mut pages = BTreeSet::from(["touchref.1".to_owned()]);
    pages.extend(SUBCOMMANDS.map(|name| format!("touchref-{name}.1")));
    let written: BTreeSet<String> = fs::read_dir(folder.0.path().join("man"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert!(written.is_superset(&pages), "{written:?}");
    for page in pages {
        let text = fs::read_to_string(folder.0.path().join("man").join(&page)).unwrap().replace("\\-", "-");
        let name = page.trim_end_matches(".1").split_once('-').map(|(_, name)| name);
        let args: Vec<&str> = name.into_iter().chain(["--help"]).collect();
        let help = told(&folder.run(&args, b"").stdout);
        assert!(options(&help).len() > 2, "{help}");
        for option in options(&help) {
            assert!(text.contains(&option), "{page} lacks {option}");
        }
        if is_installed("groff") {
            let set =
                run("groff", &["-man", "-ww", "-Tutf8", "-K", "utf8", &page], &folder.0.path().join("man"));
            assert!(set.status.success() && set.stderr.is_empty(), "{page}: {}", told(&set.stderr));
            assert!(!set.stdout.is_empty(), "{page}");
        }
    }
}

/// What bash offers for the last of these words.
fn offered(folder: &Folder, words: &[&str]) -> Vec<String> {
    let last = words.len() - 1;
    let script = format!(
        "compopt() {{ :; }}; source ./touchref.bash; COMP_WORDS=({}); COMP_CWORD={last}; \
         _touchref touchref '{}' '{}'; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
        words.iter().map(|word| format!("'{word}'")).collect::<Vec<_>>().join(" "),
        words[last],
        words[last - 1],
    );
    let output = run("bash", &["--norc", "-c", &script], folder.0.path());
    assert!(output.stderr.is_empty(), "{words:?}: {}", told(&output.stderr));
    told(&output.stdout).lines().map(str::to_owned).collect()
}

#[test]
fn completions_are_scripts_that_know_the_names() {
    let folder = Folder::new();
    for (shell, checked_by) in
        [("bash", "bash"), ("zsh", "zsh"), ("fish", "fish"), ("elvish", ""), ("powershell", "")]
    {
        let output = folder.run(&["completions", shell], b"");
        let script = told(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{}", told(&output.stderr));
        assert!(SUBCOMMANDS.iter().all(|name| script.contains(name)), "{shell}");
        if ["bash", "zsh", "fish"].contains(&shell) {
            // The others complete no values.
            for word in ["cylinder-plane", "least-squares", "kuka", "rtde"] {
                assert!(script.contains(word), "{shell}: {word}");
            }
        }
        fs::write(folder.0.path().join(format!("touchref.{shell}")), &script).unwrap();
        if !checked_by.is_empty() && is_installed(checked_by) {
            let checked = run(checked_by, &["-n", &format!("touchref.{shell}")], folder.0.path());
            assert!(checked.status.success(), "{shell}: {}", told(&checked.stderr));
        }
    }
    if !is_installed("bash") {
        return;
    }
    for (words, expected) in [
        (&["touchref", "loc"][..], "locate"),
        (&["touchref", "locate", "--fixture", "cyl"], "cylinder-plane"),
        (&["touchref", "study", "--solver", "glo"], "global"),
        (&["touchref", "locate", "--dialect", "ku"], "kuka"),
        (&["touchref", "describe", "three"], "three-sphere"),
        (&["touchref", "log", "--from", "fanuc-p"], "fanuc-posreg"),
        (&["touchref", "locate", "--touches", "touchref.f"], "touchref.fish"),
        (&["touchref", "locate", "--near", "touchref.f"], "touchref.fish"),
        (&["touchref", "plan", "--quie"], "--quiet"),
    ] {
        assert_eq!(offered(&folder, words), [expected], "{words:?}");
    }
}

/// Runs the command on a terminal of so many columns; what it would show, standard error among it.
fn on_terminal(folder: &Folder, columns: usize, settings: &[(&str, &str)], call: &str) -> String {
    let binary = assert_cmd::cargo::cargo_bin!("touchref");
    let script = format!("stty rows 50 cols {columns}; {} {call}", binary.display());
    let mut command = Command::new("script");
    command.args(["-qec", &script, "/dev/null"]).current_dir(folder.0.path()).stdin(Stdio::null());
    // What else decides about colours: a machine of continuous integration is taken to have them.
    for setting in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "FORCE_COLOR", "CI"] {
        command.env_remove(setting);
    }
    command.env("TERM", "xterm").env("LC_ALL", "C.UTF-8").envs(settings.iter().copied());
    told(&command.output().unwrap().stdout)
}

/// What is seen of a text: without the sequences that a terminal obeys, each state of a line by itself.
fn seen(text: &str) -> String {
    anstream::adapter::strip_str(text).to_string().replace('\r', "\n")
}

#[test]
fn tables_fit_the_terminal() {
    if !is_installed("script") {
        return;
    }
    let folder = with_examples();
    let calls = [
        "locate examples/nederbragt-ravani.toml -v",
        "locate examples/three-sphere.toml",
        "locate examples/nederbragt-ravani.toml --sigma 0.016",
        "list",
        "describe least-squares",
        "study examples/cube.toml --trials 100",
        "plan examples/nederbragt-ravani.toml --next",
        "uncertainty examples/three-sphere.toml --at 300,0,0 --at 0,0,200 --samples 1000",
        "reliability examples/nederbragt-ravani.toml --at 300,0,0",
        "element plane touches.csv --surface plane",
        "calibrate examples/calibration.toml",
        "log examples/logs/probe.dat --from kuka-dat",
        "compare cell.db --series",
        "history cell.db",
    ];
    let mut wide = Vec::new();
    for call in calls {
        for columns in [40, 60, 80, 200] {
            let text = seen(&on_terminal(&folder, columns, &[], call));
            let too_long = text.lines().filter(|line| line.trim_end().chars().count() > columns);
            wide.extend(too_long.map(|line| format!("{call}, {columns} columns: {line}")));
        }
    }
    assert!(wide.is_empty(), "{}", wide.join("\n"));
    // No number is broken, however narrow it is.
    let narrow = seen(&on_terminal(&folder, 40, &[], calls[0]));
    for number in ["2.900029", "-0.556215"] {
        assert!(narrow.contains(number), "{narrow}");
    }
}

#[test]
fn colours_boxes_and_bars_are_for_terminals_that_have_them() {
    if !is_installed("script") {
        return;
    }
    let folder = with_examples();
    let call = "study examples/cube.toml --trials 3000 --threads 1";
    let rich = on_terminal(&folder, 80, &[], call);
    assert!(rich.contains('\u{1b}') && rich.contains('─') && rich.contains(" left"), "{rich:?}");
    // The bar is gone before the result is there.
    let (_, after) = rich.rsplit_once(" left").unwrap();
    assert!(after.contains("\u{1b}[2K") && after.contains("No frame was wrong."), "{after:?}");
    let plain = on_terminal(&folder, 80, &[("TERM", "dumb")], call);
    assert!(!plain.contains('\u{1b}') && !plain.contains(" left"), "{plain:?}");
    let colourless = on_terminal(&folder, 80, &[("NO_COLOR", "1")], &format!("{call} -q"));
    assert!(!colourless.contains('\u{1b}') && colourless.contains('─'), "{colourless:?}");
    let ascii = on_terminal(&folder, 80, &[("LC_ALL", "C"), ("LANG", "C")], call);
    assert!(seen(&ascii).is_ascii(), "{ascii:?}");
}
