//! M. G. Cox and P. M. Harris, Software specifications for uncertainty evaluation, NPL report DEM-ES-011.

use rand_chacha::ChaCha8Rng;

use super::{Example, Figure, Origin, Settings, monte_carlo_figures, quietly};
use crate::propagation::{Distribution, FirstOrder, Input, Interval, PropagationError};

pub(super) const EXAMPLES: &[Example] = &[Example {
    document: "NPL report DEM-ES-011",
    clause: "9.2",
    title: "logarithm of a rectangular quantity",
    source: "inputs and figures as sandialabs/suncal (test/test_examples.py) quotes them",
    compute: logarithm,
}];

fn logarithm(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    const LOW: f64 = 0.1;
    const HIGH: f64 = 1.1;
    let quantity = Distribution::rectangular(LOW, HIGH)?;
    let inputs = [Input::new(quantity.mean(), quantity.standard_uncertainty())];
    let model = |x: &[f64], y: &mut [f64]| y[0] = x[0].ln();
    let result = FirstOrder::new(&inputs, 1, &model)?.propagate()?;
    let expanded = result.expanded_uncertainty(0, 0.95)?.unwrap_or(f64::NAN);
    let draw = |rng: &mut ChaCha8Rng, y: &mut [f64]| {
        y[0] = quantity.sample(rng).ln();
        true
    };
    let drawn = settings.monte_carlo(0.95, Interval::Shortest).run(1, &draw, &quietly)?;
    // The density of the logarithm grows up to its high end: the shortest interval leaves out the low end only.
    let exact_low = (LOW + 0.05 * (HIGH - LOW)).ln();
    let mut figures = vec![
        Figure::printed("first order: estimate", "-0.511", result.estimates[0]),
        Figure::printed("first order: u", "0.481", result.standard_uncertainty(0)),
        Figure::printed("first order: high end", "0.432", result.estimates[0] + expanded),
        Figure::printed("closed form: low end", "-1.895", exact_low)
            .because("the report's Monte Carlo noise; the exact end is ln 0.15 = -1.8971"),
        Figure::printed("closed form: high end", "0.095", HIGH.ln()),
    ];
    let printed = [Some("-0.665"), Some("0.606"), None, Some("0.095")];
    figures.extend(monte_carlo_figures(Origin::Printed, "", printed, &drawn, 0));
    let exact = [None, None, Some("-1.897120"), None];
    figures.extend(monte_carlo_figures(Origin::Recomputed, "", exact, &drawn, 0));
    Ok(figures)
}
