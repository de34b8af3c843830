//! Where the fixture stands: the frame, those that were rejected, and its words in every dialect.

use maud::{Markup, html};
use nalgebra::Point3;
use touchref_core::{Literal, Registry};
use touchref_io::{
    number::{decimals, fixed, short, short_or_dash},
    solution::{DialectNote, RootRecord},
    words::{length_decimals, loss},
};

use super::parts::{cell, columns, literal, section, table};
use crate::{
    dialects::{self, Told},
    subject::{PROBABILITY, Subject},
};

/// Digits after the point of a component of an axis.
const AXIS_DIGITS: usize = 6;

pub(super) fn frame(subject: &Subject<'_>) -> Markup {
    let units = subject.units.name();
    let record = &subject.record.frame;
    let origin = Point3::origin();
    let place = subject.spread_of_point(&origin).map(|spread| spread.along_axes());
    let turn = subject.spread_of_turn().map(|spread| spread.along_axes().map(f64::to_degrees));
    let factor = subject.coverage_factor();
    let row = |name: String, values: [f64; 3], digits: usize| {
        [cell(name)].into_iter().chain(values.map(|v| cell(fixed(v, digits)))).collect::<Vec<_>>()
    };
    let least = |u: Option<[f64; 3]>| u.and_then(|u| u.into_iter().filter(|u| *u > 0.0).reduce(f64::min));
    let length_digits = decimals(least(place), length_decimals(units));
    let angle_digits = decimals(least(turn), 4);
    let mut rows = vec![row(format!("origin ({units})"), record.origin, length_digits)];
    let coverage = format!("at {} %", short(100.0 * PROBABILITY));
    if let (Some(place), Some(turn)) = (place, turn) {
        rows.push(row(format!("standard uncertainty ({units})"), place, length_digits));
        rows.push(row(format!("\u{b1} {coverage} ({units})"), place.map(|u| factor * u), length_digits));
        rows.push(row("turn about, standard uncertainty (degrees)".to_owned(), turn, angle_digits));
        rows.push(row(
            format!("turn about, \u{b1} {coverage} (degrees)"),
            turn.map(|u| factor * u),
            angle_digits,
        ));
    }
    let axes = [record.x_axis, record.y_axis, record.z_axis].into_iter().zip(["X", "Y", "Z"]);
    rows.extend(axes.map(|(axis, name)| row(format!("{name} axis"), axis, AXIS_DIGITS)));
    let body = html! {
        (table("Frame of the fixture along the parent's axes", &columns(["", ">x", ">y", ">z"]), &rows))
        p { "Quaternion x y z w: " span.number { (record.quaternion_xyzw.map(|v| fixed(v, 8)).join("  ")) } }
        @if place.is_none() { p.missing { "Uncertainties are not told: no sigma is stated, and no touch beyond the unknowns tells it." } }
    };
    section("frame", "Frame", &body)
}

pub(super) fn roots(subject: &Subject<'_>) -> Markup {
    let record = subject.record;
    let units = subject.units.name();
    let trust = &record.trust;
    let length = |length: Option<f64>, none: &str| {
        length.map_or_else(|| none.to_owned(), |v| format!("{} {units}", short(v)))
    };
    let limit = match trust.limited_by.as_str() {
        "none" => "nothing".to_owned(),
        "ambiguity" => "a second frame fits within the noise".to_owned(),
        "curvature" => "the stated uncertainty is not true: the problem is too curved".to_owned(),
        "rise" => "the stated uncertainty is not true: the misfit does not rise as predicted".to_owned(),
        "search" => "the search for other frames is not complete".to_owned(),
        other => other.to_owned(),
    };
    let second = trust.second_minimum.as_ref();
    let margin = [
        ("stated sigma of one touch", length(trust.sigma, "none is stated")),
        ("stands from a sigma of", length(trust.from_sigma, "0")),
        ("stands up to a sigma of", length(trust.up_to_sigma, "any")),
        ("what gives way above", limit),
        (
            "chi-square of the next best frame",
            second.map_or("there is none".to_owned(), |second| short_or_dash(second.chi_square)),
        ),
        ("relative curvature", short_or_dash(trust.nonlinearity)),
    ];
    let margin = margin.map(|(name, value)| vec![cell(name), cell(value)]);
    let body = html! {
        (table("The margin in which the frame stands", &columns(["", ">"]), &margin))
        @if record.roots.is_empty() {
            p.missing { "This result lists no other frames." }
        } @else {
            (table_of_roots(&record.roots, units))
        }
    };
    section("roots", "Frames that the equations allow", &body)
}

fn table_of_roots(roots: &[RootRecord], units: &str) -> Markup {
    /// Fewest digits after the point of a dimension that a root implies.
    const FEWEST: usize = 4;
    let names: Vec<&String> = roots.first().map_or(Vec::new(), |root| root.measures.keys().collect());
    let mut header = columns(["", ">misfit (sigmas)"]);
    header.extend(names.iter().map(|name| format!(">{name}")));
    header.extend(["x", "y", "z"].map(|axis| format!(">{axis} ({units})")));
    header.push("why".to_owned());
    let rows = roots.iter().enumerate().map(|(index, root)| {
        let number = |table: &serde_json::Map<String, serde_json::Value>, name: &str| {
            table.get(name).and_then(serde_json::Value::as_f64)
        };
        let measures = names.iter().map(|name| {
            let u = number(&root.measures_u, name);
            let digits = decimals(u, FEWEST);
            let value = number(&root.measures, name).map_or("-".to_owned(), |value| fixed(value, digits));
            cell(u.map_or(value.clone(), |u| format!("{value} \u{b1} {}", fixed(u, digits))))
        });
        let mut row = vec![cell(if root.selected { "taken".to_owned() } else { format!("{}", index + 1) })];
        row.push(cell(short_or_dash(root.misfit)));
        row.extend(measures);
        row.extend(root.frame.origin.map(|v| cell(fixed(v, length_decimals(units)))));
        row.push(cell(&root.reason));
        row
    });
    table("Every root, and what became of it", &header, &rows.collect::<Vec<_>>())
}

pub(super) fn dialects(subject: &Subject<'_>, registry: &Registry) -> Markup {
    let units = subject.units.name();
    let body = html! {
        p {
            "The frame as machines and programs take it, each read back and compared: what a dialect cannot tell is said in its \
             place. None has been tried on a machine: move the first time with care."
        }
        @if subject.contacts.is_none() {
            p.missing { "The result does not tell where the touches were: rounding is told at the origin." }
        }
        @if !subject.record.free.is_empty() {
            p.missing { "A dialect always tells a whole frame: what is left free of it is there as it happens to stand." }
        }
        @for told in dialects::told(subject, registry) { (dialect(&told, units)) }
    };
    section("dialects", "The frame in every dialect", &body)
}

fn dialect(told: &Told, units: &str) -> Markup {
    let wordings = html! {
        @for (name, literal) in &told.wordings { (wording(name, literal, units, told.wordings.len() == 1)) }
    };
    html! {
        article.dialect {
            h3 { code { (told.plugin.name) } " " span.summary { (told.plugin.summary) } }
            @match told.wordings.len() {
                1 => (wordings),
                count => details { summary { (count) " wordings" } (wordings) },
            }
        }
    }
}

fn wording(name: &str, told: &Result<Literal, String>, units: &str, alone: bool) -> Markup {
    html! {
        @if !alone { h4 { code { (name) } } }
        @match told {
            Err(reason) => p.missing { "Not told: " (reason) },
            Ok(told) => {
                @let note = DialectNote::from(told);
                (literal(&format!("the frame for {name}"), &told.text))
                p.note {
                    "Relative to " (note.parent) ". " (note.units) "; " (note.digits) ". Rotation: " (note.convention) ". Use: "
                    (note.usage) ". When " (loss(&note, units)) "."
                }
            }
        }
    }
}
