//! The measurement model: whitened residuals of the touches, their derivatives, and the square root of the
//! information they carry.
//!
//! Unknowns are ordered `[extras.., translation, rotation]`: uncertain or measured dimensions of the fixture and the
//! tip radius first, then the frame's twist along the fixture's axes. In a triangular square root of the information
//! the last six rows and columns are then that of the frame alone, the extras marginalised.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector6};
use touchref_core::{Contact, Frame, Freedom, MAX_DIMENSIONS, Noise, Problem, Shape, Twist, Unknown};

/// Runs `$body` for `$i` from zero to the constant `$count`, each time with a constant `$i`: the compiler leaves loops of
/// this size rolled, and their triangular inner loops with them.
macro_rules! unrolled {
    ($i:ident in $count:ident => $body:block) => {
        unrolled!(@ $i $count $body 0 1 2 3 4 5 6 7 8 9 10 11 12)
    };
    (@ $i:ident $count:ident $body:block $($constant:literal)*) => {
        $(if $constant < $count {
            let $i: usize = $constant;
            $body
        })*
    };
}
pub(crate) use unrolled;

/// An unknown besides the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extra {
    /// What it is.
    pub what: Unknown,
    /// Standard uncertainty of its nominal value; `None` for one that only the touches tell.
    pub prior: Option<f64>,
}

/// The most extras at once: six dimensions and the tip radius.
pub const MAX_EXTRAS: usize = 7;

/// Dimensions and tip radius whose stated uncertainty makes them unknowns with priors.
///
/// Without a stated sigma of touches there is nothing to weigh them against, and they are taken as exact.
#[must_use]
pub fn uncertain(problem: &Problem<'_>) -> Vec<Extra> {
    problem.uncertain().map(|(what, u)| Extra { what, prior: Some(u) }).collect()
}

/// A frame, and how far the extras deviate from their nominal values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unknowns {
    /// The frame.
    pub frame: Frame,
    /// The extras' deviations, in their order; the rest zero.
    pub extras: [f64; MAX_EXTRAS],
}

impl Unknowns {
    /// A frame, all extras at their nominal values.
    #[must_use]
    pub fn at(frame: Frame) -> Self {
        Self { frame, extras: [0.0; MAX_EXTRAS] }
    }

    /// Moved by a step in the unknowns.
    #[inline]
    pub(crate) fn moved<const P: usize>(&self, step: &[f64; P]) -> Self {
        let q = P - 6;
        let mut extras = self.extras;
        for (extra, step) in extras.iter_mut().zip(&step[..q]) {
            *extra += step;
        }
        let pose = Vector6::from_column_slice(&step[q..]);
        Self { frame: self.frame.moved(&Twist::from(pose)), extras }
    }
}

/// The model of one problem with `P` unknowns, six of them the frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Model<'a, const P: usize> {
    pub(crate) problem: &'a Problem<'a>,
    extras: &'a [Extra],
    /// Nominal values of the fixture's dimensions, where some of them are unknowns.
    nominal: Option<[f64; MAX_DIMENSIONS]>,
    /// Motions of the frame that are no unknowns.
    freedom: Freedom,
}

/// One whitened observation: residual and gradient over standard deviation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<const P: usize> {
    pub(crate) residual: f64,
    pub(crate) gradient: [f64; P],
}

/// Normal equations: upper triangle of `J^T W J`, `J^T W r`, and `r^T W r`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Normal<const P: usize> {
    pub(crate) matrix: [[f64; P]; P],
    pub(crate) gradient: [f64; P],
    pub(crate) chi_square: f64,
}

impl<const P: usize> Normal<P> {
    pub(crate) const NOTHING: Self = Self { matrix: [[0.0; P]; P], gradient: [0.0; P], chi_square: 0.0 };

    #[expect(
        clippy::inline_always,
        reason = "in every evaluation of every solver: a call costs as much as it does"
    )]
    #[inline(always)]
    pub(crate) fn add(&mut self, row: &Row<P>) {
        unrolled!(i in P => {
            for j in i..P {
                self.matrix[i][j] += row.gradient[i] * row.gradient[j];
            }
            self.gradient[i] += row.gradient[i] * row.residual;
        });
        self.chi_square += row.residual * row.residual;
    }

    /// Largest cosine between the residuals and a column of the Jacobian.
    #[inline]
    pub(crate) fn cosine(&self) -> f64 {
        let square = |i: usize| self.gradient[i] * self.gradient[i] / self.matrix[i][i];
        // A column of zeros is seen by no touch; its quotient is no number, and `max` passes it by.
        ((0..P).map(square).fold(0.0, f64::max) / self.chi_square).sqrt()
    }
}

impl<'a, const P: usize> Model<'a, P> {
    /// `extras` must be `P - 6`, at most [`MAX_EXTRAS`].
    pub(crate) fn new(problem: &'a Problem<'a>, extras: &'a [Extra]) -> Self {
        debug_assert_eq!(extras.len() + 6, P);
        let varies = extras.iter().any(|extra| matches!(extra.what, Unknown::Dimension(_)));
        let nominal = varies.then(|| {
            let mut values = [0.0; MAX_DIMENSIONS];
            for (value, dimension) in values.iter_mut().zip(problem.fixture().dimensions()) {
                *value = dimension.value;
            }
            values
        });
        Self { problem, extras, nominal, freedom: problem.fixture().freedom() }
    }

    pub(crate) fn extras(&self) -> &'a [Extra] {
        self.extras
    }

    /// Values of the fixture's dimensions in a state, where some of them are unknowns.
    #[inline]
    fn dimensions(&self, state: &Unknowns) -> Option<[f64; MAX_DIMENSIONS]> {
        if P == 6 {
            return None;
        }
        let mut values = self.nominal?;
        for (extra, deviation) in self.extras.iter().zip(&state.extras) {
            if let Unknown::Dimension(dimension) = extra.what {
                values[dimension] += deviation;
            }
        }
        Some(values)
    }

    /// The geometry of a touch's surface, where dimensions have these values instead of their nominal ones.
    fn shape(&self, index: usize, values: Option<&[f64]>) -> Shape {
        let (fixture, surface) = (self.problem.fixture(), self.problem.touches()[index].surface);
        match values {
            Some(values) => fixture.shape_with(surface, values),
            None => fixture.surfaces()[surface].shape.clone(),
        }
    }

    /// A touch as the fixture of the state sees it, uncertain dimensions and tip counted in.
    #[expect(
        clippy::inline_always,
        reason = "in every evaluation of every solver: a call costs as much as it does"
    )]
    #[inline(always)]
    fn contact(&self, state: &Unknowns, index: usize) -> Contact {
        let mut contact = match self.dimensions(state) {
            None => self.problem.contact(&state.frame, index),
            Some(values) => self.problem.contact_with(&state.frame, index, &self.shape(index, Some(&values))),
        };
        for (extra, deviation) in self.extras[..P - 6].iter().zip(&state.extras) {
            if extra.what == Unknown::TipRadius {
                contact.residual -= deviation;
            }
        }
        contact
    }

    /// Residual of a touch as a length and in standard deviations.
    #[inline]
    pub(crate) fn residual(&self, state: &Unknowns, index: usize) -> (f64, f64) {
        let contact = self.contact(state, index);
        (contact.residual, contact.residual / contact.sigma)
    }

    #[expect(
        clippy::inline_always,
        reason = "in every evaluation of every solver: a call costs as much as it does"
    )]
    #[inline(always)]
    fn row(&self, state: &Unknowns, index: usize) -> Row<P> {
        let contact = self.contact(state, index);
        let weight = 1.0 / contact.sigma;
        let mut gradient = [0.0; P];
        if let Some(values) = self.dimensions(state) {
            let surface = self.problem.touches()[index].surface;
            for (slot, extra) in gradient.iter_mut().zip(self.extras) {
                if let Unknown::Dimension(dimension) = extra.what {
                    let fixture = self.problem.fixture();
                    *slot = fixture.dimension_gradient(dimension, surface, &contact.at, &values) * weight;
                }
            }
        }
        for (slot, extra) in gradient.iter_mut().zip(&self.extras[..P - 6]) {
            if extra.what == Unknown::TipRadius {
                *slot = -weight;
            }
        }
        for (slot, slope) in gradient[P - 6..].iter_mut().zip(contact.gradient()) {
            *slot = slope * weight;
        }
        let mut row = Row { residual: contact.residual * weight, gradient };
        if let Noise::Covariance(covariance) = &self.problem.touches()[index].noise {
            self.let_sigma_vary(&mut row, state, index, &contact, covariance);
        }
        if self.freedom != Freedom::NONE {
            self.leave_free(&mut row.gradient);
        }
        row
    }

    /// Of a gradient over all unknowns, what the fixture leaves free: nothing but rounding.
    #[cold]
    fn leave_free(&self, gradient: &mut [f64; P]) {
        for (k, slope) in gradient[P - 6..].iter_mut().enumerate() {
            if self.freedom.is_free(k) {
                *slope = 0.0;
            }
        }
    }

    /// A touch with a covariance is as sure as that says along the normal, so its sigma turns with the frame: the
    /// whitened residual `d / s` grows by `dd / s - d ds / s^2`.
    #[cold]
    fn let_sigma_vary(
        &self,
        row: &mut Row<P>,
        state: &Unknowns,
        index: usize,
        contact: &Contact,
        covariance: &Matrix3<f64>,
    ) {
        /// Of the central difference over a dimension, in parts of its nominal value.
        const STEP: f64 = 1e-6;
        let Contact { at, normal, sigma, .. } = *contact;
        let rotation = state.frame.rotation.matrix();
        let (p, values) = (at.coords, self.dimensions(state));
        let shape = self.shape(index, values.as_ref().map(<[f64; MAX_DIMENSIONS]>::as_slice));
        // With k = C m along the fixture's axes, s ds = k . dm. A twist (v, w) turns the normal by w x n and moves p, seen
        // from the fixture, by -v - w x p.
        let k = rotation.tr_mul(&(covariance * (rotation * normal)));
        let bent = shape.curvature_at(&at) * k;
        let turn = normal.cross(&k) - p.cross(&bent);
        let by_twist = [-bent.x, -bent.y, -bent.z, turn.x, turn.y, turn.z];
        let scale = -row.residual / (sigma * sigma);
        for (slot, slope) in row.gradient[P - 6..].iter_mut().zip(by_twist) {
            *slot += scale * slope;
        }
        let Some(values) = values else { return };
        for (slot, extra) in row.gradient.iter_mut().zip(self.extras) {
            if let Unknown::Dimension(dimension) = extra.what {
                let step = STEP * values[dimension];
                let normal_with = |by: f64| {
                    let mut values = values;
                    values[dimension] += by;
                    self.shape(index, Some(&values)).seen_from(&at).normal
                };
                let turned = (normal_with(step) - normal_with(-step)) / (2.0 * step);
                *slot += scale * k.dot(&turned);
            }
        }
    }

    /// What the extras' stated uncertainties add: each prior is an observation.
    #[inline]
    fn prior_rows(&self, state: &Unknowns) -> impl Iterator<Item = Row<P>> + use<'a, P> {
        let values = state.extras;
        self.extras.iter().enumerate().filter_map(move |(k, extra)| {
            let u = extra.prior?;
            let mut gradient = [0.0; P];
            gradient[k] = 1.0 / u;
            Some(Row { residual: values[k] / u, gradient })
        })
    }

    /// Sum of squares of the whitened residuals, priors included.
    #[inline]
    pub(crate) fn chi_square(&self, state: &Unknowns) -> f64 {
        let mut sum = 0.0;
        for index in 0..self.problem.touches().len() {
            let (_, normalized) = self.residual(state, index);
            sum += normalized * normalized;
        }
        self.prior_rows(state).for_each(|row| sum += row.residual * row.residual);
        sum
    }

    #[inline]
    pub(crate) fn normal_equations(&self, state: &Unknowns) -> Normal<P> {
        const TOGETHER: usize = 4;
        let mut normal = Normal::NOTHING;
        // A few touches at a time, so that their square roots and divisions do not wait for each other.
        let count = self.problem.touches().len();
        let mut rows = [Row { residual: 0.0, gradient: [0.0; P] }; TOGETHER];
        for first in (0..count).step_by(TOGETHER) {
            let together = &mut rows[..TOGETHER.min(count - first)];
            for (k, row) in together.iter_mut().enumerate() {
                *row = self.row(state, first + k);
            }
            for row in together {
                normal.add(row);
            }
        }
        self.prior_rows(state).for_each(|row| normal.add(&row));
        if self.freedom != Freedom::NONE {
            self.hold_free(&mut normal.matrix);
        }
        normal
    }

    /// Lets no step move what the fixture leaves free.
    #[cold]
    fn hold_free(&self, matrix: &mut [[f64; P]; P]) {
        for k in (0..6).filter(|k| self.freedom.is_free(*k)) {
            let held = P - 6 + k;
            for row in &mut *matrix {
                row[held] = 0.0;
            }
            matrix[held] = [0.0; P];
            matrix[held][held] = 1.0;
        }
    }

    /// The same with the whole second derivative of the squared misfit, halved, in the place of `J^T W J`.
    pub(crate) fn newton_equations(&self, state: &Unknowns) -> Normal<P> {
        let mut newton = self.normal_equations(state);
        for index in 0..self.problem.touches().len() {
            let (_, residual) = self.residual(state, index);
            for (row, bends) in newton.matrix.iter_mut().zip(self.hessian(state, index)) {
                for (sum, bend) in row.iter_mut().zip(bends) {
                    *sum += residual * bend;
                }
            }
        }
        if self.freedom != Freedom::NONE {
            self.hold_free(&mut newton.matrix);
        }
        newton
    }

    /// Half the slope of the squared misfit.
    pub(crate) fn gradient(&self, state: &Unknowns) -> [f64; P] {
        let mut sum = [0.0; P];
        let mut add = |row: &Row<P>| {
            for (sum, slope) in sum.iter_mut().zip(row.gradient) {
                *sum += slope * row.residual;
            }
        };
        for index in 0..self.problem.touches().len() {
            add(&self.row(state, index));
        }
        self.prior_rows(state).for_each(|row| add(&row));
        sum
    }

    /// Upper triangular `r` with `r^T r = J^T W J`, and `q` with `r^T q = J^T W residuals`, by Householder reflections
    /// of a block of rows at a time: accurate where the normal equations would square the condition.
    pub(crate) fn square_root(&self, state: &Unknowns) -> SquareRoot<P> {
        self.square_root_of(state, |gradient| *gradient)
    }

    /// The same with the unknowns in the order `[translation, rotation, extras..]`: the last rows are the information
    /// about the extras, the frame eliminated.
    pub(crate) fn square_root_frame_first(&self, state: &Unknowns) -> SquareRoot<P> {
        self.square_root_of(state, |gradient| {
            let mut gradient = *gradient;
            gradient.rotate_left(P - 6);
            gradient
        })
    }

    #[inline]
    fn square_root_of(&self, state: &Unknowns, ordered: impl Fn(&[f64; P]) -> [f64; P]) -> SquareRoot<P> {
        let mut root = SquareRoot { r: [[0.0; P]; P], q: [0.0; P], freedom: self.freedom };
        let (mut block, mut rows) = (Block::EMPTY, 0);
        let mut take = |row: &Row<P>| {
            block.set(rows, &Row { gradient: ordered(&row.gradient), ..*row });
            rows += 1;
            if rows == ROWS {
                root.absorb(&mut block);
                (block, rows) = (Block::EMPTY, 0);
            }
        };
        for index in 0..self.problem.touches().len() {
            take(&self.row(state, index));
        }
        self.prior_rows(state).for_each(|row| take(&row));
        if rows > 0 {
            root.absorb(&mut block);
        }
        root
    }

    /// Second derivative of a touch's residual (in standard deviations) over all unknowns; its sigma is taken not to
    /// turn with the frame.
    #[allow(clippy::needless_range_loop)] // A matrix, symmetric by columns.
    fn hessian(&self, state: &Unknowns, index: usize) -> [[f64; P]; P] {
        let q = P - 6;
        let Contact { at, normal, sigma, .. } = self.contact(state, index);
        let (n, p) = (normal, at.coords);
        let values = self.dimensions(state);
        let shape = self.shape(index, values.as_ref().map(<[f64; MAX_DIMENSIONS]>::as_slice));
        // A twist (v, w) moves p to exp(-w) (p - v): to first order by -v - w x p, which the surface's curvature K sees,
        // and to second order by w x v + w x (w x p) / 2, which the normal sees.
        let (k, cross) = (shape.curvature_at(&at), p.cross_matrix());
        let bent = k * cross;
        let moving = n.cross_matrix() - bent;
        let turning = (n * p.transpose() + p * n.transpose()) * 0.5 - Matrix3::identity() * n.dot(&p)
            + cross.tr_mul(&bent);
        let mut hessian = [[0.0; P]; P];
        for i in 0..3 {
            for j in 0..3 {
                hessian[q + i][q + j] = k[(i, j)] / sigma;
                hessian[q + i][P - 3 + j] = moving[(i, j)] / sigma;
                hessian[P - 3 + j][q + i] = moving[(i, j)] / sigma;
                hessian[P - 3 + i][P - 3 + j] = turning[(i, j)] / sigma;
            }
        }
        for extra in 0..q {
            let bends = self.bends_with(state, index, extra);
            for (i, bend) in bends.into_iter().enumerate() {
                (hessian[i][extra], hessian[extra][i]) = (bend, bend);
            }
        }
        hessian
    }

    /// How fast the whitened gradient of a touch changes with an extra, by central differences: a dimension may move a
    /// surface, and so bend its distance.
    fn bends_with(&self, state: &Unknowns, index: usize, extra: usize) -> [f64; P] {
        /// In parts of the nominal value: truncation 1e-10, rounding 1e-11.
        const STEP: f64 = 1e-5;
        let (Unknown::Dimension(dimension), Some(nominal)) = (self.extras[extra].what, self.nominal) else {
            // A tip's radius enters linearly.
            return [0.0; P];
        };
        let step = STEP * nominal[dimension];
        let gradient_at = |by: f64| {
            let mut moved = *state;
            moved.extras[extra] += by;
            self.row(&moved, index).gradient
        };
        let (up, down) = (gradient_at(step), gradient_at(-step));
        std::array::from_fn(|i| (up[i] - down[i]) / (2.0 * step))
    }

    /// Relative curvature: the Frobenius norm of the residuals' second derivative, in standard deviations, in
    /// coordinates in which the covariance is the identity. Proportional to the noise.
    pub(crate) fn curvature(&self, state: &Unknowns, root: &SquareRoot<P>) -> f64 {
        let Some(inverse) = root.inverse() else { return f64::INFINITY };
        let covariance: [[f64; P]; P] = std::array::from_fn(|i| {
            std::array::from_fn(|j| inverse[i].iter().zip(&inverse[j]).map(|(a, b)| a * b).sum())
        });
        // Of W^T H W, W being the inverse and C = W W^T: the trace of its square is that of (H C)^2.
        let square = |index: usize| {
            let product = self.hessian(state, index).map(|row| {
                let mut sum = [0.0; P];
                for (factor, covariances) in row.iter().zip(&covariance) {
                    for (sum, value) in sum.iter_mut().zip(covariances) {
                        *sum += factor * value;
                    }
                }
                sum
            });
            let trace = |i: usize| (0..P).map(|j| product[i][j] * product[j][i]).sum::<f64>();
            (0..P).map(trace).sum::<f64>()
        };
        (0..self.problem.touches().len()).map(square).sum::<f64>().sqrt()
    }
}

/// Rows of a block: as many as one call reflects at once.
const ROWS: usize = 8;

/// In four sums side by side, which the compiler works on at once.
#[inline]
fn dot(a: &[f64; ROWS], b: &[f64; ROWS]) -> f64 {
    let [s0, s1, s2, s3] = std::array::from_fn(|k| a[k] * b[k] + a[k + 4] * b[k + 4]);
    (s0 + s2) + (s1 + s3)
}

/// Some whitened observations, by columns; what is missing is zero.
struct Block<const P: usize> {
    gradients: [[f64; ROWS]; P],
    residuals: [f64; ROWS],
}

impl<const P: usize> Block<P> {
    const EMPTY: Self = Self { gradients: [[0.0; ROWS]; P], residuals: [0.0; ROWS] };

    #[inline]
    fn set(&mut self, index: usize, row: &Row<P>) {
        for (column, slope) in self.gradients.iter_mut().zip(&row.gradient) {
            column[index] = *slope;
        }
        self.residuals[index] = row.residual;
    }
}

/// Triangular square root of the information.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SquareRoot<const P: usize> {
    pub(crate) r: [[f64; P]; P],
    pub(crate) q: [f64; P],
    /// Motions of the frame whose rows and columns are zero.
    freedom: Freedom,
}

impl<const P: usize> SquareRoot<P> {
    /// Squared length of a column of the Jacobian.
    pub(crate) fn column_square(&self, column: usize) -> f64 {
        self.r.iter().map(|row| row[column] * row[column]).sum()
    }

    /// Half the slope of the squared misfit.
    pub(crate) fn gradient(&self) -> [f64; P] {
        std::array::from_fn(|column| (0..=column).map(|row| self.r[row][column] * self.q[row]).sum())
    }

    /// The step of the first six unknowns, the frame, that minimises the misfit once the others have made theirs; `None` where it is
    /// not determined.
    pub(crate) fn six_after(&self, others: &[f64; P]) -> Option<[f64; P]> {
        let mut step = *others;
        for i in (0..6).rev().filter(|i| !self.freedom.is_free(*i)) {
            let known: f64 = (i + 1..P).map(|j| self.r[i][j] * step[j]).sum();
            step[i] = -(self.q[i] + known) / self.r[i][i];
        }
        step.iter().all(|v| v.is_finite()).then_some(step)
    }

    /// Covariance of the first six unknowns, where that of the others is known.
    pub(crate) fn six_covariance(&self, others: &SMatrix<f64, P, P>) -> Matrix6<f64> {
        // A motion that the fixture leaves free has nothing to do with the others, and no variance.
        let seen = |i: usize, j: usize| f64::from(u8::from(i == j && !self.freedom.is_free(i)));
        let r = Matrix6::from_fn(|i, j| if i == j && self.freedom.is_free(i) { 1.0 } else { self.r[i][j] });
        let border = SMatrix::<f64, 6, P>::from_fn(|i, j| if j < 6 { 0.0 } else { self.r[i][j] });
        let (Some(inverse), Some(border)) =
            (r.solve_upper_triangular(&Matrix6::from_fn(seen)), r.solve_upper_triangular(&border))
        else {
            return Matrix6::repeat(f64::INFINITY);
        };
        inverse * inverse.transpose() + border * others * border.transpose()
    }

    /// With Marquardt's `damping` of the first six unknowns.
    pub(crate) fn with_six_damped(&self, damping: f64) -> Self {
        let mut block = Block::EMPTY;
        for column in 0..6 {
            block.gradients[column][column] = (damping * self.column_square(column)).sqrt();
        }
        let mut damped = *self;
        damped.absorb(&mut block);
        damped
    }

    /// Takes in a block of observations: column by column, a reflection that turns the block's part into nothing and
    /// leaves a positive diagonal.
    #[allow(clippy::needless_range_loop)] // Triangular indices read as in the books.
    fn absorb(&mut self, block: &mut Block<P>) {
        for i in 0..P {
            let mut reflected = block.gradients[i];
            let square = dot(&reflected, &reflected);
            let before = self.r[i][i];
            let diagonal = (before * before + square).sqrt();
            // `before - diagonal`, without cancellation.
            let first = -square / (before + diagonal);
            let (scale, factor) = if square == 0.0 { (0.0, 0.0) } else { (1.0 / first, -first / diagonal) };
            for v in &mut reflected {
                *v *= scale;
            }
            let reflect = |mine: &mut f64, theirs: &mut [f64; ROWS]| {
                let by = factor * (*mine + dot(&reflected, theirs));
                *mine -= by;
                for (v, along) in theirs.iter_mut().zip(&reflected) {
                    *v -= by * along;
                }
            };
            self.r[i][i] = diagonal;
            for j in i + 1..P {
                reflect(&mut self.r[i][j], &mut block.gradients[j]);
            }
            reflect(&mut self.q[i], &mut block.residuals);
        }
    }

    /// Whether an unknown is a motion that the fixture leaves free.
    fn is_free(&self, unknown: usize) -> bool {
        unknown >= P - 6 && self.freedom.is_free(unknown + 6 - P)
    }

    /// The inverse of `r`, zero where the fixture leaves a motion free; `None` when another diagonal element is zero.
    #[allow(clippy::needless_range_loop)] // Triangular indices read as in the books.
    pub(crate) fn inverse(&self) -> Option<[[f64; P]; P]> {
        let mut inverse = [[0.0; P]; P];
        for j in 0..P {
            if self.is_free(j) {
                continue;
            }
            if self.r[j][j] == 0.0 {
                return None;
            }
            inverse[j][j] = 1.0 / self.r[j][j];
            for i in (0..j).rev().filter(|i| !self.is_free(*i)) {
                let sum: f64 = (i + 1..=j).map(|k| self.r[i][k] * inverse[k][j]).sum();
                inverse[i][j] = -sum / self.r[i][i];
            }
        }
        inverse.iter().flatten().all(|v| v.is_finite()).then_some(inverse)
    }

    /// The Gauss-Newton step `-r^-1 q`; `None` where an unknown is free.
    pub(crate) fn step(&self) -> Option<[f64; P]> {
        self.step_to(&self.q)
    }

    /// The step `-r^-1 r^-T gradient`.
    pub(crate) fn step_against(&self, gradient: &[f64; P]) -> Option<[f64; P]> {
        let mut q = *gradient;
        for i in (0..P).filter(|i| !self.is_free(*i)) {
            q[i] /= self.r[i][i];
            for j in i + 1..P {
                q[j] -= self.r[i][j] * q[i];
            }
        }
        self.step_to(&q)
    }

    /// `-r^-1 q`.
    fn step_to(&self, q: &[f64; P]) -> Option<[f64; P]> {
        let mut step = [0.0; P];
        for i in (0..P).rev().filter(|i| !self.is_free(*i)) {
            let known: f64 = (i + 1..P).map(|j| self.r[i][j] * step[j]).sum();
            step[i] = -(q[i] + known) / self.r[i][i];
        }
        step.iter().all(|v| v.is_finite()).then_some(step)
    }

    /// Length of that step in standard deviations.
    pub(crate) fn step_in_deviations(&self) -> f64 {
        self.q.iter().map(|q| q * q).sum::<f64>().sqrt()
    }

    /// Covariance of all unknowns.
    pub(crate) fn covariance(&self) -> Option<SMatrix<f64, P, P>> {
        let inverse = self.inverse()?;
        let inverse = SMatrix::<f64, P, P>::from_fn(|i, j| inverse[i][j]);
        Some(inverse * inverse.transpose())
    }

    /// Covariance of the frame alone, along the parent's axes about its origin.
    pub(crate) fn frame_covariance(&self, frame: &Frame) -> Option<Matrix6<f64>> {
        let inverse = self.inverse()?;
        let q = P - 6;
        let inverse = Matrix6::from_fn(|i, j| inverse[q + i][q + j]);
        Some(frame.to_parent_axes(&(inverse * inverse.transpose())))
    }

    /// The square root of the information of the frame, extras marginalised; over its twist along the fixture's axes.
    pub(crate) fn of_frame(&self) -> Matrix6<f64> {
        let q = P - 6;
        Matrix6::from_fn(|i, j| self.r[q + i][q + j])
    }

    /// The step of all unknowns that a motion of the frame takes with it: the extras follow as the touches want.
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn with_extras(&self, motion: &Vector6<f64>) -> [f64; P] {
        let q = P - 6;
        let mut step = [0.0; P];
        step[q..].copy_from_slice(motion.as_slice());
        for i in (0..q).rev() {
            let sum: f64 = (i + 1..P).map(|j| self.r[i][j] * step[j]).sum();
            step[i] = if self.r[i][i] == 0.0 { 0.0 } else { -sum / self.r[i][i] };
        }
        step
    }
}

/// Runs `$body` with the constant `$unknowns` set to six plus a number of extras that is known at run time only.
macro_rules! with_unknowns {
    ($extras:expr, $unknowns:ident => $body:expr) => {
        match $extras {
            0 => {
                const $unknowns: usize = 6;
                $body
            }
            1 => {
                const $unknowns: usize = 7;
                $body
            }
            2 => {
                const $unknowns: usize = 8;
                $body
            }
            3 => {
                const $unknowns: usize = 9;
                $body
            }
            4 => {
                const $unknowns: usize = 10;
                $body
            }
            5 => {
                const $unknowns: usize = 11;
                $body
            }
            6 => {
                const $unknowns: usize = 12;
                $body
            }
            7 => {
                const $unknowns: usize = 13;
                $body
            }
            more => Err(touchref_core::SolveError::Unsupported {
                solver: "built-in",
                reason: format!("{more} uncertain dimensions are more than {}", $crate::model::MAX_EXTRAS),
            }),
        }
    };
}
pub(crate) use with_unknowns;

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Point3, Unit};
    use touchref_core::{
        Dimension, Extent, Fixture, Frame, Noise, Parameters, Probe, Problem, Requirement, Shape, Surface,
        Touch, Unknown,
    };

    use super::{Extra, Model, Unknowns};

    /// A cylinder, a cone, a sphere and a plane; the one dimension is the cone's half-angle.
    #[derive(Debug)]
    struct Everything {
        parameters: Parameters,
        surfaces: Vec<Surface>,
        requirement: Requirement,
        dimensions: [Dimension; 1],
    }

    impl Everything {
        fn new() -> Self {
            let axis = Unit::new_normalize(nalgebra::Vector3::new(0.3, -0.2, 0.9));
            let extent = Extent::Disc { radius: 1.0 };
            let point = Point3::new(1.0, -2.0, 0.5);
            let shapes = [
                Shape::Cylinder { point, axis, radius: 4.0, bore: false },
                Shape::Cone { apex: point, axis, half_angle: 0.4, bore: true },
                Shape::Sphere { center: Point3::new(4.0, 3.0, -2.0), radius: 3.0, bore: false },
                Shape::Plane { point, normal: nalgebra::Vector3::x_axis() },
            ];
            let surfaces = shapes.map(|shape| Surface::new("s", shape, extent)).to_vec();
            Self {
                parameters: Parameters::new(),
                surfaces,
                requirement: Requirement::counts(&[0; 4]),
                dimensions: [Dimension {
                    name: "half_angle".into(),
                    value: 0.4,
                    u: 0.2,
                    quantity: touchref_core::Quantity::Angle,
                }],
            }
        }
    }

    impl Fixture for Everything {
        fn kind(&self) -> &'static str {
            "everything"
        }
        fn parameters(&self) -> &Parameters {
            &self.parameters
        }
        fn surfaces(&self) -> &[Surface] {
            &self.surfaces
        }
        fn requirement(&self) -> &Requirement {
            &self.requirement
        }
        fn size(&self) -> f64 {
            4.0
        }
        fn dimensions(&self) -> &[Dimension] {
            &self.dimensions
        }
        fn shape_with(&self, surface: usize, values: &[f64]) -> Shape {
            match self.surfaces[surface].shape {
                Shape::Cone { apex, axis, bore, .. } => {
                    Shape::Cone { apex, axis, half_angle: values[0], bore }
                }
                ref other => other.clone(),
            }
        }
        fn dimension_gradient(&self, _: usize, surface: usize, at: &Point3<f64>, values: &[f64]) -> f64 {
            let Shape::Cone { apex, axis, .. } = self.surfaces[surface].shape else { return 0.0 };
            let height = axis.dot(&(at - apex));
            let rho = (at - apex - *axis * height).norm();
            rho * values[0].sin() + height * values[0].cos()
        }
        fn nominal_layout(&self) -> Vec<(usize, Point3<f64>)> {
            Vec::new()
        }
    }

    fn touches() -> Vec<Touch> {
        let places = (0..12).map(|k| {
            let k = f64::from(k);
            Point3::new(9.0 * (1.3 * k).sin(), 8.0 * (2.1 * k).cos(), 5.0 + 6.0 * (0.7 * k).sin())
        });
        places
            .enumerate()
            .map(|(k, at)| {
                let touch = Touch::new(k % 4, at);
                // One of each surface is surer along some directions than along others.
                let unsure = Matrix3::new(0.09, 0.02, 0.0, 0.02, 0.4, -0.03, 0.0, -0.03, 0.2);
                if k < 4 { touch.with_covariance(unsure) } else { touch }
            })
            .collect()
    }

    /// Touches that are as sure in every direction.
    fn plain_touches() -> Vec<Touch> {
        touches().into_iter().map(|touch| Touch { noise: Noise::OfProbe, ..touch }).collect()
    }

    fn state() -> Unknowns {
        let frame = Frame::from_quaternion_xyzw(Point3::new(0.4, -0.3, 0.8), [0.1, -0.2, 0.3, 0.9]).unwrap();
        let mut state = Unknowns::at(frame);
        (state.extras[0], state.extras[1]) = (0.05, -0.02);
        state
    }

    const EXTRAS: [Extra; 2] = [
        Extra { what: Unknown::Dimension(0), prior: Some(0.2) },
        Extra { what: Unknown::TipRadius, prior: Some(0.1) },
    ];
    /// Central differences of step 1e-5: truncation 1e-10 of third derivatives below 10, rounding 1e-15 / step.
    const STEP: f64 = 1e-5;
    const TOLERANCE: f64 = 1e-7;

    #[test]
    fn gradients_are_those_of_central_differences() {
        let (fixture, touches) = (Everything::new(), touches());
        let probe = Probe { tip_radius: 0.5, tip_radius_u: 0.0, sigma: Some(0.3) };
        let problem = Problem::new(&fixture, &touches, probe).unwrap();
        let model = Model::<8>::new(&problem, &EXTRAS);
        for index in 0..touches.len() {
            let row = model.row(&state(), index);
            for k in 0..8 {
                let mut step = [0.0; 8];
                step[k] = STEP;
                let up = model.residual(&state().moved(&step), index).1;
                let down = model.residual(&state().moved(&step.map(|s| -s)), index).1;
                assert!(((up - down) / (2.0 * STEP) - row.gradient[k]).abs() < TOLERANCE, "{index} {k}");
            }
        }
    }

    #[test]
    fn hessians_are_those_of_central_differences() {
        /// Second differences of step 1e-4: rounding 1e-15 / step^2.
        const STEP: f64 = 1e-4;
        const TOLERANCE: f64 = 1e-6;
        let (fixture, touches) = (Everything::new(), plain_touches());
        let probe = Probe { tip_radius: 0.5, tip_radius_u: 0.0, sigma: Some(0.3) };
        let problem = Problem::new(&fixture, &touches, probe).unwrap();
        let model = Model::<8>::new(&problem, &EXTRAS);
        for index in 0..touches.len() {
            let hessian = model.hessian(&state(), index);
            let at = |i: usize, by_i: f64, j: usize, by_j: f64| {
                let mut step = [0.0; 8];
                step[i] += by_i * STEP;
                step[j] += by_j * STEP;
                model.residual(&state().moved(&step), index).1
            };
            for (i, row) in hessian.iter().enumerate() {
                for (j, stated) in row.iter().enumerate() {
                    let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
                    let mixed: f64 = corners.iter().map(|(a, b)| a * b * at(i, *a, j, *b)).sum();
                    let numeric = mixed / (4.0 * STEP * STEP);
                    assert!((stated - numeric).abs() < TOLERANCE, "{index} {i} {j}: {numeric}");
                }
            }
        }
    }

    #[test]
    fn the_square_root_is_that_of_the_normal_equations() {
        let (fixture, touches) = (Everything::new(), touches());
        let probe = Probe { tip_radius: 0.5, tip_radius_u: 0.0, sigma: Some(0.3) };
        let problem = Problem::new(&fixture, &touches, probe).unwrap();
        let model = Model::<8>::new(&problem, &EXTRAS);
        let (root, normal) = (model.square_root(&state()), model.normal_equations(&state()));
        for i in 0..8 {
            for j in i..8 {
                let product: f64 = (0..8).map(|k| root.r[k][i] * root.r[k][j]).sum();
                assert!((product - normal.matrix[i][j]).abs() < 1e-12 * normal.matrix[i][i].abs().max(1.0));
            }
        }
        // The step solves the normal equations.
        let step = root.step().unwrap();
        for i in 0..8 {
            let product: f64 = (0..8)
                .map(|j| if j >= i { normal.matrix[i][j] } else { normal.matrix[j][i] } * step[j])
                .sum();
            assert!(
                (product + normal.gradient[i]).abs() < 1e-9 * normal.gradient[i].abs().max(1.0),
                "{i}: {product} {}",
                normal.gradient[i]
            );
        }
    }
}
