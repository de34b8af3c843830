//! `LinuxCNC`: work offsets, which cannot be tilted, and the tilted work plane of its simulation.

use touchref_core::{DialectPlugin, ParameterKind, ParameterSpec, Units};

use super::{
    angles::Order,
    written::{Form, Written, number, whole},
};

/// The largest tilt in degrees that a work offset leaves out unasked: what the third decimal of its angle shows, 17 um
/// a metre away.
const TILT: &str = "0.001";

/// Work offsets of `LinuxCNC`.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "linuxcnc",
    summary: "LinuxCNC: a work offset by G10 L2 (G54 is 1), turned about Z; refuses a tilt",
    origin: module_path!(),
    parameters: &[
        number("number of the work offset, 1 to 9: 1 is G54"),
        ParameterSpec {
            name: "tilt",
            kind: ParameterKind::Angle { above: 0.0, below: 10.0 },
            default: Some(TILT),
            meaning: "the largest tilt in degrees that may be left out",
        },
        ParameterSpec {
            name: "units",
            kind: ParameterKind::Choice(&["mm", "in"]),
            default: Some("mm"),
            meaning: "unit of the lines: G21 or G20",
        },
    ],
    reference: "LinuxCNC documentation, G10 L2; interp_read.cc",
    build: |parameters| {
        let n = whole(parameters, 1, 9)?;
        let (units, code) = match parameters.word("units") {
            "in" => (Units::Inch, "G20"),
            _ => (Units::Millimetre, "G21"),
        };
        Ok(Box::new(Written {
            pattern: format!("{code}\nG10 L2 P{n} X#x Y#y Z#z R#a"),
            units: Some(units),
            decimals: [6, 6],
            rotation: Form::AboutZ { tilt: parameters.number("tilt").to_radians() },
            parent: "the machine's coordinates, in which the touches must be told",
            usage: "two lines of a program or of MDI; the unit of the first line stays active",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);

/// The tilted work plane of `LinuxCNC`.
pub static TILTED: DialectPlugin = DialectPlugin {
    name: "linuxcnc-g68",
    summary: "LinuxCNC: tilted work plane by G68.2, where the configuration remaps it",
    origin: module_path!(),
    parameters: &[],
    reference: "LinuxCNC, remap of the tilted work plane in its simulated configurations",
    build: |_| {
        Ok(Box::new(Written {
            pattern: "G68.2 P0 Q313 X#x Y#y Z#z I#a J#b K#c".to_owned(),
            units: Some(Units::Millimetre),
            decimals: [6, 6],
            rotation: Form::moving(Order::ZXZ, ["I", "J", "K"]),
            parent: "the active work offset, in which the touches must be told",
            usage: "in mm (G21); a Python remap of a simulated configuration, not part of the core: \
                    verify on the machine",
        }))
    },
};
touchref_core::register_dialect!(TILTED);
