//! Levenberg-Marquardt on the manifold of frames: the plain loop.
//!
//! Steps are twists along the fixture's axes, so there is no chart to leave and no gimbal lock. Matrices live on the
//! stack; a solve allocates nothing.

use crate::model::{Model, Normal, State};

/// Where a descent ended. One that ran out of steps ends in a valley so flat that the tests of curvature refuse it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Descent {
    pub(crate) state: State,
    pub(crate) chi_square: f64,
}

/// A step shorter than this part of the fixture's size ends the descent: steps shrink at least tenfold near a
/// minimum, so what is left is below 1e-10 of the size.
const STEP: f64 = 1e-9;
/// Steps tried before a descent counts as not converged. Sound starts need three to six, bad ones tens.
const STEPS: usize = 100;
/// Damping at the start: nearly Gauss-Newton, as starts come from a closed form.
const DAMPING: f64 = 1e-4;
/// Damping above which no step downhill exists to rounding.
const MOST_DAMPING: f64 = 1e12;

/// Descends from `start` to a local minimum of the squared misfit.
pub(crate) fn descend<const P: usize>(model: &Model<'_, P>, start: State) -> Descent {
    // No place is known: it cannot be cut short.
    descend_unless(model, start, |_, _| false).unwrap_or(Descent { state: start, chi_square: f64::NAN })
}

/// Descends from `start`, but ends without result (`None`) once `arrived` says of a state and its squared misfit that
/// it is in a basin already known.
pub(crate) fn descend_unless<const P: usize>(
    model: &Model<'_, P>,
    start: State,
    arrived: impl Fn(&State, f64) -> bool,
) -> Option<Descent> {
    let size = model.problem.fixture().size();
    let mut state = start;
    let mut normal = model.normal_equations(&state);
    let mut damping = DAMPING;
    for _ in 0..STEPS {
        let Some(step) = damped_step(&normal, damping) else {
            damping = (damping * 10.0).max(1e-12);
            if damping > MOST_DAMPING {
                break;
            }
            continue;
        };
        let length = length_of(&step, size);
        let next = state.moved(&step);
        let next_normal = model.normal_equations(&next);
        if length <= STEP * size {
            // Too short for rounding to tell up from down: take whichever is lower, and be done.
            if next_normal.chi_square <= normal.chi_square {
                (state, normal) = (next, next_normal);
            }
            return Some(Descent { state, chi_square: normal.chi_square });
        }
        if next_normal.chi_square < normal.chi_square {
            (state, normal) = (next, next_normal);
            damping *= 0.1;
            if arrived(&state, normal.chi_square) {
                return None;
            }
        } else {
            damping *= 10.0;
            if damping > MOST_DAMPING {
                break;
            }
        }
    }
    Some(Descent { state, chi_square: normal.chi_square })
}

/// The minimum to rounding, from where a descent ended: Gauss-Newton's steps, undamped and by orthogonal transformation,
/// as long as they shrink. Beside large residuals they do so only by the residuals' part of the radii of curvature.
pub(crate) fn settled<const P: usize>(model: &Model<'_, P>, end: State) -> State {
    let size = model.problem.fixture().size();
    let mut state = end;
    let mut shortest = f64::INFINITY;
    for _ in 0..STEPS {
        let Some(step) = model.square_root(&state).step() else { break };
        let length = length_of(&step, size);
        if length.partial_cmp(&shortest) != Some(std::cmp::Ordering::Less) {
            break;
        }
        state = state.moved(&step);
        shortest = length;
    }
    state
}

/// Length of a step with rotations scaled by the fixture's size; extras count as lengths.
fn length_of<const P: usize>(step: &[f64; P], size: f64) -> f64 {
    let (lengths, turns) = step.split_at(P - 3);
    let squares = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>();
    (squares(lengths) + size * size * squares(turns)).sqrt()
}

/// Solves `(A + damping diag A) x = -g` by `L D L^T`; `None` when that is not positive definite.
#[allow(clippy::needless_range_loop)] // Triangular indices read as in the books.
#[inline]
fn damped_step<const P: usize>(normal: &Normal<P>, damping: f64) -> Option<[f64; P]> {
    let mut l = normal.matrix;
    let mut d = [0.0; P];
    for i in 0..P {
        l[i][i] *= 1.0 + damping;
    }
    for j in 0..P {
        let mut pivot = l[j][j];
        for k in 0..j {
            pivot -= l[j][k] * l[j][k] * d[k];
        }
        // Not positive, or NaN.
        if pivot.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        d[j] = pivot;
        for i in j + 1..P {
            let mut sum = l[i][j];
            for k in 0..j {
                sum -= l[i][k] * l[j][k] * d[k];
            }
            l[i][j] = sum / pivot;
        }
    }
    let mut x = [0.0; P];
    for i in 0..P {
        let mut sum = -normal.gradient[i];
        for k in 0..i {
            sum -= l[i][k] * x[k];
        }
        x[i] = sum;
    }
    for i in (0..P).rev() {
        let mut sum = x[i] / d[i];
        for k in i + 1..P {
            sum -= l[k][i] * x[k];
        }
        x[i] = sum;
    }
    x.iter().all(|v| v.is_finite()).then_some(x)
}
