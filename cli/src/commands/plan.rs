//! `plan`: where to touch.

use std::path::PathBuf;

use nalgebra::Point3;
use schemars::JsonSchema;
use serde::Serialize;
use touchref::{
    Frame, Registry, SolveError,
    analysis::planning::{Effect, Next, Plan, PlanError, Planner, Wanted},
    fixture::touches_per_surface,
    io::{
        InputError, schema,
        solution::{FixtureRecord, ProbeRecord, TrustRecord, WarningRecord},
        write::{self, ToFill},
    },
};

use crate::{
    args::Format,
    failure::Failure,
    layout::per_surface,
    output::{Output, working, write_file},
    planning::{CriterionArg, PlaceRecord, PlanningArgs, can_aim, coverage_factor, length},
    setup::{FULL_MARGIN, MeasurementArgs, NearArgs, Setup, SolverArgs},
    text,
};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.plan/1";

/// Tell where to touch: the layout that makes the frame surest where it is used, or the touch to make next
///
/// Touches are placed within reach so that the largest uncertainty over the points of use is smallest. A layout counts
/// only when its noise-free touches give one frame that is accepted, and when the others check every touch, as far as
/// their count allows. With neither a count nor a target as many touches are planned on each surface as the fixture's own
/// layout has. With --next: the one further touch that helps the measurement's touches most; where they are ambiguous, the
/// one that separates the frames that fit.
/// Exit status 1: no such layout stands, or the target is not met.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref plan examples/three-sphere.toml --at 300,0,0\n\
\x20 touchref plan examples/nederbragt-ravani.toml --next")]
pub(crate) struct Args {
    #[command(flatten)]
    measurement: MeasurementArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    near: NearArgs,
    #[command(flatten)]
    planning: PlanningArgs,
    /// Touches on each surface, in the fixture's order
    #[arg(long, value_name = "A,B,...", value_delimiter = ',', conflicts_with_all = ["total", "target", "next"])]
    touches_per_surface: Vec<usize>,
    /// Touches altogether, on whichever surfaces they help most
    #[arg(long, value_name = "N", conflicts_with_all = ["target", "next"])]
    total: Option<u16>,
    /// As few touches as make the expanded uncertainty (95 %) along the worst direction at most this at every point of use
    #[arg(long, value_name = "U", conflicts_with = "next", value_parser = length, allow_negative_numbers = true)]
    target: Option<f64>,
    /// The one touch to make next, beside those of the measurement
    #[arg(long, conflicts_with_all = ["output", "table"])]
    next: bool,
    /// Measurement file to write, to be filled in with what the probe reads
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Touch table (CSV) to write, to be filled in
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// The JSON of `plan`. Uncertainties are `null` where no sigma is stated; ratios are there all the same.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlanRecord {
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
    /// What is made small: the uncertainty of the worst point, or the volume of the confidence region.
    pub(crate) criterion: CriterionArg,
    /// By which a standard uncertainty is multiplied to cover 95 %.
    pub(crate) coverage_factor: f64,
    /// The touches to make.
    pub(crate) touches: Vec<PlannedTouch>,
    /// Points of use.
    pub(crate) points: Vec<PointRecord>,
    /// Largest standard uncertainty over the points.
    pub(crate) worst: Option<f64>,
    /// Worst case of other layouts of as many touches, over that of the plan; `null` where they leave a motion free.
    pub(crate) naive_over_plan: Option<f64>,
    /// The same of the median random layout.
    pub(crate) random_median_over_plan: Option<f64>,
    /// Least redundancy number of a touch: the part of its error that the others see.
    pub(crate) least_redundancy: f64,
    /// Whether the count of touches allows that of every touch.
    pub(crate) redundancy_possible: bool,
    /// Whether the measurement must tell approach directions: without them another frame fits as well.
    pub(crate) approach_needed: bool,
    /// How far the frame would stand.
    pub(crate) trust: TrustRecord,
    /// What the user should know.
    pub(crate) warnings: Vec<WarningRecord>,
}

/// A touch to make.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlannedTouch {
    /// Which touch, from 0.
    pub(crate) index: usize,
    #[serde(flatten)]
    pub(crate) place: PlaceRecord,
    /// The part of its error that the others see.
    pub(crate) redundancy: f64,
}

/// How sure the frame will be at a point of use.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PointRecord {
    /// In fixture coordinates.
    pub(crate) at: [f64; 3],
    /// Standard, along the worst direction.
    pub(crate) u: Option<f64>,
    /// In standard deviations of a touch.
    pub(crate) u_over_sigma: f64,
}

/// The JSON of `plan --next`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct NextRecord {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The fixture.
    pub(crate) fixture: FixtureRecord,
    /// Unit of every length.
    #[schemars(schema_with = "schema::units")]
    pub(crate) units: &'static str,
    /// The touch to make next.
    pub(crate) next: NextTouch,
    /// What the user should know.
    pub(crate) warnings: Vec<WarningRecord>,
}

/// The touch to make next, and what it does.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct NextTouch {
    #[serde(flatten)]
    pub(crate) place: PlaceRecord,
    /// `separates` frames that all fit, `reduces` the worst case, or `fixes` what is free.
    #[schemars(extend("enum" = ["separates", "reduces", "fixes"]))]
    pub(crate) effect: &'static str,
    /// Frames that fit before it.
    pub(crate) frames: usize,
    /// By how much its readings differ between any two of them at least: in standard deviations.
    pub(crate) sigmas: Option<f64>,
    /// Worst-case standard uncertainty before and after.
    pub(crate) worst_before: Option<f64>,
    /// The same after it.
    pub(crate) worst_after: Option<f64>,
}

impl NextTouch {
    pub(crate) fn new(planner: &Planner<'_>, next: &Next, frame: Option<&Frame>, frames: usize) -> Self {
        let place = PlaceRecord::new(planner.fixture, &planner.probe, next.surface, &next.contact, frame);
        let mut touch =
            Self { place, effect: "fixes", frames, sigmas: None, worst_before: None, worst_after: None };
        match next.effect {
            Effect::Separates { sigmas } => {
                touch.effect = "separates";
                touch.sigmas = Some(sigmas);
            }
            Effect::Reduces { from, to } => {
                touch.effect = "reduces";
                (touch.worst_before, touch.worst_after) = (Some(from), Some(to));
            }
            Effect::Fixes => {}
        }
        touch
    }
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let solver = self.solver.build(registry, if self.next { &[] } else { &FULL_MARGIN })?;
        let near = self.near.frame()?;
        let setup = self.measurement.load(registry)?;
        let planner = self.planning.planner(&setup, &*solver)?;
        if self.next {
            return self.next(&setup, &planner, near);
        }
        let wanted = self.wanted(&setup)?;
        let working = working("looking for the best layout");
        let plan = planner.plan(&wanted);
        drop(working);
        let plan = plan.map_err(Failure::from)?;
        let record = self.record(&setup, &plan, near.as_ref());
        self.write(&setup, &plan, near.as_ref())?;
        Ok(Output::in_form(self.format, &record, &record.warnings, text::plan))
    }

    fn wanted(&self, setup: &Setup) -> Result<Wanted, InputError> {
        if let Some(total) = self.total {
            return Ok(Wanted::Total(usize::from(total)));
        }
        if let Some(target) = self.target {
            can_aim(setup)?;
            return Ok(Wanted::Target(target / coverage_factor()));
        }
        let given = per_surface(&self.touches_per_surface, setup)?;
        Ok(Wanted::PerSurface(given.unwrap_or_else(|| nominal_counts(setup))))
    }

    fn record(&self, setup: &Setup, plan: &Plan, near: Option<&Frame>) -> PlanRecord {
        let (fixture, probe) = (&*setup.fixture, &setup.measurement.probe);
        let sigma = probe.sigma;
        let told = |u: f64| sigma.map(|_| u);
        let touches = plan.layout.iter().zip(&plan.redundancy).enumerate();
        let points = self.planning.points(fixture);
        PlanRecord {
            schema: SCHEMA,
            fixture: FixtureRecord::new(fixture.kind(), fixture.parameters()),
            units: setup.measurement.units.name(),
            probe: ProbeRecord::from(probe),
            criterion: self.planning.criterion(),
            coverage_factor: coverage_factor(),
            touches: touches
                .map(|(index, ((surface, contact), redundancy))| PlannedTouch {
                    index,
                    place: PlaceRecord::new(fixture, probe, *surface, contact, near),
                    redundancy: *redundancy,
                })
                .collect(),
            points: points
                .iter()
                .zip(&plan.uncertainties)
                .map(|(at, u)| PointRecord {
                    at: (*at).into(),
                    u: told(*u),
                    u_over_sigma: u / sigma.unwrap_or(1.0),
                })
                .collect(),
            worst: told(plan.worst()),
            naive_over_plan: plan.naive.map(|naive| naive / plan.worst()),
            random_median_over_plan: plan.random_median.map(|median| median / plan.worst()),
            least_redundancy: self.planning.redundancy(),
            redundancy_possible: plan.redundancy_possible,
            approach_needed: plan.approach_needed,
            trust: TrustRecord::from(&plan.trust),
            warnings: setup.warnings().iter().map(WarningRecord::from).collect(),
        }
    }

    /// Writes the files that are to be filled in.
    fn write(&self, setup: &Setup, plan: &Plan, near: Option<&Frame>) -> Result<(), Failure> {
        let (fixture, measurement) = (&*setup.fixture, &setup.measurement);
        let to_fill = |(index, contact): &(usize, Point3<f64>)| {
            let surface = &fixture.surfaces()[*index];
            ToFill {
                surface: &surface.name,
                contact: *contact,
                tip: surface.tip_center(contact, measurement.probe.tip_radius),
                approach: surface.approach(contact),
            }
        };
        let touches: Vec<ToFill<'_>> = plan.layout.iter().map(to_fill).collect();
        if let Some(path) = &self.output {
            let text = write::measurement_to_fill(
                &measurement.kind,
                measurement.parameters(),
                measurement.units,
                &measurement.probe,
                &touches,
                near,
            );
            write_file(path, |output| output.write_all(text.as_bytes()))?;
        }
        if let Some(path) = &self.table {
            write_file(path, |output| write::table_to_fill(output, &touches, near))?;
        }
        Ok(())
    }

    fn next(&self, setup: &Setup, planner: &Planner<'_>, near: Option<Frame>) -> Result<Output, Failure> {
        let working = working("looking for the best touch");
        let found = next(setup, planner, near);
        drop(working);
        let (next, frames) = found?;
        let record = NextRecord {
            schema: SCHEMA,
            fixture: FixtureRecord::new(setup.fixture.kind(), setup.fixture.parameters()),
            units: setup.measurement.units.name(),
            next: NextTouch::new(planner, &next, frames.first(), frames.len()),
            warnings: setup.warnings().iter().map(WarningRecord::from).collect(),
        };
        Ok(Output::in_form(self.format, &record, &record.warnings, text::next))
    }
}

/// The touch to make next beside those of a measurement, and the frames that fit these: one, or several that it
/// separates.
fn next(setup: &Setup, planner: &Planner<'_>, near: Option<Frame>) -> Result<(Next, Vec<Frame>), Failure> {
    let problem = setup.problem()?;
    let problem = near.map_or(problem, |frame| problem.near(frame));
    // What touches state themselves is all that is known of those to come.
    match planner.solver.solve(&problem) {
        Ok(solution) => {
            let next = planner.next(problem.touches(), &solution.frame)?;
            Ok((next, vec![solution.frame]))
        }
        Err(error @ SolveError::Ambiguous(_)) => {
            let frames = planner.surviving(&problem, &error);
            match planner.next_apart(problem.touches(), &frames) {
                Ok(next) => Ok((next, frames)),
                // What is refused cannot be helped by one touch: then the refusal is what there is to tell.
                Err(_) => Err(setup.refused(error).into()),
            }
        }
        Err(error) => Err(setup.refused(error).into()),
    }
}

/// As many touches on each surface as the fixture's own layout has.
pub(crate) fn nominal_counts(setup: &Setup) -> Vec<usize> {
    let touched = setup.fixture.nominal_layout().into_iter().map(|(surface, _)| surface);
    touches_per_surface(setup.fixture.surfaces().len(), touched)
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Self {
        let message = error.to_string();
        match error {
            PlanError::Touches(error) => InputError::from(error).into(),
            PlanError::TooFewTouches { .. } => InputError::new("too-few-touches", message)
                .with_help("`touchref describe` tells how many touches a fixture needs")
                .into(),
            PlanError::Unreachable { .. } => InputError::new("invalid-input", message)
                .with_key("cone")
                .with_help("widen the cone, come from another side, or touch other surfaces")
                .into(),
            _ => Self::Unplanned(Box::new(error)),
        }
    }
}
