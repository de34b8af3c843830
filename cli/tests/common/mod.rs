//! What the tests of the command share: the paper's measurement, and running the command on files of their own.

#![allow(dead_code)] // Each test uses its own part.

use std::{fs, path::Path, process::Output};

use serde_json::Value;
use tempfile::TempDir;

/// The paper's measurement, as the README's first command reads it.
pub(crate) fn paper() -> String {
    example("nederbragt-ravani.toml")
}

/// The paper's measurement without its touches.
pub(crate) fn without_touches() -> String {
    paper().split("[[touch]]").next().unwrap().to_owned()
}

/// The paper's touches as a table.
pub(crate) const TABLE: &str = "surface,x,y,z,id
cylinder,2.9270,2.0000,1.6250,x1
cylinder,1.7750,2.8000,1.4438,x2
cylinder,1.3730,2.6000,3.1166,x3
cylinder,3.5270,3.2000,3.1082,x4
plane,2.8250,2.4000,4.0395,x5
plane,3.9020,5.2000,4.0353,x6
plane,2.0480,5.2000,4.7853,x7
";

/// A number of a result.
pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// An example that users have, by the name of its file.
pub(crate) fn example(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name);
    fs::read_to_string(path).unwrap()
}

/// A folder in which the command runs.
pub(crate) struct Folder(pub(crate) TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// With a file.
    pub(crate) fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        fs::write(self.0.path().join(name), content).unwrap();
        self
    }

    /// Runs `touchref` with these arguments and this standard input.
    pub(crate) fn run(&self, args: &[&str], stdin: &[u8]) -> Output {
        assert_cmd::cargo::cargo_bin_cmd!("touchref")
            .current_dir(self.0.path())
            .args(args)
            .write_stdin(stdin)
            .output()
            .unwrap()
    }

    /// Runs it with `--format json`; returns the exit status and what it printed.
    pub(crate) fn json(&self, args: &[&str], stdin: &[u8]) -> (i32, Value) {
        let output = self.run(&[args, &["--format", "json"]].concat(), stdin);
        let text = String::from_utf8(output.stdout).unwrap();
        let value = serde_json::from_str(&text).unwrap_or_else(|error| {
            panic!("{args:?}: {error}: {text} {}", String::from_utf8_lossy(&output.stderr))
        });
        (output.status.code().unwrap(), value)
    }
}
