//! Levenberg-Marquardt on the manifold of frames.
//!
//! Steps are twists along the fixture's axes, so there is no chart to leave and no gimbal lock. Matrices live on the
//! stack; a descent allocates nothing. [`Descent::advance`] is the one step that the plain loop ([`descend`]) and the
//! solver for argmin's `Executor` share.

use crate::model::{Model, Normal, SquareRoot, Unknowns, unrolled};

/// A step shorter than this part of the fixture's size ends the descent: steps shrink at least tenfold near a
/// minimum, so what is left is below 1e-10 of the size.
const STEP: f64 = 1e-9;
/// A predicted decrease below this part of the squared misfit ends the descent: the step is 1e-4 standard deviations of
/// residuals as large as they are, and what is left after it is less.
const COST: f64 = 1e-8;
/// A gradient whose cosine with every column of the Jacobian is below this ends the descent: the residuals are
/// perpendicular to all motions but for rounding.
const GRADIENT: f64 = 1e-12;
/// Steps tried before a descent counts as not converged. Sound starts need three to six, bad ones tens.
pub(crate) const STEPS: usize = 100;
/// Damping at the start: all but Gauss-Newton, as starts come from a closed form.
const DAMPING: f64 = 1e-6;
/// A first step longer than this (parts of the fixture's size plus radians) shows a start that is far off.
const FAR: f64 = 0.25;
/// Damping from there: Gauss-Newton's step would leave the region where it is true.
const FAR_DAMPING: f64 = 10.0;
/// A step longer than this (as [`FAR`]) is still far off: damping then falls slowly, for long steps slide into other
/// basins.
const LONG: f64 = 0.1;
/// What damping falls by after a long step, and after any other.
const FALL: [f64; 2] = [0.5, 0.1];
/// Damping above which no step downhill exists to rounding.
const MOST_DAMPING: f64 = 1e12;

/// Why a descent ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stop {
    /// The residuals are perpendicular to every motion, to rounding.
    Gradient,
    /// The step has become too short to matter.
    Step,
    /// The squared misfit would hardly decrease any more.
    Cost,
    /// No step leads downhill, to rounding; or the normal equations are not positive definite at any damping.
    NoDescent,
    /// The iterations allowed are used up.
    Iterations,
}

impl Stop {
    /// In a word, for messages and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gradient => "gradient",
            Self::Step => "step",
            Self::Cost => "cost",
            Self::NoDescent => "no-descent",
            Self::Iterations => "iterations",
        }
    }

    /// Whether it tells a minimum.
    #[must_use]
    pub fn converged(self) -> bool {
        matches!(self, Self::Gradient | Self::Step | Self::Cost)
    }
}

/// One iteration of a descent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Squared misfit after it.
    pub chi_square: f64,
    /// Largest cosine between the residuals and a column of the Jacobian, before it.
    pub gradient: f64,
    /// Length of the step tried: translation in parts of the fixture's size, plus rotation in radians.
    pub step: f64,
    /// Marquardt's damping of it.
    pub damping: f64,
    /// Whether it led downhill and was taken.
    pub taken: bool,
}

/// A sum of squares that a descent can lower, its residuals made linear as an `L`.
pub(crate) trait SumOfSquares<L: Linear> {
    /// Values of the unknowns.
    type At: Clone;
    /// Residuals, their derivatives and squares there.
    fn linear(&self, at: &Self::At) -> L;
    /// Moved by a step in the unknowns.
    fn moved(&self, at: &Self::At, step: &L::Step) -> Self::At;
    /// Length of a step: lengths in parts of the size of what is measured, plus radians.
    fn length(&self, step: &L::Step) -> f64;
}

/// Residuals made linear in the unknowns: what a step is computed from.
pub(crate) trait Linear {
    /// A step in the unknowns.
    type Step;
    /// Sum of the squares.
    fn chi_square(&self) -> f64;
    /// Largest cosine between the residuals and a column of the Jacobian.
    fn cosine(&self) -> f64;
    /// The step under Marquardt's damping and, as far as that is none, the decrease it predicts; `None` where the
    /// unknowns are not determined.
    fn damped_step(&self, damping: f64) -> Option<(Self::Step, f64)>;
}

impl<const P: usize> Linear for Normal<P> {
    type Step = [f64; P];

    #[inline]
    fn chi_square(&self) -> f64 {
        self.chi_square
    }

    #[inline]
    fn cosine(&self) -> f64 {
        Normal::cosine(self)
    }

    #[inline]
    fn damped_step(&self, damping: f64) -> Option<([f64; P], f64)> {
        let step = damped_step(self, damping)?;
        let decrease = -step.iter().zip(&self.gradient).map(|(x, g)| x * g).sum::<f64>();
        Some((step, decrease))
    }
}

impl<const P: usize> SumOfSquares<Normal<P>> for Model<'_, P> {
    type At = Unknowns;

    #[inline]
    fn linear(&self, at: &Unknowns) -> Normal<P> {
        self.normal_equations(at)
    }

    #[inline]
    fn moved(&self, at: &Unknowns, step: &[f64; P]) -> Unknowns {
        at.moved(step)
    }

    #[inline]
    fn length(&self, step: &[f64; P]) -> f64 {
        length_of(step, self.problem.fixture().size())
    }
}

/// A descent under way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Descent<L, At = Unknowns> {
    pub(crate) at: At,
    linear: L,
    chi_square: f64,
    damping: f64,
    /// Whether no step was taken yet.
    first: bool,
    /// Steps tried.
    pub(crate) steps: usize,
}

impl<L: Linear, At: Clone> Descent<L, At> {
    pub(crate) fn from(model: &impl SumOfSquares<L, At = At>, start: At) -> Self {
        let linear = model.linear(&start);
        let chi_square = linear.chi_square();
        Self { at: start, linear, chi_square, damping: DAMPING, first: true, steps: 0 }
    }

    /// Squared misfit where it is.
    #[inline]
    pub(crate) fn chi_square(&self) -> f64 {
        self.chi_square
    }

    /// Tries one step; says why the descent is over, if it is.
    #[inline]
    pub(crate) fn advance(&mut self, model: &impl SumOfSquares<L, At = At>) -> (Progress, Option<Stop>) {
        self.steps += 1;
        let before = self.chi_square;
        let gradient = self.linear.cosine();
        let mut progress =
            Progress { chi_square: before, gradient, step: 0.0, damping: self.damping, taken: false };
        if gradient <= GRADIENT {
            return (progress, Some(Stop::Gradient));
        }
        let Some((mut step, mut decrease)) = self.linear.damped_step(self.damping) else {
            return (progress, self.damp());
        };
        let mut length = model.length(&step);
        if self.first && length > FAR {
            self.damping = FAR_DAMPING;
            (progress.damping, self.first) = (self.damping, false);
            let Some(shorter) = self.linear.damped_step(self.damping) else {
                return (progress, self.damp());
            };
            (step, decrease) = shorter;
            length = model.length(&step);
        }
        progress.step = length;
        let next = model.moved(&self.at, &step);
        let nearly_undamped = self.damping <= 0.1;
        if nearly_undamped && decrease <= COST * before {
            // The quadratic model is true to far better than what is left.
            (self.at, self.chi_square) = (next, before - decrease);
            (progress.chi_square, progress.taken) = (self.chi_square, true);
            return (progress, Some(Stop::Cost));
        }
        let linear = model.linear(&next);
        let downhill = linear.chi_square() < before;
        // Too short a step for rounding to tell up from down: take whichever is lower, and be done.
        let short = length <= STEP;
        if downhill {
            self.chi_square = linear.chi_square();
            (self.at, self.linear, self.first) = (next, linear, false);
            self.damping *= FALL[usize::from(length <= LONG)];
        }
        (progress.chi_square, progress.taken) = (self.chi_square, downhill);
        if short {
            return (progress, Some(Stop::Step));
        }
        (progress, if downhill { None } else { self.damp() })
    }

    /// More damping after a step that failed.
    fn damp(&mut self) -> Option<Stop> {
        self.damping = (self.damping * 10.0).max(1e-12);
        (self.damping > MOST_DAMPING).then_some(Stop::NoDescent)
    }
}

/// Descends from `start` to a local minimum of the squared misfit.
pub(crate) fn descend<L: Linear, At: Clone>(
    model: &impl SumOfSquares<L, At = At>,
    start: At,
) -> Descent<L, At> {
    let mut descent = Descent::from(model, start);
    for _ in 0..STEPS {
        if descent.advance(model).1.is_some() {
            break;
        }
    }
    descent
}

/// Descends from `start`, but ends without result (`None`) once `arrived` says of a place and its squared misfit that
/// it is in a basin already known. One that runs out of steps ends in a valley so flat that the tests of curvature
/// refuse it.
pub(crate) fn descend_unless<const P: usize>(
    model: &Model<'_, P>,
    start: Unknowns,
    arrived: impl Fn(&Unknowns, f64) -> bool,
) -> Option<Descent<Normal<P>>> {
    let mut descent = Descent::from(model, start);
    for _ in 0..STEPS {
        if arrived(&descent.at, descent.chi_square()) {
            return None;
        }
        if descent.advance(model).1.is_some() {
            break;
        }
    }
    Some(descent)
}

/// The sum of squares that no unknown could take up were the residuals linear; infinite where they leave one free.
pub(crate) fn linear_minimum<const P: usize>(model: &Model<'_, P>, at: &Unknowns) -> f64 {
    let normal = model.normal_equations(at);
    let Some((_, taken)) = normal.damped_step(0.0) else { return f64::INFINITY };
    (normal.chi_square - taken).max(0.0)
}

/// Undamped steps from near a minimum to where rounding ends them; the minimum, and the square root of the information
/// near it.
///
/// All but the first share one factor, by orthogonal reflections; each is the correction that makes semi-normal
/// equations as accurate as those (Bjorck, Numerical Methods for Least Squares Problems, 1996, section 6.6.5).
pub(crate) fn polish<const P: usize>(model: &Model<'_, P>, from: Unknowns) -> (Unknowns, SquareRoot<P>) {
    /// Steps shrink by the curvature's part, below 0.5 for any frame that is accepted.
    const STEPS: usize = 60;
    let root = model.square_root(&from);
    let (mut at, mut last) = (from, f64::INFINITY);
    let mut next = root.step();
    for _ in 0..STEPS {
        let Some(step) = next else { break };
        let length = model.length(&step);
        // It no longer shrinks: rounding.
        if length >= last {
            break;
        }
        at = at.moved(&step);
        // Steps shrink at the rate of the curvature: the next would be rounding.
        if length <= f64::EPSILON || last.is_finite() && length * length <= f64::EPSILON * last {
            break;
        }
        last = length;
        next = root.step_against(&model.gradient(&at));
    }
    (at, root)
}

/// The minimum near where a descent ended, however large its residuals, by Newton's method; `None` where there is none, as
/// on a saddle or in a valley.
pub(crate) fn settle<const P: usize>(model: &Model<'_, P>, from: Unknowns) -> Option<Unknowns> {
    /// Damping where none does not lead downhill, and the factor by which it grows and falls.
    const DAMPING: f64 = 1e-3;
    const GROWTH: f64 = 10.0;
    /// Of a step after which the next would be below rounding.
    const SETTLED: f64 = 1e-8;
    /// Second derivatives that this part of the diagonal turns singular are flat: the square of a motion's rank tolerance,
    /// and what rounding leaves of it.
    const FLAT: f64 = 1e-10;
    /// A curved valley takes hundreds.
    const STEPS: usize = 1000;
    let (mut at, mut damping) = (from, 0.0);
    let mut newton = model.newton_equations(&at);
    for _ in 0..STEPS {
        let step = damped_step(&newton, damping).map(|step| (model.length(&step), at.moved(&step)));
        if let Some((length, next)) = step
            && let after = model.newton_equations(&next)
            && (after.chi_square <= newton.chi_square || length <= SETTLED)
        {
            (at, newton) = (next, after);
            if length <= SETTLED {
                damped_step(&newton, -FLAT)?;
                if damping == 0.0 {
                    return Some(at);
                }
            }
            damping = if damping > DAMPING && length > SETTLED { damping / GROWTH } else { 0.0 };
        } else {
            damping = DAMPING.max(damping * GROWTH);
            if damping > MOST_DAMPING {
                return None;
            }
        }
    }
    None
}

/// Length of a step: lengths in parts of the fixture's size (extras count as lengths), plus radians.
#[inline]
fn length_of<const P: usize>(step: &[f64; P], size: f64) -> f64 {
    let (lengths, turns) = step.split_at(P - 3);
    let norm = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>().sqrt();
    norm(lengths) / size + norm(turns)
}

/// Solves `(A + damping diag A) x = -g` by elimination; `None` when that is not positive definite.
#[allow(clippy::needless_range_loop)] // Triangular indices read as in the books.
#[inline]
pub(crate) fn damped_step<const P: usize>(normal: &Normal<P>, damping: f64) -> Option<[f64; P]> {
    let (mut upper, mut right) = (normal.matrix, normal.gradient);
    let mut inverse = [0.0; P];
    for i in 0..P {
        upper[i][i] *= 1.0 + damping;
    }
    unrolled!(i in P => {
        let pivot = upper[i][i];
        // Not positive, or NaN.
        if pivot.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        inverse[i] = 1.0 / pivot;
        for k in i + 1..P {
            let factor = upper[i][k] * inverse[i];
            for j in k..P {
                upper[k][j] -= factor * upper[i][j];
            }
            right[k] -= factor * right[i];
        }
    });
    let mut x = [0.0; P];
    for i in (0..P).rev() {
        let known: f64 = (i + 1..P).map(|k| upper[i][k] * x[k]).sum();
        x[i] = -(right[i] + known) * inverse[i];
    }
    x.iter().all(|v| v.is_finite()).then_some(x)
}
