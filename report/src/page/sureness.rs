//! How sure the frame is where it is used, and where that comes from.

use maud::{Markup, html};
use nalgebra::Point3;
use touchref_analysis::{
    Uncertainty,
    uncertainty::{Contribution, Spread},
};
use touchref_core::observability::direction_in_words;
use touchref_io::{
    number::{decimals, fixed, short},
    words::length_decimals,
};

use super::parts::{cell, section, table};
use crate::{
    charts::{PARTS, shares},
    subject::{PROBABILITY, Subject},
};

/// Something that is uncertain: a point of use or the rotation.
struct Quantity {
    name: String,
    /// Of its numbers, which are multiplied by `scale` to be told.
    unit: &'static str,
    scale: f64,
    fewest: usize,
    spread: Spread,
    /// Where the result tells.
    budget: Vec<Contribution>,
}

pub(super) fn budget(subject: &Subject<'_>, points: &[Point3<f64>]) -> Markup {
    let sources = subject.sources();
    let quantities = quantities(subject, points, sources.as_ref().ok());
    let body = html! {
        @if quantities.is_empty() {
            p.missing {
                "There is no uncertainty to tell: no sigma is stated, and no touch beyond the unknowns tells it."
            }
        } @else {
            (places(subject, &quantities))
            @match &sources {
                Ok(sources) => (contributions(subject, &quantities, sources)),
                Err(reason) => p.missing { "Where it comes from is not told: " (reason) "." },
            }
        }
    };
    section("budget", "Uncertainty where the frame is used", &body)
}

fn quantities(subject: &Subject<'_>, points: &[Point3<f64>], sources: Option<&Uncertainty>) -> Vec<Quantity> {
    let units = subject.units.name();
    let of_points = points.iter().filter_map(|point| {
        Some(Quantity {
            name: format!("point {}", [point.x, point.y, point.z].map(short).join(", ")),
            unit: units,
            scale: 1.0,
            fewest: length_decimals(units),
            spread: subject.spread_of_point(point)?,
            budget: sources.map_or(Vec::new(), |sources| sources.budget_of_point(point)),
        })
    });
    let turn = subject.spread_of_turn().map(|spread| Quantity {
        name: "turn".to_owned(),
        unit: "degrees",
        scale: 1.0_f64.to_degrees(),
        fewest: 4,
        spread,
        budget: sources.map_or(Vec::new(), Uncertainty::budget_of_turn),
    });
    of_points.chain(turn).collect()
}

fn places(subject: &Subject<'_>, quantities: &[Quantity]) -> Markup {
    let factor = subject.coverage_factor();
    let header = ["", "", ">x", ">y", ">z", ">worst", "along"].map(str::to_owned);
    let rows = quantities.iter().flat_map(|quantity| {
        let [x, y, z] = quantity.spread.along_axes();
        let (worst, direction) = quantity.spread.worst();
        let numbers = [x, y, z, worst].map(|u| u * quantity.scale);
        let least = numbers.into_iter().filter(|u| *u > 0.0).reduce(f64::min);
        let digits = decimals(least, quantity.fewest);
        let row = |name: &str, kind: String, factor: f64, along: String| {
            let numbers = numbers.map(|u| cell(fixed(factor * u, digits)));
            [cell(name), cell(kind)].into_iter().chain(numbers).chain([cell(along)]).collect::<Vec<_>>()
        };
        let along = direction_in_words(&*subject.fixture, &subject.frame, &direction);
        let unit = quantity.unit;
        [
            row(&quantity.name, format!("standard ({unit})"), 1.0, along),
            row("", format!("\u{b1} at {} % ({unit})", short(100.0 * PROBABILITY)), factor, String::new()),
        ]
    });
    let told = match subject.degrees_of_freedom() {
        None => "the normal distribution's".to_owned(),
        Some(degrees) => format!("Student's, with {degrees} degrees of freedom"),
    };
    html! {
        (table("Uncertainty along the parent's axes; points in fixture coordinates", &header, &rows.collect::<Vec<_>>()))
        p.note { "Coverage factor " (fixed(factor, 2)) " (" (told) "). To first order, from the covariance below." }
    }
}

fn contributions(subject: &Subject<'_>, quantities: &[Quantity], sources: &Uncertainty) -> Markup {
    let Ok(problem) = subject.problem() else { return html! {} };
    let share = |quantity: &Quantity, contribution: &Contribution| {
        let (worst, direction) = quantity.spread.worst();
        let variance = worst * worst;
        if variance > 0.0 { contribution.spread.along(&direction).powi(2) / variance } else { 0.0 }
    };
    let all = sources.budget_of_turn();
    let names: Vec<String> = all.iter().map(|contribution| contribution.source.in_words(&problem)).collect();
    let of = |quantity: &Quantity| {
        // The model is of first order at nominal sizes: of its own sum, so that parts make a whole.
        let shares: Vec<f64> =
            quantity.budget.iter().map(|contribution| share(quantity, contribution)).collect();
        let sum: f64 = shares.iter().sum();
        shares.into_iter().map(|part| if sum > 0.0 { part / sum } else { 0.0 }).collect::<Vec<f64>>()
    };
    let parts: Vec<Vec<f64>> = quantities.iter().map(of).collect();
    let mut header = vec!["source".to_owned()];
    header.extend(quantities.iter().map(|quantity| format!(">{} (%)", quantity.name)));
    let rows = names.iter().enumerate().map(|(index, source)| {
        let first = html! { span class={ "swatch part-" (index % PARTS) } {} (source) };
        let parts = parts
            .iter()
            .map(|parts| cell(parts.get(index).map_or("-".to_owned(), |part| fixed(100.0 * part, 1))));
        [first].into_iter().chain(parts).collect::<Vec<_>>()
    });
    html! {
        @for (quantity, parts) in quantities.iter().zip(&parts) {
            @let title = format!("Part of each source in the variance of {}", quantity.name);
            @let parts = names.iter().cloned().zip(parts.iter().copied()).collect::<Vec<_>>();
            p.bar-name { (quantity.name) }
            (shares(&title, &parts))
        }
        (table("Part of the variance along the worst direction, by source", &header, &rows.collect::<Vec<_>>()))
    }
}
