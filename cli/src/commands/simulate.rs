//! `simulate`: what a probe would read on a fixture whose frame is known.

use std::{
    io::{self, Write},
    path::PathBuf,
};

use clap::ValueEnum;
use touchref::{
    Fixture, Frame, Probe, Registry,
    analysis::{Layout, random_layout, simulate, simulation::generator},
    io::{
        InputError, TouchSource, Touches, Units, read_frame,
        write::{Columns, Row, TableWriter},
    },
};

use crate::{
    failure::Failure,
    output::{Output, write_file},
    setup::{MeasurementArgs, Setup, default_solver},
};

/// Simulate touches: a touch table with noise, from a seed
///
/// The fixture stands where --frame says; else where the measurement's own touches place it; else it coincides with
/// the parent.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    measurement: MeasurementArgs,
    /// Seed of the noise: the same seed gives the same touches
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// How many placements; with more than one the table has a column `placement`
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    count: u64,
    /// Where the fixture is touched [default: measurement if it has touches, else nominal]
    #[arg(long, value_enum, value_name = "LAYOUT")]
    layout: Option<LayoutKind>,
    /// True frame: x,y,z,qx,qy,qz,qw or a result file
    #[arg(long, value_name = "FRAME", allow_hyphen_values = true)]
    frame: Option<String>,
    /// Touches on each surface of a random layout, in the fixture's order [default: the fewest]
    #[arg(long, value_name = "A,B,...", value_delimiter = ',')]
    touches_per_surface: Vec<usize>,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Where a fixture is touched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LayoutKind {
    /// The layout that the fixture recommends
    Nominal,
    /// Uniform over the reachable surfaces, anew for every placement
    Random,
    /// Where the measurement touched it
    Measurement,
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
        let Some(sigma) = setup.measurement.probe.sigma else {
            return Err(InputError::new(
                "missing-key",
                "no sigma is stated, so there is no noise to simulate",
            )
            .with_key("probe.sigma")
            .with_help("give --sigma S, or `sigma` under [probe]")
            .into());
        };
        let has_touches = setup.measurement.touches != TouchSource::Absent;
        let layout =
            self.layout.unwrap_or(if has_touches { LayoutKind::Measurement } else { LayoutKind::Nominal });
        let measured = if layout == LayoutKind::Measurement || (has_touches && frame.is_none()) {
            Some(measured(&setup, registry)?)
        } else {
            None
        };
        let true_frame = frame.or(measured.as_ref().map(|(_, frame)| *frame)).unwrap_or_else(Frame::identity);
        let contacts = match (layout, &measured) {
            (LayoutKind::Measurement, Some((touches, frame))) => contacts_of(&*setup.fixture, touches, frame),
            (LayoutKind::Random, _) => Contacts::Random(self.counts(&*setup.fixture)?),
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

    /// How many touches each surface gets in a random layout.
    fn counts(&self, fixture: &dyn Fixture) -> Result<Vec<usize>, InputError> {
        let surfaces = fixture.surfaces().len();
        if self.touches_per_surface.is_empty() {
            let fewest = fixture.requirement().alternatives.first();
            return Ok(fewest.cloned().unwrap_or_else(|| vec![1; surfaces]));
        }
        if self.touches_per_surface.len() == surfaces {
            return Ok(self.touches_per_surface.clone());
        }
        let names: Vec<&str> = fixture.surfaces().iter().map(|surface| surface.name.as_str()).collect();
        let given = self.touches_per_surface.len();
        Err(InputError::new("invalid-input", format!("{given} counts are given for {surfaces} surfaces"))
            .with_key("touches-per-surface")
            .with_help(format!("give one count for each of {}", names.join(", "))))
    }
}

/// The measurement's touches, and the frame in which they place the fixture.
fn measured(setup: &Setup, registry: &Registry) -> Result<(Touches, Frame), Failure> {
    let touches = setup.touches()?;
    let solution = setup.solve(&*default_solver(registry)?, &touches, None)?;
    Ok((touches, solution.frame))
}

/// The points at which the tip met the surfaces: every touch brought back onto its surface.
fn contacts_of(fixture: &dyn Fixture, touches: &Touches, frame: &Frame) -> Contacts {
    let contact = |touch: &touchref::Touch| {
        let tip = frame.to_fixture(&touch.at);
        let seen = fixture.surfaces()[touch.surface].seen_from(&tip);
        (touch.surface, tip - seen.normal * seen.distance)
    };
    let ids = touches.records.iter().map(|record| record.id.clone()).collect();
    Contacts::Fixed(touches.touches.iter().map(contact).collect(), ids)
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
