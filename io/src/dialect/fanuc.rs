//! FANUC robots: user frames.

use touchref_core::{DialectPlugin, Units};

use super::{
    angles::Order,
    written::{Form, Written, number, whole},
};

/// FANUC robots.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "fanuc",
    summary: "FANUC robot: a user frame, by a TP program or by Direct Entry",
    origin: module_path!(),
    parameters: &[number("number of the user frame, and of the position register that carries it")],
    reference: "FANUC robot controller operator manual: user frame, Direct Entry; position registers",
    build: |parameters| {
        let n = whole(parameters, 1, 100)?;
        Ok(Box::new(Written {
            pattern: format!(
                "PR[{n},1]=#x ;\nPR[{n},2]=#y ;\nPR[{n},3]=#z ;\nPR[{n},4]=#c ;\nPR[{n},5]=#b ;\nPR[{n},6]=#a ;\nUFRAME[{n}]=PR[{n}] ;"
            ),
            units: Some(Units::Millimetre),
            decimals: [3, 3],
            rotation: Form::moving(Order::ZYX, ["R", "P", "W"]),
            parent: "the world frame of the robot, if the touches were read in UFRAME 0",
            usage: "lines of a TP program, which overwrite this position register (Cartesian \
                    representation); or type the six numbers X Y Z W P R into SETUP FRAMES, Direct \
                    Entry, in the order of the lines; three decimals are what the pendant takes",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
