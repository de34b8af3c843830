//! Guide to the expression of uncertainty in measurement (GUM), JCGM 100:2008, annex H.

use nalgebra::DMatrix;

use super::{Example, Figure, Settings, correlation_of_two};
use crate::propagation::{FirstOrder, Input, PropagationError, coverage_factor};

const DOCUMENT: &str = "GUM, JCGM 100:2008";

pub(super) const EXAMPLES: &[Example] = &[
    Example {
        document: DOCUMENT,
        clause: "H.1",
        title: "end-gauge calibration; lengths in nm",
        source: "inputs and figures as MSLNZ/GTC (docs/API/GUM_H1.rst) and sandialabs/suncal (test/ex_endgauge.yaml) quote \
                 them",
        compute: end_gauge,
    },
    Example {
        document: DOCUMENT,
        clause: "H.2",
        title: "simultaneous resistance and reactance measurement; V, mA, rad, ohm",
        source: "inputs and figures as MSLNZ/GTC (docs/API/GUM_H2.rst, test/test_type_a.py) and sandialabs/suncal \
                 (test/test_examples.py) quote them",
        compute: impedance,
    },
    Example {
        document: DOCUMENT,
        clause: "H.3",
        title: "calibration of a thermometer by a straight line; degrees Celsius",
        source: "readings and figures as MSLNZ/GTC (docs/API/GUM_H3.rst) quotes them",
        compute: thermometer,
    },
];

/// Length of the end gauge: of the standard, plus the difference measured, less thermal expansion.
pub(super) fn gauge_length([standard, difference, expansion, apart, theta, delta]: [f64; 6]) -> f64 {
    standard + difference - standard * (apart * theta + expansion * delta)
}

fn end_gauge(_: Settings) -> Result<Vec<Figure>, PropagationError> {
    let rectangular = |half_width: f64| half_width / 3.0_f64.sqrt();
    let inputs = [
        Input::new(50_000_623.0, 25.0).with_degrees_of_freedom(18.0),
        // The difference: repeated observations, random and systematic effects of the comparator.
        Input::new(215.0, 5.8).with_degrees_of_freedom(24.0),
        Input::new(0.0, 3.9).with_degrees_of_freedom(5.0),
        Input::new(0.0, 6.7).with_degrees_of_freedom(8.0),
        // Expansion coefficient of the standard, and by how much that of the gauge differs.
        Input::new(11.5e-6, rectangular(2e-6)),
        Input::new(0.0, rectangular(1e-6)).with_degrees_of_freedom(50.0),
        // Temperature of the bed: its mean, and its cycle.
        Input::new(-0.1, 0.2),
        Input::new(0.0, 0.5 / 2.0_f64.sqrt()),
        // By how much that of the gauge differs.
        Input::new(0.0, rectangular(0.05)).with_degrees_of_freedom(2.0),
    ];
    let model = |x: &[f64], y: &mut [f64]| {
        y[0] = gauge_length([x[0], x[1] + x[2] + x[3], x[4], x[5], x[6] + x[7], x[8]]);
        y[1] = x[1] + x[2] + x[3];
        // The terms of second order that count (H.1.7), one by one.
        y[2] = x[0] * x[5] * (x[6] + x[7] + 0.1);
        y[3] = x[0] * (x[4] - 11.5e-6) * x[8];
    };
    let first_order = FirstOrder::new(&inputs, 4, &model)?;
    let result = first_order.propagate()?;
    let higher = first_order.higher_order_variance()?;
    let u = result.standard_uncertainty(0);
    let degrees = |output| result.effective_degrees_of_freedom(output).unwrap_or(f64::NAN);
    let part = |input| result.contributions[(0, input)].abs();
    Ok(vec![
        Figure::printed("length l", "50000838", result.estimates[0]),
        Figure::printed("u(d)", "9.7", result.standard_uncertainty(1)),
        Figure::printed("effective degrees of freedom of u(d)", "25.6", degrees(1)).because(
            "the GUM rounds u(d) to 9.7 before it raises it to the fourth power; from 9.68 follows 25.4",
        ),
        Figure::recomputed("part of the standard in u(l)", "25", part(0)),
        Figure::recomputed("part of the difference of expansion", "2.9", part(5)),
        Figure::recomputed("part of the difference of temperature", "16.6", part(8)),
        Figure::printed("u(l)", "32", u),
        Figure::printed("effective degrees of freedom, cut to a whole number", "16", degrees(0).floor()),
        Figure::recomputed("coverage factor, 99 %", "2.921", coverage_factor(0.99, degrees(0))?),
        Figure::printed("U(l), 99 %", "93", result.expanded_uncertainty(0, 0.99)?.unwrap_or(f64::NAN))
            .because("the GUM multiplies rounded numbers, 2.92 by 32; from 31.66 follows 92.5"),
        Figure::recomputed("second order: of expansion and temperature", "11.7", higher[2].sqrt()),
        Figure::recomputed("second order: of expansion and its difference", "1.7", higher[3].sqrt()),
        Figure::printed("u(l) with terms of second order", "34", (u * u + higher[0]).sqrt()),
    ])
}

/// Mean and covariance of the mean of several quantities observed together (GUM 4.2 and 5.2.3): estimates, standard
/// uncertainties and correlation coefficients.
fn observed<const N: usize>(series: [&[f64]; N]) -> ([f64; N], [f64; N], DMatrix<f64>) {
    let count = series[0].len() as f64;
    let means = series.map(|values| values.iter().sum::<f64>() / count);
    let covariance = DMatrix::from_fn(N, N, |i, j| {
        let pairs = series[i].iter().zip(series[j]);
        pairs.map(|(a, b)| (a - means[i]) * (b - means[j])).sum::<f64>() / (count * (count - 1.0))
    });
    let u = std::array::from_fn(|i| covariance[(i, i)].sqrt());
    let correlation =
        DMatrix::from_fn(N, N, |i, j| if i == j { 1.0 } else { covariance[(i, j)] / (u[i] * u[j]) });
    (means, u, correlation)
}

fn impedance(_: Settings) -> Result<Vec<Figure>, PropagationError> {
    let voltage = [5.007, 4.994, 5.005, 4.990, 4.999];
    let current = [19.663, 19.639, 19.640, 19.685, 19.678];
    let phase = [1.0456, 1.0438, 1.0468, 1.0428, 1.0433];
    let (means, u, correlation) = observed([&voltage, &current, &phase]);
    let inputs: Vec<Input> = means.iter().zip(u).map(|(mean, u)| Input::new(*mean, u)).collect();
    let model = |x: &[f64], y: &mut [f64]| {
        let magnitude = x[0] / (1e-3 * x[1]);
        (y[0], y[1], y[2]) = (magnitude * x[2].cos(), magnitude * x[2].sin(), magnitude);
    };
    let result = FirstOrder::new(&inputs, 3, &model)?.with_correlation(&correlation)?.propagate()?;
    Ok(vec![
        Figure::printed("V", "4.9990", means[0]),
        Figure::printed("u(V)", "0.0032", u[0]),
        Figure::printed("I", "19.6610", means[1]),
        Figure::printed("u(I)", "0.0095", u[1]),
        Figure::printed("phi", "1.04446", means[2]),
        Figure::printed("u(phi)", "0.00075", u[2]),
        Figure::printed("r(V, I)", "-0.36", correlation[(0, 1)]),
        Figure::printed("r(V, phi)", "0.86", correlation[(0, 2)]),
        Figure::printed("r(I, phi)", "-0.65", correlation[(1, 2)]),
        Figure::printed("R", "127.732", result.estimates[0]),
        Figure::printed("u(R)", "0.071", result.standard_uncertainty(0)),
        Figure::printed("X", "219.847", result.estimates[1]),
        Figure::printed("u(X)", "0.295", result.standard_uncertainty(1))
            .because("the GUM rounds its intermediate results; from the readings follows 0.29558"),
        Figure::printed("Z", "254.260", result.estimates[2]),
        Figure::printed("u(Z)", "0.236", result.standard_uncertainty(2)),
        Figure::printed("r(R, X)", "-0.588", result.correlation(0, 1)),
        Figure::recomputed("r(R, Z)", "-0.48526", result.correlation(0, 2)),
        Figure::recomputed("r(X, Z)", "0.99251", result.correlation(1, 2)),
    ])
}

fn thermometer(_: Settings) -> Result<Vec<Figure>, PropagationError> {
    /// The temperature that the line is told about.
    const REFERENCE: f64 = 20.0;
    let readings = [21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511];
    let corrections =
        [-0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160];
    // Least squares about the mean reading, where intercept and slope are independent.
    let count = readings.len() as f64;
    let middle = readings.iter().sum::<f64>() / count;
    let spread: f64 = readings.iter().map(|t| (t - middle).powi(2)).sum();
    let pairs = || readings.iter().zip(corrections);
    let height = corrections.iter().sum::<f64>() / count;
    let slope = pairs().map(|(t, b)| (t - middle) * b).sum::<f64>() / spread;
    let squares: f64 = pairs().map(|(t, b)| (b - height - slope * (t - middle)).powi(2)).sum();
    let degrees = count - 2.0;
    let s = (squares / degrees).sqrt();
    let inputs = [(height, s / count.sqrt()), (slope, s / spread.sqrt())]
        .map(|(estimate, u)| Input::new(estimate, u).with_degrees_of_freedom(degrees));
    let line = |x: &[f64], y: &mut [f64]| {
        y[0] = x[0] + x[1] * (REFERENCE - middle);
        y[1] = x[1];
    };
    let result = FirstOrder::new(&inputs, 2, &line)?.propagate()?;
    // As a user of the line goes on: from its intercept and slope, and their correlation.
    let r = result.correlation(0, 1);
    let known = [0, 1].map(|k| Input::new(result.estimates[k], result.standard_uncertainty(k)));
    let at_30 = |x: &[f64], y: &mut [f64]| y[0] = x[0] + x[1] * (30.0 - REFERENCE);
    let correlation = correlation_of_two(r);
    let predicted = FirstOrder::new(&known, 1, &at_30)?.with_correlation(&correlation)?.propagate()?;
    Ok(vec![
        Figure::printed("intercept y1", "-0.1712", result.estimates[0]),
        Figure::printed("u(y1)", "0.0029", result.standard_uncertainty(0)),
        Figure::printed("slope y2", "0.00218", result.estimates[1]),
        Figure::printed("u(y2)", "0.00067", result.standard_uncertainty(1)),
        Figure::printed("r(y1, y2)", "-0.93", r),
        Figure::recomputed("standard deviation of a correction", "0.0034976", s),
        Figure::printed("correction at 30", "-0.1494", predicted.estimates[0]),
        Figure::printed("u of the correction at 30", "0.0041", predicted.standard_uncertainty(0)),
    ])
}
