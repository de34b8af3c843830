//! Published examples computed anew, for people.

use super::{
    Look,
    number::{fixed, short, short_or_dash},
    sheet::{BAD, GOOD, Sheet},
};
use crate::commands::gauge::{ExampleRecord, FigureRecord, GaugeRecord};

/// Each figure by document and example, and what came of it.
pub(crate) fn gauge(record: &GaugeRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    verdict(&mut sheet, record);
    for documents in record.examples.chunk_by(|a, b| a.document == b.document) {
        sheet.heading(documents[0].document);
        for example in documents {
            sheet.prose(&format!("{}: {}", example.clause, example.title));
            figures(&mut sheet, example);
        }
    }
    sheet.heading("What it rests on");
    basis(&mut sheet, record);
    sheet.finish()
}

fn verdict(sheet: &mut Sheet, record: &GaugeRecord) {
    let all = record.pass + record.note + record.diff;
    let (style, verdict) = match record.diff {
        0 => (GOOD, "No figure differs.".to_owned()),
        1 => (BAD, "1 figure differs.".to_owned()),
        diff => (BAD, format!("{diff} figures differ.")),
    };
    let rest = format!(
        "Of {all} published figures {} pass, {} are off for a reason that is known, {} differ.",
        record.pass, record.note, record.diff
    );
    sheet.verdict(style, &verdict, &rest);
}

fn figures(sheet: &mut Sheet, example: &ExampleRecord) {
    let header = ["", "", "published", "computed", "off by", "tolerance", "of it scatter"].map(str::to_owned);
    let rows = example.figures.iter().map(|figure| {
        vec![
            figure.verdict.to_owned(),
            figure.quantity.clone(),
            published(figure),
            computed(figure),
            off_by(figure),
            short(figure.tolerance),
            short_or_dash(figure.scatter),
        ]
    });
    sheet.table(&header, rows.collect(), &[2, 3, 4, 5, 6]);
    for figure in &example.figures {
        if let Some(reason) = figure.reason {
            sheet.prose(&format!("{} {}: {reason}", figure.verdict, figure.quantity));
        }
    }
}

/// The difference; nothing where it is but rounding.
fn off_by(figure: &FigureRecord) -> String {
    /// Of half a unit of the last digit.
    const ROUNDING: f64 = 1e-6;
    if figure.difference.abs() < ROUNDING * figure.rounding {
        "0".to_owned()
    } else {
        short(figure.difference)
    }
}

/// As published; with a mark where the document itself was not at hand.
fn published(figure: &FigureRecord) -> String {
    let mark = if figure.origin == "printed" { "" } else { "*" };
    format!("{}{mark}", figure.published)
}

/// With two more digits than were published.
fn computed(figure: &FigureRecord) -> String {
    let mantissa = figure.published.split('e').next().unwrap_or_default();
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len()) + 2;
    if figure.published.contains('e') {
        format!("{:.decimals$e}", figure.computed)
    } else {
        fixed(figure.computed, decimals)
    }
}

fn basis(sheet: &mut Sheet, record: &GaugeRecord) {
    let trials = record.samples.map_or_else(
        || "as many trials as make two digits stable".to_owned(),
        |samples| format!("{samples} trials"),
    );
    sheet.prose(&format!("{trials} of each Monte Carlo calculation, seed {}", record.seed));
    sheet.prose(&format!(
        "tolerance: half a unit of the last digit published, and for a Monte Carlo result as much more as ours scatters, with \
         a chance of {:e} of being further off",
        record.chance
    ));
    sheet.prose(
        "* recomputed for the document's example, from closed forms or by other programs, not printed in it",
    );
    let together = |a: &ExampleRecord, b: &ExampleRecord| a.document == b.document && a.source == b.source;
    for examples in record.examples.chunk_by(together) {
        let clauses: Vec<&str> = examples.iter().map(|example| example.clause).collect();
        sheet.prose(&format!("{}, {}: {}", examples[0].document, clauses.join("; "), examples[0].source));
    }
}
