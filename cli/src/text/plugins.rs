//! Fixtures, solvers, dialects and formats of logs for people.

use super::{Look, sheet::Sheet, solution::note_of_dialect};
use crate::commands::{
    describe::{Description, Kind, ParameterDescription},
    list::{Item, Listing},
    schema::Entry,
};

/// What there is by name.
pub(crate) fn listing(listing: &Listing, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    let sections = [
        ("Fixtures", &listing.fixtures),
        ("Solvers", &listing.solvers),
        ("Dialects", &listing.dialects),
        ("Logs", &listing.logs),
    ];
    for (heading, items) in sections {
        if let Some(items) = items {
            sheet.heading(heading);
            names(&mut sheet, items);
        }
    }
    sheet.finish()
}

fn names(sheet: &mut Sheet, items: &[Item]) {
    if items.is_empty() {
        sheet.prose("none yet");
        return;
    }
    let rows = items.iter().map(|item| vec![item.name.to_owned(), item.summary.to_owned()]);
    sheet.table(&[], rows.collect(), &[]);
}

/// The schemas that can be printed.
pub(crate) fn schemas(entries: &[Entry], look: Look) -> String {
    let mut sheet = Sheet::new(look);
    sheet.heading("Schemas");
    let rows = entries.iter().map(|entry| vec![entry.name.to_owned(), entry.summary.to_owned()]);
    sheet.table(&[], rows.collect(), &[]);
    sheet.finish()
}

/// All that a fixture, a solver, a dialect or a format of logs says of itself.
pub(crate) fn description(description: &Description, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    sheet.heading(&format!("{} {}", description.kind, description.name));
    sheet.prose(description.summary);
    if let Kind::Solver { about } | Kind::Log { about, .. } = &description.of {
        sheet.gap();
        sheet.prose(about);
    }
    if let Kind::Dialect { call, note, example } = &description.of {
        sheet.gap();
        sheet.prose(&format!("--dialect {call}"));
        note_of_dialect(&mut sheet, note);
        sheet.heading("30 degrees about Z, at 100, 200, 300 mm");
        sheet.exact(example);
    }
    if !matches!(description.of, Kind::Log { .. }) {
        sheet.heading("Parameters");
        parameters(&mut sheet, &description.parameters);
    }
    if let Kind::Fixture { surfaces, touches, frame, drawing, .. } = &description.of {
        sheet.heading("Surfaces");
        if surfaces.is_empty() {
            sheet.prose("those that the measurement states");
        }
        let rows = surfaces.iter().map(|surface| vec![surface.name.to_owned(), surface.meaning.to_owned()]);
        sheet.table(&[], rows.collect(), &[]);
        sheet.heading("Touches");
        sheet.prose(touches);
        sheet.heading("Frame");
        sheet.prose(frame);
        sheet.gap();
        sheet.verbatim(drawing);
    }
    sheet.heading("Reference");
    sheet.prose(description.reference);
    if let Kind::Fixture { example, .. } | Kind::Log { example, .. } = &description.of {
        sheet.heading(match description.of {
            Kind::Log { .. } => "In a measurement file",
            _ => "A measurement file",
        });
        sheet.verbatim(example);
    }
    sheet.finish()
}

fn parameters(sheet: &mut Sheet, parameters: &[ParameterDescription]) {
    if parameters.is_empty() {
        sheet.prose("none");
        return;
    }
    let header = ["name", "takes", "default", "meaning"].map(str::to_owned);
    let rows = parameters.iter().map(|parameter| {
        let default = parameter.default.unwrap_or("(must be given)");
        vec![
            parameter.name.to_owned(),
            parameter.takes.clone(),
            default.to_owned(),
            parameter.meaning.to_owned(),
        ]
    });
    sheet.table(&header, rows.collect(), &[]);
    for parameter in parameters {
        for table in &parameter.tables {
            sheet.heading(&format!("{}, type = \"{}\"", parameter.name, table.name));
            self::parameters(sheet, &table.parameters);
        }
    }
}
