//! Position and quaternion, the form in which `--near` takes a frame.

use touchref_core::DialectPlugin;

use super::written::{Form, Written};

/// Position and quaternion.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "quaternion",
    summary: "x,y,z,qx,qy,qz,qw: position and quaternion, as --near takes them",
    origin: module_path!(),
    parameters: &[],
    reference: "S. W. Shepperd, \"Quaternion from Rotation Matrix\", J. Guidance and Control 1 (1978)",
    build: |_| {
        Ok(Box::new(Written {
            pattern: "#x,#y,#z,#a,#b,#c,#d".to_owned(),
            units: None,
            // What doubles near one have.
            decimals: [12, 16],
            rotation: Form::QuaternionXyzw,
            parent: "the frame the touches are told in",
            usage: "the quaternion stands as x, y, z, w (w last; ABB has it first)",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
