//! `describe`: all that a fixture, a solver, a dialect or a format of logs says of itself.

use nalgebra::Point3;
use schemars::JsonSchema;
use serde::Serialize;
use touchref::{
    DialectPlugin, FixturePlugin, Frame, Literal, ParameterKind, ParameterSpec, Parameters, Plugin, Probe,
    Registry, SolverPlugin, TableSpec, Value,
    io::{InputError, Measurement, TouchRecord, Units, dialect, log, schema, solution::DialectNote, write},
    parameters::TYPE,
};

use crate::{args::Format, commands::list::LOG_ORIGIN, failure::Failure, output::Output, text};

/// The form of its JSON.
pub(crate) const SCHEMA: &str = "touchref.describe/1";

/// Tell parameters, surfaces, touches and frame of a fixture, what a solver does, what the numbers of a dialect mean,
/// or what is read of a log
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n\
\x20 touchref describe cylinder-plane\n\
\x20 touchref describe kuka-dat")]
pub(crate) struct Args {
    /// A fixture, a solver, a dialect or a format of logs
    name: String,
    /// Form of the result
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// The JSON of `describe`: a fixture, a solver, a dialect or a format of logs.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Description {
    /// The form of this JSON, and its version.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// What it is.
    #[schemars(extend("enum" = ["fixture", "solver", "dialect", "log"]))]
    pub(crate) kind: &'static str,
    /// By which it is called.
    pub(crate) name: &'static str,
    /// What it is, in one line.
    pub(crate) summary: &'static str,
    /// Crate and module it comes from.
    pub(crate) origin: &'static str,
    /// Its parameters, in the order in which help shows them.
    pub(crate) parameters: Vec<ParameterDescription>,
    #[serde(flatten)]
    pub(crate) of: Kind,
    /// Paper, book or standard it comes from.
    pub(crate) reference: &'static str,
}

/// What only one of the kinds has.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum Kind {
    Fixture {
        /// Its surfaces; none where its parameters state them.
        surfaces: Vec<SurfaceDescription>,
        /// How many touches it needs, in words.
        touches: &'static str,
        /// Where its frame's origin and axes are, in words.
        frame: &'static str,
        /// The frame drawn in text.
        drawing: &'static str,
        /// A measurement file.
        example: String,
    },
    Solver {
        /// What it does, in a paragraph.
        about: &'static str,
    },
    Log {
        /// What it does, in a paragraph.
        about: &'static str,
        /// Endings of its files.
        extensions: &'static [&'static str],
        /// `null` where the measurement states it, or the log tells it.
        #[schemars(schema_with = "schema::units_or_null")]
        units: Option<&'static str>,
        /// What its positions are always relative to; `null` where the measurement states it, or the log tells it.
        frame: Option<&'static str>,
        /// The section of a measurement file.
        example: String,
    },
    Dialect {
        /// What is typed after `--dialect`.
        call: String,
        #[serde(flatten)]
        note: DialectNote,
        /// A frame in this dialect.
        example: String,
    },
}

/// A parameter of a plugin.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ParameterDescription {
    /// The key in a measurement file.
    pub(crate) name: &'static str,
    /// Which values it takes, in words.
    pub(crate) takes: String,
    /// `null` for one that must be given; `instead of NAME` for one that may take the place of another.
    pub(crate) default: Option<&'static str>,
    /// What it means, in one line.
    pub(crate) meaning: &'static str,
    /// What each type of its tables has, for one that takes tables.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) tables: Vec<TableDescription>,
}

/// One type of the tables that a parameter takes.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct TableDescription {
    /// The word that `type` has.
    pub(crate) name: &'static str,
    /// What else such a table has.
    pub(crate) parameters: Vec<ParameterDescription>,
}

impl ParameterDescription {
    fn of(spec: &ParameterSpec) -> Self {
        let tables = match spec.kind {
            ParameterKind::Tables(tables) => tables,
            _ => &[],
        };
        let table = |table: &TableSpec| TableDescription {
            name: table.name,
            parameters: table.parameters.iter().map(Self::of).collect(),
        };
        Self {
            name: spec.name,
            takes: spec.kind.to_string(),
            default: spec.default,
            meaning: spec.meaning,
            tables: tables.iter().map(table).collect(),
        }
    }
}

/// A surface of a fixture.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SurfaceDescription {
    /// The name that touches refer to.
    pub(crate) name: &'static str,
    /// What it is.
    pub(crate) meaning: &'static str,
}

impl Args {
    pub(crate) fn run(self, registry: &Registry) -> Result<Output, Failure> {
        let description = if let Ok(plugin) = registry.fixture(&self.name) {
            of_fixture(plugin, registry)
        } else if let Ok(plugin) = registry.solver(&self.name) {
            of_solver(plugin)
        } else if let Ok(plugin) = registry.dialect(&self.name) {
            of_dialect(plugin)?
        } else if let Ok(importer) = log::find(&self.name) {
            of_log(importer)
        } else {
            let fixtures = registry.fixtures().iter().map(|plugin| plugin.name);
            let solvers = registry.solvers().iter().map(|plugin| plugin.name);
            let known = fixtures.chain(solvers).chain(registry.dialects().iter().map(|plugin| plugin.name));
            let known = known.chain(log::ALL.iter().map(|importer| importer.name));
            let error =
                InputError::unknown("unknown-name", "fixture, solver, dialect or log", &self.name, known);
            return Err(error.with_key("name").into());
        };
        Ok(Output::in_form(self.format, &description, &[], text::description))
    }
}

fn of_fixture(plugin: &'static FixturePlugin, registry: &Registry) -> Description {
    let surfaces = plugin.surfaces.iter().map(|&(name, meaning)| SurfaceDescription { name, meaning });
    let kind = Kind::Fixture {
        surfaces: surfaces.collect(),
        touches: plugin.touches,
        frame: plugin.frame,
        drawing: plugin.drawing,
        example: example(plugin, registry),
    };
    describe(plugin, kind, plugin.reference)
}

fn of_solver(plugin: &'static SolverPlugin) -> Description {
    describe(plugin, Kind::Solver { about: plugin.about }, plugin.reference)
}

fn of_log(importer: &'static log::Importer) -> Description {
    let kind = Kind::Log {
        about: importer.about,
        extensions: importer.extensions,
        units: importer.units.map(Units::name),
        frame: importer.frame,
        example: log_example(importer),
    };
    Description {
        schema: SCHEMA,
        kind: "log",
        name: importer.name,
        summary: importer.summary,
        origin: LOG_ORIGIN,
        parameters: Vec::new(),
        of: kind,
        reference: importer.reference,
    }
}

/// The section of a measurement file that reads a log of this format, with every key that it needs.
fn log_example(importer: &log::Importer) -> String {
    let ending = importer.extensions.first().map_or(String::new(), |ending| format!(".{ending}"));
    let needed = [
        (importer.takes_columns(), "columns = { at = [\"X\", \"Y\", \"Z\"] }"),
        (importer.units.is_none(), "units = \"mm\""),
        (importer.frame.is_none(), "base = 1"),
        (!importer.tip_centres, "compensated = false"),
    ];
    let needed = needed.iter().filter(|(needed, _)| *needed).map(|(_, line)| format!("{line}\n"));
    format!(
        "[log]\nfile = \"touches{ending}\"\nformat = \"{}\"\n{}\n[[log.touch]]\nsurface = \"cylinder\"\nrows = \"1-4\"\n",
        importer.name,
        needed.collect::<String>()
    )
}

/// With the parameters that must be given at the first of their values, and a frame that every dialect can tell.
fn of_dialect(plugin: &'static DialectPlugin) -> Result<Description, Failure> {
    let needed = plugin.parameters.iter().filter(|spec| spec.default.is_none());
    let parameters =
        needed.fold(Parameters::new(), |parameters, spec| parameters.with(spec.name, plausible(spec)));
    let built = plugin.build(&parameters).map_err(|error| {
        InputError::new("invalid-input", format!("dialect `{}`: {error}", plugin.name)).with_key("name")
    })?;
    let origin = Point3::new(100.0, 200.0, 300.0);
    // 30 degrees about Z.
    let frame =
        Frame::from_quaternion_xyzw(origin, [0.0, 0.0, 0.258_819_045_102_520_7, 0.965_925_826_289_068_3])
            .unwrap_or_else(Frame::identity);
    let literal = Literal::new(plugin.name, &*built, &frame, Units::Millimetre, &[])?;
    let kind = Kind::Dialect {
        call: dialect::call(plugin),
        note: DialectNote::from(&literal),
        example: literal.text,
    };
    Ok(describe(plugin, kind, plugin.reference))
}

fn describe<P: Plugin>(plugin: &'static P, of: Kind, reference: &'static str) -> Description {
    let parameters = plugin.parameters().iter().map(ParameterDescription::of);
    Description {
        schema: SCHEMA,
        kind: P::KIND,
        name: plugin.name(),
        summary: plugin.summary(),
        origin: plugin.origin(),
        parameters: parameters.collect(),
        of,
        reference,
    }
}

/// A measurement file of this fixture: plausible parameters, touched without noise at its nominal layout; without
/// touches where those parameters do not go together.
fn example(plugin: &FixturePlugin, registry: &Registry) -> String {
    let given = plugin.parameters.iter().filter(|spec| spec.default.is_none());
    let measurement = given.fold(Measurement::new(plugin.name, Units::Millimetre), |measurement, spec| {
        measurement.with_parameter(spec.name, plausible(spec))
    });
    let probe = Probe { tip_radius: 1.5, sigma: Some(0.005), ..Probe::default() };
    let touches = measurement.fixture(registry).map_or(Vec::new(), |fixture| {
        // Where it stands does not matter; numbers of three decimals read well.
        let frame = Frame::from_quaternion_xyzw(Point3::new(100.0, 200.0, 50.0), [0.0, 0.0, 0.1, 1.0])
            .unwrap_or_else(Frame::identity);
        let layout = fixture.nominal_layout().into_iter().map(|(surface, contact)| {
            let surface = &fixture.surfaces()[surface];
            let at = frame.to_parent(&surface.tip_center(&contact, probe.tip_radius));
            TouchRecord::new(&surface.name, at.map(|v| (v * 1e3).round() / 1e3))
        });
        layout.collect()
    });
    let parameters: &Parameters = measurement.parameters();
    write::measurement(plugin.name, parameters, Units::Millimetre, &probe, &touches)
}

/// A value of a parameter that has no default: radii of 20 and distances of 100 go together.
fn plausible(spec: &ParameterSpec) -> Value {
    match spec.kind {
        ParameterKind::Length if spec.name.contains("radius") => Value::from(20.0),
        ParameterKind::Length => Value::from(100.0),
        ParameterKind::Lengths3 => Value::from([20.0; 3]),
        ParameterKind::Angle { above, below } => Value::from(0.5 * (above + below)),
        ParameterKind::Choice(words) => Value::from(words.first().copied().unwrap_or_default()),
        ParameterKind::Name => Value::from(spec.name),
        ParameterKind::Point => Value::from([0.0; 3]),
        ParameterKind::Direction => Value::from([0.0, 0.0, 1.0]),
        ParameterKind::Tables(tables) => Value::from(
            tables.iter().enumerate().map(|(index, table)| plausible_table(index, table)).collect::<Vec<_>>(),
        ),
        _ => Value::from(false),
    }
}

/// A table of this type, one of several: its points and directions its own, so that they do not coincide.
fn plausible_table(index: usize, table: &TableSpec) -> Parameters {
    const APART: f64 = 60.0;
    let given = table.parameters.iter().filter(|spec| spec.default.is_none());
    given.fold(Parameters::new().with(TYPE, table.name), |parameters, spec| {
        let mut place = [0.0; 3];
        place[index % 3] = 1.0;
        let value = match spec.kind {
            ParameterKind::Name => Value::from(format!("{}-{}", table.name, index + 1).as_str()),
            ParameterKind::Point => Value::from(place.map(|v| v * APART)),
            ParameterKind::Direction => Value::from(place),
            _ => plausible(spec),
        };
        parameters.with(spec.name, value)
    })
}
