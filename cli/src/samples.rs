//! How many trials a Monte Carlo calculation makes, as it is typed.

use std::str::FromStr;

use touchref::analysis::propagation::Trials;

/// A number, or `auto`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Samples {
    /// So many.
    Number(u64),
    /// Until the results are stable.
    Auto,
}

impl Samples {
    /// The same for the calculation, which holds so many in memory at most.
    pub(crate) fn trials(self, most: u64) -> Trials {
        match self {
            Self::Number(number) => Trials::Fixed(number),
            Self::Auto => Trials::Adaptive { most },
        }
    }
}

impl FromStr for Samples {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            number => {
                number.parse().map(Self::Number).map_err(|_| "expected a whole number, or auto".to_owned())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_or_auto() {
        assert_eq!("auto".parse(), Ok(Samples::Auto));
        assert_eq!("1000".parse(), Ok(Samples::Number(1000)));
        for wrong in ["", "Auto", "-1", "1e6", "1.5"] {
            assert!(wrong.parse::<Samples>().is_err(), "{wrong}");
        }
    }
}
