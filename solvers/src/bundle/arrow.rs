//! The least-squares problem of many placements, shaped like an arrow: each touch sees its own placement's frame and the
//! shared parameters, so the information has one block of six for each frame and a border for what is shared.
//!
//! Each placement's frame is eliminated on the stack by orthogonal reflections; what its touches then still say of the
//! shared parameters is a few rows. These rows of all placements are a tall matrix, which faer factors: the condition is
//! never squared, and time and memory grow in proportion to the placements.

use faer::{Mat, linalg::solvers::SolveLstsq};
use nalgebra::{DMatrix, Matrix6, SMatrix};
use touchref_core::{Iteration, Problem, RANK_TOLERANCE};

use crate::{
    levenberg_marquardt::{Linear, SumOfSquares, descend},
    model::{Extra, Model, SquareRoot, Unknowns},
};

/// The sum of squares over all frames and the shared parameters.
pub(super) struct Bundle<'a, const P: usize> {
    /// The shared parameters are unknowns of each, without what is known of them: that counts once.
    models: Vec<Model<'a, P>>,
    shared: &'a [Extra],
}

/// Its residuals made linear: of each placement the square root of the information, its frame first.
pub(super) struct Arrow<const P: usize> {
    roots: Vec<SquareRoot<P>>,
    /// Which shared parameter, one over the standard uncertainty of its nominal value, and its whitened deviation.
    priors: Vec<(usize, f64, f64)>,
    chi_square: f64,
}

impl<const P: usize> SumOfSquares<Arrow<P>> for Bundle<'_, P> {
    /// The frame of each placement; the shared parameters are the same in all.
    type At = Vec<Unknowns>;

    fn linear(&self, at: &Vec<Unknowns>) -> Arrow<P> {
        let placed = || self.models.iter().zip(at);
        let roots = placed().map(|(model, at)| model.square_root_frame_first(at)).collect();
        let priors: Vec<(usize, f64, f64)> = self
            .shared
            .iter()
            .enumerate()
            .filter_map(|(k, extra)| extra.prior.map(|u| (k, 1.0 / u, at[0].extras[k] / u)))
            .collect();
        let chi_square = placed().map(|(model, at)| model.chi_square(at)).sum::<f64>()
            + priors.iter().map(|(.., residual)| residual * residual).sum::<f64>();
        Arrow { roots, priors, chi_square }
    }

    fn moved(&self, at: &Vec<Unknowns>, step: &Vec<[f64; P]>) -> Vec<Unknowns> {
        at.iter().zip(step).map(|(at, step)| at.moved(step)).collect()
    }

    /// That of the placement which moves most.
    fn length(&self, step: &Vec<[f64; P]>) -> f64 {
        self.models.iter().zip(step).map(|(model, step)| model.length(step)).fold(0.0, f64::max)
    }
}

impl<const P: usize> Linear for Arrow<P> {
    /// Of each placement: the shared parameters, then its frame.
    type Step = Vec<[f64; P]>;

    fn chi_square(&self) -> f64 {
        self.chi_square
    }

    fn cosine(&self) -> f64 {
        let mut shared = vec![0.0; P - 6];
        let mut largest = 0.0_f64;
        for root in &self.roots {
            let gradient = root.gradient();
            for (sum, slope) in shared.iter_mut().zip(&gradient[6..]) {
                *sum += slope;
            }
            for (column, slope) in gradient[..6].iter().enumerate() {
                // What no touch sees has no cosine, and `max` passes it by.
                largest = largest.max(slope * slope / root.column_square(column));
            }
        }
        for (k, weight, residual) in &self.priors {
            shared[*k] += weight * residual;
        }
        for (slope, square) in shared.iter().zip(self.shared_squares()) {
            largest = largest.max(slope * slope / square);
        }
        (largest / self.chi_square).sqrt()
    }

    fn damped_step(&self, damping: f64) -> Option<(Vec<[f64; P]>, f64)> {
        let damped: Vec<SquareRoot<P>>;
        let roots = if damping > 0.0 {
            damped = self.roots.iter().map(|root| root.with_six_damped(damping)).collect();
            &damped
        } else {
            &self.roots
        };
        let (rows, right) = self.shared_rows(roots, damping);
        let shared = rows.qr().solve_lstsq(&right);
        let shared: [f64; P] = std::array::from_fn(|k| if k < 6 { 0.0 } else { -shared[(k - 6, 0)] });
        let mut decrease: f64 =
            self.priors.iter().map(|(k, weight, residual)| -shared[6 + k] * weight * residual).sum();
        let mut steps = Vec::with_capacity(roots.len());
        for (root, undamped) in roots.iter().zip(&self.roots) {
            let mut step = root.six_after(&shared)?;
            decrease -= step.iter().zip(undamped.gradient()).map(|(x, slope)| x * slope).sum::<f64>();
            step.rotate_left(6);
            steps.push(step);
        }
        Some((steps, decrease))
    }
}

impl<const P: usize> Arrow<P> {
    /// Squared length of the Jacobian's column of each shared parameter.
    fn shared_squares(&self) -> [f64; P] {
        let mut squares = [0.0; P];
        for (k, square) in squares.iter_mut().enumerate().take(P - 6) {
            *square = self.roots.iter().map(|root| root.column_square(6 + k)).sum();
        }
        for (k, weight, _) in &self.priors {
            squares[*k] += weight * weight;
        }
        squares
    }

    /// What is said of the shared parameters once the frames are eliminated: by each placement, by what is known of
    /// them, and by Marquardt's damping.
    fn shared_rows(&self, roots: &[SquareRoot<P>], damping: f64) -> (Mat<f64>, Mat<f64>) {
        let count = P - 6;
        let damped = if damping > 0.0 { count } else { 0 };
        let above = roots.len() * count;
        let mut rows = Mat::zeros(above + self.priors.len() + damped, count);
        let mut right = Mat::zeros(rows.nrows(), 1);
        for (placement, root) in roots.iter().enumerate() {
            for i in 0..count {
                let row = placement * count + i;
                for j in i..count {
                    rows[(row, j)] = root.r[6 + i][6 + j];
                }
                right[(row, 0)] = root.q[6 + i];
            }
        }
        for (row, (k, weight, residual)) in (above..).zip(&self.priors) {
            rows[(row, *k)] = *weight;
            right[(row, 0)] = *residual;
        }
        for (k, square) in self.shared_squares().iter().enumerate().take(damped) {
            rows[(above + self.priors.len() + k, k)] = (damping * square).sqrt();
        }
        (rows, right)
    }

    /// The information about the shared parameters, the frames eliminated.
    fn reduced(&self) -> Reduced {
        let (rows, _) = self.shared_rows(&self.roots, 0.0);
        // A column that nothing says anything of stays zero.
        let scales: Vec<f64> = self.shared_squares()[..P - 6]
            .iter()
            .map(|square| if *square > 0.0 { square.sqrt() } else { 1.0 })
            .collect();
        let scaled = Mat::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)] / scales[j]);
        let mut reduced = Reduced {
            singular_values: vec![0.0; P - 6],
            directions: DMatrix::identity(P - 6, P - 6),
            scales,
        };
        // Where numbers are not finite nothing is seen.
        if let Ok(svd) = scaled.thin_svd() {
            reduced.singular_values = svd.S().column_vector().iter().copied().collect();
            reduced.directions = DMatrix::from_fn(P - 6, P - 6, |i, j| svd.V()[(i, j)]);
        }
        reduced
    }
}

/// The information about the shared parameters, the frames eliminated: singular values of its square root, whose columns
/// are scaled so that each had length one when the frames were known. Without unit, and at most the root of the count.
pub(super) struct Reduced {
    /// Largest first.
    pub(super) singular_values: Vec<f64>,
    /// Their directions, by columns, in the scaled parameters.
    pub(super) directions: DMatrix<f64>,
    /// By what a parameter is multiplied to scale it.
    pub(super) scales: Vec<f64>,
}

impl Reduced {
    /// How many combinations of the parameters are not seen.
    pub(super) fn unseen(&self) -> usize {
        self.singular_values.iter().filter(|value| value.is_nan() || **value <= RANK_TOLERANCE).count()
    }

    /// Covariance of the parameters.
    fn covariance(&self) -> DMatrix<f64> {
        let count = self.scales.len();
        let root = DMatrix::from_fn(count, count, |i, j| {
            self.directions[(i, j)] / (self.scales[i] * self.singular_values[j])
        });
        &root * root.transpose()
    }
}

/// The minimum of the sum of squares; covariances and normalized residuals at the problems' own sigmas.
pub(super) struct Fit {
    /// Deviations of the shared parameters from their nominal values.
    pub(super) shared: Vec<f64>,
    pub(super) reduced: Reduced,
    pub(super) covariance: DMatrix<f64>,
    pub(super) placements: Vec<FittedPlacement>,
    /// Priors included.
    pub(super) chi_square: f64,
    /// Length of the step that would still follow, in standard deviations.
    pub(super) step_left: f64,
    pub(super) iteration: Iteration,
}

/// One placement at the minimum.
pub(super) struct FittedPlacement {
    pub(super) at: Unknowns,
    /// Of its frame, along the parent's axes.
    pub(super) covariance: Matrix6<f64>,
    /// Lengths, and in standard deviations.
    pub(super) residuals: Vec<(f64, f64)>,
}

impl FittedPlacement {
    /// Squared misfit of its touches.
    pub(super) fn chi_square(&self) -> f64 {
        self.residuals.iter().map(|(_, normalized)| normalized * normalized).sum()
    }
}

/// Descends from `starts`, and on to where rounding ends the steps.
pub(super) fn fit<const P: usize>(problems: &[Problem<'_>], shared: &[Extra], starts: Vec<Unknowns>) -> Fit {
    let bare: Vec<Extra> = shared.iter().map(|extra| Extra { prior: None, ..*extra }).collect();
    let models: Vec<Model<'_, P>> = problems.iter().map(|problem| Model::new(problem, &bare)).collect();
    let bundle = Bundle { models, shared };
    let descent = descend(&bundle, starts);
    let (at, arrow, steps) = settled(&bundle, descent.at);
    let reduced = arrow.reduced();
    let covariance = reduced.covariance();
    let step_left = arrow.damped_step(0.0).map_or(f64::INFINITY, |(_, decrease)| decrease.max(0.0).sqrt());
    let of_shared =
        SMatrix::<f64, P, P>::from_fn(|i, j| if i < 6 || j < 6 { 0.0 } else { covariance[(i - 6, j - 6)] });
    let placements = bundle.models.iter().zip(&at).zip(&arrow.roots).map(|((model, at), root)| {
        let touches = 0..model.problem.touches().len();
        FittedPlacement {
            at: *at,
            covariance: at.frame.to_parent_axes(&root.six_covariance(&of_shared)),
            residuals: touches.map(|index| model.residual(at, index)).collect(),
        }
    });
    Fit {
        shared: at[0].extras[..shared.len()].to_vec(),
        covariance,
        placements: placements.collect(),
        chi_square: arrow.chi_square,
        step_left,
        iteration: Iteration { steps: descent.steps + steps, stopped_by: "step" },
        reduced,
    }
}

/// Undamped steps from near a minimum until they no longer shrink: rounding. The last place, its linear problem, and how
/// many steps were made.
fn settled<const P: usize>(bundle: &Bundle<'_, P>, from: Vec<Unknowns>) -> (Vec<Unknowns>, Arrow<P>, usize) {
    /// Three or four are usual.
    const STEPS: usize = 30;
    let (mut at, mut last) = (from, f64::INFINITY);
    let mut arrow = bundle.linear(&at);
    if arrow.reduced().unseen() > 0 {
        // There is no undamped step along what is not seen.
        return (at, arrow, 0);
    }
    for count in 0..STEPS {
        let Some((step, _)) = arrow.damped_step(0.0) else { return (at, arrow, count) };
        let length = bundle.length(&step);
        if length.is_nan() || length >= last || length <= f64::EPSILON {
            return (at, arrow, count);
        }
        last = length;
        at = bundle.moved(&at, &step);
        arrow = bundle.linear(&at);
    }
    (at, arrow, STEPS)
}
