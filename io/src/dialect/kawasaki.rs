//! Kawasaki, Adept, Comau and Doosan: Z, then the Y so reached, then the Z so reached.

use touchref_core::{DialectPlugin, Units};

use super::{
    angles::Order,
    written::{Form, Written, name, variable},
};

/// Kawasaki AS.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "kawasaki",
    summary: "Kawasaki AS: a transformation value",
    origin: module_path!(),
    parameters: &[name("fixture", "name of the variable")],
    reference: "Kawasaki AS language reference manual: TRANS, BASE",
    build: |parameters| {
        let name = variable(parameters, "name", "")?;
        Ok(Box::new(Written {
            pattern: format!("POINT {name} = TRANS(#x,#y,#z,#a,#b,#c)"),
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::ZYZ, ["O", "A", "T"]),
            parent: "the base frame of the robot",
            usage: "BASE followed by its name makes it the base",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);

/// Adept V+.
pub static ADEPT: DialectPlugin = DialectPlugin {
    name: "adept",
    summary: "Adept V+: a transformation",
    origin: module_path!(),
    parameters: &[name("fixture", "name of the variable")],
    reference: "Adept V+ language reference guide: TRANS",
    build: |parameters| {
        let name = variable(parameters, "name", ".")?;
        Ok(Box::new(Written {
            pattern: format!("SET {name} = TRANS(#x,#y,#z,#a,#b,#c)"),
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::ZYZ, ["yaw", "pitch", "roll"]),
            parent: "the base frame of the robot",
            usage: "yaw, pitch and roll are here angles about Z, Y and Z; verify the statement on the \
                    machine",
        }))
    },
};
touchref_core::register_dialect!(ADEPT);

/// Comau PDL2.
pub static COMAU: DialectPlugin = DialectPlugin {
    name: "comau",
    summary: "Comau PDL2: a position",
    origin: module_path!(),
    parameters: &[name("fixture", "name of the variable")],
    reference: "Comau PDL2 programming language manual: POS",
    build: |parameters| {
        let name = variable(parameters, "name", "$")?;
        Ok(Box::new(Written {
            pattern: format!("{name} := POS(#x,#y,#z,#a,#b,#c,'')"),
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::ZYZ, ["A", "E", "R"]),
            parent: "the base frame of the robot",
            usage: "for $UFRAME, say; verify the statement on the machine",
        }))
    },
};
touchref_core::register_dialect!(COMAU);

/// Doosan DRL.
pub static DOOSAN: DialectPlugin = DialectPlugin {
    name: "doosan",
    summary: "Doosan DRL: a task position",
    origin: module_path!(),
    parameters: &[name("fixture", "name of the variable")],
    reference: "Doosan Robotics programming manual: posx",
    build: |parameters| {
        let name = variable(parameters, "name", "")?;
        Ok(Box::new(Written {
            pattern: format!("{name} = posx(#x,#y,#z,#a,#b,#c)"),
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::ZYZ, ["a", "b", "c"]),
            parent: "the base frame of the robot",
            usage: "a task position; as user coordinates by the command for these",
        }))
    },
};
touchref_core::register_dialect!(DOOSAN);
