//! Four touches on an unrolled cylinder: layouts, and what they are worth with three touches of the plane.

use std::f64::consts::TAU;

use nalgebra::Point3;
use touchref::{Fixture, Observability, Parameters, Probe, Problem, Touch};

use super::{
    chart::{Anchor, Picture},
    fixture, solver,
};

/// A fixture of radius 20, as `examples/acceptance_study.rs` has it, and touches good to 0.01.
const RADIUS: f64 = 20.0;
const SIGMA: f64 = 0.01;
/// Where the cylinder can be touched.
const ENDS: [f64; 2] = [-80.0, -20.0];

/// Turn in degrees and height in parts of the reach of each touch of the cylinder.
const LAYOUTS: [(&str, [[f64; 2]; 4]); 6] = [
    ("two at each end, opposite", [[135.0, 0.0], [225.0, 0.0], [315.0, 1.0], [45.0, 1.0]]),
    ("the same, turned by 90°", [[225.0, 0.0], [315.0, 0.0], [45.0, 1.0], [135.0, 1.0]]),
    ("both ends alike", [[135.0, 0.0], [225.0, 0.0], [135.0, 1.0], [225.0, 1.0]]),
    ("low, high, low, high", [[45.0, 0.0], [135.0, 1.0], [225.0, 0.0], [315.0, 1.0]]),
    ("a ring", [[45.0, 0.5], [135.0, 0.5], [225.0, 0.5], [315.0, 0.5]]),
    ("from one side", [[150.0, 0.0], [190.0, 0.0], [160.0, 1.0], [200.0, 1.0]]),
];

pub(super) fn drawn() -> String {
    const COLUMNS: usize = 3;
    const CELL: [f64; 2] = [243.0, 236.0];
    let title =
        "Six layouts of four touches on an unrolled cylinder, the condition of each and what becomes of it";
    let mut picture = Picture::new(title, 2.0 * CELL[1]);
    let parameters = Parameters::new().with("radius", RADIUS).with("angle_deg", 45.0);
    let fixture = fixture("cylinder-plane", &parameters);
    for (index, (name, touches)) in LAYOUTS.iter().enumerate() {
        let (row, column) = (index / COLUMNS, index % COLUMNS);
        let corner = [18.0 + column as f64 * CELL[0], 14.0 + row as f64 * CELL[1]];
        cell(&mut picture, corner, &*fixture, name, touches);
    }
    picture.finish()
}

fn cell(
    picture: &mut Picture,
    [left, top]: [f64; 2],
    fixture: &dyn Fixture,
    name: &str,
    layout: &[[f64; 2]; 4],
) {
    let (width, height) = (225.0, 130.0);
    picture.text([left, top + 16.0], "title", Anchor::Start, name);
    let (from, to) = ([left, top + 28.0], [left + width, top + 28.0 + height]);
    picture.rectangle("body", from, to);
    for quarter in [0.25, 0.5, 0.75] {
        let x = left + quarter * width;
        picture.line("axis", 0.4, &[[x, from[1]], [x, to[1]]]);
    }
    for [degrees, up] in layout {
        let at = [left + degrees / 360.0 * width, to[1] - (0.12 + 0.76 * up) * height];
        picture.dot("f1", at, 6.0);
    }
    let [condition, fate] = worth(fixture, layout);
    picture.text([left, to[1] + 20.0], "", Anchor::Start, &condition);
    picture.text([left, to[1] + 39.0], "", Anchor::Start, &fate);
}

/// The condition of a layout, and what the default solver says of touches without an error.
fn worth(fixture: &dyn Fixture, layout: &[[f64; 2]; 4]) -> [String; 2] {
    /// Beyond this a condition is that of rounding.
    const SINGULAR: f64 = 1e9;
    let on_cylinder = layout.map(|[degrees, up]| {
        let (sin, cos) = (degrees / 360.0 * TAU).sin_cos();
        Touch::new(0, Point3::new(RADIUS * cos, RADIUS * sin, ENDS[0] + up * (ENDS[1] - ENDS[0])))
    });
    let on_plane = fixture.nominal_layout().into_iter().filter(|(surface, _)| *surface == 1);
    let touches: Vec<Touch> =
        on_cylinder.into_iter().chain(on_plane.map(|(surface, at)| Touch::new(surface, at))).collect();
    let probe = Probe { sigma: Some(SIGMA), ..Probe::default() };
    let problem = Problem::new(fixture, &touches, probe).unwrap();
    let condition = Observability::at(&problem, &touchref::Frame::identity()).condition;
    let condition =
        if condition > SINGULAR { "singular".to_owned() } else { format!("condition {condition:.0}") };
    let fate = match solver().solve(&problem) {
        Ok(solution) => format!("one frame up to sigma {:.2}", solution.trust.up_to_sigma),
        Err(refusal) => format!("refused: {}", refusal.code()),
    };
    [condition, fate]
}
