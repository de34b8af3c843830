//! How times grow with the touches, as a picture: both axes logarithmic, legible on light and on dark.

use std::fmt::Write as _;

use super::Measured;

/// Size of the picture, and what of it is left of, above, right of and below the plot.
const SIZE: (f64, f64) = (760.0, 480.0);
const MARGINS: [f64; 4] = [64.0, 16.0, 210.0, 48.0];
/// Colours of the lines, on light and on dark.
const COLOURS: [(&str, &str); 6] = [
    ("#0b57d0", "#8ab4f8"),
    ("#7a3fc2", "#c58af9"),
    ("#c5221f", "#f28b82"),
    ("#b06000", "#fdb45c"),
    ("#137333", "#81c995"),
    ("#5f6368", "#bdc1c6"),
];
/// Names of lines stay so far apart.
const APART: f64 = 16.0;

/// The median times of these methods over random layouts.
pub(crate) fn growth(measured: &[Measured<'_>], methods: &[&str]) -> String {
    let sets: Vec<&Measured<'_>> = measured.iter().filter(|set| !set.set.name.contains("nominal")).collect();
    let lines: Vec<(&str, Vec<(f64, f64)>)> = methods
        .iter()
        .map(|name| {
            let at = |set: &&Measured<'_>| Some((set.set.touches() as f64, set.time(name)?));
            (*name, sets.iter().filter_map(at).collect())
        })
        .filter(|(_, points): &(_, Vec<_>)| !points.is_empty())
        .collect();
    let all = || lines.iter().flat_map(|(_, points)| points);
    let decades = |value: &dyn Fn(&(f64, f64)) -> f64| {
        let logs = || all().map(|point| value(point).log10());
        (logs().fold(f64::INFINITY, f64::min).floor(), logs().fold(f64::NEG_INFINITY, f64::max).ceil())
    };
    let (across, up) = (decades(&|point| point.0), decades(&|point| point.1));
    let [left, top, right, below] = MARGINS;
    let (wide, high) = (SIZE.0 - left - right, SIZE.1 - top - below);
    let x = |touches: f64| left + wide * (touches.log10() - across.0) / (across.1 - across.0);
    let y = |time: f64| top + high * (1.0 - (time.log10() - up.0) / (up.1 - up.0));

    let mut svg = String::new();
    let _ = writeln!(
        svg,
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {}" role="img" font-family="system-ui, sans-serif" font-size="13">
<title>Median time of a problem over its touches, 7 to 10 000</title>
<style>
text {{ fill: #202124 }} .grid {{ stroke: #dadce0 }} .back {{ fill: #ffffff }}
polyline {{ fill: none; stroke-width: 2 }}"#,
        SIZE.0, SIZE.1
    );
    for (k, (light, _)) in COLOURS.iter().enumerate() {
        let _ = writeln!(svg, ".l{k} {{ stroke: {light} }} .f{k} {{ fill: {light} }}");
    }
    svg.push_str("@media (prefers-color-scheme: dark) {\ntext { fill: #e8eaed } .grid { stroke: #44474c } .back { fill: #1b1c1f }\n");
    for (k, (_, dark)) in COLOURS.iter().enumerate() {
        let _ = writeln!(svg, ".l{k} {{ stroke: {dark} }} .f{k} {{ fill: {dark} }}");
    }
    svg.push_str("}\n</style>\n");
    let _ = writeln!(svg, r#"<rect class="back" width="{}" height="{}"/>"#, SIZE.0, SIZE.1);
    for decade in powers(up) {
        let at = y(decade);
        let _ = writeln!(
            svg,
            r#"<path class="grid" d="M{left} {at:.1}h{wide}"/><text x="{}" y="{:.1}" text-anchor="end">{}</text>"#,
            left - 8.0,
            at + 4.5,
            duration(decade)
        );
    }
    for decade in powers(across) {
        let at = x(decade);
        let _ = writeln!(
            svg,
            r#"<path class="grid" d="M{at:.1} {top}v{high}"/><text x="{at:.1}" y="{}" text-anchor="middle">{decade:.0}</text>"#,
            top + high + 20.0
        );
    }
    let _ = writeln!(
        svg,
        r#"<text x="{:.1}" y="{}" text-anchor="middle">touches</text>"#,
        left + 0.5 * wide,
        SIZE.1 - 8.0
    );
    // Names stand at the ends of their lines, from the top, none over another.
    let mut order: Vec<usize> = (0..lines.len()).collect();
    let end = |k: usize| lines[k].1.last().map_or(0.0, |point| y(point.1));
    order.sort_by(|a, b| end(*a).total_cmp(&end(*b)));
    let mut free = f64::NEG_INFINITY;
    for k in order {
        let (name, points) = &lines[k];
        let colour = k % COLOURS.len();
        let path: Vec<String> =
            points.iter().map(|(touches, time)| format!("{:.1},{:.1}", x(*touches), y(*time))).collect();
        let _ = writeln!(svg, r#"<polyline class="l{colour}" points="{}"/>"#, path.join(" "));
        for (touches, time) in points {
            let _ = writeln!(
                svg,
                r#"<circle class="f{colour}" cx="{:.1}" cy="{:.1}" r="3"/>"#,
                x(*touches),
                y(*time)
            );
        }
        let at = (end(k) + 4.5).max(free + APART);
        free = at;
        let from = points.last().map_or(0.0, |point| x(point.0));
        let _ = writeln!(
            svg,
            r#"<text class="f{colour}" x="{:.1}" y="{at:.1}">{}</text>"#,
            from + 10.0,
            name.replace('`', "")
        );
    }
    svg.push_str("</svg>\n");
    svg
}

/// The powers of ten between two.
fn powers((from, to): (f64, f64)) -> impl Iterator<Item = f64> {
    let next = move |exponent: &f64| (*exponent < to).then_some(exponent + 1.0);
    std::iter::successors(Some(from), next).map(|exponent| 10.0_f64.powf(exponent))
}

fn duration(nanoseconds: f64) -> String {
    match nanoseconds {
        time if time < 999.0 => format!("{time:.0} ns"),
        time if time < 999e3 => format!("{:.0} us", time / 1e3),
        time => format!("{:.0} ms", time / 1e6),
    }
}
