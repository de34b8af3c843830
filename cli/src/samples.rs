//! How many draws a Monte Carlo calculation makes, as it is typed.

use touchref::analysis::propagation::Trials;

/// Draws after which a result that is not stable is told as it is.
const MOST_DRAWS: u64 = 2_000_000;
/// Draws that may be asked for: all of their numbers are held in memory.
const MOST_SAMPLES: u64 = 10_000_000;

/// A number, or `auto`.
///
/// # Errors
/// What was expected.
pub(crate) fn trials(text: &str) -> Result<Trials, String> {
    match text.trim() {
        "auto" => Ok(Trials::Adaptive { most: MOST_DRAWS }),
        number => match number.parse() {
            Ok(count @ 1..=MOST_SAMPLES) => Ok(Trials::Fixed(count)),
            _ => Err(format!("expected a number of draws up to {MOST_SAMPLES}, or `auto`")),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_or_auto() {
        assert_eq!(trials("auto"), Ok(Trials::Adaptive { most: MOST_DRAWS }));
        assert_eq!(trials("1000"), Ok(Trials::Fixed(1000)));
        for wrong in ["", "Auto", "0", "-1", "1e6", "1.5", "10000001"] {
            assert!(trials(wrong).is_err(), "{wrong}");
        }
    }
}
