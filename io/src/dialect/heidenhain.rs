//! Heidenhain controls: datum shift and tilted plane.

use touchref_core::{DialectPlugin, Units};

use super::{
    angles::Order,
    written::{Form, Written},
};

/// Heidenhain Klartext.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "heidenhain",
    summary: "Heidenhain Klartext: datum shift and PLANE SPATIAL",
    origin: module_path!(),
    parameters: &[],
    reference: "Heidenhain Klartext user manual: cycle 7, PLANE SPATIAL",
    build: |_| {
        Ok(Box::new(Written {
            pattern: "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X#+x\nCYCL DEF 7.2 Y#+y\nCYCL DEF 7.3 Z#+z\n\
                      PLANE SPATIAL SPA#+c SPB#+b SPC#+a STAY"
                .to_owned(),
            units: Some(Units::Millimetre),
            decimals: [4, 4],
            rotation: Form::moving(Order::ZYX, ["SPC", "SPB", "SPA"]),
            parent: "the active datum, about whose axes the touches must be told",
            usage: "SPA turns about the fixed X, then SPB about the fixed Y, then SPC about the fixed \
                    Z; STAY moves no axis, TURN or MOVE with their feed rate and set-up clearance \
                    would; verify the datum shift on the machine",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
