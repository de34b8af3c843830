//! Where a frame is used: points that move with the fixture.

use nalgebra::Point3;
use touchref::{Registry, Solution};

use crate::{
    failure::Failure,
    setup::{MeasurementArgs, NearArgs, Setup, SolverArgs, solve},
};

/// A measurement, and where its frame is used.
#[derive(Debug, clap::Args)]
pub(crate) struct UseArgs {
    #[command(flatten)]
    measurement: MeasurementArgs,
    #[command(flatten)]
    near: NearArgs,
    #[command(flatten)]
    points: PointArgs,
}

/// A measurement whose frame was accepted, and where that is used.
#[derive(Debug)]
pub(crate) struct InUse {
    pub(crate) setup: Setup,
    pub(crate) solution: Solution,
    pub(crate) points: Vec<Point3<f64>>,
}

impl UseArgs {
    /// Locates the fixture with the default solver.
    pub(crate) fn locate(&self, registry: &Registry) -> Result<InUse, Failure> {
        let solver = SolverArgs::default().build(registry, &[])?;
        let near = self.near.frame()?;
        let setup = self.measurement.load(registry)?;
        let solution = solve(&setup, &*solver, near)?;
        Ok(InUse { setup, solution, points: self.points.points() })
    }
}

/// Points of use, from the arguments.
#[derive(Debug, clap::Args)]
pub(crate) struct PointArgs {
    /// A point where the frame is used, in fixture coordinates; may be repeated [default: the fixture's origin; of `plan`
    /// and `guide` also one fixture size along each axis to either side]
    #[arg(long = "at", value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point)]
    points: Vec<Point3<f64>>,
}

impl PointArgs {
    /// The points.
    pub(crate) fn points(&self) -> Vec<Point3<f64>> {
        self.given().unwrap_or_else(|| vec![Point3::origin()])
    }

    /// The points, where some are given.
    pub(crate) fn given(&self) -> Option<Vec<Point3<f64>>> {
        (!self.points.is_empty()).then(|| self.points.clone())
    }
}

/// A point, for an argument.
pub(crate) fn point(text: &str) -> Result<Point3<f64>, String> {
    let numbers = text.split(',').map(|number| number.trim().parse::<f64>());
    let numbers = numbers.collect::<Result<Vec<f64>, _>>().ok().filter(|n| n.iter().all(|v| v.is_finite()));
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Point3::new(x, y, z)),
        _ => Err("expected three finite numbers, as 100,0,-25.5".to_owned()),
    }
}
