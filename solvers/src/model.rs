//! The measurement model: whitened residuals of the touches, their derivatives, and the square root of the
//! information they carry.
//!
//! Unknowns are ordered `[extras.., translation, rotation]`: uncertain or measured dimensions of the fixture and the
//! tip radius first, then the frame's twist along the fixture's axes. In a triangular square root of the information
//! the last six rows and columns are then that of the frame alone, the extras marginalised.

use nalgebra::{Matrix3, Matrix3x6, Matrix6, Point3, SMatrix, Vector3, Vector6};
use touchref_core::{Contact, Frame, Problem, Twist};

/// An unknown besides the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extra {
    pub(crate) what: Quantity,
    /// Standard uncertainty of the nominal value; `None` for one that only the touches tell.
    pub(crate) prior: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Quantity {
    /// A dimension of the fixture, by index.
    Dimension(usize),
    TipRadius,
}

/// The most extras at once.
pub(crate) const MAX_EXTRAS: usize = 6;

/// A frame and the extras' deviations from their nominal values.
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    pub(crate) frame: Frame,
    pub(crate) extras: [f64; MAX_EXTRAS],
}

impl State {
    pub(crate) fn at(frame: Frame) -> Self {
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
}

/// One whitened observation: residual and gradient over standard deviation.
pub(crate) struct Row<const P: usize> {
    pub(crate) residual: f64,
    pub(crate) gradient: [f64; P],
}

/// Normal equations at a state: lower triangle of `J^T W J`, `J^T W r`, and `r^T W r`.
pub(crate) struct Normal<const P: usize> {
    pub(crate) matrix: [[f64; P]; P],
    pub(crate) gradient: [f64; P],
    pub(crate) chi_square: f64,
}

impl<'a, const P: usize> Model<'a, P> {
    /// `extras` must be `P - 6`, at most [`MAX_EXTRAS`].
    pub(crate) fn new(problem: &'a Problem<'a>, extras: &'a [Extra]) -> Self {
        debug_assert_eq!(extras.len() + 6, P);
        Self { problem, extras }
    }

    /// Residual of a touch as a length, extras counted in.
    #[inline]
    fn length(&self, state: &State, index: usize, contact: &Contact) -> f64 {
        let mut length = contact.residual;
        for (extra, value) in self.extras.iter().zip(&state.extras) {
            length += self.extra_gradient(extra, index, &contact.at) * value;
        }
        length
    }

    #[inline]
    fn extra_gradient(&self, extra: &Extra, index: usize, at: &Point3<f64>) -> f64 {
        match extra.what {
            Quantity::Dimension(dimension) => {
                let surface = self.problem.touches()[index].surface;
                self.problem.fixture().dimension_gradient(dimension, surface, at)
            }
            Quantity::TipRadius => -1.0,
        }
    }

    /// Residual of a touch as a length and in standard deviations.
    #[inline]
    pub(crate) fn residual(&self, state: &State, index: usize) -> (f64, f64) {
        let contact = self.problem.contact(&state.frame, index);
        let length = self.length(state, index, &contact);
        (length, length / contact.sigma)
    }

    /// The outward normal at a touch, in the parent.
    pub(crate) fn normal(&self, state: &State, index: usize) -> Vector3<f64> {
        state.frame.rotation * self.problem.contact(&state.frame, index).normal
    }

    #[inline]
    fn row(&self, state: &State, index: usize) -> Row<P> {
        let contact = self.problem.contact(&state.frame, index);
        let weight = 1.0 / contact.sigma;
        let mut gradient = [0.0; P];
        for (slot, extra) in gradient.iter_mut().zip(self.extras) {
            *slot = self.extra_gradient(extra, index, &contact.at) * weight;
        }
        for (slot, slope) in gradient[P - 6..].iter_mut().zip(contact.gradient()) {
            *slot = slope * weight;
        }
        Row { residual: self.length(state, index, &contact) * weight, gradient }
    }

    /// What the extras' stated uncertainties add: each prior is an observation.
    #[inline]
    fn prior_rows(&self, state: &State) -> impl Iterator<Item = Row<P>> + use<'a, P> {
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
    pub(crate) fn chi_square(&self, state: &State) -> f64 {
        let touches = (0..self.problem.touches().len()).map(|index| self.residual(state, index).1);
        let priors = self.prior_rows(state).map(|row| row.residual);
        touches.chain(priors).map(|r| r * r).sum()
    }

    #[inline]
    pub(crate) fn normal_equations(&self, state: &State) -> Normal<P> {
        let mut normal = Normal { matrix: [[0.0; P]; P], gradient: [0.0; P], chi_square: 0.0 };
        let mut add = |row: &Row<P>| {
            for i in 0..P {
                for j in 0..=i {
                    normal.matrix[i][j] += row.gradient[i] * row.gradient[j];
                }
                normal.gradient[i] += row.gradient[i] * row.residual;
            }
            normal.chi_square += row.residual * row.residual;
        };
        for index in 0..self.problem.touches().len() {
            add(&self.row(state, index));
        }
        self.prior_rows(state).for_each(|row| add(&row));
        normal
    }

    /// Upper triangular `r` with `r^T r = J^T W J`, and `q` with `r^T q = J^T W residuals`, by Givens rotations row by
    /// row: accurate where the normal equations would square the condition.
    pub(crate) fn square_root(&self, state: &State) -> SquareRoot<P> {
        let mut root = SquareRoot { r: [[0.0; P]; P], q: [0.0; P], left_over: 0.0 };
        for index in 0..self.problem.touches().len() {
            root.absorb(self.row(state, index));
        }
        self.prior_rows(state).for_each(|row| root.absorb(row));
        root
    }

    /// Second derivative of a touch's residual (in standard deviations) over the frame's twist; extras enter
    /// linearly.
    fn hessian(&self, state: &State, index: usize) -> Matrix6<f64> {
        let Contact { at, normal: n, sigma, .. } = self.problem.contact(&state.frame, index);
        let p = at.coords;
        let mut h = Matrix6::zeros();
        // A twist (v, w) moves p to exp(-w) (p - v): to second order by w x v + w x (w x p) / 2.
        let cross = n.cross_matrix();
        h.fixed_view_mut::<3, 3>(0, 3).copy_from(&cross);
        h.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross.transpose());
        let turning = (n * p.transpose() + p * n.transpose()) * 0.5 - Matrix3::identity() * n.dot(&p);
        h.fixed_view_mut::<3, 3>(3, 3).copy_from(&turning);
        // To first order p moves by -v - w x p = M (v, w), M = -[1, -[p]x].
        let touch = &self.problem.touches()[index];
        let mut moves = Matrix3x6::zeros();
        moves.fixed_view_mut::<3, 3>(0, 0).copy_from(&-Matrix3::identity());
        moves.fixed_view_mut::<3, 3>(0, 3).copy_from(&p.cross_matrix());
        let surface = &self.problem.fixture().surfaces()[touch.surface];
        h += moves.transpose() * surface.curvature_at(&at) * moves;
        h / sigma
    }

    /// Relative curvature: the Frobenius norm of the residuals' second derivative, in standard deviations, in
    /// coordinates in which the covariance is the identity. Proportional to the noise.
    pub(crate) fn curvature(&self, state: &State, root: &SquareRoot<P>) -> f64 {
        let Some(inverse) = root.inverse() else { return f64::INFINITY };
        let q = P - 6;
        let pose = SMatrix::<f64, 6, P>::from_fn(|i, j| inverse[q + i][j]);
        let squares = (0..self.problem.touches().len()).map(|index| {
            let whitened = pose.transpose() * self.hessian(state, index) * pose;
            whitened.norm_squared()
        });
        squares.sum::<f64>().sqrt()
    }
}

/// Triangular square root of the information.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SquareRoot<const P: usize> {
    r: [[f64; P]; P],
    q: [f64; P],
    /// Sum of squares that no unknown can take up: the linearised minimum.
    pub(crate) left_over: f64,
}

impl<const P: usize> SquareRoot<P> {
    fn absorb(&mut self, Row { residual: mut rest, gradient: mut row }: Row<P>) {
        for i in 0..P {
            if row[i] == 0.0 {
                continue;
            }
            let length = self.r[i][i].hypot(row[i]);
            let (c, s) = (self.r[i][i] / length, row[i] / length);
            for (mine, theirs) in self.r[i][i..].iter_mut().zip(&mut row[i..]) {
                (*mine, *theirs) = (c * *mine + s * *theirs, c * *theirs - s * *mine);
            }
            (self.q[i], rest) = (c * self.q[i] + s * rest, c * rest - s * self.q[i]);
        }
        self.left_over += rest * rest;
    }

    /// The inverse of `r`; `None` when a diagonal element is zero.
    #[allow(clippy::needless_range_loop)] // Triangular indices read as in the books.
    pub(crate) fn inverse(&self) -> Option<[[f64; P]; P]> {
        let mut inverse = [[0.0; P]; P];
        for j in 0..P {
            if self.r[j][j] == 0.0 {
                return None;
            }
            inverse[j][j] = 1.0 / self.r[j][j];
            for i in (0..j).rev() {
                let sum: f64 = (i + 1..=j).map(|k| self.r[i][k] * inverse[k][j]).sum();
                inverse[i][j] = -sum / self.r[i][i];
            }
        }
        inverse.iter().flatten().all(|v| v.is_finite()).then_some(inverse)
    }

    /// The Gauss-Newton step `-r^-1 q`.
    pub(crate) fn step(&self) -> Option<[f64; P]> {
        let inverse = self.inverse()?;
        Some(std::array::from_fn(|i| -(i..P).map(|j| inverse[i][j] * self.q[j]).sum::<f64>()))
    }

    /// Covariance of all unknowns.
    pub(crate) fn covariance(&self) -> Option<SMatrix<f64, P, P>> {
        let inverse = self.inverse()?;
        let inverse = SMatrix::<f64, P, P>::from_fn(|i, j| inverse[i][j]);
        Some(inverse * inverse.transpose())
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
            more => Err(touchref_core::SolveError::Unsupported {
                solver: "closed-form",
                reason: format!("{more} uncertain dimensions are more than {}", $crate::model::MAX_EXTRAS),
            }),
        }
    };
}
pub(crate) use with_unknowns;

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix6, Point3, Unit, Vector6};
    use touchref_core::{
        Extent, Fixture, Frame, Parameters, Probe, Problem, Requirement, Shape, Surface, Touch, Twist,
    };

    use super::{Extra, Model, Quantity, State};

    /// A cylinder, a cone, a sphere and a plane, with one made-up dimension.
    #[derive(Debug)]
    struct Everything {
        parameters: Parameters,
        surfaces: Vec<Surface>,
        requirement: Requirement,
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
            Self { parameters: Parameters::new(), surfaces, requirement: Requirement::counts(&[0; 4]) }
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
        fn dimension_gradient(&self, _: usize, surface: usize, _: &Point3<f64>) -> f64 {
            if surface == 0 { -1.0 } else { 0.0 }
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
        places.enumerate().map(|(k, at)| Touch::new(k % 4, at)).collect()
    }

    fn state() -> State {
        let frame = Frame::from_quaternion_xyzw(Point3::new(0.4, -0.3, 0.8), [0.1, -0.2, 0.3, 0.9]).unwrap();
        State::at(frame)
    }

    const EXTRAS: [Extra; 1] = [Extra { what: Quantity::Dimension(0), prior: Some(0.2) }];
    /// Central differences of step 1e-5: truncation 1e-10 of third derivatives below 10, rounding 1e-15 / step.
    const STEP: f64 = 1e-5;
    const TOLERANCE: f64 = 1e-7;

    #[test]
    fn gradients_are_those_of_central_differences() {
        let (fixture, touches) = (Everything::new(), touches());
        let probe = Probe { tip_radius: 0.5, tip_radius_u: 0.0, sigma: Some(0.3) };
        let problem = Problem::new(&fixture, &touches, probe).unwrap();
        let model = Model::<7>::new(&problem, &EXTRAS);
        for index in 0..touches.len() {
            let row = model.row(&state(), index);
            for k in 0..7 {
                let mut step = [0.0; 7];
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
        let (fixture, touches) = (Everything::new(), touches());
        let probe = Probe { tip_radius: 0.5, tip_radius_u: 0.0, sigma: Some(0.3) };
        let problem = Problem::new(&fixture, &touches, probe).unwrap();
        let model = Model::<6>::new(&problem, &[]);
        for index in 0..touches.len() {
            let hessian = model.hessian(&state(), index);
            let at = |v: Vector6<f64>| {
                let frame = state().frame.moved(&Twist::from(v));
                model.residual(&State::at(frame), index).1
            };
            let numeric = Matrix6::from_fn(|i, j| {
                let (a, b) = (Vector6::ith(i, STEP), Vector6::ith(j, STEP));
                (at(a + b) - at(a - b) - at(b - a) + at(-a - b)) / (4.0 * STEP * STEP)
            });
            assert!((hessian - numeric).abs().max() < TOLERANCE, "{index}: {}", hessian - numeric);
        }
    }

    #[test]
    fn the_square_root_is_that_of_the_normal_equations() {
        let (fixture, touches) = (Everything::new(), touches());
        let probe = Probe { tip_radius: 0.5, tip_radius_u: 0.0, sigma: Some(0.3) };
        let problem = Problem::new(&fixture, &touches, probe).unwrap();
        let model = Model::<7>::new(&problem, &EXTRAS);
        let (root, normal) = (model.square_root(&state()), model.normal_equations(&state()));
        for i in 0..7 {
            for j in 0..=i {
                let product: f64 = (0..7).map(|k| root.r[k][i] * root.r[k][j]).sum();
                assert!((product - normal.matrix[i][j]).abs() < 1e-12 * normal.matrix[i][i].abs().max(1.0));
            }
        }
        // Pythagoras: what the unknowns take up, and what is left over.
        let taken: f64 = root.q.iter().map(|q| q * q).sum();
        assert!((taken + root.left_over - normal.chi_square).abs() < 1e-10 * normal.chi_square);
        // The step solves the normal equations.
        let step = root.step().unwrap();
        for i in 0..7 {
            let product: f64 = (0..7)
                .map(|j| if j <= i { normal.matrix[i][j] } else { normal.matrix[j][i] } * step[j])
                .sum();
            assert!(
                (product + normal.gradient[i]).abs() < 1e-9 * normal.gradient[i].abs().max(1.0),
                "{i}: {product} {}",
                normal.gradient[i]
            );
        }
    }
}
