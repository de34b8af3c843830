//! FANUC CNC: tilted work plane.

use touchref_core::{DialectPlugin, Units};

use super::{
    angles::Order,
    written::{Form, Written},
};

/// FANUC CNC.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "fanuc-cnc",
    summary: "FANUC CNC: tilted work plane, G68.2",
    origin: module_path!(),
    parameters: &[],
    reference: "FANUC CNC operator manual: tilted working plane indexing, G68.2",
    build: |_| {
        Ok(Box::new(Written {
            pattern: "G68.2 X#x Y#y Z#z I#a J#b K#c".to_owned(),
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::ZXZ, ["I", "J", "K"]),
            parent: "the active work offset, in which the touches must be told",
            usage: "in mm (G21); G53.1 afterwards moves the rotary axes; verify on the machine \
                    whether it wants the attitude of the table or of the tool",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
