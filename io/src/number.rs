//! Numbers as text: as many digits as they are worth.

/// A number with so many digits after the point; no exponent, no negative zero.
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
    if zero { text.trim_start_matches('-').to_owned() } else { text }
}

/// Digits after the point at which two digits of the uncertainty `u` show; at least `fewest`, at most 12.
#[must_use]
pub fn decimals(u: Option<f64>, fewest: usize) -> usize {
    /// Doubles near one have no more.
    const MOST: usize = 12;
    match u {
        Some(u) if u > 0.0 && u.is_finite() => {
            let wanted =
                (1..=MOST).find(|&decimals| u * 10f64.powi(clamped(decimals)) >= 9.5).unwrap_or(MOST);
            wanted.max(fewest)
        }
        _ => fewest,
    }
}

fn clamped(decimals: usize) -> i32 {
    i32::try_from(decimals).unwrap_or(i32::MAX)
}

/// A number of which the size matters: three digits, plain where that reads well.
#[must_use]
pub fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-5..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    let decimals = (0..=7).find(|&decimals| size * 10f64.powi(decimals) >= 99.95).unwrap_or(7);
    let text = format!("{value:.0$}", usize::try_from(decimals).unwrap_or(0));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The same, or a dash where there is no number.
#[must_use]
pub fn short_or_dash(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), short)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_uncertainty() {
        for (u, fewest, expected) in [
            (Some(0.000_05), 3, 6),
            (Some(0.012), 3, 3),
            (Some(0.001_2), 3, 4),
            (Some(25.0), 0, 1),
            (Some(0.0), 3, 3),
            (None, 4, 4),
            (Some(1e-30), 3, 12),
        ] {
            assert_eq!(decimals(u, fewest), expected, "{u:?}");
        }
        assert_eq!(fixed(-0.000_04, 3), "0.000");
        assert_eq!(fixed(-1.25, 1), "-1.2");
    }

    #[test]
    fn sizes_are_short() {
        for (value, expected) in [
            (0.000_05, "0.00005"),
            (0.001_234_5, "0.00123"),
            (7.1e-7, "7.10e-7"),
            (12.345, "12.3"),
            (123_456.0, "123456"),
            (0.0, "0"),
            (-2.5, "-2.5"),
            (1e9, "1.00e9"),
        ] {
            assert_eq!(short(value), expected);
        }
    }
}
