//! `three-sphere` held against methods that share no code with it: centres by barycentric coordinates, minima by a
//! brute-force search; and what must hold whatever the order, the parent, the unit or the names of the balls.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use allocation_counter::measure;
use nalgebra::{Matrix6, Point3, Rotation3, Vector3, Vector6};
use rand::{Rng, RngExt, seq::SliceRandom};
use rand_distr::StandardNormal;
use rayon::prelude::*;
use touchref::{
    Extent, Fixture, Frame, Parameters, Probe, Problem, Root, RootKind, Shape, SolveError, Touch, Value,
    analysis::{
        Study, StudyLayout,
        simulation::{generator, random_frame, random_layout, simulate},
    },
};

const RADIUS: f64 = 12.7;
/// `ab`, `bc`, `ca`.
const SIDES: [f64; 3] = [110.0, 95.0, 100.0];
const TIP_RADIUS: f64 = 1.5;
const SIGMA: f64 = 0.01;
/// How far the parent's origin may be.
const REACH: f64 = 1000.0;
/// The squared misfit that the true frame of nine touches, three more than unknowns, exceeds with a chance of 1e-6.
const LEVEL: f64 = 30.66;

fn three_sphere(sides: [f64; 3], radii: impl Into<Value>) -> Box<dyn Fixture> {
    let radii = radii.into();
    let [ab, bc, ca] = sides;
    let mut parameters = Parameters::new().with("ab", ab).with("bc", bc).with("ca", ca);
    parameters.set(if matches!(radii, Value::Numbers(_)) { "radii" } else { "radius" }, radii);
    support::fixture("three-sphere", &parameters)
}

fn probe(sigma: Option<f64>) -> Probe {
    Probe { tip_radius: TIP_RADIUS, sigma, ..Probe::default() }
}

/// Touches at random places of the caps, and the true frame.
fn random_touches(fixture: &dyn Fixture, counts: [usize; 3], sigma: f64, trial: u64) -> (Vec<Touch>, Frame) {
    let mut rng = generator(31, trial);
    let layout = random_layout(fixture, &counts, &mut rng);
    let truth = random_frame(REACH, &mut rng);
    (simulate(fixture, &layout, &truth, &probe(None), sigma, &mut rng), truth)
}

fn roots_of(fixture: &dyn Fixture, touches: &[Touch], probe: Probe) -> Result<Vec<Root>, SolveError> {
    let problem = Problem::new(fixture, touches, probe).unwrap();
    let mut roots = Vec::new();
    fixture.closed_form().unwrap().roots(&problem, &mut |root| roots.push(root))?;
    Ok(roots)
}

/// Candidates, and the noise up to which they claim to be all.
fn candidates_of(problem: &Problem<'_>, noise: f64) -> Result<(Vec<Frame>, f64), SolveError> {
    let mut frames = Vec::new();
    let closed_form = problem.fixture().closed_form().unwrap();
    let complete = closed_form.candidates(problem, noise, &mut |frame| frames.push(frame))?;
    Ok((frames, complete))
}

/// Centre and radius of each ball in fixture coordinates.
fn balls(fixture: &dyn Fixture) -> [(Point3<f64>, f64); 3] {
    [0, 1, 2].map(|ball| match fixture.surfaces()[ball].shape {
        Shape::Sphere { center, radius, .. } => (center, radius),
        ref other => panic!("{other:?}"),
    })
}

/// How far apart two frames are: the largest distance between their places of a ball.
fn apart(fixture: &dyn Fixture, one: &Frame, other: &Frame) -> f64 {
    let off = |(center, _): (Point3<f64>, f64)| (one.to_parent(&center) - other.to_parent(&center)).norm();
    balls(fixture).map(off).into_iter().fold(0.0, f64::max)
}

/// The two centres of a sphere of this radius through three points: the circle's centre by barycentric coordinates, its
/// radius by Heron's formula. `None` when the circle is larger.
fn centers_through(radius: f64, points: &[Point3<f64>]) -> Option<[Point3<f64>; 2]> {
    let [p, q, r] = points else { panic!("{} points", points.len()) };
    let [a, b, c] = [q - r, r - p, p - q].map(|edge| edge.norm());
    let weight = |a: f64, b: f64, c: f64| a * a * (b * b + c * c - a * a);
    let [u, v, w] = [weight(a, b, c), weight(b, c, a), weight(c, a, b)];
    let foot = Point3::from((p.coords * u + q.coords * v + r.coords * w) / (u + v + w));
    let half = 0.5 * (a + b + c);
    let area = (half * (half - a) * (half - b) * (half - c)).sqrt();
    let circle = a * b * c / (4.0 * area);
    let height = (radius * radius - circle * circle).sqrt();
    let up = (q - p).cross(&(r - p)).normalize() * height;
    (!height.is_nan()).then(|| [foot + up, foot - up])
}

fn on_ball(touches: &[Touch], ball: usize) -> Vec<Point3<f64>> {
    touches.iter().filter(|touch| touch.surface == ball).map(|touch| touch.at).collect()
}

/// Every combination of centres, computed independently, is a root with its own distances, and nothing else is; the
/// true frame is among them.
#[test]
fn the_roots_are_the_eight_combinations_of_centres() {
    const TRIALS: u64 = 20_000;
    /// Coordinates of 1000 round to 1e-13; a centre amplifies that by the radius over its height above the touches'
    /// plane and over the height of their triangle, the heights of which are seldom below a hundredth of the radius.
    const ROUNDING: f64 = 1e-13 * 100.0;
    let fixture = three_sphere(SIDES, [12.7, 10.0, 15.0]);
    let radii = balls(&*fixture).map(|(_, radius)| radius + TIP_RADIUS);
    let mut errors: Vec<f64> = (0..TRIALS)
        .into_par_iter()
        .map(|trial| {
            let (touches, truth) = random_touches(&*fixture, [3; 3], 0.0, trial);
            let roots = roots_of(&*fixture, &touches, probe(None)).unwrap();
            let centers = [0, 1, 2].map(|ball| centers_through(radii[ball], &on_ball(&touches, ball)));
            let [Some(a), Some(b), Some(c)] = centers else {
                // A great circle, to rounding.
                assert!(roots.iter().any(|root| root.kind == RootKind::NearMiss) || roots.len() == 8);
                return 0.0;
            };
            let flat = |[one, other]: &[Point3<f64>; 2], radius: f64| (one - other).norm() < 0.02 * radius;
            if flat(&a, radii[0]) || flat(&b, radii[1]) || flat(&c, radii[2]) {
                return 0.0;
            }
            assert_eq!(roots.len(), 8, "trial {trial}");
            let mut worst: f64 = 0.0;
            for combination in 0..8 {
                let (a, b, c) = (a[combination & 1], b[combination >> 1 & 1], c[combination >> 2]);
                let sides = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
                let off = |root: &&Root| {
                    let x = (b - a).normalize();
                    let z = x.cross(&(c - a)).normalize();
                    let turned = (root.frame.axis(0) - x).norm() + (root.frame.axis(2) - z).norm();
                    let measured: f64 = sides.iter().zip(root.measures).map(|(s, m)| (s - m).abs()).sum();
                    (root.frame.origin - a).norm() + 100.0 * turned + measured
                };
                let near = roots.iter().min_by(|one, other| off(one).total_cmp(&off(other))).unwrap();
                assert_eq!(near.kind, RootKind::Real);
                worst = worst.max(off(&near));
            }
            let nearest =
                roots.iter().map(|root| apart(&*fixture, &root.frame, &truth)).fold(f64::INFINITY, f64::min);
            worst.max(nearest)
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    let at = |part: usize| errors[(errors.len() - 1) * part / 1000];
    println!("errors: median {:.1e}, 99 % {:.1e}, largest {:.1e}", at(500), at(990), at(1000));
    assert!(at(500) < ROUNDING && at(990) < 100.0 * ROUNDING && at(1000) < 1e-5);
}

/// One combination only has the known distances: the others miss one of them by millimetres.
#[test]
fn the_nominal_layout_has_one_frame() {
    /// Part of the radius by which some distance of every other combination is off.
    const CLEARLY: f64 = 0.3;
    let fixtures = [
        three_sphere(SIDES, RADIUS),
        three_sphere([100.0; 3], RADIUS),
        three_sphere([20.0; 3], 20.0),
        three_sphere([300.0, 160.0, 200.0], 25.4),
        three_sphere([40.0, 45.0, 50.0], [10.0, 12.0, 14.0]),
    ];
    for fixture in &fixtures {
        let sides: Vec<f64> = fixture.dimensions()[..3].iter().map(|dimension| dimension.value).collect();
        let truth = random_frame(REACH, &mut generator(32, 0));
        let contacts = fixture.nominal_layout();
        for (surface, contact) in &contacts {
            let Extent::Cap { axis, half_angle } = fixture.surfaces()[*surface].extent else {
                panic!("no cap")
            };
            let out = fixture.surfaces()[*surface].seen_from(contact).normal;
            assert!(
                axis.angle(&out) < half_angle + 1e-9 && out.z > 0.0,
                "a probe from above reaches {contact}"
            );
        }
        let touches = simulate(&**fixture, &contacts, &truth, &probe(None), 0.0, &mut generator(32, 1));
        let roots = roots_of(&**fixture, &touches, probe(None)).unwrap();
        let off =
            |root: &Root| root.measures.iter().zip(&sides).map(|(m, s)| (m - s).abs()).fold(0.0, f64::max);
        let mut offs: Vec<f64> = roots.iter().map(off).collect();
        offs.sort_by(f64::total_cmp);
        println!("{sides:?}: the combinations miss a distance by {offs:.2?}");
        assert!(offs[0] < 1e-9 && offs[1] > CLEARLY * RADIUS, "{offs:?}");
    }
}

/// Nothing but the chance that sound touches are called inconsistent refuses the nominal layout, and the frame is true.
#[test]
fn the_nominal_layout_is_accepted() {
    const TRIALS: u64 = 5_000;
    let (fixture, solver) = (three_sphere(SIDES, RADIUS), support::solver("closed-form"));
    let layout = StudyLayout::Fixed(fixture.nominal_layout());
    let (fixture, solver, probe) = (&*fixture, &*solver, probe(Some(SIGMA)));
    let plugin = &touchref::fixtures::three_sphere::PLUGIN;
    let study = Study { fixture, plugin, solver, layout, probe, reach: REACH, seed: 33, trials: TRIALS };
    let outcome = study.run().unwrap();
    let nees = outcome.nees_mean().unwrap();
    println!("accepted {}, refused {:?}, NEES {nees}", outcome.accepted, outcome.refused);
    let inconsistent = outcome.refused.get("inconsistent").copied().unwrap_or(0);
    assert_eq!(outcome.accepted + inconsistent, TRIALS);
    // One in a thousand is expected; five standard deviations more.
    assert!(inconsistent < 17, "{inconsistent}");
    assert_eq!(outcome.wrong, 0);
    // Three standard deviations of the mean of chi-square with six degrees of freedom, and 0.05 for what acceptance cuts.
    assert!((nees.value - 6.0).abs() < 3.0 * (12.0 / TRIALS as f64).sqrt() + 0.05);
}

/// Whatever the layout: no accepted frame is wrong, and labels that are right are never called mixed up.
#[test]
fn random_layouts_are_right_or_refused() {
    const TRIALS: u64 = 10_000;
    /// Parts accepted: three touches near a great circle, or near each other, do not tell a centre by themselves, as the
    /// closed form wants it; five seldom lie so.
    const ACCEPTED: [(usize, f64); 2] = [(3, 0.60), (5, 0.98)];
    let (fixture, solver) = (three_sphere(SIDES, RADIUS), support::solver("closed-form"));
    for (touches, accepted) in ACCEPTED {
        let (fixture, solver, probe) = (&*fixture, &*solver, probe(Some(SIGMA)));
        let layout = StudyLayout::Random(vec![touches; 3]);
        let plugin = &touchref::fixtures::three_sphere::PLUGIN;
        let study = Study { fixture, plugin, solver, layout, probe, reach: REACH, seed: 34, trials: TRIALS };
        let outcome = study.run().unwrap();
        println!("{touches} touches each: accepted {}, refused {:?}", outcome.accepted, outcome.refused);
        assert_eq!(outcome.wrong, 0);
        assert!(outcome.accepted as f64 > accepted * TRIALS as f64);
        assert!(!outcome.refused.contains_key("invalid-input"), "{:?}", outcome.refused);
    }
}

/// Descends from a frame by Levenberg and Marquardt's steps, on the distances of the tip centres from the balls' centres:
/// the squared misfit where it ends, that frame, and the square root of the information there.
fn descend(
    fixture: &dyn Fixture,
    touches: &[Touch],
    sigma: f64,
    start: &Frame,
) -> (f64, Frame, Matrix6<f64>) {
    const STEPS: usize = 400;
    let balls = balls(fixture);
    let normal = |frame: &Frame| {
        let (mut matrix, mut gradient, mut square) = (Matrix6::zeros(), Vector6::zeros(), 0.0);
        for touch in touches {
            let (center, radius) = balls[touch.surface];
            let arm = frame.rotation * center.coords;
            let from_center = touch.at - frame.origin - arm;
            let out = from_center.normalize();
            let turn = arm.cross(&out);
            let row = -Vector6::new(out.x, out.y, out.z, turn.x, turn.y, turn.z) / sigma;
            let residual = (from_center.norm() - radius - TIP_RADIUS) / sigma;
            matrix += row * row.transpose();
            gradient += row * residual;
            square += residual * residual;
        }
        (matrix, gradient, square)
    };
    let moved = |frame: &Frame, step: &Vector6<f64>| Frame {
        origin: frame.origin + step.fixed_rows::<3>(0),
        rotation: Rotation3::new(step.fixed_rows::<3>(3).into_owned()) * frame.rotation,
    };
    let (mut frame, mut damping) = (*start, 1e-3);
    let mut here = normal(&frame);
    for _ in 0..STEPS {
        let damped = here.0 + Matrix6::from_diagonal(&here.0.diagonal()) * damping;
        let Some(cholesky) = damped.cholesky() else { break };
        let step = -cholesky.solve(&here.1);
        let next = moved(&frame, &step);
        let there = normal(&next);
        if there.2 <= here.2 {
            // A step of a millionth of a standard deviation is the last.
            let last = step.dot(&(here.0 * step)) < 1e-12;
            (frame, here, damping) = (next, there, damping * 0.2);
            if last {
                break;
            }
        } else {
            damping *= 8.0;
        }
    }
    (here.2, frame, here.0)
}

/// A brute-force search from the roots and from all around them finds no minimum that the candidates do not lead to,
/// where these claim to be all.
#[test]
fn candidates_lead_to_every_minimum() {
    const TRIALS: u64 = 1_500;
    const STARTS: usize = 40;
    /// Five times the noise for which the fixture is meant: more layouts are weak.
    const SIGMA: f64 = 0.05;
    /// Minima nearer than this, in standard deviations, are one.
    const SAME: f64 = 0.1;
    let fixture = three_sphere(SIDES, RADIUS);
    let counts: Vec<(usize, usize, bool)> = (0..TRIALS)
        .into_par_iter()
        .map(|trial| {
            let (touches, truth) = random_touches(&*fixture, [3; 3], SIGMA, trial);
            let problem = Problem::new(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
            let Ok((candidates, complete_up_to)) = candidates_of(&problem, 1.0) else { return (0, 0, false) };
            if complete_up_to <= 1.0 {
                return (0, 0, false);
            }
            let reached: Vec<Frame> =
                candidates.iter().map(|frame| descend(&*fixture, &touches, SIGMA, frame).1).collect();
            let mut rng = generator(35, trial);
            let mut centers = vec![truth];
            centers.extend(roots_of(&*fixture, &touches, probe(None)).unwrap().iter().map(|root| root.frame));
            let mut missed = 0;
            for k in 0..STARTS {
                let from = &centers[k % centers.len()];
                let start = if k < centers.len() { *from } else { jolted(from, &mut rng) };
                let (misfit, frame, information) = descend(&*fixture, &touches, SIGMA, &start);
                let known = reached.iter().any(|other| {
                    let off = Vector6::from(frame.error_to(other));
                    off.dot(&(information * off)).sqrt() < SAME
                });
                missed += usize::from(misfit < LEVEL && !known);
            }
            (candidates.len(), missed, true)
        })
        .collect();
    let claimed = counts.iter().filter(|(.., claimed)| *claimed).count();
    let missing = counts.iter().filter(|(_, missed, _)| *missed > 0).count();
    let candidates: usize = counts.iter().map(|(candidates, ..)| candidates).sum();
    println!(
        "{claimed} of {TRIALS} searches claim to be complete, {candidates} candidates; {missing} miss a minimum"
    );
    assert!(claimed as u64 > TRIALS * 95 / 100);
    assert_eq!(missing, 0);
}

/// A frame moved by anything from a hundredth of a millimetre to the size of the balls.
fn jolted(frame: &Frame, rng: &mut impl Rng) -> Frame {
    let length = 10.0_f64.powf(rng.random_range(-2.0..1.3));
    let mut random =
        || Vector3::from(std::array::from_fn::<f64, 3, _>(|_| rng.sample(StandardNormal))) * length;
    let (slide, turn) = (random(), random() / 60.0);
    Frame { origin: frame.origin + slide, rotation: Rotation3::new(turn) * frame.rotation }
}

/// A ball of which two touches coincide tells nothing of its own centre but a circle; the others place it.
#[test]
fn candidates_do_without_the_centre_of_one_ball() {
    let fixture = three_sphere(SIDES, RADIUS);
    for trial in 0..200 {
        for ball in 0..3 {
            let (mut touches, truth) = random_touches(&*fixture, [3; 3], 0.0, 1000 + trial);
            touches[3 * ball].at = touches[3 * ball + 2].at;
            for sigma in [Some(0.001), None] {
                let problem = Problem::new(&*fixture, &touches, probe(sigma)).unwrap();
                let (frames, _) = candidates_of(&problem, 0.0).unwrap();
                let nearest =
                    frames.iter().map(|frame| apart(&*fixture, frame, &truth)).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-6, "trial {trial}, ball {ball}: {nearest:e}");
            }
        }
    }
}

/// What roots, as a set, are to be: each with its frame, its measures and its kind.
fn assert_same_roots(fixture: &dyn Fixture, got: &[Root], want: &[Root], tolerance: f64) {
    assert_eq!(got.len(), want.len());
    for want in want {
        let off = |root: &Root| {
            let measured =
                root.measures.iter().zip(want.measures).map(|(g, w)| (g - w).abs()).fold(0.0, f64::max);
            apart(fixture, &root.frame, &want.frame) + measured
        };
        let near = got.iter().min_by(|one, other| off(one).total_cmp(&off(other))).unwrap();
        assert!(off(near) < tolerance && near.kind == want.kind, "{want:?}\n{near:?}");
    }
}

/// Coordinates up to 3000 round to 5e-13; the weaker places of touches on a ball amplify that some thousand times.
const SAME: f64 = 1e-8;

/// Touches of the nominal layout with noise, one or two more on each ball.
fn measurement(fixture: &dyn Fixture, trial: u64) -> Vec<Touch> {
    let mut rng = generator(36, trial);
    let mut layout = fixture.nominal_layout();
    if trial % 2 == 1 {
        layout.extend(random_layout(fixture, &[1, 2, 1], &mut rng));
    }
    let truth = random_frame(REACH, &mut rng);
    simulate(fixture, &layout, &truth, &probe(None), SIGMA, &mut rng)
}

#[test]
fn the_order_of_touches_changes_nothing() {
    let fixture = three_sphere(SIDES, RADIUS);
    for trial in 0..40 {
        let touches = measurement(&*fixture, trial);
        let mut shuffled = touches.clone();
        shuffled.shuffle(&mut generator(37, trial));
        let [one, other] = [&touches, &shuffled].map(|t| roots_of(&*fixture, t, probe(Some(SIGMA))).unwrap());
        assert_same_roots(&*fixture, &other, &one, SAME);
        let [one, other] = [&touches, &shuffled].map(|touches| {
            let problem = Problem::new(&*fixture, touches, probe(Some(SIGMA))).unwrap();
            support::solver("closed-form").solve(&problem).map(|solution| solution.frame)
        });
        match (one, other) {
            (Ok(one), Ok(other)) => assert!(apart(&*fixture, &one, &other) < SAME),
            (one, other) => assert_eq!(one.unwrap_err().code(), other.unwrap_err().code()),
        }
    }
}

#[test]
fn the_frame_moves_with_its_parent() {
    let fixture = three_sphere(SIDES, RADIUS);
    for trial in 0..40 {
        let touches = measurement(&*fixture, trial);
        let motion = random_frame(REACH, &mut generator(38, trial));
        let moved: Vec<Touch> =
            touches.iter().map(|touch| Touch { at: motion.to_parent(&touch.at), ..*touch }).collect();
        let here = roots_of(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
        let there = roots_of(&*fixture, &moved, probe(Some(SIGMA))).unwrap();
        let expected: Vec<Root> =
            here.iter().map(|root| Root { frame: root.frame.seen_from(&motion), ..*root }).collect();
        assert_same_roots(&*fixture, &there, &expected, SAME);
    }
}

#[test]
fn the_unit_scales_lengths_only() {
    let fixture = three_sphere(SIDES, RADIUS);
    for unit in [25.4, 1.0 / 25.4, 1e3, 1e-3] {
        let scaled_fixture = three_sphere(SIDES.map(|side| side * unit), RADIUS * unit);
        for trial in 0..10 {
            let touches = measurement(&*fixture, trial);
            let scaled: Vec<Touch> = touches.iter().map(|t| Touch { at: t.at * unit, ..*t }).collect();
            let scaled_probe = Probe { tip_radius: TIP_RADIUS * unit, ..probe(Some(SIGMA * unit)) };
            let here = roots_of(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
            let there = roots_of(&*scaled_fixture, &scaled, scaled_probe).unwrap();
            let back: Vec<Root> = there
                .iter()
                .map(|root| Root {
                    frame: Frame { origin: root.frame.origin / unit, ..root.frame },
                    measures: root.measures.map(|side| side / unit),
                    ..*root
                })
                .collect();
            assert_same_roots(&*fixture, &back, &here, SAME);

            let counts =
                [(&*fixture, &touches, probe(Some(SIGMA))), (&*scaled_fixture, &scaled, scaled_probe)];
            let [one, other] = counts.map(|(fixture, touches, probe)| {
                let (frames, complete) =
                    candidates_of(&Problem::new(fixture, touches, probe).unwrap(), 1.0).unwrap();
                (frames.len(), complete)
            });
            assert!(one.0 == other.0 && (one.1 / other.1 - 1.0).abs() < 1e-6, "{one:?} {other:?}");
        }
    }
}

/// `a`, `b`, `c` called `b`, `c`, `a`: the frame turns about Z and starts at another ball.
#[test]
fn other_names_of_the_balls_make_another_frame_of_the_same_place() {
    let [ab, bc, ca] = SIDES;
    let fixture = three_sphere(SIDES, [12.7, 10.0, 15.0]);
    // The ball called `a` is now the one that was `b`.
    let renamed = three_sphere([bc, ca, ab], [10.0, 15.0, 12.7]);
    let [a, b, c] = balls(&*fixture).map(|(center, _)| center);
    let between = Frame::from_z_and_x(b, Vector3::z(), c - b).unwrap();
    assert!((between.to_fixture(&a) - balls(&*renamed)[2].0).norm() < SAME);
    for trial in 0..40 {
        let touches = measurement(&*fixture, trial);
        let called: Vec<Touch> =
            touches.iter().map(|touch| Touch { surface: [2, 0, 1][touch.surface], ..*touch }).collect();
        let here = roots_of(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
        let there = roots_of(&*renamed, &called, probe(Some(SIGMA))).unwrap();
        for root in here {
            // Where the root's own distances put its balls.
            let [ab, bc, ca] = root.measures;
            let own = three_sphere([ab, bc, ca], RADIUS);
            let [_, b, c] = balls(&*own).map(|(center, _)| center);
            let frame = Frame::from_z_and_x(b, Vector3::z(), c - b).unwrap().seen_from(&root.frame);
            let off = |other: &Root| {
                let measured =
                    [bc, ca, ab].iter().zip(other.measures).map(|(w, g)| (w - g).abs()).fold(0.0, f64::max);
                apart(&*renamed, &other.frame, &frame) + measured
            };
            let nearest = there.iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(nearest < SAME, "{nearest:e}");
        }
    }
}

/// Only the sum of the radii of ball and tip counts.
#[test]
fn a_tip_makes_the_balls_larger() {
    let by_tip = three_sphere(SIDES, RADIUS);
    let by_ball = three_sphere(SIDES, RADIUS + TIP_RADIUS);
    for trial in 0..20 {
        let (touches, truth) = random_touches(&*by_tip, [3, 4, 3], 0.0, trial);
        let one = roots_of(&*by_tip, &touches, probe(None)).unwrap();
        let other = roots_of(&*by_ball, &touches, Probe::default()).unwrap();
        assert_same_roots(&*by_tip, &other, &one, 1e-6);
        assert!(one.iter().any(|root| apart(&*by_tip, &root.frame, &truth) < 1e-6));
    }
}

#[test]
fn with_more_touches_a_centre_is_unique() {
    /// Coordinates of 1000, and the worst of some layouts.
    const EXACT: f64 = 1e-8;
    let fixture = three_sphere(SIDES, RADIUS);
    let mut unique = 0;
    for trial in 0..200 {
        for counts in [[4; 3], [9, 6, 5]] {
            let (touches, truth) = random_touches(&*fixture, counts, 0.0, trial);
            let roots = roots_of(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
            let nearest =
                roots.iter().map(|root| apart(&*fixture, &root.frame, &truth)).fold(f64::INFINITY, f64::min);
            assert!(nearest < EXACT, "trial {trial}: {nearest:e}");
            unique += u32::from(roots.len() == 1);
        }
    }
    println!("{unique} of 400 layouts have one root");
    // Four touches near a plane, or near each other, still leave two places.
    assert!(unique > 250, "{unique}");

    // Four in one plane: both places, as with three.
    let [(a, _), ..] = balls(&*fixture);
    let mut touches = measurement(&*fixture, 0);
    touches.retain(|touch| touch.surface != 0);
    let ring = (0..4).map(|k| {
        let (sin, cos) = (1.3 * f64::from(k)).sin_cos();
        a + Vector3::new(0.8 * cos, 0.8 * sin, 0.6) * (RADIUS + TIP_RADIUS)
    });
    touches.extend(ring.map(|at| Touch::new(0, at)));
    assert_eq!(roots_of(&*fixture, &touches, probe(Some(SIGMA))).unwrap().len(), 8);
}

/// Touches that noise, or a wrong radius, moved too far from each other for the radius.
#[test]
fn a_circle_larger_than_the_ball_is_a_near_miss() {
    let fixture = three_sphere(SIDES, RADIUS);
    let mut touches = measurement(&*fixture, 0);
    let path = RADIUS + TIP_RADIUS;
    let center = Point3::new(500.0, -200.0, 30.0);
    for (k, touch) in touches.iter_mut().filter(|touch| touch.surface == 1).enumerate() {
        let (sin, cos) = (2.2 * k as f64).sin_cos();
        touch.at = center + Vector3::new(cos, sin, 0.0) * (path + SIGMA);
    }
    let roots = roots_of(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
    assert_eq!(roots.len(), 4);
    for root in roots {
        assert_eq!(root.kind, RootKind::NearMiss);
        let b = root.frame.origin + root.frame.axis(0) * root.measures[0];
        assert!((b - center).norm() < SAME, "{b}");
    }
}

/// A centre that has moved into the plane of its touches is told by the other balls, not by these: the closed form has
/// no root to stand for it and refuses; the candidates lead there.
#[test]
fn touches_on_a_great_circle_are_refused_by_the_closed_form_and_reached_by_the_candidates() {
    let fixture = three_sphere(SIDES, RADIUS);
    for trial in 0..20 {
        let mut layout = fixture.nominal_layout();
        let (center, radius) = balls(&*fixture)[1];
        let mut rng = generator(39, trial);
        let tilt = Rotation3::from_axis_angle(&Vector3::x_axis(), rng.random_range(0.0..1.0));
        for (k, (_, contact)) in layout.iter_mut().filter(|(surface, _)| *surface == 1).enumerate() {
            let (sin, cos) = (0.3 + 1.1 * k as f64).sin_cos();
            *contact = center + tilt * Vector3::new(cos, 0.0, sin) * radius;
        }
        let truth = random_frame(REACH, &mut rng);
        for noise in [0.0, SIGMA] {
            let touches = simulate(&*fixture, &layout, &truth, &probe(None), noise, &mut rng);
            let problem = Problem::new(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
            let refusal = support::solver("closed-form").solve(&problem).unwrap_err();
            assert!(["degenerate", "not-validated", "ambiguous"].contains(&refusal.code()), "{refusal}");
            let (frames, _) = candidates_of(&problem, 1.0).unwrap();
            let ends = frames.iter().map(|frame| descend(&*fixture, &touches, SIGMA, frame));
            let nearest =
                ends.map(|(_, end, _)| apart(&*fixture, &end, &truth)).fold(f64::INFINITY, f64::min);
            // A motion of that ball along the normal of its touches is told by the others to some sigma.
            assert!(nearest < if noise == 0.0 { 1e-3 } else { 100.0 * SIGMA }, "trial {trial}: {nearest}");
        }
    }
}

/// Touches in a line are told with the motion they leave to their ball.
#[test]
fn touches_in_a_line_are_told() {
    let fixture = three_sphere(SIDES, RADIUS);
    let frame = random_frame(REACH, &mut generator(40, 0));
    for (ball, name) in ["a", "b", "c"].into_iter().enumerate() {
        for count in [3, 4] {
            let exact = simulate(
                &*fixture,
                &fixture.nominal_layout(),
                &frame,
                &probe(None),
                0.0,
                &mut generator(40, 1),
            );
            let (one, two) = (exact[3 * ball].at, exact[3 * ball + 1].at);
            let rest: Vec<Touch> = exact.iter().filter(|touch| touch.surface != ball).copied().collect();
            let line = |steps: &[f64]| {
                let places = steps.iter().map(|step| Touch::new(ball, one + (two - one) * *step));
                rest.iter().copied().chain(places).collect::<Vec<_>>()
            };
            let cases = [
                (line(&[0.0, 1.0, 0.4, 0.7][..count]), 2),
                (line(&[0.0, 1.0, 1.0, 0.0][..count]), 2),
                (line(&[0.0, 0.0, 0.0, 0.0][..count]), 1),
            ];
            for (touches, rank) in cases {
                for sigma in [Some(SIGMA), None] {
                    let problem = Problem::new(&*fixture, &touches, probe(sigma)).unwrap();
                    let refusal = support::solver("closed-form").solve(&problem).unwrap_err();
                    let SolveError::Degenerate(degenerate) = &refusal else { panic!("{refusal}") };
                    let words = degenerate.free.to_string();
                    assert!(words.contains(&format!("rotation of `{name}`")), "{words}");
                    assert_eq!((degenerate.rank, degenerate.unknowns), (rank, 3));
                    if rank == 2 {
                        let turn = degenerate.free.twist.rotation;
                        assert!(turn.normalize().cross(&(two - one).normalize()).norm() < 1e-6);
                        let off = (degenerate.free.about - one).cross(&(two - one)).norm();
                        assert!(off < 1e-6, "the axis passes {off} from the touches");
                    }
                    assert!(refusal.help().contains(name), "{}", refusal.help());
                }
            }
        }
    }
}

/// Two balls without a centre of their own leave nothing to hold.
#[test]
fn two_balls_touched_in_a_line_are_degenerate_for_every_solver() {
    let fixture = three_sphere(SIDES, RADIUS);
    let (mut touches, _) = random_touches(&*fixture, [3; 3], 0.0, 0);
    (touches[0].at, touches[3].at) = (touches[1].at, touches[4].at);
    let problem = Problem::new(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
    assert_eq!(candidates_of(&problem, 1.0).unwrap_err().code(), "degenerate");
}

/// Three touches in all but one place leave their ball loose: where the noise is small beside what the misfit bends by
/// then, it says nothing of labels.
#[test]
fn labels_are_not_doubted_where_the_balls_are_loose() {
    const TRIALS: u64 = 50;
    const QUIET: f64 = 1e-10;
    let fixture = three_sphere([100.0, 90.0, 80.0], RADIUS);
    for off in [1e-7, 1e-6, 1e-5, 1e-4] {
        for trial in 0..TRIALS {
            let mut rng = generator(47, trial);
            let frame = random_frame(REACH, &mut rng);
            let mut near_the_top = |ball: usize| {
                let (center, radius) = balls(&*fixture)[ball];
                let aside: [f64; 2] = [(); 2].map(|()| rng.sample(StandardNormal));
                (ball, center + Vector3::new(off * aside[0], off * aside[1], 1.0).normalize() * radius)
            };
            let layout: Vec<_> = (0..9).map(|k| near_the_top(k / 3)).collect();
            let touches = simulate(&*fixture, &layout, &frame, &probe(None), 0.0, &mut rng);
            let problem = Problem::new(&*fixture, &touches, probe(Some(QUIET))).unwrap();
            if let Err(refusal) = support::solver("least-squares").solve(&problem) {
                assert_ne!(refusal.code(), "invalid-input", "{off:e}, trial {trial}: {refusal}");
            }
        }
    }
}

/// Labels that are exchanged are told where the distances, or the radii, tell them apart.
#[test]
fn labels_that_are_mixed_up_are_named() {
    /// Which ball the touches of each label are really on, and what is to be said.
    const EXCHANGED: [([usize; 3], &[&str]); 5] = [
        ([1, 0, 2], &["`a` is called `b`", "`b` is called `a`"]),
        ([2, 1, 0], &["`a` is called `c`", "`c` is called `a`"]),
        ([0, 2, 1], &["`b` is called `c`", "`c` is called `b`"]),
        ([1, 2, 0], &["`a` is called `b`", "`b` is called `c`", "`c` is called `a`"]),
        ([2, 0, 1], &["`a` is called `c`", "`b` is called `a`", "`c` is called `b`"]),
    ];
    let solver = support::solver("closed-form");
    let fixtures = [three_sphere(SIDES, RADIUS), three_sphere([100.0; 3], [12.7, 10.0, 15.0])];
    for fixture in &fixtures {
        for (on, words) in EXCHANGED {
            for trial in 0..20 {
                let right = measurement(&**fixture, trial);
                let label = |ball: usize| on.iter().position(|other| *other == ball).unwrap();
                let touches: Vec<Touch> =
                    right.iter().map(|touch| Touch { surface: label(touch.surface), ..*touch }).collect();
                let problem = Problem::new(&**fixture, &touches, probe(Some(SIGMA)));
                let Ok(problem) = problem else { panic!() };
                if problem.require_enough().is_err() {
                    continue;
                }
                let refusal = solver.solve(&problem).unwrap_err();
                let told = refusal.to_string();
                assert_eq!(refusal.code(), "invalid-input", "{on:?}, trial {trial}: {told}");
                assert!(words.iter().all(|word| told.contains(word)), "{on:?}: {told}");
                let SolveError::InvalidTouches { touches: concerned, .. } = &refusal else {
                    panic!("{told}")
                };
                let moved =
                    touches.iter().enumerate().filter(|(_, touch)| on[touch.surface] != touch.surface);
                let mut concerned = concerned.clone();
                concerned.sort_unstable();
                assert_eq!(concerned, moved.map(|(index, _)| index).collect::<Vec<_>>());
            }
        }
    }
    // Balls that are alike may change places.
    let alike = three_sphere([100.0, 80.0, 100.0], RADIUS);
    let mut touches = measurement(&*alike, 0);
    for touch in &mut touches {
        touch.surface = [0, 2, 1][touch.surface];
    }
    assert!(solver.solve(&Problem::new(&*alike, &touches, probe(Some(SIGMA))).unwrap()).is_ok());
}

/// Balls that fit the fixture in no order are told by what the touches measure.
#[test]
fn distances_that_fit_in_no_order_are_told() {
    let made = three_sphere([110.0, 95.0, 104.0], RADIUS);
    let stated = three_sphere(SIDES, RADIUS);
    let problem_touches = measurement(&*made, 0);
    let problem = Problem::new(&*stated, &problem_touches, probe(Some(SIGMA))).unwrap();
    let refusal = support::solver("closed-form").solve(&problem).unwrap_err();
    assert_eq!(refusal.code(), "inconsistent");
    let told = refusal.to_string();
    assert!(told.contains("want ca 104.") || told.contains("want ca 103.9"), "{told}");
}

/// Sizes that are not exactly known widen what counts as fitting.
#[test]
fn uncertain_sizes_take_part() {
    let u = 0.1;
    let uncertain = |value: f64| Value::Number { value, u };
    let parameters = Parameters::new().with("radius", RADIUS).with("bc", 95.0).with("ca", 100.0);
    let fixture = support::fixture("three-sphere", &parameters.clone().with("ab", uncertain(110.0)));
    let made = support::fixture("three-sphere", &parameters.with("ab", 110.15));
    let solver = support::solver("closed-form");
    for trial in 0..20 {
        let touches = measurement(&*made, 2 * trial);
        let problem = Problem::new(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
        let solution = solver.solve(&problem).unwrap();
        let (measured, root) = (solution.roots[0].measures[0].clone(), &solution.roots[0]);
        assert!(root.selected && (measured.value - 110.15).abs() < 6.0 * measured.u.unwrap());
    }
}

/// Without a sigma the answer is conditional.
#[test]
fn without_a_sigma_the_answer_is_an_interval() {
    let fixture = three_sphere(SIDES, RADIUS);
    for trial in 0..10 {
        let touches = measurement(&*fixture, trial);
        let problem = Problem::new(&*fixture, &touches, probe(None)).unwrap();
        let trust = support::solver("closed-form").solve(&problem).unwrap().trust;
        assert!(trust.from_sigma < 3.0 * SIGMA && trust.up_to_sigma > 5.0 * SIGMA, "{trust:?}");
    }
}

#[test]
fn roots_and_candidates_allocate_nothing() {
    let fixture = three_sphere(SIDES, RADIUS);
    let closed_form = fixture.closed_form().unwrap();
    for trial in 0..200 {
        let counts = if trial % 2 == 0 { [3; 3] } else { [3, 4, 6] };
        let (touches, _) = random_touches(&*fixture, counts, SIGMA, trial);
        let problem = Problem::new(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
        let mut found = 0;
        let allocated = measure(|| {
            closed_form.roots(&problem, &mut |_| found += 1).unwrap();
            for noise in [0.0, 1.0, 20.0] {
                closed_form.candidates(&problem, noise, &mut |_| found += 1).unwrap();
            }
        });
        assert_eq!(allocated.count_total, 0, "trial {trial}");
        assert!(found >= 4, "{found}");
    }
}

#[test]
fn parameters_are_checked_in_words() {
    type Numbers<'a> = &'a [(&'a str, f64)];
    let table: [(Numbers<'_>, &[f64], &str); 9] = [
        (
            &[("radius", 10.0), ("ab", 300.0), ("bc", 120.0), ("ca", 100.0)],
            &[],
            "`ab` is 300.0, `bc` is 120.0 and `ca` is 100.0",
        ),
        (
            &[("radius", 10.0), ("ab", 100.0), ("bc", 250.0), ("ca", 120.0)],
            &[],
            "below the sum of the other two, 220.0",
        ),
        (&[("radius", 10.0), ("ab", 100.0), ("bc", 120.0), ("ca", 220.0)], &[], "too flat"),
        (&[("radius", 10.0), ("ab", 1e-50), ("bc", 1e50), ("ca", 1e50)], &[], "they make"),
        (&[("ab", 100.0), ("bc", 120.0), ("ca", 110.0)], &[], "`radius` is missing"),
        (&[("radius", 10.0), ("ab", 100.0), ("ca", 110.0)], &[], "`bc` is missing"),
        (
            &[("radius", 10.0), ("ab", 100.0), ("bc", 120.0), ("ca", 110.0)],
            &[10.0, 11.0, 12.0],
            "beside `radius`",
        ),
        (&[("ab", 100.0), ("bc", 120.0), ("ca", 110.0)], &[10.0, 11.0], "each > 0"),
        (&[("ab", 100.0), ("bc", 120.0), ("ca", 110.0)], &[10.0, 120.0, 9.0], "lies within"),
    ];
    let registry = touchref::registry().unwrap();
    let plugin = registry.fixture("three-sphere").unwrap();
    for (numbers, radii, message) in table {
        let mut parameters = Parameters::new();
        for (name, value) in numbers {
            parameters = parameters.with(name, *value);
        }
        if !radii.is_empty() {
            parameters.set("radii", Value::Numbers(radii.to_vec()));
        }
        let refused = plugin.build(&parameters).unwrap_err();
        assert!(refused.to_string().contains(message), "{refused}");
    }
}
