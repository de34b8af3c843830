//! Calibrated parameters, for people.

use touchref::io::{CalibrationRecord, calibration::PlacementRecord, solution::AdjustmentRecord};

use super::{
    Look,
    number::{decimals, fixed, short, short_or_dash},
    sheet::{GOOD, Sheet},
    solution::{fixture, length_decimals, probe},
};

/// The parameters, what they rest on, and how each placement fits.
pub(crate) fn calibration(record: &CalibrationRecord, look: Look) -> String {
    let mut sheet = Sheet::new(look);
    let touches: usize = record.placements.iter().map(|placement| placement.touches.len()).sum();
    let fits = match (record.chi_square, record.p_value) {
        (Some(chi_square), Some(p)) => {
            format!(
                "chi-square {} with {} degrees of freedom, p = {}",
                short(chi_square),
                record.degrees_of_freedom,
                short(p)
            )
        }
        (Some(_), None) => "no more touches than unknowns, so that nothing checks the values".to_owned(),
        (None, _) => format!(
            "no sigma is stated; the residuals tell {} {} with {} degrees of freedom",
            short_or_dash(record.sigma),
            record.units,
            record.degrees_of_freedom
        ),
    };
    let counted = format!("{} placements, {touches} touches: {fits}.", record.placements.len());
    sheet.verdict(GOOD, "Calibrated.", &counted);
    parameters(&mut sheet, &record.parameters, &record.units);
    correlations(&mut sheet, record);
    sheet.heading("What it rests on");
    sheet.prose(&format!("fixture {}", fixture(&record.fixture, sheet.plus_minus())));
    sheet.prose(&probe(&record.probe, sheet.plus_minus(), &record.units));
    sheet.prose(&format!("residuals: rms {} {}", short_or_dash(record.rms), record.units));
    placements(&mut sheet, &record.placements, &record.units);
    sheet.finish()
}

fn parameters(sheet: &mut Sheet, parameters: &[AdjustmentRecord], units: &str) {
    sheet.heading(&format!("Parameters ({units}, degrees)"));
    let plus_minus = sheet.plus_minus();
    let header = ["", "nominal", plus_minus, "calibrated", plus_minus, "moved"].map(str::to_owned);
    let rows = parameters.iter().map(|parameter| {
        let digits = decimals(parameter.u, length_decimals(units));
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| fixed(v, digits));
        let moved = parameter.moved.map_or_else(|| "-".to_owned(), |moved| format!("{} u", fixed(moved, 2)));
        vec![
            parameter.name.clone(),
            number(parameter.nominal),
            parameter.nominal_u.map_or_else(|| "free".to_owned(), |u| fixed(u, digits)),
            number(parameter.value),
            number(parameter.u),
            moved,
        ]
    });
    sheet.table(&header, rows.collect(), &[1, 2, 3, 4, 5]);
}

fn correlations(sheet: &mut Sheet, record: &CalibrationRecord) {
    if record.parameters.len() < 2 {
        return;
    }
    sheet.heading("Correlations");
    let names = record.parameters.iter().map(|parameter| parameter.name.clone());
    let header: Vec<String> = std::iter::once(String::new()).chain(names.clone()).collect();
    let rows = names.zip(&record.correlations).enumerate().map(|(k, (name, row))| {
        // The upper half says the same.
        let values =
            row.iter().enumerate().map(|(j, value)| if j > k { String::new() } else { fixed(*value, 3) });
        std::iter::once(name).chain(values).collect()
    });
    let right: Vec<usize> = (1..header.len()).collect();
    sheet.table(&header, rows.collect(), &right);
}

fn placements(sheet: &mut Sheet, placements: &[PlacementRecord], units: &str) {
    sheet.heading("Placements");
    let plus_minus = sheet.plus_minus();
    let header =
        ["", "name", "touches", "chi-square", "worst residual", &format!("origin ({units})"), plus_minus];
    let header = header.map(str::to_owned);
    let named = placements.iter().any(|placement| placement.name.is_some());
    let shown = |mut row: Vec<String>| {
        if !named {
            row.remove(1);
        }
        row
    };
    let rows = placements.iter().map(|placement| {
        let largest = |of: fn(&touchref::io::solution::ResidualRecord) -> Option<f64>| {
            let values = placement.touches.iter().filter_map(of);
            values.max_by(|a, b| a.abs().total_cmp(&b.abs()))
        };
        let worst = match largest(|touch| touch.normalized) {
            Some(worst) => format!("{} sigma", fixed(worst, 2)),
            None => short_or_dash(largest(|touch| touch.residual)),
        };
        let deviations = [0, 1, 2].map(|k| placement.covariance.matrix[k][k].max(0.0).sqrt());
        let digits = decimals(deviations.into_iter().reduce(f64::min), length_decimals(units));
        shown(vec![
            placement.index.to_string(),
            placement.name.clone().unwrap_or_default(),
            placement.touches.len().to_string(),
            placement.chi_square.map_or_else(|| "-".to_owned(), |v| fixed(v, 1)),
            worst,
            placement.frame.origin.map(|v| fixed(v, digits)).join(" "),
            deviations.map(|u| fixed(u, digits)).join(" "),
        ])
    });
    let rows = rows.collect();
    let first_number = if named { 2 } else { 1 };
    sheet.table(&shown(header.to_vec()), rows, &[first_number, first_number + 1, first_number + 2]);
}
