//! The corpus of layouts that leave a motion free, nearly do, or do not: `layouts.ndjson`, made and judged by
//! `layouts.py`, which shares no code with the library. What is free is refused and told; what is sound is located.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

use std::{collections::BTreeMap, path::Path};

use nalgebra::{Matrix3, Point3, Vector6};
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::Value;
use touchref::{
    Fixture, Frame, Motion, Parameters, Problem, Registry, Solution, SolveError, Touch, io::Measurement,
};

/// Above this condition a motion is free.
const FREE: f64 = 1e8;
/// Below this condition a layout is sound.
const SOUND: f64 = 1e4;

/// A line of the corpus: see `layouts.py`.
#[derive(Deserialize)]
struct Line {
    name: String,
    measurement: Value,
    frame: [f64; 12],
    short: bool,
    condition: Option<f64>,
    free: Vec<[f64; 6]>,
}

struct Layout {
    line: Line,
    measurement: Measurement,
    fixture: Box<dyn Fixture>,
    touches: Vec<Touch>,
    truth: Frame,
}

fn corpus() -> Vec<Layout> {
    let registry = touchref::registry().unwrap();
    include_str!("layouts.ndjson").lines().map(|line| layout(&registry, line)).collect()
}

fn layout(registry: &Registry, line: &str) -> Layout {
    let line: Line = serde_json::from_str(line).unwrap();
    let text = line.measurement.to_string();
    let measurement = Measurement::from_text("layouts.json", &text, Path::new("")).unwrap();
    let fixture = measurement.fixture(registry).unwrap();
    let touches = measurement.touches(&*fixture).unwrap().touches;
    let [x, y, z, axes @ ..] = line.frame;
    let rotation = nalgebra::Rotation3::from_matrix(&Matrix3::from_row_slice(&axes));
    Layout { truth: Frame { rotation, origin: Point3::new(x, y, z) }, measurement, fixture, touches, line }
}

impl Layout {
    fn solve(&self, solver: &str) -> Result<Solution, SolveError> {
        let solver = touchref::registry().unwrap().solver(solver).unwrap().build(&Parameters::new()).unwrap();
        solver.solve(&Problem::new(&*self.fixture, &self.touches, self.measurement.probe).unwrap())
    }

    /// How far a motion is from those that no touch resists, degrees.
    fn off_by(&self, motion: &Motion) -> f64 {
        let w = motion.twist.rotation;
        let v = motion.twist.translation + w.cross(&(self.truth.origin - motion.about));
        let size = self.fixture.size();
        let motion = Vector6::new(v.x, v.y, v.z, w.x * size, w.y * size, w.z * size);
        let free = self.line.free.iter().map(|free| Vector6::from_row_slice(free));
        let within: Vector6<f64> = free.map(|basis| basis * basis.dot(&motion)).sum();
        (motion - within).norm().atan2(within.norm()).to_degrees()
    }

    fn condition(&self) -> f64 {
        self.line.condition.unwrap_or(f64::INFINITY)
    }
}

/// The weak motion of a refusal.
fn told(refusal: &SolveError) -> Option<&Motion> {
    match refusal {
        SolveError::Degenerate(degenerate) => Some(&degenerate.free),
        other => Some(&other.refusal()?.observability.as_ref()?.weakest),
    }
}

#[test]
fn explore() {
    for solver in ["closed-form", "least-squares"] {
        let mut verdicts: BTreeMap<(String, &str, &str, String), usize> = BTreeMap::new();
        let outcomes: Vec<_> = corpus()
            .into_par_iter()
            .map(|layout| {
                let start = std::time::Instant::now(); eprintln!("START {}", layout.line.name);
                let outcome = layout.solve(solver);
                if start.elapsed().as_secs_f64() > 0.3 { eprintln!("SLOW {} {solver} {:.2}", layout.line.name, start.elapsed().as_secs_f64()); }
                (layout, outcome)
            })
            .collect();
        for (layout, outcome) in &outcomes {
            let class = match layout.condition() {
                c if c > FREE => "free",
                c if c < SOUND => "sound",
                _ => "between",
            };
            let mut code = outcome.as_ref().err().map_or("ok", SolveError::code).to_owned();
            if let Err(refusal) = outcome
                && class == "free"
            {
                match told(refusal) {
                    Some(motion) => {
                        let off = layout.off_by(motion);
                        if off > 1.0 {
                            code = format!("{code} WRONG {off:.1} {} {motion}", layout.line.name);
                        }
                    }
                    None => code = format!("{code} UNTOLD {} {refusal}", layout.line.name),
                }
            }
            if class == "sound" && code != "ok" {
                code = format!("{code} {} {:.1} {}", layout.line.name, layout.condition(), outcome.as_ref().unwrap_err());
            }
            if let Ok(solution) = outcome {
                let error = layout.truth.twist_to(&solution.frame);
                let off = error.translation.norm().max(error.rotation.norm() * layout.fixture.size());
                if off > 1e-3 {
                    code = format!("{code} OFF {off:.1e} {}", layout.line.name);
                }
            }
            *verdicts
                .entry((layout.fixture.kind().to_owned(), class, if layout.line.short { "short" } else { "" }, code))
                .or_default() += 1;
        }
        for (key, count) in verdicts {
            println!("{solver} {key:?}: {count}");
        }
    }
}
