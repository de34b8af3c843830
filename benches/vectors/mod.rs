//! Peers that know vectors only: argmin's stock Gauss-Newton and the `levenberg-marquardt` crate.
//!
//! They get the twist that leads from a start to the frame, with exact derivatives, and what was computed for residuals is
//! kept for derivatives ([`Chart`]).

#![allow(dead_code)] // Each bench uses its own part.

use std::cell::RefCell;

use argmin::{
    core::{Error, Executor, IterState, Jacobian, Operator, State},
    solver::gaussnewton::GaussNewton,
};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{Vector3, Vector6};
use nalgebra_0_34::{
    DMatrix, DVector, DefaultAllocator, Dim, DimMax, DimMaximum, DimMin, OMatrix, OVector, SVector, U1, U6,
    allocator::{Allocator, Reallocator},
    storage::Owned,
};
use touchref::{Contact, Frame, Problem, Twist};

/// Steps the library allows itself.
pub(crate) const STEPS: u64 = 100;

/// A frame, and the steps that were tried on the way there.
pub(crate) struct End {
    pub(crate) frame: Frame,
    pub(crate) steps: u64,
}

/// By default it stops when the norm of the residuals changes by less than 1.5e-8: where that norm is one, a step of
/// 1.7e-4 standard deviations. The library stops at 1e-4.
pub(crate) fn by_gauss_newton(problem: &Problem<'_>, start: &Frame) -> Option<End> {
    let chart = Chart::new(problem, start);
    let result = Executor::new(OfVectors(RefCell::new(chart)), GaussNewton::new())
        .configure(|state: IterState<_, (), _, (), _, f64>| {
            state.param(DVector::zeros(6)).max_iters(STEPS).counting(false)
        })
        .ctrlc(false)
        .run()
        .ok()?;
    let twist = Vector6::from_column_slice(result.state().get_param()?.as_slice());
    Some(End { frame: start.moved(&Twist::from(twist)), steps: result.state().get_iter() })
}

/// With the library's own bounds on cost, step and gradient.
pub(crate) fn by_library_bounds() -> LevenbergMarquardt<f64> {
    LevenbergMarquardt::new().with_ftol(1e-8).with_xtol(1e-9).with_gtol(1e-12)
}

/// By the crate, with matrices of `D` rows: as many as there are touches.
pub(crate) fn by_levenberg_marquardt<D>(
    solver: &LevenbergMarquardt<f64>,
    problem: &Problem<'_>,
    start: &Frame,
) -> End
where
    D: DimMin<U6> + DimMax<U6>,
    DefaultAllocator: Allocator<D> + Allocator<D, U6> + Reallocator<f64, D, U6, DimMaximum<D, U6>, U6>,
{
    let (chart, report) = solver.minimize::<U6, D, _>(Chart::new(problem, start));
    End { frame: chart.frame, steps: report.number_of_evaluations as u64 - 1 }
}

/// Touches over a chart of the frames about a start, `x -> start.moved(x)`, seen from one `x`.
#[derive(Clone)]
pub(crate) struct Chart<'a> {
    problem: &'a Problem<'a>,
    start: Frame,
    x: [f64; 6],
    frame: Frame,
    contacts: Vec<Contact>,
}

impl<'a> Chart<'a> {
    pub(crate) fn new(problem: &'a Problem<'a>, start: &Frame) -> Self {
        let contacts = (0..problem.touches().len()).map(|index| problem.contact(start, index)).collect();
        Self { problem, start: *start, x: [0.0; 6], frame: *start, contacts }
    }

    #[expect(clippy::float_cmp, reason = "whether it is the very same place")]
    pub(crate) fn move_to(&mut self, x: &[f64]) {
        if self.x != x {
            self.x.copy_from_slice(x);
            self.frame = self.start.moved(&Twist::from(Vector6::from(self.x)));
            for (index, contact) in self.contacts.iter_mut().enumerate() {
                *contact = self.problem.contact(&self.frame, index);
            }
        }
    }

    /// In standard deviations.
    pub(crate) fn residual(&self, touch: usize) -> f64 {
        let contact = &self.contacts[touch];
        contact.residual / contact.sigma
    }

    /// Of each residual over `x = (v, w)`, one after the other.
    ///
    /// A change `(dv, dw)` of `x` moves the frame by the twist `(exp(-w) dv, J dw)` along its own axes, where
    /// `J = 1 - a [w] + b [w]^2`, `a = (1 - cos |w|) / |w|^2`, `b = (|w| - sin |w|) / |w|^3`, is the right Jacobian of
    /// rotations (Sola et al., "A micro Lie theory", equation 143).
    pub(crate) fn gradients(&self) -> impl Iterator<Item = [f64; 6]> {
        /// Below this square of an angle, the next term of the series of `b` is less than rounding.
        const SMALL: f64 = 1e-4;
        let w = Vector3::new(self.x[3], self.x[4], self.x[5]);
        let exp = self.start.rotation.matrix().tr_mul(self.frame.rotation.matrix());
        let square = w.norm_squared();
        let (a, b) = if square < SMALL {
            (
                0.5 - square / 24.0 + square * square / 720.0,
                1.0 / 6.0 - square / 120.0 + square * square / 5040.0,
            )
        } else {
            let (sine, cosine) = square.sqrt().sin_cos();
            ((1.0 - cosine) / square, (1.0 - sine / square.sqrt()) / square)
        };
        self.contacts.iter().map(move |contact| {
            let [x, y, z, rx, ry, rz] = contact.gradient();
            let (by_v, by_w) = (Vector3::new(x, y, z), Vector3::new(rx, ry, rz));
            let crossed = w.cross(&by_w);
            let by_v = exp * by_v / contact.sigma;
            let by_w = (by_w + a * crossed + b * w.cross(&crossed)) / contact.sigma;
            [by_v.x, by_v.y, by_v.z, by_w.x, by_w.y, by_w.z]
        })
    }

    fn vector<D: Dim>(&self) -> OVector<f64, D>
    where
        DefaultAllocator: Allocator<D>,
    {
        OVector::from_fn_generic(D::from_usize(self.contacts.len()), U1, |i, _| self.residual(i))
    }

    fn matrix<D: Dim, C: Dim>(&self) -> OMatrix<f64, D, C>
    where
        DefaultAllocator: Allocator<D, C>,
    {
        let mut matrix = OMatrix::zeros_generic(D::from_usize(self.contacts.len()), C::from_usize(6));
        for (i, gradient) in self.gradients().enumerate() {
            for (k, slope) in gradient.into_iter().enumerate() {
                matrix[(i, k)] = slope;
            }
        }
        matrix
    }
}

/// For argmin, which never says that it is still at the same `x`, and wants a Jacobian, its transpose and their product
/// to be of one type: matrices of fixed size will not do.
struct OfVectors<'a>(RefCell<Chart<'a>>);

impl Operator for OfVectors<'_> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;

    fn apply(&self, x: &DVector<f64>) -> Result<DVector<f64>, Error> {
        let mut chart = self.0.borrow_mut();
        chart.move_to(x.as_slice());
        Ok(chart.vector())
    }
}

impl Jacobian for OfVectors<'_> {
    type Param = DVector<f64>;
    type Jacobian = DMatrix<f64>;

    fn jacobian(&self, x: &DVector<f64>) -> Result<DMatrix<f64>, Error> {
        let mut chart = self.0.borrow_mut();
        chart.move_to(x.as_slice());
        Ok(chart.matrix())
    }
}

impl<D: Dim> LeastSquaresProblem<f64, D, U6> for Chart<'_>
where
    DefaultAllocator: Allocator<D> + Allocator<D, U6>,
{
    type ResidualStorage = Owned<f64, D>;
    type JacobianStorage = Owned<f64, D, U6>;
    type ParameterStorage = Owned<f64, U6>;

    fn set_params(&mut self, x: &SVector<f64, 6>) {
        self.move_to(x.as_slice());
    }

    fn params(&self) -> SVector<f64, 6> {
        self.x.into()
    }

    fn residuals(&self) -> Option<OVector<f64, D>> {
        Some(self.vector())
    }

    fn jacobian(&self) -> Option<OMatrix<f64, D, U6>> {
        Some(self.matrix())
    }
}
