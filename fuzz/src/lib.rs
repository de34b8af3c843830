//! What is fuzzed. A target hands bytes to one way into touchref and asserts what must hold of whatever comes out: nothing
//! panics, what is refused is told with its place, and what is accepted is sound.
//!
//! The fuzzer's binaries (`fuzz_targets/`) and a test of the workspace (`tests/fuzz.rs`) run the same targets.

#![allow(unreachable_pub, reason = "a test takes this file as a module")]

mod structured;
mod text;

/// What a target does with its input.
pub type Target = fn(&[u8]);

/// Every target by name.
pub const TARGETS: &[(&str, Target)] = &[
    ("calibration", text::calibration),
    ("dialect", text::dialect),
    ("frame", text::frame),
    ("locate", structured::locate),
    ("locate_everywhere", structured::locate_everywhere),
    ("log_abb_mod", |data| text::log("abb-mod", data)),
    ("log_csv", |data| text::log("csv", data)),
    ("log_dmis", |data| text::log("dmis", data)),
    ("log_fanuc_ls", |data| text::log("fanuc-ls", data)),
    ("log_fanuc_posreg", |data| text::log("fanuc-posreg", data)),
    ("log_grbl", |data| text::log("grbl", data)),
    ("log_kuka_dat", |data| text::log("kuka-dat", data)),
    ("log_linuxcnc_probe", |data| text::log("linuxcnc-probe", data)),
    ("log_ur_rtde", |data| text::log("ur-rtde", data)),
    ("log_urscript", |data| text::log("urscript", data)),
    ("measurement_json", |data| text::measurement("m.json", data)),
    ("measurement_toml", |data| text::measurement("m.toml", data)),
    ("registry", structured::registry),
    ("result", text::result),
    ("touch_table", text::touch_table),
];

/// Runs the target of this name.
///
/// # Panics
/// When there is none, and when what must hold does not.
pub fn run(name: &str, data: &[u8]) {
    let target = TARGETS.iter().find(|(known, _)| *known == name);
    target.unwrap_or_else(|| panic!("no target is named {name}")).1(data);
}
