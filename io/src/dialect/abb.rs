//! ABB robots: work objects of RAPID.

use touchref_core::{DialectPlugin, Units};

use super::written::{Form, Written, name, variable};

/// ABB RAPID.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "abb",
    summary: "ABB RAPID: a wobjdata with the frame as its user frame",
    origin: module_path!(),
    parameters: &[name("wFixture", "name of the work object")],
    reference: "ABB RAPID reference manual: wobjdata, orient",
    build: |parameters| {
        let name = variable(parameters, "name", "")?;
        Ok(Box::new(Written {
            pattern: format!(
                "PERS wobjdata {name}:=[FALSE,TRUE,\"\",[[#x,#y,#z],[#d,#a,#b,#c]],[[0,0,0],[1,0,0,0]]];"
            ),
            units: Some(Units::Millimetre),
            decimals: [4, 9],
            rotation: Form::QuaternionXyzw,
            parent: "the world frame of the robot, if the touches were taken in wobj0; a robtarget is \
                     relative to the work object of its move",
            usage: "a declaration of a program module; the measured frame is the user frame, the \
                    object frame is the identity; the quaternion stands as q1 to q4 = w, x, y, z (w \
                    first); the controller keeps single precision, about seven digits",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
