//! The figures, one file each; [`chart`] is what they are drawn with.

mod basins;
mod chart;
mod distance;
mod layouts;
mod rates;
mod roots;
mod scene;

use std::path::Path;

use touchref::{Fixture, Parameters, Solver, Touch, io::Measurement, locate::Setup};

/// Every figure: the name of its file, and the SVG.
pub(crate) fn all() -> Vec<(&'static str, String)> {
    vec![
        ("scene.svg", scene::drawn()),
        ("four-roots.svg", roots::of_the_paper()),
        ("six-roots.svg", roots::six()),
        ("basins.svg", basins::drawn()),
        ("layouts.svg", layouts::drawn()),
        ("rates.svg", rates::drawn()),
        ("distance.svg", distance::drawn()),
    ]
}

/// The worked example of Nederbragt and Ravani.
fn paper() -> Setup {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let text = std::fs::read_to_string(folder.join("nederbragt-ravani.toml")).unwrap();
    let measurement = Measurement::from_text("nederbragt-ravani.toml", &text, &folder).unwrap();
    Setup::new(measurement, &touchref::registry().unwrap()).unwrap()
}

fn fixture(kind: &str, parameters: &Parameters) -> Box<dyn Fixture> {
    touchref::registry().unwrap().fixture(kind).unwrap().build(parameters).unwrap()
}

/// The default solver, which looks for other frames as far as its own stands.
fn solver() -> Box<dyn Solver> {
    let full = Parameters::new().with("margin", "full");
    touchref::registry().unwrap().solver("least-squares").unwrap().build(&full).unwrap()
}

/// Touches of surfaces, by name.
fn touches(fixture: &dyn Fixture, of: &[(&str, &[[f64; 3]])]) -> Vec<Touch> {
    let on = |name: &str, at: &[f64; 3]| fixture.touch(name, *at).unwrap();
    of.iter().flat_map(|(name, points)| points.iter().map(|at| on(name, at))).collect()
}
