//! How sure a frame is where it is used, for people.

use super::{
    Look,
    number::{decimals, fixed, short},
    sheet::{BAD, GOOD, Sheet},
    solution::{fixture, length_decimals, probe},
};
use crate::commands::uncertainty::{MonteCarloRecord, QuantityRecord, UncertaintyRecord};

/// The uncertainty at each point of use, its sources, and what draws say of it.
pub(crate) fn uncertainty(record: &UncertaintyRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    verdict(&mut sheet, record);
    sheet.heading(&format!("Where the frame is used ({}, degrees)", record.units));
    places(&mut sheet, record);
    sheet.heading("Part of the variance along the worst direction, %");
    budget(&mut sheet, record);
    if let Some(drawn) = &record.monte_carlo {
        sheet.heading(&format!("By Monte Carlo, from the measured values ({}, degrees)", record.units));
        draws(&mut sheet, drawn);
    }
    sheet.heading("What it rests on");
    sheet.prose(&format!("fixture {}", fixture(&record.fixture, sheet.plus_minus())));
    sheet.prose(&probe(&record.probe, sheet.plus_minus(), record.units));
    if let Some(degrees) = record.degrees_of_freedom {
        sheet.prose(&format!(
            "sigma {} {} from the residuals, with {degrees} degrees of freedom",
            short(record.sigma),
            record.units
        ));
    }
    sheet.finish()
}

fn verdict(sheet: &mut Sheet, record: &UncertaintyRecord) {
    let worst = record.points.iter().max_by(|a, b| a.worst.u.total_cmp(&b.worst.u));
    let Some((point, at)) = worst.and_then(|point| Some((point, point.at?))) else { return };
    let plus_minus = sheet.plus_minus();
    let told = format!(
        "{plus_minus}{} {} at {}, along {}",
        short(point.worst.expanded),
        record.units,
        at.map(short).join(", "),
        point.worst.along
    );
    let (style, of_draws) = match &record.monte_carlo {
        None => (GOOD, ""),
        Some(drawn) if drawn.validated => (GOOD, " Monte Carlo agrees."),
        Some(_) => (BAD, " Monte Carlo does not agree: take its intervals."),
    };
    let rest = format!(
        "{told} ({} % coverage, k = {}).{of_draws}",
        short(100.0 * record.probability),
        fixed(record.coverage_factor, 2)
    );
    sheet.verdict(style, "Known to", &rest);
}

fn places(sheet: &mut Sheet, record: &UncertaintyRecord) {
    let plus_minus = sheet.plus_minus();
    let header = ["", "", "x", "y", "z", "worst", "along"].map(str::to_owned);
    let mut rows = Vec::new();
    let in_degrees = |radians: f64| radians.to_degrees();
    let mut add = |name: String, quantity: &QuantityRecord, unit: &dyn Fn(f64) -> f64, fewest: usize| {
        let numbers = |[x, y, z]: [f64; 3], worst: f64| [x, y, z, worst].map(unit);
        let least = numbers(quantity.u, quantity.worst.u).into_iter().filter(|u| *u > 0.0).reduce(f64::min);
        let digits = decimals(least, fewest);
        let told = |name: &str, kind: &str, numbers: [f64; 4], along: &str| {
            let numbers = numbers.map(|number| fixed(number, digits));
            [name.to_owned(), kind.to_owned()].into_iter().chain(numbers).chain([along.to_owned()]).collect()
        };
        rows.push(told(&name, "standard", numbers(quantity.u, quantity.worst.u), &quantity.worst.along));
        rows.push(told("", plus_minus, numbers(quantity.expanded, quantity.worst.expanded), ""));
    };
    for point in &record.points {
        add(at(point), point, &|length| length, length_decimals(record.units));
    }
    add("turn".to_owned(), &record.rotation, &in_degrees, 4);
    sheet.table(&header, rows, &[2, 3, 4, 5]);
}

fn at(point: &QuantityRecord) -> String {
    point.at.map_or_else(|| "turn".to_owned(), |at| format!("at {}", at.map(short).join(", ")))
}

fn budget(sheet: &mut Sheet, record: &UncertaintyRecord) {
    let all: Vec<&QuantityRecord> = record.points.iter().chain([&record.rotation]).collect();
    let header: Vec<String> = std::iter::once(String::new()).chain(all.iter().map(|of| at(of))).collect();
    let sources = record.rotation.budget.iter().enumerate();
    let rows = sources.map(|(index, of)| {
        let shares = all.iter().map(|quantity| fixed(100.0 * quantity.budget[index].share, 1));
        std::iter::once(of.source.clone()).chain(shares).collect()
    });
    let right: Vec<usize> = (1..header.len()).collect();
    sheet.table(&header, rows.collect(), &right);
}

fn draws(sheet: &mut Sheet, drawn: &MonteCarloRecord) {
    let header = ["", "mean", "standard", "low", "high", "first order", "agrees"].map(str::to_owned);
    let rows = drawn.quantities.iter().map(|of| {
        let unit = if of.name.starts_with('r') { 1.0_f64.to_degrees() } else { 1.0 };
        let digits = decimals(Some(of.u * unit), 3);
        let told = |value: f64| fixed(value * unit, digits);
        let agrees = if of.validated { "yes" } else { "no" };
        vec![
            of.name.clone(),
            told(of.mean),
            told(of.u),
            told(of.low),
            told(of.high),
            format!("{} {}", sheet.plus_minus(), told(of.first_order[1])),
            agrees.to_owned(),
        ]
    });
    let rows = rows.collect();
    sheet.table(&header, rows, &[1, 2, 3, 4, 5]);
    let stable = if drawn.stable { "stable" } else { "not stable yet" };
    let failed = match drawn.failed {
        0 => String::new(),
        failed => format!("; {failed} have no frame"),
    };
    sheet.prose(&format!(
        "{} draws, seed {}, {stable} to {} of the standard uncertainties{failed}",
        drawn.trials,
        drawn.seed,
        if drawn.digits == 1 { "one digit".to_owned() } else { format!("{} digits", drawn.digits) }
    ));
}
