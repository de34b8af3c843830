//! `composite`: surfaces as data. Held against the built-in fixtures stated as data, the truth of simulated touches, and
//! what a user may write wrongly.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use std::path::Path;

use support::{bore_with_two_faces, v_block};
use touchref::{
    Fixture, Frame, Freedom, Parameters, Probe, Problem, SolveError, Twist, Value,
    analysis::{
        Study, StudyLayout,
        simulation::{generator, random_frame, random_layout, simulate},
    },
    io::{Measurement, read_frame},
    registry,
    statistics::chi_square_level,
};

/// Frames of the same touches and geometry, by different searches: parts of the size, radians.
const SAME: f64 = 1e-8;
const SIGMA: f64 = 0.005;

fn probe() -> Probe {
    Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) }
}

fn surface(kind: &str, name: &str) -> Parameters {
    Parameters::new().with("type", kind).with("name", name)
}

fn plane(name: &str, point: [f64; 3], normal: [f64; 3]) -> Parameters {
    surface("plane", name).with("point", point).with("normal", normal)
}

fn composite(surfaces: Vec<Parameters>) -> Box<dyn Fixture> {
    support::fixture("composite", &Parameters::new().with("surface", surfaces))
}

/// A built-in fixture, the same as data, and how many touches of each surface.
type Twins = (Box<dyn Fixture>, Box<dyn Fixture>, Vec<usize>);

/// The built-in fixtures, each with the same as data.
fn twins() -> Vec<Twins> {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let cylinder = surface("cylinder", "cylinder").with("point", [0.0; 3]).with("axis", [0.0, 0.0, 3.0]);
    // Where the cylinder ends tells from which side of the plane it was touched.
    let cylinder = cylinder.with("from", -200.0).with("to", 20.0);
    let oblique = vec![cylinder.with("radius", 20.0), plane("plane", [0.0; 3], [-half, 0.0, half])];
    let ball =
        |name: &str, center: [f64; 3]| surface("sphere", name).with("center", center).with("radius", 12.0);
    // A right-angled triangle of sides 80, 60 and 100.
    let balls = vec![ball("a", [0.0; 3]), ball("b", [80.0, 0.0, 0.0]), ball("c", [0.0, 60.0, 0.0])];
    let sides = Parameters::new().with("radius", 12.0).with("ab", 80.0).with("bc", 100.0).with("ca", 60.0);
    let face = |name: &str, axis: usize, sign: f64| {
        let mut normal = [0.0; 3];
        normal[axis] = sign;
        let middle = if sign > 0.0 { 0.0 } else { -40.0 };
        let mut point = [-20.0; 3];
        point[axis] = middle;
        // The circle around a face: a touch in a corner is on it.
        plane(name, point, normal).with("within", 20.0 * 2.0_f64.sqrt())
    };
    let names = ["+x", "-x", "+y", "-y", "+z", "-z"];
    let faces =
        names.iter().enumerate().map(|(k, name)| face(name, k / 2, if k % 2 == 0 { 1.0 } else { -1.0 }));
    vec![
        (support::cylinder_plane(20.0, 45.0), composite(oblique), vec![6, 4]),
        (support::fixture("three-sphere", &sides), composite(balls), vec![4, 4, 4]),
        (
            support::fixture("cube", &Parameters::new().with("edge", 40.0)),
            composite(faces.collect()),
            vec![3, 0, 3, 0, 3, 0],
        ),
    ]
}

#[test]
fn a_built_in_fixture_stated_as_data_has_the_same_frame() {
    const TRIALS: u64 = 25;
    let solver = support::solver("least-squares");
    for (built_in, stated, counts) in twins() {
        let (mut both, mut only) = (0, [0, 0]);
        for trial in 0..TRIALS {
            let mut rng = generator(61, trial);
            let layout = random_layout(&*built_in, &counts, &mut rng);
            let truth = random_frame(300.0, &mut rng);
            let touches = simulate(&*built_in, &layout, &truth, &probe(), SIGMA, &mut rng);
            let solve = |fixture| solver.solve(&Problem::new(fixture, &touches, probe()).unwrap());
            match (solve(&*built_in), solve(&*stated)) {
                (Ok(first), Ok(second)) => {
                    both += 1;
                    let apart = first.frame.twist_to(&second.frame).extent(built_in.size());
                    assert!(apart < SAME, "{} {trial}: {apart:e}", built_in.kind());
                    let of = |s: &touchref::Solution| s.covariance.unwrap().matrix;
                    assert!((of(&first) - of(&second)).norm() < 1e-6 * of(&first).norm());
                }
                (Ok(_), Err(_)) => only[0] += 1,
                (Err(_), Ok(_)) => only[1] += 1,
                (Err(_), Err(_)) => {}
            }
        }
        println!("{}: both {both}, only one {only:?}", built_in.kind());
        assert!(both * 4 >= TRIALS * 3, "{}: only {both} of {TRIALS}", built_in.kind());
    }
}

#[test]
fn the_examples_are_located_where_they_were_simulated() {
    let registry = registry().unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    for name in ["v-block", "tooling-balls", "bore-and-faces"] {
        let path = folder.join(format!("{name}.toml"));
        let text = std::fs::read_to_string(&path).unwrap();
        let truth = text.lines().find_map(|line| line.split_once("x,y,z,qx,qy,qz,qw = ")).unwrap().1;
        let truth = read_frame(truth.trim_end_matches('.')).unwrap();
        let measurement = Measurement::from_text(name, &text, &folder).unwrap();
        let fixture = measurement.fixture(&registry).unwrap();
        let touches = measurement.touches(&*fixture).unwrap().touches;
        let problem = Problem::new(&*fixture, &touches, measurement.probe).unwrap();
        for solver in ["least-squares", "global"] {
            let solution = support::solver(solver).solve(&problem).unwrap();
            let squared = solution.squared_distance(&truth).unwrap();
            println!("{name}, {solver}: squared error {squared:.2}");
            assert!(squared < chi_square_level(1e-4, problem.unknowns()), "{name}");
        }
        let closed_form = support::solver("closed-form").solve(&problem).unwrap_err();
        assert_eq!(closed_form.code(), "unsupported");
    }
}

#[test]
fn a_free_motion_is_told_unless_it_is_not_wanted() {
    let wanted = bore_with_two_faces();
    let mut all = Parameters::new();
    all.set("surface", wanted.get("surface").unwrap().clone());
    let (wanted, all) = (support::fixture("composite", &wanted), support::fixture("composite", &all));
    assert_eq!(wanted.freedom(), Freedom::from_names(["rz"]).unwrap());
    let mut rng = generator(62, 0);
    let truth = random_frame(300.0, &mut rng);
    let touches = simulate(&*wanted, &wanted.nominal_layout(), &truth, &probe(), SIGMA, &mut rng);
    let solver = support::solver("least-squares");

    let SolveError::Degenerate(told) =
        solver.solve(&Problem::new(&*all, &touches, probe()).unwrap()).unwrap_err()
    else {
        panic!("the spin is free")
    };
    assert_eq!(told.free.to_string(), "rotation about the axis of `bore`");

    let problem = Problem::new(&*wanted, &touches, probe()).unwrap();
    let solution = solver.solve(&problem).unwrap();
    assert_eq!((solution.degrees_of_freedom, solution.observability.rank), (touches.len() - 5, 5));
    assert!(solution.warnings.iter().any(|warning| warning.code == "free-motion"));
    assert!(solution.squared_distance(&truth).unwrap() < chi_square_level(1e-4, 5));
    // Nothing is said of the spin, and nothing depends on it.
    let spin = solution.frame.axis(2);
    let variance = solution.covariance.unwrap().matrix.fixed_view::<3, 3>(3, 3) * spin;
    assert!(variance.norm() < 1e-12);
    let turned = solution.frame.moved(&Twist::from(nalgebra::Vector6::ith(5, 1.0)));
    assert!(solution.squared_distance(&turned).unwrap() < 1e-9);
    // An expected frame tells the spin that is wanted.
    let near = solver.solve(&problem.near(truth)).unwrap();
    assert!(near.frame.error_to(&truth).norm() < 20.0 * SIGMA);
}

#[test]
fn the_stated_covariance_is_true() {
    const TRIALS: u64 = 300;
    let plugin = registry().unwrap().fixture("composite").unwrap();
    let solver = support::solver("least-squares");
    for (parameters, unknowns) in [(v_block(), 6.0), (bore_with_two_faces(), 5.0)] {
        let fixture = plugin.build(&parameters).unwrap();
        let layout = StudyLayout::Fixed(fixture.nominal_layout());
        let study = Study {
            fixture: &*fixture,
            plugin,
            solver: &*solver,
            layout,
            probe: probe(),
            reach: 500.0,
            seed: 63,
            trials: TRIALS,
        };
        let outcome = study.run().unwrap();
        let nees = outcome.nees_mean().unwrap();
        println!("{} of {TRIALS} accepted, NEES {:.2} of {unknowns}", outcome.accepted, nees.value);
        assert_eq!(outcome.wrong, 0);
        assert!(outcome.accepted * 100 >= TRIALS * 98);
        // Four standard deviations of the mean.
        assert!((nees.value - unknowns).abs() < 4.0 * nees.u, "{nees:?}");
        // Nothing is uncertain but the touches, so the bound is reached.
        for over in outcome.rms_over_bound().unwrap() {
            assert!((over.value - 1.0).abs() < 4.0 * over.u, "{over:?}");
        }
    }
}

#[test]
fn an_uncertain_radius_takes_part() {
    let Value::Tables(mut tables) = bore_with_two_faces().get("surface").unwrap().clone() else { panic!() };
    tables[0].set("radius", Value::Number { value: 15.0, u: 0.05 });
    let fixture =
        support::fixture("composite", &Parameters::new().with("surface", tables).with("free", &["rz"][..]));
    // It is larger by one of its standard uncertainties.
    let truly = bore_with_two_faces();
    let Value::Tables(mut tables) = truly.get("surface").unwrap().clone() else { panic!() };
    tables[0].set("radius", Value::from(15.05));
    let truly = support::fixture("composite", &truly.with("surface", tables));
    let mut rng = generator(64, 0);
    let truth = random_frame(300.0, &mut rng);
    let touches = simulate(&*truly, &truly.nominal_layout(), &truth, &probe(), SIGMA, &mut rng);
    let solution =
        support::solver("least-squares").solve(&Problem::new(&*fixture, &touches, probe()).unwrap()).unwrap();
    let [radius] = solution.adjustments.as_slice() else { panic!("{:?}", solution.adjustments) };
    assert_eq!(radius.name, "bore.radius");
    assert!((radius.value - 15.05).abs() < 4.0 * radius.u && radius.u < SIGMA, "{radius:?}");
}

#[test]
fn what_is_wrong_with_a_surface_is_said_where_it_stands() {
    let start = "units = \"mm\"\n[fixture]\nkind = \"composite\"\n";
    let good =
        "[[fixture.surface]]\nname = \"top\"\ntype = \"plane\"\npoint = [0, 0, 5]\nnormal = [0, 0, 1]\n";
    // What is appended or replaced, code, line, and what the message or help says.
    let table: [(String, &str, usize, &str); 14] = [
        (good.replace("normal", "nromal"), "unknown-key", 8, "normal"),
        (good.replace("normal = [0, 0, 1]\n", ""), "missing-key", 4, "normal"),
        (good.replace("\"plane\"", "\"plan\""), "invalid-input", 6, "plane"),
        (good.replace("type = \"plane\"\n", ""), "missing-key", 4, "type"),
        (good.replace("[0, 0, 1]", "[0, 0, 0]"), "invalid-input", 8, "not all zero"),
        (good.replace("[0, 0, 1]", "[0, 1]"), "invalid-input", 8, "direction"),
        (good.replace("[0, 0, 5]", "\"here\""), "invalid-input", 7, "a word"),
        (good.replace("\"top\"", "\"\""), "invalid-input", 5, "empty"),
        (format!("{good}within = -2\n"), "invalid-input", 9, "length > 0"),
        (format!("{good}{good}"), "invalid-input", 10, "another surface"),
        (good.to_owned(), "missing-key", 2, "size"),
        (format!("surface = []\n{}", "size = 3\n"), "invalid-input", 4, "empty"),
        (format!("free = [\"rw\"]\nsize = 10\n{good}"), "invalid-input", 4, "rw"),
        (format!("free = [\"z\"]\nsize = 10\n{good}"), "invalid-input", 4, "`top` fixes"),
    ];
    let registry = registry().unwrap();
    for (text, code, line, says) in table {
        let text = format!("{start}{text}");
        let measurement = Measurement::from_text("m.toml", &text, Path::new("")).unwrap();
        let error = measurement.fixture(&registry).unwrap_err();
        let told = format!("{error} {}", error.help().unwrap_or_default());
        assert_eq!(error.code(), code, "{text}{told}");
        assert_eq!(error.place().map(|place| place.line), Some(line), "{text}{told}");
        assert!(told.contains(says), "{text}{told}");
    }
    let two = format!("{start}free = [\"rx\", \"ry\"]\nsize = 10\n{good}");
    let measurement = Measurement::from_text("m.toml", &two, Path::new("")).unwrap();
    assert!(measurement.fixture(&registry).unwrap_err().to_string().contains("all three"));
}

#[test]
fn a_touch_beyond_a_stated_end_rules_a_frame_out() {
    // Three planes meet in four frames; the ends tell them apart.
    let parameters = v_block();
    let fixture = support::fixture("composite", &parameters);
    let mut rng = generator(65, 0);
    let truth = random_frame(300.0, &mut rng);
    let touches = simulate(&*fixture, &fixture.nominal_layout(), &truth, &probe(), SIGMA, &mut rng);
    let solution =
        support::solver("global").solve(&Problem::new(&*fixture, &touches, probe()).unwrap()).unwrap();
    assert!(solution.squared_distance(&truth).unwrap() < chi_square_level(1e-4, 6));
    let out = solution.roots.iter().filter(|root| root.reason.contains("beyond the end of")).count();
    assert!(out >= 1, "{:?}", solution.roots);
    let nobody: Frame = truth.moved(&Twist::from(nalgebra::Vector6::new(0.0, 0.0, 80.0, 0.0, 0.0, 0.0)));
    assert!(fixture.objection(&Problem::new(&*fixture, &touches, probe()).unwrap(), &nobody).is_some());
}

#[test]
fn a_bad_touch_is_named() {
    let fixture = support::fixture("composite", &v_block());
    let solver = support::solver("robust");
    for (trial, bad) in [0, 4, 8, 12].into_iter().enumerate() {
        let mut rng = generator(66, trial as u64);
        let truth = random_frame(300.0, &mut rng);
        let layout: Vec<_> =
            (0..15).map(|k| (k % 3, fixture.surfaces()[k % 3].point_at(0.2 * (k / 3) as f64, 0.7))).collect();
        let mut touches = simulate(&*fixture, &layout, &truth, &probe(), SIGMA, &mut rng);
        let surface = &fixture.surfaces()[touches[bad].surface];
        let normal = truth.rotation * surface.seen_from(&truth.to_fixture(&touches[bad].at)).normal;
        touches[bad].at += normal;
        let solution = solver.solve(&Problem::new(&*fixture, &touches, probe()).unwrap()).unwrap();
        assert_eq!(solution.excluded, [bad]);
        assert!(solution.squared_distance(&truth).unwrap() < chi_square_level(1e-4, 6));
    }
}

/// Sizes and places beyond all measure are refused, or build at once: no decomposition of what is no number goes on for ever.
#[test]
fn absurd_sizes_end() {
    let plugin = touchref::registry().unwrap().fixture("composite").unwrap();
    let sphere = |center: [f64; 3], toward: [f64; 3]| {
        surface("sphere", "a").with("center", center).with("radius", 12.0).with("toward", toward)
    };
    let floor = plane("floor", [0.0; 3], [0.0, 0.0, 1e300]);
    for far in [1e150, 1e300, f64::MAX, 1e-300] {
        for surfaces in [
            vec![sphere([far, 0.0, 0.0], [0.0, 0.0, 1.0]), floor.clone()],
            vec![sphere([far; 3], [1.0, far, 0.0])],
            vec![plane("one", [far; 3], [far, 1.0, 0.0]), plane("other", [far; 3], [0.0, 1.0, far])],
        ] {
            if let Ok(fixture) = plugin.build(&Parameters::new().with("surface", surfaces.clone())) {
                assert!(fixture.size().is_finite() && fixture.size() > 0.0, "{surfaces:?}");
            }
        }
    }
    let error =
        plugin.build(&Parameters::new().with("surface", vec![floor]).with("size", 1e300)).unwrap_err();
    assert_eq!(error.name, "size");
    // A direction of any length is one.
    let turned = composite(vec![sphere([0.0; 3], [0.0, 1e300, 0.0]), plane("b", [0.0; 3], [0.0, 0.0, 1.0])]);
    for (index, at) in turned.nominal_layout() {
        assert!(turned.surfaces()[index].seen_from(&at).distance.abs() < 1e-9, "{at}");
    }
}
