//! An outside author: a fixture, a solver and a dialect, one file each, that use the facade crate alone and are found by
//! name like the built-in ones. Every solver works with every fixture.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod corner;
mod house_dialect;
mod nearest_measure;
#[path = "../support/mod.rs"]
mod support;

use nalgebra::{Point3, Vector6};
use touchref::{
    Fixture, FixturePlugin, Frame, Literal, ParameterKind, Parameters, Probe, Problem, Solution, SolveError,
    Solver, SolverPlugin, Touch, Units,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
    conformance::{Claim, Suite},
    io::dialect::find,
    registry,
    statistics::chi_square_level,
};

const SIGMA: f64 = 0.002;
const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };

fn fixture(name: &str) -> Box<dyn Fixture> {
    built(registry().unwrap().fixture(name).unwrap())
}

/// Built with defaults, and with 20 where a length must be given.
fn built(plugin: &FixturePlugin) -> Box<dyn Fixture> {
    let needed = plugin.parameters.iter().filter(|spec| spec.default.is_none());
    let parameters = needed.fold(Parameters::new(), |parameters, spec| match spec.kind {
        ParameterKind::Length => parameters.with(spec.name, 20.0),
        ParameterKind::Lengths3 => parameters.with(spec.name, [20.0; 3]),
        ParameterKind::Tables(_) => parameters.with(spec.name, support::v_block().tables(spec.name).to_vec()),
        other => panic!("{}: no value of kind {other} for `{}`", plugin.name, spec.name),
    });
    plugin.build(&parameters).unwrap()
}

fn solver(name: &str) -> Box<dyn Solver> {
    registry().unwrap().solver(name).unwrap().build(&Parameters::new()).unwrap()
}

fn solve(solver: &dyn Solver, fixture: &dyn Fixture, touches: &[Touch]) -> Result<Solution, SolveError> {
    solver.solve(&Problem::new(fixture, touches, PROBE).unwrap())
}

/// Squared error of a frame in its own stated covariance: chi-square with six degrees of freedom.
fn squared_error(solution: &Solution, truth: &Frame) -> Option<f64> {
    let covariance = solution.covariance?.matrix;
    let twist = solution.frame.twist_to(truth);
    let (t, w) = (solution.frame.rotation * twist.translation, solution.frame.rotation * twist.rotation);
    let error = Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z);
    Some(error.dot(&covariance.cholesky()?.solve(&error)))
}

#[test]
fn all_are_found_by_name() {
    let registry = registry().unwrap();
    assert!(std::ptr::eq(registry.fixture("corner").unwrap(), &raw const corner::PLUGIN));
    assert!(std::ptr::eq(registry.solver("nearest-measure").unwrap(), &raw const nearest_measure::PLUGIN));
    assert_eq!(registry.fixture("corner").unwrap().origin, "outsider::corner");
    assert!(std::ptr::eq(registry.dialect("house").unwrap(), &raw const house_dialect::PLUGIN));
    // Among the built-in ones.
    assert!(registry.fixture("cylinder-plane").is_ok() && registry.solver("closed-form").is_ok());
}

/// Told and read back like a built-in one; and held to what it says of itself.
#[test]
fn a_frame_is_told_in_the_dialect_of_the_house() {
    let dialect = find(&registry().unwrap(), "house").unwrap();
    let half_turn = [0.0, 0.0, 1.0, 0.0];
    let frame = Frame::from_quaternion_xyzw(Point3::new(1.0, -2.5, 0.000_4), half_turn).unwrap();
    let touched = [Point3::new(1.0, 1000.0, 0.0)];
    let literal = Literal::new("house", &*dialect, &frame, Units::Millimetre, &touched).unwrap();
    assert_eq!(literal.text, "1000 -2500 0 0 0 3141593");
    // 0.4 um of the origin, and 0.35 urad 1002.5 mm away.
    assert!((literal.rounding_loss - 0.000_53).abs() < 0.000_02, "{}", literal.rounding_loss);
}

/// An editor completes a measurement of it like one of the built-in fixtures.
#[test]
fn the_schema_of_a_measurement_has_the_corner() {
    let schema = touchref::io::schema::measurement(&registry().unwrap());
    let fixtures = schema["properties"]["fixture"]["oneOf"].as_array().unwrap();
    let kind = |name: &str| fixtures.iter().find(|one| one["properties"]["kind"]["const"] == name).unwrap();
    let corner = kind(corner::PLUGIN.name);
    for spec in corner::PLUGIN.parameters {
        let described = corner["properties"][spec.name]["description"].as_str().unwrap();
        assert!(described.starts_with(spec.meaning), "{described}");
    }
    assert!(corner["description"].as_str().unwrap().contains(corner::PLUGIN.frame));
    assert_eq!(kind("cube")["required"][1], "edge");
}

/// Every pair, on exact touches and on noisy ones: the right frame, or a typed refusal.
#[test]
fn every_solver_works_with_every_fixture() {
    const TRIALS: u64 = 100;
    /// Exact touches: translation in parts of the fixture's size, and radians. Coordinates of 1000 round to 1e-13.
    const EXACT: f64 = 1e-9;
    let registry = registry().unwrap();
    let level = chi_square_level(1e-9, 6);
    let pairs = registry.fixtures().iter().flat_map(|f| registry.solvers().iter().map(move |s| (*f, *s)));
    for (fixture_plugin, solver_plugin) in pairs {
        let (fixture, solver) = pair(fixture_plugin, solver_plugin);
        let (layout, mut solved) = (fixture.nominal_layout(), 0);
        for trial in 0..TRIALS {
            let what = format!("{} by {}, trial {trial}", fixture_plugin.name, solver_plugin.name);
            let mut rng = generator(71, trial);
            let truth = random_frame(1000.0, &mut rng);
            let noise = if trial % 2 == 0 { 0.0 } else { SIGMA };
            let touches = simulate(&*fixture, &layout, &truth, &PROBE, noise, &mut rng);
            match solve(&*solver, &*fixture, &touches) {
                Ok(solution) => {
                    solved += 1;
                    assert_eq!(
                        (solution.solver, solution.residuals.len()),
                        (solver_plugin.name, touches.len())
                    );
                    let off = solution.frame.twist_to(&truth);
                    let off = off.translation.norm() / fixture.size() + off.rotation.norm();
                    assert!(noise > 0.0 || off < EXACT, "{what}: off by {off:e}");
                    let squared = squared_error(&solution, &truth);
                    assert!(
                        squared.is_none_or(|squared| squared < level),
                        "{what}: squared error {squared:?}"
                    );
                }
                Err(refusal) => {
                    assert!(!refusal.code().is_empty() && !refusal.help().is_empty(), "{what}: {refusal:?}");
                }
            }
        }
        println!("{} by {}: {solved} of {TRIALS} solved", fixture_plugin.name, solver_plugin.name);
        // A search everywhere finds, too, what a closed form leaves out without an objection: the other corners of 3-2-1.
        let led = fixture.closed_form().is_some() && solver.name() != "global";
        assert!(solved > TRIALS * 9 / 10 || !led, "{} by {}", fixture.kind(), solver.name());
    }
}

fn pair(fixture: &FixturePlugin, solver: &SolverPlugin) -> (Box<dyn Fixture>, Box<dyn Solver>) {
    (built(fixture), solver.build(&Parameters::new()).unwrap())
}

/// The built-in solver knows the outsider's fixture by the trait only, and is as honest about it as about its own.
#[test]
fn the_built_in_solver_is_honest_about_the_corner() {
    const TRIALS: u64 = 2000;
    /// Standard deviations of the mean that chance may take; chi-square with six degrees of freedom has variance 12.
    const CHANCE: f64 = 3.0;
    let (corner, closed_form) = (fixture("corner"), solver("closed-form"));
    for counts in [[3, 2, 1], [3, 3, 3]] {
        let layout: Vec<(usize, Point3<f64>)> = if counts == [3, 2, 1] {
            corner.nominal_layout()
        } else {
            random_layout(&*corner, &counts, &mut generator(72, 0))
        };
        let mut squared_errors = Vec::new();
        for trial in 0..TRIALS {
            let mut rng = generator(73, trial);
            let truth = random_frame(1000.0, &mut rng);
            let touches = simulate(&*corner, &layout, &truth, &PROBE, SIGMA, &mut rng);
            let Ok(solution) = solve(&*closed_form, &*corner, &touches) else { continue };
            assert_eq!(solution.degrees_of_freedom, touches.len() - 6);
            squared_errors.push(squared_error(&solution, &truth).unwrap());
        }
        let count = squared_errors.len() as f64;
        let mean = squared_errors.iter().sum::<f64>() / count;
        println!("corner {counts:?}: NEES {mean:.3} of {count} accepted");
        assert!(count > 0.99 * TRIALS as f64, "{counts:?}: {count} accepted");
        assert!((mean - 6.0).abs() < CHANCE * (12.0 / count).sqrt(), "{counts:?}: NEES {mean}");
    }
}

/// Two touches of `y` one above the other along X leave a turn about X free; the outsider did not have to say so.
#[test]
fn the_built_in_solver_sees_what_the_corner_leaves_free() {
    let corner = fixture("corner");
    let mut layout = corner.nominal_layout();
    layout[4].1 = layout[3].1 + nalgebra::Vector3::x() * -10.0;
    let mut rng = generator(74, 0);
    let truth = random_frame(1000.0, &mut rng);
    let touches = simulate(&*corner, &layout, &truth, &PROBE, 0.0, &mut rng);
    match solve(&*solver("closed-form"), &*corner, &touches) {
        Err(SolveError::Degenerate(degenerate)) => {
            let axis = degenerate.free.twist.rotation;
            assert!(axis.normalize().cross(&truth.axis(0)).norm() < 1e-6, "{}", degenerate.free);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_left_handed_corner_is_told() {
    let corner = fixture("corner");
    let layout = random_layout(&*corner, &[3, 3, 3], &mut generator(75, 0));
    let mut touches = simulate(&*corner, &layout, &Frame::identity(), &PROBE, SIGMA, &mut generator(75, 1));
    for touch in &mut touches {
        touch.surface = [1, 0, 2][touch.surface];
    }
    let refusal = solve(&*solver("closed-form"), &*corner, &touches).unwrap_err();
    assert_eq!(refusal.code(), "invalid-input");
    assert!(refusal.to_string().contains("left-handed"), "{refusal}");
}

#[test]
fn too_few_touches_are_told() {
    let corner = fixture("corner");
    let touches = [corner.touch("x", [0.0; 3]).unwrap(), corner.touch("y", [0.0; 3]).unwrap()];
    for name in ["closed-form", "nearest-measure"] {
        let refusal = solve(&*solver(name), &*corner, &touches).unwrap_err();
        assert_eq!(refusal.code(), "too-few-touches", "{name}: {refusal}");
        assert!(refusal.to_string().contains("`z` has 0 of 1 touches"), "{refusal}");
    }
}

/// The published suite, run by the outsider.
#[test]
fn the_corner_keeps_its_promises() {
    let (suite, parameters) = (Suite::default(), Parameters::new());
    suite.fixture(&corner::PLUGIN, &parameters).assert_passed();
    let closed_form = registry().unwrap().solver("closed-form").unwrap();
    let claim = Claim::LeastSquaresMeasured;
    suite.solver((closed_form, &parameters), claim, (&corner::PLUGIN, &parameters)).assert_passed();
}

/// The example that is not to be trusted does not pass for one that is: the suite says what it lacks.
#[test]
fn the_nearest_measure_keeps_hardly_any() {
    let (suite, none) = (Suite::default(), Parameters::new());
    let cylinder_plane = registry().unwrap().fixture("cylinder-plane").unwrap();
    let radius = Parameters::new().with("radius", 20.0);
    let report = suite.solver((&nearest_measure::PLUGIN, &none), Claim::Other, (cylinder_plane, &radius));
    println!("{report}");
    // It tells no covariance, hands out a frame for any layout, and trusts none itself.
    assert_eq!(report.failed(), ["noisy", "account", "invariance", "refusals", "no-sigma"]);
}
