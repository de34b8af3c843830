//! `reliability`: which error of a touch would be noticed, and what one that is not does to the frame.

use nalgebra::{Point3, Vector6};
use schemars::JsonSchema;
use serde::Serialize;
use touchref::{
    Problem, Registry,
    analysis::{
        Reliability, ReliabilityError, Test,
        linear::{Observation, lever},
        reliability::{Checked, Confusion},
    },
    io::{
        InputError, TouchRecord, schema,
        solution::{FixtureRecord, ProbeRecord, WarningRecord},
    },
};

use crate::{
    args::Format,
    failure::Failure,
    output::Output,
    points::{InUse, UseArgs},
    setup::missing_sigma,
    text,
};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.reliability/1";

/// An observation of which less than this part is checked is weakly checked: most of its error goes into the frame.
pub(crate) const WEAK: f64 = 0.1;

/// Tell how far touches check each other: which error of one would be noticed, what one that is not does to the frame
///
/// For each touch, and for each size and the tip radius where an uncertainty is stated: the part of its error that
/// the others see (redundancy), the smallest error that is noticed, how the frame moves when that is not, how it moves
/// when the touch is left out, and for which other touches an error would be taken.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref reliability examples/cube.toml --at 300,0,0")]
pub(crate) struct Args {
    #[command(flatten)]
    of: UseArgs,
    /// Chance at which a sound touch is called bad
    #[arg(long, value_name = "A", default_value_t = Test::default().alpha, value_parser = chance)]
    alpha: f64,
    /// Chance at which an error of the smallest detectable size is noticed
    #[arg(long, value_name = "P", default_value_t = Test::default().power, value_parser = chance)]
    power: f64,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// A number between 0 and 1, for an argument.
pub(crate) fn chance(text: &str) -> Result<f64, String> {
    match text.trim().parse() {
        Ok(chance) if 0.0 < chance && chance < 1.0 => Ok(chance),
        _ => Err("expected a number between 0 and 1".to_owned()),
    }
}

/// The JSON of `reliability`. What is not checked has no numbers: they are `null`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ReliabilityRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The fixture.
    pub(crate) fixture: FixtureRecord,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    pub(crate) units: &'static str,
    /// The probe as used.
    pub(crate) probe: ProbeRecord,
    /// Chance that a good observation is called bad.
    pub(crate) alpha: f64,
    /// Chance that an error of the smallest detectable size is noticed.
    pub(crate) power: f64,
    /// A test value beyond this calls an observation bad.
    pub(crate) critical_value: f64,
    /// Mean test value of an error of the smallest detectable size.
    pub(crate) noncentrality: f64,
    /// Points of use, in fixture coordinates.
    pub(crate) points: Vec<[f64; 3]>,
    /// The touches, then what is stated of sizes.
    pub(crate) observations: Vec<ObservationRecord>,
    /// What the user should know.
    pub(crate) warnings: Vec<WarningRecord>,
}

/// How far one observation is checked; lengths, or degrees where it is an angle.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ObservationRecord {
    /// `touch`, or the name of the size that is stated.
    pub(crate) kind: String,
    /// Which touch.
    pub(crate) index: Option<usize>,
    /// What the user calls the touch.
    pub(crate) id: Option<String>,
    /// Its surface.
    pub(crate) surface: Option<String>,
    /// Standard deviation.
    pub(crate) sigma: f64,
    /// The part of its error that the others see, from 0 to 1.
    pub(crate) redundancy: f64,
    /// Its residual over the standard deviation of that.
    pub(crate) test_value: Option<f64>,
    /// The smallest error that is noticed with chance `power`.
    pub(crate) smallest_detectable: Option<f64>,
    /// What an error of that size, unnoticed, does.
    pub(crate) undetected: Option<ShiftRecord>,
    /// What leaving it out does.
    pub(crate) left_out: Option<ShiftRecord>,
    /// Others that its error may be taken for.
    pub(crate) confused_with: Vec<ConfusionRecord>,
}

/// How the frame moves.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ShiftRecord {
    /// `x y z rx ry rz` along the parent's axes about the fixture's origin; radians.
    pub(crate) motion: [f64; 6],
    /// How far each point of use moves.
    pub(crate) at_points: Vec<f64>,
}

/// Another observation that an error may be taken for.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ConfusionRecord {
    /// Its place among the observations.
    pub(crate) with: usize,
    /// Chance that its test value is the larger.
    pub(crate) chance: f64,
    /// Whether no test can tell the two apart.
    pub(crate) always: bool,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let test = Test { alpha: self.alpha, power: self.power };
        let InUse { setup, solution, points } = self.of.locate(registry)?;
        let (frame, problem) = (solution.frame, setup.problem()?);
        let reliability = Reliability::of(&problem, &frame, test).map_err(failure)?;
        let shift = |motion: Vector6<f64>| {
            let at = |point: &Point3<f64>| (lever(&frame, point) * motion).norm();
            ShiftRecord { motion: motion.into(), at_points: points.iter().map(at).collect() }
        };
        let touches = &setup.touches()?.records;
        let told = |checked: &Checked| ObservationRecord::new(checked, &problem, touches, &shift);
        let record = ReliabilityRecord {
            schema: SCHEMA,
            fixture: FixtureRecord::new(setup.fixture.kind(), setup.fixture.parameters()),
            units: setup.measurement.units.name(),
            probe: ProbeRecord::from(&setup.measurement.probe),
            alpha: test.alpha,
            power: test.power,
            critical_value: test.critical_value(),
            noncentrality: test.noncentrality(),
            points: points.iter().map(|point| (*point).into()).collect(),
            observations: reliability.observations.iter().map(told).collect(),
            warnings: setup.warnings().iter().map(WarningRecord::from).collect(),
        };
        Ok(Output::in_form(self.format, &record, &record.warnings, text::reliability))
    }
}

fn failure(error: ReliabilityError) -> Failure {
    match error {
        ReliabilityError::NoSigma => missing_sigma(error.to_string()).into(),
        // The frame was accepted: what is left is a layout at the very edge of that.
        _ => InputError::new("degenerate", error.to_string()).with_help("add touches").into(),
    }
}

impl ObservationRecord {
    fn new(
        checked: &Checked,
        problem: &Problem<'_>,
        touches: &[TouchRecord],
        shift: &impl Fn(Vector6<f64>) -> ShiftRecord,
    ) -> Self {
        let (kind, index, scale) = match checked.observation {
            Observation::Touch(index) => ("touch".to_owned(), Some(index), 1.0),
            Observation::Stated(unknown) => {
                let stated = unknown.stated(problem.fixture(), problem.probe());
                (stated.name.into_owned(), None, stated.scale)
            }
        };
        let touch = index.and_then(|index| touches.get(index));
        let check = checked.check.as_ref();
        let confusion =
            |told: &Confusion| ConfusionRecord { with: told.with, chance: told.chance, always: told.always };
        Self {
            kind,
            index,
            id: touch.and_then(|touch| touch.id.clone()),
            surface: touch.map(|touch| touch.surface.clone()),
            sigma: checked.sigma * scale,
            redundancy: checked.redundancy,
            test_value: check.map(|check| check.test_value),
            smallest_detectable: check.map(|check| check.smallest_detectable * scale),
            undetected: checked.undetected_shift().map(shift),
            left_out: checked.shift_without().map(shift),
            confused_with: check
                .map_or_else(Vec::new, |check| check.confusions.iter().map(confusion).collect()),
        }
    }

    /// What it is called in text.
    pub(crate) fn name(&self) -> String {
        match (self.index, &self.surface) {
            (Some(index), Some(surface)) => format!("{index} on {surface}"),
            _ => self.kind.clone(),
        }
    }
}
