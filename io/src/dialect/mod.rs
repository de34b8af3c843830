//! A frame in the words of the machine that will use it.
//!
//! One file a family of machines; `written` is what nearly all of them are, a text with numbers in it, and `angles` turns
//! rotations into triples and back. A dialect is a [plugin](DialectPlugin) like fixtures and solvers: another crate adds
//! its own with `register_dialect!`. What is printed is read back before it is handed out: see
//! [`Literal`](touchref_core::Literal).

pub mod abb;
mod angles;
pub mod euler;
pub mod fanuc;
pub mod fanuc_cnc;
pub mod heidenhain;
pub mod kawasaki;
pub mod kuka;
pub mod linuxcnc;
pub mod matrix;
pub mod mitsubishi;
pub mod quaternion;
pub mod ros;
pub mod siemens;
pub mod staubli;
pub mod ur;
mod written;
pub mod yaskawa;

use touchref_core::{Dialect, DialectPlugin, ParameterKind, Parameters, Registry};

use crate::{InputError, parameter};

/// Every dialect of this crate, for programs whose linker drops what was registered.
pub static ALL: &[&DialectPlugin] = &[
    &abb::PLUGIN,
    &euler::PLUGIN,
    &fanuc::PLUGIN,
    &fanuc_cnc::PLUGIN,
    &heidenhain::PLUGIN,
    &kawasaki::ADEPT,
    &kawasaki::COMAU,
    &kawasaki::DOOSAN,
    &kawasaki::PLUGIN,
    &kuka::PLUGIN,
    &linuxcnc::PLUGIN,
    &linuxcnc::TILTED,
    &matrix::FRANKA,
    &matrix::PLUGIN,
    &mitsubishi::PLUGIN,
    &quaternion::PLUGIN,
    &ros::PLUGIN,
    &ros::URDF,
    &siemens::PLUGIN,
    &staubli::MECADEMIC,
    &staubli::PLUGIN,
    &ur::PLUGIN,
    &yaskawa::PLUGIN,
];

/// The dialect that a text names: `kuka`, or with values of its parameters after colons, by their order or by name:
/// `euler:zyx:intrinsic:deg`, `linuxcnc:tilt=0.02`.
///
/// # Errors
/// `unknown-dialect`, with the nearest known name; `unknown-key`, `missing-key` or `invalid-input` for its parameters.
pub fn find(registry: &Registry, text: &str) -> Result<Box<dyn Dialect>, InputError> {
    build(registry, text).map_err(|error| error.with_key("dialect"))
}

fn build(registry: &Registry, text: &str) -> Result<Box<dyn Dialect>, InputError> {
    let mut words = text.split(':');
    let plugin = registry.dialect(words.next().unwrap_or_default())?;
    let told = format!("dialect `{}`", plugin.name);
    let wrong = |problem: String, nearest: Option<&str>| {
        let call = format!("it is asked for by `{}`", call(plugin));
        let help = nearest.map_or(call.clone(), |name| format!("did you mean `{name}`? {call}"));
        InputError::new("invalid-input", format!("{told}: {problem}")).with_help(help).with_nearest(nearest)
    };
    let mut parameters = Parameters::new();
    for (index, word) in words.enumerate() {
        let by_order = || plugin.parameters.get(index).map(|spec| (spec.name, word));
        let (name, value) = word
            .split_once('=')
            .or_else(by_order)
            .ok_or_else(|| wrong(format!("there is no parameter for `{word}`"), None))?;
        if parameters.get(name).is_some() {
            return Err(wrong(format!("parameter `{name}` is given twice"), None));
        }
        parameters.set(name, parameter::from_argument(&told, plugin.parameters, name, value)?);
    }
    plugin.build(&parameters).map_err(|error| wrong(error.to_string(), error.nearest.as_deref()))
}

/// How a dialect is asked for: `euler:<order>:<intrinsic|extrinsic>:<deg|rad>`, `linuxcnc[:NUMBER][:TILT][:UNITS]`.
#[must_use]
pub fn call(plugin: &DialectPlugin) -> String {
    /// More words than this do not read well in one line.
    const FEW: usize = 4;
    let values = plugin.parameters.iter().map(|spec| match (spec.default, spec.kind) {
        (Some(_), _) => format!("[:{}]", spec.name.to_uppercase()),
        (None, ParameterKind::Choice(words)) if words.len() <= FEW => format!(":<{}>", words.join("|")),
        (None, _) => format!(":<{}>", spec.name),
    });
    format!("{}{}", plugin.name, values.collect::<String>())
}
