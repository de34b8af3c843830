//! ROS 2 and URDF: metres and radians.

use touchref_core::{DialectPlugin, Units};

use super::{
    angles::Order,
    written::{Form, Written, variable, word},
};

/// ROS 2.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "ros2",
    summary: "ROS 2: static_transform_publisher, by quaternion",
    origin: module_path!(),
    parameters: &[
        word("parent", "base", "frame id of the parent, in which the touches are told"),
        word("child", "fixture", "frame id of the fixture"),
    ],
    reference: "ros2/geometry2: static_transform_publisher",
    build: |parameters| {
        let (parent, child) = (variable(parameters, "parent", "/")?, variable(parameters, "child", "/")?);
        Ok(Box::new(Written {
            pattern: format!(
                "ros2 run tf2_ros static_transform_publisher --x #x --y #y --z #z \
                 --qx #a --qy #b --qz #c --qw #d \
                 --frame-id {parent} --child-frame-id {child}"
            ),
            units: Some(Units::Metre),
            decimals: [9, 9],
            rotation: Form::QuaternionXyzw,
            parent: "the frame of --frame-id, which must be the one in which the touches are told",
            usage: "a command line; the quaternion stands as x, y, z, w",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);

/// URDF.
pub static URDF: DialectPlugin = DialectPlugin {
    name: "urdf",
    summary: "URDF: the origin of a joint, by roll, pitch and yaw",
    origin: module_path!(),
    parameters: &[],
    reference: "ros/urdfdom: pose",
    build: |_| {
        Ok(Box::new(Written {
            pattern: "<origin xyz=\"#x #y #z\" rpy=\"#a #b #c\"/>".to_owned(),
            units: Some(Units::Metre),
            decimals: [9, 9],
            rotation: Form::Angles {
                order: Order::XYZ,
                fixed: true,
                names: ["roll", "pitch", "yaw"],
                radians: true,
            },
            parent: "the link of the parent, which must be the one in which the touches are told",
            usage: "an element of a joint; readers may snap angles near a pitch of 90 degrees, where \
                    `ros2` is the safer",
        }))
    },
};
touchref_core::register_dialect!(URDF);
