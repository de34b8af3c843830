//! What a solver is given and what it returns.

use std::{borrow::Cow, fmt};

use nalgebra::{Matrix6, Point3, Vector3};

use crate::{
    Fixture, Frame, Freedom, Noise, Observability, Probe, Proximity, Rule, Shape, SolveError, Surface, Touch,
    TouchError, fixture::touches_per_surface,
};

/// A way to find the frame. Object safe.
pub trait Solver: fmt::Debug + Send + Sync {
    /// The name its plugin is registered under.
    fn name(&self) -> &'static str;

    /// Finds the frame, or says why there is none to trust.
    ///
    /// # Errors
    /// A [`SolveError`]: too few touches, a degenerate layout, no frame or several within the noise, or an
    /// uncertainty that would not be true.
    fn solve(&self, problem: &Problem<'_>) -> Result<Solution, SolveError>;

    /// The rule by which it accepts frames, for a solver whose frames may be found [many at once](crate::Together).
    fn rule(&self) -> Option<Rule> {
        None
    }
}

const _: Option<&dyn Solver> = None;

/// A measurement: fixture, touches and probe, checked; borrows all of them.
#[derive(Debug, Clone, Copy)]
pub struct Problem<'a> {
    fixture: &'a dyn Fixture,
    surfaces: &'a [Surface],
    touches: &'a [Touch],
    numbers: Option<&'a [usize]>,
    probe: Probe,
    near: Option<Frame>,
    reference_sigma: Option<f64>,
}

impl<'a> Problem<'a> {
    /// Checks that every number is finite, every surface exists and every sigma is positive.
    ///
    /// # Errors
    /// The first touch or probe value that is wrong.
    pub fn new(fixture: &'a dyn Fixture, touches: &'a [Touch], probe: Probe) -> Result<Self, TouchError> {
        check_probe(&probe)?;
        if touches.is_empty() {
            return Err(TouchError::Empty);
        }
        let surfaces = fixture.surfaces();
        for (index, touch) in touches.iter().enumerate() {
            check_touch(index, touch, surfaces.len())?;
        }
        let states_own = |touch: &Touch| touch.noise != Noise::OfProbe;
        if probe.sigma.is_none()
            && touches.iter().any(states_own)
            && let Some(index) = touches.iter().position(|touch| !states_own(touch))
        {
            return Err(TouchError::SigmaMissing { index });
        }
        let mut problem = Self {
            fixture,
            surfaces,
            touches,
            numbers: None,
            probe,
            near: None,
            reference_sigma: probe.sigma,
        };
        if touches.iter().all(states_own) {
            // No single sigma is stated: the root mean square speaks for all.
            let squares = touches.iter().map(|touch| mean_variance(&touch.noise)).sum::<f64>();
            problem.reference_sigma = Some((squares / touches.len() as f64).sqrt());
        }
        Ok(problem)
    }

    /// The same measurement with a frame near which the answer is expected; it decides between frames that fit
    /// equally well.
    #[must_use]
    pub fn near(self, frame: Frame) -> Self {
        Self { near: Some(frame), ..self }
    }

    /// The same measurement with other touches: some of its own, perhaps with other labels. `numbers` tells which touch
    /// of the measurement each of them is, for messages.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_touches<'b>(
        &self,
        touches: &'b [Touch],
        numbers: &'b [usize],
    ) -> Result<Problem<'b>, TouchError>
    where
        'a: 'b,
    {
        let other = Problem::new(self.fixture, touches, self.probe)?;
        Ok(Problem { near: self.near, numbers: Some(numbers), ..other })
    }

    /// Which touch of the measurement, from 0, this one is: messages count so.
    #[must_use]
    pub fn number(&self, index: usize) -> usize {
        self.numbers.and_then(|numbers| numbers.get(index)).copied().unwrap_or(index)
    }

    /// The fixture.
    #[must_use]
    pub fn fixture(&self) -> &'a dyn Fixture {
        self.fixture
    }

    /// The touches, in input order.
    #[must_use]
    pub fn touches(&self) -> &'a [Touch] {
        self.touches
    }

    /// The mean of the touches.
    #[must_use]
    pub fn centroid(&self) -> Point3<f64> {
        let sum: Vector3<f64> = self.touches.iter().map(|touch| touch.at.coords).sum();
        Point3::from(sum / self.touches.len() as f64)
    }

    /// The probe.
    #[must_use]
    pub fn probe(&self) -> &Probe {
        &self.probe
    }

    /// The frame near which the answer is expected, if one was given.
    #[must_use]
    pub fn expected_near(&self) -> Option<&Frame> {
        self.near.as_ref()
    }

    /// Standard deviation of one touch: the probe's, or the root mean square of the touches' own; `None` where
    /// nothing is stated.
    #[must_use]
    pub fn reference_sigma(&self) -> Option<f64> {
        self.reference_sigma
    }

    /// Standard deviation of touch `index` whatever the direction: the root mean square over directions; 1 where no
    /// sigma is stated, so that weights are equal and misfits are lengths.
    #[must_use]
    pub fn mean_sigma(&self, index: usize) -> f64 {
        match self.touches[index].noise {
            Noise::OfProbe => self.probe.sigma.unwrap_or(1.0),
            own => mean_variance(&own).sqrt(),
        }
    }

    /// One touch as the fixture sees it when it stands at `frame`.
    #[must_use]
    #[expect(
        clippy::inline_always,
        reason = "in every evaluation of every solver: a call costs as much as it does"
    )]
    #[inline(always)]
    pub fn contact(&self, frame: &Frame, index: usize) -> Contact {
        self.contact_with(frame, index, &self.surfaces[self.touches[index].surface].shape)
    }

    /// The same, its surface having another geometry than the fixture's nominal one.
    #[must_use]
    #[expect(
        clippy::inline_always,
        reason = "in every evaluation of every solver: a call costs as much as it does"
    )]
    #[inline(always)]
    pub fn contact_with(&self, frame: &Frame, index: usize, shape: &Shape) -> Contact {
        let touch = &self.touches[index];
        let at = frame.to_fixture(&touch.at);
        let Proximity { distance, normal } = shape.seen_from(&at);
        let sigma = match touch.noise {
            Noise::OfProbe => self.probe.sigma.unwrap_or(1.0),
            Noise::Sigma(sigma) => sigma,
            Noise::Covariance(_) => touch.noise.along(&(frame.rotation * normal), 1.0),
        };
        Contact { at, residual: distance - self.probe.tip_radius, normal, sigma }
    }

    /// The touches of one surface, in input order, each with its index among all.
    #[inline]
    pub fn touches_on(&self, surface: usize) -> impl Iterator<Item = (usize, &'a Touch)> + Clone + use<'a> {
        self.touches.iter().enumerate().filter(move |(_, touch)| touch.surface == surface)
    }

    /// How many unknowns the frame has: six, less what the fixture leaves free.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        6 - self.fixture.freedom().count()
    }

    /// How many touches each surface has, in the fixture's order.
    #[must_use]
    pub fn counts(&self) -> Vec<usize> {
        touches_per_surface(self.fixture.surfaces().len(), self.touches.iter().map(|touch| touch.surface))
    }

    /// Checks that the touches are enough for the fixture.
    ///
    /// # Errors
    /// [`SolveError::TooFewTouches`], saying on which surfaces.
    pub fn require_enough(&self) -> Result<(), SolveError> {
        match self.fixture.requirement().missing(&self.counts(), self.fixture.surfaces()) {
            None => Ok(()),
            Some(missing) => Err(SolveError::TooFewTouches { missing }),
        }
    }
}

fn mean_variance(noise: &Noise) -> f64 {
    match noise {
        Noise::OfProbe => 0.0,
        Noise::Sigma(sigma) => sigma * sigma,
        Noise::Covariance(c) => c.trace() / 3.0,
    }
}

fn check_probe(probe: &Probe) -> Result<(), TouchError> {
    let bad = |what, value, expected| Err(TouchError::BadProbe { what, value, expected });
    if !(probe.tip_radius.is_finite() && probe.tip_radius >= 0.0) {
        return bad("tip radius", probe.tip_radius, "a length, 0 or more");
    }
    if !(probe.tip_radius_u.is_finite() && probe.tip_radius_u >= 0.0) {
        return bad("uncertainty of the tip radius", probe.tip_radius_u, "a length, 0 or more");
    }
    match probe.sigma {
        Some(sigma) if !(sigma.is_finite() && sigma > 0.0) => bad("sigma", sigma, "a length > 0"),
        _ => Ok(()),
    }
}

fn check_touch(index: usize, touch: &Touch, surfaces: usize) -> Result<(), TouchError> {
    let bad = |what, value, expected| Err(TouchError::BadNumber { index, what, value, expected });
    if touch.surface >= surfaces {
        return Err(TouchError::NoSuchSurface { index, surface: touch.surface, surfaces });
    }
    if let Some(value) = touch.at.iter().copied().find(|v| !v.is_finite()) {
        return bad("a coordinate", value, "a finite number");
    }
    if let Some(approach) = touch.approach
        && let Some(value) = approach.iter().copied().find(|v| !v.is_finite())
    {
        return bad("a component of the approach", value, "a finite number");
    }
    match touch.noise {
        Noise::OfProbe => Ok(()),
        Noise::Sigma(sigma) if sigma.is_finite() && sigma > 0.0 => Ok(()),
        Noise::Sigma(sigma) => bad("sigma", sigma, "a length > 0"),
        Noise::Covariance(c) => {
            let symmetric = (c - c.transpose()).abs().max() <= 1e-12 * c.abs().max();
            // The decomposition of what is not finite may never settle.
            let finite = c.iter().all(|v| v.is_finite());
            let least = if finite { c.symmetric_eigenvalues().min() } else { f64::NAN };
            if symmetric && least > 0.0 {
                Ok(())
            } else {
                bad(
                    "the smallest eigenvalue of the covariance",
                    least,
                    "a symmetric matrix with eigenvalues > 0",
                )
            }
        }
    }
}

/// A touch as the fixture sees it.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// The tip's centre, in fixture coordinates.
    pub at: Point3<f64>,
    /// Signed distance from the surface less the tip radius.
    pub residual: f64,
    /// Outward normal of the surface there, in fixture coordinates.
    pub normal: Vector3<f64>,
    /// Standard deviation of the touch along the normal; 1 where no sigma is stated.
    pub sigma: f64,
}

impl Contact {
    /// How fast the residual grows with a twist of the frame along the fixture's axes about its origin, translation
    /// first: one row of the Jacobian, not weighted.
    ///
    /// A twist `(v, w)` of the frame moves the touch, seen from the fixture, by `-v - w x p`.
    #[must_use]
    #[inline]
    pub fn gradient(&self) -> [f64; 6] {
        let (n, turn) = (self.normal, self.at.coords.cross(&self.normal));
        [-n.x, -n.y, -n.z, -turn.x, -turn.y, -turn.z]
    }
}

/// The frame, how far it can be trusted, and all that was weighed on the way.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// Name of the solver.
    pub solver: &'static str,
    /// The fixture's frame in the parent.
    pub frame: Frame,
    /// What of the frame no touch can tell, by the fixture's nature: as near the parent's axes, or the expected frame,
    /// as it goes, and without uncertainty.
    pub freedom: Freedom,
    /// Its covariance; `None` where no sigma is stated and no redundancy estimates one.
    pub covariance: Option<Covariance>,
    /// Per touch, in input order.
    pub residuals: Vec<Residual>,
    /// The touches, from 0, on which the frame does not rest because the solver holds them for bad; their residuals are
    /// told all the same.
    pub excluded: Vec<usize>,
    /// Root mean square of the residuals of the touches that are not excluded (divisor: the number of these).
    pub rms: f64,
    /// Squared misfit over the variance; `None` where no sigma is stated.
    pub chi_square: Option<f64>,
    /// Touches that are not excluded, less unknowns.
    pub degrees_of_freedom: usize,
    /// Chance of a larger [`chi_square`](Self::chi_square); `None` without one or without degrees of freedom.
    pub p_value: Option<f64>,
    /// Every root of the closed form, and why all but one are out.
    pub roots: Vec<RootReport>,
    /// Uncertain dimensions and tip radius that were unknowns beside the frame.
    pub adjustments: Vec<Adjustment>,
    /// How the iteration ended, where there was one.
    pub iteration: Option<Iteration>,
    /// From where other frames were looked for, and what was found; `None` for a solver that does not tell.
    pub search: Option<SearchReport>,
    /// The margin within which the frame stands.
    pub trust: Trust,
    /// What the touches see at the frame.
    pub observability: Observability,
    /// What the user should know although the frame stands.
    pub warnings: Vec<Warning>,
}

impl Solution {
    /// A solution with the parts every solver has; the rest empty.
    #[must_use]
    pub fn new(
        solver: &'static str,
        frame: Frame,
        residuals: Vec<Residual>,
        trust: Trust,
        observability: Observability,
    ) -> Self {
        let squares = residuals.iter().map(|r| r.length * r.length).sum::<f64>();
        let rms = (squares / residuals.len().max(1) as f64).sqrt();
        Self {
            solver,
            frame,
            freedom: Freedom::NONE,
            covariance: None,
            residuals,
            excluded: Vec::new(),
            rms,
            chi_square: None,
            degrees_of_freedom: 0,
            p_value: None,
            roots: Vec::new(),
            adjustments: Vec::new(),
            iteration: None,
            search: None,
            trust,
            observability,
            warnings: Vec::new(),
        }
    }

    /// Squared distance of another frame from this one, in this one's own covariance: chi-square with six degrees of
    /// freedom for the true frame, less one for each motion that the fixture leaves free and that does not count. `None`
    /// where no covariance is stated, or none that is positive.
    #[must_use]
    pub fn squared_distance(&self, other: &Frame) -> Option<f64> {
        let mut covariance = self.covariance.as_ref()?.matrix;
        if self.freedom == Freedom::NONE {
            let error = self.frame.error_to(other);
            return Some(error.dot(&covariance.cholesky()?.solve(&error)));
        }
        let other = self.freedom.nearest(other, &self.frame);
        let along_fixture = Frame { rotation: self.frame.rotation.inverse(), ..self.frame };
        covariance = along_fixture.to_parent_axes(&covariance);
        for index in (0..6).filter(|index| self.freedom.is_free(*index)) {
            covariance[(index, index)] = 1.0;
        }
        let error = self.freedom.without(&self.frame.twist_to(&other).into());
        Some(error.dot(&covariance.cholesky()?.solve(&error)))
    }
}

/// Covariance of a frame.
///
/// Order `x y z rx ry rz`: translation of the fixture's origin and rotation vector about it (radians), both along
/// the **parent's** axes: `t' = t + dt`, `R' = exp(dw) R`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covariance {
    /// The 6x6 matrix.
    pub matrix: Matrix6<f64>,
    /// Standard deviation of one touch that it stands on.
    pub sigma: f64,
    /// Where that came from.
    pub sigma_source: SigmaSource,
}

impl Covariance {
    /// Standard deviations, in the order of the matrix.
    #[must_use]
    pub fn standard_deviations(&self) -> [f64; 6] {
        std::array::from_fn(|i| self.matrix[(i, i)].max(0.0).sqrt())
    }
}

/// Where the standard deviation of a touch came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SigmaSource {
    /// The measurement states it.
    Given,
    /// The residuals, by their degrees of freedom.
    Residuals,
}

impl SigmaSource {
    /// The word that results have for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Residuals => "residuals",
        }
    }
}

/// How far a touch is from its surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Signed distance from the surface less the tip radius; a length.
    pub length: f64,
    /// In standard deviations of the touch; `None` where none is stated.
    pub normalized: Option<f64>,
}

/// One root, and what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct RootReport {
    /// Its frame.
    pub frame: Frame,
    /// What it implies for the fixture's dimensions.
    pub measures: Vec<Measure>,
    /// How far it is from the known geometry, in standard deviations; `None` where no sigma is stated.
    pub misfit: Option<f64>,
    /// Whether it is the one.
    pub selected: bool,
    /// Why it is, or why not.
    pub reason: Cow<'static, str>,
}

/// A dimension as a root measures it.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// Name of the dimension.
    pub name: Cow<'static, str>,
    /// Its value: a length, or degrees.
    pub value: f64,
    /// Its standard uncertainty; `None` where no sigma is stated.
    pub u: Option<f64>,
}

/// An uncertain quantity that was an unknown beside the frame: what was known of it, and what the touches made of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Adjustment {
    /// Name of the dimension, or `tip_radius`.
    pub name: Cow<'static, str>,
    /// Its nominal value: a length, or degrees.
    pub nominal: f64,
    /// Standard uncertainty of that; `None` where only the touches tell it.
    pub nominal_u: Option<f64>,
    /// Its estimate.
    pub value: f64,
    /// Standard uncertainty of that.
    pub u: f64,
}

impl Adjustment {
    /// How far it moved, in standard uncertainties of its nominal value; of its estimate where the nominal value has
    /// none.
    #[must_use]
    pub fn moved(&self) -> f64 {
        (self.value - self.nominal) / self.nominal_u.unwrap_or(self.u)
    }
}

/// How an iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Iteration {
    /// Steps made.
    pub steps: usize,
    /// The criterion that ended it: `gradient`, `step` or `cost`.
    pub stopped_by: &'static str,
}

/// The search for every frame that the touches may mean.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchReport {
    /// Frames from which it descended, those that were given up on the way among them.
    pub starts: usize,
    /// The distinct local minima of the squared misfit that it found, lowest first.
    pub minima: Vec<MinimumReport>,
}

/// A local minimum of the squared misfit.
#[derive(Debug, Clone, PartialEq)]
pub struct MinimumReport {
    /// Its frame.
    pub frame: Frame,
    /// The squared misfit there; a length squared where no sigma is stated.
    pub chi_square: f64,
    /// The frame from which it was first reached.
    pub start: Frame,
    /// Steps of that descent.
    pub steps: usize,
    /// Whether it is the frame that was accepted.
    pub selected: bool,
    /// Why it cannot be the frame, however well it fits, if something speaks against it.
    pub objection: Option<String>,
}

/// The margin within which a frame stands.
///
/// The frame is the only one, consistent, and its uncertainty true, if the standard deviation of one touch lies
/// between the two bounds. All sigmas are lengths; where touches differ they are scaled together, and the root mean
/// square is told.
#[derive(Debug, Clone, PartialEq)]
pub struct Trust {
    /// The stated standard deviation of one touch.
    pub sigma: Option<f64>,
    /// Below this the touches contradict the fixture.
    pub from_sigma: f64,
    /// Above this the frame is not the only one, or its uncertainty is not true; infinite when nothing limits it.
    pub up_to_sigma: f64,
    /// What gives way first above that.
    pub limited_by: Limit,
    /// The next best frame.
    pub second_minimum: Option<SecondMinimum>,
    /// Relative curvature at the stated sigma, else at `up_to_sigma`; `None` where it could not be had.
    pub nonlinearity: Option<f64>,
}

/// What gives way above [`Trust::up_to_sigma`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// Nothing.
    None,
    /// A second frame fits within the noise.
    Ambiguity,
    /// First-order uncertainty does not hold: relative curvature.
    Curvature,
    /// First-order uncertainty does not hold: the misfit does not rise as predicted along the weakest motion.
    Rise,
    /// The search for other frames is no longer complete: the layout is too weak for this much noise.
    Search,
}

/// The next best frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondMinimum {
    /// Its squared misfit; `None` where no sigma is stated.
    pub chi_square: Option<f64>,
    /// Its frame.
    pub frame: Frame,
}

/// Something the user should know although the frame stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// By which programs know it.
    pub code: &'static str,
    /// For people.
    pub message: String,
}
