//! One fitted surface, for people.

use super::{
    Look,
    number::{decimals, fixed, short},
    sheet::{GOOD, Sheet},
};
use crate::commands::element::ElementRecord;

/// Where the surface is, its sizes, and what they rest on.
pub(crate) fn element(record: &ElementRecord, look: Look) -> String {
    /// Digits after the point where no uncertainty says how many.
    const FEWEST: usize = 6;
    let mut sheet = Sheet::new(look);
    let rest = match record.second_rms {
        None => "The search saw no other minimum.".to_owned(),
        Some(second) => format!(
            "It fits best of {} distinct minima that the search saw; the next has a root mean square distance of {}.",
            record.minima,
            short(second)
        ),
    };
    sheet.verdict(GOOD, &format!("A {} through {} points.", record.element, record.points), &rest);
    sheet.heading("The surface");
    let deviations = |covariance: &Option<[[f64; 3]; 3]>| {
        covariance.map(|matrix| [0, 1, 2].map(|k: usize| matrix[k][k].max(0.0).sqrt()))
    };
    let mut rows = Vec::new();
    let mut vector = |name: &str, values: Option<[f64; 3]>, u: Option<[f64; 3]>| {
        let Some(values) = values else { return };
        for (k, axis) in ["x", "y", "z"].iter().enumerate() {
            let u = u.map(|u| u[k]);
            let digits = decimals(u, FEWEST);
            let told = u.map_or_else(|| "-".to_owned(), |u| fixed(u, digits));
            rows.push(vec![format!("{name} {axis}"), fixed(values[k], digits), told]);
        }
    };
    vector("point", Some(record.point), deviations(&record.point_covariance));
    vector("direction", record.direction, deviations(&record.direction_covariance));
    vector("apex", record.apex, None);
    let sizes = [
        ("radius", record.radius, record.radius_u),
        ("half-angle (deg)", record.half_angle_deg, record.half_angle_deg_u),
    ];
    for (name, value, u) in sizes {
        let Some(value) = value else { continue };
        let digits = decimals(u, FEWEST);
        let told = u.map_or_else(|| "-".to_owned(), |u| fixed(u, digits));
        rows.push(vec![name.to_owned(), fixed(value, digits), told]);
    }
    let header = [String::new(), "value".to_owned(), sheet.plus_minus().to_owned()];
    sheet.table(&header, rows, &[1, 2]);
    sheet.prose(&format!("root mean square distance {}", short(record.rms)));
    if record.point_covariance.is_none() {
        sheet.prose("no more points than unknowns: no uncertainty can be told");
    }
    sheet.finish()
}
