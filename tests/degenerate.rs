//! Layouts of `cylinder-plane` that leave a motion free: refused, and told which motion; never a frame, however little
//! noise hides what is missing.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use std::{collections::BTreeMap, f64::consts::FRAC_PI_2};

use nalgebra::{DMatrix, Point3, Rotation3, Unit, Vector3, Vector6};
use rayon::prelude::*;
use touchref::{
    Fixture, Frame, Motion, Probe, Problem, Solution, SolveError, Touch, Twist,
    analysis::simulation::{Layout, generator, random_frame, simulate},
    statistics::chi_square_level,
    surface::perpendiculars,
};

const RADIUS: f64 = 20.0;
const ANGLE_DEG: f64 = 45.0;
const SIGMA: f64 = 0.001;
const TIP_RADIUS: f64 = 1.5;

/// Where the cylinder is touched: turn about its axis in degrees, and height in radii.
type OnCylinder = [(f64, f64); 4];
/// Where the plane is touched: along two perpendicular directions in it, in radii.
type OnPlane = [(f64, f64); 3];

/// A layout, and what its refusal must say.
struct Case {
    name: &'static str,
    cylinder: OnCylinder,
    plane: OnPlane,
    /// Words of the free motion.
    words: &'static [&'static str],
}

const SOUND_CYLINDER: OnCylinder = [(135.0, -4.0), (225.0, -4.0), (315.0, -1.5), (45.0, -1.5)];
const SOUND_PLANE: OnPlane = [(1.5, 0.0), (-0.75, 1.3), (-0.75, -1.3)];

/// Layouts that leave a motion free while the radius is known by the touches alone, as the closed form wants it.
const DEGENERATE: [Case; 9] = [
    Case {
        name: "plane touches in a line",
        cylinder: SOUND_CYLINDER,
        plane: [(-1.0, -0.6), (0.25, 0.15), (1.0, 0.6)],
        words: &["rotation of `plane`"],
    },
    Case {
        name: "two plane touches coincident",
        cylinder: SOUND_CYLINDER,
        plane: [(1.5, 0.0), (-0.75, 1.3), (1.5, 0.0)],
        words: &["rotation of `plane`"],
    },
    Case {
        name: "two cylinder touches coincident",
        cylinder: [(135.0, -4.0), (225.0, -4.0), (315.0, -1.5), (225.0, -4.0)],
        plane: SOUND_PLANE,
        words: &["rotation of `cylinder`"],
    },
    Case {
        name: "ring of four",
        cylinder: [(10.0, -3.0), (95.0, -3.0), (190.0, -3.0), (285.0, -3.0)],
        plane: SOUND_PLANE,
        words: &["rotation about"],
    },
    Case {
        name: "one generator line",
        cylinder: [(50.0, -4.0), (50.0, -3.2), (50.0, -2.1), (50.0, -1.5)],
        plane: SOUND_PLANE,
        words: &["rotation of `cylinder`"],
    },
    Case {
        name: "two opposed pairs at two heights",
        cylinder: [(20.0, -4.0), (200.0, -4.0), (80.0, -1.5), (260.0, -1.5)],
        plane: SOUND_PLANE,
        words: &["rotation about"],
    },
    Case {
        name: "two opposed pairs, one above the other",
        cylinder: [(20.0, -4.0), (200.0, -4.0), (20.0, -1.5), (200.0, -1.5)],
        plane: SOUND_PLANE,
        words: &["slide along"],
    },
    Case {
        name: "low-high-low-high at 90 degrees",
        cylinder: [(10.0, -4.0), (100.0, -1.5), (190.0, -4.0), (280.0, -1.5)],
        plane: SOUND_PLANE,
        words: &["rotation about"],
    },
    Case { name: "everything in one point", cylinder: [(50.0, -3.0); 4], plane: [(0.5, 0.5); 3], words: &[] },
];

const SOUND: [Case; 3] = [
    Case { name: "nominal", cylinder: SOUND_CYLINDER, plane: SOUND_PLANE, words: &[] },
    Case {
        name: "low-low-high-high at 90 degrees",
        cylinder: [(100.0, -4.0), (190.0, -4.0), (280.0, -1.5), (10.0, -1.5)],
        plane: SOUND_PLANE,
        words: &[],
    },
    Case {
        name: "scattered",
        cylinder: [(120.0, -3.9), (230.0, -3.4), (330.0, -1.6), (40.0, -2.0)],
        plane: [(1.4, 0.2), (-0.9, 1.0), (-0.5, -1.4)],
        words: &[],
    },
];

fn fixture() -> Box<dyn Fixture> {
    support::cylinder_plane(RADIUS, ANGLE_DEG)
}

fn probe(sigma: Option<f64>) -> Probe {
    Probe { tip_radius: TIP_RADIUS, sigma, ..Probe::default() }
}

/// Contact points in fixture coordinates.
fn layout(cylinder: &OnCylinder, plane: &OnPlane) -> Layout {
    let angle = ANGLE_DEG.to_radians();
    let normal = Unit::new_unchecked(Vector3::new(-angle.sin(), 0.0, angle.cos()));
    let (e1, e2) = perpendiculars(&normal);
    let on_cylinder = cylinder.iter().map(|(turn, height)| {
        let (sin, cos) = turn.to_radians().sin_cos();
        (0, Point3::new(cos, sin, *height) * RADIUS)
    });
    let on_plane = plane.iter().map(|(a, b)| (1, Point3::from((e1 * *a + e2 * *b) * RADIUS)));
    on_cylinder.chain(on_plane).collect()
}

/// The parent's own, axes along those of the parent, and anywhere.
fn frames() -> Vec<Frame> {
    let quarter = Rotation3::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
    let axes_swapped = Frame { rotation: quarter, origin: Point3::new(100.0, -200.0, 50.0) };
    let anywhere = (0..3).map(|k| random_frame(1000.0, &mut generator(61, k)));
    [Frame::identity(), axes_swapped].into_iter().chain(anywhere).collect()
}

fn touches(case: &Case, frame: &Frame, noise: f64, trial: u64) -> Vec<Touch> {
    let contacts = layout(&case.cylinder, &case.plane);
    simulate(&*fixture(), &contacts, frame, &probe(None), noise, &mut generator(62, trial))
}

fn solve(touches: &[Touch], sigma: Option<f64>) -> Result<Solution, SolveError> {
    let fixture = fixture();
    let problem = Problem::new(&*fixture, touches, probe(sigma)).unwrap();
    support::solver("closed-form").solve(&problem)
}

/// A twist about the frame's origin along the parent's axes, its rotation times the radius.
type Scaled = Vector6<f64>;

fn scaled(motion: &Motion, frame: &Frame) -> Scaled {
    let w = motion.twist.rotation;
    let v = motion.twist.translation + w.cross(&(frame.origin - motion.about));
    Scaled::new(v.x, v.y, v.z, w.x * RADIUS, w.y * RADIUS, w.z * RADIUS)
}

/// The motions that none of these touches resists when the fixture stands at `frame` and its radius is free: an
/// orthonormal basis of the null space of the rows `[normal, p x normal, radius]`, the radius left out.
fn free_motions(contacts: &[(usize, Point3<f64>)], frame: &Frame) -> Vec<Scaled> {
    /// The smallest singular value of a layout that is degenerate in exact arithmetic, in parts of the largest.
    const ROUNDING: f64 = 1e-12;
    let fixture = fixture();
    let mut rows = DMatrix::zeros(contacts.len().max(7), 7);
    for (index, (surface, contact)) in contacts.iter().enumerate() {
        let normal = frame.rotation * fixture.surfaces()[*surface].seen_from(contact).normal;
        let turn = (frame.rotation * contact.coords).cross(&normal) / RADIUS;
        let radius = if *surface == 0 { 1.0 } else { 0.0 };
        let row = [normal.x, normal.y, normal.z, turn.x, turn.y, turn.z, radius];
        rows.row_mut(index).copy_from_slice(&row);
    }
    let svd = rows.svd(false, true);
    let v_t = svd.v_t.unwrap();
    let largest = svd.singular_values.max();
    let free = (0..7).filter(|k| svd.singular_values[*k] < ROUNDING * largest);
    let free: Vec<_> = free.map(|k| v_t.row(k).columns(0, 6).transpose()).collect();
    if free.is_empty() {
        return Vec::new();
    }
    // Without the radius the columns are no longer orthonormal.
    let basis = DMatrix::from_columns(&free).qr().q();
    basis.column_iter().map(|column| Scaled::from_iterator(column.iter().copied())).collect()
}

/// Angle between a motion and the space of free ones, in degrees.
fn off_by(motion: &Scaled, free: &[Scaled]) -> f64 {
    let within: Scaled = free.iter().map(|basis| basis * basis.dot(motion)).sum();
    (motion - within).norm().atan2(within.norm()).to_degrees()
}

/// The table is what its names say: by an SVD, without the library's solvers.
#[test]
fn the_layouts_are_what_they_are_called() {
    let free = |case: &Case| free_motions(&layout(&case.cylinder, &case.plane), &Frame::identity());
    for case in &SOUND {
        assert!(free(case).is_empty(), "{}", case.name);
    }
    for case in &DEGENERATE {
        let motions = free(case);
        assert!(!motions.is_empty(), "{}", case.name);
        if case.words.contains(&"slide along") {
            let slides = motions.iter().all(|motion| motion.fixed_rows::<3>(3).norm() < 1e-9);
            assert!(slides, "{}: not a slide: {motions:?}", case.name);
        }
    }
}

/// Exact touches: `degenerate`, and the motion that is told is one that no touch resists, in numbers and in words.
fn assert_refused_for_the_right_motion(name: &str) {
    /// Degrees. A double root is placed to 1e-8, far below this.
    const RIGHT: f64 = 1.0;
    let case = DEGENERATE.iter().find(|case| case.name == name).unwrap();
    for frame in frames() {
        for sigma in [Some(SIGMA), None] {
            let refusal = match solve(&touches(case, &frame, 0.0, 0), sigma) {
                Ok(solution) => panic!("{name}, sigma {sigma:?}: accepted, {:?}", solution.trust),
                Err(refusal) => refusal,
            };
            let SolveError::Degenerate(degenerate) = &refusal else {
                panic!("{name}, sigma {sigma:?}: refused as `{}`: {refusal}", refusal.code())
            };
            let told = degenerate.free.to_string();
            let mut contacts = layout(&case.cylinder, &case.plane);
            // Where the words say that a surface turns by itself, its own touches are all that could resist.
            let of = |name: &str| told.contains(&format!("rotation of `{name}`"));
            if let Some(alone) = fixture().surfaces().iter().position(|surface| of(&surface.name)) {
                contacts.retain(|(surface, _)| *surface == alone);
            }
            let off = if case.name == "two cylinder touches coincident" {
                // Three touches are met by a cylinder of every direction, and by several of the known radius: only
                // the direction of the turn is common to all.
                let normal = frame.rotation * fixture().surfaces()[1].seen_from(&Point3::origin()).normal;
                degenerate.free.twist.rotation.cross(&normal).norm().asin().to_degrees()
            } else {
                off_by(&scaled(&degenerate.free, &frame), &free_motions(&contacts, &frame))
            };
            assert!(off < RIGHT, "{name}, sigma {sigma:?}: `{told}` is {off:.2} degrees from a free motion");
            for word in case.words {
                assert!(told.contains(word), "{name}, sigma {sigma:?}: {word} is not in `{told}`");
            }
            assert!(degenerate.rank < degenerate.unknowns, "{name}: {degenerate:?}");
            let Twist { translation, rotation } = degenerate.free.twist;
            assert!(translation.norm() + rotation.norm() > 0.0, "{name}: `{told}` is no motion");
        }
    }
}

macro_rules! exact {
    ($($test:ident: $name:literal,)*) => {
        mod exact {
            $(#[test]
            fn $test() {
                super::assert_refused_for_the_right_motion($name);
            })*
        }
    };
}
exact! {
    plane_touches_in_a_line: "plane touches in a line",
    two_plane_touches_coincident: "two plane touches coincident",
    two_cylinder_touches_coincident: "two cylinder touches coincident",
    ring_of_four: "ring of four",
    one_generator_line: "one generator line",
    two_opposed_pairs_at_two_heights: "two opposed pairs at two heights",
    two_opposed_pairs_one_above_the_other: "two opposed pairs, one above the other",
    low_high_low_high: "low-high-low-high at 90 degrees",
    everything_in_one_point: "everything in one point",
}

/// The weak motion in words, where a refusal tells one.
fn weak_motion(refusal: &SolveError) -> Option<String> {
    match refusal {
        SolveError::Degenerate(degenerate) => Some(degenerate.free.to_string()),
        other => Some(other.refusal()?.observability.as_ref()?.weakest.to_string()),
    }
}

/// Every degenerate layout with a micrometre of noise, at every frame; tells how often which verdict came.
fn noisy_outcomes(sigma: Option<f64>) -> Vec<(&'static str, Result<Solution, SolveError>)> {
    const DRAWS: u64 = 40;
    let settings: Vec<(&Case, Frame)> =
        DEGENERATE.iter().flat_map(|case| frames().into_iter().map(move |frame| (case, frame))).collect();
    let outcomes: Vec<_> = settings
        .into_par_iter()
        .flat_map_iter(|(case, frame)| {
            (0..DRAWS).map(move |draw| (case.name, solve(&touches(case, &frame, SIGMA, draw), sigma)))
        })
        .collect();
    let mut verdicts: BTreeMap<(&str, &str), u64> = BTreeMap::new();
    for (name, outcome) in &outcomes {
        let code = outcome.as_ref().err().map_or("accepted", SolveError::code);
        *verdicts.entry((name, code)).or_default() += 1;
    }
    for ((name, code), count) in &verdicts {
        println!("{name}, sigma {sigma:?}: {code} {count}");
    }
    outcomes
}

fn assert_tells_the_weak_motion(name: &str, refusal: &SolveError) {
    let told = weak_motion(refusal);
    assert!(told.is_some_and(|words| !words.is_empty()), "{name}: `{}`, {refusal}", refusal.code());
}

/// A micrometre of noise makes every layout regular; none may pass for it, and each refusal tells the weak motion.
#[test]
fn noise_does_not_make_a_layout_sound() {
    for (name, outcome) in noisy_outcomes(Some(SIGMA)) {
        match outcome {
            Ok(solution) => panic!("{name}: accepted, {:?}", solution.trust),
            Err(refusal) => assert_tells_the_weak_motion(name, &refusal),
        }
    }
}

/// Without a sigma an answer is conditional: a frame may stand for touches far better than these were, and says so.
#[test]
fn noise_that_is_not_stated_is_not_covered_by_the_answer() {
    for (name, outcome) in noisy_outcomes(None) {
        match outcome {
            Ok(solution) => {
                let trust = &solution.trust;
                println!("{name}: stands from {:e} to {:e}", trust.from_sigma, trust.up_to_sigma);
                assert!(trust.up_to_sigma < SIGMA, "{name}: {trust:?}");
            }
            Err(refusal) => assert_tells_the_weak_motion(name, &refusal),
        }
    }
}

/// The rule does not refuse everything.
#[test]
fn sound_layouts_are_accepted() {
    const DRAWS: u64 = 20;
    let settings = SOUND.iter().flat_map(|case| frames().into_iter().map(move |frame| (case, frame)));
    for (case, frame) in settings {
        for (sigma, noise) in [(Some(SIGMA), 0.0), (Some(SIGMA), SIGMA), (None, 0.0), (None, SIGMA)] {
            for draw in 0..DRAWS {
                let outcome = solve(&touches(case, &frame, noise, draw), sigma);
                let solution =
                    outcome.unwrap_or_else(|e| panic!("{}, noise {noise}, draw {draw}: {e}", case.name));
                assert!(solution.trust.up_to_sigma > SIGMA, "{}: {:?}", case.name, solution.trust);
            }
        }
    }
}

/// Squared error of a frame in its own stated covariance: chi-square with six degrees of freedom.
fn squared_error(solution: &Solution, truth: &Frame) -> f64 {
    let twist = solution.frame.twist_to(truth);
    let turn = |v: Vector3<f64>| solution.frame.rotation * v;
    let (t, w) = (turn(twist.translation), turn(twist.rotation));
    let error = Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z);
    error.dot(&solution.covariance.unwrap().matrix.cholesky().unwrap().solve(&error))
}

/// A ring of four of which one touch is moved along the axis by each of 49 steps from 1e-12 to 1 radius.
fn off_the_ring() -> impl Iterator<Item = (f64, Case)> {
    const STEPS: i32 = 48;
    (0..=STEPS).map(|step| {
        let off = 10.0_f64.powf(-12.0 * f64::from(STEPS - step) / f64::from(STEPS));
        let ring = [(10.0, -3.0), (95.0, -3.0), (190.0, -3.0), (285.0, -3.0 + off)];
        (off, Case { name: "off the ring", cylinder: ring, plane: SOUND_PLANE, words: &[] })
    })
}

/// Exact touches: refused, and from some step on accepted, with the sigma stated.
#[test]
fn a_ring_is_refused_until_one_touch_leaves_it_far_enough() {
    for frame in frames() {
        let mut accepted_from = None;
        for (off, case) in off_the_ring() {
            let outcome = solve(&touches(&case, &frame, 0.0, 0), Some(SIGMA));
            match (&outcome, accepted_from) {
                (Ok(_), None) => accepted_from = Some(off),
                (Err(refusal), Some(from)) => panic!("accepted from {from:e}, but at {off:e}: {refusal}"),
                _ => {}
            }
        }
        let from = accepted_from.unwrap_or_else(|| panic!("never accepted"));
        println!("one touch off the ring: accepted from {from:.1e} of the radius");
        // Below 50 sigma the touch cannot be told to be off the ring; a whole radius is a sound layout.
        assert!(from > 50.0 * SIGMA / RADIUS, "accepted from {from:e}");
    }
}

/// With noise the verdict may come at another step, but no accepted frame is outside its own uncertainty.
#[test]
fn near_a_ring_no_accepted_frame_is_outside_its_own_uncertainty() {
    const DRAWS: u64 = 40;
    let level = chi_square_level(1e-9, 6);
    let cases: Vec<(f64, Case)> = off_the_ring().collect();
    let squared_errors: Vec<f64> = cases
        .par_iter()
        .flat_map_iter(|(off, case)| {
            (0..DRAWS).filter_map(move |draw| {
                let frame = random_frame(1000.0, &mut generator(63, draw));
                let solution = solve(&touches(case, &frame, SIGMA, draw), Some(SIGMA)).ok()?;
                let squared = squared_error(&solution, &frame);
                assert!(squared < level, "{off:e} off the ring, draw {draw}: squared error {squared}");
                Some(squared)
            })
        })
        .collect();
    let count = squared_errors.len() as f64;
    let mean = squared_errors.iter().sum::<f64>() / count;
    println!("{count} accepted, mean squared error {mean:.2}");
    assert!(count > 0.0);
    // Three standard deviations of the mean of as many draws of chi-square.
    assert!((mean - 6.0).abs() < 3.0 * (12.0 / count).sqrt(), "{mean}");
}

/// A ring of four turns about the line along the plane's normal through the ring's centre: no SVD needed.
#[test]
fn the_motion_of_a_ring_is_told_where_it_is() {
    let case = DEGENERATE.iter().find(|case| case.name == "ring of four").unwrap();
    let frame = random_frame(1000.0, &mut generator(64, 0));
    let Err(SolveError::Degenerate(degenerate)) = solve(&touches(case, &frame, 0.0, 0), Some(SIGMA)) else {
        panic!("a ring of four is degenerate");
    };
    let angle = ANGLE_DEG.to_radians();
    let normal = frame.rotation * Vector3::new(-angle.sin(), 0.0, angle.cos());
    let center = frame.to_parent(&Point3::new(0.0, 0.0, -3.0 * RADIUS));
    let twist = Twist { translation: Vector3::zeros(), rotation: normal };
    let expected = scaled(&Motion::new(twist, center), &frame);
    let told = scaled(&degenerate.free, &frame);
    assert!(off_by(&told, &[expected.normalize()]) < 1.0, "{}", degenerate.free);
}

/// Four touches all but on one generator line, and noise so small that every step along what is free is above it: told as
/// the turn that it is, not as what a descent along it ends at.
#[test]
fn touches_nearly_on_one_generator_are_told() {
    const QUIET: f64 = 1e-10;
    for (off, frame) in [1e-12, 1e-10, 1e-8]
        .into_iter()
        .flat_map(|off: f64| frames().into_iter().map(move |frame| (off, frame)))
    {
        let turned = |by: f64| 50.0 + (by * off).to_degrees();
        let generator_line =
            [(turned(0.0), -4.0), (turned(1.0), -3.2), (turned(-1.0), -2.1), (turned(0.0), -1.5)];
        let case =
            Case { name: "nearly one generator", cylinder: generator_line, plane: SOUND_PLANE, words: &[] };
        let touches = touches(&case, &frame, 0.0, 0);
        let fixture = fixture();
        let problem = Problem::new(&*fixture, &touches, probe(Some(QUIET))).unwrap();
        for solver in ["closed-form", "least-squares"] {
            match support::solver(solver).solve(&problem) {
                Err(SolveError::Degenerate(degenerate)) => {
                    let told = &degenerate.free;
                    assert!(told.to_string().contains("rotation of `cylinder`"), "{solver}, {off:e}: {told}");
                    let off_axis = told.twist.rotation.cross(&frame.axis(2)).norm();
                    assert!(off_axis < 1e-6, "{solver}, {off:e}: {told}");
                }
                other => panic!("{solver}, {off:e}: {other:?}"),
            }
        }
    }
}

/// As with three touches, so with more: a line through all of them does not tell a plane.
#[test]
fn four_plane_touches_in_a_line_are_refused() {
    let case = DEGENERATE.iter().find(|case| case.name == "plane touches in a line").unwrap();
    for frame in frames() {
        for sigma in [Some(SIGMA), None] {
            let mut four = touches(case, &frame, 0.0, 0);
            let (last, next) = (four[6], four[5]);
            four.push(Touch { at: last.at + (last.at - next.at) * 0.5, ..last });
            let outcome = solve(&four, sigma);
            let code = outcome.as_ref().err().map(SolveError::code);
            assert_eq!(code, Some("degenerate"), "sigma {sigma:?}: {outcome:?}");
        }
    }
}
