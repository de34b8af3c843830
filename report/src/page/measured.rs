//! The touches: how far they are from their surfaces, and what each does to the frame.

use maud::{Markup, html};
use nalgebra::{Point3, Vector6};
use touchref_analysis::Test;
use touchref_io::{
    number::{decimals, fixed, short, short_or_dash},
    solution::ResidualRecord,
    words::{self, length_decimals},
};

use super::parts::{cell, columns, name, section, table};
use crate::{
    charts::{Bar, Chart},
    subject::{Influence, Observed, Subject},
};

/// The most rows of a table of touches: those that matter most.
const MOST_ROWS: usize = 1000;

pub(super) fn residuals(subject: &Subject<'_>) -> Markup {
    let units = subject.units.name();
    let touches = &subject.record.touches;
    let in_sigmas = touches.iter().any(|touch| touch.normalized.is_some());
    let height = |touch: &ResidualRecord| if in_sigmas { touch.normalized } else { touch.residual };
    let bars = touches.iter().map(|touch| Bar {
        name: touch.index.to_string(),
        text: words::touch(touch, units),
        height: Some(height(touch).unwrap_or(0.0)),
        dot: None,
        hollow: touch.excluded,
    });
    let axis = if in_sigmas { "residual, sigmas".to_owned() } else { format!("residual, {units}") };
    let lines = if in_sigmas { vec![(2.0, "two sigmas"), (-2.0, "two sigmas")] } else { Vec::new() };
    let chart =
        Chart { title: "Residual of each touch", axis: &axis, bars: bars.collect(), lines, up_to: None };
    let shown = shown(touches);
    let body = html! {
        (chart.draw())
        p.note {
            "Signed distance of each touch from its surface, less the tip radius, along the outward normal"
            @if in_sigmas { ", in standard deviations of the touch; of sound touches one in twenty is beyond the lines." }
            @else { ". No sigma is stated, so that none of them is large or small by itself." }
        }
        @if shown.len() < touches.len() {
            p.missing { "The table has the " (MOST_ROWS) " touches of the largest residuals." }
        }
        (table_of_touches(&shown, units))
    };
    section("residuals", "Residuals", &body)
}

/// The touches of the table, in input order.
fn shown(touches: &[ResidualRecord]) -> Vec<&ResidualRecord> {
    let mut shown: Vec<&ResidualRecord> = touches.iter().collect();
    let size = |touch: &ResidualRecord| touch.residual.map_or(f64::INFINITY, f64::abs);
    shown.sort_by(|a, b| size(b).total_cmp(&size(a)));
    shown.truncate(MOST_ROWS);
    shown.sort_by_key(|touch| touch.index);
    shown
}

fn table_of_touches(touches: &[&ResidualRecord], units: &str) -> Markup {
    let any = |has: &dyn Fn(&ResidualRecord) -> bool| touches.iter().any(|touch| has(touch));
    let (ids, places) = (any(&|touch| touch.id.is_some()), any(&|touch| touch.at.is_some()));
    let (sigmas, notes) =
        (any(&|touch| touch.normalized.is_some()), any(&|touch| !words::note(touch).is_empty()));
    let largest = touches.iter().filter_map(|touch| touch.residual).fold(0.0, |a: f64, b| a.max(b.abs()));
    let digits = decimals(Some(largest), length_decimals(units));
    let mut header = columns(["touch"]);
    header.extend(ids.then(|| "id".to_owned()));
    header.push("surface".to_owned());
    header.extend(["x", "y", "z"].into_iter().filter(|_| places).map(|axis| format!(">{axis} ({units})")));
    header.push(format!(">residual ({units})"));
    header.extend(sigmas.then(|| ">in sigmas".to_owned()));
    header.extend(notes.then(String::new));
    let rows = touches.iter().map(|touch| {
        let mut row = vec![cell(touch.index.to_string())];
        row.extend(ids.then(|| name(touch.id.as_deref().unwrap_or_default())));
        row.push(name(&touch.surface));
        let at = touch
            .at
            .map_or(["-"; 3].map(str::to_owned), |at| at.map(|v| fixed(v, length_decimals(units) + 1)));
        row.extend(at.into_iter().filter(|_| places).map(cell));
        row.push(cell(touch.residual.map_or_else(|| "-".to_owned(), |v| fixed(v, digits))));
        row.extend(sigmas.then(|| cell(touch.normalized.map_or_else(|| "-".to_owned(), |v| fixed(v, 2)))));
        row.extend(notes.then(|| cell(words::note(touch))));
        row
    });
    table("Touches (tip centres) and their residuals", &header, &rows.collect::<Vec<_>>())
}

pub(super) fn influence(
    subject: &Subject<'_>,
    influences: &Result<Vec<Influence>, String>,
    points: &[Point3<f64>],
) -> Markup {
    let body = match influences {
        Err(reason) => html! {
            p.missing { "What each touch does to the frame is not told: " (reason) "." }
        },
        Ok(influences) => told(subject, influences, points),
    };
    section("influence", "What each touch does to the frame", &body)
}

fn told(subject: &Subject<'_>, influences: &[Influence], points: &[Point3<f64>]) -> Markup {
    let units = subject.units.name();
    let moved = |motion: &Option<Vector6<f64>>| {
        let motion = motion.as_ref()?;
        points.iter().map(|point| subject.moved(point, motion)).reduce(f64::max)
    };
    let with_sigma = influences.iter().any(|influence| influence.smallest_detectable.is_some());
    let touched = influences.iter().filter_map(|influence| match influence.of {
        Observed::Touch(index) => Some((index, influence)),
        Observed::Stated(_) => None,
    });
    let bar = |index: usize, text: String| Bar {
        name: index.to_string(),
        text,
        height: None,
        dot: None,
        hollow: false,
    };
    let checks = touched.clone().map(|(index, influence)| {
        let text = format!("touch {index}: the others see {} of its error", fixed(influence.redundancy, 3));
        Bar { height: Some(influence.redundancy), ..bar(index, text) }
    });
    let checks = Chart {
        title: "Part of the error of each touch that the others see",
        axis: "part seen",
        bars: checks.collect(),
        lines: Vec::new(),
        up_to: Some(1.0),
    };
    let effects = touched.map(|(index, influence)| {
        let (unnoticed, left_out) = (moved(&influence.unnoticed), moved(&influence.left_out));
        let unnoticed_told = unnoticed.map_or("any error".to_owned(), |v| {
            format!("an error that goes unnoticed: {} {units}", short(v))
        });
        let left_out_told = left_out.map_or("nothing else tells what it tells".to_owned(), |v| {
            format!("left out: {} {units}", short(v))
        });
        let text = if with_sigma {
            format!("touch {index}: {unnoticed_told}; {left_out_told}")
        } else {
            format!("touch {index}: {left_out_told}")
        };
        if with_sigma {
            Bar { height: unnoticed, dot: left_out, ..bar(index, text) }
        } else {
            Bar { height: left_out, ..bar(index, text) }
        }
    });
    let axis = format!("moves by, {units}");
    let effects = Chart {
        title: "How far the frame moves by each touch",
        axis: &axis,
        bars: effects.collect(),
        lines: Vec::new(),
        up_to: None,
    };
    let test = Test::default();
    let at = if points.len() == 1 {
        "at the point of use".to_owned()
    } else {
        format!("at the worst of {} points of use", points.len())
    };
    html! {
        h3 { "How far the others check it" }
        (checks.draw())
        p.note {
            "The part of a touch's error that its fellows see (redundancy); the rest goes into the frame. 0: nothing checks it."
        }
        h3 { "How far the frame moves" }
        (effects.draw())
        p.note {
            @if with_sigma {
                "Bars: how far an error of the smallest size that is noticed (" (short(100.0 * test.power)) " % of the time, at a false \
                 alarm rate of " (test.alpha) ") moves the frame " (at) " when it is not; open bars have no bound. Dots: how far the \
                 frame moves when the touch is left out."
            } @else {
                "How far the frame moves " (at) " when the touch is left out; open bars: nothing else tells what it tells. Which error \
                 would be noticed only a stated sigma could tell."
            }
        }
        @if influences.len() <= MOST_ROWS { (table_of_influences(subject, influences, &moved)) }
        @else { p.missing { "There are too many touches for a table." } }
    }
}

fn table_of_influences(
    subject: &Subject<'_>,
    influences: &[Influence],
    moved: &dyn Fn(&Option<Vector6<f64>>) -> Option<f64>,
) -> Markup {
    let units = subject.units.name();
    let header = [
        String::new(),
        ">part seen".to_owned(),
        ">test value".to_owned(),
        format!(">smallest noticed ({units})"),
        format!(">unnoticed, moves by ({units})"),
        format!(">left out, moves by ({units})"),
    ];
    let rows = influences.iter().map(|influence| {
        let told = match &influence.of {
            Observed::Touch(index) => {
                let surface = subject.record.touches.get(*index).map_or("", |touch| &touch.surface);
                format!("{index} on {surface}")
            }
            Observed::Stated(what) => what.clone(),
        };
        let of_moves = |motion| moved(motion).map_or("no bound".to_owned(), short);
        let known = subject.record.trust.sigma.is_some() || influence.test_value.is_some();
        vec![
            name(&told),
            cell(fixed(influence.redundancy, 3)),
            cell(influence.test_value.map_or("-".to_owned(), |v| fixed(v, 2))),
            cell(match influence.smallest_detectable {
                Some(smallest) => short(smallest),
                None if known => "none".to_owned(),
                None => "-".to_owned(),
            }),
            cell(if known { of_moves(&influence.unnoticed) } else { short_or_dash(None) }),
            cell(of_moves(&influence.left_out)),
        ]
    });
    table("What each touch, and each stated size, does to the frame", &header, &rows.collect::<Vec<_>>())
}
