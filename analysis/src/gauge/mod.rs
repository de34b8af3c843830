//! Published worked examples of uncertainty, computed anew by [`crate::propagation`] and held against what their
//! documents say.
//!
//! A figure passes when it rounds to the published one: when it is within half a unit of its last digit, and for a
//! Monte Carlo result within so much more as ours scatters. What does not pass has a reason that is
//! known, or is a difference.

mod gum;
mod jcgm101;
mod jcgm102;
mod nist;
mod npl;

use nalgebra::DMatrix;
use touchref_core::statistics::student_quantile;

use crate::propagation::{Interval, MonteCarlo, Propagated, PropagationError, Trials};

/// Chance at which a Monte Carlo result of ours is further off than its tolerance: of all figures, fewer than one in a
/// thousand runs.
pub const CHANCE: f64 = 1e-5;

/// How the examples are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// The same seed gives the same figures.
    pub seed: u64,
    /// Of each Monte Carlo calculation.
    pub trials: Trials,
}

impl Default for Settings {
    /// Enough trials for two digits of most examples.
    fn default() -> Self {
        Self { seed: 0, trials: Trials::Fixed(400_000) }
    }
}

impl Settings {
    fn monte_carlo(self, probability: f64, interval: Interval) -> MonteCarlo {
        /// As the published tables show.
        const DIGITS: u32 = 2;
        MonteCarlo { probability, digits: DIGITS, seed: self.seed, trials: self.trials, interval }
    }
}

/// One worked example.
#[derive(Debug, Clone, Copy)]
pub struct Example {
    /// The document it stands in.
    pub document: &'static str,
    /// Where in the document.
    pub clause: &'static str,
    /// What it is about.
    pub title: &'static str,
    /// Where its inputs and published figures were taken from.
    pub source: &'static str,
    compute: fn(Settings) -> Result<Vec<Figure>, PropagationError>,
}

impl Example {
    /// Computes its figures.
    ///
    /// # Errors
    /// [`PropagationError`], where the settings ask for what cannot be.
    pub fn figures(&self, settings: Settings) -> Result<Vec<Figure>, PropagationError> {
        (self.compute)(settings)
    }
}

/// All examples, by document.
pub fn examples() -> impl Iterator<Item = &'static Example> {
    [gum::EXAMPLES, jcgm101::EXAMPLES, jcgm102::EXAMPLES, npl::EXAMPLES, nist::EXAMPLES].into_iter().flatten()
}

/// How a published figure is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The document prints it, as our source quotes it.
    Printed,
    /// Computed for the document's example from closed forms or by other programs; the document itself was not at hand.
    Recomputed,
}

impl Origin {
    /// One word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Recomputed => "recomputed",
        }
    }
}

/// One published figure, and ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What it is.
    pub quantity: String,
    /// As published: its last digit decides.
    pub published: &'static str,
    /// How that is known.
    pub origin: Origin,
    /// Ours.
    pub computed: f64,
    /// How ours scatters; `None` unless it comes of a Monte Carlo calculation.
    pub monte_carlo: Option<Scatter>,
    /// Why ours is another one, where that is known.
    pub reason: Option<&'static str>,
}

/// What is known of the scatter of a Monte Carlo result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Standard deviation.
    pub s: f64,
    /// Degrees of freedom of that: blocks of trials less one.
    pub degrees_of_freedom: f64,
}

impl Scatter {
    /// The result is further off than this with [`CHANCE`] only.
    #[must_use]
    pub fn bound(&self) -> f64 {
        student_quantile(1.0 - 0.5 * CHANCE, self.degrees_of_freedom) * self.s
    }
}

/// What comes of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Ours is the published figure.
    Pass,
    /// It is not, for a reason that is known.
    Note,
    /// It is not.
    Diff,
}

impl Verdict {
    /// As it is printed.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "PASS",
            Self::Note => "NOTE",
            Self::Diff => "DIFF",
        }
    }
}

impl Figure {
    fn new(origin: Origin, quantity: &str, published: &'static str, computed: f64) -> Self {
        let quantity = quantity.to_owned();
        Self { quantity, published, origin, computed, monte_carlo: None, reason: None }
    }

    fn printed(quantity: &str, published: &'static str, computed: f64) -> Self {
        Self::new(Origin::Printed, quantity, published, computed)
    }

    fn recomputed(quantity: &str, published: &'static str, computed: f64) -> Self {
        Self::new(Origin::Recomputed, quantity, published, computed)
    }

    fn with_monte_carlo(self, scatter: Scatter) -> Self {
        Self { monte_carlo: Some(scatter), ..self }
    }

    fn because(self, reason: &'static str) -> Self {
        Self { reason: Some(reason), ..self }
    }

    /// Half a unit of the last published digit.
    #[must_use]
    pub fn rounding(&self) -> f64 {
        0.5 * last_digit(self.published)
    }

    /// By so much ours may differ.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        /// Doubles near a published number are no nearer to it: a figure that is exactly half a unit off passes.
        const ROUNDING: f64 = 1e-9;
        self.rounding() * (1.0 + ROUNDING) + self.monte_carlo.map_or(0.0, |scatter| scatter.bound())
    }

    /// By how much it does; NaN where the published text is no number.
    #[must_use]
    pub fn difference(&self) -> f64 {
        self.published.parse().map_or(f64::NAN, |published: f64| self.computed - published)
    }

    /// Pass, note or difference.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        match self.reason {
            _ if self.difference().abs() <= self.tolerance() => Verdict::Pass,
            Some(_) => Verdict::Note,
            None => Verdict::Diff,
        }
    }
}

/// One unit of the last digit of a number as written: `12.30` has 0.01, `1.5e-3` has 0.0001.
fn last_digit(written: &str) -> f64 {
    let (mantissa, exponent) = written.split_once('e').unwrap_or((written, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let exponent = exponent.parse().unwrap_or(0) - i32::try_from(decimals).unwrap_or(i32::MAX);
    // One division instead of many: a power of ten that is a double is exact.
    if exponent < 0 { 1.0 / 10.0_f64.powi(-exponent) } else { 10.0_f64.powi(exponent) }
}

/// Names of the four numbers of a Monte Carlo result.
const RESULTS: [&str; 4] = ["estimate", "u", "low end", "high end"];

/// Figures of one output of a Monte Carlo calculation, by the published estimate, standard uncertainty, low and high end;
/// what is not published is left out.
fn monte_carlo_figures(
    origin: Origin,
    name: &str,
    published: [Option<&'static str>; 4],
    drawn: &Propagated,
    output: usize,
) -> Vec<Figure> {
    let degrees_of_freedom = drawn.blocks as f64 - 1.0;
    let output = &drawn.outputs[output];
    let numerical = &output.numerical;
    let ours = [
        (output.estimate, numerical.estimate),
        (output.u, numerical.u),
        (output.low, numerical.low),
        (output.high, numerical.high),
    ];
    let figures = RESULTS.iter().zip(published).zip(ours).filter_map(|((result, published), (value, s))| {
        let quantity = format!("Monte Carlo: {name}{result}");
        Some(
            Figure::new(origin, &quantity, published?, value)
                .with_monte_carlo(Scatter { s, degrees_of_freedom }),
        )
    });
    figures.collect()
}

/// Correlation matrix of two quantities.
fn correlation_of_two(coefficient: f64) -> DMatrix<f64> {
    DMatrix::from_fn(2, 2, |i, j| if i == j { 1.0 } else { coefficient })
}

/// Tells nothing of the trials.
fn quietly(_: u64) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digit_decides() {
        for (written, unit) in [
            ("12", 1.0),
            ("-0.1712", 1e-4),
            ("2.00", 0.01),
            ("5.67037e-8", 1e-13),
            ("2.05e-13", 1e-15),
            ("3e4", 1e4),
        ] {
            assert!((last_digit(written) / unit - 1.0).abs() < 1e-12, "{written}: {}", last_digit(written));
        }
        let figure = |computed| Figure::printed("x", "0.295", computed);
        assert_eq!(figure(0.2954).verdict(), Verdict::Pass);
        assert_eq!(figure(0.2955).verdict(), Verdict::Pass);
        assert_eq!(figure(0.2956).verdict(), Verdict::Diff);
        assert_eq!(figure(0.2956).because("it is rounded down").verdict(), Verdict::Note);
        // Printed tables of Student's distribution: 99.9995 % is beyond 4.4 deviations, whatever the degrees of freedom.
        let scatter = Scatter { s: 0.0001 / 4.4, degrees_of_freedom: 9.0 };
        assert_eq!(figure(0.2956).with_monte_carlo(scatter).verdict(), Verdict::Pass);
        assert!(scatter.bound() > Scatter { degrees_of_freedom: 39.0, ..scatter }.bound());
        assert_eq!(figure(f64::NAN).verdict(), Verdict::Diff);
    }
}
