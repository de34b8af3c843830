//! The hot paths, each on measurements that are the same in every run.

use std::{fmt::Write, hint::black_box};

use touchref_analysis::{
    Linear,
    simulation::{generator, random_frame, random_layout, simulate},
};
use touchref_core::{Fixture, Frame, Parameters, Probe, Problem, Solver, Touch};
use touchref_fixtures::{cube, cylinder_plane, three_sphere};
use touchref_solvers::{
    closed_form, least_squares,
    refinement::{descend, refine},
};

const SEED: u64 = 20_261_123;
const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(0.01) };
/// Measurements of a case, so that no lucky one speaks for all.
pub(super) const MEASUREMENTS: u64 = 50;

/// What is counted: callgrind knows it by this name.
#[inline(never)]
fn measured(case: &mut dyn FnMut()) {
    case();
    // A call in the last place would be a jump, and this function over before it.
    black_box(());
}

/// Counts a case, and tells its name. Once before, uncounted: what is set up once is no part of a call.
fn count(name: &str, mut case: impl FnMut()) {
    case();
    measured(&mut case);
    println!("{name}");
}

/// Every case: a call for each measurement.
pub(super) fn run() {
    let new = Parameters::new;
    let cylinder_plane =
        cylinder_plane::PLUGIN.build(&new().with("radius", 20.0).with("angle_deg", 45.0)).unwrap();
    let sides = new().with("radius", 20.0).with("ab", 100.0).with("bc", 90.0).with("ca", 80.0);
    let three_sphere = three_sphere::PLUGIN.build(&sides).unwrap();
    let cube = cube::PLUGIN.build(&new().with("edge", 40.0)).unwrap();
    let closed_form = closed_form::PLUGIN.build(&new()).unwrap();
    let least_squares = least_squares::PLUGIN.build(&new()).unwrap();

    let random = simulated(&*cylinder_plane, Some(&[4, 3]), &PROBE, MEASUREMENTS);
    let problems = problems(&*cylinder_plane, &random);
    count("roots of 4 + 3 touches", || {
        let equations = cylinder_plane.closed_form().unwrap();
        for (problem, _) in &problems {
            equations.roots(problem, &mut |root| _ = black_box(root)).unwrap();
        }
    });
    count("descent of 4 + 3 touches", || {
        for (problem, truth) in &problems {
            black_box(descend(problem, truth));
        }
    });
    for counts in [[4, 3], [17, 13], [570, 430]] {
        let random = simulated(&*cylinder_plane, Some(&counts), &PROBE, MEASUREMENTS);
        let problems = self::problems(&*cylinder_plane, &random);
        let [cylinder, plane] = counts;
        count(&format!("refinement of {cylinder} + {plane} touches"), || {
            for (problem, truth) in &problems {
                let _ = black_box(refine(problem, truth));
            }
        });
    }
    // The fixtures' own layouts: among random ones are some that are searched a thousand times as long.
    let nominal = simulated(&*cylinder_plane, None, &PROBE, MEASUREMENTS);
    let nominal = self::problems(&*cylinder_plane, &nominal);
    count("closed-form, nominal cylinder-plane", || solve(&*closed_form, &nominal));
    let fixtures = [("cylinder-plane", &cylinder_plane), ("three-sphere", &three_sphere), ("cube", &cube)];
    for (name, fixture) in fixtures {
        let nominal = simulated(&**fixture, None, &PROBE, MEASUREMENTS);
        let problems = self::problems(&**fixture, &nominal);
        count(&format!("least-squares, nominal {name}"), || solve(&*least_squares, &problems));
    }
    count("covariance of 4 + 3 touches", || {
        for (problem, truth) in &problems {
            black_box(Linear::at(problem, truth).map(|linear| linear.covariance()));
        }
    });
}

fn solve(solver: &dyn Solver, problems: &[(Problem<'_>, Frame)]) {
    for (problem, _) in problems {
        let _ = black_box(solver.solve(problem));
    }
}

/// Touches of a fixture that stands somewhere, at random places or at those of its own layout, and where it stands.
fn simulated(
    fixture: &dyn Fixture,
    counts: Option<&[usize]>,
    probe: &Probe,
    measurements: u64,
) -> Vec<(Vec<Touch>, Frame)> {
    let measurement = |trial| {
        let mut rng = generator(SEED, trial);
        let layout = match counts {
            Some(counts) => random_layout(fixture, counts, &mut rng),
            None => fixture.nominal_layout(),
        };
        let frame = random_frame(1000.0, &mut rng);
        (simulate(fixture, &layout, &frame, probe, probe.sigma.unwrap(), &mut rng), frame)
    };
    (0..measurements).map(measurement).collect()
}

fn problems<'a>(fixture: &'a dyn Fixture, simulated: &'a [(Vec<Touch>, Frame)]) -> Vec<(Problem<'a>, Frame)> {
    let problem =
        |(touches, truth): &'a (Vec<Touch>, Frame)| (Problem::new(fixture, touches, PROBE).unwrap(), *truth);
    simulated.iter().map(problem).collect()
}

/// A table of so many placements of the paper's fixture.
pub(super) fn table(placements: u64) -> String {
    let probe = Probe { tip_radius: 0.0, tip_radius_u: 0.0, sigma: Some(0.000_05) };
    let fixture = cylinder_plane::PLUGIN.build(&Parameters::new().with("radius", 1.0)).unwrap();
    let mut table = "placement,surface,x,y,z\n".to_owned();
    for (placement, (touches, _)) in simulated(&*fixture, None, &probe, placements).iter().enumerate() {
        for touch in touches {
            let (surface, at) = (&fixture.surfaces()[touch.surface].name, touch.at);
            writeln!(table, "{placement},{surface},{},{},{}", at.x, at.y, at.z).unwrap();
        }
    }
    table
}
