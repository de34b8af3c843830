//! Where to touch: layouts that make the frame as sure as it can be where it is used.
//!
//! A [`Planner`] searches the reachable part of each surface by exchange of touches from several starts, the same on every
//! machine, and moves what it finds over the surfaces until nothing helps. What it hands out has passed two tests: from
//! the noise-free touches the solver accepts the frame, so that no other one survives, and every touch is checked by the
//! others as far as its count allows. [`Planner::next`] tells the one touch that helps a measurement most.
//!
//! Predictions are to first order ([`Linear`]); uncertain sizes and tip radius are unknowns beside the frame. Without a
//! stated sigma all uncertainties are for touches of standard deviation 1 and only their ratios tell.

use std::cmp::Ordering;

use nalgebra::{Matrix6, Point3, Vector3};
use rand::RngExt;
use rayon::prelude::*;
use thiserror::Error;
use touchref_core::{
    Fixture, Frame, Probe, Problem, SolveError, Solver, Touch, TouchError, Trust,
    fixture::touches_per_surface,
};

use crate::{
    linear::{Linear, lever},
    simulation::{Layout, generator},
    uncertainty::Spread,
};

mod free;
mod next;
mod reach;
mod search;

pub use free::free_motions;
pub use next::{Effect, Next};
pub use reach::{Cone, Reach};

use reach::Site;
use search::{Checks, Counts, Design, Scene};

/// The redundancy number below which an error of a touch is as good as unseen: a test at power 80 % would not notice one
/// of 13 standard deviations.
pub const LEAST_REDUNDANCY: f64 = 0.1;
/// Starts of one search. The best of these comes from most of them on the built-in fixtures.
const STARTS: usize = 12;
/// Layouts of equal score (parts of it) are one, turned or mirrored.
const SAME: f64 = 1e-6;
/// A redundancy number this near the least counts as that: on seven touches of `cylinder-plane` 0.1 is the most that all
/// can have, and a search comes near only.
pub const REDUNDANCY_ROUNDING: f64 = 5e-4;
/// Weights with which the search asks for redundancy numbers: loose first, to come near without being caught.
const CHECK_WEIGHTS: [f64; 5] = [100.0, 1_000.0, 10_000.0, 100_000.0, 1_000_000.0];
/// Designs that are followed from one weight to the next.
const FOLLOWED: usize = 3;
/// Random layouts with which a plan is compared; an odd number has a median.
const RANDOM_LAYOUTS: u64 = 201;
/// Draws for one touch of a random layout that a cone may refuse.
const RANDOM_DRAWS: usize = 1000;
/// Random layouts that are tried where no optimum is sound.
const SECOND_CHOICES: usize = 24;
/// By how much more than with the count of touches a variance may fall: a better layout of more.
const FASTER: f64 = 4.0;
/// The most touches that are tried to meet a target.
const MOST_TOUCHES: usize = 40;

/// What is asked of a layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Criterion {
    /// The least standard uncertainty along the worst direction at the worst point of use.
    #[default]
    Worst,
    /// The least volume of the confidence region of the frame, and of the sizes that are unknowns beside it: D-optimal.
    Volume,
}

/// How many touches.
#[derive(Debug, Clone, PartialEq)]
pub enum Wanted {
    /// So many on each surface, in the fixture's order.
    PerSurface(Vec<usize>),
    /// So many altogether, on whichever surfaces they help most.
    Total(usize),
    /// The fewest with which the worst-case standard uncertainty at every point of use is at most this.
    Target(f64),
}

/// Looks for layouts.
#[derive(Debug)]
pub struct Planner<'a> {
    /// The fixture.
    pub fixture: &'a dyn Fixture,
    /// The probe.
    pub probe: Probe,
    /// Who must accept the frame.
    pub solver: &'a dyn Solver,
    /// What the probe can reach.
    pub reach: Reach,
    /// Points at which the frame is used, in fixture coordinates: they move with it.
    pub points: Vec<Point3<f64>>,
    /// What is asked for.
    pub criterion: Criterion,
    /// The least redundancy number asked of every touch where their count allows it; 0 asks for none.
    pub least_redundancy: f64,
}

/// A layout, and what it promises. Everything is in fixture coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Contact points, by surface.
    pub layout: Layout,
    /// Standard uncertainty along the worst direction at each point of use.
    pub uncertainties: Vec<f64>,
    /// Redundancy number of each touch.
    pub redundancy: Vec<f64>,
    /// Whether the count of touches allows every redundancy number to be as large as asked.
    pub redundancy_possible: bool,
    /// Whether the measurement must tell the approach directions: without them another frame fits as well.
    pub approach_needed: bool,
    /// How far the frame would stand.
    pub trust: Trust,
    /// Worst-case standard uncertainty of the naive layout of as many touches; `None` where that leaves a motion free or
    /// is out of reach.
    pub naive: Option<f64>,
    /// Median of the worst-case standard uncertainty of random layouts of as many touches; `None` where most leave a
    /// motion free.
    pub random_median: Option<f64>,
}

/// Why there is no plan.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The probe's numbers make no problem.
    #[error(transparent)]
    Touches(#[from] TouchError),
    /// The touches asked for do not fix the frame.
    #[error("too few touches: {missing}")]
    TooFewTouches {
        /// What is missing, in words.
        missing: String,
    },
    /// A surface that is to be touched cannot be reached.
    #[error("no point of `{surface}` can be reached")]
    Unreachable {
        /// Its name.
        surface: String,
    },
    /// No layout of so many touches fixes the frame, or there is no room for them.
    #[error("no layout of these touches within reach fixes the frame")]
    NoLayout,
    /// The target is not met.
    #[error(
        "{touches} touches reach a worst-case standard uncertainty of {reached:.3e}, the target is {target:.3e}; more than \
         {MOST_TOUCHES} would be needed, if any number does"
    )]
    NotMet {
        /// Of the plans that were made, how many touches the surest has.
        touches: usize,
        /// What these reach.
        reached: f64,
        /// What was asked for.
        target: f64,
    },
    /// The solver accepts the frame of none of the best layouts, even without noise.
    #[error("the frame would stand on none of the {tried} best layouts; on the best of them: {refusal}")]
    NoSoundLayout {
        /// How many were tried.
        tried: usize,
        /// Why not on the best of them.
        refusal: Box<SolveError>,
    },
}

impl Plan {
    /// The largest of the uncertainties.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.uncertainties.iter().copied().fold(0.0, f64::max)
    }
}

/// Standard uncertainty along the worst direction at each point of a fixture (fixture coordinates) that stands at `frame`
/// with this covariance.
#[must_use]
pub fn worst_case(covariance: &Matrix6<f64>, frame: &Frame, points: &[Point3<f64>]) -> Vec<f64> {
    let at = |point: &Point3<f64>| {
        let lever = lever(frame, point);
        Spread(lever * covariance * lever.transpose()).worst().0
    };
    points.iter().map(at).collect()
}

/// Points of use where none is named: the fixture's origin, and on each of its axes one fixture size to either side.
#[must_use]
pub fn default_points(fixture: &dyn Fixture) -> Vec<Point3<f64>> {
    let along = |axis: usize| [1.0, -1.0].map(|side| Point3::from(Vector3::ith(axis, side * fixture.size())));
    std::iter::once(Point3::origin()).chain((0..3).flat_map(along)).collect()
}

impl Planner<'_> {
    /// The best layout that is sound.
    ///
    /// # Errors
    /// A [`PlanError`].
    pub fn plan(&self, wanted: &Wanted) -> Result<Plan, PlanError> {
        let anywhere = self.touches(&self.fixture.nominal_layout());
        let problem = Problem::new(self.fixture, &anywhere, self.probe)?;
        let scene = Scene::new(problem, &self.reach, &self.points, self.criterion, false);
        match wanted {
            Wanted::PerSurface(counts) => {
                self.require(counts)?;
                self.unreached(&scene, |surface| counts[surface] > 0)?;
                self.best(scene, &vec![counts.clone(); STARTS], &Counts::Kept)
            }
            Wanted::Total(total) => self.of_total(scene, *total),
            Wanted::Target(target) => self.fewest(&problem, *target),
        }
    }

    /// The best layout of so many touches on each surface by the criterion alone: nobody asks whether it is checked, or
    /// whether another frame fits it as well.
    ///
    /// # Errors
    /// A [`PlanError`].
    pub fn unconstrained(&self, counts: &[usize]) -> Result<Layout, PlanError> {
        let anywhere = self.touches(&self.fixture.nominal_layout());
        let problem = Problem::new(self.fixture, &anywhere, self.probe)?;
        let scene = Scene::new(problem, &self.reach, &self.points, self.criterion, false);
        let starts = (0..STARTS as u64).into_par_iter().filter_map(|number| scene.start(counts, number));
        let best = optima(&scene, starts.collect(), &Counts::Kept).into_iter().next();
        best.map(|design| contacts_of(&design)).ok_or(PlanError::NoLayout)
    }

    /// The fewest touches that meet a target.
    fn fewest(&self, problem: &Problem<'_>, target: f64) -> Result<Plan, PlanError> {
        let requirement = self.fixture.requirement();
        let least = requirement.alternatives.iter().map(|need| need.iter().sum()).min().unwrap_or(0);
        let (mut touches, mut reached) = (0, f64::INFINITY);
        let mut total = least.max(requirement.total).max(1);
        while total <= MOST_TOUCHES {
            let mut next = total + 1;
            let scene = Scene::new(*problem, &self.reach, &self.points, Criterion::Worst, false);
            match self.of_total(scene, total) {
                Ok(plan) if plan.worst() <= target => return Ok(plan),
                Ok(plan) => {
                    if plan.worst() < reached {
                        (touches, reached) = (total, plan.worst());
                    }
                    // Variances fall with the count of touches, and not much faster.
                    let wanted = total as f64 * (plan.worst() / target).powi(2) / FASTER;
                    // A count beyond all reason is cut off by the cast.
                    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
                    let wanted = wanted as usize;
                    next = next.max(wanted);
                }
                // More touches may do.
                Err(PlanError::NoSoundLayout { .. } | PlanError::NoLayout) => {}
                Err(error) => return Err(error),
            }
            total = next;
        }
        Err(PlanError::NotMet { touches, reached, target })
    }

    fn of_total(&self, scene: Scene<'_>, total: usize) -> Result<Plan, PlanError> {
        let starts = self.starts(&scene, total)?;
        let enough = |counts: &[usize]| self.missing(counts).is_none() && self.fixture.can_search(counts);
        self.best(scene, &starts, &Counts::Where(&enough))
    }

    /// Counts to start from: what the fixture needs, and the rest dealt out over the surfaces that are reached.
    fn starts(&self, scene: &Scene<'_>, total: usize) -> Result<Vec<Vec<usize>>, PlanError> {
        let surfaces = self.reach.surfaces().len();
        let reached = |surface: usize| scene.candidates.iter().any(|site| site.surface == surface);
        let reached: Vec<bool> = (0..surfaces).map(reached).collect();
        let requirement = self.fixture.requirement();
        let (mut fitting, mut within) = (Vec::new(), Vec::new());
        for need in &requirement.alternatives {
            if need.iter().zip(&reached).all(|(need, reached)| *need == 0 || *reached) {
                within.push(need);
                if need.iter().sum::<usize>() <= total {
                    fitting.push(need);
                }
            }
        }
        if within.is_empty() {
            self.unreached(scene, |_| true)?;
        }
        if fitting.is_empty() || total < requirement.total || total == 0 {
            let least = within.iter().map(|need| need.iter().sum::<usize>()).min().unwrap_or(0);
            let missing =
                format!("{total} are asked for, the fixture needs {}", least.max(requirement.total).max(1));
            return Err(PlanError::TooFewTouches { missing });
        }
        let dealt = |start: usize| {
            // Alternatives are sorted by kind: a step through them takes different ones.
            let mut counts = fitting[start * fitting.len() / STARTS].clone();
            let spare = total - counts.iter().sum::<usize>();
            let mut next = (0..surfaces).cycle().skip(start % surfaces).filter(|surface| reached[*surface]);
            for surface in next.by_ref().take(spare) {
                counts[surface] += 1;
            }
            counts
        };
        Ok((0..STARTS).map(dealt).collect())
    }

    fn counts(&self, layout: &Layout) -> Vec<usize> {
        touches_per_surface(self.fixture.surfaces().len(), layout.iter().map(|(surface, _)| *surface))
    }

    fn missing(&self, counts: &[usize]) -> Option<String> {
        self.fixture.requirement().missing(counts, self.fixture.surfaces())
    }

    fn require(&self, counts: &[usize]) -> Result<(), PlanError> {
        self.missing(counts).map_or(Ok(()), |missing| Err(PlanError::TooFewTouches { missing }))
    }

    /// Refuses when a surface that is wanted has no place within reach.
    fn unreached(&self, scene: &Scene<'_>, wanted: impl Fn(usize) -> bool) -> Result<(), PlanError> {
        let reached = |surface: usize| scene.candidates.iter().any(|site| site.surface == surface);
        let mut surfaces = self.reach.surfaces().iter().enumerate();
        let unreached = surfaces.find(|(index, _)| wanted(*index) && !reached(*index));
        unreached.map_or(Ok(()), |(_, surface)| Err(PlanError::Unreachable { surface: surface.name.clone() }))
    }

    /// The best of the searches from these counts that is sound.
    fn best(&self, scene: Scene<'_>, starts: &[Vec<usize>], counts: &Counts<'_>) -> Result<Plan, PlanError> {
        let touches: usize = starts[0].iter().sum();
        let drawn =
            starts.par_iter().enumerate().filter_map(|(number, counts)| scene.start(counts, number as u64));
        let naive = self.naive(&starts[0]).and_then(|layout| scene.near(&layout));
        let starts: Vec<Design> = drawn.chain(naive).collect();
        let mut designs = optima(&scene, starts.clone(), counts);
        if designs.is_empty() {
            return Err(PlanError::NoLayout);
        }
        // Redundancy numbers add up to the touches less the unknowns at most.
        let spare = touches as f64 - scene.problem.unknowns() as f64;
        let asked = self.least_redundancy > 0.0;
        let mut possible = asked && self.least_redundancy * touches as f64 <= spare;
        if possible {
            let checked =
                self.checked(scene, [&starts, &designs[..designs.len().min(FOLLOWED)]].concat(), counts);
            possible = !checked.is_empty();
            if possible {
                designs = checked;
            }
        }
        let mut refusal = None;
        let mut tried = 0;
        let optimal = designs.iter().map(contacts_of);
        // What is drawn touches as the best of the optima does.
        let counts = || self.counts(&contacts_of(&designs[0]));
        let others = std::iter::once_with(|| self.second_choices(&counts(), possible));
        for layout in optimal.chain(others.flatten()) {
            match self.judged(layout, possible || !asked) {
                Ok(plan) => return Ok(plan),
                Err(PlanError::NoSoundLayout { refusal: why, .. }) => {
                    refusal.get_or_insert(why);
                    tried += 1;
                }
                Err(error) => return Err(error),
            }
        }
        refusal.map_or(Err(PlanError::NoLayout), |refusal| Err(PlanError::NoSoundLayout { tried, refusal }))
    }

    /// Designs in which the others check every touch as far as asked; none where the search finds none.
    fn checked(&self, scene: Scene<'_>, starts: Vec<Design>, counts: &Counts<'_>) -> Vec<Design> {
        let least = self.least_redundancy;
        let (mut scene, mut found) = (scene, starts);
        for weight in CHECK_WEIGHTS {
            scene = scene.with_checks(Checks { least, weight });
            let again = found.into_iter().filter_map(|design| scene.design(design.sites));
            found = optima(&scene, again.collect(), counts);
            found.truncate(FOLLOWED);
        }
        found.retain(|design| scene.least_redundancy(design) >= least - REDUNDANCY_ROUNDING);
        found
    }

    /// Layouts to take where no optimum is sound, best first: random ones, and the naive one.
    fn second_choices(&self, counts: &[usize], checked: bool) -> Vec<Layout> {
        let drawn =
            (0..RANDOM_LAYOUTS).filter_map(|number| self.random(counts, number)).chain(self.naive(counts));
        let rated = drawn.filter_map(|layout| {
            let linear = self.linear(&layout)?;
            let least = linear.redundancy().diagonal().rows(0, layout.len()).min();
            let sound = !checked || least >= self.least_redundancy - REDUNDANCY_ROUNDING;
            sound.then(|| (self.worst_at(&linear), layout))
        });
        let mut rated: Vec<(f64, Layout)> = rated.collect();
        rated.sort_by(|a, b| a.0.total_cmp(&b.0));
        rated.truncate(SECOND_CHOICES);
        rated.into_iter().map(|(_, layout)| layout).collect()
    }

    /// The plan of a layout, if the solver accepts its frame.
    fn judged(&self, layout: Layout, redundancy_possible: bool) -> Result<Plan, PlanError> {
        let touches = self.touches(&layout);
        let problem = Problem::new(self.fixture, &touches, self.probe)?;
        let refused = |refusal: SolveError| PlanError::NoSoundLayout { tried: 1, refusal: Box::new(refusal) };
        let (solution, approach_needed) = match self.solver.solve(&problem) {
            Ok(solution) => (solution, false),
            // That the probe came from outside may be what rules the others out.
            Err(refusal) => {
                let surfaces = self.fixture.surfaces();
                let inward = |touch: &Touch| surfaces[touch.surface].approach(&touch.at).into_inner();
                let told: Vec<Touch> =
                    touches.iter().map(|touch| touch.with_approach(inward(touch))).collect();
                let told = Problem::new(self.fixture, &told, self.probe)?;
                (self.solver.solve(&told).map_err(|_| refused(refusal))?, true)
            }
        };
        let linear = Linear::at(&problem, &Frame::identity()).ok_or(PlanError::NoLayout)?;
        let counts = self.counts(&layout);
        Ok(Plan {
            uncertainties: worst_case(&linear.covariance(), &Frame::identity(), &self.points),
            redundancy: (0..layout.len()).map(|index| linear.redundancy()[(index, index)]).collect(),
            redundancy_possible,
            approach_needed,
            trust: solution.trust,
            naive: self.naive(&counts).and_then(|layout| self.worst_of(&layout)),
            random_median: self.random_median(&counts),
            layout,
        })
    }

    /// Touches at contact points, in fixture coordinates.
    #[must_use]
    pub fn touches(&self, layout: &[(usize, Point3<f64>)]) -> Vec<Touch> {
        let surfaces = self.fixture.surfaces();
        let touch = |(surface, at): &(usize, Point3<f64>)| {
            Touch::new(*surface, surfaces[*surface].tip_center(at, self.probe.tip_radius))
        };
        layout.iter().map(touch).collect()
    }

    /// Worst-case standard uncertainty of a layout at the points of use; `None` where it leaves a motion free.
    #[must_use]
    pub fn worst_of(&self, layout: &[(usize, Point3<f64>)]) -> Option<f64> {
        self.linear(layout).map(|linear| self.worst_at(&linear))
    }

    /// A layout to first order.
    fn linear(&self, layout: &[(usize, Point3<f64>)]) -> Option<Linear> {
        let touches = self.touches(layout);
        let problem = Problem::new(self.fixture, &touches, self.probe).ok()?;
        Linear::at(&problem, &Frame::identity())
    }

    fn worst_at(&self, linear: &Linear) -> f64 {
        worst_case(&linear.covariance(), linear.frame(), &self.points).into_iter().fold(0.0, f64::max)
    }

    /// What one would touch without a plan: the fixture's own layout where it has these counts, else points spread evenly
    /// over each surface (a Fibonacci lattice). `None` where the probe does not reach so many.
    #[must_use]
    pub fn naive(&self, counts: &[usize]) -> Option<Layout> {
        let own = self.fixture.nominal_layout();
        let has = |surface: usize| own.iter().filter(|(of, _)| *of == surface).count();
        let reached = |(surface, at): &(usize, Point3<f64>)| self.reach.holds(*surface, at);
        if counts.iter().enumerate().all(|(surface, count)| has(surface) == *count) && own.iter().all(reached)
        {
            return Some(own);
        }
        let mut layout = Layout::new();
        for (surface, &count) in counts.iter().enumerate() {
            // Of more points than are wanted, as a cone leaves only some.
            let lattice = |points: usize| {
                let at = (0..points).filter_map(|k| self.reach.site(surface, lattice_point(k, points)));
                at.map(|site| (surface, site.at)).collect::<Layout>()
            };
            let found = (count..=count.saturating_mul(RANDOM_DRAWS)).step_by(count.max(1)).map(lattice);
            let found = found.take_while(|_| count > 0).find(|found| found.len() >= count);
            layout.extend(if count == 0 { Layout::new() } else { found?.into_iter().take(count).collect() });
        }
        Some(layout)
    }

    /// The touch of this number on a surface, of touches spread evenly.
    #[must_use]
    pub fn spread(&self, surface: usize, number: usize) -> Point3<f64> {
        /// As many as anyone makes.
        const MANY: usize = 8;
        let [u, v] = lattice_point(number, MANY.max(number + 1));
        self.reach.surfaces()[surface].point_at(u, v)
    }

    /// Median worst-case standard uncertainty of random layouts, uniform in area over what is reached.
    fn random_median(&self, counts: &[usize]) -> Option<f64> {
        let mut worst: Vec<f64> = (0..RANDOM_LAYOUTS)
            .into_par_iter()
            .map(|number| {
                let layout = self.random(counts, number);
                layout.and_then(|layout| self.worst_of(&layout)).unwrap_or(f64::INFINITY)
            })
            .collect();
        worst.sort_by(f64::total_cmp);
        Some(worst[worst.len() / 2]).filter(|median| median.is_finite())
    }

    fn random(&self, counts: &[usize], number: u64) -> Option<Layout> {
        let mut rng = generator(0, number);
        let mut layout = Layout::new();
        for (surface, &count) in counts.iter().enumerate() {
            for _ in 0..count {
                let site =
                    (0..RANDOM_DRAWS).find_map(|_| self.reach.site(surface, [rng.random(), rng.random()]))?;
                layout.push((surface, site.at));
            }
        }
        Some(layout)
    }
}

/// A point of a lattice of so many that is uniform in the unit square.
fn lattice_point(index: usize, points: usize) -> [f64; 2] {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    [(index as f64 * GOLDEN).fract(), (index as f64 + 0.5) / points as f64]
}

/// Contact points of a design, in an order that does not tell where the search began.
fn contacts_of(design: &Design) -> Layout {
    let mut sites = design.sites.clone();
    let place = |site: &Site| (site.surface, [site.uv[1], site.uv[0]]);
    sites.sort_by(|a, b| place(a).partial_cmp(&place(b)).unwrap_or(Ordering::Equal));
    sites.into_iter().map(|site| (site.surface, site.at)).collect()
}

/// Where searches from these designs end: best first, each once.
fn optima(scene: &Scene<'_>, starts: Vec<Design>, counts: &Counts<'_>) -> Vec<Design> {
    let ends = starts.into_par_iter().map(|start| scene.polish(scene.exchange(start, counts)));
    let mut found: Vec<Design> = ends.collect();
    found.sort_by(|a, b| a.score.total_cmp(&b.score));
    // Logarithms: a difference is a part.
    found.dedup_by(|a, b| {
        (a.score - b.score).abs() <= SAME && scene.counts(&a.sites) == scene.counts(&b.sites)
    });
    found
}
