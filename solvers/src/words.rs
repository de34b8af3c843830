//! Numbers in messages.

use touchref_core::{ClosedForm, Problem};

/// What a root's measures say of the fixture's dimensions, and whether units seem mixed up.
pub(crate) fn wanted_dimensions(
    problem: &Problem<'_>,
    closed_form: &dyn ClosedForm,
    measures: &[f64],
) -> String {
    /// Ratios of units that are mistaken for each other.
    const UNITS: [(f64, &str); 2] = [(25.4, "inch and mm"), (1000.0, "mm and m (or um)")];
    /// Part by which a ratio may miss one of these and still be told.
    const NEAR: f64 = 0.1;
    let dimensions = problem.fixture().dimensions();
    let told = closed_form.measured().iter().zip(measures).map(|(index, measure)| {
        let dimension = &dimensions[*index];
        let ratio = measure / dimension.value;
        let close = |unit: f64| (ratio / unit - 1.0).abs() < NEAR || (ratio * unit - 1.0).abs() < NEAR;
        let mixed = UNITS.iter().find(|(unit, _)| close(*unit));
        let mixed = mixed
            .map_or_else(String::new, |(unit, names)| format!(", a factor of {unit}: {names} mixed up?"));
        let [wanted, stated] = [*measure, dimension.value].map(|v| short(v * dimension.quantity.scale()));
        format!("; the touches want {} {wanted}, the fixture says {stated}{mixed}", dimension.name)
    });
    told.collect()
}

/// Touches by number and surface: "touch 3 on `plane`", "touches 3 on `plane` and 5 on `cylinder`".
pub(crate) fn touches_in_words(problem: &Problem<'_>, touches: &[usize]) -> String {
    let surfaces = problem.fixture().surfaces();
    let told = touches.iter().map(|index| {
        format!("{} on `{}`", problem.number(*index), surfaces[problem.touches()[*index].surface].name)
    });
    format!("touch{} {}", if touches.len() == 1 { "" } else { "es" }, listed(&told.collect::<Vec<_>>()))
}

/// "a, b and c".
pub(crate) fn listed(all: &[String]) -> String {
    joined(all, ",", "and")
}

/// "a, b or c".
pub(crate) fn either(all: &[String]) -> String {
    joined(all, ",", "or")
}

/// With this mark between them, and this word before the last; of many only the first, and how many more.
pub(crate) fn joined(all: &[String], mark: &str, last: &str) -> String {
    const MOST: usize = 12;
    let between = format!("{mark} ");
    match all {
        [head @ .., end] if !head.is_empty() && all.len() <= MOST => {
            let before = if mark == "," { "" } else { mark };
            format!("{}{before} {last} {end}", head.join(&between))
        }
        [_, _, ..] => format!("{}{between}{last} {} more", all[..MOST].join(&between), all.len() - MOST),
        _ => all.concat(),
    }
}

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
    fn lists() {
        let items: Vec<String> = (0..20).map(|k| k.to_string()).collect();
        let table = [
            (0, ""),
            (1, "0"),
            (2, "0 or 1"),
            (3, "0, 1 or 2"),
            (13, "0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, or 1 more"),
        ];
        for (count, expected) in table {
            assert_eq!(super::either(&items[..count]), expected);
        }
        assert_eq!(super::joined(&items[..3], ";", "or"), "0; 1; or 2");
    }

    #[test]
    fn four_digits() {
        let table = [(0.0, "0"), (15.055_472, "15.06"), (0.000_051_234, "0.00005123"), (1.5e9, "1.500e9")];
        for (value, expected) in table {
            assert_eq!(super::short(value), expected);
        }
    }
}
