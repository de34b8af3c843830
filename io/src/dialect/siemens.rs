//! Siemens 840D and 828D: settable frames.

use touchref_core::{DialectPlugin, Units};

use super::{
    angles::Order,
    written::{Form, Written, number, whole},
};

/// Siemens SINUMERIK.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "siemens",
    summary: "Siemens 840D/828D: a settable frame (G54 is 1)",
    origin: module_path!(),
    parameters: &[number("number of the settable frame: 1 is G54")],
    reference: "Siemens SINUMERIK job planning manual: frames, CTRANS, CROT, MD10600",
    build: |parameters| {
        let n = whole(parameters, 1, 99)?;
        Ok(Box::new(Written {
            pattern: format!("$P_UIFR[{n}]=CTRANS(X,#x,Y,#y,Z,#z):CROT(X,#c,Y,#b,Z,#a)"),
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::ZYX, ["Z", "Y", "X"]),
            parent: "the basic coordinate system, in which the touches must be told",
            usage: "for MD10600 = 1 (RPY, the default) and lengths in mm; the control reads the same \
                    triple back: X and Z within 180 degrees, Y within 90",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
