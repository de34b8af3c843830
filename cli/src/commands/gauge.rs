//! `gauge`: published worked examples of uncertainty, computed anew.

use schemars::JsonSchema;
use serde::Serialize;
use touchref::{
    analysis::{
        gauge::{CHANCE, Example, Figure, Settings, Verdict, examples},
        propagation::Trials,
    },
    io::InputError,
};

use crate::{
    args::Format,
    failure::Failure,
    output::{Output, progress},
    samples::trials,
    text,
};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.gauge/1";

/// Compute published worked examples of measurement uncertainty anew, and hold the results against what was published
///
/// The examples are of the GUM, its supplements 1 and 2, an NPL report and NIST Technical Note 1900. A figure passes when it is
/// within half a unit of the last digit published, and for a Monte Carlo result within so much more as ours scatters (chance
/// 1e-5 of being further off); NOTE is a figure that does not, for a reason that is known. Exit status 0: no other differs; 1: one does.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref gauge --samples 10000")]
pub(crate) struct Args {
    /// Seed: the same seed gives the same figures, whatever the number of threads
    #[arg(long, value_name = "N", default_value_t = Settings::default().seed)]
    seed: u64,
    /// Draws of each Monte Carlo calculation: a number, or `auto` (until its figures are stable) [default: 400000]
    #[arg(long, value_name = "N", value_parser = trials)]
    samples: Option<Trials>,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// The JSON of `gauge`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct GaugeRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// Of the random numbers.
    pub(crate) seed: u64,
    /// Trials of each Monte Carlo calculation; `null` where each made as many as it took.
    pub(crate) samples: Option<u64>,
    /// At which a Monte Carlo result is further off than its tolerance.
    pub(crate) chance: f64,
    /// How many figures are within their tolerance.
    pub(crate) pass: usize,
    /// How many are not, for a reason that is known.
    pub(crate) note: usize,
    /// How many are not, for none.
    pub(crate) diff: usize,
    /// The worked examples.
    pub(crate) examples: Vec<ExampleRecord>,
}

/// One worked example.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ExampleRecord {
    /// Where it was published.
    pub(crate) document: &'static str,
    /// Clause of the document.
    pub(crate) clause: &'static str,
    /// What is measured.
    pub(crate) title: &'static str,
    /// Where the document is found.
    pub(crate) source: &'static str,
    /// Its figures.
    pub(crate) figures: Vec<FigureRecord>,
}

/// One figure.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FigureRecord {
    /// What the figure is of.
    pub(crate) quantity: String,
    /// As published.
    pub(crate) published: &'static str,
    /// `printed` in the document, or `recomputed` for it.
    #[schemars(extend("enum" = ["printed", "recomputed"]))]
    pub(crate) origin: &'static str,
    /// As computed anew.
    pub(crate) computed: f64,
    /// Computed less published.
    pub(crate) difference: f64,
    /// By so much they may differ.
    pub(crate) tolerance: f64,
    /// The part of the tolerance that is half a unit of the last digit.
    pub(crate) rounding: f64,
    /// The part that is the scatter of ours; `null` unless it is a Monte Carlo result.
    pub(crate) scatter: Option<f64>,
    /// Standard deviation of ours.
    pub(crate) scatter_s: Option<f64>,
    /// `PASS`, `NOTE` or `DIFF`.
    #[schemars(extend("enum" = [Verdict::Pass, Verdict::Note, Verdict::Diff].map(Verdict::name)))]
    pub(crate) verdict: &'static str,
    /// Of a NOTE.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) reason: Option<&'static str>,
}

impl Args {
    pub(crate) fn run(self) -> Result<Output, Failure> {
        let trials = self.samples.unwrap_or(Settings::default().trials);
        let settings = Settings { seed: self.seed, trials };
        let bar = progress(examples().count() as u64);
        let mut records = Vec::new();
        for example in examples() {
            let figures = example.figures(settings).map_err(|error| {
                let error = InputError::new("invalid-input", error.to_string()).with_key("samples");
                error.with_help("give more --samples")
            })?;
            records.push(ExampleRecord::new(example, figures));
            bar.inc(1);
        }
        drop(bar);
        let record = GaugeRecord::new(settings, records);
        let output = Output::in_form(self.format, &record, &[], text::gauge);
        Ok(output.with_status(record.status()))
    }
}

impl GaugeRecord {
    fn new(settings: Settings, examples: Vec<ExampleRecord>) -> Self {
        let figures = || examples.iter().flat_map(|example| &example.figures);
        let count = |verdict: Verdict| figures().filter(|figure| figure.verdict == verdict.name()).count();
        Self {
            schema: SCHEMA,
            seed: settings.seed,
            samples: match settings.trials {
                Trials::Fixed(number) => Some(number),
                Trials::Adaptive { .. } => None,
            },
            chance: CHANCE,
            pass: count(Verdict::Pass),
            note: count(Verdict::Note),
            diff: count(Verdict::Diff),
            examples,
        }
    }

    /// The exit status.
    fn status(&self) -> u8 {
        u8::from(self.diff > 0)
    }
}

impl ExampleRecord {
    fn new(example: &Example, figures: Vec<Figure>) -> Self {
        let Example { document, clause, title, source, .. } = *example;
        Self {
            document,
            clause,
            title,
            source,
            figures: figures.into_iter().map(FigureRecord::from).collect(),
        }
    }
}

impl From<Figure> for FigureRecord {
    fn from(figure: Figure) -> Self {
        let verdict = figure.verdict();
        Self {
            published: figure.published,
            origin: figure.origin.name(),
            computed: figure.computed,
            difference: figure.difference(),
            tolerance: figure.tolerance(),
            rounding: figure.rounding(),
            scatter: figure.monte_carlo.map(|scatter| scatter.bound()),
            scatter_s: figure.monte_carlo.map(|scatter| scatter.s),
            reason: figure.reason.filter(|_| verdict == Verdict::Note),
            verdict: verdict.name(),
            quantity: figure.quantity,
        }
    }
}

#[cfg(test)]
mod tests {
    use touchref::analysis::gauge::Origin;

    use super::*;
    use crate::text::Look;

    #[test]
    fn one_figure_that_differs_is_told() {
        let figure = |computed| Figure {
            quantity: "u".to_owned(),
            published: "2.00",
            origin: Origin::Printed,
            computed,
            monte_carlo: None,
            reason: None,
        };
        let record = |figures: Vec<Figure>| {
            let example = examples().next().unwrap();
            GaugeRecord::new(Settings::default(), vec![ExampleRecord::new(example, figures)])
        };
        let right = record(vec![figure(2.004)]);
        assert_eq!((right.pass, right.diff, right.status()), (1, 0, 0));
        let wrong = record(vec![figure(2.004), figure(2.006)]);
        assert_eq!((wrong.pass, wrong.diff, wrong.status()), (1, 1, 1));
        let text = text::gauge(&wrong, Look::PLAIN);
        assert!(text.contains("1 figure differs.") && text.contains("DIFF"), "{text}");
    }
}
