//! GUM Supplement 2: extension to any number of output quantities, JCGM 102:2011.

use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;

use super::{Example, Figure, Origin, Settings, correlation_of_two, monte_carlo_figures, quietly};
use crate::propagation::{
    FirstOrder, Input, Interval, MultivariateNormal, PropagationError, box_factor, ellipsoid_factor,
};

const DOCUMENT: &str = "GUM Supplement 2, JCGM 102:2011";
const TITLE: &str = "magnitude and phase of a complex quantity";
const QUOTED: &str =
    "tables 6 and 7 as sandialabs/suncal (test/test_examples.py, test/ex_magphase.yaml) quotes them";

pub(super) const EXAMPLES: &[Example] = &[
    Example {
        document: DOCUMENT,
        clause: "6.5",
        title: "coverage factors of normal quantities together",
        source: "figures recomputed from chi-square and normal quantiles",
        compute: factors,
    },
    Example {
        document: DOCUMENT,
        clause: "9.3, real part 0.001, r = 0",
        title: TITLE,
        source: QUOTED,
        compute: |settings| {
            magnitude_and_phase(
                settings,
                0.001,
                0.0,
                ["0.001", "0.010", "0.000", "10.000"],
                [["0.013", "0.007"], ["0.000", "1.744"]],
            )
        },
    },
    Example {
        document: DOCUMENT,
        clause: "9.3, real part 0.001, r = 0.9",
        title: TITLE,
        source: QUOTED,
        compute: |settings| {
            magnitude_and_phase(
                settings,
                0.001,
                0.9,
                ["0.001", "0.010", "0.000", "10.000"],
                [["0.012", "0.008"], ["-0.556", "1.599"]],
            )
        },
    },
    Example {
        document: DOCUMENT,
        clause: "9.3, real part 0.010, r = 0.9",
        title: TITLE,
        source: QUOTED,
        compute: |settings| {
            magnitude_and_phase(
                settings,
                0.010,
                0.9,
                ["0.010", "0.010", "0.000", "1.000"],
                [["0.015", "0.008"], ["-0.343", "0.903"]],
            )
        },
    },
];

fn factors(_: Settings) -> Result<Vec<Figure>, PropagationError> {
    let published = ["1.9600", "2.4477", "2.7955", "3.0802", "3.3272", "3.5485"];
    let mut figures = Vec::new();
    for (outputs, published) in (1..).zip(published) {
        let quantity = format!("ellipsoid, 95 %, outputs: {outputs}");
        figures.push(Figure::recomputed(&quantity, published, ellipsoid_factor(0.95, outputs)?));
    }
    figures.push(Figure::recomputed("ellipsoid, 99 %, outputs: 6", "4.1002", ellipsoid_factor(0.99, 6)?));
    figures.push(Figure::recomputed("Bonferroni's box, 95 %, outputs: 6", "2.6383", box_factor(0.95, 6)?));
    Ok(figures)
}

/// Of real and imaginary part, the latter about 0; both with a standard uncertainty of 0.01.
fn magnitude_and_phase(
    settings: Settings,
    real: f64,
    correlation: f64,
    first_order: [&'static str; 4],
    monte_carlo: [[&'static str; 2]; 2],
) -> Result<Vec<Figure>, PropagationError> {
    const U: f64 = 0.01;
    let model = |x: &[f64], y: &mut [f64]| (y[0], y[1]) = (x[0].hypot(x[1]), x[1].atan2(x[0]));
    let inputs = [Input::new(real, U), Input::new(0.0, U)];
    let coefficients = correlation_of_two(correlation);
    let result = FirstOrder::new(&inputs, 2, &model)?.with_correlation(&coefficients)?.propagate()?;
    let together = MultivariateNormal::new(DVector::from_vec(vec![real, 0.0]), &(coefficients * (U * U)))?;
    let draw = |rng: &mut ChaCha8Rng, y: &mut [f64]| {
        model(together.sample(rng).as_slice(), y);
        true
    };
    let drawn = settings.monte_carlo(0.95, Interval::Symmetric).run(2, &draw, &quietly)?;
    let mut figures = Vec::new();
    for (output, name) in ["magnitude", "phase"].into_iter().enumerate() {
        let u = result.standard_uncertainty(output);
        let published = monte_carlo[output];
        figures.extend([
            Figure::printed(
                &format!("first order: {name}, estimate"),
                first_order[2 * output],
                result.estimates[output],
            ),
            Figure::printed(&format!("first order: {name}, u"), first_order[2 * output + 1], u),
        ]);
        let published = [Some(published[0]), Some(published[1]), None, None];
        figures.extend(monte_carlo_figures(Origin::Printed, &format!("{name}, "), published, &drawn, output));
    }
    Ok(figures)
}
