//! Three angles in any order: for machines that no other dialect is for.

use touchref_core::{DialectPlugin, ParameterKind, ParameterSpec};

use super::{
    angles::Order,
    written::{Form, Written},
};

/// Position and three angles.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "euler",
    summary: "x y z and three angles, euler:<order>:<intrinsic|extrinsic>:<deg|rad>, as \
              euler:zyx:intrinsic:deg",
    origin: module_path!(),
    parameters: &[
        ParameterSpec {
            name: "order",
            kind: ParameterKind::Choice(Order::NAMES),
            default: None,
            meaning: "axes in the order in which the angles turn, and are printed",
        },
        ParameterSpec {
            name: "axes",
            kind: ParameterKind::Choice(&["intrinsic", "extrinsic"]),
            default: None,
            meaning: "whether the axes move with the frame, or stay the parent's",
        },
        ParameterSpec {
            name: "angles",
            kind: ParameterKind::Choice(&["deg", "rad"]),
            default: None,
            meaning: "unit of the angles",
        },
    ],
    reference: "J. Diebel, \"Representing Attitude: Euler Angles, Unit Quaternions, and Rotation \
                Vectors\", 2006",
    build: |parameters| {
        let radians = parameters.word("angles") == "rad";
        Ok(Box::new(Written {
            pattern: "#x #y #z #a #b #c".to_owned(),
            units: None,
            decimals: [9, if radians { 12 } else { 10 }],
            rotation: Form::Angles {
                // Checked by the parameter's description.
                order: Order::from_name(parameters.word("order")).unwrap_or(Order::ZYX),
                fixed: parameters.word("axes") == "extrinsic",
                names: ["a", "b", "c"],
                radians,
            },
            parent: "the frame the touches are told in",
            usage: "the numbers stand as x y z a b c",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
