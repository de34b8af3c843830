//! How often a frame would be right, refused or wrong, for people.

use touchref::analysis::Share;

use super::{
    Look,
    number::{decimals, fixed, short},
    sheet::{BAD, GOOD, Sheet},
    solution::{fixture, probe},
};
use crate::commands::study::StudyRecord;

/// What came of the measurements, and how true the frames handed out are.
pub(crate) fn study(record: &StudyRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    verdict(&mut sheet, record);
    sheet.heading("What came of the measurements");
    counts(&mut sheet, record);
    if record.accepted > 0 {
        sheet.heading("How true the frames handed out are");
        frames(&mut sheet, record);
        sheet.prose(
            "The bound is the least error that the touches allow where dimensions and tip radius are known.",
        );
    }
    sheet.heading("What it rests on");
    basis(&mut sheet, record);
    sheet.finish()
}

fn verdict(sheet: &mut Sheet, record: &StudyRecord) {
    let Some(at_most) = record.wrong_rate_at_most else {
        sheet.verdict(BAD, "No frame was handed out:", "every measurement was refused.");
        return;
    };
    let (style, verdict) = match record.wrong {
        0 => (GOOD, "No frame was wrong.".to_owned()),
        1 => (BAD, "1 frame was wrong.".to_owned()),
        wrong => (BAD, format!("{wrong} frames were wrong.")),
    };
    let rest = format!(
        "{} of {} simulated measurements gave a frame; with 95 % confidence fewer than {} % of such frames are wrong: \
         outside their own stated covariance at the 1e-9 level.",
        record.accepted,
        record.trials,
        short(100.0 * at_most)
    );
    sheet.verdict(style, &verdict, &rest);
}

fn counts(sheet: &mut Sheet, record: &StudyRecord) {
    let header = ["", "count", "%", "95 % interval"].map(str::to_owned);
    let accepted = ("accepted".to_owned(), record.accepted);
    let refused = record.refused.iter().map(|(code, count)| (format!("refused as {code}"), *count));
    let rows = std::iter::once(accepted).chain(refused).map(|(name, count)| {
        let mut row = vec![name, count.to_string()];
        if let Some(Share { value, low, high }) = Share::of(count, record.trials) {
            let percent = |part: f64| fixed(100.0 * part, decimals(Some(50.0 * (high - low)), 1));
            row.extend([percent(value), format!("{} to {}", percent(low), percent(high))]);
        }
        row
    });
    sheet.table(&header, rows.collect(), &[1, 2, 3]);
}

fn frames(sheet: &mut Sheet, record: &StudyRecord) {
    let plus_minus = sheet.plus_minus().to_owned();
    let header = [String::new(), "measured".to_owned(), plus_minus, "expected".to_owned()];
    let percent = |part: Option<f64>| part.map(|part| 100.0 * part);
    let (bound, bound_u) = (&record.rms_over_bound, &record.rms_over_bound_u);
    let unknowns = record.unknowns.to_string();
    let rows = [
        (
            "mean squared error in their own covariance (NEES)",
            record.nees_mean,
            record.nees_mean_u,
            unknowns.as_str(),
        ),
        ("within their own 95 % region, %", percent(record.coverage_95), percent(record.coverage_95_u), "95"),
        ("rms error of the origin over the bound", bound.translation, bound_u.translation, "1 at best"),
        ("rms error of the rotation over the bound", bound.rotation, bound_u.rotation, "1 at best"),
    ];
    let rows = rows.map(|(name, value, u, expected)| {
        let digits = decimals(u, 1);
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| fixed(value, digits));
        vec![name.to_owned(), number(value), number(u), expected.to_owned()]
    });
    sheet.table(&header, rows.into(), &[1, 2, 3]);
}

fn basis(sheet: &mut Sheet, record: &StudyRecord) {
    let touches = record.touches_per_surface.iter().map(|(surface, count)| format!("{count} on {surface}"));
    sheet.prose(&format!(
        "trials {}, seed {}, solver {}, layout {}: {}",
        record.trials,
        record.seed,
        record.solver,
        record.layout,
        touches.collect::<Vec<_>>().join(", ")
    ));
    sheet.prose(&format!("fixture {}", fixture(&record.fixture, sheet.plus_minus())));
    sheet.prose(&probe(&record.probe, sheet.plus_minus(), record.units));
    if record.probe.sigma.is_none() {
        let sigma = short(record.sigma);
        sheet
            .prose(&format!("the touches state their own sigmas: {sigma} {} root mean square", record.units));
    }
    sheet
        .prose("each trial draws anew: the frame, the noise of the touches, and what is stated as uncertain");
}
