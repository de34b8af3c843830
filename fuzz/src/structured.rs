//! What takes values: building plugins from any parameters, and locating from any touches.

use arbitrary::{Result, Unstructured};
use nalgebra::{Matrix3, Point3, Vector3};
use touchref::{
    Fixture, FixturePlugin, Frame, Literal, MAX_DIMENSIONS, Noise, ParameterKind, ParameterSpec, Parameters,
    Plugin, Probe, Problem, Solution, SolveError, Solver, SolverPlugin, Touch, Units, Value,
    analysis::{random_frame, random_layout, simulate, simulation::generator},
    io::{
        ErrorRecord, Measurement, SolutionRecord, TouchRecord,
        solution::{Context, FixtureRecord},
        write,
    },
};

use super::text::REGISTRY;

/// More touches make the slowest solvers slower, and nothing else.
const MOST_TOUCHES: usize = 10;

/// A number: mostly one of up to `size` in magnitude, sometimes any at all.
fn number(u: &mut Unstructured<'_>, size: f64) -> Result<f64> {
    const ODD: [f64; 10] =
        [0.0, -0.0, 1.0, -1.0, f64::MIN_POSITIVE, 1e-300, 1e300, f64::MAX, f64::INFINITY, f64::NAN];
    Ok(match u.int_in_range(0..=31)? {
        30 => u.arbitrary()?,
        31 => *u.choose(&ODD)?,
        _ => size * f64::from(u.arbitrary::<i32>()?) / f64::from(i32::MAX),
    })
}

/// A number above zero, as far as it is an ordinary one.
fn length(u: &mut Unstructured<'_>, size: f64) -> Result<f64> {
    let value = number(u, size)?;
    Ok(if value.abs() <= size { 0.5 * (size + value) } else { value })
}

fn point(u: &mut Unstructured<'_>, size: f64) -> Result<Point3<f64>> {
    Ok(Point3::new(number(u, size)?, number(u, size)?, number(u, size)?))
}

/// A value of any kind.
fn any_value(u: &mut Unstructured<'_>, depth: usize) -> Result<Value> {
    Ok(match u.int_in_range(0..=if depth > 0 { 5 } else { 4 })? {
        0 => Value::Number { value: u.arbitrary()?, u: u.arbitrary()? },
        1 => Value::Numbers(u.arbitrary()?),
        2 => Value::Word(u.arbitrary()?),
        3 => Value::Flag(u.arbitrary()?),
        4 => Value::Words(u.arbitrary()?),
        _ => {
            let tables = (0..u.int_in_range(0..=3)?).map(|_| {
                (0..u.int_in_range(0..=4)?).try_fold(Parameters::new(), |table, _| {
                    Ok(table.with(u.arbitrary()?, any_value(u, depth - 1)?))
                })
            });
            Value::Tables(tables.collect::<Result<_>>()?)
        }
    })
}

/// A value of this kind, mostly within its range.
fn value_of(u: &mut Unstructured<'_>, spec: &ParameterSpec) -> Result<Value> {
    Ok(match spec.kind {
        ParameterKind::Length => {
            let size = if spec.name.contains("radius") { 25.0 } else { 150.0 };
            Value::Number { value: length(u, size)?, u: uncertainty(u, size)? }
        }
        ParameterKind::Lengths3 => Value::from([length(u, 25.0)?, length(u, 25.0)?, length(u, 25.0)?]),
        ParameterKind::Angle { above, below } => {
            let middle = 0.5 * (above + below);
            Value::Number { value: middle + number(u, below - middle)?, u: uncertainty(u, middle)? }
        }
        ParameterKind::Choice(words) => Value::from(*u.choose(words)?),
        ParameterKind::Flag => Value::Flag(u.arbitrary()?),
        ParameterKind::Name => Value::from(*u.choose(&["a", "b", "c", "d", "e"])?),
        ParameterKind::Words(words) => {
            let chosen = (0..u.int_in_range(0..=2)?).map(|_| u.choose(words).copied());
            Value::from(chosen.collect::<Result<Vec<&str>>>()?.as_slice())
        }
        ParameterKind::Coordinate => Value::from(number(u, 100.0)?),
        ParameterKind::Point | ParameterKind::Direction => Value::from(<[f64; 3]>::from(point(u, 100.0)?)),
        ParameterKind::Tables(tables) => {
            let made = (0..u.int_in_range(1..=4)?).map(|_| {
                let table = u.choose(tables)?;
                let start = Parameters::new().with(touchref::parameters::TYPE, table.name);
                with_parameters(u, start, table.parameters)
            });
            Value::Tables(made.collect::<Result<_>>()?)
        }
        _ => any_value(u, 1)?,
    })
}

fn uncertainty(u: &mut Unstructured<'_>, size: f64) -> Result<f64> {
    Ok(if u.ratio(1, 4)? { number(u, 1e-3 * size)?.abs() } else { 0.0 })
}

/// Parameters as these descriptions want them: those that must be given, and some that need not be.
fn with_parameters(
    u: &mut Unstructured<'_>,
    start: Parameters,
    specs: &[ParameterSpec],
) -> Result<Parameters> {
    let mut parameters = start;
    for spec in specs {
        if spec.default.is_none() && !u.ratio(1, 64)? || u.ratio(1, 4)? {
            parameters.set(spec.name, value_of(u, spec)?);
        }
    }
    Ok(parameters)
}

/// Any parameters, most of them near what these descriptions want.
fn any_parameters(u: &mut Unstructured<'_>, specs: &[ParameterSpec]) -> Result<Parameters> {
    let mut parameters = with_parameters(u, Parameters::new(), specs)?;
    if u.ratio(1, 4)? {
        let name = match specs.get(u.int_in_range(0..=8)?) {
            Some(spec) => spec.name,
            None => u.arbitrary()?,
        };
        parameters.set(name, any_value(u, 2)?);
    }
    Ok(parameters)
}

/// Builds any plugin from any parameters; what is built keeps what its trait promises.
pub(super) fn registry(data: &[u8]) {
    let u = &mut Unstructured::new(data);
    // Bytes that are too few are no case.
    let _ = match u.int_in_range(0..=7) {
        Ok(0) => build(u, REGISTRY.solvers(), |solver, plugin| assert_eq!(solver.name(), plugin.name)),
        Ok(1) => build(u, REGISTRY.dialects(), |dialect, plugin| {
            let told = Literal::new(plugin.name, dialect, &Frame::identity(), Units::Millimetre, &[]);
            assert!(told.is_ok(), "{told:?}");
        }),
        _ => build(u, REGISTRY.fixtures(), is_fixture),
    };
}

fn build<P: Plugin>(
    u: &mut Unstructured<'_>,
    plugins: &[&'static P],
    check: impl Fn(&P::Product, &'static P),
) -> Result<()> {
    let plugin = *u.choose(plugins)?;
    let parameters = any_parameters(u, plugin.parameters())?;
    match plugin.build(&parameters) {
        Ok(built) => check(&built, plugin),
        Err(error) => {
            assert!(!error.name.is_empty() || parameters.get("").is_some(), "{error:?}");
            assert!(!error.to_string().is_empty() && !error.expected.is_empty(), "{error:?}");
        }
    }
    Ok(())
}

fn is_fixture(fixture: &(dyn Fixture + 'static), plugin: &'static FixturePlugin) {
    /// Of the size: rounding of points that lie on their surfaces.
    const ROUNDING: f64 = 1e-9;
    let surfaces = fixture.surfaces();
    assert!(fixture.kind() == plugin.name && !surfaces.is_empty());
    for (index, surface) in surfaces.iter().enumerate() {
        assert_eq!(fixture.surface_index(&surface.name), Ok(index), "names are unique");
    }
    assert!(fixture.size().is_finite() && fixture.size() > 0.0, "{fixture:?}");
    assert!(fixture.dimensions().len() <= MAX_DIMENSIONS);
    let requirement = fixture.requirement();
    assert!(requirement.alternatives.iter().all(|row| row.len() == surfaces.len()));
    let layout = fixture.nominal_layout();
    for (surface, at) in &layout {
        assert!(at.iter().all(|v| v.is_finite()), "{fixture:?}");
        let off = surfaces[*surface].seen_from(at).distance.abs();
        let scale = fixture.size() + at.coords.norm();
        assert!(off <= ROUNDING * scale, "{off} off `{}`: {fixture:?}", surfaces[*surface].name);
    }
    // Written in any of the ways there are, its parameters are the same.
    let parameters = fixture.parameters();
    let told = FixtureRecord::new(plugin.name, parameters);
    let written = write::measurement(plugin.name, parameters, Units::Millimetre, &Probe::default(), &[]);
    let file = Measurement::from_text("m.toml", &written, std::path::Path::new(""));
    let file = file.unwrap_or_else(|error| panic!("{error}\n{written}"));
    for again in [plugin.build(parameters).ok(), told.build(&REGISTRY).ok(), file.fixture(&REGISTRY).ok()] {
        let again = again.unwrap_or_else(|| panic!("{written}"));
        assert_eq!(again.parameters(), parameters, "{written}");
    }
}

/// A measurement, and how it is solved.
struct Case {
    fixture: Box<dyn Fixture>,
    solver: Box<dyn Solver>,
    probe: Probe,
    touches: Vec<Touch>,
    near: Option<Frame>,
    /// The true frame, where the touches are simulated with the noise that is stated.
    truth: Option<Frame>,
}

/// Where frames are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Search {
    /// Where the fixture's equations say that there may be some: a fraction of a millisecond.
    Led,
    /// Everywhere, a thousand times as long.
    Everywhere,
}

/// Locates from any touches of a fixture that has equations, by a solver that uses them; a frame that is handed out is one,
/// and is told as it is.
pub(super) fn locate(data: &[u8]) {
    run(data, Search::Led);
}

/// The same with every other fixture or solver.
pub(super) fn locate_everywhere(data: &[u8]) {
    run(data, Search::Everywhere);
}

fn run(data: &[u8], search: Search) {
    match Case::read(&mut Unstructured::new(data)) {
        Ok(Some(case)) if case.search() == search => case.run(),
        _ => {}
    }
}

impl Case {
    /// `None` where there is no such fixture.
    fn read(u: &mut Unstructured<'_>) -> Result<Option<Self>> {
        let plugin: &FixturePlugin = u.choose(REGISTRY.fixtures())?;
        let parameters = with_parameters(u, Parameters::new(), plugin.parameters)?;
        let Ok(fixture) = plugin.build(&parameters) else { return Ok(None) };
        let plugin: &SolverPlugin = u.choose(REGISTRY.solvers())?;
        let parameters = with_parameters(u, Parameters::new(), plugin.parameters)?;
        let Ok(solver) = plugin.build(&parameters) else { return Ok(None) };
        let size = fixture.size();
        let probe = Probe {
            tip_radius: if u.arbitrary()? { number(u, 2.0)?.abs() } else { 0.0 },
            tip_radius_u: uncertainty(u, 2.0)?,
            sigma: if u.ratio(7, 8)? { Some(number(u, 1e-3 * size)?.abs()) } else { None },
        };
        let near = if u.ratio(1, 8)? {
            let quaternion = [u.arbitrary()?, u.arbitrary()?, u.arbitrary()?, u.arbitrary()?];
            Frame::from_quaternion_xyzw(point(u, size)?, quaternion)
        } else {
            None
        };
        let mut case = Self { fixture, solver, probe, touches: Vec::new(), near, truth: None };
        if u.ratio(7, 8)? {
            case.simulate(u)?;
        }
        for _ in 0..u.int_in_range(0..=if case.truth.is_some() { 1 } else { MOST_TOUCHES })? {
            case.disturb(u)?;
        }
        case.touches.truncate(MOST_TOUCHES);
        Ok(Some(case))
    }

    /// Touches of a fixture that stands somewhere.
    fn simulate(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let fixture = &*self.fixture;
        let mut rng = generator(u.arbitrary::<u16>()?.into(), 0);
        let layout = if u.arbitrary()? {
            fixture.nominal_layout()
        } else {
            let counts = (0..fixture.surfaces().len()).map(|_| u.int_in_range(0..=4));
            random_layout(fixture, &counts.collect::<Result<Vec<usize>>>()?, &mut rng)
        };
        let truth = random_frame(10.0 * fixture.size(), &mut rng);
        // The generator takes no deviation that is none.
        let noise = self.probe.sigma.filter(|sigma| sigma.is_finite()).unwrap_or(0.0);
        self.touches = simulate(fixture, &layout, &truth, &self.probe, noise, &mut rng);
        self.truth = Some(truth);
        Ok(())
    }

    /// Another touch, or another place, surface, noise or approach of one.
    fn disturb(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let (size, surfaces) = (self.fixture.size(), self.fixture.surfaces().len());
        let kind = u.int_in_range(0..=6)?;
        let touch = match self.touches.len() {
            0 => None,
            count => Some(u.choose_index(count)?),
        };
        self.truth = None;
        match (touch.map(|index| &mut self.touches[index]), kind) {
            (None, _) | (_, 0) => {
                self.touches.push(Touch::new(u.int_in_range(0..=surfaces)?, point(u, 3.0 * size)?));
            }
            (Some(touch), 1) => touch.at = point(u, 3.0 * size)?,
            (Some(touch), 2) => touch.at += point(u, 0.01 * size)?.coords,
            (Some(touch), 3) => touch.surface = u.int_in_range(0..=surfaces)?,
            (Some(touch), 4) => touch.noise = Noise::Sigma(number(u, 1e-3 * size)?.abs()),
            (Some(touch), 5) => {
                let square_root = Matrix3::from_fn(|_, _| number(u, 1e-3 * size).unwrap_or(0.0));
                touch.noise = Noise::Covariance(square_root * square_root.transpose());
            }
            (Some(touch), _) => *touch = touch.with_approach(point(u, 1.0)?.coords),
        }
        Ok(())
    }

    fn search(&self) -> Search {
        let led = self.fixture.closed_form().is_some() && self.solver.name() != "global";
        if led { Search::Led } else { Search::Everywhere }
    }

    fn run(&self) {
        let Ok(problem) = Problem::new(&*self.fixture, &self.touches, self.probe) else { return };
        let problem = self.near.map_or(problem, |near| problem.near(near));
        match self.solver.solve(&problem) {
            Ok(solution) => self.is_frame(&problem, &solution),
            Err(error) => self.is_refusal(&error),
        }
    }

    fn records(&self) -> Vec<TouchRecord> {
        let surfaces = self.fixture.surfaces();
        let record = |touch: &Touch| TouchRecord {
            noise: touch.noise,
            approach: touch.approach,
            ..TouchRecord::new(&surfaces[touch.surface].name, touch.at)
        };
        self.touches.iter().map(record).collect()
    }

    fn is_refusal(&self, error: &SolveError) {
        assert!(!error.code().is_empty() && !error.to_string().is_empty());
        let record = ErrorRecord::of_refusal(error, Units::Millimetre, &self.records());
        serde_json::to_string(&record).expect("a refusal is JSON");
    }

    fn is_frame(&self, problem: &Problem<'_>, solution: &Solution) {
        /// Rounding of a residual, in parts of the largest coordinate, size or radius that it is computed from.
        const ROUNDING: f64 = 1e-9;
        /// Of a squared misfit, in parts of it.
        const OF_SQUARES: f64 = 1e-6;
        /// Squared distance from the truth in the frame's own covariance: by chance once in 1e19.
        const WRONG: f64 = 100.0;
        let frame = &solution.frame;
        assert!(frame.is_sound(), "{frame:?}");
        assert_eq!(solution.residuals.len(), self.touches.len());
        let exact = solution.adjustments.is_empty();
        let mut chi_square = 0.0;
        for (index, (touch, residual)) in self.touches.iter().zip(&solution.residuals).enumerate() {
            assert!(residual.length.is_finite(), "{solution:?}");
            let seen = self.fixture.surfaces()[touch.surface].seen_from(&frame.to_fixture(&touch.at));
            let expected = seen.distance - self.probe.tip_radius;
            let scale = [touch.at.coords.amax(), frame.origin.coords.amax(), self.fixture.size()];
            let scale = scale.into_iter().fold(self.probe.tip_radius, f64::max);
            if exact {
                let off = (residual.length - expected).abs();
                assert!(off <= ROUNDING * scale, "touch {index}: {residual:?}, {expected}");
            }
            if !solution.excluded.contains(&index) {
                chi_square += residual.normalized.unwrap_or(0.0).powi(2);
            }
        }
        let used = self.touches.len() - solution.excluded.len();
        assert_eq!(solution.degrees_of_freedom, used.saturating_sub(problem.unknowns()), "{solution:?}");
        assert!(solution.rms.is_finite() && solution.rms >= 0.0, "{solution:?}");
        if let Some(told) = solution.chi_square {
            assert!(told.is_finite() && told >= 0.0, "{solution:?}");
            let off = (told - chi_square).abs();
            // That of a root is one to first order.
            let summed = exact && solution.iteration.is_some();
            assert!(!summed || off <= OF_SQUARES * (1.0 + told), "{told}, {chi_square}: {solution:?}");
        }
        assert!(solution.p_value.is_none_or(|p| (0.0..=1.0).contains(&p)), "{solution:?}");
        if let Some(covariance) = &solution.covariance {
            let matrix = &covariance.matrix;
            assert!(matrix.iter().all(|v| v.is_finite()), "{matrix}");
            assert!((matrix - matrix.transpose()).amax() <= ROUNDING * matrix.amax(), "{matrix}");
            assert!(matrix.diagonal().iter().all(|v| *v >= 0.0), "{matrix}");
        }
        let trust = &solution.trust;
        if let Some(sigma) = trust.sigma {
            assert!(trust.from_sigma <= sigma && sigma < trust.up_to_sigma, "{trust:?}");
        }
        if let (Some(truth), true) = (&self.truth, self.is_true()) {
            let off = solution.squared_distance(truth).unwrap_or(0.0);
            assert!(off < WRONG, "a wrong frame, {off}: {solution:?}, true is {truth:?}");
        }
        self.is_told(solution);
    }

    /// Whether what is stated of the fixture and the probe is how the touches were simulated.
    fn is_true(&self) -> bool {
        let exact = self.fixture.dimensions().iter().all(|dimension| dimension.u == 0.0);
        self.near.is_none() && exact && self.probe.tip_radius_u == 0.0 && self.probe.sigma.is_some()
    }

    /// The result reads back as it was written.
    fn is_told(&self, solution: &Solution) {
        let context = Context {
            kind: self.fixture.kind(),
            parameters: self.fixture.parameters(),
            units: Units::Millimetre,
            probe: &self.probe,
            touches: &self.records(),
        };
        let record = SolutionRecord::new(&context, solution);
        let written = serde_json::to_string(&record).expect("a record is JSON");
        let again = SolutionRecord::from_text("r.json", &written);
        assert_eq!(again.as_ref(), Ok(&record), "{written}");
        let touches: Vec<Vector3<f64>> = self.touches.iter().map(|touch| touch.at.coords).collect();
        let points: Vec<Point3<f64>> = touches.into_iter().map(Point3::from).collect();
        let dialect = REGISTRY.dialect("matrix").expect("it is built in").build(&Parameters::new());
        let told = Literal::new(
            "matrix",
            &*dialect.expect("it needs no parameters"),
            &solution.frame,
            Units::Millimetre,
            &points,
        );
        assert!(told.is_ok(), "{told:?}");
    }
}
