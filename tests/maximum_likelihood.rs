//! `least-squares` held against maximum-likelihood frames at 60 digits: every fixture, every kind of noise, sizes and
//! tip radius exact or uncertain.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A test may panic, and tells its figures.

mod support;

use std::fmt;

use nalgebra::{Matrix3, Matrix6, Point3, Rotation3};
use serde_json::Value as Json;
use touchref::{Fixture, Frame, Parameters, Probe, Problem, Solution, SolveError, Touch, Value};

/// Cases of each fixture that the oracle must at least hold.
const CASES: usize = 50;

/// One case of `tests/oracle/maximum_likelihood.json`.
struct Case {
    json: Json,
    fixture: Box<dyn Fixture>,
    touches: Vec<Touch>,
    probe: Probe,
}

impl Case {
    fn read(json: &Json) -> Self {
        let kind = json["fixture"]["kind"].as_str().unwrap();
        let fixture = support::fixture(kind, &parameters(&json["fixture"]));
        let touches = json["touches"].as_array().unwrap().iter().map(|touch| read_touch(&*fixture, touch));
        let touches = touches.collect();
        let (tip_radius, tip_radius_u) = number(&json["probe"]["tip_radius"]);
        let probe = Probe { tip_radius, tip_radius_u, sigma: json["probe"]["sigma"].as_f64() };
        Self { json: json.clone(), fixture, touches, probe }
    }

    fn problem(&self) -> Problem<'_> {
        Problem::new(&*self.fixture, &self.touches, self.probe).unwrap()
    }

    fn frame(&self) -> Frame {
        let rotation = Matrix3::from_fn(|i, j| self.json["frame"]["rotation"][i][j].as_f64().unwrap());
        Frame {
            rotation: Rotation3::from_matrix_unchecked(rotation),
            origin: Point3::from(numbers::<3>(&self.json["frame"]["origin"])),
        }
    }

    fn solve(&self) -> Result<Solution, SolveError> {
        let problem = self.problem();
        // Where two frames fit, the expected one decides.
        let ambiguous = self.json["ambiguous"].as_bool().unwrap();
        let problem = if ambiguous { problem.near(self.frame()) } else { problem };
        support::solver("least-squares").solve(&problem)
    }

    /// Largest distance of a touch from the parent's origin: coordinates are rounded to 1e-16 of it.
    fn reach(&self) -> f64 {
        self.touches.iter().map(|touch| touch.at.coords.norm()).fold(0.0, f64::max)
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.fixture.kind(), self.json["name"].as_str().unwrap())
    }
}

fn oracle(kind: &str) -> Vec<Case> {
    let all: Json = serde_json::from_str(include_str!("oracle/maximum_likelihood.json")).unwrap();
    let of_kind = all["cases"].as_array().unwrap().iter().filter(|case| case["fixture"]["kind"] == kind);
    let cases: Vec<Case> = of_kind.map(Case::read).collect();
    assert!(cases.len() >= CASES, "{kind}: {} cases", cases.len());
    cases
}

fn numbers<const N: usize>(json: &Json) -> [f64; N] {
    std::array::from_fn(|i| json[i].as_f64().unwrap())
}

/// A number and its standard uncertainty, which is 0 where none is stated.
fn number(json: &Json) -> (f64, f64) {
    json.as_f64().map_or_else(|| (json["value"].as_f64().unwrap(), json["u"].as_f64().unwrap()), |v| (v, 0.0))
}

fn parameters(json: &Json) -> Parameters {
    let mut parameters = Parameters::new();
    for (name, json) in json.as_object().unwrap().iter().filter(|(name, _)| *name != "kind") {
        let value = match json {
            Json::Bool(flag) => Value::from(*flag),
            Json::String(word) => Value::from(word.as_str()),
            Json::Array(_) => Value::from(numbers::<3>(json)),
            _ => {
                let (value, u) = number(json);
                Value::Number { value, u }
            }
        };
        parameters.set(name, value);
    }
    parameters
}

fn read_touch(fixture: &dyn Fixture, json: &Json) -> Touch {
    let touch = fixture.touch(json["surface"].as_str().unwrap(), numbers(&json["at"])).unwrap();
    match (json["sigma"].as_f64(), json.get("covariance")) {
        (Some(sigma), None) => touch.with_sigma(sigma),
        (None, Some(rows)) => touch.with_covariance(Matrix3::from_fn(|i, j| rows[i][j].as_f64().unwrap())),
        (None, None) => touch,
        both => panic!("a touch has one noise: {both:?}"),
    }
}

/// What of a solution is compared, and how far it may be off.
const COMPARED: [(&str, f64); 8] = [
    ("origin, in fixture sizes", 1e-9),
    ("rotation, in radians", 1e-9),
    ("variances, relative", 1e-5),
    ("covariances, in standard deviations", 1e-5),
    ("chi-square, absolute and relative", 1e-6),
    ("residuals, in fixture sizes", 1e-9),
    ("uncertain quantities, in fixture sizes or radians", 1e-9),
    ("their uncertainties, relative", 1e-5),
];

/// How far a solution is off, in the order of [`COMPARED`].
fn off(case: &Case, solution: &Solution) -> [f64; COMPARED.len()] {
    let (size, frame) = (case.fixture.size(), case.frame());
    let rotation = solution.frame.rotation.matrix() - frame.rotation.matrix();

    let covariance = Matrix6::from_fn(|i, j| case.json["covariance"][i][j].as_f64().unwrap());
    let deviations = covariance.diagonal().map(f64::sqrt);
    let difference = solution.covariance.as_ref().unwrap().matrix - covariance;
    let difference = difference.component_div(&(deviations * deviations.transpose())).abs();

    let chi_square = case.json["chi_square"].as_f64().unwrap();
    let residuals = case.json["residuals"].as_array().unwrap();
    assert_eq!(solution.residuals.len(), residuals.len(), "{case}");
    let residuals = solution.residuals.iter().zip(residuals);
    let [quantities, uncertainties] = off_in_quantities(case, solution);
    [
        (solution.frame.origin - frame.origin).norm() / size,
        // A small rotation has twice the square of its angle in the squares of its matrix.
        rotation.norm() / 2.0_f64.sqrt(),
        difference.diagonal().max(),
        difference.max(),
        (solution.chi_square.unwrap() - chi_square).abs() / (1.0 + chi_square),
        residuals.map(|(got, want)| (got.length - want.as_f64().unwrap()).abs()).fold(0.0, f64::max) / size,
        quantities,
        uncertainties,
    ]
}

/// How far what was uncertain of fixture and tip is off, at most, and how far its uncertainty.
fn off_in_quantities(case: &Case, solution: &Solution) -> [f64; 2] {
    let quantities = case.json["quantities"].as_array().unwrap();
    assert_eq!(solution.adjustments.len(), quantities.len(), "{case}");
    let mut worst = [0.0_f64; 2];
    for quantity in quantities {
        let name = quantity["name"].as_str().unwrap();
        let adjusted = solution.adjustments.iter().find(|adjusted| adjusted.name == name);
        let adjusted = adjusted.unwrap_or_else(|| panic!("{case}: `{name}` was no unknown"));
        let (value, u) = number(quantity);
        let unit = if name == "angle_deg" { 1.0_f64.to_degrees() } else { case.fixture.size() };
        assert!(adjusted.value.is_finite() && adjusted.u.is_finite(), "{case}: {adjusted:?}");
        worst[0] = worst[0].max((adjusted.value - value).abs() / unit);
        worst[1] = worst[1].max((adjusted.u / u - 1.0).abs());
    }
    worst
}

/// Solves every case of a fixture; tells the worst of each figure, and every case that is refused or off.
fn hold_to_the_oracle(kind: &str) {
    let mut worst = [0.0_f64; COMPARED.len()];
    let mut failures = Vec::new();
    for case in oracle(kind) {
        let solution = match case.solve() {
            Ok(solution) => solution,
            Err(refusal) => {
                failures.push(format!("{case}: {}: {refusal}", refusal.code()));
                continue;
            }
        };
        let degrees = case.json["degrees_of_freedom"].as_u64().unwrap();
        assert_eq!(solution.degrees_of_freedom as u64, degrees, "{case}");
        for ((worst, off), (what, bound)) in worst.iter_mut().zip(off(&case, &solution)).zip(COMPARED) {
            *worst = worst.max(off);
            if off.is_nan() || off > bound {
                failures.push(format!("{case}: {what}: off by {off:.1e}"));
            }
        }
    }
    for ((what, bound), worst) in COMPARED.iter().zip(worst) {
        println!("{kind}: {what}: off by at most {worst:.1e}, {bound:.0e} allowed");
    }
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn cylinder_plane() {
    hold_to_the_oracle("cylinder-plane");
}

#[test]
fn three_sphere() {
    hold_to_the_oracle("three-sphere");
}

#[test]
fn cube() {
    hold_to_the_oracle("cube");
}

/// Library and oracle mean the same surfaces: at the oracle's frame, with the sizes that it found, each touch is as
/// far from its surface as the oracle says.
fn share_the_geometry(kind: &str) {
    /// Roundings of coordinates and of the printed frame, in units of the last place of the farthest coordinate.
    const ROUNDINGS: f64 = 10.0;
    let mut worst = 0.0_f64;
    for case in oracle(kind) {
        let mut sizes = parameters(&case.json["fixture"]);
        let mut probe = case.probe;
        for quantity in case.json["quantities"].as_array().unwrap() {
            let value = quantity["value"].as_f64().unwrap();
            match quantity["name"].as_str().unwrap() {
                "tip_radius" => probe.tip_radius = value,
                name => sizes.set(name, Value::from(value)),
            }
        }
        let fixture = support::fixture(kind, &sizes);
        let problem = Problem::new(&*fixture, &case.touches, probe).unwrap();
        for (index, expected) in case.json["residuals"].as_array().unwrap().iter().enumerate() {
            let residual = problem.contact(&case.frame(), index).residual;
            let off = (residual - expected.as_f64().unwrap()).abs() / (f64::EPSILON * case.reach());
            worst = worst.max(off);
            assert!(off <= ROUNDINGS, "{case}: touch {index}: {residual:e}, expected {expected}");
        }
    }
    println!("{kind}: residuals off by at most {worst:.1} roundings, {ROUNDINGS} allowed");
}

#[test]
fn geometry_of_cylinder_plane() {
    share_the_geometry("cylinder-plane");
}

#[test]
fn geometry_of_three_sphere() {
    share_the_geometry("three-sphere");
}

#[test]
fn geometry_of_cube() {
    share_the_geometry("cube");
}
