//! Staubli and Mecademic: X, then the Y so reached, then the Z so reached.

use touchref_core::{DialectPlugin, Units};

use super::{
    angles::Order,
    written::{Form, Written, name, variable},
};

/// Staubli VAL3.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "staubli",
    summary: "Staubli VAL3: an element of a frame variable in the data file of an application",
    origin: module_path!(),
    parameters: &[name("fFixture", "name of the variable")],
    reference: "Staubli VAL3 reference manual: frame",
    build: |parameters| {
        let name = variable(parameters, "name", "")?;
        Ok(Box::new(Written {
            pattern: format!(
                "<Data name=\"{name}\" access=\"private\" xsi:type=\"array\" type=\"frame\" size=\"1\">\
                 <Value key=\"0\" x=\"#x\" y=\"#y\" z=\"#z\" rx=\"#a\" ry=\"#b\" rz=\"#c\" fatherId=\"world[0]\"/></Data>"
            ),
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::XYZ, ["rx", "ry", "rz"]),
            parent: "the world frame, as its fatherId says",
            usage: "an element of the .dtx file of the application",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);

/// Mecademic.
pub static MECADEMIC: DialectPlugin = DialectPlugin {
    name: "mecademic",
    summary: "Mecademic: the command SetWRF",
    origin: module_path!(),
    parameters: &[],
    reference: "Mecademic programming manual: SetWRF",
    build: |_| {
        Ok(Box::new(Written {
            pattern: "SetWRF(#x,#y,#z,#a,#b,#c)".to_owned(),
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::XYZ, ["alpha", "beta", "gamma"]),
            parent: "the base frame of the robot",
            usage: "makes this the world reference frame; verify the command on the machine",
        }))
    },
};
touchref_core::register_dialect!(MECADEMIC);
