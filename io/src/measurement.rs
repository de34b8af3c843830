//! Measurement files: what was touched, with what, and where.

use std::{ops::Range, path::Path, sync::Arc};

use nalgebra::{Point3, Unit, Vector3};
use touchref_core::{
    Fault, Fixture, FixturePlugin, Noise, ParameterError, Parameters, Probe, Registry, Touch, TouchError,
    Value, Warning,
};

use crate::{Input, InputError, Units, log::LogSource, parameter, source::Source, table::TableReader};

mod file;
pub(crate) mod schema;

pub(crate) use file::read_units;

/// In the place of a surface's name: that it is not known.
pub const UNLABELLED: &str = "?";
/// In the place of a touch's coordinates: that it is still to be made.
pub const NOT_MEASURED: &str = "?";

/// The unit of this name, where a program and no file states it.
///
/// # Errors
/// `unknown-name`, with the nearest.
pub fn units_named(name: &str) -> Result<Units, InputError> {
    Units::from_name(name).ok_or_else(|| {
        let known = Units::ALL.map(Units::name);
        InputError::unknown("unknown-name", "unit", name, known.into_iter()).with_key("units")
    })
}

/// A measurement as its file (or its arguments) states it, in the file's unit.
///
/// Names are not resolved yet: [`fixture`](Self::fixture) builds the fixture and [`touches`](Self::touches) finds its
/// surfaces; both still point into the file when something is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Unit of every length.
    pub units: Units,
    /// Kind of the fixture: the name of its plugin.
    pub kind: String,
    /// Parameters of the fixture as given, unchecked.
    parameters: Parameters,
    /// The probe.
    pub probe: Probe,
    /// Where the touches are.
    pub touches: TouchSource,
    origin: Option<Arc<Origin>>,
}

/// Where the touches of a measurement are.
#[derive(Debug, Clone, PartialEq)]
pub enum TouchSource {
    /// None are given, as for a simulation.
    Absent,
    /// In a touch table.
    Table(Input),
    /// In the log of a machine.
    Log(Box<LogSource>),
    /// In the measurement itself.
    Listed(Vec<TouchRecord>),
    /// Of many placements of the fixture; each in a table or listed.
    Placed(Vec<PlacementSource>),
}

/// One placement of the fixture, and where its touches are.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacementSource {
    /// What the user calls it.
    pub name: Option<String>,
    /// Its touches.
    pub touches: TouchSource,
}

/// One touch as a file states it.
#[derive(Debug, Clone, PartialEq)]
pub struct TouchRecord {
    /// Name of the surface, or [`UNLABELLED`].
    pub surface: String,
    /// Whether the file leaves the surface open, and it was found.
    pub label_found: bool,
    /// Centre of the tip, in the parent.
    pub at: Point3<f64>,
    /// How sure the position is.
    pub noise: Noise,
    /// Direction in which the probe moved, in the parent.
    pub approach: Option<Unit<Vector3<f64>>>,
    /// What the user calls the touch.
    pub id: Option<String>,
    /// The placement of the fixture to which it belongs, in a table of many.
    pub placement: Option<String>,
    /// Line of the file, from 1.
    pub line: Option<usize>,
}

/// Touches whose surfaces are known to the fixture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Touches {
    /// As the file states them, in its order.
    pub records: Vec<TouchRecord>,
    /// The same for a solver.
    pub touches: Vec<Touch>,
    /// The file they come from.
    pub file: String,
    /// What the user should know of the file.
    pub warnings: Vec<Warning>,
}

/// One placement of the fixture, its touches read.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacementTouches {
    /// What the user calls it.
    pub name: Option<String>,
    /// Its touches.
    pub touches: Touches,
}

/// The text behind a measurement, and where in it the names stand that are resolved later.
#[derive(Debug, PartialEq)]
struct Origin {
    source: Source,
    fixture: Range<usize>,
    kind: Range<usize>,
    parameters: Vec<parameter::Written>,
    /// The surface of each listed touch, by placement.
    surfaces: Vec<Vec<Range<usize>>>,
}

impl Measurement {
    /// A measurement that no file states: exact touches of surface points, none given yet.
    #[must_use]
    pub fn new(kind: &str, units: Units) -> Self {
        Self {
            units,
            kind: kind.to_owned(),
            parameters: Parameters::new(),
            probe: Probe::default(),
            touches: TouchSource::Absent,
            origin: None,
        }
    }

    /// Reads a measurement file: TOML, or the same keys as JSON.
    ///
    /// # Errors
    /// The first thing that is wrong with it: a file that cannot be read, a syntax error, a key that is unknown,
    /// missing, or has a value of the wrong kind or range.
    pub fn read(input: &Input) -> Result<Self, InputError> {
        let folder = match input {
            Input::File(path) => path.parent().unwrap_or(Path::new("")),
            Input::Stdin => Path::new(""),
        };
        file::read(Source::read(input)?, folder)
    }

    /// Reads the text of a measurement file that messages call `name`; a touch table it names is looked for in
    /// `folder`.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn from_text(name: &str, text: &str, folder: &Path) -> Result<Self, InputError> {
        file::read(Source::new(name, text), folder)
    }

    /// The plugin of its fixture.
    ///
    /// # Errors
    /// `unknown-fixture`, with the nearest name.
    pub fn plugin(&self, registry: &Registry) -> Result<&'static FixturePlugin, InputError> {
        registry.fixture(&self.kind).map_err(|error| {
            let error = InputError::from(error).with_key("fixture.kind");
            match &self.origin {
                Some(origin) => error.at(origin.source.place(origin.kind.clone())),
                None => error,
            }
        })
    }

    /// Sets a parameter from the text after `NAME=`; it takes the place of the file's.
    ///
    /// # Errors
    /// `unknown-key` when the fixture has no such parameter, `invalid-input` when the text is no value of its kind.
    pub fn set_parameter(
        &mut self,
        plugin: &FixturePlugin,
        name: &str,
        text: &str,
    ) -> Result<(), InputError> {
        let value = parameter::from_argument(&told(plugin), plugin.parameters, name, text)?;
        self.parameters.set(name, value);
        if let Some(origin) = self.origin.as_mut().and_then(Arc::get_mut) {
            origin.parameters.retain(|(known, ..)| known != name);
        }
        Ok(())
    }

    /// The parameters of its fixture as given, unchecked and without defaults.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Sets a parameter to a value; it takes the place of the file's.
    #[must_use]
    pub fn with_parameter(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.parameters.set(name, value.into());
        self
    }

    /// Sets each of these parameters, as [`with_parameter`](Self::with_parameter) does.
    #[must_use]
    pub fn with_parameters(self, parameters: &Parameters) -> Self {
        parameters
            .iter()
            .fold(self, |measurement, (name, value)| measurement.with_parameter(name, value.clone()))
    }

    /// Sets the radius of the probe tip from text, which may carry a standard uncertainty: `1.5`, `1.5+-0.001`.
    ///
    /// # Errors
    /// `invalid-input` when the text is no length of 0 or more.
    pub fn set_tip_radius(&mut self, text: &str) -> Result<(), InputError> {
        let right = |(radius, u): &(f64, f64)| [*radius, *u].iter().all(|v| v.is_finite() && *v >= 0.0);
        let (radius, u) = parameter::uncertain(text).filter(right).ok_or_else(|| {
            let message = format!("the tip radius is `{text}`; expected a length, 0 or more");
            InputError::new("invalid-input", message).with_key("probe.tip_radius")
        })?;
        (self.probe.tip_radius, self.probe.tip_radius_u) = (radius, u);
        Ok(())
    }

    /// Sets the standard deviation of one touch.
    ///
    /// # Errors
    /// `invalid-input` when it is not a length above 0.
    pub fn set_sigma(&mut self, sigma: f64) -> Result<(), InputError> {
        if sigma.is_finite() && sigma > 0.0 {
            self.probe.sigma = Some(sigma);
            return Ok(());
        }
        let message = format!("sigma is {sigma}; expected a length > 0");
        Err(InputError::new("invalid-input", message).with_key("probe.sigma"))
    }

    /// Builds its fixture.
    ///
    /// # Errors
    /// `unknown-fixture`; `unknown-key`, `missing-key` or `invalid-input` for the first parameter that is wrong.
    pub fn fixture(&self, registry: &Registry) -> Result<Box<dyn Fixture>, InputError> {
        let plugin = self.plugin(registry)?;
        plugin.build(&self.parameters).map_err(|error| self.parameter_error(plugin, &error))
    }

    fn parameter_error(&self, plugin: &FixturePlugin, error: &ParameterError) -> InputError {
        let origin = self.origin.as_deref();
        let find = |wanted: &str| origin?.parameters.iter().find(|(name, ..)| name == wanted);
        let written = find(&error.name);
        // A key of a table, as `radius` of `surface[2]`, is missing there; any other in the fixture.
        let (table, name) = match error.name.rsplit_once('.') {
            Some((table, name)) => (find(table).map(|(.., value)| value.clone()), name),
            None => (origin.map(|origin| origin.fixture.clone()), error.name.as_str()),
        };
        let meaning = plugin.parameters.iter().find(|spec| spec.name == error.name).map(|spec| spec.meaning);
        let (reason, span, label) = match error.fault {
            Fault::Unknown if table.is_none() || error.name == name => {
                let span = written.map(|(_, key, _)| key.clone());
                let unknown = parameter::unknown(&told(plugin), plugin.parameters, &error.name);
                (unknown, span, "not a parameter of this fixture".to_owned())
            }
            Fault::Unknown => {
                let span = written.map(|(_, key, _)| key.clone());
                let unknown = InputError::new("unknown-key", error.to_string());
                (unknown.with_nearest(error.nearest.as_deref()), span, "not a known key".to_owned())
            }
            Fault::Missing => {
                let missing = InputError::new("missing-key", error.to_string()).with_help(match meaning {
                    Some(meaning) => format!("add `{name} = ...`: {meaning}"),
                    None => format!("add `{name} = ...`: {}", error.expected),
                });
                (missing, table, format!("`{name}` is missing here"))
            }
            Fault::Wrong => {
                let wrong = InputError::new("invalid-input", error.to_string())
                    .with_nearest(error.nearest.as_deref())
                    .with_help(match meaning {
                        Some(meaning) => format!("{name}: {meaning}"),
                        None => format!("expected {}", error.expected),
                    });
                (wrong, written.map(|(.., value)| value.clone()), format!("expected {}", error.expected))
            }
        };
        let key = if origin.is_some() { format!("fixture.{}", error.name) } else { error.name.clone() };
        let reason = reason.with_key(key).labelled(label);
        match (origin, span) {
            (Some(origin), Some(span)) => reason.at(origin.source.place(span)),
            _ => reason,
        }
    }

    /// Reads its touches, of one placement, and finds their surfaces.
    ///
    /// # Errors
    /// `too-few-touches` when there are none, `invalid-input` when they are of many placements, `unknown-surface`, also
    /// where one is [`UNLABELLED`], and whatever is wrong with a touch table.
    pub fn touches(&self, fixture: &dyn Fixture) -> Result<Touches, InputError> {
        self.touches_labelled_by(fixture, |records, _| Err(unlabelled(records)))
    }

    /// The same; where some are [`UNLABELLED`], `label` finds the surface of each. It is handed the touches, and the
    /// surfaces that are known.
    ///
    /// # Errors
    /// As [`touches`](Self::touches), and what `label` says.
    pub fn touches_labelled_by<E: From<InputError>>(
        &self,
        fixture: &dyn Fixture,
        label: impl FnOnce(&[TouchRecord], &[Option<usize>]) -> Result<Vec<usize>, E>,
    ) -> Result<Touches, E> {
        const HELP: &str = "`touchref calibrate` takes many placements; for a frame give the touches of one";
        let many = |message: String, file: &str| {
            InputError::new("invalid-input", message).with_file(file).with_key("placement").with_help(HELP)
        };
        if let TouchSource::Placed(placements) = &self.touches {
            let message =
                format!("the measurement has {} placements; a frame is that of one", placements.len());
            return Err(many(message, self.file()).into());
        }
        let touches = self.read_touches(fixture, &self.touches)?;
        let first = touches.records.first().and_then(|record| record.placement.as_ref());
        let other = touches.records.iter().find(|record| record.placement.as_ref() != first);
        if let Some(other) = other {
            let line = other.line.map_or(String::new(), |line| format!(" (from line {line} on)"));
            let message =
                format!("{} has touches of many placements{line}; a frame is that of one", touches.file);
            return Err(many(message, &touches.file).into());
        }
        self.labelled(fixture, touches, 0, label)
    }

    /// Reads the touches of its placements: sections of the file, or rows of a table by their column `placement`, in the
    /// order in which they come first.
    ///
    /// # Errors
    /// As [`touches`](Self::touches), and `invalid-input` when they are of one placement only, or a touch of none.
    pub fn placements(&self, fixture: &dyn Fixture) -> Result<Vec<PlacementTouches>, InputError> {
        let read = |source: &TouchSource, placement: usize| {
            let touches = self.read_touches(fixture, source)?;
            self.labelled(fixture, touches, placement, |records, _| Err(unlabelled(records)))
        };
        let TouchSource::Placed(sources) = &self.touches else {
            return by_placement(&read(&self.touches, 0)?);
        };
        let placed = sources.iter().enumerate().map(|(index, source)| {
            Ok(PlacementTouches { name: source.name.clone(), touches: read(&source.touches, index)? })
        });
        placed.collect()
    }

    /// The touches from one source, their surfaces not found yet.
    fn read_touches(&self, fixture: &dyn Fixture, source: &TouchSource) -> Result<Touches, InputError> {
        let touches = match source {
            TouchSource::Absent | TouchSource::Placed(_) => {
                return Err(InputError::new("too-few-touches", "the measurement has no touches").with_help(
                    "list them in the measurement file as [[touch]], name a table there (touches = \"touches.csv\") or a \
                     machine's log ([log]), or give one with --touches TABLE",
                ));
            }
            TouchSource::Listed(records) => {
                Touches { records: records.clone(), file: self.file().to_owned(), ..Touches::default() }
            }
            TouchSource::Table(input) => from_table(fixture, input, self.units)?,
            TouchSource::Log(log) => log.touches(fixture, self.units, &self.probe)?,
        };
        self.same_certainty(&touches)?;
        Ok(touches)
    }

    /// The same with their surfaces found; of the placement with this index.
    fn labelled<E: From<InputError>>(
        &self,
        fixture: &dyn Fixture,
        mut touches: Touches,
        placement: usize,
        label: impl FnOnce(&[TouchRecord], &[Option<usize>]) -> Result<Vec<usize>, E>,
    ) -> Result<Touches, E> {
        let mut surfaces = Vec::with_capacity(touches.records.len());
        for (index, record) in touches.records.iter().enumerate() {
            let known = record.is_labelled().then(|| self.surface_of(fixture, placement, index, record));
            surfaces.push(known.transpose()?);
        }
        let found = match surfaces.iter().copied().collect() {
            Some(all) => all,
            None => label(&touches.records, &surfaces)?,
        };
        let mut told = Vec::new();
        for (index, (record, surface)) in touches.records.iter_mut().zip(found).enumerate() {
            if !record.is_labelled() {
                record.label_found = true;
                record.surface.clone_from(&fixture.surfaces()[surface].name);
                told.push(format!("{index} is on `{}`", record.surface));
            }
            let TouchRecord { at, noise, approach, .. } = *record;
            touches.touches.push(Touch { surface, at, noise, approach });
        }
        if !told.is_empty() {
            let message =
                format!("surfaces that the measurement leaves open were found: touch {}", told.join(", "));
            touches.warnings.push(Warning { code: "label-found", message });
        }
        Ok(touches)
    }

    /// Name of the file, where there is one.
    fn file(&self) -> &str {
        self.origin.as_ref().map_or("", |origin| origin.source.name())
    }

    /// The surface of a touch, found by its name.
    fn surface_of(
        &self,
        fixture: &dyn Fixture,
        placement: usize,
        index: usize,
        record: &TouchRecord,
    ) -> Result<usize, InputError> {
        fixture.surface_index(&record.surface).map_err(|error| {
            let within = match &self.touches {
                TouchSource::Placed(_) => format!("placement[{placement}]."),
                _ => String::new(),
            };
            let error = InputError::from(error).with_key(format!("{within}touch[{index}].surface"));
            let span = |origin: &Origin| origin.surfaces.get(placement)?.get(index).cloned();
            match self.origin.as_deref().and_then(|origin| Some((origin, span(origin)?))) {
                Some((origin, span)) => error.at(origin.source.place(span)),
                None => error,
            }
        })
    }

    /// Either every touch says how sure it is, or the probe does.
    fn same_certainty(&self, touches: &Touches) -> Result<(), InputError> {
        let states_own = |record: &TouchRecord| record.noise != Noise::OfProbe;
        let some = touches.records.iter().any(states_own);
        match touches.records.iter().find(|record| !states_own(record)) {
            Some(record) if some && self.probe.sigma.is_none() => {
                let line = record.line.map_or(String::new(), |line| format!(" (line {line})"));
                let message = format!(
                    "touch `{}`{line} has no sigma although others have one, and the probe states none",
                    record.id.as_deref().unwrap_or(&record.surface)
                );
                Err(InputError::new("invalid-input", message)
                    .with_file(&touches.file)
                    .with_key("probe.sigma")
                    .with_help("state `sigma` under [probe] or with --sigma, or for every touch"))
            }
            _ => Ok(()),
        }
    }
}

impl TouchRecord {
    /// A touch of the surface of that name, its tip centre at `at`; nothing else is known of it.
    #[must_use]
    pub fn new(surface: &str, at: Point3<f64>) -> Self {
        Self {
            surface: surface.to_owned(),
            label_found: false,
            at,
            noise: Noise::OfProbe,
            approach: None,
            id: None,
            placement: None,
            line: None,
        }
    }

    /// Reads a touch from a line of JSON with the keys of `[[touch]]`, which stands at line `number` of the input, from 1.
    ///
    /// # Errors
    /// As [`Measurement::read`].
    pub fn from_json(name: &str, number: usize, text: &str) -> Result<Self, InputError> {
        let before = "\n".repeat(number.saturating_sub(1));
        file::read_line(&Source::new(name, &(before + text)))
    }

    /// Whether its surface is stated.
    #[must_use]
    pub fn is_labelled(&self) -> bool {
        self.surface != UNLABELLED
    }

    /// The touch for a solver.
    ///
    /// # Errors
    /// [`TouchError::UnknownSurface`] with the nearest known name.
    pub fn touch(&self, fixture: &dyn Fixture) -> Result<Touch, TouchError> {
        let surface = fixture.surface_index(&self.surface)?;
        Ok(Touch { surface, at: self.at, noise: self.noise, approach: self.approach })
    }
}

impl From<TouchError> for InputError {
    fn from(error: TouchError) -> Self {
        match &error {
            TouchError::UnknownSurface { nearest, .. } => {
                Self::new("unknown-surface", error.to_string()).with_nearest(nearest.as_deref())
            }
            TouchError::Empty => Self::new("too-few-touches", error.to_string()),
            _ => Self::new("invalid-input", error.to_string()),
        }
    }
}

/// A fixture, in a message about its parameters.
fn told(plugin: &FixturePlugin) -> String {
    format!("fixture `{}`", plugin.name)
}

/// Groups the touches of a table.
fn by_placement(all: &Touches) -> Result<Vec<PlacementTouches>, InputError> {
    let mut placements: Vec<PlacementTouches> = Vec::new();
    for (record, touch) in all.records.iter().zip(&all.touches) {
        let Some(name) = &record.placement else {
            let line = record.line.map_or(String::new(), |line| format!("line {line}: "));
            let message = format!("{line}the touch belongs to no placement");
            return Err(InputError::new("invalid-input", message)
                .with_file(&all.file)
                .with_key("placement")
                .with_help(
                    "name placements in a column `placement` of the table, or by [[placement]] in the file; \
                     `touchref locate` takes the touches of one placement",
                ));
        };
        let known = placements.iter().position(|placement| placement.name.as_ref() == Some(name));
        let index = known.unwrap_or_else(|| {
            let touches = Touches { file: all.file.clone(), ..Touches::default() };
            placements.push(PlacementTouches { name: Some(name.clone()), touches });
            placements.len() - 1
        });
        placements[index].touches.records.push(record.clone());
        placements[index].touches.touches.push(*touch);
    }
    // What is to be known of the table is to be known once.
    if let Some(first) = placements.first_mut() {
        first.touches.warnings.clone_from(&all.warnings);
    }
    Ok(placements)
}

/// Touches whose surfaces are open.
fn unlabelled(records: &[TouchRecord]) -> InputError {
    let open = records.iter().enumerate().find(|(_, record)| !record.is_labelled());
    let first = open.map_or(String::new(), |(index, record)| {
        let line = record.line.map_or(String::new(), |line| format!(" (line {line})"));
        format!("touch {index}{line} does not say on which surface it is")
    });
    InputError::new("unknown-surface", first).with_key("surface").with_help(
        "name its surface, or solve with `--solver robust`, which finds the surfaces of touches without one",
    )
}

fn from_table(fixture: &dyn Fixture, input: &Input, units: Units) -> Result<Touches, InputError> {
    let names: Vec<&str> = fixture.surfaces().iter().map(|surface| surface.name.as_str()).collect();
    let mut reader = TableReader::open(input, &names)?.in_units(units);
    let mut touches = Touches { file: input.name(), ..Touches::default() };
    for record in &mut reader {
        touches.records.push(record?);
    }
    touches.warnings = reader.warnings().to_vec();
    if touches.records.is_empty() {
        return Err(InputError::new("too-few-touches", "the touch table has a header but no touches")
            .with_file(&touches.file)
            .with_help("add one line a touch below the header"));
    }
    Ok(touches)
}
