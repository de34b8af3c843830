//! For the record: what the frame was found from.

use maud::{Markup, html};
use touchref_io::{
    number::short_or_dash,
    solution::FixtureRecord,
    words::{counted, in_words, touches, unknowns},
};

use super::parts::{cell, columns, literal, name, section, table};
use crate::{raw::Raw, subject::Subject};

pub(super) fn record(subject: &Subject<'_>, notes: &[String]) -> Markup {
    let record = subject.record;
    let units = &record.units;
    let body = html! {
        @if !notes.is_empty() {
            h3 { "Notes" }
            @for note in notes { p.words { (note) } }
        }
        (table("Measurement", &columns(["", ""]), &facts(subject)))
        (fixture(&record.fixture, units))
        @if !record.adjustments.is_empty() { (adjustments(subject)) }
        (covariance(subject))
        (raw(subject))
    };
    section("record", "For the record", &body)
}

fn facts(subject: &Subject<'_>) -> Vec<Vec<Markup>> {
    let record = subject.record;
    let units = &record.units;
    let or_none =
        |value: Option<f64>, none: &str| value.map_or(none.to_owned(), |value| format!("{value} {units}"));
    let misfit = match (record.chi_square, record.p_value) {
        (Some(chi_square), Some(p)) => format!("chi-square {chi_square}, p = {p}"),
        (Some(chi_square), None) => format!("chi-square {chi_square}"),
        (None, _) => "no chi-square, as no sigma is stated".to_owned(),
    };
    let iteration = record.iteration.as_ref().map_or("none".to_owned(), |iteration| {
        format!("{}, ended by `{}`", counted(iteration.steps, "step", "steps"), iteration.stopped_by)
    });
    let facts = [
        (
            "report made by",
            format!(
                "touchref {}; with which version the frame was found the result does not state",
                env!("CARGO_PKG_VERSION")
            ),
        ),
        ("result", record.schema.clone()),
        ("unit of lengths", units.clone()),
        ("solver", record.solver.clone()),
        ("iteration", iteration),
        ("touches", touches(&record.touches)),
        (
            "tip radius",
            match record.probe.tip_radius_u {
                0.0 => or_none(Some(record.probe.tip_radius), ""),
                u => format!("{} \u{b1} {u} {units} (standard)", record.probe.tip_radius),
            },
        ),
        ("sigma of one touch", or_none(record.probe.sigma, "not stated for the probe")),
        ("rms of the residuals", or_none(record.rms, "-")),
        ("misfit", misfit),
        (
            "degrees of freedom",
            format!("{} ({} unknowns)", record.degrees_of_freedom, in_words(unknowns(record))),
        ),
        ("date, place, operator", "not stated by the result".to_owned()),
    ];
    facts.into_iter().map(|(name, value)| vec![cell(name), cell(value)]).collect()
}

fn fixture(fixture: &FixtureRecord, units: &str) -> Markup {
    let rows = fixture.parameters.iter().map(|(parameter, value)| {
        let tables = value.as_array().filter(|tables| tables.iter().any(serde_json::Value::is_object));
        let told = match (value.get("value"), value.get("u"), tables) {
            (Some(value), Some(u), _) => html! { (value) " \u{b1} " (u) " (standard)" },
            (_, _, Some(tables)) => html! { @for table in tables { code.line { (table) } } },
            _ => cell(value.as_str().map_or_else(|| value.to_string(), str::to_owned)),
        };
        vec![name(parameter), told]
    });
    let caption = format!("Fixture `{}`, lengths in {units}, angles as their names say", fixture.kind);
    table(&caption, &columns(["parameter", "value"]), &rows.collect::<Vec<_>>())
}

fn adjustments(subject: &Subject<'_>) -> Markup {
    let rows = subject.record.adjustments.iter().map(|adjusted| {
        let numbers = [adjusted.nominal, adjusted.nominal_u, adjusted.value, adjusted.u, adjusted.moved];
        [name(&adjusted.name)]
            .into_iter()
            .chain(numbers.map(|number| cell(short_or_dash(number))))
            .collect::<Vec<_>>()
    });
    let header = columns(["", ">stated", ">\u{b1}", ">estimated", ">\u{b1}", ">moved by (of its \u{b1})"]);
    table("Sizes that were unknowns beside the frame", &header, &rows.collect::<Vec<_>>())
}

fn covariance(subject: &Subject<'_>) -> Markup {
    let Some(covariance) = &subject.record.covariance else {
        return html! { p.missing { "There is no covariance." } };
    };
    let rows = covariance.matrix.iter().zip(&covariance.order).map(|(row, name)| {
        [cell(name)].into_iter().chain(row.map(|v| cell(format!("{v:.4e}")))).collect::<Vec<_>>()
    });
    let header: Vec<String> =
        [String::new()].into_iter().chain(covariance.order.iter().map(|name| format!(">{name}"))).collect();
    let caption = format!(
        "Covariance of the frame: {} and radians, along the parent's axes, about the fixture's origin",
        subject.units
    );
    table(&caption, &header, &rows.collect::<Vec<_>>())
}

fn raw(subject: &Subject<'_>) -> Markup {
    let Some(Raw { text, sha256 }) = Raw::of(&subject.record.touches) else {
        return html! { p.missing { "The result, an older one, does not tell where the touches were: there is nothing to hash." } };
    };
    html! {
        h3 { "Touches as measured" }
        p { "SHA-256 of the table below: " code.hash #hash { (sha256) } }
        p.note {
            "Tip centres in " (subject.units) ", every digit that counts, lines ended by a line feed. Copied into a file `touches.csv` \
             (with a line feed after the last line), it is what touchref reads with --touches, and `sha256sum touches.csv` prints this \
             hash."
        }
        div #raw { (literal("the touches as measured", &text)) }
    }
}
