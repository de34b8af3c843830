//! A. Possolo, Simple guide for evaluating and expressing the uncertainty of NIST measurement results, NIST Technical
//! Note 1900 (2015); T. Lafarge and A. Possolo, NIST Uncertainty Machine, user's manual.

use rand_chacha::ChaCha8Rng;

use super::{Example, Figure, Origin, Settings, monte_carlo_figures, quietly};
use crate::propagation::{
    Distribution, FirstOrder, Input, Interval, Propagated, Propagation, PropagationError,
};

const NOTE: &str = "NIST Technical Note 1900";

pub(super) const EXAMPLES: &[Example] = &[
    Example {
        document: NOTE,
        clause: "E3",
        title: "falling-ball viscometer; mPa s",
        source: "inputs as usnistgov/NIST-Uncertainty-Machine (conf/config-Viscosity.txt), figures as sandialabs/suncal \
                 (test/test_examples.py) quotes them",
        compute: viscosity,
    },
    Example {
        document: NOTE,
        clause: "E11",
        title: "microwave step attenuator; dB",
        source: "inputs as sandialabs/suncal (test/ex_stepatten.yaml), figures as its test/test_examples.py quotes them",
        compute: attenuator,
    },
    Example {
        document: NOTE,
        clause: "E13",
        title: "coefficient of thermal expansion; 1/K",
        source: "inputs as usnistgov/NIST-Uncertainty-Machine (conf/config-Thermal.txt), figures as sandialabs/suncal \
                 (test/test_examples.py) quotes them",
        compute: expansion,
    },
    Example {
        document: "NIST Uncertainty Machine, user's manual",
        clause: "example 10",
        title: "Stefan-Boltzmann constant; W m-2 K-4",
        source: "inputs as usnistgov/NIST-Uncertainty-Machine (conf/config-Stefan.txt), figures as sandialabs/suncal \
                 (test/test_examples.py) quotes them",
        compute: stefan_boltzmann,
    },
];

/// First order and Monte Carlo of a function of independent quantities.
fn both(
    settings: Settings,
    probability: f64,
    parts: &[Distribution],
    value: impl Fn(&[f64]) -> f64 + Sync,
) -> Result<(Propagation, Propagated), PropagationError> {
    let inputs: Vec<Input> =
        parts.iter().map(|part| Input::new(part.mean(), part.standard_uncertainty())).collect();
    let model = |x: &[f64], y: &mut [f64]| y[0] = value(x);
    let first_order = FirstOrder::new(&inputs, 1, &model)?.propagate()?;
    let draw = |rng: &mut ChaCha8Rng, y: &mut [f64]| {
        let drawn: Vec<f64> = parts.iter().map(|part| part.sample(rng)).collect();
        y[0] = value(&drawn);
        true
    };
    let monte_carlo = settings.monte_carlo(probability, Interval::Symmetric).run(1, &draw, &quietly)?;
    Ok((first_order, monte_carlo))
}

fn normals(known: &[(f64, f64)]) -> Result<Vec<Distribution>, PropagationError> {
    known.iter().map(|(mean, u)| Distribution::normal(*mean, *u)).collect()
}

/// Student's with three degrees of freedom, by its standard uncertainty, as the note has it.
fn student_3(mean: f64, u: f64) -> Result<Distribution, PropagationError> {
    Distribution::student(mean, u / 3.0_f64.sqrt(), 3.0)
}

fn viscosity(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    // Viscosity of the calibration liquid; densities of ball, solution and calibration liquid; travel times in solution
    // and calibration liquid.
    let parts =
        normals(&[(4.63, 0.0463), (2217.0, 0.5), (1180.0, 0.5), (810.0, 0.5), (61.0, 6.1), (36.6, 5.49)])?;
    let value = |x: &[f64]| x[0] * (x[1] - x[2]) / (x[1] - x[3]) * x[4] / x[5];
    let (first_order, drawn) = both(settings, 0.95, &parts, value)?;
    let mut figures = vec![Figure::printed("first order: estimate", "5.69", first_order.estimates[0])];
    let published = ["5.82", "1.11", "4.05", "8.39"].map(Some);
    let drawn = monte_carlo_figures(Origin::Printed, "", published, &drawn, 0);
    figures.extend(drawn.into_iter().map(|figure| match figure.published {
        "4.05" => figure,
        _ => figure.because("the note's own Monte Carlo noise: quadrature gives 5.8252, 1.1154 and 8.3993"),
    }));
    Ok(figures)
}

fn attenuator(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    let about_zero = |half_width: f64| (-half_width, half_width);
    let rectangular = |half_width| {
        let (low, high) = about_zero(half_width);
        Distribution::rectangular(low, high)
    };
    let arcsine = |half_width| {
        let (low, high) = about_zero(half_width);
        Distribution::arcsine(low, high)
    };
    let parts = [
        student_3(30.0402, 0.0091)?,
        Distribution::rectangular(0.003 - 0.00433, 0.003 + 0.00433)?,
        rectangular(0.000_519_6)?,
        rectangular(0.000_519_6)?,
        Distribution::normal(0.0, 0.002)?,
        Distribution::normal(0.0, 0.002)?,
        arcsine(0.02828)?,
        arcsine(0.00198)?,
        arcsine(0.002_969_8)?,
    ];
    // All but the standard are about zero or added: signs do not count.
    let (_, drawn) = both(settings, 0.95, &parts, |x| x.iter().sum())?;
    let published = ["30.043", "0.0224", "30.006", "30.081"].map(Some);
    Ok(monte_carlo_figures(Origin::Printed, "", published, &drawn, 0))
}

fn expansion(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    // Lengths and temperatures, before and after.
    let known = [(1.4999, 0.0001), (1.5021, 0.0002), (288.15, 0.02), (373.10, 0.05)];
    let parts = known.map(|(mean, u)| student_3(mean, u)).into_iter().collect::<Result<Vec<_>, _>>()?;
    let (first_order, drawn) = both(settings, 0.95, &parts, |x| (x[1] - x[0]) / (x[0] * (x[3] - x[2])))?;
    let mut figures = vec![
        Figure::printed("first order: estimate", "1.7266e-5", first_order.estimates[0]),
        Figure::printed("first order: u", "1.76e-6", first_order.standard_uncertainty(0)),
    ];
    let published = [Some("1.7268e-5"), Some("1.74e-6"), None, None];
    let drawn = monte_carlo_figures(Origin::Printed, "", published, &drawn, 0);
    let noise = "the note's own Monte Carlo noise, large for three degrees of freedom: expected are 1.7266e-5 and 1.755e-6";
    figures.extend(drawn.into_iter().map(|figure| figure.because(noise)));
    Ok(figures)
}

fn stefan_boltzmann(settings: Settings) -> Result<Vec<Figure>, PropagationError> {
    /// Molar mass constant, kg/mol.
    const MOLAR_MASS: f64 = 1e-3;
    /// Speed of light, m/s.
    const LIGHT: f64 = 299_792_458.0;
    // Planck's, molar gas and Rydberg constant; relative mass of the electron; fine-structure constant.
    let parts = normals(&[
        (6.626_069_57e-34, 0.000_000_29e-34),
        (8.314_462_1, 0.000_007_5),
        (10_973_731.568_539, 0.000_055),
        (5.485_799_094_6e-4, 0.000_000_002_2e-4),
        (7.297_352_569_8e-3, 0.000_000_002_4e-3),
    ])?;
    let value = |x: &[f64]| {
        let over = 32.0 * std::f64::consts::PI.powi(5) * x[0] * (x[1] * x[2]).powi(4);
        over / (15.0 * (x[3] * MOLAR_MASS).powi(4) * LIGHT.powi(6) * x[4].powi(8))
    };
    let (first_order, drawn) = both(settings, 0.99, &parts, value)?;
    let mut figures = vec![
        Figure::printed("first order: estimate", "5.67037e-8", first_order.estimates[0]),
        Figure::printed("first order: u", "2.05e-13", first_order.standard_uncertainty(0)),
    ];
    let published = ["5.67037e-8", "2.05e-13", "5.67032e-8", "5.67043e-8"].map(Some);
    figures.extend(monte_carlo_figures(Origin::Printed, "99 %, ", published, &drawn, 0));
    Ok(figures)
}
