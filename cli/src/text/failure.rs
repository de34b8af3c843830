//! Failures for people: what is wrong, where, and what to do.

use std::fmt;

use miette::{Diagnostic, MietteHandler, MietteHandlerOpts, ReportHandler};
use touchref::{
    SolveError,
    io::refusal::{ConcernedPlacement, ErrorDetails, Findings},
    locate::Refused,
};

use super::{
    Look,
    sheet::{BAD, Sheet},
    solution::{condition, roots},
};
use crate::failure::{Failure, Uncalibrated};

/// A failure, for standard error.
pub(crate) fn failure(failure: &Failure, look: Look) -> String {
    match failure {
        Failure::Input(error) => diagnostic(error, look),
        Failure::Refused(refused) => refusal(refused, &failure.record().error, look),
        Failure::Uncalibrated(refused) => uncalibrated(refused, &failure.record().error, look),
        Failure::Undetermined(_) => helped("No surface to trust:", &failure.record().error, look),
        Failure::Unplanned(_) => helped("No plan:", &failure.record().error, look),
        Failure::Untold(_) => helped("A frame was found, but not told:", &failure.record().error, look),
        Failure::Call(error) => error.render().ansi().to_string(),
    }
}

/// A diagnostic that points into the text it is about.
fn diagnostic(error: &dyn Diagnostic, look: Look) -> String {
    /// Hands a diagnostic to a handler of our choice; miette's own `Report` has one for the whole process.
    struct Shown<'a>(&'a dyn Diagnostic, MietteHandler);
    impl fmt::Display for Shown<'_> {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            self.1.debug(self.0, f)
        }
    }
    let handler = MietteHandlerOpts::new()
        .force_graphical(true)
        // Where colours are not wanted they are taken out on the way to the stream.
        .color(look.terminal)
        .unicode(look.unicode)
        .terminal_links(false)
        .width(look.width)
        .build();
    let text = Shown(error, handler).to_string();
    text.trim_start_matches('\n').trim_end().to_owned() + "\n"
}

fn refusal(refused: &Refused, details: &ErrorDetails, look: Look) -> String {
    let units = refused.units.name();
    let mut sheet = Sheet::new(look);
    let verdict = if refused.error.is_input_error() { "No frame:" } else { "No frame to trust:" };
    sheet.verdict(BAD, verdict, &details.message);
    let findings = &details.findings;
    touches(&mut sheet, findings, &refused.file);
    if let SolveError::Degenerate(degenerate) = &refused.error {
        sheet.prose(&format!("the touches determine {} of {} motions", degenerate.rank, degenerate.unknowns));
    }
    if !details.help.is_empty() {
        sheet.heading("What to do");
        sheet.prose(&details.help);
    }
    found(&mut sheet, findings, units);
    sheet.finish()
}

/// What is wrong, and what to do about it.
fn helped(verdict: &str, details: &ErrorDetails, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    sheet.verdict(BAD, verdict, &details.message);
    sheet.heading("What to do");
    sheet.prose(&details.help);
    sheet.finish()
}

fn uncalibrated(refused: &Uncalibrated, details: &ErrorDetails, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    let verdict = if refused.error.is_input_error() { "No calibration:" } else { "No calibration to trust:" };
    sheet.verdict(BAD, verdict, &details.message);
    if let Some(ConcernedPlacement { index, name }) = &details.findings.placement {
        if let Some(name) = name {
            sheet.prose(&format!("placement {index} is `{name}`"));
        }
        touches(&mut sheet, &details.findings, &refused.placements[*index].touches.file);
    }
    sheet.heading("What to do");
    sheet.prose(&details.help);
    sheet.finish()
}

/// The touches that a refusal is about.
fn touches(sheet: &mut Sheet, findings: &Findings, file: &str) {
    for touch in &findings.touches {
        let id = touch.id.as_ref().map_or(String::new(), |id| format!(" `{id}`"));
        let line = touch.line.map_or(String::new(), |line| format!(", {file} line {line}"));
        sheet.prose(&format!("touch {}{id} on {}{line}", touch.index, touch.surface));
    }
}

fn found(sheet: &mut Sheet, findings: &Findings, units: &str) {
    if let Some(all) = findings.roots.as_deref().filter(|all| !all.is_empty()) {
        sheet.heading("Frames that were weighed");
        roots(sheet, all, units);
    }
    // A margin that is empty, or that does not exist, tells nothing.
    if let Some(trust) = &findings.trust
        && let (Some(from), Some(to)) = (trust.from_sigma, trust.up_to_sigma)
        && from < to
    {
        sheet.heading("When the best of them would stand");
        sheet.prose(&condition(trust, units));
    }
    if let Some(observability) = &findings.observability {
        sheet.gap();
        sheet.prose(&format!("weakest at the best of them is a {}", observability.weakest));
    }
}
