//! The distributions of chi-square and F: p-values and levels. Quantiles of the normal distribution and of Student's.

use std::sync::OnceLock;

use statrs::{
    distribution::{ChiSquared, Continuous, ContinuousCDF, Normal, StudentsT},
    function::beta::{checked_beta_reg, inv_beta_reg},
};

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

/// Chance that the ratio of two mean squares exceeds `value` (distribution F): of `degrees_of_freedom` over
/// `of_estimate`, the degrees of freedom of the estimated variance. `None` without either.
#[must_use]
pub fn f_p_value(value: f64, degrees_of_freedom: usize, of_estimate: usize) -> Option<f64> {
    let (a, b) = (degrees_of_freedom as f64, of_estimate as f64);
    if value <= 0.0 {
        return (a > 0.0 && b > 0.0).then_some(1.0);
    }
    // Not as one minus something: small chances keep their digits.
    checked_beta_reg(0.5 * b, 0.5 * a, b / (b + a * value)).ok()
}

/// The value that the ratio of two mean squares exceeds with chance `level`: of `degrees_of_freedom` over `of_estimate`,
/// both at least 1.
#[must_use]
pub fn f_level(level: f64, degrees_of_freedom: usize, of_estimate: usize) -> f64 {
    let (a, b) = (degrees_of_freedom.max(1) as f64, of_estimate.max(1) as f64);
    let share = inv_beta_reg(0.5 * b, 0.5 * a, level);
    b / a * (1.0 / share - 1.0)
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
    /// From here on the expansion about the normal distribution is exact in doubles, and quicker.
    const NEARLY_NORMAL: f64 = 1e4;
    if !(probability > 0.0 && probability < 1.0 && degrees_of_freedom > 0.0) {
        return f64::NAN;
    }
    // Upper tails lose digits that lower tails keep, and the distribution is symmetric.
    if probability > 0.5 {
        return -student_quantile(1.0 - probability, degrees_of_freedom);
    }
    if degrees_of_freedom < NEARLY_NORMAL {
        let distribution = StudentsT::new(0.0, 1.0, degrees_of_freedom);
        return distribution.map_or(f64::NAN, |distribution| lower_quantile(&distribution, probability));
    }
    let z = lower_quantile(&Normal::standard(), probability);
    // Abramowitz and Stegun, 26.7.5.
    let terms = [
        (z.powi(3) + z) / 4.0,
        (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0,
        (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0,
    ];
    terms.iter().zip(1..).fold(z, |sum, (term, power)| sum + term / degrees_of_freedom.powi(power))
}

/// By which a standard uncertainty of so many degrees of freedom is multiplied for an interval to either side that covers with
/// this probability; arguments as of [`student_quantile`].
#[must_use]
pub fn student_factor(probability: f64, degrees_of_freedom: f64) -> f64 {
    student_quantile(0.5 + 0.5 * probability, degrees_of_freedom)
}

/// A quantile in the lower half of a distribution that is symmetric about zero: Newton's method on the logarithm of the
/// distribution function, within a bracket.
fn lower_quantile(
    distribution: &(impl ContinuousCDF<f64, f64> + Continuous<f64, f64>),
    probability: f64,
) -> f64 {
    /// More halvings than a double has bits; Newton's steps take a handful.
    const STEPS: usize = 200;
    let (mut low, mut high) = (-1.0, 0.0);
    while distribution.cdf(low) > probability && low > f64::MIN {
        (low, high) = (2.0 * low, low);
    }
    let mut x = low;
    for _ in 0..STEPS {
        let tail = distribution.cdf(x);
        *(if tail < probability { &mut low } else { &mut high }) = x;
        let newton = x - (tail / probability).ln() * tail / distribution.pdf(x);
        let next = if (low..=high).contains(&newton) { newton } else { 0.5 * (low + high) };
        let settled = (next - x).abs() <= f64::EPSILON * x.abs();
        x = next;
        if settled {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_printed_tables() {
        // Upper points of F: level, degrees of freedom, of the estimate; Abramowitz and Stegun, table 26.9; those of two
        // degrees of freedom over n are n/2 (level^(-2/n) - 1).
        let table = [
            (0.05, 6, 2, 19.33),
            (0.05, 6, 10, 3.22),
            (0.01, 6, 1, 5859.0),
            (0.001, 6, 4, 50.53),
            (0.001, 3, 30, 7.05),
            (0.001, 2, 8, 4.0 * (1e-3_f64.powf(-0.25) - 1.0)),
            (1e-6, 2, 4, 2.0 * (1e-6_f64.powf(-0.5) - 1.0)),
        ];
        for (level, a, b, expected) in table {
            let got = f_level(level, a, b);
            assert!((got / expected - 1.0).abs() < 2e-3, "level {level}, {a} over {b}: {got}");
            let back = f_p_value(got, a, b).unwrap();
            assert!((back / level - 1.0).abs() < 1e-6, "level {level}, {a} over {b}: {back}");
        }
        // An estimate of very many is as good as known.
        let known = chi_square_level(1e-3, 6) / 6.0;
        assert!((f_level(1e-3, 6, 10_000_000) / known - 1.0).abs() < 1e-5);
        assert_eq!(
            (f_p_value(0.0, 6, 1), f_p_value(1.0, 6, 0), f_p_value(f64::NAN, 6, 1)),
            (Some(1.0), None, None)
        );
    }

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

    /// More degrees of freedom than are kept, too.
    #[test]
    fn a_level_keeps_its_values() {
        let level = Level::new(1e-3);
        assert!((level.chance() - 1e-3).abs() < f64::EPSILON);
        for degrees in [1, 3, 8, 64, 65, 66, 200] {
            let expected = chi_square_level(1e-3, degrees);
            assert!((level.value(degrees) - expected).abs() < f64::EPSILON * expected, "{degrees}");
        }
    }

    #[test]
    fn an_interval_has_half_of_what_it_misses_on_either_side() {
        // The tables have one side: 0.975, and 0.995.
        assert!((student_factor(0.95, 9.0) / 2.262_157_162_798_205 - 1.0).abs() < 1e-9);
        assert!((student_factor(0.99, 16.0) / 2.920_781_622_425_1 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn quantiles_of_students_distribution() {
        // mpmath 1.3, 30 digits: the root of the regularised incomplete beta function.
        let table = [
            (0.975, 1.0, 12.706_204_736_174_705),
            (0.975, 2.0, 4.302_652_729_749_464),
            (0.995, 16.0, 2.920_781_622_425_1),
            (0.975, 9.0, 2.262_157_162_798_205),
            (0.9, 3.5, 1.576_576_605_139_645),
            (0.977_25, 50.0, 2.051_250_781_882_188_3),
            (0.975, 9_999.0, 1.960_201_263_621_358),
            (0.975, 10_001.0, 1.960_201_216_164_641_2),
            (0.999_99, 0.5, 1_028_491_156.316_34),
            (0.975, f64::INFINITY, 1.959_963_984_540_054_3),
            (1e-9, f64::INFINITY, -5.997_807_015_007_686_5),
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
