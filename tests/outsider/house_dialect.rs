//! `house`: a frame as the works' own database keeps it: six integers, micrometres and microradians.
//!
//! An example of a dialect in one file.

use nalgebra::{Point3, Rotation3, Vector3};
use touchref::{Convention, Dialect, DialectPlugin, Frame, Loss, Units};

/// The plugin.
pub(crate) static PLUGIN: DialectPlugin = DialectPlugin {
    name: "house",
    summary: "six integers: micrometres, and a rotation vector in microradians",
    origin: module_path!(),
    parameters: &[],
    reference: "house standard 12-4",
    build: |_| Ok(Box::new(House)),
};
touchref::register_dialect!(PLUGIN);

/// Six integers.
#[derive(Debug)]
struct House;

impl Dialect for House {
    fn convention(&self) -> Convention {
        Convention {
            parent: "the machine",
            units: Some(Units::Micrometre),
            angles: "microradians",
            digits: "whole numbers".to_owned(),
            rotation: "axis times angle".to_owned(),
            usage: "a row of the table of fixtures",
            loss: Loss { length: 0.5, angle: 1e-6 },
            omission: None,
        }
    }

    fn print(&self, frame: &Frame) -> String {
        let [x, y, z] = frame.origin.coords.into();
        let [a, b, c] = (frame.rotation_vector() * 1e6).into();
        [x, y, z, a, b, c].map(|v| format!("{v:.0}")).join(" ")
    }

    fn parse(&self, literal: &str) -> Option<Frame> {
        let numbers: Vec<f64> = literal.split(' ').map(|word| word.parse().ok()).collect::<Option<_>>()?;
        let [x, y, z, a, b, c] = numbers[..] else { return None };
        let rotation = Rotation3::from_scaled_axis(Vector3::new(a, b, c) * 1e-6);
        Some(Frame { rotation, origin: Point3::new(x, y, z) })
    }
}
