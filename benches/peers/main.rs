//! touchref beside its peers: one run, the same problems, interleaved rounds.
//!
//! ```text
//! benches/peers/run
//! ```
//!
//! builds all of it and writes `docs/speed_table.md` and `docs/figures/growth.svg`; docs/speed.md tells what is compared with
//! what. The peers in C++ and Python are programs that solve what this one asks of them ([`Program`]); one that is not there
//! is named in the table. With `--print` the table goes to standard output, with `--smoke` after three problems and one round.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)] // A bench may panic, and tells its figures.

#[path = "../columns/mod.rs"]
mod columns;
mod method;
mod plot;
#[path = "../rounds/mod.rs"]
mod rounds;
mod set;
#[path = "../../tests/support/mod.rs"]
mod support;
mod table;
#[path = "../vectors/mod.rs"]
mod vectors;

use std::{cell::RefCell, env, fs, path::Path, process::Command};

use arrow_array::{Array, RecordBatch, cast::AsArray, types::Float64Type};
use faer::Mat;
use levenberg_marquardt::LevenbergMarquardt;
use method::{Asked, Each, Program, Run};
use nalgebra::{Point3, SVector};
use nalgebra_0_34::{Const, Dyn};
use rayon::{ThreadPool, ThreadPoolBuilder};
use rounds::Rounds;
use set::{Measurement, PROBE, Set};
use support::companion::{Equations, companion, companion_roots};
use touchref::{
    Fixture, Frame, Problem, Solver, Units,
    batch::Locator,
    solvers::refinement::{descend, refine},
};
use vectors::{by_gauss_newton, by_levenberg_marquardt, by_library_bounds};

const SEED: u64 = 20_261_123;
const RADIUS: f64 = 25.0;
const ANGLE_DEG: f64 = 45.0;
const SIGMA: f64 = 0.01;
const PROBLEMS: usize = 200;
/// With so many touches, a tenth of the problems takes long enough.
const MANY: usize = 10_000;
const ROUNDS: usize = 31;
/// Of a method in a round, nanoseconds: a slow one solves as many of the problems as it can in this, a fast one all of them
/// so often that it takes this.
const MOST: f64 = 1e8;
const LEAST: f64 = 1e6;
/// What is nearer than this to the least-squares frame is that frame: length, a hundredth of the noise; radians, less than
/// that at the fixture's size.
const SAME: (f64, f64) = (1e-4, 1e-6);
/// An axis that is farther off than a degree (radians) is another one.
const SAME_AXIS: f64 = 0.017_453;

/// What a method finds, and by what it is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Task {
    /// Roots of the equations: by nothing here; tests judge them.
    Roots,
    /// A frame from the touches: by the least-squares frame.
    Whole,
    /// A root of the equations as the frame: by the least-squares frame, from which noise keeps it.
    Root,
    /// The least-squares frame from the start.
    Refinement,
    /// An axis: by that of the least-squares frame.
    Axis,
}

/// A method over the problems of a set.
struct Method<'a> {
    name: &'static str,
    task: Task,
    /// Or why it is absent.
    run: Result<Box<dyn Run + 'a>, String>,
}

/// How a method did with a set.
#[derive(Debug, Clone)]
struct Outcome {
    name: &'static str,
    task: Task,
    /// Or why it is absent.
    ends: Result<Ends, String>,
}

/// Where a method ended.
#[derive(Debug, Clone, Copy, Default)]
struct Ends {
    solved: usize,
    /// Of these, how many without a frame, and with another one than the least-squares frame.
    refused: usize,
    elsewhere: usize,
    /// How far the others are from it at most: length, and radians.
    farthest: (f64, f64),
}

/// What was measured with a set.
struct Measured<'a> {
    set: &'a Set,
    outcomes: Vec<Outcome>,
    /// Of those that are not absent, in their order.
    rounds: Rounds,
}

impl Measured<'_> {
    fn place(&self, name: &str) -> Option<usize> {
        self.outcomes.iter().filter(|outcome| outcome.ends.is_ok()).position(|outcome| outcome.name == name)
    }

    /// The median time of a problem, nanoseconds.
    fn time(&self, name: &str) -> Option<f64> {
        Some(self.rounds.time(self.place(name)?))
    }

    /// How many times as long as another method one takes.
    fn ratio(&self, name: &str, other: &str) -> Option<f64> {
        Some(self.rounds.ratio(self.place(name)?, self.place(other)?))
    }
}

const EVERY_ROOT: &str = "touchref: closed form, every frame";
const REFINEMENT: &str = "touchref: refinement";
const UNAIDED: &str = "touchref: closed form, choice, refinement";
const LOCATE: &str = "touchref: honest locate";
const TINY: &str = "`ceres::TinySolver`";
const TINY_TIGHT: &str = "`ceres::TinySolver`, to rounding";
const CERES: &str = "`ceres::Solve`";
const CERES_TIGHT: &str = "`ceres::Solve`, to rounding";
const CRATE: &str = "`levenberg-marquardt` crate";
const CRATE_TIGHT: &str = "`levenberg-marquardt` crate, to rounding";
const GAUSS_NEWTON: &str = "argmin's `GaussNewton`";
const SCIPY: &str = "SciPy `least_squares`, `lm`";
const SCIPY_TIGHT: &str = "SciPy `least_squares`, `lm`, to rounding";
const COMPANION: &str = "companion matrix, nalgebra: touches to angles";

fn main() {
    // Cargo adds an argument of its own.
    let arguments: Vec<String> = env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let smoke = arguments.iter().any(|argument| argument == "--smoke");
    let fixture = support::cylinder_plane(RADIUS, ANGLE_DEG);
    let sets = sets(&*fixture, smoke);
    let folder = env::temp_dir().join(format!("touchref-peers-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    for set in &sets {
        set.write(&folder).unwrap();
    }
    let programs = Programs::start(&folder);
    let rounds = if smoke { 1 } else { ROUNDS };
    let measured: Vec<Measured<'_>> =
        sets.iter().map(|set| measured(&*fixture, set, &programs, rounds)).collect();
    let table = table::markdown(&measured, &programs.versions());
    drop(programs);
    fs::remove_dir_all(&folder).unwrap();
    if smoke || arguments.iter().any(|argument| argument == "--print") {
        println!("{table}");
    } else {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
        fs::create_dir_all(docs.join("figures")).unwrap();
        fs::write(docs.join("speed_table.md"), table).unwrap();
        let lines = [REFINEMENT, LOCATE, TINY, CRATE, CERES, SCIPY];
        fs::write(docs.join("figures/growth.svg"), plot::growth(&measured, &lines)).unwrap();
    }
}

fn sets(fixture: &dyn Fixture, smoke: bool) -> Vec<Set> {
    let random = [
        ("7", [4, 3]),
        ("12", [7, 5]),
        ("30", [18, 12]),
        ("100", [60, 40]),
        ("1000", [600, 400]),
        ("10000", [6000, 4000]),
    ];
    let problems = |touches| match touches {
        _ if smoke => 3,
        MANY => PROBLEMS / 10,
        _ => PROBLEMS,
    };
    let nominal = Set::draw(fixture, "7-nominal", [4, 3], true, problems(7));
    let random =
        random.map(|(name, counts)| Set::draw(fixture, name, counts, false, problems(counts.iter().sum())));
    std::iter::once(nominal).chain(random).collect()
}

/// The peers that are programs; or why one is absent.
struct Programs {
    ceres: Result<RefCell<Program>, String>,
    python: Result<RefCell<Program>, String>,
}

impl Programs {
    fn start(folder: &Path) -> Self {
        let start = |variable: &str, script: Option<&str>| {
            let path = env::var_os(variable).ok_or("not installed")?;
            Program::start(Command::new(path).args(script), folder).map(RefCell::new)
        };
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peers/peers.py");
        Self { ceres: start("PEERS_CERES", None), python: start("PEERS_PYTHON", Some(script)) }
    }

    fn versions(&self) -> Vec<String> {
        let both = [("Ceres", &self.ceres), ("Python", &self.python)];
        let told = both.map(|(name, program)| match program {
            Ok(program) => program.borrow().versions.clone(),
            Err(why) => format!("{name}: {why}"),
        });
        told.to_vec()
    }
}

/// Measures every method with a set, in interleaved rounds.
fn measured<'a>(fixture: &dyn Fixture, set: &'a Set, programs: &Programs, rounds: usize) -> Measured<'a> {
    let problems: Vec<Problem<'_>> =
        set.measurements.iter().map(|m| Problem::new(fixture, &m.touches, PROBE).unwrap()).collect();
    let goals: Vec<Frame> = problems
        .iter()
        .zip(&set.measurements)
        .map(|(problem, m)| refine(problem, &m.start).map_or(m.start, |end| end.unknowns.frame))
        .collect();
    let solver = support::solver("least-squares");
    let mut methods = ours(fixture, &*solver, set, &problems);
    methods.extend(crates(set, &problems));
    methods.extend(others(set, programs));

    let mut outcomes = Vec::new();
    let mut timed: Vec<(Box<dyn Run + '_>, usize, usize)> = Vec::new();
    for Method { name, task, run } in methods {
        let ends = run.map(|mut run| {
            // What is loaded or chosen the first time is not timed.
            run.nanoseconds(1, 1);
            let one = run.nanoseconds(1, 1);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            // Positive, and at most thousands.
            let times = |budget: f64, all: f64, most: usize| ((budget / all) as usize).clamp(1, most);
            let count = times(MOST, one, set.measurements.len());
            let all = run.nanoseconds(count, 1);
            let repeats = times(LEAST, all, PROBLEMS);
            let ends = judged(task, &run.frames(count), &goals);
            timed.push((run, count, repeats));
            ends
        });
        outcomes.push(Outcome { name, task, ends });
    }
    let rounds = Rounds::measured(rounds, timed.len(), |method| {
        let (run, count, repeats) = &mut timed[method];
        if *repeats > 1 {
            // Others have had the caches.
            run.nanoseconds(*count, 1);
        }
        run.nanoseconds(*count, *repeats) / (*count * *repeats) as f64
    });
    eprintln!("{}: done", set.name);
    Measured { set, outcomes, rounds }
}

fn judged(task: Task, frames: &[Option<Frame>], goals: &[Frame]) -> Ends {
    let mut ends = Ends { solved: frames.len(), ..Ends::default() };
    if task == Task::Roots {
        return ends;
    }
    for (frame, goal) in frames.iter().zip(goals) {
        let Some(frame) = frame else {
            ends.refused += 1;
            continue;
        };
        let off = goal.twist_to(frame);
        let (moved, turned) = match task {
            Task::Axis => (0.0, goal.axis(2).cross(&frame.axis(2)).norm()),
            _ => (off.translation.norm(), off.rotation.norm()),
        };
        let same = match task {
            Task::Axis => turned <= SAME_AXIS,
            Task::Root => true,
            _ => moved <= SAME.0 && turned <= SAME.1,
        };
        if same {
            ends.farthest = (ends.farthest.0.max(moved), ends.farthest.1.max(turned));
        } else {
            ends.elsewhere += 1;
        }
    }
    ends
}

/// The library's own ways.
fn ours<'a>(
    fixture: &'a dyn Fixture,
    solver: &'a dyn Solver,
    set: &'a Set,
    problems: &'a [Problem<'a>],
) -> Vec<Method<'a>> {
    let every_root = move |index: usize| {
        std::hint::black_box(set::every_root(&problems[index]));
        None
    };
    let locator =
        Locator { fixture, solver, probe: PROBE, units: Units::Millimetre, near: None, fast: false };
    vec![
        here(EVERY_ROOT, Task::Roots, every_root),
        here("touchref: closed form and choice", Task::Root, move |index| set::start(&problems[index])),
        here(REFINEMENT, Task::Refinement, move |index| {
            Some(descend(&problems[index], &set.measurements[index].start).frame)
        }),
        here(UNAIDED, Task::Refinement, move |index| {
            Some(descend(&problems[index], &set::start(&problems[index])?).frame)
        }),
        here(LOCATE, Task::Whole, move |index| Some(solver.solve(&problems[index]).ok()?.frame)),
        Method {
            name: "touchref: batch from memory, one thread",
            task: Task::Whole,
            run: Ok(Box::new(Batch::new(locator, set))),
        },
        Method {
            name: "touchref: batch from memory, plain ones at once, one thread",
            task: Task::Whole,
            run: Ok(Box::new(Batch::new(Locator { fast: true, ..locator }, set))),
        },
    ]
}

fn here<'a>(name: &'static str, task: Task, solve: impl Fn(usize) -> Option<Frame> + 'a) -> Method<'a> {
    Method { name, task, run: Ok(Box::new(Each(solve))) }
}

/// The problems of a set as the rows of one table.
struct Batch<'a> {
    locator: Locator<'a>,
    touches: RecordBatch,
    of_one: usize,
    pool: ThreadPool,
}

impl<'a> Batch<'a> {
    fn new(locator: Locator<'a>, set: &Set) -> Self {
        let touches = set.measurements.iter().map(|Measurement { touches, .. }| touches.clone());
        let touches: Vec<_> = (0..).zip(touches).collect();
        Self {
            locator,
            touches: columns::record_batch(locator.fixture, &touches),
            of_one: set.touches(),
            pool: ThreadPoolBuilder::new().num_threads(1).build().unwrap(),
        }
    }

    fn locate(&self, count: usize) -> RecordBatch {
        let touches = self.touches.slice(0, count * self.of_one);
        self.pool.install(|| self.locator.locate(&touches)).unwrap()
    }
}

impl Run for Batch<'_> {
    fn nanoseconds(&mut self, count: usize, repeats: usize) -> f64 {
        method::nanoseconds(|| {
            for _ in 0..repeats {
                std::hint::black_box(self.locate(count));
            }
        })
    }

    fn frames(&mut self, count: usize) -> Vec<Option<Frame>> {
        let frames = self.locate(count);
        let column = |name: &str| frames.column_by_name(name).unwrap().as_primitive::<Float64Type>();
        let [x, y, z, i, j, k, w] = ["x", "y", "z", "qx", "qy", "qz", "qw"].map(column);
        let frame = |row: usize| {
            let numbers = [x, y, z, i, j, k, w].map(|column| column.is_valid(row).then(|| column.value(row)));
            let [x, y, z, i, j, k, w] = numbers;
            Frame::from_quaternion_xyzw(Point3::new(x?, y?, z?), [i?, j?, k?, w?])
        };
        (0..frames.num_rows()).map(frame).collect()
    }
}

/// Other crates.
fn crates<'a>(set: &'a Set, problems: &'a [Problem<'a>]) -> Vec<Method<'a>> {
    let by_crate = |solver: LevenbergMarquardt<f64>| {
        move |index: usize| {
            let (problem, start) = (&problems[index], &set.measurements[index].start);
            // Matrices of fixed size as long as they are small.
            let end = match set.touches() {
                7 => by_levenberg_marquardt::<Const<7>>(&solver, problem, start),
                12 => by_levenberg_marquardt::<Const<12>>(&solver, problem, start),
                30 => by_levenberg_marquardt::<Const<30>>(&solver, problem, start),
                _ => by_levenberg_marquardt::<Dyn>(&solver, problem, start),
            };
            Some(end.frame)
        }
    };
    let mut methods = vec![
        here(CRATE, Task::Refinement, by_crate(by_library_bounds())),
        here(CRATE_TIGHT, Task::Refinement, by_crate(LevenbergMarquardt::new())),
        here(GAUSS_NEWTON, Task::Refinement, move |index| {
            Some(by_gauss_newton(&problems[index], &set.measurements[index].start)?.frame)
        }),
    ];
    if set.touches() == 7 {
        let equations = move |index: usize| {
            let at = |touch: usize| set.measurements[index].touches[touch].at;
            Equations::new(&[0, 1, 2, 3].map(at), &[4, 5, 6].map(at), ANGLE_DEG.to_radians())
        };
        let polynomials: Vec<SVector<f64, 7>> =
            (0..problems.len()).map(|index| equations(index).polynomial()).collect();
        let of_faer = polynomials.clone();
        methods.extend([
            here(COMPANION, Task::Roots, move |index| {
                std::hint::black_box(equations(index).roots());
                None
            }),
            here("companion matrix, nalgebra: eigenvalues alone", Task::Roots, move |index| {
                std::hint::black_box(companion_roots(&polynomials[index]));
                None
            }),
            here("companion matrix, faer: eigenvalues alone", Task::Roots, move |index| {
                let matrix = companion(&of_faer[index]);
                let matrix = Mat::<f64>::from_fn(6, 6, |row, column| matrix[(row, column)]);
                let _ = std::hint::black_box(matrix.eigenvalues());
                None
            }),
        ]);
    }
    methods
}

/// Other programs.
fn others<'a>(set: &'a Set, programs: &'a Programs) -> Vec<Method<'a>> {
    let asked = |name, task, program: &'a Result<RefCell<Program>, String>, method| {
        let run = program.as_ref().map_err(Clone::clone);
        let run = run.map(|program| Box::new(Asked { program, method, set }) as Box<dyn Run + 'a>);
        Method { name, task, run }
    };
    let Programs { ceres, python } = programs;
    let mut methods = vec![
        asked(TINY, Task::Refinement, ceres, "tiny-solver"),
        asked(TINY_TIGHT, Task::Refinement, ceres, "tiny-solver-tight"),
        asked(CERES, Task::Refinement, ceres, "ceres"),
        asked(CERES_TIGHT, Task::Refinement, ceres, "ceres-tight"),
        asked(SCIPY, Task::Refinement, python, "scipy"),
        asked(SCIPY_TIGHT, Task::Refinement, python, "scipy-tight"),
    ];
    if set.touches() == 7 {
        methods.push(asked("NumPy closed form, `np.roots`", Task::Root, python, "numpy-closed-form"));
    }
    // It wants more than four touches, and minutes for many.
    if (8..MANY).contains(&set.touches()) {
        methods.push(asked(
            "scikit-spatial `Cylinder.best_fit` (cylinder touches alone)",
            Task::Axis,
            python,
            "scikit-spatial",
        ));
    }
    methods
}
