//! The closed form allocates nothing: it may run in a control loop.

#![allow(clippy::unwrap_used)] // A test may panic.

mod support;

use allocation_counter::measure;
use rand::RngExt;
use touchref::{
    Fixture, Probe, Problem, Root, Touch,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
};

const MEASUREMENTS: u64 = 1000;
const SEED: u64 = 41;

fn measurements(fixture: &dyn Fixture, probe: &Probe) -> Vec<Vec<Touch>> {
    (0..MEASUREMENTS)
        .map(|trial| {
            let mut rng = generator(SEED, trial);
            let layout = random_layout(fixture, &[4, 3], &mut rng);
            let frame = random_frame(1000.0, &mut rng);
            let sigma = rng.random_range(0.0..0.05);
            simulate(fixture, &layout, &frame, probe, sigma, &mut rng)
        })
        .collect()
}

/// Cold, the first call of the process, as warm: nothing is set up once and kept.
#[test]
fn roots_of_four_and_three_touches_allocate_nothing() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let probe = Probe { tip_radius: 1.5, sigma: Some(0.01), ..Probe::default() };
    let measurements = measurements(&*fixture, &probe);
    let problems: Vec<Problem<'_>> =
        measurements.iter().map(|touches| Problem::new(&*fixture, touches, probe).unwrap()).collect();
    let closed_form = fixture.closed_form().unwrap();
    let mut found = 0;
    let mut count = |_: Root| found += 1;

    let cold = measure(|| closed_form.roots(&problems[0], &mut count).unwrap());
    assert_eq!((cold.count_total, cold.bytes_total), (0, 0), "the first call");
    for (trial, problem) in problems.iter().enumerate() {
        let warm = measure(|| closed_form.roots(problem, &mut count).unwrap());
        assert_eq!((warm.count_total, warm.bytes_total), (0, 0), "measurement {trial}");
    }
    assert!(found > 2 * problems.len(), "two roots at least, as a rule, but {found} in all");
}

/// The counter counts: the same calls into a list that grows.
#[test]
fn roots_kept_in_a_list_are_counted() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let probe = Probe::default();
    let measurements = measurements(&*fixture, &probe);
    let problem = Problem::new(&*fixture, &measurements[0], probe).unwrap();
    let closed_form = fixture.closed_form().unwrap();
    let mut kept = Vec::new();
    let counted = measure(|| closed_form.roots(&problem, &mut |root| kept.push(root)).unwrap());
    assert!(counted.count_total > 0 && !kept.is_empty());
}
