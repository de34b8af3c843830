//! Numbers in messages.

/// Four significant digits, without an exponent where that stays readable.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor();
    if (-6.0..7.0).contains(&magnitude) {
        // In range by the test above.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let decimals = (3.0 - magnitude).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn four_digits() {
        let table = [(0.0, "0"), (15.055_472, "15.06"), (0.000_051_234, "0.00005123"), (1.5e9, "1.500e9")];
        for (value, expected) in table {
            assert_eq!(super::short(value), expected);
        }
    }
}
