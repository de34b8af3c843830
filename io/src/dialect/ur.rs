//! Universal Robots: poses of `URScript`.

use touchref_core::{DialectPlugin, Units};

use super::written::{Form, Written, name, variable};

/// Universal Robots.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "ur",
    summary: "Universal Robots URScript: a pose variable, metres and rotation vector",
    origin: module_path!(),
    parameters: &[name("fixture", "name of the variable")],
    reference: "Universal Robots script manual: pose, pose_trans",
    build: |parameters| {
        let name = variable(parameters, "name", "")?;
        Ok(Box::new(Written {
            pattern: format!("{name} = p[#x,#y,#z,#a,#b,#c]"),
            units: Some(Units::Metre),
            decimals: [9, 9],
            rotation: Form::RotationVector,
            parent: "the controller's `base`, if the touches were read in it; ROS `base_link` differs \
                     from it by 180 degrees about Z",
            usage: "use it by pose_trans(fixture, p[...]); at an angle of pi the vector of the other \
                    sign is the same rotation; the pendant shows mm, and may show degrees",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
