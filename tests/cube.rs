//! The closed form of `cube` held against methods that share no code with it: the plane equations by themselves, a
//! search from rotations all over, and the symmetries of the cube; what its labels can get wrong; and how often its
//! frames are right.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use std::collections::BTreeSet;

use allocation_counter::measure;
use nalgebra::{DMatrix, Matrix3, Matrix6, Point3, Rotation3, Vector3, Vector6};
use rand::{Rng, RngExt, seq::SliceRandom};
use rayon::prelude::*;
use touchref::{
    Fixture, Frame, Parameters, Probe, Problem, Root, Solution, SolveError, Touch, Value,
    analysis::{
        Study, StudyLayout, StudyOutcome,
        simulation::{Layout, generator, random_frame, random_layout, simulate},
    },
    statistics::chi_square_level,
};

const EDGE: f64 = 50.0;
const SIGMA: f64 = 0.01;
const TIP_RADIUS: f64 = 1.5;
/// How far the parent's origin may be.
const REACH: f64 = 100.0;

/// Outward direction of each face: axis and sign.
const FACES: [(&str, usize, f64); 6] =
    [("+x", 0, 1.0), ("-x", 0, -1.0), ("+y", 1, 1.0), ("-y", 1, -1.0), ("+z", 2, 1.0), ("-z", 2, -1.0)];

fn cube(edge: impl Into<Value>) -> Box<dyn Fixture> {
    support::fixture("cube", &Parameters::new().with("edge", edge))
}

fn probe(sigma: Option<f64>) -> Probe {
    Probe { tip_radius: TIP_RADIUS, sigma, ..Probe::default() }
}

fn solve(fixture: &dyn Fixture, touches: &[Touch], probe: Probe) -> Result<Solution, SolveError> {
    support::solver("closed-form").solve(&Problem::new(fixture, touches, probe).unwrap())
}

fn roots_of(problem: &Problem<'_>) -> Vec<Root> {
    let mut roots = Vec::new();
    problem.fixture().closed_form().unwrap().roots(problem, &mut |root| roots.push(root)).unwrap();
    roots
}

/// How far a tip centre is from where its face lets it be, from the definition of the faces alone.
fn off_face(frame: &Frame, touch: &Touch, edge: f64, tip_radius: f64) -> f64 {
    let (_, axis, sign) = FACES[touch.surface];
    let along = frame.rotation.matrix().column(axis).dot(&(touch.at - frame.origin));
    let face = if sign > 0.0 { 0.0 } else { -edge };
    sign * (along - face) - tip_radius
}

/// Translation in parts of the edge, plus radians.
fn distance(from: &Frame, to: &Frame) -> f64 {
    from.twist_to(to).extent(EDGE)
}

/// Touches on the three faces of a corner (axis by axis), so many on each in order of the axes.
fn counts_of(corner: [usize; 3], counts: [usize; 3]) -> [usize; 6] {
    let mut all = [0; 6];
    for (face, count) in corner.into_iter().zip(counts) {
        all[face] = count;
    }
    all
}

fn corners() -> impl Iterator<Item = [usize; 3]> {
    (0..8).map(|corner| [corner % 2, 2 + (corner / 2) % 2, 4 + corner / 4])
}

const ORDERS: [[usize; 3]; 6] = [[3, 2, 1], [3, 1, 2], [2, 3, 1], [2, 1, 3], [1, 3, 2], [1, 2, 3]];

/// A random layout that is no weak one: some face has three touches well away from a line, and all touches together
/// tell the frame well.
fn sound_layout(fixture: &dyn Fixture, counts: &[usize; 6], rng: &mut impl Rng) -> Layout {
    /// Singular values of the layout's own equations, lengths in parts of the edge.
    const CONDITION: f64 = 20.0;
    /// Height of a triangle of touches over its first side, in parts of the edge.
    const HEIGHT: f64 = 0.1;
    loop {
        let layout = random_layout(fixture, counts, rng);
        let rows = DMatrix::from_fn(layout.len(), 6, |i, j| {
            let (_, axis, sign) = FACES[layout[i].0];
            let normal = Vector3::ith(axis, sign);
            let turn = layout[i].1.coords.cross(&normal) / EDGE;
            if j < 3 { normal[j] } else { turn[j - 3] }
        });
        let singular = rows.svd(false, false).singular_values;
        let plane = layout.windows(3).any(|three| {
            let [(a, p), (b, q), (c, r)] = [three[0], three[1], three[2]];
            a == b && b == c && (q - p).cross(&(r - p)).norm() > HEIGHT * EDGE * (q - p).norm()
        });
        if plane && singular.max() < CONDITION * singular.min() {
            return layout;
        }
    }
}

fn exact(fixture: &dyn Fixture, layout: &Layout, truth: &Frame) -> Vec<Touch> {
    simulate(fixture, layout, truth, &probe(None), 0.0, &mut generator(0, 0))
}

/// Eight corners, six orders of counts: the true frame first, three others by half turns about its axes, and every one
/// of the four with every touch on its plane.
#[test]
fn four_roots_of_3_2_1_on_every_corner_in_every_order() {
    const TRIALS: u64 = 20;
    /// Parts of the edge, and radians: coordinates of 100 round to 1e-14, which sound layouts amplify by twenty.
    const EXACT: f64 = 1e-12;
    let fixture = cube(EDGE);
    let mut worst = 0.0_f64;
    for (corner, order) in corners().flat_map(|corner| ORDERS.map(|order| (corner, order))) {
        for trial in 0..TRIALS {
            let mut rng = generator(81, trial);
            let layout = sound_layout(&*fixture, &counts_of(corner, order), &mut rng);
            let truth = random_frame(REACH, &mut rng);
            let touches = exact(&*fixture, &layout, &truth);
            let problem = Problem::new(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
            let roots = roots_of(&problem);
            assert_eq!(roots.len(), 4, "{corner:?} {order:?}");
            for root in &roots {
                for touch in &touches {
                    let off = off_face(&root.frame, touch, EDGE, TIP_RADIUS) / EDGE;
                    assert!(off.abs() < EXACT, "{corner:?} {order:?}: a touch is off its plane by {off:e}");
                }
                let rotation = root.frame.rotation.matrix();
                assert!((rotation.transpose() * rotation - Matrix3::identity()).norm() < EXACT);
                assert!((rotation.determinant() - 1.0).abs() < EXACT);
            }
            worst = worst.max(distance(&roots[0].frame, &truth));
            // The others are half turns of the axes, each about another one.
            let mut turns = BTreeSet::new();
            for root in &roots[1..] {
                let turn = truth.rotation.matrix().transpose() * root.frame.rotation.matrix();
                let axis = (0..3).max_by(|a, b| turn[(*a, *a)].total_cmp(&turn[(*b, *b)])).unwrap();
                let mut half = -Matrix3::identity();
                half[(axis, axis)] = 1.0;
                assert!((turn - half).norm() < EXACT, "{corner:?} {order:?}: {turn}");
                turns.insert(axis);
            }
            assert_eq!(turns.len(), 3);

            let solution = support::solver("closed-form").solve(&problem).unwrap();
            assert!(distance(&solution.frame, &truth) < EXACT, "{corner:?} {order:?}");
            let selected: Vec<bool> = solution.roots.iter().map(|root| root.selected).collect();
            assert_eq!(selected, [true, false, false, false]);
            let beyond = solution.roots[1..].iter().all(|root| root.reason.contains("would lie off"));
            assert!(beyond, "{:?}", solution.roots);
        }
    }
    println!("largest error {worst:.1e}");
    assert!(worst < EXACT, "{worst:e}");
}

/// With more touches than needed, on three faces up to six, the true frame is the first root of exact touches, and
/// solved to rounding.
#[test]
fn the_true_frame_is_the_first_root_of_more_touches() {
    const TRIALS: u64 = 50;
    const EXACT: f64 = 1e-12;
    /// A minimum of squares is placed to the square root of rounding where opposite faces make it flat.
    const ROOT: f64 = 1e-7;
    let fixture = cube(EDGE);
    let table = [
        [3, 0, 3, 0, 3, 0],
        [0, 3, 0, 3, 0, 3],
        [3, 0, 0, 2, 2, 0],
        [5, 0, 4, 0, 0, 7],
        [3, 1, 2, 0, 1, 0],
        [2, 2, 3, 0, 1, 0],
        [1, 1, 2, 1, 3, 1],
        [3, 3, 3, 3, 3, 3],
        [1, 4, 0, 3, 2, 2],
    ];
    for counts in table {
        for trial in 0..TRIALS {
            let mut rng = generator(82, trial);
            let layout = sound_layout(&*fixture, &counts, &mut rng);
            let truth = random_frame(REACH, &mut rng);
            let touches = exact(&*fixture, &layout, &truth);
            for sigma in [Some(SIGMA), None] {
                let problem = Problem::new(&*fixture, &touches, probe(sigma)).unwrap();
                let off = distance(&roots_of(&problem)[0].frame, &truth);
                assert!(off < ROOT, "{counts:?}, sigma {sigma:?}: off by {off:e}");
            }
            let solution = solve(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
            assert!(distance(&solution.frame, &truth) < EXACT, "{counts:?}");
        }
    }
}

/// Without a sigma the answer is an interval that holds the noise, or a refusal; never an interval without it where the
/// touches are sound.
#[test]
fn without_a_sigma_the_frame_stands_for_the_noise_there_is() {
    let fixture = cube(EDGE);
    for trial in 0..100 {
        let mut rng = generator(83, trial);
        let truth = random_frame(REACH, &mut rng);
        let touches = simulate(&*fixture, &fixture.nominal_layout(), &truth, &probe(None), SIGMA, &mut rng);
        let solution = solve(&*fixture, &touches, probe(None)).unwrap();
        assert!(solution.trust.up_to_sigma > SIGMA, "{:?}", solution.trust);
        assert!(distance(&solution.frame, &truth) < 20.0 * SIGMA / EDGE);
    }
}

/// A measurement with noise, on a sound layout.
fn measured(fixture: &dyn Fixture, counts: &[usize; 6], seed: u64, trial: u64) -> (Vec<Touch>, Frame) {
    let mut rng = generator(seed, trial);
    let layout = sound_layout(fixture, counts, &mut rng);
    let truth = random_frame(REACH, &mut rng);
    (simulate(fixture, &layout, &truth, &probe(None), SIGMA, &mut rng), truth)
}

const MIXTURES: [[usize; 6]; 5] =
    [[1, 0, 2, 0, 3, 0], [3, 0, 3, 0, 3, 0], [0, 2, 4, 0, 3, 1], [1, 1, 2, 1, 3, 1], [0, 3, 1, 2, 0, 2]];

#[test]
fn neither_the_order_of_touches_nor_the_parent_nor_the_unit_matters() {
    /// Parts of the edge, and radians: rounding of coordinates of 100 and of descents that end near the minimum.
    const SAME: f64 = 1e-9;
    let fixture = cube(EDGE);
    for (counts, trial) in MIXTURES.iter().flat_map(|counts| (0..20).map(move |trial| (counts, trial))) {
        let (touches, _) = measured(&*fixture, counts, 84, trial);
        let here = solve(&*fixture, &touches, probe(Some(SIGMA))).unwrap();

        let mut shuffled = touches.clone();
        shuffled.shuffle(&mut generator(85, trial));
        let other = solve(&*fixture, &shuffled, probe(Some(SIGMA))).unwrap();
        assert!(distance(&here.frame, &other.frame) < SAME, "{counts:?}");

        let motion = random_frame(REACH, &mut generator(86, trial));
        let moved: Vec<Touch> = touches.iter().map(|t| Touch { at: motion.to_parent(&t.at), ..*t }).collect();
        let other = solve(&*fixture, &moved, probe(Some(SIGMA))).unwrap();
        assert!(distance(&here.frame.seen_from(&motion), &other.frame) < SAME, "{counts:?}");

        for unit in [1.0 / 25.4, 25.4, 1e-3, 1000.0] {
            let scaled: Vec<Touch> = touches.iter().map(|t| Touch { at: t.at * unit, ..*t }).collect();
            let scaled_probe =
                Probe { tip_radius: TIP_RADIUS * unit, sigma: Some(SIGMA * unit), ..Probe::default() };
            let other = solve(&*cube(EDGE * unit), &scaled, scaled_probe).unwrap();
            let back = Frame { origin: other.frame.origin / unit, ..other.frame };
            assert!(distance(&here.frame, &back) < SAME, "{counts:?}, unit {unit}");
            let ratio = other.trust.up_to_sigma / (here.trust.up_to_sigma * unit);
            assert!((ratio - 1.0).abs() < 1e-5, "{counts:?}, unit {unit}: {ratio}");
        }
    }
}

/// The 24 rotations that map the cube onto itself, as signed permutations of the axes.
fn symmetries() -> Vec<Matrix3<f64>> {
    let mut all = Vec::new();
    for order in ORDERS.map(|order| order.map(|k| k - 1)) {
        for signs in 0..8 {
            let columns = [0, 1, 2]
                .map(|axis| Vector3::ith(order[axis], if (signs >> axis) % 2 == 0 { 1.0 } else { -1.0 }));
            let matrix = Matrix3::from_columns(&columns);
            if matrix.determinant() > 0.0 {
                all.push(matrix);
            }
        }
    }
    all
}

/// The same touches with the labels of a turned cube give the turned frame, its origin at the corner that is now called
/// so.
#[test]
fn labels_turned_by_a_symmetry_turn_the_frame() {
    const SAME: f64 = 1e-9;
    let fixture = cube(EDGE);
    let middle = Point3::new(-0.5, -0.5, -0.5) * EDGE;
    let symmetries = symmetries();
    assert_eq!(symmetries.len(), 24);
    for (counts, trial) in MIXTURES.iter().flat_map(|counts| (0..5).map(move |trial| (counts, trial))) {
        let (touches, _) = measured(&*fixture, counts, 87, trial);
        let here = solve(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
        for symmetry in &symmetries {
            let relabelled = |touch: &Touch| {
                let (_, axis, sign) = FACES[touch.surface];
                let outward: Vector3<f64> = symmetry.column(axis) * sign;
                let surface = FACES.iter().position(|(_, axis, sign)| outward[*axis] * sign > 0.5).unwrap();
                Touch { surface, ..*touch }
            };
            let touches: Vec<Touch> = touches.iter().map(relabelled).collect();
            let there = solve(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
            let rotation =
                Rotation3::from_matrix_unchecked(here.frame.rotation.matrix() * symmetry.transpose());
            let origin = here.frame.to_parent(&middle) - rotation * middle.coords;
            let off = distance(&there.frame, &Frame { rotation, origin });
            assert!(off < SAME, "{counts:?}: off by {off:e}");
            assert!((there.chi_square.unwrap() - here.chi_square.unwrap()).abs() < 1e-6);
        }
    }
}

/// Exact touches by tips of any radius give one frame.
#[test]
fn the_tip_radius_is_taken_off_along_the_normals() {
    const EXACT: f64 = 1e-12;
    let fixture = cube(EDGE);
    for (counts, trial) in MIXTURES.iter().flat_map(|counts| (0..10).map(move |trial| (counts, trial))) {
        let mut rng = generator(88, trial);
        let layout = sound_layout(&*fixture, counts, &mut rng);
        let truth = random_frame(REACH, &mut rng);
        for tip_radius in [0.0, 0.5, 3.0, 20.0] {
            let probe = Probe { tip_radius, sigma: Some(SIGMA), ..Probe::default() };
            let touches = simulate(&*fixture, &layout, &truth, &probe, 0.0, &mut rng);
            let solution = solve(&*fixture, &touches, probe).unwrap();
            assert!(distance(&solution.frame, &truth) < EXACT, "{counts:?}, tip radius {tip_radius}");
        }
    }
}

/// Squared misfit of a frame and its Gauss-Newton step, from the definition of the faces: a search of its own.
fn normal_equations(touches: &[Touch], frame: &Frame, sigma: f64) -> (f64, Matrix6<f64>, Vector6<f64>) {
    let (mut chi_square, mut matrix, mut gradient) = (0.0, Matrix6::zeros(), Vector6::zeros());
    for touch in touches {
        let (_, axis, sign) = FACES[touch.surface];
        let normal = frame.rotation.matrix().column(axis) * sign;
        let residual = off_face(frame, touch, EDGE, TIP_RADIUS) / sigma;
        // A turn w of the axes about the origin adds w x n . (p - o) = w . n x (p - o).
        let turn = normal.cross(&(touch.at - frame.origin));
        let row = Vector6::from_iterator((-normal).iter().chain(turn.iter()).map(|v| v / sigma));
        chi_square += residual * residual;
        gradient += row * residual;
        matrix += row * row.transpose();
    }
    (chi_square, matrix, gradient)
}

/// Where a descent ends, and its squared misfit; `None` where it has not settled.
fn descended(touches: &[Touch], start: Frame, sigma: f64) -> Option<(Frame, f64)> {
    /// Descents that need more end in valleys too flat to be trusted.
    const STEPS: usize = 60;
    /// In squared standard deviations.
    const SETTLED: f64 = 1e-9;
    let mut frame = start;
    let (mut chi_square, mut matrix, mut gradient) = normal_equations(touches, &frame, sigma);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        // Twice what an undamped step would gain.
        let gain = gradient.dot(&matrix.cholesky()?.solve(&gradient));
        if gain < SETTLED * (1.0 + chi_square) {
            return Some((frame, chi_square));
        }
        let damped = matrix + Matrix6::from_diagonal(&matrix.diagonal()) * damping;
        let step = damped.cholesky()?.solve(&-gradient);
        let turn = Rotation3::new(Vector3::new(step[3], step[4], step[5]));
        let next = Frame {
            rotation: Rotation3::from_matrix(&(turn * frame.rotation).into_inner()),
            origin: frame.origin + Vector3::new(step[0], step[1], step[2]),
        };
        let there = normal_equations(touches, &next, sigma);
        if there.0 <= chi_square {
            frame = next;
            (chi_square, matrix, gradient) = there;
            damping *= 0.1;
        } else {
            damping *= 10.0;
        }
    }
    None
}

/// Every minimum that a search from rotations all over finds within the noise, and that nothing speaks against, is
/// reached from a candidate, too, unless the layout is refused as too weak anyway: layouts near a line on every face,
/// opposite faces, much noise.
#[test]
fn candidates_are_in_every_basin_within_the_noise() {
    const TRIALS: u64 = 3000;
    const STARTS: usize = 40;
    /// Two ends of descents nearer than this (parts of the edge, radians) are one minimum: flat ones end a little apart.
    const ONE: f64 = 1e-4;
    let fixture = cube(EDGE);
    let outcomes: Vec<(usize, usize)> = (0..TRIALS)
        .into_par_iter()
        .map(|trial| {
            let mut rng = generator(89, trial);
            let counts = MIXTURES[usize::try_from(trial).unwrap() % MIXTURES.len()];
            let mut layout = random_layout(&*fixture, &counts, &mut rng);
            let slim = 10.0_f64.powf(rng.random_range(-3.0..0.0));
            for (face, point) in &mut layout {
                let across = (FACES[*face].1 + 1) % 3;
                point[across] = -0.5 * EDGE + slim * (point[across] + 0.5 * EDGE);
            }
            let truth = random_frame(REACH, &mut rng);
            // The face's normals are known to 0.001 to 0.1 rad.
            let sigma = 10.0_f64.powf(rng.random_range(-3.0..-1.0)) * slim * 0.3 * EDGE;
            let touches = simulate(&*fixture, &layout, &truth, &probe(None), sigma, &mut rng);
            if let Err(refusal) = solve(&*fixture, &touches, probe(Some(sigma)))
                && ["degenerate", "not-validated"].contains(&refusal.code())
            {
                return (0, 0);
            }
            let problem = Problem::new(&*fixture, &touches, probe(Some(sigma))).unwrap();
            let mut reached: Vec<Frame> = Vec::new();
            let mut start = |start| reached.extend(descended(&touches, start, sigma).map(|(end, _)| end));
            fixture.closed_form().unwrap().candidates(&problem, 1.0, &mut start).unwrap();
            // Higher minima do not count as a second frame.
            let within = chi_square_level(1e-6, touches.len() - 6);
            let mut minima: Vec<Frame> = Vec::new();
            let mean = touches.iter().map(|t| t.at.coords).sum::<Vector3<f64>>() / touches.len() as f64;
            for _ in 0..STARTS {
                let rotation = random_frame(0.0, &mut rng).rotation;
                let start =
                    Frame { rotation, origin: Point3::from(mean + rotation * Vector3::repeat(0.5 * EDGE)) };
                let Some((end, chi_square)) = descended(&touches, start, sigma) else { continue };
                let new = minima.iter().all(|known| distance(known, &end) > ONE);
                if chi_square < within && new && fixture.objection(&problem, &end).is_none() {
                    minima.push(end);
                }
            }
            let missed = minima.iter().filter(|m| reached.iter().all(|end| distance(m, end) > ONE)).count();
            if missed > 0 {
                println!("trial {trial}: {counts:?}, slim {slim}, sigma {sigma}: {missed} missed");
            }
            (minima.len(), missed)
        })
        .collect();
    let searched = outcomes.iter().filter(|(minima, _)| *minima > 0).count();
    let several = outcomes.iter().filter(|(minima, _)| *minima > 1).count();
    let missed = outcomes.iter().filter(|(_, missed)| *missed > 0).count();
    println!("{searched} layouts searched, {several} with several minima; minima missed in {missed}");
    assert!(searched > 1500 && several > 8, "{searched}, {several}");
    assert_eq!(missed, 0);
}

/// Labels that make a left-handed corner: two faces exchanged, one taken for its opposite, a mirrored parent.
#[test]
fn a_left_handed_corner_is_told() {
    let fixture = cube(EDGE);
    let all_six = [[0, 2, 4], [1, 3, 5]].map(|faces: [usize; 3]| faces.to_vec()).concat();
    let corners = corners().map(|corner| corner.to_vec()).chain([all_six]);
    for (trial, faces) in corners.enumerate() {
        for count in [[3, 2, 1], [1, 3, 2], [3, 3, 3], [5, 4, 3]] {
            let mut rng = generator(90, trial as u64);
            let mut counts = [0; 6];
            for face in &faces {
                counts[*face] = count[face / 2];
            }
            let layout = sound_layout(&*fixture, &counts, &mut rng);
            let truth = random_frame(REACH, &mut rng);
            let touches = simulate(&*fixture, &layout, &truth, &probe(None), SIGMA, &mut rng);
            let relabelled = |label: &dyn Fn(usize) -> usize| -> Vec<Touch> {
                touches.iter().map(|touch| Touch { surface: label(touch.surface), ..*touch }).collect()
            };
            let exchanged = |a: usize, b: usize| {
                relabelled(&move |face| match face / 2 {
                    axis if axis == a => 2 * b + face % 2,
                    axis if axis == b => 2 * a + face % 2,
                    _ => face,
                })
            };
            let opposite =
                |axis: usize| relabelled(&move |face| if face / 2 == axis { face ^ 1 } else { face });
            let mirror =
                |touch: &Touch| Touch { at: Point3::new(touch.at.x, -touch.at.y, touch.at.z), ..*touch };
            let wrong = [
                exchanged(0, 1),
                exchanged(1, 2),
                exchanged(2, 0),
                opposite(0),
                opposite(1),
                opposite(2),
                touches.iter().map(mirror).collect(),
            ];
            for (touches, sigma) in wrong.iter().flat_map(|touches| [(touches, Some(SIGMA)), (touches, None)])
            {
                let refusal = solve(&*fixture, touches, probe(sigma)).unwrap_err();
                let SolveError::InvalidTouches { problem, help, .. } = &refusal else {
                    panic!("{faces:?} {count:?}, sigma {sigma:?}: {refusal}")
                };
                assert!(problem.contains("left-handed") && help.contains("exchange the labels"), "{refusal}");
                let labels: BTreeSet<usize> = touches.iter().map(|touch| touch.surface).collect();
                let named = labels.iter().filter(|face| problem.contains(FACES[**face].0)).count();
                assert_eq!(named, 3, "{refusal}");
            }
        }
    }
}

/// One wrong label among nine touches or more: refused, whichever it is, on adjacent faces or on all six.
#[test]
fn one_wrong_label_is_never_accepted() {
    let fixture = cube(EDGE);
    for trial in 0..20 {
        let mut rng = generator(91, trial);
        let truth = random_frame(REACH, &mut rng);
        let all_around = sound_layout(&*fixture, &[3, 2, 1, 4, 2, 3], &mut rng);
        for layout in [fixture.nominal_layout(), all_around] {
            let touches = simulate(&*fixture, &layout, &truth, &probe(None), SIGMA, &mut rng);
            assert!(solve(&*fixture, &touches, probe(Some(SIGMA))).is_ok());
            for (wrong, label) in (0..touches.len()).flat_map(|wrong| (0..6).map(move |label| (wrong, label)))
            {
                if label == touches[wrong].surface {
                    continue;
                }
                let mut touches = touches.clone();
                touches[wrong].surface = label;
                let outcome = solve(&*fixture, &touches, probe(Some(SIGMA)));
                assert!(outcome.is_err(), "touch {wrong} labelled {}: accepted", FACES[label].0);
            }
        }
    }
}

/// A unit or an edge that is off puts touches beyond their faces: told with the touch and the border.
#[test]
fn touches_beyond_their_faces_are_told() {
    let truth = random_frame(REACH, &mut generator(92, 0));
    let touches = exact(&*cube(EDGE), &cube(EDGE).nominal_layout(), &truth);
    for edge in [EDGE / 25.4, 0.6 * EDGE] {
        for sigma in [Some(SIGMA), None] {
            let refusal = solve(&*cube(edge), &touches, probe(sigma)).unwrap_err();
            let SolveError::InvalidTouches { problem, help, touches } = &refusal else { panic!("{refusal}") };
            assert!(
                problem.contains("would lie off `") && problem.contains("% of the edge beyond"),
                "{refusal}"
            );
            assert!(help.contains("unit") && help.contains("edge") && touches.len() == 1, "{help}");
        }
    }
}

/// A cube that is a little larger than stated is no reason to refuse where the edge takes no part; nor is a touch in the
/// corner of its face.
#[test]
fn touches_up_to_the_edges_are_sound() {
    let fixture = cube(EDGE);
    let truth = random_frame(REACH, &mut generator(93, 0));
    let reach = 1.015 * EDGE;
    let on = |axis: usize| {
        let square = [[0.0, 0.0], [reach, 0.0], [0.0, reach]];
        square.map(move |[a, b]| {
            let mut point = Point3::origin();
            (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (-a, -b);
            (2 * axis, point)
        })
    };
    let layout: Layout = (0..3).flat_map(on).collect();
    for trial in 0..100 {
        let touches = simulate(&*fixture, &layout, &truth, &probe(None), SIGMA, &mut generator(94, trial));
        let solution = solve(&*fixture, &touches, probe(Some(SIGMA)));
        assert!(solution.is_ok() || solution.as_ref().unwrap_err().code() == "inconsistent", "{solution:?}");
    }
}

/// Opposite faces nearer or farther than the edge allows contradict it, unless the edge is uncertain by as much.
#[test]
fn opposite_faces_measure_the_edge() {
    for counts in [[1, 1, 2, 0, 3, 0], [2, 0, 0, 1, 3, 3], [2, 2, 2, 2, 3, 3]] {
        for (trial, off) in [0.3, -0.3, 5.0, -5.0].into_iter().enumerate() {
            let actual = cube(EDGE + off);
            let mut rng = generator(95, trial as u64);
            let layout = sound_layout(&*actual, &counts, &mut rng);
            let truth = random_frame(REACH, &mut rng);
            let touches = simulate(&*actual, &layout, &truth, &probe(None), SIGMA, &mut rng);
            let refusal = solve(&*cube(EDGE), &touches, probe(Some(SIGMA))).unwrap_err();
            assert_eq!(refusal.code(), "inconsistent", "{counts:?}, off by {off}: {refusal}");
            assert!(refusal.to_string().contains("chi-square"), "{refusal}");

            let uncertain = cube(Value::Number { value: EDGE, u: off.abs() });
            let solution = solve(&*uncertain, &touches, probe(Some(SIGMA))).unwrap();
            // The origin is a corner of faces that may not be touched: it is off by what the edge is.
            let reached = distance(&solution.frame, &truth) * EDGE;
            assert!(reached < 1.5 * off.abs() + 50.0 * SIGMA, "{counts:?}, off by {off}: {reached}");
        }
    }
}

/// Where on the faces of a corner: along two directions of each face, in edges from the origin.
fn on_corner(x: &[[f64; 2]], y: &[[f64; 2]], z: &[[f64; 2]]) -> Layout {
    let on = |axis: usize, places: &[[f64; 2]]| -> Layout {
        let at = |[a, b]: [f64; 2]| {
            let mut point = Point3::origin();
            (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (-a * EDGE, -b * EDGE);
            (2 * axis, point)
        };
        places.iter().map(|place| at(*place)).collect()
    };
    [on(0, x), on(1, y), on(2, z)].concat()
}

/// Touches that do not tell a face's plane, or the turn about it, are told with the line about which the face may turn;
/// with noise they are no frame either.
#[test]
fn touches_in_a_line_are_refused_with_the_line() {
    /// Radians.
    const ALONG: f64 = 1e-6;
    let triangle = [[0.2, 0.2], [0.8, 0.3], [0.3, 0.9]];
    let line = [[0.2, 0.2], [0.5, 0.5], [0.8, 0.8]];
    let diagonal = (Vector3::x() + Vector3::y()).normalize();
    let turn = [[0.5, 0.2], [0.5, 0.7]];
    let table = [
        ("three in a line", on_corner(&[[0.5, 0.4]], &turn, &line), "rotation of `+z`", diagonal),
        (
            "three places, two the same",
            on_corner(&[[0.5, 0.4]], &turn, &[[0.2, 0.2], [0.8, 0.8], [0.2, 0.2]]),
            "rotation of `+z`",
            diagonal,
        ),
        ("a line on every face", on_corner(&line, &line, &line), "rotation of `+", Vector3::zeros()),
        (
            "two in one place",
            on_corner(&[[0.5, 0.4], [0.5, 0.4]], &[[0.5, 0.4]], &triangle),
            "rotation of `+x`",
            Vector3::z(),
        ),
        (
            "two one above the other",
            on_corner(&[[0.5, 0.4], [0.5, 0.9]], &[[0.5, 0.4]], &triangle),
            "rotation of `+x`",
            Vector3::z(),
        ),
        (
            "one place on each face",
            on_corner(&[[0.5, 0.5]; 3], &[[0.5, 0.5]; 2], &[[0.5, 0.5]]),
            "rotation of `+x`",
            Vector3::zeros(),
        ),
    ];
    let fixture = cube(EDGE);
    for (trial, (name, layout, words, axis)) in table.iter().enumerate() {
        for frame in [Frame::identity(), random_frame(REACH, &mut generator(96, trial as u64))] {
            for sigma in [Some(SIGMA), None] {
                let refusal = solve(&*fixture, &exact(&*fixture, layout, &frame), probe(sigma)).unwrap_err();
                let SolveError::Degenerate(degenerate) = &refusal else {
                    panic!("{name}, sigma {sigma:?}: `{}`, {refusal}", refusal.code())
                };
                assert!(degenerate.free.to_string().contains(words), "{name}: {refusal}");
                assert!(refusal.help().starts_with("touch `+"), "{name}: {}", refusal.help());
                let told = degenerate.free.twist.rotation;
                let sine = told.cross(&(frame.rotation * axis)).norm();
                assert!(sine < ALONG, "{name}: {sine:e} from the line");
                for noise in 0..20 {
                    let mut rng = generator(97, noise);
                    let touches = simulate(&*fixture, layout, &frame, &probe(None), SIGMA, &mut rng);
                    let outcome = solve(&*fixture, &touches, probe(sigma));
                    let stands = outcome.map_or(0.0, |solution| solution.trust.up_to_sigma);
                    assert!(stands < SIGMA, "{name}, sigma {sigma:?}: stands up to {stands}");
                }
            }
        }
    }
}

/// What is missing is told for the alternative that needs least.
#[test]
fn what_is_missing_is_told_shortly() {
    let fixture = cube(EDGE);
    let table = [
        ([3, 0, 0, 0, 0, 0], "`+y` has 0 of 1 touches, `+z` has 0 of 2 touches"),
        ([3, 3, 1, 0, 0, 0], "`+z` has 0 of 2 touches"),
        ([2, 0, 2, 0, 2, 0], "`+z` has 2 of 3 touches"),
        ([0, 2, 0, 0, 0, 3], "`+y` has 0 of 1 touches"),
        ([1, 1, 1, 1, 1, 1], "`+y` has 1 of 2 touches, `+z` has 1 of 3 touches"),
    ];
    for (counts, expected) in table {
        let layout = random_layout(&*fixture, &counts, &mut generator(98, 0));
        let touches = exact(&*fixture, &layout, &Frame::identity());
        let refusal = solve(&*fixture, &touches, probe(Some(SIGMA))).unwrap_err();
        assert_eq!(refusal.code(), "too-few-touches", "{counts:?}");
        assert!(refusal.to_string().ends_with(expected), "{counts:?}: {refusal}");
        // Nor does the closed form by itself panic or invent a frame.
        let problem = Problem::new(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
        let alone = fixture.closed_form().unwrap().candidates(&problem, 1.0, &mut |_| ());
        assert!(alone.is_err(), "{counts:?}");
    }
}

/// Six touches are no more than unknowns: no chi-square can speak, and the solution says so.
#[test]
fn six_touches_have_no_redundancy_and_say_so() {
    let fixture = cube(EDGE);
    let (touches, truth) = measured(&*fixture, &[1, 0, 2, 0, 3, 0], 99, 0);
    let solution = solve(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
    assert_eq!((solution.degrees_of_freedom, solution.p_value), (0, None));
    assert!(solution.chi_square.unwrap() < 1e-12);
    assert!(solution.squared_distance(&truth).unwrap() < chi_square_level(1e-6, 6));
    assert!(solution.warnings.iter().any(|warning| warning.code == "low-redundancy"));
    let unstated = solve(&*fixture, &touches, probe(None)).unwrap();
    assert!(unstated.covariance.is_none() && unstated.trust.from_sigma == 0.0, "{unstated:?}");
}

/// Touches in inches on a cube in millimetres lie near its corner, where no size of the cube contradicts them: the unit
/// is asked for. In the right unit it is not.
#[test]
fn touches_close_together_ask_for_the_unit() {
    let fixture = cube(EDGE);
    for trial in 0..100 {
        let (touches, _) = measured(&*fixture, &[3, 0, 3, 0, 3, 0], 102, trial);
        let asks = |scale: f64| {
            let scaled = |touch: &Touch| Touch { at: touch.at * scale, ..*touch };
            let touches: Vec<Touch> = touches.iter().map(scaled).collect();
            let problem = Problem::new(&*fixture, &touches, Probe { sigma: Some(SIGMA), ..Probe::default() });
            let solution = support::solver("least-squares").solve(&problem.unwrap()).ok()?;
            Some(solution.warnings.iter().any(|warning| warning.code == "touches-close-together"))
        };
        assert_ne!(asks(1.0), Some(true), "trial {trial}");
        assert_ne!(asks(1.0 / 25.4), Some(false), "trial {trial}");
    }
}

/// The search for frames allocates nothing: it may run in a control loop.
#[test]
fn roots_and_candidates_allocate_nothing() {
    let fixture = cube(EDGE);
    let closed_form = fixture.closed_form().unwrap();
    for (counts, trial) in MIXTURES.iter().flat_map(|counts| (0..100).map(move |trial| (counts, trial))) {
        let (touches, _) = measured(&*fixture, counts, 101, trial);
        let problem = Problem::new(&*fixture, &touches, probe(Some(SIGMA))).unwrap();
        let mut found = 0;
        let counted = measure(|| {
            closed_form.roots(&problem, &mut |_| found += 1).unwrap();
            for noise in [1.0, 30.0] {
                closed_form.candidates(&problem, noise, &mut |_| found += 1).unwrap();
            }
        });
        assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{counts:?}, trial {trial}");
        assert!(found >= 3, "{counts:?}, trial {trial}: {found}");
    }
}

fn study(layout: StudyLayout, trials: u64, seed: u64) -> StudyOutcome {
    let (fixture, solver) = (cube(EDGE), support::solver("closed-form"));
    let (fixture, solver) = (&*fixture, &*solver);
    let probe = probe(Some(SIGMA));
    let plugin = &touchref::fixtures::cube::PLUGIN;
    let outcome =
        Study { fixture, plugin, solver, layout, probe, reach: 1000.0, seed, trials }.run().unwrap();
    println!(
        "accepted {} of {trials}, wrong {}, NEES {:.3}, refused {:?}",
        outcome.accepted,
        outcome.wrong,
        outcome.nees_mean().unwrap(),
        outcome.refused
    );
    assert_eq!(outcome.wrong, 0);
    // Four standard deviations of the mean.
    let spread = 4.0 * (12.0 / outcome.accepted as f64).sqrt();
    let nees = outcome.nees_mean().unwrap();
    assert!((nees.value - 6.0).abs() < spread, "{nees}");
    outcome
}

/// Of a million none was wrong, and nothing but chi-square refused any, at its level.
#[test]
fn nothing_but_chi_square_refuses_the_nominal_layout() {
    const TRIALS: u64 = 10_000;
    let outcome = study(StudyLayout::Fixed(cube(EDGE).nominal_layout()), TRIALS, 102);
    assert!(outcome.refused.keys().all(|code| *code == "inconsistent"), "{:?}", outcome.refused);
    // Chance 1e-3, and five standard deviations of its count.
    assert!(outcome.accepted >= TRIALS - 26, "{}", outcome.accepted);
}

#[test]
fn random_layouts_are_right_or_refused() {
    const TRIALS: u64 = 10_000;
    let outcome = study(StudyLayout::Random(vec![3, 0, 3, 0, 3, 0]), TRIALS, 103);
    assert!(outcome.accepted as f64 > 0.99 * TRIALS as f64, "{}", outcome.accepted);
    // Six touches at random are a weak layout in a third of the cases.
    let outcome = study(StudyLayout::Random(vec![1, 0, 2, 0, 3, 0]), TRIALS, 104);
    assert!(outcome.accepted as f64 > 0.6 * TRIALS as f64, "{}", outcome.accepted);
}
