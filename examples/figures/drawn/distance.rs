//! How sure a frame is away from the fixture: the worst standard uncertainty of a point, over its distance.

use nalgebra::{Point3, Vector3};
use touchref::{Frame, Parameters, Probe, Problem, Touch, analysis::Uncertainty};

use super::{
    chart::{Anchor, Field, Picture, Scale},
    fixture,
};

const SIGMA: f64 = 0.01;

pub(super) fn drawn() -> String {
    let new = Parameters::new;
    let three = new().with("radius", 12.7).with("ab", 100.0).with("bc", 100.0).with("ca", 100.0);
    let fixtures = [
        (
            "cylinder-plane, radius 20",
            "0",
            "cylinder-plane",
            new().with("radius", 20.0).with("angle_deg", 45.0),
        ),
        ("cube, edge 50", "1", "cube", new().with("edge", 50.0)),
        ("three-sphere, sides 100", "2", "three-sphere", three),
    ];
    let title =
        "Worst standard uncertainty of a point over its distance from the touches, for three fixtures";
    let mut picture = Picture::new(title, 400.0);
    let x = Scale::Linear { from: 0.0, to: 500.0 };
    let y = Scale::Linear { from: 0.0, to: 0.3 };
    let field = Field { left: 70.0, right: 735.0, top: 44.0, bottom: 345.0, x, y };
    let along = [(0.0, "0"), (100.0, "100"), (200.0, "200"), (300.0, "300"), (400.0, "400"), (500.0, "500")];
    let up = [(0.0, "0"), (0.1, "0.1"), (0.2, "0.2"), (0.3, "0.3")];
    let names = [
        "distance from the middle of the touches, mm",
        "worst standard uncertainty, mm, for touches of 0.01 mm",
    ];
    field.draw(&mut picture, &along, &up, names);
    for (index, (name, class, kind, parameters)) in fixtures.into_iter().enumerate() {
        let fixture = fixture(kind, &parameters);
        let layout = fixture.nominal_layout();
        let touches: Vec<Touch> = layout.iter().map(|(surface, at)| Touch::new(*surface, *at)).collect();
        let probe = Probe { sigma: Some(SIGMA), ..Probe::default() };
        let problem = Problem::new(&*fixture, &touches, probe).unwrap();
        let uncertainty = Uncertainty::of(&problem, &Frame::identity()).unwrap();
        let middle = problem.centroid();
        let worst = |distance: f64| {
            let at = |direction: Vector3<f64>| -> Point3<f64> { middle + direction * distance };
            let six = (0..6).map(|k| Vector3::ith(k / 2, if k % 2 == 0 { 1.0 } else { -1.0 }));
            six.map(|direction| uncertainty.of_point(&at(direction)).worst().0).fold(0.0, f64::max)
        };
        let points: Vec<[f64; 2]> = (0..=50).map(|k| 10.0 * f64::from(k)).map(|d| [d, worst(d)]).collect();
        field.curve(&mut picture, &format!("s{class}"), &points);
        let row = 66.0 + 22.0 * index as f64;
        picture.line(&format!("s{class}"), 2.0, &[[90.0, row - 5.0], [116.0, row - 5.0]]);
        picture.text([124.0, row], "", Anchor::Start, &format!("{name}, {} touches", touches.len()));
    }
    picture.finish()
}
