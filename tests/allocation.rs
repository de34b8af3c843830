//! What the hot paths allocate: the closed forms and the plain descent nothing, so that they may run in a control loop; a whole
//! locate what its report holds.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use std::hint::black_box;

use allocation_counter::{AllocationInfo, measure};
use rand::RngExt;
use touchref::{
    Fixture, Frame, Parameters, Probe, Problem, Root, Touch,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
    solvers::refinement::{descend, refine},
};

const MEASUREMENTS: u64 = 1000;
const SEED: u64 = 41;
const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(0.01) };

/// A fixture, and how many touches a surface gets: the fewest.
struct Case {
    name: &'static str,
    fixture: Box<dyn Fixture>,
    counts: &'static [usize],
}

/// Every fixture of one size.
fn cases() -> [Case; 4] {
    let case = |name, fixture, counts| Case { name, fixture, counts };
    let sides = Parameters::new().with("radius", 20.0).with("ab", 100.0).with("bc", 90.0).with("ca", 80.0);
    let edge = Parameters::new().with("edge", 40.0);
    [
        case("cylinder-plane", support::cylinder_plane(20.0, 45.0), &[4, 3]),
        case("three-sphere", support::fixture("three-sphere", &sides), &[3, 3, 3]),
        case("cube", support::fixture("cube", &edge), &[3, 0, 2, 0, 1]),
        case("composite", support::fixture("composite", &support::v_block()), &[3, 3, 2]),
    ]
}

/// Touches of a fixture at random places, and where it stands.
fn measurements(fixture: &dyn Fixture, counts: &[usize], probe: &Probe) -> Vec<(Vec<Touch>, Frame)> {
    (0..MEASUREMENTS)
        .map(|trial| {
            let mut rng = generator(SEED, trial);
            let layout = random_layout(fixture, counts, &mut rng);
            let frame = random_frame(1000.0, &mut rng);
            let sigma = rng.random_range(0.0..0.05);
            (simulate(fixture, &layout, &frame, probe, sigma, &mut rng), frame)
        })
        .collect()
}

fn problems<'a>(
    fixture: &'a dyn Fixture,
    measurements: &'a [(Vec<Touch>, Frame)],
) -> Vec<(Problem<'a>, Frame)> {
    let problem =
        |(touches, frame): &'a (Vec<Touch>, Frame)| (Problem::new(fixture, touches, PROBE).unwrap(), *frame);
    measurements.iter().map(problem).collect()
}

fn assert_nothing(counted: &AllocationInfo, what: &str) {
    assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{what}");
}

/// Cold, the first call of the process, as warm: nothing is set up once and kept.
#[test]
fn roots_of_the_fewest_touches_allocate_nothing() {
    for Case { name, fixture, counts } in cases() {
        let Some(closed_form) = fixture.closed_form() else { continue };
        let measurements = measurements(&*fixture, counts, &PROBE);
        let mut found = 0;
        let mut count = |_: Root| found += 1;
        for (trial, (problem, _)) in problems(&*fixture, &measurements).iter().enumerate() {
            let mut outcome = Ok(());
            let counted = measure(|| outcome = closed_form.roots(problem, &mut count));
            if outcome.is_ok() {
                assert_nothing(&counted, &format!("{name}, measurement {trial}"));
            }
        }
        println!("{name}: {found} roots of {MEASUREMENTS} measurements");
        assert!(found > MEASUREMENTS, "{name}: {found} roots");
    }
}

/// The steps alone, from the true frame.
#[test]
fn a_descent_allocates_nothing_and_a_refinement_its_history() {
    /// A list that doubles from four to a hundred steps.
    const HISTORY: u64 = 6;
    for Case { name, fixture, counts } in cases() {
        let measurements = measurements(&*fixture, counts, &PROBE);
        for (trial, (problem, frame)) in problems(&*fixture, &measurements).iter().enumerate() {
            let counted = measure(|| _ = black_box(descend(problem, frame)));
            assert_nothing(&counted, &format!("{name}, measurement {trial}"));
            let counted = measure(|| _ = black_box(refine(problem, frame)));
            assert!(counted.count_total <= HISTORY, "{name}, measurement {trial}: {counted:?}");
        }
    }
}

/// What a solver allocates for a frame is its report, and the starts and minima of its search: so many at the most.
#[test]
fn a_locate_allocates_what_it_reports() {
    const MOST: [(&str, &str, u64); 7] = [
        ("cylinder-plane", "closed-form", 41),
        ("cylinder-plane", "least-squares", 21),
        ("three-sphere", "closed-form", 50),
        ("three-sphere", "least-squares", 21),
        ("cube", "closed-form", 20),
        ("cube", "least-squares", 17),
        ("composite", "least-squares", 96),
    ];
    /// A search everywhere takes long.
    const EVERYWHERE: usize = 20;
    for Case { name, fixture, counts } in cases() {
        let measurements = measurements(&*fixture, counts, &PROBE);
        let mut problems = problems(&*fixture, &measurements);
        problems.truncate(if fixture.closed_form().is_some() { problems.len() } else { EVERYWHERE });
        for (_, solver, most) in MOST.into_iter().filter(|(kind, ..)| *kind == name) {
            let solver = support::solver(solver);
            let (mut located, mut counted) = (0, Vec::new());
            for (problem, _) in &problems {
                let mut accepted = false;
                let of = measure(|| accepted = black_box(solver.solve(problem)).is_ok());
                located += usize::from(accepted);
                counted.extend(accepted.then_some(of.count_total));
            }
            counted.sort_unstable();
            let told =
                format!("{name}, {}: {:?} of {located}", solver.name(), counted.first().zip(counted.last()));
            println!("{told}");
            assert!(2 * located > problems.len() / 2, "{told}");
            assert!(counted.last().is_some_and(|count| *count <= most), "{told}");
        }
    }
}

/// The counter counts: the same calls into a list that grows.
#[test]
fn roots_kept_in_a_list_are_counted() {
    let fixture = support::cylinder_plane(20.0, 45.0);
    let measurements = measurements(&*fixture, &[4, 3], &PROBE);
    let (problem, _) = problems(&*fixture, &measurements)[0];
    let closed_form = fixture.closed_form().unwrap();
    let mut kept = Vec::new();
    let counted = measure(|| closed_form.roots(&problem, &mut |root| kept.push(root)).unwrap());
    assert!(counted.count_total > 0 && !kept.is_empty());
}
