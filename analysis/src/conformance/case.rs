//! The fixture under test, and the measurements that are made up of it.

use nalgebra::{Point3, Vector3};
use rand::{Rng, RngExt, seq::SliceRandom};
use rand_distr::StandardNormal;
use touchref_core::{
    Fixture, FixturePlugin, Frame, ParameterKind, ParameterSpec, Parameters, Probe, Problem, Shape, Touch,
    Unknown, Value, parameters::TYPE,
};

use super::{Suite, without_panic};
use crate::{
    reference::condition,
    simulation::{Layout, generator, random_frame, random_layout, simulate},
};

/// Standard deviation of a touch in parts of the fixture's size: a good machine, so that sound layouts stay sound.
const NOISE: f64 = 1e-4;
/// Frames lie within this many sizes of the parent's origin.
pub(super) const REACH: f64 = 10.0;
/// Tip radius in parts of the smallest radius that is touched.
const TIP: f64 = 0.1;
/// The unit of the same measurement seen in another: inches for millimetres.
pub(super) const UNIT: f64 = 25.4;
/// Most touches beyond the fewest.
const MORE: usize = 8;
/// Condition up to which a layout is sound: first order holds at [`NOISE`] far beyond any error.
pub(super) const SOUND: f64 = 100.0;
/// Condition up to which exact touches tell a frame to far better than anyone needs.
pub(super) const REGULAR: f64 = 1e4;

/// A fixture under test.
#[derive(Debug)]
pub(crate) struct Subject<'a> {
    pub(super) suite: Suite,
    pub(super) plugin: &'a FixturePlugin,
    /// What it was built from, defaults filled in.
    pub(super) parameters: Parameters,
    pub(super) fixture: Box<dyn Fixture>,
    /// The same with all lengths times [`UNIT`].
    pub(super) in_other_unit: Box<dyn Fixture>,
}

/// Where a fixture is touched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Places {
    /// Its nominal layout.
    Nominal,
    /// Random places, as few as one of its alternatives needs.
    Fewest,
    /// Random places, more than that.
    More,
}

impl Places {
    pub(super) const ALL: [Self; 3] = [Self::Nominal, Self::Fewest, Self::More];

    fn words(self) -> &'static str {
        match self {
            Self::Nominal => "nominal layout",
            Self::Fewest => "fewest touches at random places",
            Self::More => "more touches at random places",
        }
    }
}

/// A simulated measurement.
#[derive(Debug, Clone)]
pub(super) struct Case {
    /// Which one, for messages.
    pub(super) what: String,
    pub(super) layout: Layout,
    pub(super) truth: Frame,
    pub(super) probe: Probe,
    pub(super) touches: Vec<Touch>,
}

impl<'a> Subject<'a> {
    pub(super) fn new(
        suite: Suite,
        plugin: &'a FixturePlugin,
        parameters: &Parameters,
    ) -> Result<Self, String> {
        let build = |parameters: &Parameters| {
            without_panic(|| plugin.build(parameters))?.map_err(|error| format!("{}: {error}", plugin.name))
        };
        let parameters =
            parameters.checked(plugin.parameters).map_err(|error| format!("{}: {error}", plugin.name))?;
        let fixture = build(&parameters)?;
        let in_other_unit = build(&in_unit(&parameters, plugin.parameters, UNIT))?;
        Ok(Self { suite, plugin, parameters, fixture, in_other_unit })
    }

    pub(super) fn size(&self) -> f64 {
        self.fixture.size()
    }

    /// The standard deviation of the noise.
    pub(super) fn sigma(&self) -> f64 {
        NOISE * self.size()
    }

    /// A tip that fits into every bore.
    pub(super) fn tip_radius(&self) -> f64 {
        let radius = |shape: &Shape| match shape {
            Shape::Cylinder { radius, .. } | Shape::Sphere { radius, .. } => *radius,
            _ => f64::INFINITY,
        };
        let shapes = self.fixture.surfaces().iter().map(|surface| radius(&surface.shape));
        TIP * shapes.fold(self.size(), f64::min)
    }

    /// The dimensions that the closed form leaves free.
    pub(super) fn measured(&self) -> Vec<Unknown> {
        let closed_form = self.fixture.closed_form();
        let measured = closed_form.map_or(&[][..], |closed_form| closed_form.measured());
        measured.iter().map(|index| Unknown::Dimension(*index)).collect()
    }

    /// A generator for the measurements of one kind.
    pub(super) fn generator(&self, places: Places, trial: u64) -> impl Rng + use<> {
        // Kinds have streams far apart.
        generator(self.suite.seed, ((places as u64) << 32) + trial)
    }

    pub(super) fn layout(&self, places: Places, rng: &mut impl Rng) -> Layout {
        if places == Places::Nominal {
            return self.fixture.nominal_layout();
        }
        let alternatives = &self.fixture.requirement().alternatives;
        let mut counts = alternatives[rng.random_range(0..alternatives.len())].clone();
        if places == Places::More {
            // Where a surface needs no touch, one on another may be meant to take its part.
            let touched: Vec<usize> = (0..counts.len()).filter(|surface| counts[*surface] > 0).collect();
            for _ in 0..rng.random_range(1..=MORE) {
                counts[touched[rng.random_range(0..touched.len())]] += 1;
            }
        }
        random_layout(&*self.fixture, &counts, rng)
    }

    /// A measurement with noise of standard deviation `noise`, of which the solver is told `sigma`; every other one
    /// with a tip.
    pub(super) fn case(&self, places: Places, trial: u64, noise: f64, sigma: Option<f64>) -> Case {
        let mut rng = self.generator(places, trial);
        let layout = self.layout(places, &mut rng);
        let truth = random_frame(REACH * self.size(), &mut rng);
        let tip_radius = if trial.is_multiple_of(2) { self.tip_radius() } else { 0.0 };
        let probe = Probe { tip_radius, tip_radius_u: 0.0, sigma };
        let touches = simulate(&*self.fixture, &layout, &truth, &probe, noise, &mut rng);
        let what = format!("{}, trial {trial}, tip radius {tip_radius}", places.words());
        Case { what, layout, truth, probe, touches }
    }

    /// The measurements of one kind whose layout has at most this condition, the measured dimensions among the
    /// unknowns.
    ///
    /// # Errors
    /// In words, where random layouts are hardly ever as good.
    pub(super) fn cases(
        &self,
        places: Places,
        noise: f64,
        sigma: Option<f64>,
        most_condition: f64,
    ) -> Result<Vec<Case>, String> {
        /// One in so many random layouts must be good enough; fewer, and the surfaces' extents are to blame.
        const ONE_IN: u64 = 10;
        let measured = self.measured();
        let all = (0..self.suite.trials).map(|trial| self.case(places, trial, noise, sigma));
        let good: Vec<Case> = all
            .filter(|case| {
                let problem = Problem::new(&*self.fixture, &case.touches, case.probe);
                problem.is_ok_and(|problem| condition(&problem, &measured, &case.truth) <= most_condition)
            })
            .collect();
        if good.len() as u64 * ONE_IN < self.suite.trials {
            return Err(format!(
                "{}: only {} of {} layouts have a condition of at most {most_condition}",
                places.words(),
                good.len(),
                self.suite.trials
            ));
        }
        Ok(good)
    }
}

/// The parameters with all lengths times `unit`.
fn in_unit(parameters: &Parameters, specs: &[ParameterSpec], unit: f64) -> Parameters {
    let mut scaled = parameters.clone();
    for (name, value) in parameters.iter() {
        let kind = specs.iter().find(|spec| spec.name == name).map(|spec| spec.kind);
        match (kind, value) {
            (Some(ParameterKind::Length), Value::Number { value, u }) => {
                scaled.set(name, Value::Number { value: value * unit, u: u * unit });
            }
            (Some(ParameterKind::Tables(specs)), Value::Tables(tables)) => {
                let of = |table: &Parameters| {
                    let spec = specs.iter().find(|spec| spec.name == table.word(TYPE));
                    in_unit(table, spec.map_or(&[], |spec| spec.parameters), unit)
                };
                scaled.set(name, Value::Tables(tables.iter().map(of).collect()));
            }
            (Some(ParameterKind::Coordinate), Value::Number { value, .. }) => {
                scaled.set(name, Value::from(value * unit));
            }
            (Some(ParameterKind::Lengths3 | ParameterKind::Point), Value::Numbers(numbers)) => {
                scaled.set(name, Value::Numbers(numbers.iter().map(|number| number * unit).collect()));
            }
            _ => {}
        }
    }
    scaled
}

/// One measurement seen in another way.
pub(super) struct View<'a> {
    /// In which way, for messages.
    pub(super) what: &'static str,
    pub(super) fixture: &'a dyn Fixture,
    pub(super) touches: Vec<Touch>,
    /// Which touch of the measurement each of these is.
    pub(super) order: Vec<usize>,
    pub(super) probe: Probe,
    /// Pose of the measurement's parent in this one's, in this one's unit.
    pub(super) motion: Frame,
    pub(super) unit: f64,
}

impl<'a> View<'a> {
    /// A measurement with its touches in this order, seen from a parent in which its own stands at `motion`, in the unit
    /// of a fixture.
    fn new(
        what: &'static str,
        (fixture, unit): (&'a dyn Fixture, f64),
        case: &Case,
        order: Vec<usize>,
        motion: Frame,
    ) -> Self {
        let seen = |from: &usize| {
            let touch = case.touches[*from];
            Touch { at: motion.to_parent(&(touch.at * unit)), ..touch }
        };
        let touches = order.iter().map(seen).collect();
        let Probe { tip_radius, tip_radius_u, sigma } = case.probe;
        let probe = Probe {
            tip_radius: tip_radius * unit,
            tip_radius_u: tip_radius_u * unit,
            sigma: sigma.map(|sigma| sigma * unit),
        };
        Self { what, fixture, touches, order, probe, motion, unit }
    }

    /// A frame of the measurement, seen in this way.
    pub(super) fn of(&self, frame: &Frame) -> Frame {
        Frame { origin: frame.origin * self.unit, ..*frame }.seen_from(&self.motion)
    }
}

impl Subject<'_> {
    /// A measurement with its touches in another order, from another parent, in another unit.
    pub(super) fn views(&self, case: &Case, rng: &mut impl Rng) -> [View<'_>; 3] {
        let as_is: Vec<usize> = (0..case.touches.len()).collect();
        let mut shuffled = as_is.clone();
        shuffled.shuffle(rng);
        let motion = random_frame(REACH * self.size(), rng);
        let (still, own, other) = (Frame::identity(), &*self.fixture, &*self.in_other_unit);
        [
            View::new("touches in another order", (own, 1.0), case, shuffled, still),
            View::new("seen from another parent", (own, 1.0), case, as_is.clone(), motion),
            View::new("in another unit of length", (other, UNIT), case, as_is, still),
        ]
    }

    /// Touches that no measurement should ever have, and what is absurd about them.
    pub(super) fn wild(&self) -> Vec<(String, Vec<Touch>, Probe)> {
        let size = self.size();
        let mut rng = self.generator(Places::Nominal, u64::from(u32::MAX));
        let probe = Probe { tip_radius: self.tip_radius(), tip_radius_u: 0.0, sigma: Some(self.sigma()) };
        let truth = random_frame(size, &mut rng);
        let layout = self.fixture.nominal_layout();
        let sound = simulate(&*self.fixture, &layout, &truth, &probe, 0.0, &mut rng);
        let surfaces = self.fixture.surfaces().len();
        let mut random = || Vector3::from(std::array::from_fn::<f64, 3, _>(|_| rng.sample(StandardNormal)));
        let (direction, anywhere) = (random().normalize() * size, sound.iter().map(|_| random() * size));
        let anywhere: Vec<Vector3<f64>> = anywhere.collect();

        let placed = |place: &dyn Fn(usize, &Touch) -> Point3<f64>| -> Vec<Touch> {
            let touches = sound.iter().enumerate();
            touches.map(|(index, touch)| Touch { at: place(index, touch), ..*touch }).collect()
        };
        let first_of = |surface: usize| sound.iter().find(|touch| touch.surface == surface).map(|t| t.at);
        let mut all: Vec<(String, Vec<Touch>)> = vec![
            ("all touches at one point".to_owned(), placed(&|_, _| sound[0].at)),
            ("all touches at the parent's origin".to_owned(), placed(&|_, _| Point3::origin())),
            (
                "the touches of each surface at one point".to_owned(),
                placed(&|_, touch| first_of(touch.surface).unwrap_or(touch.at)),
            ),
            (
                "all touches in a line".to_owned(),
                placed(&|index, _| sound[0].at + direction * (index as f64 / 7.0)),
            ),
            (
                "the touches of each surface in a line".to_owned(),
                placed(&|index, touch| {
                    first_of(touch.surface).unwrap_or(touch.at) + direction * (index as f64)
                }),
            ),
            ("touches anywhere".to_owned(), placed(&|index, _| Point3::from(anywhere[index]))),
            ("touches of the mirror image".to_owned(), placed(&|_, touch| Point3::from(-touch.at.coords))),
            ("labels exchanged".to_owned(), {
                let next = |touch: &Touch| Touch { surface: (touch.surface + 1) % surfaces, ..*touch };
                sound.iter().map(next).collect()
            }),
            ("one touch alone".to_owned(), sound[..1].to_vec()),
        ];
        for surface in 0..surfaces {
            let name = &self.fixture.surfaces()[surface].name;
            let moved = sound.iter().map(|touch| Touch { surface, ..*touch }).collect();
            all.push((format!("all touches labelled `{name}`"), moved));
            let without: Vec<Touch> =
                sound.iter().filter(|touch| touch.surface != surface).copied().collect();
            if !without.is_empty() && without.len() < sound.len() {
                all.push((format!("no touch on `{name}`"), without));
            }
        }
        for offset in [1e6, 1e15, 1e100, 1e300] {
            all.push((
                format!("touches {offset:e} sizes away"),
                placed(&|_, t| t.at + direction.normalize() * (offset * size)),
            ));
        }
        for scale in [1e-310, 1e-200, 1e-100, 1e-9, 1e9, 1e100, 1e200, 1e300] {
            all.push((format!("coordinates times {scale:e}"), placed(&|_, touch| touch.at * scale)));
        }
        let mut with_probe: Vec<(String, Vec<Touch>, Probe)> =
            all.into_iter().map(|(what, touches)| (what, touches, probe)).collect();
        for sigma in [1e-300, 1e300] {
            let probe = Probe { sigma: Some(sigma), ..probe };
            with_probe.push((format!("a sigma of {sigma:e}"), sound.clone(), probe));
        }
        for tip_radius in [1e3 * size, 1e300] {
            let probe = Probe { tip_radius, ..probe };
            with_probe.push((format!("a tip radius of {tip_radius:e}"), sound.clone(), probe));
        }
        with_probe
    }
}
