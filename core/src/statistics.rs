//! The chi-square distribution: p-values and levels. Quantiles of the normal distribution and of Student's.

use std::sync::OnceLock;

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal, StudentsT};

/// Chi-square levels of one chance, kept for the degrees of freedom that touches have: a solve asks for them often.
#[derive(Debug)]
pub struct Level {
    chance: f64,
    table: OnceLock<[f64; Self::KEPT]>,
}

impl Level {
    const KEPT: usize = 65;

    /// Of this chance.
    #[must_use]
    pub const fn new(chance: f64) -> Self {
        Self { chance, table: OnceLock::new() }
    }

    /// The chance.
    #[must_use]
    pub fn chance(&self) -> f64 {
        self.chance
    }

    /// [`chi_square_level`] with these degrees of freedom.
    #[must_use]
    pub fn value(&self, degrees_of_freedom: usize) -> f64 {
        let table =
            self.table.get_or_init(|| std::array::from_fn(|degrees| chi_square_level(self.chance, degrees)));
        match table.get(degrees_of_freedom) {
            Some(value) => *value,
            None => chi_square_level(self.chance, degrees_of_freedom),
        }
    }
}

/// Chance that a chi-square variable with `degrees_of_freedom` exceeds `value`; `None` without degrees of freedom.
#[must_use]
pub fn chi_square_p_value(value: f64, degrees_of_freedom: usize) -> Option<f64> {
    let distribution = ChiSquared::new(degrees_of_freedom as f64).ok()?;
    Some(if value <= 0.0 { 1.0 } else { distribution.sf(value) })
}

/// The value that a chi-square variable with `degrees_of_freedom` (at least 1) exceeds with chance `level`.
///
/// Wilson and Hilferty's start, then Newton on the survival function; relative error below 1e-9.
#[must_use]
pub fn chi_square_level(level: f64, degrees_of_freedom: usize) -> f64 {
    let nu = degrees_of_freedom.max(1) as f64;
    let Ok(distribution) = ChiSquared::new(nu) else { return f64::NAN };
    // Normal quantile of the tail, good to two digits: Newton does the rest.
    let t = (-2.0 * level.ln()).sqrt();
    let normal = t - (2.515_517 + 0.802_853 * t) / (1.0 + 1.432_788 * t + 0.189_269 * t * t);
    let mut x = nu * (1.0 - 2.0 / (9.0 * nu) + normal * (2.0 / (9.0 * nu)).sqrt()).powi(3);
    x = x.max(f64::MIN_POSITIVE);
    for _ in 0..60 {
        // Newton on log(sf): the tail is nearly exponential, so this converges from either side.
        let tail = distribution.sf(x);
        let density = distribution.pdf(x);
        let step = (tail / level).ln() * tail / density;
        let next = if x + step > 0.0 { x + step } else { 0.5 * x };
        let settled = (next - x).abs() <= 1e-12 * x;
        x = next;
        if settled {
            break;
        }
    }
    x
}

/// The value that a standard normal variable stays below with this probability; NaN unless that lies in (0, 1).
#[must_use]
pub fn normal_quantile(probability: f64) -> f64 {
    student_quantile(probability, f64::INFINITY)
}

/// The value that a Student variable with `degrees_of_freedom` (above 0; infinity is the normal distribution) stays
/// below with this probability; NaN for arguments that have no such value. Relative error below 1e-9.
#[must_use]
pub fn student_quantile(probability: f64, degrees_of_freedom: f64) -> f64 {
    if !(probability > 0.0 && probability < 1.0 && degrees_of_freedom > 0.0) {
        return f64::NAN;
    }
    // Upper tails lose digits that lower tails keep, and the distribution is symmetric.
    if probability > 0.5 {
        return -student_quantile(1.0 - probability, degrees_of_freedom);
    }
    let start = Normal::standard().inverse_cdf(probability);
    if degrees_of_freedom.is_infinite() {
        return polished(&Normal::standard(), probability, start);
    }
    let Ok(distribution) = StudentsT::new(0.0, 1.0, degrees_of_freedom) else { return f64::NAN };
    polished(&distribution, probability, distribution.inverse_cdf(probability))
}

/// A quantile in the lower tail from a start near it: Newton on the logarithm of the distribution function.
fn polished(
    distribution: &(impl ContinuousCDF<f64, f64> + Continuous<f64, f64>),
    probability: f64,
    start: f64,
) -> f64 {
    /// The start has half the digits at least, and each step doubles them.
    const STEPS: usize = 3;
    (0..STEPS).fold(start, |x, _| {
        let tail = distribution.cdf(x);
        let step = (tail / probability).ln() * tail / distribution.pdf(x);
        if step.is_finite() { x - step } else { x }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_of_printed_tables() {
        // Abramowitz and Stegun, table 26.8, and the levels that the acceptance rule uses.
        let table = [
            (0.05, 1, 3.841_459),
            (0.05, 6, 12.591_587),
            (1e-3, 1, 10.827_566),
            (1e-3, 3, 16.266_236),
            (1e-3, 8, 26.124_482),
            (1e-6, 1, 23.928),
            (1e-6, 3, 30.665),
            (1e-6, 8, 42.701),
            (1e-9, 6, 53.344_573), // closed form: exp(-x/2) (1 + x/2 + x^2/8)
        ];
        for (level, nu, expected) in table {
            let got = chi_square_level(level, nu);
            assert!((got - expected).abs() < 1e-3, "level {level}, {nu}: {got}, expected {expected}");
            let back = chi_square_p_value(got, nu).unwrap();
            assert!((back / level - 1.0).abs() < 1e-9, "{back}");
        }
    }

    #[test]
    fn quantiles_of_students_distribution() {
        // mpmath 1.3, 30 digits: the root of the regularised incomplete beta function.
        let table = [
            (0.975, 1.0, 12.706_204_736_174_705),
            (0.975, 2.0, 4.302_652_729_749_464),
            (0.995, 16.0, 2.920_781_622_425_1),
            (0.975, 9.0, 2.262_157_162_798_205),
            (0.9, 3.5, 1.576_576_605_139_645_1),
            (0.977_25, 50.0, 2.051_250_781_882_188_2),
            (0.975, f64::INFINITY, 1.959_963_984_540_054_2),
            (1e-9, f64::INFINITY, -5.997_807_015_007_686_9),
        ];
        for (probability, degrees, expected) in table {
            let got = student_quantile(probability, degrees);
            assert!(
                (got / expected - 1.0).abs() < 1e-9,
                "{probability}, {degrees}: {got}, expected {expected}"
            );
            // It is symmetric, as far as doubles tell 1 - p.
            let mirrored = student_quantile(1.0 - probability, degrees);
            assert!((got + mirrored).abs() < 1e-7 * got.abs(), "{probability}, {degrees}: {mirrored}");
        }
        // Student's is wider, and becomes the normal one.
        assert!((student_quantile(0.99, 1e9) / normal_quantile(0.99) - 1.0).abs() < 1e-8);
        assert!(normal_quantile(0.5).abs() < 1e-15);
        for (probability, degrees) in [(0.0, 3.0), (1.0, 3.0), (f64::NAN, 3.0), (0.5, 0.0), (0.5, f64::NAN)] {
            assert!(student_quantile(probability, degrees).is_nan());
        }
    }
}
