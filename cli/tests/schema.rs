//! The published schemas are those of the program, and what it prints is valid by them.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::{collections::BTreeSet, env, fs, path::PathBuf};

use common::{Folder, TABLE, example, paper, without_touches};
use jsonschema::Validator;
use serde_json::{Value, json};

/// How the published files are written anew.
const ANEW: &str = "WRITE_SCHEMAS=1 cargo test -p touchref-cli --test schema published";

fn published() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/schema"))
}

/// What `touchref schema` lists.
fn names() -> Vec<String> {
    let listed = Folder::new().run(&["schema"], b"").stdout;
    let listed = String::from_utf8(listed).unwrap();
    let rows = listed.lines().filter(|line| line.starts_with("  "));
    rows.map(|line| line.split_whitespace().next().unwrap().to_owned()).collect()
}

fn schema(name: &str) -> Value {
    let output = Folder::new().run(&["schema", name], b"");
    assert_eq!(output.status.code(), Some(0), "{name}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The schema that knows no key but its own: so that whatever is printed must be in it.
fn closed(name: &str) -> Validator {
    let mut schema = schema(name);
    let close = |schema: &mut Value| {
        if schema.get("properties").is_some() {
            schema["unevaluatedProperties"] = false.into();
        }
    };
    close(&mut schema);
    if let Some(definitions) = schema.get_mut("$defs").and_then(Value::as_object_mut) {
        definitions.values_mut().for_each(close);
    }
    jsonschema::validator_for(&schema).unwrap()
}

fn assert_valid(validator: &Validator, document: &Value, what: &str) {
    let errors: Vec<String> =
        validator.iter_errors(document).map(|error| format!("{}: {error}", error.instance_path())).collect();
    assert!(errors.is_empty(), "{what}: {errors:#?}\n{document:#}");
}

#[test]
fn published_files_are_what_the_program_prints() {
    let folder = published();
    let names = names();
    assert!(names.contains(&"measurement".to_owned()) && names.len() > 10, "{names:?}");
    for name in &names {
        let file = folder.join(name).with_extension("json");
        let printed = Folder::new().run(&["schema", name], b"").stdout;
        if env::var_os("WRITE_SCHEMAS").is_some() {
            fs::write(&file, &printed).unwrap();
        }
        let kept = fs::read(&file).unwrap_or_default();
        assert!(kept == printed, "{} is not what `touchref schema {name}` prints: {ANEW}", file.display());
        let schema: Value = serde_json::from_slice(&printed).unwrap();
        jsonschema::meta::validate(&schema).unwrap();
        assert_eq!(schema["title"], format!("touchref.{name}/1"));
        assert_eq!(schema["$id"], format!("urn:touchref:{name}:1"));
    }
    let files = fs::read_dir(&folder).unwrap().map(|file| file.unwrap().path());
    let files = files.filter(|file| file.extension().is_some_and(|extension| extension == "json"));
    let files: BTreeSet<String> =
        files.map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    assert_eq!(files, names.into_iter().collect(), "a file of no schema");
}

/// Within a version keys are only added: what an earlier program printed is valid still, and every key of it is known.
#[test]
fn what_was_printed_once_is_valid_still() {
    let mut kept = BTreeSet::new();
    for file in fs::read_dir(published().join("examples")).unwrap() {
        let path = file.unwrap().path();
        let file = path.file_name().unwrap().to_str().unwrap();
        let name = file.split('.').next().unwrap();
        let document = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
        assert_valid(&closed(name), &document, file);
        kept.insert(name.to_owned());
    }
    let printed: BTreeSet<String> = names().into_iter().filter(|name| name != "measurement").collect();
    assert_eq!(kept, printed, "each form has an example");
}

/// The examples, and measurements that show what else there is to print.
fn folder() -> Folder {
    let cube = example("cube.toml");
    let bad = cube.replacen("[426.5496, -151.5672, 87.7929]", "[426.5496, -151.5672, 88.7929]", 1);
    let open = cube.replacen("surface = \"+z\"", "surface = \"?\"", 1);
    let own = paper().replace(
        "at = [2.8250, 2.4000, 4.0395]",
        "at = [2.8250, 2.4000, 4.0395]\nsigma = 0.0001\napproach = [0, 0, -2]",
    );
    let covariance = paper().replace(
        "at = [2.9270, 2.0000, 1.6250]",
        "at = [2.9270, 2.0000, 1.6250]\ncovariance = [[1e-8, 0, 0], [0, 1e-8, 0], [0, 0, 2e-8]]",
    );
    let uncertain = paper().replace("radius = 1.0", "radius = { value = 1.0, u = 0.001 }");
    assert!(bad != cube && open != cube && own != paper() && covariance != paper() && uncertain != paper());
    let examples = [
        "bore-and-faces.toml",
        "calibration.toml",
        "cube.toml",
        "nederbragt-ravani.toml",
        "three-sphere.toml",
        "tooling-balls.toml",
        "v-block.toml",
        "logs/probe.dat",
    ];
    let folder = examples
        .into_iter()
        .fold(Folder::new(), |folder, name| folder.with(name.rsplit('/').next().unwrap(), example(name)));
    folder
        .with("kuka.toml", example("logs/kuka.toml"))
        .with("bad.toml", bad)
        .with("open.toml", open)
        .with("own.toml", own)
        .with("covariance.toml", covariance)
        .with("uncertain.toml", uncertain)
        .with("no-sigma.toml", paper().replace("sigma = 0.00005", ""))
        .with("ambiguous.toml", paper().replace("sigma = 0.00005", "sigma = 0.1"))
        .with("inconsistent.toml", paper().replace("radius = 1.0", "radius = 1.04"))
        .with("bare.toml", without_touches())
        .with("table.csv", TABLE)
        .with("placed.csv", TABLE.replace('\n', ",a\n").replacen(",a", ",placement", 1))
        .with("points.csv", "x,y,z\n0,0,0\n1,0,0.01\n0,1,0\n1,1,-0.01\n")
}

/// Whatever `locate` prints, a frame or a refusal.
#[test]
fn what_locate_prints_is_valid() {
    let (solution, error) = (closed("solution"), closed("error"));
    let folder = folder();
    let cases: &[(&[&str], i32)] = &[
        (&["bore-and-faces.toml"], 0),
        (&["cube.toml", "--dialect", "kuka", "--dialect", "euler:zyx:intrinsic:deg"], 0),
        (&["nederbragt-ravani.toml", "--solver", "closed-form"], 0),
        (&["three-sphere.toml"], 0),
        (&["tooling-balls.toml", "--solver", "global"], 0),
        (&["v-block.toml"], 0),
        (&["kuka.toml"], 0),
        (&["bad.toml", "--solver", "robust"], 0),
        (&["open.toml", "--solver", "robust"], 0),
        (&["own.toml"], 0),
        (&["covariance.toml"], 0),
        (&["uncertain.toml"], 0),
        (&["no-sigma.toml"], 0),
        (&["bad.toml"], 1),
        (&["ambiguous.toml"], 1),
        (&["inconsistent.toml"], 1),
        (&["open.toml"], 2),
        (&["bare.toml"], 2),
        (&["calibration.toml"], 2),
        (&["no-such.toml"], 2),
        (&["cube.toml", "-p", "edges=50"], 2),
        (&["cube.toml", "--solver", "closed"], 2),
        (&["cube.toml", "--dialect", "kuk"], 2),
        (&["cube.toml", "--what"], 2),
        (&["cube.toml", "--dialect", "linuxcnc"], 1),
    ];
    for (args, expected) in cases {
        let (status, printed) = folder.json(&[&["locate"], *args].concat(), b"");
        assert_eq!(status, *expected, "{args:?}: {printed:#}");
        assert_valid(if status == 0 { &solution } else { &error }, &printed, &format!("{args:?}"));
    }
}

#[test]
fn what_the_other_commands_print_is_valid() {
    let folder = folder();
    let located = folder.run(&["locate", "cube.toml", "--format", "json"], b"").stdout;
    let moved = String::from_utf8(located.clone()).unwrap();
    let folder = folder.with("before.json", located).with("after.json", moved.replace("412.5", "412.6"));
    for file in ["cube.toml", "bad.toml"] {
        folder.run(&["locate", file, "--record", "cell.db"], b"");
    }
    let cases: &[(&str, &[&str])] = &[
        ("batch", &["batch", "placed.csv", "--measurement", "bare.toml", "-o", "frames.csv"]),
        ("calibration", &["calibrate", "calibration.toml"]),
        ("comparison", &["compare", "before.json", "after.json", "--at", "1,2,3"]),
        ("comparison", &["compare", "before.json", "before.json"]),
        ("describe", &["describe", "composite"]),
        ("describe", &["describe", "robust"]),
        ("describe", &["describe", "kuka"]),
        ("describe", &["describe", "csv"]),
        ("describe", &["describe", "kuka-dat"]),
        ("element", &["element", "plane", "points.csv"]),
        ("element", &["element", "sphere", "table.csv", "--surface", "cylinder"]),
        ("error", &["calibrate", "cube.toml"]),
        ("gauge", &["gauge", "--samples", "2000"]),
        ("history", &["history", "cell.db"]),
        ("list", &["list"]),
        ("list", &["list", "dialects"]),
        ("log", &["log", "probe.dat", "--from", "kuka-dat"]),
        ("plan", &["plan", "bare.toml"]),
        ("plan", &["plan", "nederbragt-ravani.toml", "--next"]),
        ("reliability", &["reliability", "three-sphere.toml"]),
        ("study", &["study", "nederbragt-ravani.toml", "--trials", "20"]),
        ("study", &["study", "bare.toml", "--sigma", "1", "--trials", "5"]),
        ("uncertainty", &["uncertainty", "three-sphere.toml", "--samples", "1000"]),
        ("uncertainty", &["uncertainty", "no-sigma.toml"]),
    ];
    for (name, args) in cases {
        let (_, printed) = folder.json(args, b"");
        assert_valid(&closed(name), &printed, &format!("{args:?}"));
    }
    let table = TABLE.replace("plane,2.8250", "plate,2.8250") + "plane,2.8250,2.4000,4.0395,x5\n";
    let guided = folder.run(&["guide", "bare.toml", "--format", "json"], table.as_bytes());
    let (guide, mut states) = (closed("guide"), BTreeSet::new());
    for line in String::from_utf8(guided.stdout).unwrap().lines() {
        let answer: Value = serde_json::from_str(line).unwrap();
        states.insert(answer["state"].as_str().unwrap().to_owned());
        assert_valid(&guide, &answer, line);
    }
    assert_eq!(states.into_iter().collect::<Vec<_>>(), ["done", "error", "free"]);
}

/// A program that reads what it does not understand is told so by the schema.
#[test]
fn what_is_no_result_is_not_valid() {
    let folder = folder();
    let (_, right) = folder.json(&["locate", "nederbragt-ravani.toml"], b"");
    let solution = jsonschema::validator_for(&schema("solution")).unwrap();
    assert!(solution.is_valid(&right));
    let with = |pointer: &str, value: Value| {
        let mut document = right.clone();
        *document.pointer_mut(pointer).unwrap() = value;
        document
    };
    let without = |pointer: &str, key: &str| {
        let mut document = right.clone();
        document.pointer_mut(pointer).unwrap().as_object_mut().unwrap().remove(key).unwrap();
        document
    };
    let wrong = [
        with("/schema", json!("touchref.solution/2")),
        with("/schema", json!("touchref.error/1")),
        with("/units", json!("cm")),
        with("/frame/origin", json!([1, 2])),
        with("/frame/origin/0", json!("2.9")),
        with("/frame/matrix/3", json!([0, 0, 1])),
        with("/rms", json!("small")),
        with("/degrees_of_freedom", json!(1.5)),
        with("/degrees_of_freedom", json!(-1)),
        with("/covariance/matrix/0/0", json!(null)),
        with("/covariance/order/0", json!("rx")),
        with("/covariance/axes", json!("fixture")),
        with("/covariance/sigma_source", json!("guessed")),
        with("/touches/0/index", json!("0")),
        with("/touches/0/at", json!([1, 2, 3, 4])),
        with("/roots/0/measures/radius", json!("1.0")),
        with("/trust/limited_by", json!("patience")),
        with("/warnings", json!({})),
        with("/dialects", json!([])),
        with("/fixture/parameters/radius", json!(null)),
        without("", "frame"),
        without("", "schema"),
        without("", "covariance"),
        without("/frame", "quaternion_xyzw"),
        without("/touches/0", "residual"),
        without("/trust", "up_to_sigma"),
    ];
    for document in wrong {
        assert!(!solution.is_valid(&document), "{document:#}");
    }
    let mut later = right;
    later["temperature"] = json!(20.5);
    assert!(solution.is_valid(&later), "later versions may add keys");

    let (_, right) = folder.json(&["locate", "ambiguous.toml"], b"");
    let error = jsonschema::validator_for(&schema("error")).unwrap();
    assert!(error.is_valid(&right));
    for (pointer, value) in [
        ("/error/code", json!("unsure")),
        ("/error/message", json!(null)),
        ("/error/roots", json!({})),
        ("/error/units", json!("cm")),
    ] {
        let mut document = right.clone();
        *document.pointer_mut(pointer).unwrap() = value;
        assert!(!error.is_valid(&document), "{document:#}");
    }
}

/// The sources of what prints, blanks left out.
fn sources() -> String {
    fn read(folder: PathBuf, texts: &mut String) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                read(path, texts);
            } else if !path.ends_with("refusal.rs") {
                texts.extend(fs::read_to_string(&path).unwrap().split_whitespace());
            }
        }
    }
    let mut texts = String::new();
    for package in ["core", "solvers", "io", "batch", "report", "cli", "bindings/c"] {
        read(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").join(package).join("src"), &mut texts);
    }
    texts
}

/// Every code that the sources have is in the schema of an error, and none that they do not have.
#[test]
fn the_codes_of_errors_are_those_of_the_sources() {
    let sources = sources();
    let schema = schema("error");
    let code = schema["$defs"]["ErrorDetails"]["properties"]["code"]["enum"].as_array().unwrap();
    let codes: BTreeSet<&str> = code.iter().map(|code| code.as_str().unwrap()).collect();
    for code in &codes {
        assert!(sources.contains(&format!("\"{code}\"")), "{code} is nobody's");
    }
    for call in ["InputError::new(\"", "InputError::unknown(\"", "ErrorRecord::new(\"", "Self::new(\""] {
        for after in sources.split(call).skip(1) {
            let code = after.split('"').next().unwrap();
            let is_code = code.contains('-') && code.chars().all(|c| c.is_ascii_lowercase() || c == '-');
            assert!(!is_code || codes.contains(code), "{call}{code} is not in `refusal::CODES`");
        }
    }
}

/// The guide tells what to do about each of them.
#[test]
fn the_guide_has_every_code() {
    let guide = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/integrators.md")).unwrap();
    let first_cells = guide.lines().filter_map(|line| line.strip_prefix("| `")?.split(" | ").next());
    let told: BTreeSet<&str> =
        first_cells.flat_map(|cell| cell.trim_end_matches('`').split("`, `")).collect();
    for code in touchref::io::refusal::CODES {
        assert!(told.contains(code), "docs/integrators.md has no row of {code}");
    }
}

/// Whatever calls itself a form has a schema.
#[test]
fn every_form_has_a_schema() {
    let (sources, names) = (sources(), names());
    let mut found = BTreeSet::new();
    for before in [":\"touchref.", "=\"touchref."] {
        for after in sources.split(before).skip(1) {
            if let Some((name, _)) = after.split('"').next().unwrap().split_once('/') {
                assert!(names.contains(&name.to_owned()), "{name} is not in `schema::ALL`");
                found.insert(name.to_owned());
            }
        }
    }
    assert!(found.len() > 10, "{found:?}");
}

#[test]
fn an_unknown_name_is_told_with_the_nearest() {
    let output = Folder::new().run(&["schema", "solutions"], b"");
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("`solutions` is not known") && told.contains("did you mean `solution`?"), "{told}");
}
