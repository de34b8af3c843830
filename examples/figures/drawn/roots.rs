//! Equation (1) over the direction of the axis, and the radius that four touches have from there.
//!
//! The curve is the paper's formula as it stands, the roots are those that the fixture's closed form hands out.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector2, Vector3};
use touchref::{Fixture, Frame, Parameters, Probe, Problem, RootKind, Touch, fixtures::algebra::Circle};

use super::{
    chart::{Anchor, Field, Picture, Scale},
    fixture, paper, touches,
};

/// Directions of a curve.
const STEPS: i32 = 1440;

pub(super) fn of_the_paper() -> String {
    let setup = paper();
    let title = "Equation (1) over the direction of the axis: four roots, one with the known radius 1";
    let touches = &setup.touches().unwrap().touches;
    drawn(&*setup.fixture, touches, title, (1.0, 45.0, &[0.9, 1.0, 1.1, 1.2, 1.3]))
}

/// Touches of a bore with six roots: one of the cases that `tests/oracle/cylinder_plane_roots.py` solves at 60 digits.
pub(super) fn six() -> String {
    const CYLINDER: [[f64; 3]; 4] = [
        [6.118_672_100_383_093, 1.078_104_807_901_546_5, -2.360_331_785_722_36],
        [3.177_305_393_341_251_6, 0.441_791_890_680_988_6, -2.042_728_625_541_46],
        [3.667_491_804_530_031_5, 0.409_507_432_767_132_1, -1.431_567_489_818_052_6],
        [2.603_885_381_162_291, 1.466_994_983_643_139_5, -2.249_818_774_586_589_4],
    ];
    const PLANE: [[f64; 3]; 3] = [
        [2.302_853_538_148_904_4, 1.640_231_967_590_453, -0.444_510_547_372_482_63],
        [2.703_230_122_660_537_3, 1.461_861_408_413_913_4, -0.009_077_102_393_605_627],
        [0.099_955_938_222_032_05, 1.520_168_672_805_834_2, 0.700_457_044_004_201_4],
    ];
    let parameters = Parameters::new().with("radius", 0.8).with("angle_deg", 75.0).with("bore", true);
    let fixture = fixture("cylinder-plane", &parameters);
    let touches = touches(&*fixture, &[("cylinder", &CYLINDER), ("plane", &PLANE)]);
    let title = "Equation (1) over the direction of the axis for touches that have six roots";
    drawn(&*fixture, &touches, title, (0.8, 75.0, &[0.5, 1.0, 1.5, 2.0, 2.5]))
}

/// The circle of axis directions about a plane's normal, and four touches seen from it.
pub(super) struct Circling {
    /// Two directions in the plane, and its normal.
    axes: [Vector3<f64>; 3],
    angle: f64,
    at: Vec<Point3<f64>>,
}

impl Circling {
    /// `frame` is one of the fixture's, whose plane the touches tell exactly.
    pub(super) fn new(frame: &Frame, angle: f64, cylinder: Vec<Point3<f64>>) -> Self {
        let normal = frame.rotation * Vector3::new(-angle.sin(), 0.0, angle.cos());
        // The parent's own directions, as far as they lie in the plane: angles count from its x.
        let u = (Vector3::x() - normal * normal.x).normalize();
        Self { axes: [u, normal.cross(&u), normal], angle, at: cylinder }
    }

    fn direction(&self, phi: f64) -> Vector3<f64> {
        let [u, v, n] = self.axes;
        n * self.angle.cos() + (u * phi.cos() + v * phi.sin()) * self.angle.sin()
    }

    /// Degrees at which the axis of a frame is on the circle.
    pub(super) fn degrees(&self, frame: &Frame) -> f64 {
        let axis = frame.axis(2);
        self.axes[1].dot(&axis).atan2(self.axes[0].dot(&axis)).to_degrees().rem_euclid(360.0)
    }

    /// Equation (1) as the paper has it.
    fn equation(&self, phi: f64) -> f64 {
        let s = self.direction(phi);
        let p: [Vector3<f64>; 3] = [0, 1, 2].map(|i| self.at[i] - self.at[3]);
        let term = |i: usize| p[(i + 1) % 3].cross(&p[(i + 2) % 3]) * p[i].cross(&s).norm_squared();
        s.dot(&(term(0) + term(1) + term(2)))
    }

    /// The touches seen along the axis.
    pub(super) fn projected(&self, phi: f64) -> Vec<(f64, Vector2<f64>)> {
        let s = self.direction(phi);
        let x = s.cross(&self.axes[2]).normalize();
        let y = s.cross(&x);
        let flat = |at: &Point3<f64>| Vector2::new(x.dot(&(at - self.at[0])), y.dot(&(at - self.at[0])));
        self.at.iter().map(|at| (1.0, flat(at))).collect()
    }
}

/// So many directions around, in degrees, each with a number.
pub(super) fn around(number: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let at = |k: i32| f64::from(k) / f64::from(STEPS);
    (0..=STEPS).map(|k| [360.0 * at(k), number(TAU * at(k))]).collect()
}

/// Marks of a whole turn.
pub(super) const TURN: [(f64, &str); 5] =
    [(0.0, "0"), (90.0, "90"), (180.0, "180"), (270.0, "270"), (360.0, "360")];

fn drawn(
    fixture: &dyn Fixture,
    touches: &[Touch],
    title: &str,
    (radius, angle_deg, marks): (f64, f64, &[f64]),
) -> String {
    let problem = Problem::new(fixture, touches, Probe::default()).unwrap();
    let mut roots = Vec::new();
    let closed_form = fixture.closed_form().unwrap();
    closed_form.roots(&problem, &mut |root| roots.push(root)).unwrap();
    roots.retain(|root| root.kind == RootKind::Real);
    let cylinder = problem.touches_on(0).map(|(_, touch)| touch.at).collect();
    let circling = Circling::new(&roots[0].frame, f64::to_radians(angle_deg), cylinder);

    let mut picture = Picture::new(title, 560.0);
    let x = Scale::Linear { from: 0.0, to: 360.0 };
    let mut equation = around(|phi| circling.equation(phi));
    let most = equation.iter().map(|[_, value]| value.abs()).fold(0.0, f64::max);
    for [_, value] in &mut equation {
        *value /= most;
    }
    let y = Scale::Linear { from: -1.0, to: 1.0 };
    let above = Field { left: 70.0, right: 735.0, top: 44.0, bottom: 240.0, x, y };
    let words = "equation (1), in parts of its largest value";
    above.draw(&mut picture, &TURN, &[(-1.0, "-1"), (0.0, "0"), (1.0, "1")], ["", words]);
    above.level(&mut picture, 0.0);
    above.curve(&mut picture, "s0", &equation);

    let radii =
        around(|phi| Circle::nearest(&circling.projected(phi).into_iter()).map_or(f64::NAN, |c| c.0.radius));
    let y = Scale::Linear { from: marks[0], to: marks[marks.len() - 1] };
    let below = Field { top: 320.0, bottom: 510.0, y, ..above };
    let words = "radius of the circle nearest the four touches, seen along the axis";
    let names: Vec<String> = marks.iter().map(|mark| format!("{mark:.1}")).collect();
    let marks: Vec<(f64, &str)> = marks.iter().copied().zip(names.iter().map(String::as_str)).collect();
    below.draw(
        &mut picture,
        &TURN,
        &marks,
        ["direction of the axis about the plane's normal, degrees", words],
    );
    below.level(&mut picture, radius);
    below.curve(&mut picture, "s0", &radii);

    roots.sort_by(|a, b| circling.degrees(&a.frame).total_cmp(&circling.degrees(&b.frame)));
    let mut last = f64::NEG_INFINITY;
    let mut raised = false;
    for root in &roots {
        let (at, implied) = (circling.degrees(&root.frame), root.measures[0]);
        let known = (implied - radius).abs() < 1e-3 * radius;
        let class = if known { "f1" } else { "f0" };
        picture.dot(class, above.at(at, 0.0), 5.0);
        let [across, up] = below.at(at, implied);
        picture.dot(class, [across, up], 5.0);
        // Numbers of neighbours stand one above the other.
        raised = across - last < 58.0 && !raised;
        last = across;
        let lift = if raised { 30.0 } else { 12.0 };
        // The first is not to cover the marks of the axis.
        let (across, anchor) =
            if across < below.left + 30.0 { (across - 8.0, Anchor::Start) } else { (across, Anchor::Middle) };
        picture.text([across, up - lift], "", anchor, &format!("{implied:.4}"));
    }
    picture.finish()
}
