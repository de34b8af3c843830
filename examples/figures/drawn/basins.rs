//! The misfit of the worked example over the direction of the axis, and the sigma up to which its frame is the only one.

use touchref::{Probe, Problem, fixtures::algebra::Circle};

use super::{
    chart::{Anchor, Field, Picture, Scale},
    paper,
    roots::{Circling, TURN, around},
    solver,
};

pub(super) fn drawn() -> String {
    /// Chi-square levels of one degree of freedom: a frame is consistent, a second one out.
    const CONSISTENT: f64 = 1e-3;
    const EXCLUDED: f64 = 1e-6;
    let setup = paper();
    let touches = &setup.touches().unwrap().touches;
    let probe = Probe { sigma: Some(5e-5), ..Probe::default() };
    let problem = Problem::new(&*setup.fixture, touches, probe).unwrap();
    let solution = solver().solve(&problem).unwrap();
    let cylinder = problem.touches_on(0).map(|(_, touch)| touch.at).collect();
    let circling = Circling::new(&solution.frame, 45_f64.to_radians(), cylinder);
    let misfit_at = |phi: f64| {
        let points = circling.projected(phi);
        let paths = Circle::of_radius(1.0, &points, None, 1e-9, f64::INFINITY);
        paths[0].1.min(paths[1].1)
    };
    let mut misfit = around(misfit_at);
    // Around the frame it is steeper than the steps of the curve.
    let at_frame = circling.degrees(&solution.frame);
    for off in [0.1, 0.03, 0.01, 0.003, 0.001, 0.0, -0.001, -0.003, -0.01, -0.03, -0.1] {
        let degrees = at_frame + off;
        misfit.push([degrees, misfit_at(degrees.to_radians())]);
    }
    misfit.sort_by(|a, b| a[0].total_cmp(&b[0]));

    let title = "Length of the residuals over the direction of the axis, with the radius known: the frame, and the \
                 minimum that would be taken for it if touches were worse than 0.0137";
    let mut picture = Picture::new(title, 420.0);
    let x = Scale::Linear { from: 0.0, to: 360.0 };
    let y = Scale::Logarithmic { from: 1e-5, to: 3.0 };
    let field = Field { left: 80.0, right: 735.0, top: 44.0, bottom: 370.0, x, y };
    let marks =
        [(1e-5, "0.00001"), (1e-4, "0.0001"), (1e-3, "0.001"), (1e-2, "0.01"), (0.1, "0.1"), (1.0, "1")];
    let words = "root of the sum of squared residuals, mm";
    field.draw(
        &mut picture,
        &TURN,
        &marks,
        ["direction of the axis about the plane's normal, degrees", words],
    );
    field.curve(&mut picture, "s0", &misfit);
    let level = |chance: f64| touchref::statistics::chi_square_level(chance, 1).sqrt();
    let (stated, up_to) = (5e-5, solution.trust.up_to_sigma);
    for (height, words) in [
        (stated * level(CONSISTENT), format!("sigma {stated} mm: consistent below")),
        (up_to * level(EXCLUDED), format!("sigma {up_to:.4} mm: other frames are out above")),
    ] {
        field.level(&mut picture, height);
        let [_, at] = field.at(0.0, height);
        picture.text([field.right - 4.0, at - 7.0], "", Anchor::End, &words);
    }
    for minimum in &solution.search.as_ref().unwrap().minima {
        let residuals = minimum.chi_square.sqrt() * stated;
        let class = if minimum.selected { "f1" } else { "f0" };
        picture.dot(class, field.at(circling.degrees(&minimum.frame), residuals), 5.0);
    }
    picture.finish()
}
