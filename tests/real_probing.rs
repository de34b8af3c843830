//! Real probing: ball centres of a coordinate measuring machine on a bore and a 40 degree oblique plane, the QIF
//! "Cheese Block" (github.com/QualityInformationFramework/qif-community). The table is not part of this repository;
//! without it these tests say so and pass.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use std::{collections::BTreeMap, fs, path::Path};

use nalgebra::{Matrix6, Point3, Vector3, Vector6};
use rand::{Rng, RngExt};
use touchref::{
    Fixture, Frame, Parameters, Probe, Problem, RootKind, Solution, Touch, analysis::simulation::generator,
    statistics::chi_square_level,
};

const TIP_RADIUS: f64 = 2.499_782_711_04;
const ANGLE_DEG: f64 = 39.996;
/// Radius of the bore as all its touches measure it; the drawing says 15.
const RADIUS: f64 = 15.0555;
/// Standard deviation taken for one touch; the residuals of all touches are 2 um rms.
const SIGMA: f64 = 0.005;

/// The bore of this radius in an oblique plane.
fn block(radius: f64) -> Box<dyn Fixture> {
    let parameters = Parameters::new().with("radius", radius).with("angle_deg", ANGLE_DEG).with("bore", true);
    support::fixture("cylinder-plane", &parameters)
}

fn probe() -> Probe {
    Probe { tip_radius: TIP_RADIUS, sigma: Some(SIGMA), ..Probe::default() }
}

/// The touches of the table, `surface,x,y,z` and a column more; `None`, told, where it is missing.
fn touches(fixture: &dyn Fixture) -> Option<Vec<Touch>> {
    let table = "../shared/data/real/qif_cheese_block/cylinder_plane.csv";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(table);
    let Ok(text) = fs::read_to_string(path) else {
        println!("skipped: {table} is missing");
        return None;
    };
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let touches = rows.map(|row| {
        let fields: Vec<&str> = row.split(',').collect();
        fixture.touch(fields[0], [1, 2, 3].map(|k| fields[k].parse().unwrap())).unwrap()
    });
    Some(touches.collect())
}

fn solve(fixture: &dyn Fixture, touches: &[Touch]) -> Result<Solution, touchref::SolveError> {
    let problem = Problem::new(fixture, touches, probe()).unwrap();
    support::solver("closed-form").solve(&problem)
}

/// Translation and rotation vector from one frame to another, along the parent's axes.
fn error(from: &Frame, to: &Frame) -> Vector6<f64> {
    let twist = from.twist_to(to);
    let (t, w) = (from.rotation * twist.translation, from.rotation * twist.rotation);
    Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z)
}

#[test]
fn all_touches_give_the_frame_of_the_inspection() {
    /// The inspection's frame is a fit of other features of the part, too.
    const INSPECTION_ORIGIN: f64 = 0.05;
    const INSPECTION_AXIS: f64 = 1e-3;
    let fixture = block(RADIUS);
    let Some(touches) = touches(&*fixture) else { return };
    assert_eq!(touches.len(), 22);
    let frame = solve(&*fixture, &touches).unwrap().frame;
    let origin = Point3::new(-19.4688, 19.6549, 22.5590);
    let axis = Vector3::new(-0.000_276, 0.001_202, 0.999_999);
    assert!((frame.origin - origin).norm() < INSPECTION_ORIGIN, "{}", frame.origin);
    assert!(frame.axis(2).angle(&axis) < INSPECTION_AXIS, "{}", frame.axis(2));
}

/// The radius-free least squares of `tests/oracle/cheese_block.py`, which prints these numbers.
#[test]
fn all_touches_give_the_least_squares_frame() {
    /// mm and radians; the oracle's digits reach 1e-12, Gauss-Newton is stopped after two steps.
    const TOLERANCE: f64 = 1e-6;
    const ORACLE_RADIUS: f64 = 15.055_470_308_281;
    let oracle = Frame::from_z_and_x(
        Point3::new(-19.461_659_047_098, 19.654_530_415_622, 22.565_329_227_588),
        Vector3::new(-0.000_002_191_084, 0.001_189_372_772, 0.999_999_292_694),
        Vector3::new(0.999_999_997_342, 0.000_072_873_913, 0.000_002_104_411),
    )
    .unwrap();
    let fixture = block(RADIUS);
    let Some(touches) = touches(&*fixture) else { return };
    let solution = solve(&*fixture, &touches).unwrap();
    let off = error(&solution.frame, &oracle);
    let radius = solution.roots[0].measures[0].value - ORACLE_RADIUS;
    println!(
        "from the oracle: {:.1e} {:.1e}, radius {radius:.1e}",
        off.xyz().norm(),
        off.fixed_rows::<3>(3).norm()
    );
    assert!(off.amax() < TOLERANCE, "{off}");
    assert!(radius.abs() < TOLERANCE, "{radius}");
}

/// The nominal radius is wrong by 0.055 mm: no frame, and the refusal says which radius the touches want.
#[test]
fn the_nominal_radius_is_refused() {
    let fixture = block(15.0);
    let Some(touches) = touches(&*fixture) else { return };
    let refusal = solve(&*fixture, &touches).unwrap_err();
    assert_eq!(refusal.code(), "inconsistent", "{refusal}");
    assert!(refusal.to_string().contains("15.06"), "{refusal}");
}

/// `count` of the touches on one surface, at random and in random order.
fn some_of(touches: &[Touch], surface: usize, count: usize, rng: &mut impl Rng) -> Vec<Touch> {
    let mut on_surface: Vec<Touch> =
        touches.iter().filter(|touch| touch.surface == surface).copied().collect();
    for k in 0..count {
        let other = rng.random_range(k..on_surface.len());
        on_surface.swap(k, other);
    }
    on_surface.truncate(count);
    on_surface
}

/// The frame of the root of nearest radius: what a solver without refusals would answer.
fn nearest_radius(problem: &Problem<'_>) -> Option<Frame> {
    let mut best: Option<(f64, Frame)> = None;
    let closed_form = problem.fixture().closed_form()?;
    let searched = closed_form.roots(problem, &mut |root| {
        let misfit = (root.measures[0] - RADIUS).abs();
        if root.kind == RootKind::Real && best.is_none_or(|(least, _)| misfit < least) {
            best = Some((misfit, root.frame));
        }
    });
    searched.ok()?;
    best.map(|(_, frame)| frame)
}

/// Real 4 + 3 subsets: whatever is accepted is as good as it says.
#[test]
fn no_subset_gives_a_frame_outside_its_own_uncertainty() {
    const SUBSETS: u64 = 1500;
    const SEED: u64 = 51;
    /// Form counts as noise, but `SIGMA` is the probe's: in variance, the plane's form (6 um rms over four touches) and
    /// the bore's (2 um) beside 5 um.
    const FORM: f64 = 1.0 + (6.0 * 6.0 + 2.0 * 2.0) / (5.0 * 5.0);
    /// An axis this far off is another root.
    const ANOTHER: f64 = 2.0;
    let fixture = block(RADIUS);
    let Some(touches) = touches(&*fixture) else { return };
    let truth = solve(&*fixture, &touches).unwrap();
    let of_truth: Matrix6<f64> = truth.covariance.unwrap().matrix;
    let level = chi_square_level(1e-9, 6);
    let (mut accepted, mut worst, mut nearest_wrong) = (0, 0.0_f64, 0);
    let mut refused: BTreeMap<&str, u64> = BTreeMap::new();
    for subset in 0..SUBSETS {
        let mut rng = generator(SEED, subset);
        let mut some = some_of(&touches, 0, 4, &mut rng);
        some.extend(some_of(&touches, 1, 3, &mut rng));
        match solve(&*fixture, &some) {
            Ok(solution) => {
                let covariance = (solution.covariance.unwrap().matrix + of_truth) * FORM;
                let off = error(&solution.frame, &truth.frame);
                let squared = off.dot(&covariance.cholesky().unwrap().solve(&off));
                assert!(squared < level, "subset {subset}: squared error {squared}");
                worst = worst.max(squared);
                accepted += 1;
            }
            Err(refusal) => {
                assert!(!refusal.is_input_error(), "subset {subset}: {refusal}");
                *refused.entry(refusal.code()).or_default() += 1;
            }
        }
        let problem = Problem::new(&*fixture, &some, probe()).unwrap();
        let wrong = nearest_radius(&problem)
            .is_none_or(|frame| frame.axis(2).angle(&truth.frame.axis(2)) > ANOTHER.to_radians());
        nearest_wrong += u64::from(wrong);
    }
    println!(
        "{SUBSETS} subsets: accepted {accepted}, worst squared error {worst:.1} of {level:.1}; refused {refused:?}"
    );
    println!("by nearest radius: {nearest_wrong} with an axis more than {ANOTHER} degrees off");
    assert!(accepted > SUBSETS / 10, "{accepted} accepted: too few to say anything");
    assert!(nearest_wrong > SUBSETS / 20, "{nearest_wrong}: the data is easier than it was");
}
