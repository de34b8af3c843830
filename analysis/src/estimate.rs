//! Measured rates and means with their own statistical uncertainty.

use std::{fmt, ops::AddAssign};

use touchref_core::statistics::chi_square_level;

/// A measured number and its standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
}

impl fmt::Display for Estimate {
    /// `6.012 +- 0.035`, with the digits after the point that the format asks for.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.value.fmt(f)?;
        f.write_str(" +- ")?;
        self.u.fmt(f)
    }
}

/// A part of many trials, and the interval in which it lies with 95 % confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// The part counted.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Share {
    /// So many of so many trials; `None` without trials.
    ///
    /// E. B. Wilson, Probable inference, the law of succession, and statistical inference (1927): true where all or
    /// none were counted, too.
    #[must_use]
    pub fn of(count: u64, trials: u64) -> Option<Self> {
        /// 97.5 % quantile of the normal distribution.
        const Z: f64 = 1.959_964;
        if trials == 0 {
            return None;
        }
        let (trials, value) = (trials as f64, count as f64 / trials as f64);
        let middle = value + Z * Z / (2.0 * trials);
        let spread = Z * (value * (1.0 - value) / trials + Z * Z / (4.0 * trials * trials)).sqrt();
        let scale = 1.0 + Z * Z / trials;
        let low = ((middle - spread) / scale).clamp(0.0, value);
        Some(Self { value, low, high: ((middle + spread) / scale).clamp(value, 1.0) })
    }
}

/// With 95 % confidence the rate of an event that was seen `count` times is below this; `None` without trials.
///
/// Exact for rare events (Poisson); where none was seen it is three over the trials.
pub(crate) fn rate_at_most(count: u64, trials: u64) -> Option<f64> {
    let degrees_of_freedom = usize::try_from(count.saturating_add(1)).ok()?.checked_mul(2)?;
    (trials > 0).then(|| (0.5 * chi_square_level(0.05, degrees_of_freedom) / trials as f64).min(1.0))
}

/// Sums over pairs, for the ratio of their means.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Ratio {
    pairs: u64,
    over: f64,
    under: f64,
    over_over: f64,
    over_under: f64,
    under_under: f64,
}

impl Ratio {
    pub(crate) fn add(&mut self, over: f64, under: f64) {
        *self += Self {
            pairs: 1,
            over,
            under,
            over_over: over * over,
            over_under: over * under,
            under_under: under * under,
        };
    }

    /// Square root of the ratio; its uncertainty to first order, from the scatter of the pairs. `None` for fewer than
    /// two, which do not tell it.
    pub(crate) fn root(&self) -> Option<Estimate> {
        if self.pairs < 2 || self.under <= 0.0 {
            return None;
        }
        let ratio = self.over / self.under;
        let scatter = self.over_over - 2.0 * ratio * self.over_under + ratio * ratio * self.under_under;
        let free = (self.pairs - 1) as f64 / self.pairs as f64;
        let value = ratio.sqrt();
        Some(Estimate { value, u: (scatter.max(0.0) / free).sqrt() / self.under / (2.0 * value) })
    }
}

impl AddAssign for Ratio {
    fn add_assign(&mut self, other: Self) {
        self.pairs += other.pairs;
        self.over += other.over;
        self.under += other.under;
        self.over_over += other.over_over;
        self.over_under += other.over_under;
        self.under_under += other.under_under;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_a_share_are_just_not_excluded() {
        for (count, trials) in [(0, 10), (1, 10), (8, 10), (10, 10), (3, 1_000_000)] {
            let share = Share::of(count, trials).unwrap();
            let counted = count as f64 / trials as f64;
            assert!((share.value - counted).abs() < 1e-15);
            // The definition: a true share at an end would have the count 1.96 of its own standard deviations off.
            for end in [share.low, share.high] {
                let deviation = (end * (1.0 - end) / trials as f64).sqrt();
                let off = (counted - end).abs() - 1.959_964 * deviation;
                assert!(off.abs() < 1e-12, "{count} of {trials}: {share:?}");
            }
        }
        assert_eq!(Share::of(0, 0), None);
    }

    #[test]
    fn rare_events_have_the_limits_of_printed_tables() {
        // One-sided 95 % upper limits of a Poisson mean (Garwood).
        for (count, limit) in [(0, 2.9957), (1, 4.7439), (2, 6.2958), (10, 16.9622)] {
            let rate = rate_at_most(count, 1000).unwrap();
            assert!((rate * 1000.0 - limit).abs() < 5e-5, "{count}: {rate}");
        }
        assert_eq!(rate_at_most(0, 1), Some(1.0));
        assert_eq!(rate_at_most(0, 0), None);
        // Many events: the normal limit, to its own accuracy.
        let rate = rate_at_most(1_000_000, 10_000_000).unwrap();
        assert!((rate * 1e7 - 1e6 - 1644.9).abs() < 3.0, "{rate}");
    }

    #[test]
    fn the_root_of_a_ratio_has_the_uncertainty_of_a_mean() {
        let of = |pairs: &[[f64; 2]]| {
            let mut ratio = Ratio::default();
            for [over, under] in pairs {
                ratio.add(*over, *under);
            }
            ratio.root()
        };
        // Mean 2, standard deviation sqrt(2), of two: standard uncertainty 1, which the root divides by 2 sqrt(2).
        let root = of(&[[1.0, 1.0], [3.0, 1.0]]).unwrap();
        assert!((root.value - 2.0_f64.sqrt()).abs() < 1e-15);
        assert!((root.u - 1.0 / 8.0_f64.sqrt()).abs() < 1e-15, "{root}");
        // Pairs in one ratio leave nothing uncertain, whatever their sizes.
        let same = of(&[[4.0, 1.0], [8.0, 2.0], [0.4, 0.1]]).unwrap();
        assert!((same.value - 2.0).abs() < 1e-15 && same.u < 1e-7, "{same}");
        assert_eq!(of(&[[1.0, 1.0]]), None);
    }
}
