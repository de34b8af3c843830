//! The propagation of distributions against closed forms and quadrature. Numbers without another source come from
//! `propagation.py` beside this file.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::ThreadPoolBuilder;
use touchref_analysis::{
    propagation::{
        Distribution, Draw, FirstOrder, Input, Interval, MonteCarlo, MultivariateNormal, Propagated,
        PropagationError, Trials, Validation, box_factor, coverage_factor, ellipsoid_factor,
        numerical_tolerance,
    },
    simulation::generator,
};

/// Closed forms in doubles against 15 printed digits.
const CLOSED_FORM: f64 = 1e-13;
/// What is promised of derivatives, relative.
const DERIVATIVE: f64 = 1e-9;
/// Standard deviations: seeds are fixed, so that what passes once passes always; by chance one in 15 000 does not.
const DEVIATIONS: f64 = 4.0;

const MONTE_CARLO: MonteCarlo = MonteCarlo {
    probability: 0.95,
    digits: 2,
    seed: 1,
    trials: Trials::Fixed(200_000),
    interval: Interval::Symmetric,
};

fn quietly(_: u64) {}

fn run(settings: MonteCarlo, draw: &(dyn Fn(&mut ChaCha8Rng) -> f64 + Sync)) -> Propagated {
    let row = |rng: &mut ChaCha8Rng, row: &mut [f64]| {
        row[0] = draw(rng);
        true
    };
    settings.run(1, &row, &quietly).unwrap()
}

fn standard(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(StandardNormal)
}

/// Estimate, standard uncertainty, low and high end of the only output, within their own uncertainty.
fn assert_near(got: &Propagated, expected: [f64; 4], what: &str) {
    let output = got.outputs[0];
    let (ours, s) = (
        [output.estimate, output.u, output.low, output.high],
        [output.numerical.estimate, output.numerical.u, output.numerical.low, output.numerical.high],
    );
    for k in 0..4 {
        let off = (ours[k] - expected[k]).abs();
        assert!(off <= DEVIATIONS * s[k], "{what}, {k}: {} +- {}, expected {}", ours[k], s[k], expected[k]);
        // And that is not because everything is within it.
        assert!(s[k] < 0.03 * expected[1], "{what}, {k}: {}", s[k]);
    }
}

#[test]
fn distributions_have_their_moments_and_shapes() {
    const DRAWS: u32 = 100_000;
    let cases = [
        (
            Distribution::normal(2.0, 3.0).unwrap(),
            2.0,
            3.0,
            [(0.0, 0.252_492_537_547), (3.0, 0.630_558_659_818), (7.0, 0.952_209_647_727)],
        ),
        (
            Distribution::student(2.0, 3.0, 7.0).unwrap(),
            2.0,
            3.549_647_869_859_77,
            [(0.0, 0.263_170_341_238), (3.0, 0.625_677_725_623), (7.0, 0.930_240_208_432)],
        ),
        (
            Distribution::rectangular(1.0, 5.0).unwrap(),
            3.0,
            1.154_700_538_379_25,
            [(1.5, 0.125), (3.0, 0.5), (4.6, 0.9)],
        ),
        (
            Distribution::triangular(1.0, 5.0).unwrap(),
            3.0,
            0.816_496_580_927_726,
            [(1.5, 0.031_25), (3.0, 0.5), (4.6, 0.98)],
        ),
        (
            Distribution::trapezoidal(1.0, 5.0, 0.4).unwrap(),
            3.0,
            0.879_393_730_551_528,
            [(1.5, 0.037_202_380_952_4), (3.0, 0.5), (4.6, 0.976_190_476_19)],
        ),
        (
            Distribution::curvilinear_trapezoid(-1.0, 1.0, 0.3).unwrap(),
            0.0,
            0.585_946_527_708_232,
            [(-0.9, 0.057_539_748_239_3), (0.2, 0.603_173_201_401), (1.1, 0.986_466_244_275)],
        ),
        (
            Distribution::arcsine(1.0, 5.0).unwrap(),
            3.0,
            std::f64::consts::SQRT_2,
            [(1.5, 0.230_053_456_163), (3.0, 0.5), (4.6, 0.795_167_235_301)],
        ),
    ];
    for (distribution, mean, u, below) in cases {
        assert!((distribution.mean() - mean).abs() < CLOSED_FORM, "{distribution:?}");
        assert!((distribution.standard_uncertainty() / u - 1.0).abs() < CLOSED_FORM, "{distribution:?}");
        let mut rng = generator(2, 0);
        let drawn: Vec<f64> = (0..DRAWS).map(|_| distribution.sample(&mut rng)).collect();
        for (at, expected) in below {
            let share = drawn.iter().filter(|value| **value < at).count() as f64 / f64::from(DRAWS);
            let deviation = (expected * (1.0 - expected) / f64::from(DRAWS)).sqrt();
            assert!((share - expected).abs() < DEVIATIONS * deviation, "{distribution:?} at {at}: {share}");
        }
    }
    assert!(Distribution::student(0.0, 1.0, 2.0).unwrap().standard_uncertainty().is_infinite());
}

#[test]
fn normal_quantities_are_drawn_together() {
    let covariance = DMatrix::from_row_slice(3, 3, &[4.0, 1.8, 4.0, 1.8, 1.0, 1.8, 4.0, 1.8, 4.0]);
    let together = MultivariateNormal::new(DVector::from_vec(vec![1.0, 2.0, 3.0]), &covariance).unwrap();
    assert_eq!(together.quantities(), 3);
    let draw = |rng: &mut ChaCha8Rng, row: &mut [f64]| {
        row.copy_from_slice(together.sample(rng).as_slice());
        true
    };
    let drawn = MONTE_CARLO.run(3, &draw, &quietly).unwrap();
    for i in 0..3 {
        let expected = i as f64 + 1.0;
        assert!(
            (drawn.outputs[i].estimate - expected).abs() < DEVIATIONS * drawn.outputs[i].numerical.estimate
        );
        for j in 0..3 {
            // Standard deviation of a sample covariance of normal quantities.
            let spread = (covariance[(i, i)] * covariance[(j, j)] + covariance[(i, j)].powi(2)) / 200_000.0;
            let off = drawn.covariance[(i, j)] - covariance[(i, j)];
            assert!(off.abs() < DEVIATIONS * spread.sqrt(), "{i} {j}: {off}");
        }
    }
    // The first and the last are the same quantity but for their means.
    assert!((drawn.covariance[(0, 2)] / drawn.covariance[(0, 0)] - 1.0).abs() < 1e-6);
}

#[test]
fn sums_have_their_exact_intervals() {
    let rectangular = |u: f64, rng: &mut ChaCha8Rng| u * 3.0_f64.sqrt() * (2.0 * rng.random::<f64>() - 1.0);
    for (widest, u, end) in [(1.0, 2.0, 3.879_406_741_35), (10.0, 10.148_891_57, 17.015_814_099_9)] {
        let sum = |rng: &mut ChaCha8Rng| {
            rectangular(1.0, rng) + rectangular(1.0, rng) + rectangular(1.0, rng) + rectangular(widest, rng)
        };
        let got = run(MONTE_CARLO, &sum);
        assert_near(&got, [0.0, u, -end, end], "sum of rectangular quantities");
        assert_eq!((got.trials, got.failed), (200_000, 0));
        let [low, high] = got.interval(0, 0.95, Interval::Symmetric).unwrap().unwrap();
        assert!((low - got.outputs[0].low).abs() + (high - got.outputs[0].high).abs() < f64::EPSILON);
        assert_eq!(got.interval(1, 0.95, Interval::Symmetric), Ok(None));
    }
}

#[test]
fn squares_have_their_noncentral_chi_square_intervals() {
    let settings = MonteCarlo { interval: Interval::Shortest, ..MONTE_CARLO };
    for (x1, expected) in [
        (0.0, [50.0, 50.0, 0.0, 149.7866]),
        (0.010, [150.0, 111.803_399, 0.0, 366.0053]),
        (0.050, [2550.0, 502.493_781, 1593.5875, 3548.5876]),
    ] {
        let loss = |rng: &mut ChaCha8Rng| {
            let (a, b) = (x1 + 0.005 * standard(rng), 0.005 * standard(rng));
            1e6 * (a * a + b * b)
        };
        assert_near(&run(settings, &loss), expected, &format!("x1 = {x1}"));
    }
    let logarithm = |rng: &mut ChaCha8Rng| (0.1 + rng.random::<f64>()).ln();
    let exact = [-0.664_900_292_916, 0.606_226_697_429, -1.897_119_984_89, 0.095_310_179_804_3];
    assert_near(&run(settings, &logarithm), exact, "logarithm");
}

/// The rule stops when twice the standard deviation of every result is below the tolerance: each result is then within the
/// tolerance with about 95 %.
#[test]
fn the_adaptive_procedure_stops_when_its_results_are_within_tolerance() {
    const RUNS: u64 = 40;
    /// Standard deviation 2, two digits: half of 0.1.
    const TOLERANCE: f64 = 0.05;
    let (mut within, mut trials) = (0, 0);
    for seed in 0..RUNS {
        let settings = MonteCarlo { seed, trials: Trials::Adaptive { most: 1_000_000 }, ..MONTE_CARLO };
        let got = run(settings, &|rng| 2.0 * standard(rng));
        let output = got.outputs[0];
        assert!(got.stable && got.trials.is_multiple_of(10_000), "{seed}: {}", got.trials);
        assert!((output.tolerance - TOLERANCE).abs() < 1e-12);
        let s = output.numerical;
        assert!([s.estimate, s.u, s.low, s.high].iter().all(|s| 2.0 * s < TOLERANCE), "{s:?}");
        let end = 3.919_927_969_080_108;
        let exact = [(output.estimate, 0.0), (output.u, 2.0), (output.low, -end), (output.high, end)];
        within += exact.iter().filter(|(ours, exact)| (ours - exact).abs() <= TOLERANCE).count();
        trials += got.trials;
    }
    // 160 results, of which 152 or more are expected within; fewer than 141 with a chance below 1e-4.
    assert!(within >= 141, "{within} of {}", 4 * RUNS);
    // Block averages of an end scatter by 0.057: the rule needs a handful of blocks, not two and not a hundred.
    let mean = trials / RUNS;
    assert!((20_000..120_000).contains(&mean), "{mean} trials in the mean");
}

#[test]
fn a_cap_is_told() {
    let settings = MonteCarlo { digits: 4, trials: Trials::Adaptive { most: 45_000 }, ..MONTE_CARLO };
    let got = run(settings, &standard);
    assert!(!got.stable);
    assert_eq!(got.trials, 40_000);
    // An output that is certain is stable.
    let got = run(MonteCarlo { trials: Trials::Adaptive { most: 1_000_000 }, ..settings }, &|_| 3.0);
    assert!(got.stable && got.trials == 20_000 && got.outputs[0].u.abs() < f64::EPSILON);
}

#[test]
fn results_do_not_depend_on_threads() {
    let draw = |rng: &mut ChaCha8Rng, row: &mut [f64]| {
        let (a, b) = (standard(rng), standard(rng));
        (row[0], row[1]) = (a.exp(), a * b);
        a > -2.0
    };
    let settings = MonteCarlo { trials: Trials::Fixed(25_003), interval: Interval::Shortest, ..MONTE_CARLO };
    let on = |threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| settings.run(2, &draw, &quietly).unwrap())
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
    // What has no value is counted: the lower tail beyond two standard deviations.
    let expected = 0.022_750_132 * 25_003.0;
    assert_eq!(one.trials, 25_003);
    assert!((one.failed as f64 - expected).abs() < DEVIATIONS * expected.sqrt(), "{}", one.failed);
    let other = MonteCarlo { seed: 2, ..settings }.run(2, &draw, &quietly).unwrap();
    assert!(other.outputs[0].estimate.to_bits() != one.outputs[0].estimate.to_bits());
}

#[test]
fn progress_counts_every_trial() {
    let made = std::sync::atomic::AtomicU64::new(0);
    let count = |more| {
        made.fetch_add(more, std::sync::atomic::Ordering::Relaxed);
    };
    let draw = |rng: &mut ChaCha8Rng, row: &mut [f64]| {
        row[0] = standard(rng);
        true
    };
    MonteCarlo { trials: Trials::Fixed(12_345), ..MONTE_CARLO }.run(1, &draw, &count).unwrap();
    assert_eq!(made.into_inner(), 12_345);
}

#[test]
fn derivatives_are_those_of_calculus() {
    let inputs = [Input::new(0.7, 0.1), Input::new(-1.3, 0.2), Input::new(5e4, 3.0), Input::new(2.0, 0.0)];
    let model = |x: &[f64], y: &mut [f64]| {
        y[0] = x[0].sin() * x[1].exp() + x[2].ln();
        y[1] = x[0] / x[1] * x[2].sqrt() * x[3];
    };
    let result = FirstOrder::new(&inputs, 2, &model).unwrap().propagate().unwrap();
    let [a, b, c] = [0.7_f64, -1.3_f64, 5e4_f64];
    let exact = [
        [a.cos() * b.exp(), a.sin() * b.exp(), 1.0 / c],
        [2.0 / b * c.sqrt(), -2.0 * a / (b * b) * c.sqrt(), a / b / c.sqrt()],
    ];
    for (output, row) in exact.iter().enumerate() {
        for (input, exact) in row.iter().enumerate() {
            let got = result.sensitivity(output, input).unwrap();
            // Rounding of a difference is a part of the whole value, whatever the part of this input in it.
            let rounding = 1e-13 * result.estimates[output].abs() / inputs[input].u;
            assert!(
                (got - exact).abs() < DERIVATIVE * exact.abs() + rounding,
                "{output} {input}: {got}, {exact}"
            );
        }
        assert_eq!(result.sensitivity(output, 3), None);
        let variance: f64 = row.iter().zip(&inputs).map(|(slope, input)| (slope * input.u).powi(2)).sum();
        assert!((result.standard_uncertainty(output).powi(2) / variance - 1.0).abs() < 1e-8);
    }
    let between: f64 = (0..3).map(|k| exact[0][k] * exact[1][k] * inputs[k].u.powi(2)).sum();
    assert!((result.covariance[(0, 1)] / between - 1.0).abs() < 1e-8);
    // An uncertainty of 5e-12 of the estimate is not lost in rounding.
    let sharp = [Input::new(10_973_731.568_539, 0.000_055)];
    let power = |x: &[f64], y: &mut [f64]| y[0] = x[0].powi(4);
    let slope = FirstOrder::new(&sharp, 1, &power).unwrap().propagate().unwrap().sensitivity(0, 0).unwrap();
    assert!((slope / (4.0 * sharp[0].estimate.powi(3)) - 1.0).abs() < DERIVATIVE, "{slope}");
    // A kink within one standard uncertainty is seen from near by.
    let kink = |x: &[f64], y: &mut [f64]| y[0] = x[0].abs();
    let near = FirstOrder::new(&[Input::new(0.001, 0.01)], 1, &kink).unwrap().propagate().unwrap();
    assert!((near.standard_uncertainty(0) / 0.01 - 1.0).abs() < DERIVATIVE);
}

#[test]
fn terms_of_higher_order_are_those_of_the_guide() {
    let inputs = [Input::new(0.5, 0.1), Input::new(0.0, 0.2)];
    let model = |x: &[f64], y: &mut [f64]| {
        y[0] = x[0] * x[0];
        y[1] = x[0] * x[1];
        y[2] = x[0].exp();
        y[3] = x[1].sin();
    };
    let got = FirstOrder::new(&inputs, 4, &model).unwrap().higher_order_variance().unwrap();
    let exact = [
        // Variance of the square of a normal quantity, 4 x^2 u^2 + 2 u^4, less its first term.
        2.0 * 0.1_f64.powi(4),
        // Of a product: the product of the variances (once with each order of the two).
        (0.1_f64 * 0.2).powi(2),
        // f'' f''/2 + f' f''' = 3/2 f^2.
        1.5 * (2.0 * 0.5_f64).exp() * 0.1_f64.powi(4),
        // f' f''' = -1 at 0, where f'' is 0.
        -(0.2_f64.powi(4)),
    ];
    for (output, (got, exact)) in got.iter().zip(exact).enumerate() {
        assert!((got - exact).abs() < 1e-6 * exact.abs(), "{output}: {got}, expected {exact}");
    }
}

#[test]
fn correlated_inputs_and_degrees_of_freedom() {
    let inputs = [Input::new(1.0, 3.0).with_degrees_of_freedom(4.0), Input::new(2.0, 4.0)];
    let sum = |x: &[f64], y: &mut [f64]| (y[0], y[1]) = (x[0] + x[1], x[0] - x[1]);
    let first_order = FirstOrder::new(&inputs, 2, &sum).unwrap();
    let independent = first_order.propagate().unwrap();
    assert!((independent.standard_uncertainty(0) - 5.0).abs() < 1e-8);
    // 5^4 / (3^4 / 4).
    assert!((independent.effective_degrees_of_freedom(0).unwrap() - 625.0 / 20.25).abs() < 1e-6);
    // Cut to 30 degrees of freedom; the factor is that of printed tables.
    let expanded = independent.expanded_uncertainty(0, 0.95).unwrap().unwrap();
    assert!((expanded - 5.0 * 2.042_272_456).abs() < 1e-6, "{expanded}");
    let correlation = DMatrix::from_row_slice(2, 2, &[1.0, 0.5, 0.5, 1.0]);
    let together = FirstOrder::new(&inputs, 2, &sum)
        .unwrap()
        .with_correlation(&correlation)
        .unwrap()
        .propagate()
        .unwrap();
    assert!((together.covariance[(0, 0)] - (25.0 + 12.0)).abs() < 1e-7);
    assert!((together.covariance[(1, 1)] - (25.0 - 12.0)).abs() < 1e-7);
    assert!((together.correlation(0, 1) + 7.0 / (37.0 * 13.0_f64).sqrt()).abs() < 1e-8);
    // Degrees of freedom that are whole stay so, whatever the derivatives' rounding.
    let scaled = |x: &[f64], y: &mut [f64]| y[0] = (x[0] / 7.0).exp();
    let one = [Input::new(0.3, 0.01).with_degrees_of_freedom(9.0)];
    let alone = FirstOrder::new(&one, 1, &scaled).unwrap().propagate().unwrap();
    let factor = alone.expanded_uncertainty(0, 0.95).unwrap().unwrap() / alone.standard_uncertainty(0);
    assert!((factor - 2.262_157_163).abs() < 1e-8, "{factor}");
    // Welch and Satterthwaite's formula, and that of higher order, are for independent inputs.
    assert_eq!(together.effective_degrees_of_freedom(0), None);
    assert_eq!(together.expanded_uncertainty(0, 0.95), Ok(None));
    let first_order = FirstOrder::new(&inputs, 2, &sum).unwrap().with_correlation(&correlation).unwrap();
    assert_eq!(first_order.higher_order_variance(), Err(PropagationError::Correlated));
}

#[test]
fn coverage_factors_are_those_of_printed_tables() {
    // GUM table G.2, and Abramowitz and Stegun, table 26.8.
    for (probability, degrees, expected) in [
        (0.95, 1.0, 12.71),
        (0.95, 10.9, 2.23),
        (0.99, 16.7, 2.92),
        (0.95, f64::INFINITY, 1.960),
        (0.6827, 5.0, 1.11),
    ] {
        let got = coverage_factor(probability, degrees).unwrap();
        assert!((got - expected).abs() < 0.005, "{probability} {degrees}: {got}");
    }
    assert!((ellipsoid_factor(0.95, 6).unwrap().powi(2) - 12.591_587).abs() < 1e-5);
    assert!((ellipsoid_factor(0.95, 1).unwrap() - 1.959_963_985).abs() < 1e-8);
    // The one-sided chance of each of six two-sided ends: 1/240.
    assert!((box_factor(0.95, 6).unwrap() - 2.638_257_273).abs() < 1e-8);
}

#[test]
fn the_tolerance_is_half_a_unit_of_the_last_digit_that_counts() {
    for (u, digits, expected) in [
        (0.000_35, 2, 0.5e-5),
        (35.0, 2, 0.5),
        (0.0754, 1, 0.005),
        (0.0999, 2, 0.005),
        (9.96, 2, 0.5),
        (502.0, 2, 5.0),
        (0.0, 2, 0.0),
    ] {
        let got = numerical_tolerance(u, digits).unwrap();
        assert!((got - expected).abs() < 1e-12 * expected.max(1e-300), "{u} {digits}: {got}");
    }
}

/// The worked figures of JCGM 101 9.2.3 (exact interval), 9.2.4 and 9.3 by clause 8.
#[test]
fn the_first_order_result_is_validated_where_it_is_true() {
    let compare = |ours: f64, exact: f64, u: f64, digits| {
        Validation::new([-ours, ours], [-exact, exact], u, digits).unwrap()
    };
    assert!(compare(3.92, 3.8794, 2.0, 2).validated());
    assert!(compare(3.92, 3.8794, 2.0, 1).validated());
    let dominated = compare(19.89, 17.0158, 10.149, 2);
    assert!(!dominated.validated() && (dominated.tolerance - 0.5).abs() < 1e-12);
    assert!((dominated.low - 2.8742).abs() < 1e-12);
    let one_end = Validation::new([1.0, 2.0], [1.0, 2.6], 0.5, 1).unwrap();
    assert!(!one_end.validated() && one_end.low.abs() < f64::EPSILON);
}

#[test]
fn bad_calls_are_errors() {
    let one = |rng: &mut ChaCha8Rng, row: &mut [f64]| {
        row[0] = standard(rng);
        true
    };
    let with = |settings: MonteCarlo, outputs: usize, draw: &Draw<'_>| {
        settings.run(outputs, draw, &quietly).unwrap_err()
    };
    assert_eq!(with(MONTE_CARLO, 0, &one), PropagationError::NoOutputs);
    for probability in [0.0, 1.0, -0.1, 1.5, f64::NAN] {
        let error = with(MonteCarlo { probability, ..MONTE_CARLO }, 1, &one);
        assert!(matches!(error, PropagationError::Probability(_)), "{error:?}");
        assert!(coverage_factor(probability, 3.0).is_err() && ellipsoid_factor(probability, 3).is_err());
        assert!(box_factor(probability, 3).is_err());
    }
    assert_eq!(with(MonteCarlo { digits: 0, ..MONTE_CARLO }, 1, &one), PropagationError::Digits(0));
    for trials in [Trials::Fixed(0), Trials::Fixed(399), Trials::Adaptive { most: 19_999 }] {
        let error = with(MonteCarlo { trials, ..MONTE_CARLO }, 1, &one);
        assert!(matches!(error, PropagationError::TooFewTrials { .. }), "{trials:?}: {error:?}");
    }
    // The fewest that do, do.
    assert!(MonteCarlo { trials: Trials::Fixed(400), ..MONTE_CARLO }.run(1, &one, &quietly).is_ok());
    let nan = |rng: &mut ChaCha8Rng, row: &mut [f64]| {
        (row[0], row[1]) = (1.0, 1.0 / (standard(rng) - 3.0).min(0.0).abs().floor());
        true
    };
    let not_finite = with(MONTE_CARLO, 2, &nan);
    assert!(matches!(not_finite, PropagationError::NotFinite { output: 1, .. }), "{not_finite:?}");
    // A row that is not filled is no value either.
    let unfilled = with(MONTE_CARLO, 2, &one);
    assert_eq!(unfilled, PropagationError::NotFinite { trial: 0, output: 1 });
    let none = with(MONTE_CARLO, 1, &|_, _| false);
    assert!(matches!(none, PropagationError::TooManyFailed { failed: 10_000, .. }), "{none:?}");
}

#[test]
fn what_cannot_be_known_of_inputs_is_an_error() {
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    let wrong = [
        Distribution::normal(0.0, 0.0),
        Distribution::normal(nan, 1.0),
        Distribution::normal(0.0, infinite),
        Distribution::student(0.0, 1.0, 0.0),
        Distribution::student(0.0, -1.0, 3.0),
        Distribution::rectangular(1.0, 1.0),
        Distribution::rectangular(2.0, 1.0),
        Distribution::rectangular(-infinite, 1.0),
        Distribution::triangular(nan, 1.0),
        Distribution::trapezoidal(0.0, 1.0, 1.1),
        Distribution::arcsine(1.0, 0.0),
        Distribution::curvilinear_trapezoid(-1.0, 1.0, 1.0),
        Distribution::curvilinear_trapezoid(-1.0, 1.0, 0.0),
    ];
    for (case, distribution) in wrong.into_iter().enumerate() {
        let error = distribution.unwrap_err();
        assert!(matches!(error, PropagationError::Distribution { .. }), "{case}: {error:?}");
    }
    let mean = DVector::from_vec(vec![0.0, 0.0]);
    for wrong in [
        DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]),
        DMatrix::from_row_slice(2, 2, &[1.0, 0.5, 0.4, 1.0]),
        DMatrix::from_row_slice(2, 2, &[1.0, nan, nan, 1.0]),
        DMatrix::identity(3, 3),
    ] {
        assert!(matches!(
            MultivariateNormal::new(mean.clone(), &wrong),
            Err(PropagationError::Matrix { .. })
        ));
        let (inputs, model) = ([Input::new(0.0, 1.0); 2], |x: &[f64], y: &mut [f64]| y[0] = x[0]);
        let refused = FirstOrder::new(&inputs, 1, &model).unwrap().with_correlation(&wrong);
        assert!(matches!(refused, Err(PropagationError::Matrix { .. })));
    }
    let model = |x: &[f64], y: &mut [f64]| y[0] = x.iter().sum::<f64>().ln();
    let twice = DMatrix::identity(1, 1) * 2.0;
    let one = [Input::new(1.0, 0.1)];
    assert!(FirstOrder::new(&one, 1, &model).unwrap().with_correlation(&twice).is_err());
    assert!(matches!(FirstOrder::new(&one, 0, &model).err(), Some(PropagationError::NoOutputs)));
    for input in
        [Input::new(nan, 1.0), Input::new(0.0, -1.0), Input::new(0.0, 1.0).with_degrees_of_freedom(0.0)]
    {
        let refused = FirstOrder::new(&[one[0], input], 1, &model).err();
        assert_eq!(refused, Some(PropagationError::Input { index: 1 }));
    }
    let undefined = [Input::new(-1.0, 0.1)];
    let refused = FirstOrder::new(&undefined, 1, &model).unwrap().propagate();
    assert_eq!(refused, Err(PropagationError::NotDifferentiable { output: 0 }));
}
