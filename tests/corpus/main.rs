//! The corpus of layouts that leave a motion free, nearly do, or do not: `layouts.json`, made and judged by
//! `layouts.py`, which shares no code with the library. What is free is refused and told; what is sound is located; and
//! nothing is ever located wrongly. See `README.md` beside this file.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod geometry;

use std::{cmp::Ordering, collections::BTreeMap, path::Path};

use nalgebra::{Matrix3, Point3, Rotation3, Vector3, Vector6};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};
use touchref::{
    Fixture, Frame, Motion, Parameters, Problem, Registry, Solution, SolveError, Touch,
    analysis::simulation::generator, io::Measurement, statistics::chi_square_level,
};

use geometry::{Geometry, Moving, resistance};

/// Above this condition a motion is free.
const FREE: f64 = 1e8;
/// Below this condition a layout is sound.
const SOUND: f64 = 1e4;
/// A second frame of a misfit below this (standard deviations) fits as the true one does; it is told up to the far larger
/// one of `layouts.py`, and between the two either verdict is right.
const FITS: f64 = 1.0;
/// Degrees by which a motion that is told may be off those that no touch resists.
const RIGHT: f64 = 1.0;
/// What a touch may resist of a motion that is told as free, for each root of the number of touches: the library's tolerance is
/// this part of the largest singular value, which for so many rows is no larger.
const FREELY: f64 = 1e-6;
/// How well the touches fit where a motion was found free, in parts of the fixture's size: a double root is placed to the
/// root of rounding, a few times.
const FITTING: f64 = 1e-7;
/// Chance that the squared error of a true frame exceeds its level: the reach up to which solvers vouch for theirs.
const NEVER: f64 = 1e-9;

/// `layouts.json`: see `layouts.py`.
#[derive(Deserialize)]
struct File {
    sigma: f64,
    fixtures: Vec<Made>,
    layouts: Vec<Line>,
}

#[derive(Deserialize)]
struct Made {
    measured: Value,
    size: f64,
    surfaces: BTreeMap<String, Geometry>,
}

#[derive(Deserialize)]
struct Line {
    name: String,
    fixture: usize,
    touches: Vec<(String, f64, f64, f64)>,
    frame: [f64; 12],
    condition: Option<f64>,
    #[serde(default)]
    free: Vec<[f64; 6]>,
    second: Option<Second>,
}

#[derive(Deserialize)]
struct Second {
    misfit: f64,
}

/// What the oracle expects of every solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Expected {
    /// The frame.
    Located,
    /// A refusal that tells a free motion.
    Refused,
    /// A refusal: a second frame fits as well.
    Ambiguous,
    /// The frame or a refusal.
    Either,
}

struct Layout {
    line: Line,
    size: f64,
    surfaces: BTreeMap<String, Geometry>,
    measurement: Measurement,
    fixture: Box<dyn Fixture>,
    touches: Vec<Touch>,
    truth: Frame,
}

fn corpus() -> Vec<Layout> {
    let file: File = serde_json::from_str(include_str!("layouts.json")).unwrap();
    let registry = touchref::registry().unwrap();
    let File { sigma, fixtures, layouts } = file;
    layouts.into_iter().map(|line| Layout::new(&registry, sigma, &fixtures[line.fixture], line)).collect()
}

impl Layout {
    fn new(registry: &Registry, sigma: f64, made: &Made, line: Line) -> Self {
        let touches =
            line.touches.iter().map(|(surface, x, y, z)| json!({"surface": surface, "at": [x, y, z]}));
        let text = json!({
            "units": "mm",
            "fixture": made.measured,
            "probe": {"sigma": sigma},
            "touch": touches.collect::<Vec<_>>(),
        });
        let measurement = Measurement::from_text("layouts.json", &text.to_string(), Path::new("")).unwrap();
        let fixture = measurement.fixture(registry).unwrap();
        let touches = measurement.touches(&*fixture).unwrap().touches;
        let [x, y, z, axes @ ..] = line.frame;
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&axes));
        let truth = Frame { rotation, origin: Point3::new(x, y, z) };
        let surfaces = made.surfaces.clone();
        Self { truth, measurement, fixture, touches, size: made.size, surfaces, line }
    }

    fn condition(&self) -> f64 {
        self.line.condition.unwrap_or(f64::INFINITY)
    }

    fn expected(&self) -> Expected {
        match (self.condition(), &self.line.second) {
            (condition, _) if condition > FREE => Expected::Refused,
            (condition, _) if condition >= SOUND => Expected::Either,
            (_, Some(second)) if second.misfit < FITS => Expected::Ambiguous,
            (_, Some(_)) => Expected::Either,
            _ => Expected::Located,
        }
    }

    /// How far a motion is from those that no touch resists at the true frame, degrees.
    fn off_by(&self, motion: &Motion) -> f64 {
        let w = motion.twist.rotation;
        let v = motion.twist.translation + w.cross(&(self.truth.origin - motion.about));
        let motion = Vector6::new(v.x, v.y, v.z, w.x * self.size, w.y * self.size, w.z * self.size);
        let free = self.line.free.iter().map(|free| Vector6::from_row_slice(free));
        let within: Vector6<f64> = free.map(|basis| basis * basis.dot(&motion)).sum();
        (motion - within).norm().atan2(within.norm()).to_degrees()
    }

    /// The same with noise along every axis, in stated sigmas.
    fn disturbed(&self, noise: f64, draw: u64) -> Disturbed<'_> {
        let mut rng = generator(73, draw);
        let sigma = noise * self.measurement.probe.sigma.unwrap();
        let mut gauss = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut off = || Vector3::from_fn(|_, _| gauss()) * sigma;
        let touches = self.touches.iter().map(|touch| Touch { at: touch.at + off(), ..*touch }).collect();
        Disturbed { layout: self, touches }
    }

    /// The touches and their surfaces, as the oracle knows them.
    fn contacts(&self) -> Vec<(&Geometry, Point3<f64>)> {
        let contact =
            |(surface, x, y, z): &(String, f64, f64, f64)| (&self.surfaces[surface], Point3::new(*x, *y, *z));
        self.line.touches.iter().map(contact).collect()
    }

    /// What is wrong with the motion that a refusal tells, if something is.
    fn fault_of_motion(&self, motion: &Motion) -> Option<String> {
        let moving = Moving {
            velocity: motion.twist.translation,
            rotation: motion.twist.rotation,
            about: motion.about,
        };
        if moving.extent(self.size) == 0.0 {
            return Some("tells a motion of length zero".to_owned());
        }
        let words = motion.to_string();
        if let Some(alone) =
            self.surfaces.keys().find(|name| words.contains(&format!("rotation of `{name}`")))
        {
            let own = self.line.touches.iter().filter(|touch| touch.0 == *alone);
            let points: Vec<_> = own.map(|(_, x, y, z)| Point3::new(*x, *y, *z)).collect();
            let moves = moving.moves(&points, self.size);
            return (moves > FREELY).then(|| format!("moves the touches of `{alone}` by {moves:.1e}"));
        }
        let off = self.off_by(motion);
        if off < RIGHT {
            return None;
        }
        let resistance = resistance(&self.contacts(), &moving, self.size, FITTING);
        (resistance > FREELY * (self.touches.len() as f64).sqrt()).then(|| {
            format!("tells a motion {off:.1} degrees off, and {resistance:.1e} is resisted wherever the touches fit")
        })
    }
}

/// A layout with its touches moved.
struct Disturbed<'a> {
    layout: &'a Layout,
    touches: Vec<Touch>,
}

impl Disturbed<'_> {
    fn solve(&self, solver: &str) -> Result<Solution, SolveError> {
        let solver = touchref::registry().unwrap().solver(solver).unwrap().build(&Parameters::new()).unwrap();
        let Layout { fixture, measurement, .. } = self.layout;
        solver.solve(&Problem::new(&**fixture, &self.touches, measurement.probe).unwrap())
    }
}

/// The weak motion of a refusal.
fn told(refusal: &SolveError) -> Option<&Motion> {
    match refusal {
        SolveError::Degenerate(degenerate) => Some(&degenerate.free),
        other => Some(&other.refusal()?.observability.as_ref()?.weakest),
    }
}

/// Squared error of a frame in its own stated covariance: chi-square with six degrees of freedom.
fn squared_error(solution: &Solution, truth: &Frame) -> f64 {
    let twist = solution.frame.twist_to(truth);
    let turn = |v: Vector3<f64>| solution.frame.rotation * v;
    let (t, w) = (turn(twist.translation), turn(twist.rotation));
    let error = Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z);
    let cholesky = solution.covariance.and_then(|covariance| covariance.matrix.cholesky());
    // What states no uncertainty, or none to speak of, vouches for nothing.
    cholesky.map_or(f64::INFINITY, |cholesky| error.dot(&cholesky.solve(&error)))
}

/// Every layout by a solver; a line of name, condition, what was expected and what came, for each that is not as the
/// oracle says. `noise` in stated sigmas; what is sound must be located only where `all` are asked for.
fn faults(solver: &str, noise: f64, all: bool) -> Vec<String> {
    let level = chi_square_level(NEVER, 6);
    let outcomes: Vec<(Expected, Option<String>, bool)> = corpus()
        .into_par_iter()
        .enumerate()
        .filter(|(_, layout)| match layout.fixture.closed_form() {
            Some(_) => true,
            // Where a motion is free, a search without a closed form takes up to a second: once is enough.
            None => solver != "closed-form" && (noise == 0.0 || layout.expected() != Expected::Refused),
        })
        .map(|(index, layout)| {
            let expected = layout.expected();
            let outcome = layout.disturbed(noise, index as u64).solve(solver);
            let wrong = match (&outcome, expected) {
                (Ok(solution), Expected::Located | Expected::Either) => {
                    let squared = squared_error(solution, &layout.truth);
                    // Not a number, either.
                    (squared.partial_cmp(&level) != Some(Ordering::Less))
                        .then(|| format!("a frame of squared error {squared:.3e}, level {level:.1}"))
                }
                (Ok(_), Expected::Refused | Expected::Ambiguous) => Some("a frame".to_owned()),
                (Err(refusal), Expected::Located) => all.then(|| format!("`{}`: {refusal}", refusal.code())),
                (Err(refusal), Expected::Refused) => match told(refusal) {
                    None => Some("tells no motion".to_owned()),
                    // Noise moves the frame at which a layout was refused, and what is free there.
                    Some(_) if noise > 0.0 => None,
                    Some(motion) => layout.fault_of_motion(motion),
                }
                .map(|fault| format!("`{}` that {fault}: {refusal}", refusal.code())),
                (Err(_), Expected::Ambiguous | Expected::Either) => None,
            };
            let fault = wrong.map(|wrong| {
                let name = &layout.line.name;
                format!("{name}, condition {:.2e}: expected {expected:?}, got {wrong}", layout.condition())
            });
            (expected, fault, outcome.is_ok())
        })
        .collect();
    let mut tally: BTreeMap<Expected, [usize; 2]> = BTreeMap::new();
    for (expected, _, accepted) in &outcomes {
        tally.entry(*expected).or_default()[usize::from(*accepted)] += 1;
    }
    for (expected, [refused, accepted]) in tally {
        println!("{solver}, noise {noise}: {expected:?}: {accepted} located, {refused} refused");
    }
    outcomes.into_iter().filter_map(|(_, fault, _)| fault).collect()
}

fn assert_none(faults: &[String]) {
    assert!(faults.is_empty(), "{} layouts:\n{}", faults.len(), faults.join("\n"));
}

/// The corpus says something of as many layouts as it is there for, of every fixture, and on both sides.
#[test]
fn the_corpus_is_large_and_of_every_kind() {
    const LEAST: usize = 500;
    let mut decided: BTreeMap<(String, Expected), usize> = BTreeMap::new();
    for layout in corpus() {
        *decided.entry((layout.fixture.kind().to_owned(), layout.expected())).or_default() += 1;
    }
    println!("{decided:?}");
    let firm = decided.iter().filter(|((_, expected), _)| *expected != Expected::Either);
    assert!(firm.map(|(_, count)| count).sum::<usize>() >= LEAST);
    for kind in ["cylinder-plane", "three-sphere", "cube", "composite"] {
        for expected in [Expected::Located, Expected::Refused] {
            assert!(decided[&(kind.to_owned(), expected)] >= 15, "{kind}, {expected:?}");
        }
    }
}

/// The touches lie on the surfaces of the fixture that stands at the frame: the file is what it says.
#[test]
fn touches_lie_on_their_surfaces() {
    /// In stated sigmas: the touches are written to a twentieth.
    const WRITTEN: f64 = 0.2;
    for layout in corpus() {
        let sigma = layout.measurement.probe.sigma.unwrap();
        for (surface, at) in layout.contacts() {
            let off = surface.seen_from(&layout.truth.to_fixture(&at)).0;
            assert!(off.abs() < WRITTEN * sigma, "{}: {off:e}", layout.line.name);
        }
    }
}

#[test]
fn least_squares_says_what_the_oracle_says() {
    assert_none(&faults("least-squares", 0.0, true));
}

/// Noise may cost an acceptance; it never makes a frame wrong, nor a free motion seen; some motion is told.
#[test]
fn least_squares_is_never_wrong_under_noise() {
    assert_none(&faults("least-squares", 1.0, false));
}

/// Its own unknown, the radius, leaves more motions free than the known one does: what is sound may be refused.
#[test]
fn the_closed_form_is_never_wrong() {
    assert_none(&faults("closed-form", 0.0, false));
}
