//! The one touch that helps a measurement most.

use nalgebra::Point3;
use touchref_core::{Frame, Problem, RANK_TOLERANCE, RootReport, SolveError, Touch};

use super::{
    PlanError, Planner, Reach,
    reach::Site,
    search::{Counts, Design, Scene},
};
use crate::simulation::turned;

/// How far from where it is expected the frame is taken to be before any touch, in sizes of the fixture, and turned, in
/// radians: so far that any touch tells more.
const PRIOR: [f64; 2] = [100.0, 10.0];
/// Steps of Newton's method from where a touch is expected to where it would be.
const NEWTON_STEPS: usize = 20;
/// A touch that meets a surface more grazing than this (cosine against the normal) may slide off.
const GRAZING: f64 = 0.2;
/// First and last step of moving the touch that separates frames, in parts of the extent.
const STEPS: [f64; 2] = [1.0 / 32.0, 1e-4];
/// Starts of the search for touches that complete a layout: fewer than for a plan, as most of it is there.
const STARTS: u64 = 4;

/// A touch to make next, in fixture coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Next {
    /// Index of the surface.
    pub surface: usize,
    /// The contact point.
    pub contact: Point3<f64>,
    /// What it does.
    pub effect: Effect,
}

/// What a further touch does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effect {
    /// It tells frames apart that all fit.
    Separates {
        /// The least difference of its readings between any two of the frames, in standard deviations of that difference:
        /// of the touch, and of what the other touches foretell of it. In lengths where no sigma is stated.
        sigmas: f64,
    },
    /// It makes the worst case at the points of use smaller.
    Reduces {
        /// Standard uncertainty before.
        from: f64,
        /// Standard uncertainty with it.
        to: f64,
    },
    /// It takes part in fixing what is still free.
    Fixes,
}

impl Planner<'_> {
    /// The touch that makes the worst case at the points of use smallest, beside `touches` (parent) of a fixture that
    /// stands at `frame`.
    ///
    /// # Errors
    /// [`PlanError::NoLayout`] where the touches leave a motion free, or nothing more is in reach.
    pub fn next(&self, touches: &[Touch], frame: &Frame) -> Result<Next, PlanError> {
        let made = along_fixture(touches, frame);
        let problem = Problem::new(self.fixture, &made, self.probe)?;
        let scene = Scene::new(problem, &self.reach, &self.points, self.criterion, true);
        let before = scene.design(Vec::new()).ok_or(PlanError::NoLayout)?;
        let after = scene.extended(&before, &|_| true).ok_or(PlanError::NoLayout)?;
        let after = scene.polish(after);
        let site = after.sites[0];
        let worst = |design: &Design| scene.worst(design);
        let effect = Effect::Reduces { from: worst(&before), to: worst(&after) };
        Ok(Next { surface: site.surface, contact: site.at, effect })
    }

    /// The touch to make next of the best layout that completes `touches` (parent), which may leave motions free, to these
    /// counts: the one that tells most beside what is there. `frame` is where the fixture is expected.
    ///
    /// # Errors
    /// [`PlanError::NoLayout`] where nothing is left to touch, or nothing in reach.
    pub fn next_toward(&self, counts: &[usize], touches: &[Touch], frame: &Frame) -> Result<Next, PlanError> {
        let made = along_fixture(touches, frame);
        let anywhere = self.touches(&self.fixture.nominal_layout());
        let known = !made.is_empty();
        let problem = Problem::new(self.fixture, if known { &made } else { &anywhere }, self.probe)?;
        let [slide, turn] = PRIOR;
        let scene = Scene::new(problem, &self.reach, &self.points, self.criterion, known)
            .with_prior(slide * self.fixture.size(), turn);
        let have = scene.counts(&[]);
        let lacking: Vec<usize> =
            counts.iter().zip(&have).map(|(wanted, have)| wanted.saturating_sub(*have)).collect();
        let completions = (0..STARTS).filter_map(|number| scene.start(&lacking, number));
        let completions = completions.map(|start| scene.polish(scene.exchange(start, &Counts::Kept)));
        let best = completions.min_by(|a, b| a.score.total_cmp(&b.score));
        let sites = best.ok_or(PlanError::NoLayout)?.sites;
        let one_more = sites.into_iter().filter_map(|site| scene.design(vec![site]));
        let first = one_more.min_by(|a, b| b.information().total_cmp(&a.information()));
        let site = first.ok_or(PlanError::NoLayout)?.sites[0];
        Ok(Next { surface: site.surface, contact: site.at, effect: Effect::Fixes })
    }

    /// The frames that survive a refusal of `problem`: those that the solver accepts when they are expected, and where it
    /// accepts fewer than two, the best root and the second minimum.
    #[must_use]
    pub fn surviving(&self, problem: &Problem<'_>, error: &SolveError) -> Vec<Frame> {
        /// Frames nearer than this, in parts of the fixture's size and radians, are one.
        const SAME: f64 = 1e-6;
        /// A root farther than this from the second minimum leads to another one.
        const APART: f64 = 0.05;
        let Some(refusal) = error.refusal() else { return Vec::new() };
        let second = refusal.trust.second_minimum.map(|second| second.frame);
        let distinct = |all: &mut dyn Iterator<Item = Frame>| {
            let mut frames: Vec<Frame> = Vec::new();
            for frame in all {
                let known = |other: &Frame| other.twist_to(&frame).extent(self.fixture.size()) < SAME;
                if !frames.iter().any(known) {
                    frames.push(frame);
                }
            }
            frames
        };
        let starts = refusal.roots.iter().map(|root| root.frame).chain(second);
        let accepted =
            distinct(&mut starts.filter_map(|near| Some(self.solver.solve(&problem.near(near)).ok()?.frame)));
        if accepted.len() > 1 {
            return accepted;
        }
        // Roots may crowd about one minimum: of them the best that is not the second minimum.
        let Some(second) = second else { return accepted };
        let other = |root: &&RootReport| root.frame.twist_to(&second).extent(self.fixture.size()) > APART;
        let best = refusal.roots.iter().find(other).map(|root| root.frame);
        best.into_iter().chain([second]).collect()
    }

    /// The touch whose readings differ most between `frames` that all fit `touches` (parent): the least difference
    /// between any two counts. The touch is told as the first of the frames has it.
    ///
    /// # Errors
    /// [`PlanError::NoLayout`] where there are fewer than two frames, or no touch in reach meets the fixture in each of them.
    pub fn next_apart(&self, touches: &[Touch], frames: &[Frame]) -> Result<Next, PlanError> {
        let made: Vec<Vec<Touch>> = frames.iter().map(|frame| along_fixture(touches, frame)).collect();
        let mut views = Vec::new();
        for (frame, made) in frames.iter().zip(&made) {
            let problem = Problem::new(self.fixture, made, self.probe)?;
            let [slide, turn] = PRIOR;
            let scene = Scene::new(problem, &self.reach, &self.points, self.criterion, true)
                .with_prior(slide * self.fixture.size(), turn);
            let design = scene.design(Vec::new()).ok_or(PlanError::NoLayout)?;
            views.push(View { frame, scene, design });
        }
        let Some((first, _)) = views.split_first().filter(|(_, others)| !others.is_empty()) else {
            return Err(PlanError::NoLayout);
        };
        let apart = |site: &Site, strict: bool| apart(&views, &self.reach, site, strict);
        let best_of = |strict: bool| {
            let rated = first.scene.candidates.iter().filter_map(|site| Some((apart(site, strict)?, *site)));
            rated.max_by(|a, b| a.0.total_cmp(&b.0))
        };
        // A touch that every frame would meet within the surface's extent, if there is one.
        let strict = best_of(true).is_some();
        let (mut sigmas, mut site) = best_of(strict).ok_or(PlanError::NoLayout)?;
        let mut step = STEPS[0];
        while step > STEPS[1] {
            let around = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
            let around = around.map(|[du, dv]| [site.uv[0] + du * step, site.uv[1] + dv * step]);
            let near = around.into_iter().filter_map(|uv| self.reach.site(site.surface, uv));
            let rated = near.filter_map(|near| Some((apart(&near, strict)?, near)));
            match rated.max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((better, near)) if better > sigmas => (sigmas, site) = (better, near),
                _ => step *= 0.5,
            }
        }
        Ok(Next { surface: site.surface, contact: site.at, effect: Effect::Separates { sigmas } })
    }
}

/// A measurement as one frame has it.
struct View<'a> {
    frame: &'a Frame,
    scene: Scene<'a>,
    design: Design,
}

/// Touches as the fixture sees them from `frame`.
fn along_fixture(touches: &[Touch], frame: &Frame) -> Vec<Touch> {
    let to_fixture = frame.rotation.inverse();
    touches.iter().map(|touch| turned(touch, frame.to_fixture(&touch.at), &to_fixture)).collect()
}

/// The least difference between what any two frames foretell of a touch, in standard deviations; `None` where one of them
/// does not meet it: within its extent, if that is asked.
fn apart(views: &[View<'_>], reach: &Reach, site: &Site, strict: bool) -> Option<f64> {
    let first = &views[0];
    let planned = first.scene.touch(site.surface, &site.at);
    let surface = &first.scene.problem.fixture().surfaces()[site.surface];
    let start = first.frame.to_parent(&planned.at);
    let way = first.frame.rotation * surface.approach(&site.at).into_inner();
    let tip_radius = first.scene.problem.probe().tip_radius;
    // How far each frame lets the probe go, how steep it meets the surface, and how sure that is.
    let mut met: Vec<(f64, f64, f64)> = Vec::with_capacity(views.len());
    for view in views {
        let mut gone = 0.0;
        let mut settled = None;
        for _ in 0..NEWTON_STEPS {
            let tip = view.frame.to_fixture(&(start + way * gone));
            let seen = surface.seen_from(&tip);
            let steep = -seen.normal.dot(&(view.frame.rotation.inverse() * way));
            if steep < GRAZING {
                return None;
            }
            let step = (seen.distance - tip_radius) / steep;
            gone += step;
            if step.abs() <= RANK_TOLERANCE * first.scene.problem.fixture().size() {
                settled = Some((tip - seen.normal * seen.distance, steep));
                break;
            }
        }
        let (contact, steep) = settled?;
        if strict && !reach.holds(site.surface, &contact) {
            return None;
        }
        met.push((gone, steep, view.scene.unsure(&view.design, site.surface, &contact)));
    }
    let mut least = f64::INFINITY;
    for (k, (gone, steep, unsure)) in met.iter().enumerate() {
        for (other_gone, other_steep, other_unsure) in &met[..k] {
            let length = (gone - other_gone).abs() * steep.min(*other_steep);
            least = least.min(length / unsure.max(*other_unsure));
        }
    }
    Some(least)
}
