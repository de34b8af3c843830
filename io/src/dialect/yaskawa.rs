//! Yaskawa robots: user frames.

use touchref_core::{DialectPlugin, Units};

use super::{
    angles::Order,
    written::{Form, Written},
};

/// Yaskawa.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "yaskawa",
    summary: "Yaskawa: the numbers of a user frame, as UFRAME.CND holds them",
    origin: module_path!(),
    parameters: &[],
    reference: "Yaskawa Motoman instructions: user coordinates, UFRAME.CND",
    build: |_| {
        Ok(Box::new(Written {
            pattern: "///BUSER #x,#y,#z,#c,#b,#a".to_owned(),
            units: Some(Units::Millimetre),
            decimals: [3, 4],
            rotation: Form::moving(Order::ZYX, ["Rz", "Ry", "Rx"]),
            parent: "the base frame of the robot",
            usage: "the six numbers X Y Z Rx Ry Rz to type in; in a file UFRAME.CND the line stands in the section \
                    of its frame, beside the pulses of the taught points: verify such a file on the machine",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
