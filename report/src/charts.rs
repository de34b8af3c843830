//! Charts as SVG: one mark a touch, with its text as a title. The numbers stand in the table beside each.

use maud::{Markup, html};
use touchref_io::number::fixed;

/// Width and height of a chart, and what is kept free at its left, right, top and bottom.
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 210.0;
const LEFT: f64 = 88.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 34.0;
/// The widest bar.
const WIDEST: f64 = 26.0;

/// One touch in a chart.
pub(crate) struct Bar {
    /// What stands below it.
    pub(crate) name: String,
    /// What is said of it.
    pub(crate) text: String,
    /// Its height; `None` for one without bounds, which is drawn to the top and open.
    pub(crate) height: Option<f64>,
    /// A second mark, a dot.
    pub(crate) dot: Option<f64>,
    /// Drawn hollow: it does not count.
    pub(crate) hollow: bool,
}

/// Bars over the touches.
pub(crate) struct Chart<'a> {
    /// What it shows, for who cannot see it.
    pub(crate) title: &'a str,
    /// Of the vertical axis, with the unit.
    pub(crate) axis: &'a str,
    pub(crate) bars: Vec<Bar>,
    /// Heights at which a line is drawn, and what is said of it.
    pub(crate) lines: Vec<(f64, &'a str)>,
    /// Where the vertical axis ends, where that does not follow from the bars.
    pub(crate) up_to: Option<f64>,
}

impl Chart<'_> {
    pub(crate) fn draw(&self) -> Markup {
        let counted = self.bars.iter().filter(|bar| !bar.hollow);
        let heights: Vec<f64> = counted.flat_map(|bar| [bar.height, bar.dot]).flatten().collect();
        let lines = self.lines.iter().map(|line| line.0);
        let lowest = heights.iter().copied().fold(0.0, f64::min);
        let highest = self.up_to.unwrap_or_else(|| heights.iter().copied().chain(lines).fold(0.0, f64::max));
        let step = step(highest - lowest);
        let digits = decimals_of(step);
        // What has lines on both sides is seen from both sides.
        let low = if self.lines.iter().any(|line| line.0 < 0.0) { lowest.min(-highest) } else { lowest };
        let high = if low < 0.0 { highest.max(-low) } else { highest.max(step) };
        let low = if low < 0.0 { -high } else { low };
        let y = |value: f64| {
            let part = ((value - low) / (high - low)).clamp(0.0, 1.0);
            TOP + (1.0 - part) * (HEIGHT - TOP - BOTTOM)
        };
        let slot = (WIDTH - LEFT - RIGHT) / self.bars.len().max(1) as f64;
        let wide = (0.62 * slot).min(WIDEST);
        let every = (0..=self.bars.len()).find(|skip| slot * (skip + 1) as f64 > 24.0).unwrap_or(0) + 1;
        let chart = html! {
            svg class="chart" viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } width=(WIDTH) height=(HEIGHT) role="img" {
                title { (self.title) }
                @for tick in ticks(low, high, step) {
                    line class="grid" x1=(LEFT) x2=(WIDTH - RIGHT) y1=(tenth(y(tick))) y2=(tenth(y(tick))) {}
                    text class="tick" x=(LEFT - 6.0) y=(tenth(y(tick) + 4.0)) text-anchor="end" { (fixed(tick, digits)) }
                }
                text class="name" x="12" y=(HEIGHT - BOTTOM) transform={ "rotate(-90 12 " (HEIGHT - BOTTOM) ")" } { (self.axis) }
                @for (height, text) in &self.lines {
                    line class="limit" x1=(LEFT) x2=(WIDTH - RIGHT) y1=(tenth(y(*height))) y2=(tenth(y(*height))) { title { (text) } }
                }
                line class="zero" x1=(LEFT) x2=(WIDTH - RIGHT) y1=(tenth(y(0.0))) y2=(tenth(y(0.0))) {}
                @for (index, bar) in self.bars.iter().enumerate() {
                    @let middle = LEFT + slot * (index as f64 + 0.5);
                    g class=(if bar.hollow { "bar hollow" } else { "bar" }) {
                        title { (bar.text) }
                        (bar.mark(middle, wide, &y, [low, high]))
                    }
                    @if index % every == 0 {
                        text class="tick" x=(tenth(middle)) y=(HEIGHT - BOTTOM + 16.0) text-anchor="middle" { (bar.name) }
                    }
                }
                text class="name" x=(WIDTH - RIGHT) y=(HEIGHT - 3.0) text-anchor="end" { "touch" }
            }
        };
        // On a narrow screen it is moved, not made too small to read.
        html! { div.wide tabindex="0" role="region" aria-label=(self.title) { (chart) } }
    }
}

impl Bar {
    fn mark(&self, middle: f64, wide: f64, y: &impl Fn(f64) -> f64, [low, high]: [f64; 2]) -> Markup {
        let x = middle - 0.5 * wide;
        let height = self.height.unwrap_or(high);
        let (top, bottom) = (y(height.max(0.0)), y(height.min(0.0)));
        let beyond = self.height.is_none() || !(low..=high).contains(&height);
        html! {
            // All of its column can be pointed at.
            rect class="reach" x=(tenth(middle - 0.7 * wide)) width=(tenth(1.4 * wide)) y=(TOP) height=(HEIGHT - TOP - BOTTOM) {}
            rect class=(if self.height.is_none() { "open" } else { "value" }) x=(tenth(x)) width=(tenth(wide))
                y=(tenth(top)) height=(tenth((bottom - top).max(1.0))) {}
            @if beyond {
                @let (tip, back) = if height < 0.0 { (y(low) + 1.0, -9.0) } else { (y(high) - 1.0, 9.0) };
                path class="beyond" d={
                    "M" (tenth(middle)) " " (tenth(tip)) "l" (tenth(-0.5 * wide)) " " (back) "h" (tenth(wide)) "Z"
                } {}
            }
            @if let Some(dot) = self.dot { circle class="dot" cx=(tenth(middle)) cy=(tenth(y(dot))) r="3.4" {} }
        }
    }
}

/// A step of 1, 2 or 5 times a power of ten, of which some four make the range.
fn step(range: f64) -> f64 {
    if !range.is_normal() {
        return 1.0;
    }
    let rough = range / 4.0;
    let power = 10f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0].into_iter().find(|step| step * power >= rough).unwrap_or(10.0) * power
}

/// Digits after the point with which multiples of a step are told apart.
fn decimals_of(step: f64) -> usize {
    /// Doubles near one have no more.
    const MOST: u8 = 15;
    (0..MOST).find(|digits| step * 10f64.powi(i32::from(*digits)) > 0.99).unwrap_or(MOST).into()
}

fn ticks(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    /// Rounding of a tick, in steps.
    const ROUNDING: f64 = 1e-9;
    let first = (low / step - ROUNDING).ceil();
    (0..32)
        .map(move |k| (first + f64::from(k)) * step)
        .take_while(move |tick| *tick <= high + ROUNDING * step)
}

/// Parts of a whole as one bar; each its name and its part of one.
pub(crate) fn shares(title: &str, parts: &[(String, f64)]) -> Markup {
    const THICK: f64 = 18.0;
    let starts = parts.iter().scan(0.0, |sum, (_, part)| {
        let start = *sum;
        *sum += part;
        Some(start)
    });
    html! {
        svg class="shares" viewBox={ "0 0 " (WIDTH) " " (THICK) } width=(WIDTH) height=(THICK) preserveAspectRatio="none" role="img" {
            title { (title) }
            @for (index, ((name, part), start)) in parts.iter().zip(starts).enumerate() {
                rect class={ "part part-" (index % PARTS) } x=(tenth(start * WIDTH)) width=(tenth(part * WIDTH)) y="0" height=(THICK) {
                    title { (name) ": " (format!("{:.1} %", 100.0 * part)) }
                }
            }
        }
    }
}

/// How many parts have colours of their own; class `part-0` and so on.
pub(crate) const PARTS: usize = 6;

/// A coordinate: tenths are finer than what is seen.
pub(crate) fn tenth(value: f64) -> String {
    format!("{value:.1}")
}
