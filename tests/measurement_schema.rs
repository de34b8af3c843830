//! The JSON Schema of a measurement file and the parser of one accept and refuse the same documents.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

use std::{
    fs,
    path::{Path, PathBuf},
};

use jsonschema::Validator;
use rand::{Rng, RngExt, seq::IndexedRandom};
use serde_json::{Map, Value, json};
use touchref::{
    Registry,
    analysis::simulation::generator,
    io::{InputError, Measurement, schema},
    registry,
};

/// Whatever a measurement may say, in four documents.
const FULL: &[&str] = &[
    r#"
units = "um"
[fixture]
kind = "three-sphere"
radii = [10, 11.5, 12]
ab = { value = 100, u = 0.001 }
bc = 95
ca = 100.5
[probe]
tip_radius = { value = 1.5, u = 0 }
sigma = 1
[[touch]]
surface = "a"
at = [1, 2, 3.5]
id = "first"
sigma = 0.5
approach = [0, 0, -2]
[[touch]]
surface = "?"
at = [1, 2, 3]
covariance = [[1, 0.5, 0], [0.5, 1, 0], [0, 0, 1]]
"#,
    r#"
units = "in"
[fixture]
kind = "cylinder-plane"
radius = 1
angle_deg = { value = 40, u = 0.01 }
cylinder_side = "front"
bore = true
[log]
file = "t.csv"
format = "csv"
columns = { at = ["X", "Y", "Z"], name = "Name", normal = ["I", "J", "K"] }
units = "mm"
base = 3
tool = "probe"
compensated = false
touch = [{ surface = "cylinder", points = ["a", "b"], rows = "1-4, 7" }, { surface = "plane", rows = "8" }]
ignore = { points = ["home"] }
"#,
    r#"
units = "m"
[fixture]
kind = "composite"
free = ["rz"]
size = 0.1
[[fixture.surface]]
type = "cylinder"
name = "bore"
point = [0, 0, 0]
axis = [0, 0, 2]
radius = { value = 0.015, u = 1e-6 }
bore = true
from = { value = -0.035, u = 0 }
to = 0
[[fixture.surface]]
type = "cone"
name = "seat"
apex = [0, 0, -0.1]
axis = [0, 0, 1]
half_angle_deg = 30
[[fixture.surface]]
type = "sphere"
name = "ball"
center = [0, 0, 0.2]
radius = 0.01
toward = [0, 0, 1]
"#,
    r#"
units = "mm"
[fixture]
kind = "cube"
edge = 50
[[placement]]
name = "north"
touches = "north.csv"
[[placement]]
touch = [{ surface = "+x", at = [1, 2, 3] }]
[[placement]]
[placement.log]
file = "t.csv"
format = "csv"
columns = { at = [1, 2, 3], name = 4, approach = [5, 6, 7] }
[[placement.log.touch]]
surface = "+y"
rows = "1"
"#,
];

/// Both that are to agree.
struct Both {
    registry: Registry,
    validator: Validator,
}

impl Both {
    fn new() -> Self {
        let registry = registry().unwrap();
        let schema = schema::measurement(&registry);
        jsonschema::meta::validate(&schema).unwrap();
        Self { validator: jsonschema::validator_for(&schema).unwrap(), registry }
    }

    fn read(&self, document: &Value) -> Result<(), InputError> {
        let measurement = Measurement::from_text("m.json", &document.to_string(), Path::new(""))?;
        measurement.fixture(&self.registry).map(|_| ())
    }

    /// Whether both accept the document; they must say the same.
    fn accept(&self, document: &Value) -> bool {
        let errors: Vec<String> = self
            .validator
            .iter_errors(document)
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        match self.read(document) {
            Ok(()) => assert!(errors.is_empty(), "read, but not valid: {errors:#?}\n{document:#}"),
            Err(error) if relates(&error) => return false,
            Err(error) => assert!(!errors.is_empty(), "valid, but not read: {error}\n{document:#}"),
        }
        errors.is_empty()
    }
}

/// Whether what is wrong is how several values go together, which no schema tells.
fn relates(error: &InputError) -> bool {
    const RELATIONS: [&str; 8] = [
        "as that of another surface",
        "expected a length above `from`",
        "a length typical of the fixture",
        "is no covariance",
        "\" again",
        "that no surface fixes",
        "they make no triangle",
        "expected rows counted from 1",
    ];
    let text = error.to_string();
    RELATIONS.iter().any(|relation| text.contains(relation))
}

fn toml(text: &str) -> Value {
    toml::from_str(text).unwrap()
}

fn examples() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let files =
        [folder.clone(), folder.join("logs")].into_iter().flat_map(|folder| fs::read_dir(folder).unwrap());
    let mut files: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    files
}

/// Every example, and the documents that say everything.
fn documents() -> Vec<Value> {
    let examples = examples().into_iter().map(|file| toml(&fs::read_to_string(file).unwrap()));
    let documents: Vec<Value> = examples.chain(FULL.iter().map(|text| toml(text))).collect();
    assert!(documents.len() > 10, "{}", documents.len());
    documents
}

#[test]
fn every_example_is_accepted_by_both() {
    let both = Both::new();
    for document in documents() {
        assert!(both.accept(&document), "{document:#}");
    }
}

/// Texts that both accept or both refuse, between what stands before and after each.
struct Cases {
    before: &'static str,
    after: &'static str,
    accepted: &'static [&'static str],
    refused: &'static [&'static str],
}

/// What stands in `fixture = { .. }`.
const FIXTURES: Cases = Cases {
    before: "units = \"mm\"\nfixture = {",
    after: "}",
    accepted: &[
        r#"kind = "cube", edge = { value = 50, u = 0.1 }"#,
        r#"kind = "cylinder-plane", radius = 1"#,
        r#"kind = "three-sphere", ab = 1, bc = 1, ca = 1, radius = 0.1"#,
        r#"kind = "three-sphere", ab = 1, bc = 1, ca = 1, radii = [0.1, 0.1, 0.1]"#,
    ],
    refused: &[
        r#"kind = "cubes", edge = 50"#,
        "edge = 50",
        r#"kind = "cube""#,
        r#"kind = "cube", edge = "50""#,
        r#"kind = "cube", edge = 0"#,
        r#"kind = "cube", edge = 50, edges = 50"#,
        r#"kind = "cube", edge = { value = 50 }"#,
        r#"kind = "cube", edge = { value = 50, u = -0.1 }"#,
        r#"kind = "cube", edge = { value = 50, u = 0.1, k = 2 }"#,
        r#"kind = "cube", edge = [50]"#,
        r#"kind = "cylinder-plane", radius = 1, angle_deg = 90"#,
        r#"kind = "cylinder-plane", radius = 1, bore = "true""#,
        r#"kind = "cylinder-plane", radius = 1, cylinder_side = "beside""#,
        r#"kind = "three-sphere", ab = 1, bc = 1, ca = 1"#,
        r#"kind = "three-sphere", ab = 1, bc = 1, ca = 1, radius = 0.1, radii = [0.1, 0.1, 0.1]"#,
        r#"kind = "three-sphere", ab = 1, bc = 1, ca = 1, radii = [0.1, 0.1]"#,
        r#"kind = "composite", surface = []"#,
    ],
};

/// What stands in a surface of a composite.
const SURFACES: Cases = Cases {
    before: "units = \"mm\"\nfixture = { kind = \"composite\", size = 1, surface = [{ name = \"s\", ",
    after: "}] }",
    accepted: &[
        r#"type = "plane", point = [0, 0, 0], normal = [0, 0, 1]"#,
        r#"type = "sphere", center = [0, 0, 0], radius = 1, toward = [1, 0, 0]"#,
    ],
    refused: &[
        "point = [0, 0, 0], normal = [0, 0, 1]",
        r#"type = "torus", point = [0, 0, 0], normal = [0, 0, 1]"#,
        r#"type = "plane", point = [0, 0], normal = [0, 0, 1]"#,
        r#"type = "plane", point = [0, 0, 0], normal = [0, 0.0, 0]"#,
        r#"type = "plane", point = [0, 0, 0], axis = [0, 0, 1]"#,
        r#"type = "plane", point = [0, 0, 0], normal = [0, 0, 1], "" = 1"#,
        r#"type = "cylinder", point = [0, 0, 0], axis = [0, 0, 1], radius = 1, from = { value = 0, u = 0.1 }"#,
    ],
};

/// What stands in `probe = { .. }`.
const PROBES: Cases = Cases {
    before: "units = \"mm\"\nfixture = { kind = \"cube\", edge = 50 }\nprobe = {",
    after: "}",
    accepted: &["", "tip_radius = 0, sigma = 0.1", "tip_radius = { value = 1, u = 0 }"],
    refused: &["tip_radius = -1", "sigma = 0", "sigma = { value = 1, u = 0 }", "radius = 1"],
};

/// What stands in a touch.
const TOUCHES: Cases = Cases {
    before: "units = \"mm\"\nfixture = { kind = \"cube\", edge = 50 }\ntouch = [{",
    after: "}]",
    accepted: &[
        r#"surface = "+x", at = [1, 2, 3], id = "7", sigma = 0.1, approach = [1, 0, 0]"#,
        r#"surface = "+x", at = [1, 2, 3], covariance = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"#,
    ],
    refused: &[
        r#"surface = "+x""#,
        "at = [1, 2, 3]",
        r#"surface = "+x", at = "?""#,
        r#"surface = "+x", at = [1, 2]"#,
        r#"surface = "+x", at = [1, 2, "3"]"#,
        "surface = 1, at = [1, 2, 3]",
        r#"surface = "+x", at = [1, 2, 3], id = 7"#,
        r#"surface = "+x", at = [1, 2, 3], approach = [0, 0, 0]"#,
        r#"surface = "+x", at = [1, 2, 3], covariance = [[1, 0, 0], [0, 1, 0]]"#,
        r#"surface = "+x", at = [1, 2, 3], sigma = 1, covariance = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"#,
    ],
};

/// What stands in a placement.
const PLACEMENTS: Cases = Cases {
    before: "units = \"mm\"\nfixture = { kind = \"cube\", edge = 50 }\nplacement = [{",
    after: "}]",
    accepted: &[r#"touches = "t.csv""#],
    refused: &[
        r#"name = "n""#,
        "touch = []",
        r#"touches = "t.csv", touch = [{ surface = "+x", at = [1, 2, 3] }]"#,
    ],
};

/// What stands in `log = { .. }` beside `file`.
const LOGS: Cases = Cases {
    before: "units = \"mm\"\nfixture = { kind = \"cube\", edge = 50 }\nlog = { file = \"f\", ",
    after: "}",
    accepted: &[
        r#"format = "grbl", touch = [{ surface = "+x", rows = "1-4, 7" }]"#,
        r#"format = "grbl", touch = [{ surface = "+x", points = ["p"] }], ignore = { rows = "9" }"#,
        r#"format = "csv", columns = { at = [1, 2, 3] }, touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "dmis", base = "B", tool = 2, units = "in", touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "dmis", compensated = true, touch = [{ surface = "+x", rows = "1" }]"#,
    ],
    refused: &[
        r#"format = "grbl", touch = []"#,
        r#"format = "grbl""#,
        r#"touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "grbr", touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "grbl", touch = [{ rows = "1" }]"#,
        r#"format = "grbl", touch = [{ surface = "+x" }]"#,
        r#"format = "grbl", touch = [{ surface = "+x", points = [] }]"#,
        r#"format = "grbl", touch = [{ surface = "+x", rows = "one" }]"#,
        r#"format = "grbl", touch = [{ surface = "+x", rows = 1 }]"#,
        r#"format = "grbl", touch = [{ surface = "+x", rows = "1" }], ignore = {}"#,
        r#"format = "grbl", columns = { at = [1, 2, 3] }, touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "csv", touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "csv", columns = { at = [0, 2, 3] }, touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "csv", columns = { at = [1, 2, "Z"] }, touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "dmis", base = 2, tool = " ", touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "dmis", base = -1, touch = [{ surface = "+x", rows = "1" }]"#,
        r#"format = "dmis", compensated = 1, touch = [{ surface = "+x", rows = "1" }]"#,
    ],
};

/// What stands beside units and a cube.
const WHOLE: Cases = Cases {
    before: "units = \"mm\"\nfixture = { kind = \"cube\", edge = 50 }\n",
    after: "",
    accepted: &["", "touch = []", r#"touches = "t.csv""#, r#"touch = [{ surface = "+x", at = [1, 2, 3] }]"#],
    refused: &[
        r#"unit = "mm""#,
        r#"touch = { surface = "+x", at = [1, 2, 3] }"#,
        r#"touches = ["t.csv"]"#,
        "placement = []",
        "touch = [{ surface = \"+x\", at = [1, 2, 3] }]\ntouches = \"t.csv\"",
        "touch = [{ surface = \"+x\", at = [1, 2, 3] }]\nplacement = [{ touches = \"t.csv\" }]",
    ],
};

/// Whole documents that are none.
const NONE: Cases = Cases {
    before: "",
    after: "",
    accepted: &[],
    refused: &[
        "",
        "units = \"mm\"",
        "fixture = { kind = \"cube\", edge = 50 }",
        "units = \"cm\"\nfixture = { kind = \"cube\", edge = 50 }",
        "units = 1\nfixture = { kind = \"cube\", edge = 50 }",
        "units = \"mm\"\nfixture = \"cube\"",
    ],
};

#[test]
fn both_say_what_is_expected() {
    let both = Both::new();
    for cases in [FIXTURES, SURFACES, PROBES, TOUCHES, PLACEMENTS, LOGS, WHOLE, NONE] {
        let Cases { before, after, accepted, refused } = cases;
        let of = |texts: &'static [&'static str], expected| texts.iter().map(move |text| (text, expected));
        for (text, expected) in of(accepted, true).chain(of(refused, false)) {
            assert_eq!(both.accept(&toml(&format!("{before}{text}{after}"))), expected, "{text}");
        }
    }
    for document in [json!(null), json!([]), json!("units")] {
        assert!(!both.accept(&document));
    }
}

/// What a mutation puts in the place of a value.
fn anything(rng: &mut impl Rng) -> Value {
    let all = [
        json!(null),
        json!(true),
        json!(0),
        json!(2),
        json!(-3.5),
        json!(""),
        json!("mm"),
        json!("cube"),
        json!("1-2"),
        json!([]),
        json!([1, 2, 3]),
        json!(["a", "b", "c"]),
        json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        json!([{ "surface": "a", "at": [1, 2, 3] }]),
        json!({}),
        json!({ "value": 2, "u": 0.5 }),
        json!({ "value": 2, "u": 0 }),
    ];
    all.choose(rng).unwrap().clone()
}

/// Every key that a document may have, and some that none has.
const KEYS: &[&str] = &[
    "units",
    "fixture",
    "probe",
    "touches",
    "touch",
    "log",
    "placement",
    "kind",
    "radius",
    "radii",
    "edge",
    "angle_deg",
    "bore",
    "surface",
    "free",
    "size",
    "type",
    "name",
    "point",
    "axis",
    "normal",
    "from",
    "to",
    "within",
    "toward",
    "tip_radius",
    "sigma",
    "at",
    "id",
    "approach",
    "covariance",
    "file",
    "format",
    "columns",
    "base",
    "tool",
    "compensated",
    "ignore",
    "points",
    "rows",
    "value",
    "u",
    "Units",
    "comment",
    "$schema",
    "",
];

/// Changes one thing somewhere in the value.
fn mutate(value: &mut Value, rng: &mut impl Rng) {
    let deeper = match value {
        Value::Object(table) => !table.is_empty(),
        Value::Array(list) => !list.is_empty(),
        _ => false,
    };
    if deeper && rng.random_range(0..4) > 0 {
        match value {
            Value::Object(table) => {
                let key = table.keys().nth(rng.random_range(0..table.len())).unwrap().clone();
                mutate(&mut table[&key], rng);
            }
            Value::Array(list) => {
                let index = rng.random_range(0..list.len());
                mutate(&mut list[index], rng);
            }
            _ => {}
        }
        return;
    }
    let key = (*KEYS.choose(rng).unwrap()).to_owned();
    match (value, rng.random_range(0..5)) {
        (Value::Object(table), 0) if !table.is_empty() => {
            let gone = table.keys().nth(rng.random_range(0..table.len())).unwrap().clone();
            table.remove(&gone);
        }
        (Value::Object(table), 1) if !table.is_empty() => rename(table, key, rng),
        (Value::Object(table), 2) => {
            table.insert(key, anything(rng));
        }
        (Value::Array(list), 0) if !list.is_empty() => {
            list.remove(rng.random_range(0..list.len()));
        }
        (Value::Array(list), 1 | 2) => list.push(anything(rng)),
        (value, _) => *value = anything(rng),
    }
}

fn rename(table: &mut Map<String, Value>, key: String, rng: &mut impl Rng) {
    let old = table.keys().nth(rng.random_range(0..table.len())).unwrap().clone();
    let value = table.remove(&old).unwrap();
    table.insert(key, value);
}

/// One or two things changed in a document: both accept it or both refuse it.
#[test]
fn both_agree_on_mutations_of_the_examples() {
    const TRIALS: u64 = 20_000;
    let (both, documents) = (Both::new(), documents());
    let mut accepted = 0;
    for trial in 0..TRIALS {
        let mut rng = generator(81, trial);
        let mut document = documents.choose(&mut rng).unwrap().clone();
        for _ in 0..rng.random_range(1..=2) {
            mutate(&mut document, &mut rng);
        }
        accepted += u64::from(both.accept(&document));
    }
    println!("{accepted} of {TRIALS} mutations accepted");
    // Neither always the one nor always the other.
    assert!((TRIALS / 20..TRIALS / 2).contains(&accepted), "{accepted}");
}
