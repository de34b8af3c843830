//! Mitsubishi robots: positions of MELFA-BASIC.

use touchref_core::{DialectPlugin, Units};

use super::{
    angles::Order,
    written::{Form, Written, name, variable},
};

/// Mitsubishi MELFA-BASIC.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "mitsubishi",
    summary: "Mitsubishi MELFA-BASIC: a position",
    origin: module_path!(),
    parameters: &[name("PFixture", "name of the variable; positions begin with P")],
    reference: "Mitsubishi MELFA-BASIC programming manual: position data",
    build: |parameters| {
        let name = variable(parameters, "name", "")?;
        Ok(Box::new(Written {
            pattern: format!("{name}=(#x,#y,#z,#c,#b,#a)(0,0)"),
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::ZYX, ["C", "B", "A"]),
            parent: "the base frame of the robot",
            usage: "the structure flags in the second brackets mean nothing for a frame: verify them \
                    on the machine",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
