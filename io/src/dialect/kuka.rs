//! KUKA robots: the `FRAME` of KRL.

use touchref_core::{DialectPlugin, ParameterKind, ParameterSpec, Units};

use super::{
    angles::Order,
    written::{Form, Written, variable},
};

/// KUKA KRL.
pub static PLUGIN: DialectPlugin = DialectPlugin {
    name: "kuka",
    summary: "KUKA KRL: a FRAME, as BASE_DATA holds it",
    origin: module_path!(),
    parameters: &[ParameterSpec {
        name: "name",
        kind: ParameterKind::Name,
        default: Some("by hand, in front of the braces"),
        meaning: "variable that it is assigned to, as `BASE_DATA[3]`",
    }],
    reference: "KUKA System Software, operating and programming instructions: FRAME, $BASE",
    build: |parameters| {
        let assigned = match parameters.word("name") {
            "" => String::new(),
            _ => format!("{}=", variable(parameters, "name", "$[]")?),
        };
        Ok(Box::new(Written {
            pattern: assigned + "{X #x,Y #y,Z #z,A #a,B #b,C #c}",
            units: Some(Units::Millimetre),
            decimals: [4, 6],
            rotation: Form::moving(Order::ZYX, ["A", "B", "C"]),
            parent: "the frame the touches are told in: $ROBROOT or $WORLD, or the $BASE that was \
                     active ($POS_ACT is told in it)",
            usage: "write `BASE_DATA[n]=` in front ($config.dat; `--dialect kuka:BASE_DATA[3]` does) \
                    and use it by $BASE=BASE_DATA[n], or `DECL GLOBAL FRAME NAME=`; where touches \
                    were taken in another $BASE, compose: that base : this frame",
        }))
    },
};
touchref_core::register_dialect!(PLUGIN);
