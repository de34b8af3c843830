//! `simulate`: what a probe would read on a fixture whose frame is known.

use std::{
    io::{self, Write},
    path::PathBuf,
};

use touchref::{
    Fixture, Frame, Probe, Registry,
    analysis::{Layout, contacts, random_layout, simulate, simulation::generator},
    io::{
        Units, read_frame,
        write::{Columns, Row, TableWriter},
    },
};

use crate::{
    failure::Failure,
    layout::{LayoutArgs, LayoutKind},
    output::{Output, write_file},
    setup::{MeasurementArgs, SolverArgs, no_sigma, solve},
};

/// Simulate touches: a touch table with noise, from a seed
///
/// The fixture stands where --frame says; else where the measurement's own touches place it; else it coincides with
/// the parent.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref simulate examples/cube.toml --seed 7 --count 3\n\
\x20 touchref simulate examples/three-sphere.toml --frame 10,20,30,0,0,0,1")]
pub(crate) struct Args {
    #[command(flatten)]
    measurement: MeasurementArgs,
    /// Seed of the noise: the same seed gives the same touches
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// How many placements; with more than one the table has a column `placement`
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    count: u64,
    #[command(flatten)]
    layout: LayoutArgs,
    /// True frame: x,y,z,qx,qy,qz,qw or a result file
    #[arg(long, value_name = "FRAME", allow_hyphen_values = true, value_hint = clap::ValueHint::FilePath)]
    frame: Option<String>,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// What is simulated, all of it known.
struct Plan {
    fixture: Box<dyn Fixture>,
    frame: Frame,
    probe: Probe,
    sigma: f64,
    units: Units,
    seed: u64,
    count: u64,
    contacts: Contacts,
}

/// Contact points on the fixture.
enum Contacts {
    /// These, each with what the user calls it.
    Fixed(Layout, Vec<Option<String>>),
    /// As many on each surface, anew for every placement.
    Random(Vec<usize>),
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let frame =
            self.frame.as_deref().map(read_frame).transpose().map_err(|error| error.with_key("frame"))?;
        let setup = self.measurement.load(registry)?;
        let sigma = setup.measurement.probe.sigma.ok_or_else(no_sigma)?;
        let layout = self.layout.kind(&setup);
        let measured = if layout == LayoutKind::Measurement || (setup.has_touches() && frame.is_none()) {
            Some(solve(&setup, &*SolverArgs::default().build(registry, &[])?, None)?.frame)
        } else {
            None
        };
        let true_frame = frame.or(measured).unwrap_or_else(Frame::identity);
        let contacts = match (layout, &measured) {
            (LayoutKind::Measurement, Some(frame)) => {
                let touches = setup.touches()?;
                let ids = touches.records.iter().map(|record| record.id.clone()).collect();
                Contacts::Fixed(contacts(&setup.problem()?, frame), ids)
            }
            (LayoutKind::Random, _) => Contacts::Random(self.layout.counts(&setup)?),
            _ => {
                let layout = setup.fixture.nominal_layout();
                let ids = vec![None; layout.len()];
                Contacts::Fixed(layout, ids)
            }
        };
        let plan = Plan {
            fixture: setup.fixture,
            frame: true_frame,
            probe: setup.measurement.probe,
            sigma,
            units: setup.measurement.units,
            seed: self.seed,
            count: self.count,
            contacts,
        };
        match &self.output {
            Some(path) => write_file(path, |output| plan.write(output)).map(|()| Output::nothing()),
            None => Ok(Output::stream(move |output| plan.write(output))),
        }
    }
}

impl Plan {
    fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        let (origin, quaternion) = (self.frame.origin, self.frame.quaternion_xyzw());
        let numbers = origin.iter().chain(&quaternion).map(f64::to_string).collect::<Vec<_>>().join(",");
        let units = self.units;
        let comments = [
            format!("simulated touches on `{}`: tip centres in {units}", self.fixture.kind()),
            format!(
                "seed {}, sigma {} {units}, tip radius {} {units}",
                self.seed, self.sigma, self.probe.tip_radius
            ),
            format!("true frame x,y,z,qx,qy,qz,qw: {numbers}"),
        ];
        let ids: &[Option<String>] = match &self.contacts {
            Contacts::Fixed(_, ids) => ids,
            Contacts::Random(_) => &[],
        };
        let columns = Columns { id: ids.iter().any(Option::is_some), placement: self.count > 1 };
        let mut table = TableWriter::new(output, &comments, columns)?;
        for trial in 0..self.count {
            let mut rng = generator(self.seed, trial);
            let drawn;
            let layout = match &self.contacts {
                Contacts::Fixed(layout, _) => layout,
                Contacts::Random(counts) => {
                    drawn = random_layout(&*self.fixture, counts, &mut rng);
                    &drawn
                }
            };
            let touches = simulate(&*self.fixture, layout, &self.frame, &self.probe, self.sigma, &mut rng);
            for (index, touch) in touches.iter().enumerate() {
                table.write(&Row {
                    surface: &self.fixture.surfaces()[touch.surface].name,
                    at: touch.at,
                    id: ids.get(index).and_then(Option::as_deref),
                    placement: Some(trial),
                })?;
            }
        }
        table.finish()
    }
}
