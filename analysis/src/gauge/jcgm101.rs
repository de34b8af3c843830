//! GUM Supplement 1: propagation of distributions using a Monte Carlo method, JCGM 101:2008, clause 9.

use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;

use super::{
    Example, Figure, Origin, Settings, correlation_of_two, gum::gauge_length, monte_carlo_figures, quietly,
};
use crate::propagation::{Distribution, FirstOrder, Input, Interval, MultivariateNormal, PropagationError};

const DOCUMENT: &str = "GUM Supplement 1, JCGM 101:2008";
const QUOTED: &str = "figures as sandialabs/suncal (test/test_examples.py) quotes them; ends to more digits from closed \
                      forms";
const REFLECTION: &str = "reflection coefficients with u = 0.005; figures recomputed (noncentral chi-square where \
                          independent, else other programs), in units of 1e-6";

pub(super) const EXAMPLES: &[Example] = &[
    Example {
        document: DOCUMENT,
        clause: "9.2.2",
        title: "sum of four normal quantities",
        source: QUOTED,
        compute: normal_sum,
    },
    Example {
        document: DOCUMENT,
        clause: "9.2.3",
        title: "sum of four rectangular quantities",
        source: QUOTED,
        compute: rectangular_sum,
    },
    Example {
        document: DOCUMENT,
        clause: "9.2.4",
        title: "sum of four rectangular quantities, one of them ten times as wide",
        source: "figures recomputed from the exact distribution of the sum",
        compute: dominated_sum,
    },
    Example {
        document: DOCUMENT,
        clause: "9.3",
        title: "mass calibration; deviation from 100 g in mg",
        source: "inputs as commonly quoted; figures recomputed by another program (2e7 draws)",
        compute: mass,
    },
    Example {
        document: DOCUMENT,
        clause: "9.4, x1 = 0, r = 0",
        title: "comparison loss in microwave power meter calibration",
        source: REFLECTION,
        compute: |settings| loss(settings, 0.0, 0.0, ["50", "50.0", "0.0", "149.8"], &[("u", "0")]),
    },
    Example {
        document: DOCUMENT,
        clause: "9.4, x1 = 0.010, r = 0",
        title: "comparison loss in microwave power meter calibration",
        source: REFLECTION,
        compute: |settings| {
            let first_order = &[("u", "100"), ("low end", "-96"), ("high end", "296")];
            loss(settings, 0.010, 0.0, ["150", "111.8", "0.0", "366.0"], first_order)
        },
    },
    Example {
        document: DOCUMENT,
        clause: "9.4, x1 = 0.050, r = 0",
        title: "comparison loss in microwave power meter calibration",
        source: REFLECTION,
        compute: |settings| {
            let first_order = &[("u", "500"), ("low end", "1520"), ("high end", "3480")];
            loss(settings, 0.050, 0.0, ["2550", "502.5", "1593.6", "3548.6"], first_order)
        },
    },
    Example {
        document: DOCUMENT,
        clause: "9.4, x1 = 0, r = 0.9",
        title: "comparison loss in microwave power meter calibration",
        source: REFLECTION,
        compute: |settings| loss(settings, 0.0, 0.9, ["50", "67.3", "0.0", "185.1"], &[("u", "0")]),
    },
    Example {
        document: DOCUMENT,
        clause: "9.4, x1 = 0.010, r = 0.9",
        title: "comparison loss in microwave power meter calibration",
        source: REFLECTION,
        compute: |settings| loss(settings, 0.010, 0.9, ["150", "120.5", "12.8", "397.8"], &[("u", "100")]),
    },
    Example {
        document: DOCUMENT,
        clause: "9.4, x1 = 0.050, r = 0.9",
        title: "comparison loss in microwave power meter calibration",
        source: REFLECTION,
        compute: |settings| loss(settings, 0.050, 0.9, ["2550", "504.5", "1624", "3554"], &[("u", "500")]),
    },
    Example {
        document: DOCUMENT,
        clause: "9.5",
        title: "gauge block calibration; nm beyond 50 mm, 99 %",
        source: "inputs as commonly quoted; figures recomputed by another program (2e7 draws)",
        compute: gauge_block,
    },
];

/// First order and Monte Carlo of a sum of independent quantities.
fn sum(
    settings: Settings,
    parts: &[Distribution],
    origin: Origin,
    first_order: [&'static str; 2],
    monte_carlo: [&'static str; 4],
) -> Result<Vec<Figure>, PropagationError> {
    let inputs: Vec<Input> =
        parts.iter().map(|part| Input::new(part.mean(), part.standard_uncertainty())).collect();
    let model = |x: &[f64], y: &mut [f64]| y[0] = x.iter().sum();
    let result = FirstOrder::new(&inputs, 1, &model)?.propagate()?;
    let expanded = result.expanded_uncertainty(0, 0.95)?.unwrap_or(f64::NAN);
    let draw = |rng: &mut ChaCha8Rng, y: &mut [f64]| {
        y[0] = parts.iter().map(|part| part.sample(rng)).sum();
        true
    };
    // Symmetric, as the distribution is: the ends of a shortest interval scatter more.
    let drawn = settings.monte_carlo(0.95, Interval::Symmetric).run(1, &draw, &quietly)?;
    let mut figures = vec![
        Figure::recomputed("first order: u", first_order[0], result.standard_uncertainty(0)),
        Figure::recomputed("first order: high end", first_order[1], expanded),
    ];
    figures.extend(monte_carlo_figures(origin, "", monte_carlo.map(Some), &drawn, 0));
    Ok(figures)
}

fn normal_sum(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    let parts = [Distribution::normal(0.0, 1.0)?; 4];
    sum(settings, &parts, Origin::Printed, ["2.00", "3.92"], ["0.00", "2.00", "-3.92", "3.92"])
}

fn rectangular_sum(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    let parts = [standard_rectangular(1.0)?; 4];
    sum(settings, &parts, Origin::Printed, ["2.00", "3.92"], ["0.00", "2.00", "-3.88", "3.88"])
}

fn dominated_sum(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    let parts = [1.0, 1.0, 1.0, 10.0].map(standard_rectangular);
    let parts = parts.into_iter().collect::<Result<Vec<_>, _>>()?;
    let exact = ["0.0", "10.149", "-17.0158", "17.0158"];
    sum(settings, &parts, Origin::Recomputed, ["10.149", "19.89"], exact)
}

/// About zero, with this standard uncertainty.
fn standard_rectangular(u: f64) -> Result<Distribution, PropagationError> {
    Distribution::rectangular(-u * 3.0_f64.sqrt(), u * 3.0_f64.sqrt())
}

/// Of the reference weight and the added weight, and densities of air, weight and reference weight.
const MASSES: [(f64, f64); 2] = [(100_000.0, 0.050), (1.234, 0.020)];
const DENSITIES: [(f64, f64); 3] = [(1.1, 1.3), (7000.0, 9000.0), (7950.0, 8050.0)];

fn mass(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    /// Nominal mass, mg.
    const NOMINAL: f64 = 100_000.0;
    /// Conventional density of air, kg/m3.
    const AIR: f64 = 1.2;
    let mut parts = Vec::new();
    for (mean, u) in MASSES {
        parts.push(Distribution::normal(mean, u)?);
    }
    for (low, high) in DENSITIES {
        parts.push(Distribution::rectangular(low, high)?);
    }
    let deviation = |x: &[f64]| (x[0] + x[1]) * (1.0 + (x[2] - AIR) * (1.0 / x[3] - 1.0 / x[4])) - NOMINAL;
    let inputs: Vec<Input> =
        parts.iter().map(|part| Input::new(part.mean(), part.standard_uncertainty())).collect();
    let model = |x: &[f64], y: &mut [f64]| y[0] = deviation(x);
    let first_order = FirstOrder::new(&inputs, 1, &model)?;
    let result = first_order.propagate()?;
    let (estimate, u) = (result.estimates[0], result.standard_uncertainty(0));
    let expanded = result.expanded_uncertainty(0, 0.95)?.unwrap_or(f64::NAN);
    let higher = (u * u + first_order.higher_order_variance()?[0]).sqrt();
    let higher_expanded = expanded * higher / u;
    let draw = |rng: &mut ChaCha8Rng, y: &mut [f64]| {
        let x: [f64; 5] = std::array::from_fn(|k| parts[k].sample(rng));
        y[0] = deviation(&x);
        true
    };
    let drawn = settings.monte_carlo(0.95, Interval::Shortest).run(1, &draw, &quietly)?;
    let mut figures = vec![
        Figure::recomputed("first order: estimate", "1.2340", estimate),
        Figure::recomputed("first order: u", "0.0539", u),
        Figure::recomputed("first order: low end", "1.1285", estimate - expanded),
        Figure::recomputed("first order: high end", "1.3395", estimate + expanded),
        Figure::recomputed("higher order: u", "0.0750", higher),
        Figure::recomputed("higher order: low end", "1.0871", estimate - higher_expanded),
        Figure::recomputed("higher order: high end", "1.3809", estimate + higher_expanded),
    ];
    let published = ["1.2340", "0.0755", "1.0845", "1.3836"].map(Some);
    figures.extend(monte_carlo_figures(Origin::Recomputed, "", published, &drawn, 0));
    Ok(figures)
}

/// The loss `X1^2 + X2^2` about `x1` and 0.
fn loss(
    settings: Settings,
    x1: f64,
    correlation: f64,
    published: [&'static str; 4],
    first_order: &[(&str, &'static str)],
) -> Result<Vec<Figure>, PropagationError> {
    /// Of both coefficients.
    const U: f64 = 0.005;
    /// The figures are in these units.
    const UNIT: f64 = 1e-6;
    let value = |x: &[f64]| (x[0] * x[0] + x[1] * x[1]) / UNIT;
    let inputs = [Input::new(x1, U), Input::new(0.0, U)];
    let coefficients = correlation_of_two(correlation);
    let model = |x: &[f64], y: &mut [f64]| y[0] = value(x);
    let result = FirstOrder::new(&inputs, 1, &model)?.with_correlation(&coefficients)?.propagate()?;
    let (estimate, u) = (result.estimates[0], result.standard_uncertainty(0));
    let expanded = result.expanded_uncertainty(0, 0.95)?.unwrap_or(f64::NAN);
    let together = MultivariateNormal::new(DVector::from_vec(vec![x1, 0.0]), &(coefficients * (U * U)))?;
    let draw = |rng: &mut ChaCha8Rng, y: &mut [f64]| {
        y[0] = value(together.sample(rng).as_slice());
        true
    };
    let drawn = settings.monte_carlo(0.95, Interval::Shortest).run(1, &draw, &quietly)?;
    let mut figures: Vec<Figure> = first_order
        .iter()
        .map(|(name, published)| {
            let computed = match *name {
                "u" => u,
                "low end" => estimate - expanded,
                _ => estimate + expanded,
            };
            Figure::recomputed(&format!("first order: {name}"), published, computed)
        })
        .collect();
    figures.extend(monte_carlo_figures(Origin::Recomputed, "", published.map(Some), &drawn, 0));
    Ok(figures)
}

fn gauge_block(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    /// The figures are beyond this length.
    const NOMINAL: f64 = 50_000_000.0;
    let standard = Distribution::student(50_000_623.0, 25.0, 18.0)?;
    let difference = [
        Distribution::student(215.0, 6.0, 24.0)?,
        Distribution::student(0.0, 4.0, 5.0)?,
        Distribution::student(0.0, 7.0, 8.0)?,
    ];
    let expansion = Distribution::rectangular(9.5e-6, 13.5e-6)?;
    let apart = Distribution::curvilinear_trapezoid(-1e-6, 1e-6, 0.1e-6)?;
    let theta = [Distribution::normal(-0.1, 0.2)?, Distribution::arcsine(-0.5, 0.5)?];
    let delta = Distribution::curvilinear_trapezoid(-0.050, 0.050, 0.025)?;
    let draw = |rng: &mut ChaCha8Rng, y: &mut [f64]| {
        let length = gauge_length([
            standard.sample(rng),
            difference.iter().map(|part| part.sample(rng)).sum(),
            expansion.sample(rng),
            apart.sample(rng),
            theta.iter().map(|part| part.sample(rng)).sum(),
            delta.sample(rng),
        ]);
        y[0] = length - NOMINAL;
        true
    };
    let drawn = settings.monte_carlo(0.99, Interval::Shortest).run(1, &draw, &quietly)?;
    let published = ["838.0", "35.8", "744.4", "931.7"].map(Some);
    Ok(monte_carlo_figures(Origin::Recomputed, "", published, &drawn, 0))
}
