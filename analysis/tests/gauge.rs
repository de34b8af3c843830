//! The published examples: none differs, and every reason is needed.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use std::collections::BTreeSet;

use touchref_analysis::{
    gauge::{Example, Figure, Settings, Verdict, examples},
    propagation::Trials,
};

/// Monte Carlo figures with a reason, and what they are without noise: NIST TN 1900 E3 by quadrature
/// (`propagation.py`); E13 to first order, whose next terms are 1e-5 of it.
const WITHOUT_NOISE: [(&str, &str, f64); 5] = [
    ("E3", "Monte Carlo: estimate", 5.825_180),
    ("E3", "Monte Carlo: u", 1.115_373),
    ("E3", "Monte Carlo: high end", 8.3993),
    ("E13", "Monte Carlo: estimate", 1.726_621e-5),
    ("E13", "Monte Carlo: u", 1.755_477e-6),
];

fn all(settings: Settings) -> Vec<(&'static Example, Figure)> {
    examples()
        .flat_map(|example| {
            example.figures(settings).unwrap().into_iter().map(move |figure| (example, figure))
        })
        .collect()
}

#[test]
fn no_published_figure_differs() {
    // Another seed and fewer trials than by default.
    for settings in [
        Settings { seed: 11, trials: Trials::Fixed(100_000) },
        Settings { seed: 12, trials: Trials::Fixed(40_000) },
    ] {
        let figures = all(settings);
        assert!(figures.len() >= 100, "{}", figures.len());
        for (example, figure) in figures {
            assert_ne!(
                figure.verdict(),
                Verdict::Diff,
                "{} {}: {figure:?}",
                example.document,
                example.clause
            );
        }
    }
}

#[test]
fn every_reason_is_needed() {
    let mut reasons = 0;
    for (example, figure) in all(Settings { trials: Trials::Fixed(40_000), ..Settings::default() }) {
        if figure.reason.is_none() {
            continue;
        }
        reasons += 1;
        let place = (example.clause, figure.quantity.as_str());
        let Some(scatter) = figure.monte_carlo else {
            assert_eq!(figure.verdict(), Verdict::Note, "{place:?}: {figure:?}");
            continue;
        };
        // Enough trials would make it a note.
        let (_, _, exact) = WITHOUT_NOISE.iter().find(|(clause, name, _)| (*clause, *name) == place).unwrap();
        let published: f64 = figure.published.parse().unwrap();
        assert!((exact - published).abs() > figure.rounding(), "{place:?}: {exact}");
        assert!((figure.computed - exact).abs() <= scatter.bound(), "{place:?}: {figure:?}");
    }
    assert_eq!(reasons, 4 + WITHOUT_NOISE.len());
}

#[test]
fn every_figure_has_its_own_place() {
    let mut places = BTreeSet::new();
    for (example, figure) in all(Settings { trials: Trials::Fixed(2000), ..Settings::default() }) {
        let place = (example.document, example.clause, figure.quantity.clone());
        assert!(places.insert(place.clone()), "{place:?} twice");
        assert!(figure.difference().is_finite() && figure.tolerance() > 0.0, "{place:?}: {figure:?}");
        assert!(!example.source.is_empty() && !example.title.is_empty());
    }
}

/// A wrong number does not hide: each figure moved by two units of its last digit and twice the scatter of ours.
#[test]
fn a_wrong_figure_differs() {
    for (example, figure) in all(Settings { trials: Trials::Fixed(2000), ..Settings::default() }) {
        let moved = 4.0 * figure.rounding() + 2.0 * figure.monte_carlo.map_or(0.0, |scatter| scatter.bound());
        let published: f64 = figure.published.parse().unwrap();
        let wrong = Figure { computed: published + moved, reason: None, ..figure };
        assert_eq!(wrong.verdict(), Verdict::Diff, "{}: {wrong:?}", example.clause);
    }
}

#[test]
fn settings_that_tell_nothing_are_errors() {
    let few = Settings { trials: Trials::Fixed(10), ..Settings::default() };
    assert!(examples().any(|example| example.figures(few).is_err()));
}
