//! What becomes of simulated measurements as touches get worse, and whether the covariance of accepted frames is true.

use touchref::{
    Parameters, Probe,
    analysis::{Study, StudyLayout, StudyOutcome},
};

use super::{
    chart::{Anchor, Field, Picture, Scale},
    fixture,
};

/// In millimetres, and told in micrometres.
const SIGMAS: [(f64, &str); 7] =
    [(0.001, "1"), (0.002, "2"), (0.005, "5"), (0.01, "10"), (0.02, "20"), (0.05, "50"), (0.1, "100")];
const TRIALS: u64 = 1000;
const SEED: u64 = 20_261_123;
/// From below: what came of a measurement.
const FATES: [(&str, &str); 5] = [
    ("accepted", "f0"),
    ("ambiguous", "f1"),
    ("not-validated", "f3"),
    ("degenerate", "f5"),
    ("inconsistent", "f4"),
];

pub(super) fn drawn() -> String {
    let title = "Shares of simulated measurements that are accepted and refused over sigma, and the mean squared error \
                 of accepted frames in their own covariance";
    let mut picture = Picture::new(title, 640.0);
    let names = ["random, 4 + 3 touches", "random, 5 + 4 touches"];
    for (column, (name, counts)) in names.into_iter().zip([[4, 3], [5, 4]]).enumerate() {
        let left = 70.0 + 350.0 * column as f64;
        let x = Scale::Linear { from: -0.6, to: 6.6 };
        let y = Scale::Linear { from: 0.0, to: 100.0 };
        let shares = Field { left, right: left + 310.0, top: 84.0, bottom: 330.0, x, y };
        picture.text([left, 52.0], "title", Anchor::Start, name);
        let marks: Vec<(f64, &str)> =
            SIGMAS.iter().enumerate().map(|(k, (_, name))| (k as f64, *name)).collect();
        let percent = [(0.0, "0"), (25.0, "25"), (50.0, "50"), (75.0, "75"), (100.0, "100")];
        shares.draw(&mut picture, &marks, &percent, ["sigma of a touch, µm", "% of 1000 measurements"]);
        let y = Scale::Linear { from: 5.0, to: 7.0 };
        let errors = Field { top: 420.0, bottom: 580.0, y, ..shares };
        let marks_of_errors = [(5.0, "5"), (5.5, "5.5"), (6.0, "6"), (6.5, "6.5"), (7.0, "7")];
        let words = "squared error in the stated covariance";
        errors.draw(&mut picture, &marks, &marks_of_errors, ["sigma of a touch, µm", words]);
        errors.level(&mut picture, 6.0);
        for (k, (sigma, _)) in SIGMAS.into_iter().enumerate() {
            let outcome = study(&counts, sigma);
            let mut below = 0.0;
            for (fate, class) in FATES {
                let count = if fate == "accepted" {
                    outcome.accepted
                } else {
                    *outcome.refused.get(fate).unwrap_or(&0)
                };
                let share = 100.0 * count as f64 / TRIALS as f64;
                let (from, to) =
                    (shares.at(k as f64 - 0.36, below + share), shares.at(k as f64 + 0.36, below));
                picture.rectangle(class, from, to);
                below += share;
            }
            assert_eq!(outcome.wrong, 0, "the caption says that no frame was wrong");
            let mean = outcome.nees_mean().unwrap();
            let ends = [-2.0, 2.0].map(|u| errors.at(k as f64, (mean.value + u * mean.u).clamp(5.0, 7.0)));
            picture.line("s0", 2.0, &ends);
            picture.dot("f0", errors.at(k as f64, mean.value), 4.5);
        }
    }
    let mut left = 70.0;
    for (fate, class) in FATES {
        picture.rectangle(class, [left, 16.0], [left + 13.0, 29.0]);
        picture.text([left + 19.0, 28.0], "", Anchor::Start, fate);
        left += 42.0 + 7.6 * fate.len() as f64;
    }
    picture.finish()
}

fn study(counts: &[usize], sigma: f64) -> StudyOutcome {
    let parameters = Parameters::new().with("radius", 20.0).with("angle_deg", 45.0);
    let fixture = fixture("cylinder-plane", &parameters);
    let registry = touchref::registry().unwrap();
    let solver = registry.solver("least-squares").unwrap().build(&Parameters::new()).unwrap();
    let study = Study {
        fixture: &*fixture,
        plugin: registry.fixture("cylinder-plane").unwrap(),
        solver: &*solver,
        layout: StudyLayout::Random(counts.to_vec()),
        probe: Probe { sigma: Some(sigma), ..Probe::default() },
        reach: 1000.0,
        seed: SEED,
        trials: TRIALS,
    };
    study.run().unwrap()
}
