//! When may a frame be accepted? The crate's documentation tells the rule.
//!
//! All conditions scale with the noise. Instead of testing them at the stated noise, [`Judgement`] finds the factor of
//! the problem's sigmas at which each gives way: the frame stands between [`Bounds::from`] and the least of the
//! others. The same bounds decide at a stated noise (factor one) and answer conditionally where none is stated.

use std::cmp::Ordering;

use nalgebra::{Matrix6, Vector6};
use touchref_core::{
    ClosedForm, Covariance, Fixture, Frame, Freedom, Limit, MinimumReport, Observability, ParameterKind,
    ParameterSpec, Parameters, Problem, Refusal, Residual, RootReport, Rule, SearchReport, SecondMinimum,
    SigmaSource, Solution, SolveError, Touch, Trust, Twist, Warning,
    error::Degenerate,
    observability::weakest_motion,
    statistics::{Level, chi_square_p_value},
};

use crate::{
    cover::Cover,
    levenberg_marquardt::{Descent, STEPS, descend_unless, settle},
    model::{Model, Normal, SquareRoot, Unknowns, uncertain, with_unknowns},
    words::short,
};

/// Chance at which a true frame is called inconsistent.
pub(crate) static INCONSISTENT: Level = Level::new(1e-3);
/// Chance that the true frame lies in a minimum above the level at which a second one counts as ambiguous.
pub(crate) static AMBIGUOUS: Level = Level::new(1e-6);
/// Relative curvature from which first-order uncertainty is not trusted. At 0.3 a true error beyond the 1e-9 level
/// needs a noise draw of 5.3 standard deviations along the worst direction.
const CURVATURE: f64 = 0.3;
/// The 1e-9 level of six degrees of freedom, in standard deviations: how far the quadratic model must hold.
pub(crate) const REACH: f64 = 7.3;
/// The misfit's rise there, as a part of the predicted one.
const RISE: [f64; 2] = [0.55, 3.0];
/// Minima nearer than this (standard deviations) are one.
const SAME: f64 = 0.01;
/// Minima nearer than this part of the fixture's size are one, whatever the noise: ends of descents.
pub(crate) const SAME_PLACE: f64 = 1e-7;
/// Sine of the angle by which an approach may point out of its surface: a grazing touch.
const APPROACH_SLACK: f64 = 0.087;
/// A motion whose standard deviation exceeds this part of the fixture's size (radians, for a turn) is as good as free.
pub(crate) const FREE: f64 = 0.05;
/// It is the layout's fault, not the noise's, when the condition exceeds this.
const WEAK: f64 = 100.0;
/// Touches nearer together than this part of the fixture's size may be in another unit, where nothing else tells.
const CLOSE: f64 = 0.1;
/// Degrees of freedom from which on a bad touch can be told, and the code of the warning where there are fewer.
const REDUNDANT: usize = 3;
const LOW_REDUNDANCY: &str = "low-redundancy";
/// An expected frame decides between two when it is this many times nearer to one.
const NEARER: f64 = 2.0;

/// How far beyond the stated noise other frames are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Margin {
    /// A tenth beyond the stated noise at least, and as far as the same search proves.
    #[default]
    Near,
    /// As far as the frame stands: many times the stated noise where the layout is good, and many times the work.
    Full,
}

/// Of the search for a near margin, in stated sigmas.
const NEAR: f64 = 1.1;
/// The farthest that a full margin reaches, in stated sigmas: noise that no probe of the stated sigma has.
const FULL: f64 = 1000.0;

/// The rule, for frames that are found many at once: other frames are looked for to the near margin.
pub(crate) fn rule() -> Rule {
    Rule {
        noise: NEAR,
        consistent: |degrees_of_freedom| INCONSISTENT.value(degrees_of_freedom),
        curvature: CURVATURE,
        reach: REACH,
        rise: 1.0 - RISE[0],
        warnings: |degrees_of_freedom| {
            if degrees_of_freedom < REDUNDANT { &[LOW_REDUNDANCY] } else { &[] }
        },
    }
}

impl Margin {
    /// The parameter that both solvers have.
    pub(crate) const SPEC: ParameterSpec = ParameterSpec {
        name: "margin",
        kind: ParameterKind::Choice(&["near", "full"]),
        default: Some("near"),
        meaning: "how far beyond the stated sigma other frames are looked for: near (a tenth, or farther where that \
                  is cheap to prove) or full (as far as the frame stands)",
    };

    /// From parameters that are checked.
    pub(crate) fn of(parameters: &Parameters) -> Self {
        if parameters.word(Self::SPEC.name) == "full" { Self::Full } else { Self::Near }
    }
}

/// A local minimum of the squared misfit.
#[derive(Debug, Clone)]
pub(crate) struct Minimum {
    pub(crate) state: Unknowns,
    /// Where the descent began that led to it.
    start: Frame,
    /// Steps of that descent.
    pub(crate) steps: usize,
    pub(crate) chi_square: f64,
    /// Square root of the frame's information, over its twist along the fixture's axes.
    pub(crate) information: Matrix6<f64>,
    /// Why it cannot be the frame, however well it fits, if something speaks against it.
    pub(crate) objection: Option<String>,
}

impl Minimum {
    /// Distance of a frame in standard deviations.
    pub(crate) fn mahalanobis(&self, frame: &Frame) -> f64 {
        (self.information * Vector6::from(self.state.frame.twist_to(frame))).norm()
    }

    /// The same, and the frame's distance as a part of the fixture's size.
    fn distances(&self, frame: &Frame, size: f64) -> (f64, f64) {
        let twist = self.state.frame.twist_to(frame);
        let whitened = self.information * Vector6::from(twist);
        (whitened.norm(), twist.extent(size))
    }

    /// Whether a frame of this squared misfit is sure to descend to this minimum: it is within one standard deviation
    /// in misfit and in Mahalanobis distance, at `noise` times the problem's sigmas.
    fn is_basin_of(&self, frame: &Frame, chi_square: f64, size: f64, noise: f64) -> bool {
        (chi_square - self.chi_square).abs() < noise * noise && self.distances(frame, size).0 < noise
    }

    /// Whether a frame is this minimum, at `noise` times the problem's sigmas.
    pub(crate) fn is_at(&self, frame: &Frame, size: f64, noise: f64) -> bool {
        let (mahalanobis, place) = self.distances(frame, size);
        mahalanobis < SAME * noise || place < SAME_PLACE
    }
}

/// More minima than any sound layout has: hundreds lie along a motion that the touches leave free. Those of layouts that
/// are sound were never seen to be a tenth as many.
const MOST_MINIMA: usize = 512;

/// Where minima are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Search {
    /// Where the fixture says that there may be some, as far as it has a closed form; else everywhere.
    Fixture,
    /// Everywhere, whatever the fixture knows.
    Everywhere,
}

impl Search {
    /// The closed form that leads the search, if one does.
    pub(crate) fn by<'a>(self, problem: &Problem<'a>) -> Option<&'a dyn ClosedForm> {
        problem.fixture().closed_form().filter(|_| self == Self::Fixture)
    }
}

/// Every minimum found, lowest first, and the noise up to which the search claims to be complete.
struct Survey<const P: usize> {
    minima: Vec<(Minimum, SquareRoot<P>)>,
    /// Frames from which it descended.
    starts: usize,
    complete_up_to: f64,
}

/// Descends from every candidate that the fixture knows at `noise` times the problem's sigmas, or from everywhere.
fn survey<const P: usize>(
    model: &Model<'_, P>,
    closed_form: Option<&dyn ClosedForm>,
    noise: f64,
) -> Result<Survey<P>, SolveError> {
    let problem = model.problem;
    // A search far beyond the noise tells minima apart no worse.
    let mut minima = Minima {
        model,
        standing: Standing::of(problem),
        apart: noise.min(1.0),
        found: Vec::new(),
        starts: 0,
    };
    if let Some(near) = problem.expected_near() {
        minima.visit(near);
    }
    let complete_up_to = if let Some(closed_form) = closed_form {
        closed_form.candidates(problem, noise, &mut |start| minima.visit(&start))?
    } else {
        minima.visit_everything();
        f64::INFINITY
    };
    let Minima { found: mut minima, starts, .. } = minima;
    // What was not looked for was not excluded: then no frame stands.
    let complete_up_to = if minima.len() < MOST_MINIMA { complete_up_to } else { 0.0 };
    minima.sort_by(|(a, _), (b, _)| a.chi_square.total_cmp(&b.chi_square));
    Ok(Survey { minima, starts, complete_up_to })
}

/// Ends of descents where no minimum is near.
struct Unsettled<const P: usize> {
    count: usize,
    /// The one that fits best, and where its descent began.
    lowest: Option<(Frame, Descent<Normal<P>>)>,
}

/// Minima as they are found.
struct Minima<'a, 'p, const P: usize> {
    model: &'a Model<'p, P>,
    standing: Standing,
    /// In which noise, in the problem's sigmas, they are told apart.
    apart: f64,
    found: Vec<(Minimum, SquareRoot<P>)>,
    /// Descents begun.
    starts: usize,
}

impl<const P: usize> Minima<'_, '_, P> {
    /// Descends from a start, and keeps the minimum if it is new.
    fn visit(&mut self, start: &Frame) {
        if self.found.len() >= MOST_MINIMA {
            return;
        }
        self.starts += 1;
        let Some(descent) = self.descend(start, |_| self.apart) else { return };
        if descent.chi_square().is_finite() && !self.knows(&descent.at, |_| self.apart) {
            self.keep(start, descent.at, descent.chi_square(), descent.steps);
        }
    }

    /// Descends from a cover of all frames, ever denser until it finds nothing new, and from around each minimum: of those
    /// that lie side by side one may have a basin too small for the cover.
    fn visit_everything(&mut self) {
        let cover = Cover::of(self.model.problem);
        let mut unsettled = Unsettled { count: 0, lowest: None };
        let mut explored = 0;
        for starts in Cover::rounds() {
            let before = self.found.len();
            for start in cover.starts(starts) {
                self.visit_far(&start, &mut unsettled);
            }
            while let Some((minimum, _)) = self.found.get(explored) {
                for start in self.around(minimum) {
                    self.visit_far(&start, &mut unsettled);
                }
                explored += 1;
            }
            if self.found.len() == before {
                break;
            }
        }
        // One that has run out of steps may only crawl where nothing fits.
        let fits_best = |lowest: &Descent<Normal<P>>| {
            self.found.iter().all(|(minimum, _)| lowest.chi_square() < minimum.chi_square)
        };
        if let Some((start, lowest)) =
            unsettled.lowest.filter(|(_, lowest)| lowest.steps < STEPS || fits_best(lowest))
        {
            self.keep(&start, lowest.at, lowest.chi_square(), lowest.steps);
        }
    }

    /// Descends from a start that knows nothing of where a minimum is, and keeps that if it is new.
    ///
    /// Most minima from there fit so badly that residuals bend the misfit more than the Jacobian tells, and a descent ends
    /// in one only to a part of its misfit: Newton's method settles it.
    fn visit_far(&mut self, start: &Frame, unsettled: &mut Unsettled<P>) {
        /// In parts of its misfit: how near a minimum gives up a descent, and how near are ends of descents to the same.
        const BASIN: f64 = 0.1;
        const END: f64 = 1.0;
        /// Ends that do not settle: of more, those as low as the lowest are taken to lie in one valley.
        const MANY: usize = 6;
        self.starts += 1;
        let apart = self.apart;
        let within = |part: f64| move |minimum: &Minimum| apart.max(part * minimum.chi_square.sqrt());
        let Some(descent) = self.descend(start, within(BASIN)) else { return };
        let chi_square = descent.chi_square();
        if !chi_square.is_finite() {
            return;
        }
        // In squared misfit; where no sigma is stated, that is a length squared.
        let as_low = apart.max(SAME_PLACE * self.model.problem.fixture().size()).powi(2);
        let in_valley = unsettled.count > MANY
            && unsettled.lowest.is_some_and(|(_, lowest)| (chi_square - lowest.chi_square()).abs() < as_low);
        if in_valley || self.knows(&descent.at, within(END)) {
            return;
        }
        match settle(self.model, descent.at) {
            Some(at) if !self.knows(&at, |_| apart) => {
                self.keep(start, at, self.model.chi_square(&at), descent.steps);
            }
            // A motion is free there; of a valley's many ends the lowest tells enough.
            None => {
                unsettled.count += 1;
                if unsettled.lowest.is_none_or(|(_, lowest)| chi_square < lowest.chi_square()) {
                    unsettled.lowest = Some((*start, descent));
                }
            }
            _ => {}
        }
    }

    /// Frames around a minimum, along the motions that it sees least to most, as far as others may lie beside it.
    fn around(&self, minimum: &Minimum) -> Vec<Frame> {
        /// Parts of the fixture's size, radians.
        const FAR: [f64; 4] = [0.15, 0.3, 0.6, 1.2];
        let size = self.model.problem.fixture().size();
        let scales = Vector6::from_fn(|i, _| if i < 3 { size } else { 1.0 });
        let scaled = minimum.information * Matrix6::from_diagonal(&scales);
        if !scaled.iter().all(|v| v.is_finite()) {
            return Vec::new();
        }
        let motions = (scaled.transpose() * scaled).symmetric_eigen().eigenvectors;
        let along = |motion: Vector6<f64>| {
            let steps = FAR.into_iter().flat_map(|far| [far, -far]);
            steps.map(move |far| Twist::from(motion.component_mul(&scales) * far))
        };
        let twists = motions.column_iter().flat_map(|motion| along(motion.into_owned()));
        twists.map(|twist| minimum.state.frame.moved(&twist)).collect()
    }

    /// Descends from a start, unless that leads into the basin of a known minimum: `within` so many of the problem's
    /// sigmas.
    fn descend(&self, start: &Frame, within: impl Fn(&Minimum) -> f64) -> Option<Descent<Normal<P>>> {
        let size = self.model.problem.fixture().size();
        let arrived = |state: &Unknowns, chi_square: f64| {
            let frame = self.standing.frame(state.frame);
            self.found.iter().any(|(m, _)| m.is_basin_of(&frame, chi_square, size, within(m)))
        };
        descend_unless(self.model, Unknowns::at(*start), arrived)
    }

    /// Whether this is a known minimum, told apart at so many of the problem's sigmas.
    fn knows(&self, at: &Unknowns, apart: impl Fn(&Minimum) -> f64) -> bool {
        let size = self.model.problem.fixture().size();
        let frame = self.standing.frame(at.frame);
        self.found.iter().any(|(m, _)| m.is_at(&frame, size, apart(m)))
    }

    fn keep(&mut self, start: &Frame, state: Unknowns, chi_square: f64, steps: usize) {
        let state = Unknowns { frame: self.standing.frame(state.frame), ..state };
        let root = self.model.square_root(&state);
        let objection = objection(self.model.problem, &state.frame);
        let minimum =
            Minimum { state, start: *start, steps, chi_square, information: root.of_frame(), objection };
        self.found.push((minimum, root));
    }
}

/// Where frames stand along the motions that the fixture leaves free: nearest the expected frame, else the parent's axes
/// at the middle of the touches.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Standing {
    free: Freedom,
    to: Frame,
}

impl Standing {
    pub(crate) fn of(problem: &Problem<'_>) -> Self {
        let expected = problem.expected_near().copied();
        let to = expected.unwrap_or_else(|| Frame::parallel_at(problem.centroid()));
        Self { free: problem.fixture().freedom(), to }
    }

    /// The frame, moved there.
    #[inline]
    pub(crate) fn frame(&self, frame: Frame) -> Frame {
        if self.free == Freedom::NONE { frame } else { self.free.nearest(&frame, &self.to) }
    }
}

/// What speaks against a frame: a touch whose approach comes out of the material, or the fixture's own objection.
pub(crate) fn objection(problem: &Problem<'_>, frame: &Frame) -> Option<String> {
    let touches = problem.touches().iter().enumerate();
    let mut wrong = touches.filter_map(|(index, touch)| {
        let approach = touch.approach?;
        let out = approach.dot(&(frame.rotation * problem.contact(frame, index).normal)) > APPROACH_SLACK;
        out.then(|| format!("the approach of touch {} would come out of its surface", problem.number(index)))
    });
    wrong.next().or_else(|| problem.fixture().objection(problem, frame))
}

/// Factors of the problem's sigmas at which each condition gives way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// Below this the touches contradict the fixture.
    pub(crate) from: f64,
    /// Above this a second frame fits.
    pub(crate) ambiguity: f64,
    /// Above this the relative curvature is too large.
    pub(crate) curvature: f64,
    /// Above this the misfit does not rise as predicted.
    pub(crate) rise: f64,
    /// Above this the search is not complete.
    pub(crate) search: f64,
}

impl Bounds {
    fn of(&mut self, limit: Limit) -> &mut f64 {
        match limit {
            Limit::Ambiguity => &mut self.ambiguity,
            Limit::Curvature => &mut self.curvature,
            Limit::Rise => &mut self.rise,
            _ => &mut self.search,
        }
    }

    /// The least upper bound, and what gives way there.
    pub(crate) fn up_to(&self) -> (f64, Limit) {
        let frame = self.of_frame();
        if self.search < frame.0 { (self.search, Limit::Search) } else { frame }
    }

    /// The same for the frame that was found, however far others were looked for.
    fn of_frame(&self) -> (f64, Limit) {
        let all = [
            (self.ambiguity, Limit::Ambiguity),
            (self.curvature, Limit::Curvature),
            (self.rise, Limit::Rise),
        ];
        let nothing = (f64::INFINITY, Limit::None);
        all.into_iter().fold(nothing, |least, next| if next.0 < least.0 { next } else { least })
    }
}

/// What is known of a problem once every minimum was weighed.
#[derive(Debug, Clone)]
pub(crate) struct Judgement {
    /// Every minimum, lowest first.
    pub(crate) minima: Vec<Minimum>,
    /// Frames from which they were looked for.
    starts: usize,
    /// Which one is the frame, if any stands.
    pub(crate) chosen: usize,
    /// The next best one that nothing speaks against.
    pub(crate) second: Option<usize>,
    /// Whether an expected frame decided.
    pub(crate) by_near: bool,
    pub(crate) bounds: Bounds,
    /// Relative curvature at the problem's own sigmas.
    pub(crate) curvature: f64,
    /// Standard deviation of the weakest motion at the problem's own sigmas, as a part of the fixture's size.
    weakest_sd: f64,
    pub(crate) observability: Observability,
}

/// Degrees of freedom: touches less the frame's unknowns. A prior adds an observation and an unknown.
pub(crate) fn degrees_of_freedom(problem: &Problem<'_>) -> usize {
    problem.touches().len().saturating_sub(problem.unknowns())
}

impl Judgement {
    /// Finds and weighs every minimum.
    ///
    /// # Errors
    /// [`SolveError::Degenerate`] where a motion is free at the best minimum, [`SolveError::InvalidTouches`] where the
    /// touches contradict the fixture.
    pub(crate) fn of<const P: usize>(
        model: &Model<'_, P>,
        search: Search,
        margin: Margin,
    ) -> Result<Self, SolveError> {
        /// Rounds in which the noise to search at settles where none is stated.
        const ROUNDS: usize = 4;
        let known = model.problem.reference_sigma().is_some();
        let Some(closed_form) = search.by(model.problem) else {
            // What does not look at the noise finds no more in a second search.
            return Self::at_noise(model, None, if known { 1.0 } else { 0.0 }, Margin::Full);
        };
        if known {
            if margin == Margin::Near {
                return Self::at_noise(model, Some(closed_form), NEAR, margin);
            }
            let judgement = Self::at_noise(model, Some(closed_form), 1.0, margin)?;
            let (bound, limit) = judgement.bounds.of_frame();
            let stands = judgement.bounds.from <= 1.0 && judgement.bounds.up_to().0 > 1.0;
            // The margin is a claim of its own: search where it ends, too.
            return if stands {
                judgement.searched_at(model, closed_form, bound.min(FULL), limit)
            } else {
                Ok(judgement)
            };
        }
        // The search for candidates depends on the noise, and the noise up to which the frame stands on the
        // candidates: from none upward, then down to where both agree.
        let mut judgement = Self::at_noise(model, Some(closed_form), 0.0, Margin::Full)?;
        for _ in 0..ROUNDS {
            let (bound, limit) = judgement.bounds.up_to();
            if !bound.is_finite() {
                break;
            }
            judgement = judgement.searched_at(model, closed_form, bound, limit)?;
            if judgement.bounds.up_to() == (bound, limit) {
                break;
            }
        }
        Ok(judgement)
    }

    /// The judgement after a search at the noise up to which it says that the frame stands: what was found only there
    /// counts, too.
    fn searched_at<const P: usize>(
        self,
        model: &Model<'_, P>,
        closed_form: &dyn ClosedForm,
        noise: f64,
        limit: Limit,
    ) -> Result<Self, SolveError> {
        let mut next = Self::at_noise(model, Some(closed_form), noise, Margin::Full)?;
        next.starts += self.starts;
        if next.bounds.of_frame().0 > self.bounds.of_frame().0 {
            // Nothing new: the bound found before stands, for its own reason.
            *next.bounds.of(limit) = self.bounds.of_frame().0;
        }
        Ok(next)
    }

    fn at_noise<const P: usize>(
        model: &Model<'_, P>,
        closed_form: Option<&dyn ClosedForm>,
        noise: f64,
        margin: Margin,
    ) -> Result<Self, SolveError> {
        let problem = model.problem;
        let Survey { minima, starts, complete_up_to } = survey(model, closed_form, noise)?;
        let (minima, roots): (Vec<Minimum>, Vec<SquareRoot<P>>) = minima.into_iter().unzip();
        let standing: Vec<usize> = (0..minima.len()).filter(|i| minima[*i].objection.is_none()).collect();
        // Where something speaks against every minimum, weigh them all the same: the refusal says why.
        let Some(&lowest) = standing.first().or((!minima.is_empty()).then_some(&0)) else {
            return Err(no_candidate());
        };
        let degrees = degrees_of_freedom(problem);
        let ambiguous = AMBIGUOUS.value(degrees);
        let (chosen, by_near) = choose(problem, &minima, &standing, lowest, ambiguous);
        let second = standing.iter().copied().find(|i| *i != chosen);

        let (best, root) = (&minima[chosen], &roots[chosen]);
        let frame = best.state.frame;
        let weakest = Weakest::of(&best.information, problem.fixture());
        let observability = Observability::from_singular_values(
            problem.fixture(),
            &frame,
            &weakest.singular_values,
            &weakest.twist,
        );
        let weakest_sd = 1.0 / (weakest.least() * problem.fixture().size());
        let curvature = model.curvature(&best.state, root);
        let at_level = |chi_square: f64, level: f64| (chi_square / level).sqrt();
        let from = if degrees == 0 { 0.0 } else { at_level(best.chi_square, INCONSISTENT.value(degrees)) };
        let ambiguity = match second {
            Some(second) if !by_near => at_level(minima[second].chi_square, ambiguous),
            _ => f64::INFINITY,
        };
        let mut bounds = Bounds {
            from,
            ambiguity,
            curvature: CURVATURE / curvature,
            rise: f64::INFINITY,
            search: complete_up_to,
        };
        let limit = if margin == Margin::Near { bounds.up_to() } else { bounds.of_frame() };
        bounds.rise = rise_bound(model, (&best.state, best.chi_square), root, &weakest, limit.0);
        Ok(Self { minima, starts, chosen, second, by_near, bounds, curvature, weakest_sd, observability })
    }

    /// The least squared misfit of a frame that nothing else speaks against.
    fn least(&self) -> f64 {
        let standing = self.minima.iter().find(|minimum| minimum.objection.is_none());
        standing.map_or(f64::INFINITY, |minimum| minimum.chi_square)
    }

    /// What the search did, to be told.
    fn search(&self) -> SearchReport {
        let told = |(index, minimum): (usize, &Minimum)| MinimumReport {
            frame: minimum.state.frame,
            chi_square: minimum.chi_square,
            start: minimum.start,
            steps: minimum.steps,
            selected: index == self.chosen,
            objection: minimum.objection.clone(),
        };
        SearchReport { starts: self.starts, minima: self.minima.iter().enumerate().map(told).collect() }
    }

    /// The minimum that is the frame, if any stands.
    pub(crate) fn best(&self) -> &Minimum {
        &self.minima[self.chosen]
    }
}

/// What touches say to a hypothesis: that just these are sound, and labelled right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Some frame fits them, at the level at which touches are consistent.
    Fits,
    /// The best is above that level, but not above the one at which a true hypothesis is hardly ever: once in a million.
    Doubtful,
    /// So few touches cannot tell, or no search for their frames is complete.
    Untested,
    /// No frame fits them.
    Excluded,
}

impl Verdict {
    /// Of these touches, by a search for all their frames. Where no sigma is stated nothing can be tested.
    pub(crate) fn of(problem: &Problem<'_>) -> Self {
        let degrees = degrees_of_freedom(problem);
        let known = problem.reference_sigma().is_some();
        if degrees == 0 || !known || !problem.fixture().can_search(&problem.counts()) {
            return Self::Untested;
        }
        let extras = uncertain(problem);
        let judgement = with_unknowns!(extras.len(), P => {
            Judgement::of(&Model::<P>::new(problem, &extras), Search::Fixture, Margin::Near)
        });
        match judgement {
            Ok(judgement) if judgement.least() <= INCONSISTENT.value(degrees) => Self::Fits,
            Ok(judgement) if judgement.bounds.search < 1.0 => Self::Untested,
            Ok(judgement) if judgement.least() <= AMBIGUOUS.value(degrees) => Self::Doubtful,
            Ok(_) | Err(SolveError::InvalidTouches { .. }) => Self::Excluded,
            Err(_) => Self::Untested,
        }
    }
}

/// The lowest minimum, or the one that an expected frame decides for among those that fit.
fn choose(
    problem: &Problem<'_>,
    minima: &[Minimum],
    standing: &[usize],
    lowest: usize,
    ambiguous: f64,
) -> (usize, bool) {
    let Some(near) = problem.expected_near() else { return (lowest, false) };
    let size = problem.fixture().size();
    // Where no sigma is stated, any minimum may fit at some noise.
    let known = problem.reference_sigma().is_some();
    let mut fitting: Vec<(f64, usize)> = standing
        .iter()
        .filter(|i| !known || minima[**i].chi_square < ambiguous)
        .map(|i| (minima[*i].distances(near, size).1, *i))
        .collect();
    fitting.sort_by(|a, b| a.0.total_cmp(&b.0));
    match fitting.as_slice() {
        [(nearest, index), (next, _), ..] if nearest * NEARER < *next => (*index, true),
        _ => (lowest, false),
    }
}

/// The first touch that is the same point of the same surface as one before it, after that one.
fn coincident(touches: &[Touch]) -> Option<(usize, usize)> {
    /// Of no more all pairs are soon compared, without memory.
    const FEW: usize = 64;
    let same =
        |i: &usize, j: &usize| touches[*i].surface == touches[*j].surface && touches[*i].at == touches[*j].at;
    if touches.len() <= FEW {
        return (0..touches.len()).find_map(|j| (0..j).find(|i| same(i, &j)).map(|i| (i, j)));
    }
    let compared = |a: &Touch, b: &Touch| {
        let axes = a.at.iter().zip(b.at.iter()).map(|(a, b)| a.partial_cmp(b).unwrap_or(Ordering::Equal));
        axes.fold(a.surface.cmp(&b.surface), Ordering::then)
    };
    let mut order: Vec<usize> = (0..touches.len()).collect();
    // Stable: of one point the first touch stays the first.
    order.sort_by(|a, b| compared(&touches[*a], &touches[*b]));
    let pairs = order.chunk_by(same).filter(|run| run.len() > 1);
    pairs.map(|run| (run[0], run[1])).min_by_key(|(_, later)| *later)
}

/// The motion that the touches see least at a frame.
pub(crate) struct Weakest {
    singular_values: Vector6<f64>,
    /// Of length one, rotations scaled by the fixture's size.
    twist: Twist,
}

impl Weakest {
    pub(crate) fn of(information: &Matrix6<f64>, fixture: &dyn Fixture) -> Self {
        let (singular_values, twist) = weakest_motion(information, fixture.size(), fixture.freedom());
        Self { singular_values, twist }
    }

    fn least(&self) -> f64 {
        self.singular_values.min()
    }
}

/// The noise factor up to which the misfit rises from a minimum along its weakest motion as the quadratic model
/// predicts, as far as `limit`; infinite when it does to the end.
pub(crate) fn rise_bound<const P: usize>(
    model: &Model<'_, P>,
    (state, chi_square): (&Unknowns, f64),
    root: &SquareRoot<P>,
    weakest: &Weakest,
    limit: f64,
) -> f64 {
    /// Each noise factor tried is this many times the one before.
    const GROWTH: f64 = 4.0;
    /// The least factor tried, in parts of the limit.
    const LEAST: f64 = 1e-3;
    /// Of the gap between one that holds and one that does not.
    const HALVINGS: usize = 20;
    if !(limit.is_finite() && limit > 0.0) {
        return f64::INFINITY;
    }
    if weakest.least() <= 0.0 {
        return 0.0;
    }
    let step = root.with_extras(&(Vector6::from(weakest.twist) / weakest.least()));
    let holds = |noise: f64| {
        let reach = REACH * noise;
        [reach, -reach].into_iter().all(|reach| {
            let there = state.moved(&step.map(|s| s * reach));
            let rise = (model.chi_square(&there) - chi_square) / (reach * reach);
            // What rounding of the misfit may add to a rise that is small itself.
            let rounding = 64.0 * f64::EPSILON * chi_square / (reach * reach);
            rise > RISE[0] - rounding && rise < RISE[1] + rounding
        })
    };
    // At a stated noise nothing below it is asked, as what fails there fails at the stated one, too, but for the message.
    let known = model.problem.reference_sigma().is_some();
    let mut last = if known && limit > 1.0 && holds(1.0) { 1.0 } else { 0.0 };
    let mut noise = if last > 0.0 { (last * GROWTH).min(limit) } else { limit * LEAST };
    while last < limit {
        if !holds(noise) {
            let (mut low, mut high) = (last, noise);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if holds(middle) { low = middle } else { high = middle }
            }
            return low;
        }
        last = noise;
        noise = (noise * GROWTH).min(limit);
    }
    f64::INFINITY
}

/// What a relative curvature allows.
pub(crate) fn curvature_bound(curvature: f64) -> f64 {
    CURVATURE / curvature
}

/// A free motion at a frame, told as a refusal.
pub(crate) fn degenerate(
    problem: &Problem<'_>,
    observability: &Observability,
    shown: (&'static str, f64, f64),
) -> SolveError {
    let unknowns = problem.unknowns();
    let (quantity, value, bound) = shown;
    SolveError::Degenerate(Box::new(Degenerate {
        // A motion may be seen, but worse than the noise lets it be told.
        rank: observability.rank.min(unknowns - 1),
        unknowns,
        quantity,
        value,
        bound,
        free: observability.weakest.clone(),
        help: "add a touch that this motion would move off its surface".to_owned(),
    }))
}

/// What shows that a motion is free whatever the noise.
pub(crate) fn rank_lost(observability: &Observability) -> (&'static str, f64, f64) {
    ("smallest over largest singular value", 1.0 / observability.condition, touchref_core::RANK_TOLERANCE)
}

fn no_candidate() -> SolveError {
    SolveError::InvalidTouches {
        problem: "no frame of the fixture comes near these touches".to_owned(),
        help: "check the labels and the unit of the touches".to_owned(),
        touches: Vec::new(),
    }
}

/// What a solver found, before it is told as a solution.
pub(crate) struct Found {
    pub(crate) frame: Frame,
    /// Per touch: length, and in standard deviations.
    pub(crate) residuals: Vec<(f64, f64)>,
    pub(crate) chi_square: f64,
    /// Covariance at the problem's own sigmas.
    pub(crate) covariance: Option<Matrix6<f64>>,
}

/// The part of a refusal or a solution that every solver fills in the same way.
pub(crate) struct Account<'a, 'p> {
    pub(crate) problem: &'a Problem<'p>,
    pub(crate) judgement: &'a Judgement,
    /// The bounds to hold against the noise: the judgement's, or tighter ones of the solver's own.
    pub(crate) bounds: Bounds,
}

impl Account<'_, '_> {
    /// Length of one factor of the problem's sigmas.
    fn unit(&self) -> f64 {
        self.problem.reference_sigma().unwrap_or(1.0)
    }

    pub(crate) fn trust(&self) -> Trust {
        let (up_to, limited_by) = self.bounds.up_to();
        let known = self.problem.reference_sigma();
        let second = self.judgement.second.map(|i| &self.judgement.minima[i]);
        let at = if known.is_some() { 1.0 } else { up_to };
        Trust {
            sigma: known,
            from_sigma: self.bounds.from * self.unit(),
            up_to_sigma: up_to * self.unit(),
            limited_by,
            second_minimum: second.map(|minimum| SecondMinimum {
                chi_square: known.map(|_| minimum.chi_square),
                frame: minimum.state.frame,
            }),
            nonlinearity: Some(self.judgement.curvature * at).filter(|c| c.is_finite()),
        }
    }

    /// The solution, but for what only its solver knows (roots, adjustments, iteration).
    pub(crate) fn solution(&self, solver: &'static str, found: Found) -> Solution {
        let Found { frame, residuals, chi_square, covariance } = found;
        let known = self.problem.reference_sigma();
        let residuals = residuals
            .into_iter()
            .map(|(length, normalized)| Residual { length, normalized: known.map(|_| normalized) });
        let degrees = degrees_of_freedom(self.problem);
        let observability = self.judgement.observability.clone();
        let mut solution = Solution::new(solver, frame, residuals.collect(), self.trust(), observability);
        solution.degrees_of_freedom = degrees;
        solution.freedom = self.problem.fixture().freedom();
        solution.search = Some(self.judgement.search());
        if known.is_some() {
            solution.chi_square = Some(chi_square);
            solution.p_value = chi_square_p_value(chi_square, degrees);
        }
        solution.covariance = match (known, covariance) {
            (Some(sigma), Some(matrix)) => {
                Some(Covariance { matrix, sigma, sigma_source: SigmaSource::Given })
            }
            (None, Some(matrix)) if degrees > 0 => {
                let variance = chi_square / degrees as f64;
                let sigma = variance.sqrt();
                Some(Covariance { matrix: matrix * variance, sigma, sigma_source: SigmaSource::Residuals })
            }
            _ => None,
        };
        solution.warnings = self.warnings();
        solution
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let mut warn = |code, message: String| warnings.push(Warning { code, message });
        let known = self.problem.reference_sigma().is_some();
        if !known {
            warn(
                "no-sigma",
                "no sigma is stated: the frame stands only if that of one touch lies between from_sigma and up_to_sigma"
                    .to_owned(),
            );
            let uncertain = self.problem.fixture().dimensions().iter().any(|d| d.u > 0.0);
            if uncertain || self.problem.probe().tip_radius_u > 0.0 {
                warn(
                    "uncertainty-not-used",
                    "uncertainties of dimensions or tip are not used, as no sigma is stated to weigh them against"
                        .to_owned(),
                );
            }
        }
        let degrees = degrees_of_freedom(self.problem);
        if !known && (1..5).contains(&degrees) {
            let plural = if degrees == 1 { "" } else { "s" };
            warn(
                "few-degrees-of-freedom",
                format!(
                    "the uncertainties rest on residuals with {degrees} degree{plural} of freedom: they may be several \
                     times too small; state a sigma"
                ),
            );
        }
        if self.judgement.by_near {
            warn(
                "chosen-by-near",
                "several frames fit; the expected frame decided for the nearest".to_owned(),
            );
        }
        let touches = self.problem.touches();
        let freedom = self.problem.fixture().freedom();
        if freedom != Freedom::NONE {
            let names = freedom.names().collect::<Vec<_>>().join(", ");
            warn(
                "free-motion",
                format!(
                    "the fixture leaves {names} free (along its own axes): the frame stands there as near the parent's axes \
                     or the expected frame as it goes, and its covariance says nothing of it"
                ),
            );
        }
        match degrees {
            0 => warn(
                LOW_REDUNDANCY,
                format!("{} touches are no more than unknowns: a bad touch cannot be noticed", touches.len()),
            ),
            1..REDUNDANT => warn(
                LOW_REDUNDANCY,
                format!(
                    "{} touches are {degrees} more than unknowns: a bad touch may be noticed, but never told which",
                    touches.len()
                ),
            ),
            _ => {}
        }
        let size = self.problem.fixture().size();
        let from_first = touches.iter().map(|touch| (touch.at - touches[0].at).norm());
        let spread = from_first.fold(0.0, f64::max);
        if spread < CLOSE * size {
            warn(
                "touches-close-together",
                format!(
                    "all touches lie within {} of the first, on a fixture of size {}: is the unit right?",
                    short(spread),
                    short(size)
                ),
            );
        }
        if let Some((i, j)) = coincident(touches) {
            warn(
                "coincident-touches",
                format!(
                    "touches {} and {} are the same point; they count as two observations",
                    self.problem.number(i),
                    self.problem.number(j)
                ),
            );
        }
        warnings
    }

    /// Why the frame does not stand, if it does not.
    pub(crate) fn refusal(
        &self,
        roots: impl FnOnce() -> Vec<RootReport>,
        hint: impl FnOnce() -> String,
    ) -> Option<SolveError> {
        let bounds = &self.bounds;
        let (up_to, limit) = bounds.up_to();
        let known = self.problem.reference_sigma().is_some();
        // Where no sigma is stated, some sigma must satisfy both sides.
        let noise = if known { 1.0 } else { bounds.from };
        let objection = self.judgement.best().objection.as_deref();
        let inconsistent = objection.is_some() || (known && bounds.from > noise);
        if !inconsistent && up_to > noise {
            return None;
        }
        let refuse = |message: String, help: String| {
            Box::new(Refusal {
                message,
                help,
                touches: Vec::new(),
                roots: roots(),
                trust: self.trust(),
                observability: Some(self.judgement.observability.clone()),
            })
        };
        if inconsistent {
            let (message, help) = self.inconsistent(objection, &hint());
            return Some(SolveError::Inconsistent(refuse(message, help)));
        }
        let seen = &self.judgement.observability;
        if self.judgement.weakest_sd * noise > FREE && seen.condition > WEAK {
            let sd = self.judgement.weakest_sd * noise;
            let shown = ("its standard deviation in parts of the fixture's size", sd, FREE);
            return Some(degenerate(self.problem, seen, shown));
        }
        let stated = if known { "the stated" } else { "the smallest consistent" };
        let sigma = short(noise * self.unit());
        let at_most = short(up_to * self.unit());
        let weakest = &self.judgement.observability.weakest;
        if known && bounds.ambiguity <= noise || limit == Limit::Ambiguity {
            let message = format!(
                "more than one frame fits: the next best would be excluded only up to a sigma of {at_most}, {stated} is \
                 {sigma}"
            );
            let help = "give an approximate frame (near), approach directions, or one more touch that tells the frames \
                        apart"
                .to_owned();
            return Some(SolveError::Ambiguous(refuse(message, help)));
        }
        let why = match limit {
            Limit::Search => "the layout is so weak that the search for other frames is not complete",
            Limit::Rise => "the misfit does not rise as the covariance predicts",
            _ => "the layout bends too much within the noise for a first-order covariance",
        };
        let message = format!(
            "the frame's uncertainty would not be true: {why}; it would be up to a sigma of {at_most}, {stated} is \
             {sigma}; weakest motion: {weakest}"
        );
        let help = format!("add touches that see the weakest motion ({weakest}), or measure with less noise");
        Some(SolveError::NotValidated(refuse(message, help)))
    }

    fn inconsistent(&self, objection: Option<&str>, hint: &str) -> (String, String) {
        if let Some(objection) = objection {
            let help = "check the labels of the touches, and their approach: i, j, k point along the probe's motion \
                        toward the surface";
            return (
                format!("every frame that fits is ruled out; at the best, {objection}"),
                help.to_owned(),
            );
        }
        let degrees = degrees_of_freedom(self.problem);
        let level = INCONSISTENT.value(degrees);
        let message = format!(
            "the touches contradict the fixture: chi-square {} with {degrees} degree{} of freedom, at most {} expected \
             (level {}); they would fit from a sigma of {}, stated is {}{hint}",
            short(self.judgement.best().chi_square),
            if degrees == 1 { "" } else { "s" },
            short(level),
            INCONSISTENT.chance(),
            short(self.bounds.from * self.unit()),
            short(self.unit()),
        );
        (message, "check labels, units, tip radius, the fixture's sizes and the stated sigma".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    /// Few touches and many are looked through in different ways.
    #[test]
    fn the_first_of_coincident_touches_is_told() {
        for count in [6, 60, 600] {
            let spread = |k: usize| Touch::new(k % 2, Point3::new((k as f64 * 0.7).sin(), k as f64, -1.0));
            let mut touches: Vec<Touch> = (0..count).map(spread).collect();
            assert_eq!(coincident(&touches), None);
            for (later, first) in [(count - 1, 3), (count - 2, 0), (count - 2, 2)] {
                touches[later] = touches[first];
            }
            // Of another surface it is another touch.
            touches[1].at = touches[0].at;
            assert_eq!(coincident(&touches), Some((2, count - 2)), "{count}");
        }
    }
}
