//! Labels: a wrong one is told, never applied; missing ones are found where only one labelling fits.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use std::collections::BTreeMap;

use rand::seq::SliceRandom;
use touchref::{
    Fixture, Probe, Problem, SolveError, Touch,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
    solvers::labelling::{Tip, label, labellings},
};

const SIGMA: f64 = 0.01;
const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };

fn fixture(kind: &str) -> Box<dyn Fixture> {
    support::fixture(kind, &support::settings(kind)[0])
}

/// Sound touches at random places, in any order.
fn touches(fixture: &dyn Fixture, counts: &[usize], trial: u64) -> Vec<Touch> {
    let mut rng = generator(11, trial);
    let mut layout = random_layout(fixture, counts, &mut rng);
    layout.shuffle(&mut rng);
    let truth = random_frame(1000.0, &mut rng);
    simulate(fixture, &layout, &truth, &PROBE, SIGMA, &mut rng)
}

fn unlabelled(touch: &Touch) -> Tip {
    Tip { surface: None, at: touch.at, noise: touch.noise, approach: touch.approach }
}

fn labels(touches: &[Touch]) -> Vec<usize> {
    touches.iter().map(|touch| touch.surface).collect()
}

/// What `robust` says of touches, in a refusal's help or in the warnings of a frame; and which it left out.
fn told(fixture: &dyn Fixture, touches: &[Touch]) -> (String, Vec<usize>) {
    match support::solver("robust").solve(&Problem::new(fixture, touches, PROBE).unwrap()) {
        Ok(solution) => {
            let warnings: Vec<&str> =
                solution.warnings.iter().map(|warning| warning.message.as_str()).collect();
            (warnings.join("\n"), solution.excluded)
        }
        Err(refusal) => (refusal.help().to_owned(), Vec::new()),
    }
}

#[test]
fn one_wrong_label_is_told() {
    let fixture = fixture("cylinder-plane");
    let (mut named, mut right) = (0, 0);
    for trial in 0..200 {
        let mut touches = touches(&*fixture, &[6, 5], trial);
        let wrong = touches.iter().position(|touch| touch.surface == usize::from(trial % 2 == 0)).unwrap();
        touches[wrong].surface = 1 - touches[wrong].surface;
        let [is, not] =
            if touches[wrong].surface == 0 { ["plane", "cylinder"] } else { ["cylinder", "plane"] };
        let (told, excluded) = told(&*fixture, &touches);
        assert!(excluded.is_empty() || excluded == [wrong], "trial {trial}: {excluded:?}, not {wrong}");
        named += u32::from(!excluded.is_empty());
        right += u32::from(told.contains(&format!("touch {wrong} fits as `{is}`, not `{not}`")));
    }
    println!("of 200 wrong labels {right} are told, {named} of these with a frame without the touch");
    assert!(right >= 190, "{right}");
}

#[test]
fn exchanged_labels_are_told() {
    for (kind, counts, other) in [("cylinder-plane", &[5, 4][..], 1), ("cube", &[3, 0, 3, 0, 3, 0], 2)] {
        let fixture = fixture(kind);
        let [one, two] = [0, other].map(|surface| &fixture.surfaces()[surface].name);
        let (mut right, mut otherwise) = (0, BTreeMap::new());
        for trial in 0..100 {
            let mut touches = touches(&*fixture, counts, trial);
            for touch in &mut touches {
                touch.surface = match touch.surface {
                    0 => other,
                    surface if surface == other => 0,
                    surface => surface,
                };
            }
            let problem = Problem::new(&*fixture, &touches, PROBE).unwrap();
            let refusal = support::solver("robust").solve(&problem).unwrap_err();
            let told = format!("when the labels `{one}` and `{two}` are exchanged");
            if refusal.help().contains(&told) {
                right += 1;
            } else {
                *otherwise.entry(refusal.code()).or_insert(0) += 1;
            }
        }
        println!("{kind}: of 100 exchanges {right} told, else {otherwise:?}");
        assert!(right >= 98, "{otherwise:?}");
    }
}

/// Touches without any label: the right ones, or a refusal; never others.
#[test]
fn missing_labels_are_found_or_refused() {
    for (kind, counts, least) in [
        ("cylinder-plane", &[4, 3][..], 40),
        ("cylinder-plane", &[5, 4], 85),
        ("three-sphere", &[3, 3, 3], 95),
    ] {
        let fixture = fixture(kind);
        let (mut found, mut several) = (0, 0);
        for trial in 0..100 {
            let touches = touches(&*fixture, counts, trial);
            let tips: Vec<Tip> = touches.iter().map(unlabelled).collect();
            match label(&*fixture, &tips, PROBE) {
                Ok(found_labels) => {
                    assert_eq!(found_labels, labels(&touches), "{kind}, trial {trial}");
                    found += 1;
                }
                Err(SolveError::Ambiguous(refusal)) => {
                    assert!(refusal.message.contains("labellings fit"), "{}", refusal.message);
                    several += 1;
                }
                Err(other) => panic!("{kind}, trial {trial}: {other}"),
            }
        }
        println!("{kind} {counts:?}: of 100 without labels {found} found, {several} refused as several");
        assert!(found >= least, "{kind}: {found}");
    }
}

/// Every labelling that fits is listed, the right one among them; which one is first does not depend on the order.
#[test]
fn the_order_of_touches_does_not_matter() {
    let fixture = fixture("cylinder-plane");
    for trial in 0..20 {
        let touches = touches(&*fixture, &[4, 3], trial);
        let mut order: Vec<usize> = (0..touches.len()).collect();
        order.shuffle(&mut generator(12, trial));
        let of = |order: &[usize]| {
            let tips: Vec<Tip> = order.iter().map(|index| unlabelled(&touches[*index])).collect();
            let mut all: Vec<Vec<usize>> = labellings(&*fixture, &tips, PROBE)
                .unwrap()
                .into_iter()
                .map(|found| {
                    (0..order.len())
                        .map(|index| found[order.iter().position(|o| *o == index).unwrap()])
                        .collect()
                })
                .collect();
            all.sort();
            all
        };
        let straight = of(&[0, 1, 2, 3, 4, 5, 6]);
        assert!(straight.contains(&labels(&touches)), "trial {trial}");
        // Of many only the first few are told, and these depend on the order.
        if straight.len() < 8 {
            assert_eq!(straight, of(&order), "trial {trial}");
        }
    }
}

/// A cube looks the same from many sides, unless labels say from which.
#[test]
fn a_cube_without_labels_is_refused() {
    let fixture = fixture("cube");
    let touches = touches(&*fixture, &[3, 0, 3, 0, 3, 0], 1);
    let tips: Vec<Tip> = touches.iter().map(unlabelled).collect();
    let refusal = label(&*fixture, &tips, PROBE).unwrap_err();
    assert!(["ambiguous", "invalid-input"].contains(&refusal.code()), "{refusal}");
    assert!(refusal.help().contains("label some of"), "{}", refusal.help());

    // Two faces labelled leave the third no choice.
    let tips: Vec<Tip> = touches
        .iter()
        .map(|touch| Tip {
            surface: Some(touch.surface).filter(|surface| *surface != 4),
            ..unlabelled(touch)
        })
        .collect();
    assert_eq!(label(&*fixture, &tips, PROBE).unwrap(), labels(&touches));
}

#[test]
fn labels_that_do_not_fit_are_none() {
    let fixture = fixture("cylinder-plane");
    let mut touches = touches(&*fixture, &[5, 4], 3);
    for (k, touch) in touches.iter_mut().enumerate() {
        touch.at.x += 5.0 * (k as f64 * 1.7).sin();
    }
    let tips: Vec<Tip> = touches.iter().map(unlabelled).collect();
    let refusal = label(&*fixture, &tips, PROBE).unwrap_err();
    assert_eq!(refusal.code(), "inconsistent");
    assert_eq!(refusal.refusal().unwrap().touches.len(), 9);

    let silent = Probe { sigma: None, ..PROBE };
    assert_eq!(label(&*fixture, &tips, silent).unwrap_err().code(), "unsupported");
    let problem = Problem::new(&*fixture, &touches, silent).unwrap();
    let refusal = support::solver("robust").solve(&problem).unwrap_err();
    assert!(
        refusal.code() == "unsupported" && refusal.to_string().contains("no sigma is stated"),
        "{refusal}"
    );
}
