//! Reference data: touches that do not fit, and the frame that fits them best, known beforehand.
//!
//! Simulated noise tells whether a solver is right on average; reference data tell whether it is right, to rounding,
//! on every single set. The method is that of the null space: A. B. Forbes and H. D. Minh, "Generation of numerical
//! artefacts for geometric form and tolerance assessment", International Journal of Metrology and Quality Engineering 3 (2012), the way in
//! which reference pairs for the testing of CMM software after ISO 10360-6 are made.
//!
//! # Mathematics
//!
//! Let the touches lie on the surfaces exactly when the fixture stands at its design frame, and let `J` be the
//! Jacobian there: how fast the signed distance of each touch grows with the frame's six motions, and with the
//! dimensions that are unknown, too. Move each touch along its surface's normal by `r_i`. Its signed distance is now
//! `r_i`, and its row of `J` is what it was: the normal does not change along itself, and neither does `p x n`. So with
//! weights `W = diag(1 / sigma_i^2)` the gradient of half the squared misfit at the design frame is `J^T W r`, and
//! where `r` is chosen with
//!
//! ```text
//! J^T W r = 0
//! ```
//!
//! the design frame is a stationary point **exactly, for residuals of any size**. There are as many independent such
//! `r` as touches beyond the unknowns; a random one is drawn: normal numbers, less what the columns of `J` take up of
//! them.
//!
//! # Where the stationary point is the minimum
//!
//! The second derivative of half the squared misfit is `J^T W J + sum_i r_i / sigma_i^2 H_i`, `H_i` that of distance
//! `i`. The first term is positive; the second grows with the residuals beside the surfaces' radii of curvature and the
//! distance of the touches from the axis of a turn, and can outweigh the first in the directions that the layout sees
//! weakly. [`ReferenceMeasurement::steepness`] is the least eigenvalue of the whole in coordinates in which the first
//! term is the identity: one without residuals, zero where the minimum is lost. Sets below [`LEAST_STEEPNESS`] are not
//! handed out. Whether another minimum, far away, is lower still is not asked.

use nalgebra::{DMatrix, DVector, Point3, Vector6};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use touchref_core::{Fixture, Frame, Probe, Problem, Quantity, Shape, Touch, Twist, Unknown};

/// Least [`steepness`](ReferenceMeasurement::steepness) of a set that is handed out: rounding moves its minimum at
/// most ten times as far as it would without residuals.
pub const LEAST_STEEPNESS: f64 = 0.1;

/// Condition from which on the weakest motion is seen by rounding alone.
const MOST_CONDITION: f64 = 1e12;
/// A touch whose residual is not what it was moved by, to this part of the fixture's size, has crossed an axis or a
/// centre.
const CROSSED: f64 = 1e-9;

/// How large residuals are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Magnitude {
    /// The largest of them, a length.
    Largest(f64),
    /// Their root mean square, a length.
    RootMeanSquare(f64),
}

/// What reference data are made of.
#[derive(Debug, Clone, Copy)]
pub struct NullSpace<'a> {
    /// The fixture.
    pub fixture: &'a dyn Fixture,
    /// Where it is touched: surface index and contact point (on the surface, in fixture coordinates).
    pub layout: &'a [(usize, Point3<f64>)],
    /// Standard deviation of each touch, in the order of the layout; empty where they are as sure as the probe.
    pub sigmas: &'a [f64],
    /// The probe.
    pub probe: Probe,
    /// The design frame.
    pub frame: Frame,
    /// What else a solver may estimate without the frame leaving the design frame.
    pub unknowns: &'a [Unknown],
    /// How large the residuals are.
    pub magnitude: Magnitude,
}

/// Touches whose least-squares frame is known.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceMeasurement {
    /// The touches: tip centres in the parent.
    pub touches: Vec<Touch>,
    /// Their least-squares frame.
    pub frame: Frame,
    /// Their residuals there, lengths.
    pub residuals: Vec<f64>,
    /// Largest over smallest singular value of the weighted Jacobian there, over all unknowns; angles scaled by the
    /// fixture's [`size`](Fixture::size).
    pub condition: f64,
    /// How much of its steepness the minimum has kept, between [`LEAST_STEEPNESS`] and, mostly, one: see
    /// [the module](self#where-the-stationary-point-is-the-minimum).
    pub steepness: f64,
}

impl NullSpace<'_> {
    /// A random set: the residuals' direction is uniform over the null space, in standard deviations of the touches.
    ///
    /// `None` where there are no touches beyond the unknowns, the numbers do not make a problem, the layout leaves an
    /// unknown free, or the residuals are so large that the design frame is no minimum (see
    /// [the module](self#where-the-stationary-point-is-the-minimum)).
    #[must_use]
    pub fn draw(&self, rng: &mut impl Rng) -> Option<ReferenceMeasurement> {
        let exact = self.touches(&Frame::identity(), &vec![0.0; self.layout.len()])?;
        let problem = Problem::new(self.fixture, &exact, self.probe).ok()?;
        let misfit = Misfit::new(&problem, self.unknowns)?;
        let rows = misfit.rows(&misfit.start(&Frame::identity()));
        let condition = rows.condition();
        if condition > MOST_CONDITION || rows.jacobian.nrows() == rows.jacobian.ncols() {
            return None;
        }
        let taken_up = rows.jacobian.svd(true, false).u?;

        let mut whitened = DVector::from_fn(exact.len(), |_, _| rng.sample::<f64, _>(StandardNormal));
        // Once leaves rounding times the condition of the projection; twice is enough.
        for _ in 0..2 {
            let within = taken_up.tr_mul(&whitened);
            whitened -= &taken_up * within;
        }
        let sigma = |index: usize| problem.contact(&Frame::identity(), index).sigma;
        let residuals = DVector::from_fn(exact.len(), |index, _| whitened[index] * sigma(index));
        let scale = match self.magnitude {
            Magnitude::Largest(length) => length / residuals.amax(),
            Magnitude::RootMeanSquare(length) => length * (exact.len() as f64).sqrt() / residuals.norm(),
        };
        let residuals: Vec<f64> = residuals.iter().map(|r| r * scale).collect();

        let moved = self.touches(&Frame::identity(), &residuals)?;
        let problem = Problem::new(self.fixture, &moved, self.probe).ok()?;
        let stays = |(index, wanted): (usize, &f64)| {
            let got = problem.contact(&Frame::identity(), index).residual;
            (got - wanted).abs() <= CROSSED * self.fixture.size()
        };
        if !residuals.iter().enumerate().all(stays) {
            return None;
        }
        let misfit = Misfit::new(&problem, self.unknowns)?;
        let steepness = misfit.steepness(&misfit.start(&Frame::identity()))?;
        if steepness < LEAST_STEEPNESS {
            return None;
        }
        let touches = self.touches(&self.frame, &residuals)?;
        Some(ReferenceMeasurement { touches, frame: self.frame, residuals, condition, steepness })
    }

    /// The touches when the fixture stands at `frame` and each is off its surface by `residuals`; `None` where a surface
    /// does not exist.
    fn touches(&self, frame: &Frame, residuals: &[f64]) -> Option<Vec<Touch>> {
        let touch = |(index, (surface, contact)): (usize, &(usize, Point3<f64>))| {
            let reach = self.probe.tip_radius + residuals[index];
            let at = self.fixture.surfaces().get(*surface)?.tip_center(contact, reach);
            let touch = Touch::new(*surface, frame.to_parent(&at));
            Some(self.sigmas.get(index).map_or(touch, |sigma| touch.with_sigma(*sigma)))
        };
        self.layout.iter().enumerate().map(touch).collect()
    }
}

/// A local minimum of the squared misfit.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The frame.
    pub frame: Frame,
    /// How far the other unknowns are from their nominal values.
    pub deviations: Vec<f64>,
    /// Squared misfit over the variance; over one where no sigma is stated.
    pub chi_square: f64,
}

/// Descends from `start` to a minimum of the squared misfit, which it finds to rounding.
///
/// For tests, plain rather than fast: Newton's method with the whole second derivative (its second term by central
/// differences), damped where it is not positive or does not lead downhill. It shares no code with the solvers. What
/// is stated of the unknowns' uncertainties takes no part, and a touch's sigma is taken as it is at each place.
///
/// `None` where it does not settle, or settles where the second derivative is not positive, or an unknown does not exist.
#[must_use]
pub fn descend(problem: &Problem<'_>, unknowns: &[Unknown], start: &Frame) -> Option<Minimum> {
    /// Sound starts need five to ten.
    const STEPS: usize = 200;
    /// Damping where none did not do, and the factor by which it grows and shrinks.
    const DAMPING: f64 = 1e-6;
    const GROWTH: f64 = 10.0;
    /// Damping at which a step no longer changes anything.
    const MOST_DAMPING: f64 = 1e12;
    /// A step this short (parts of the fixture's size) leaves a thousandth of rounding after two more.
    const SHORT: f64 = 1e-6;
    const LAST_STEPS: usize = 3;

    let misfit = Misfit::new(problem, unknowns)?;
    let mut state = misfit.start(start);
    let mut damping = 0.0;
    for _ in 0..STEPS {
        let rows = misfit.rows(&state);
        let second = misfit.second_derivative(&state, &rows);
        let next = loop {
            if damping > MOST_DAMPING {
                break None;
            }
            let step = rows.step(&second, damping);
            let moved = step.map(|step| (misfit.moved(&state, &step), step.norm()));
            match moved.filter(|(moved, _)| misfit.rows(moved).chi_square() <= rows.chi_square()) {
                Some(downhill) => break Some(downhill),
                None => damping = DAMPING.max(damping * GROWTH),
            }
        };
        let settled = next.as_ref().is_none_or(|(_, length)| *length <= SHORT * misfit.size());
        if let Some((moved, _)) = next {
            state = moved;
            damping = if damping > DAMPING { damping / GROWTH } else { 0.0 };
        }
        if settled {
            for _ in 0..LAST_STEPS {
                let rows = misfit.rows(&state);
                let step = rows.step(&misfit.second_derivative(&state, &rows), 0.0)?;
                state = misfit.moved(&state, &step);
            }
            let chi_square = misfit.rows(&state).chi_square();
            return Some(Minimum { frame: state.frame, deviations: state.deviations, chi_square });
        }
    }
    None
}

/// Largest over smallest singular value of the weighted Jacobian over the frame and `unknowns`, angles scaled by the
/// fixture's size; infinite where the touches leave one of them free, or one does not exist.
#[must_use]
pub fn condition(problem: &Problem<'_>, unknowns: &[Unknown], frame: &Frame) -> f64 {
    condition_at(problem, unknowns, frame, vec![0.0; unknowns.len()])
}

/// The same where the unknowns are so far from their nominal values.
pub(crate) fn condition_at(
    problem: &Problem<'_>,
    unknowns: &[Unknown],
    frame: &Frame,
    deviations: Vec<f64>,
) -> f64 {
    let misfit = Misfit::new(problem, unknowns);
    misfit.map_or(f64::INFINITY, |misfit| misfit.rows(&State { frame: *frame, deviations }).condition())
}

/// A frame, and how far the other unknowns are from their nominal values.
#[derive(Debug, Clone)]
struct State {
    frame: Frame,
    deviations: Vec<f64>,
}

/// The squared misfit of a problem over the frame and other unknowns. Angles are scaled by the fixture's size, so that
/// all steps are lengths; the frame comes first.
struct Misfit<'a> {
    problem: &'a Problem<'a>,
    unknowns: &'a [Unknown],
}

/// Whitened residuals, and how fast they grow with the unknowns.
struct Rows {
    jacobian: DMatrix<f64>,
    residuals: DVector<f64>,
}

impl<'a> Misfit<'a> {
    /// `None` where an unknown does not exist.
    fn new(problem: &'a Problem<'a>, unknowns: &'a [Unknown]) -> Option<Self> {
        let dimensions = problem.fixture().dimensions().len();
        let exists = |unknown: &Unknown| match unknown {
            Unknown::Dimension(index) => *index < dimensions,
            Unknown::TipRadius => true,
        };
        unknowns.iter().all(exists).then_some(Self { problem, unknowns })
    }

    fn size(&self) -> f64 {
        self.problem.fixture().size()
    }

    fn start(&self, frame: &Frame) -> State {
        State { frame: *frame, deviations: vec![0.0; self.unknowns.len()] }
    }

    /// What a scaled unknown is to be multiplied by: a length is itself, an angle a part of the fixture's size.
    fn scale(&self, unknown: Unknown) -> f64 {
        let dimensions = self.problem.fixture().dimensions();
        match unknown {
            Unknown::Dimension(index) if dimensions[index].quantity == Quantity::Angle => 1.0 / self.size(),
            _ => 1.0,
        }
    }

    fn moved(&self, state: &State, step: &DVector<f64>) -> State {
        let mut pose: Vector6<f64> = step.fixed_rows::<6>(0).into();
        pose.fixed_rows_mut::<3>(3).scale_mut(1.0 / self.size());
        let others = self.unknowns.iter().zip(step.iter().skip(6)).zip(&state.deviations);
        State {
            frame: state.frame.moved(&Twist::from(pose)),
            deviations: others.map(|((unknown, step), old)| old + step * self.scale(*unknown)).collect(),
        }
    }

    fn rows(&self, state: &State) -> Rows {
        let fixture = self.problem.fixture();
        let mut values: Vec<f64> = fixture.dimensions().iter().map(|dimension| dimension.value).collect();
        let mut wider_tip = 0.0;
        for (unknown, deviation) in self.unknowns.iter().zip(&state.deviations) {
            match unknown {
                Unknown::Dimension(index) => values[*index] += deviation,
                Unknown::TipRadius => wider_tip += deviation,
            }
        }
        let touches = self.problem.touches();
        let mut rows = Rows {
            jacobian: DMatrix::zeros(touches.len(), 6 + self.unknowns.len()),
            residuals: DVector::zeros(touches.len()),
        };
        for (index, touch) in touches.iter().enumerate() {
            let shape: Shape = if self.unknowns.is_empty() {
                fixture.surfaces()[touch.surface].shape.clone()
            } else {
                fixture.shape_with(touch.surface, &values)
            };
            let contact = self.problem.contact_with(&state.frame, index, &shape);
            rows.residuals[index] = (contact.residual - wider_tip) / contact.sigma;
            for (column, slope) in contact.gradient().into_iter().enumerate() {
                let scale = if column < 3 { 1.0 } else { 1.0 / self.size() };
                rows.jacobian[(index, column)] = slope * scale / contact.sigma;
            }
            for (k, unknown) in self.unknowns.iter().enumerate() {
                let slope = match unknown {
                    Unknown::Dimension(dimension) => {
                        fixture.dimension_gradient(*dimension, touch.surface, &contact.at, &values)
                    }
                    Unknown::TipRadius => -1.0,
                };
                rows.jacobian[(index, 6 + k)] = slope * self.scale(*unknown) / contact.sigma;
            }
        }
        rows
    }

    /// The second derivative of half the squared misfit, by central differences of `J^T residuals` with the residuals
    /// held fast: what rounding does is small beside the first term.
    fn second_derivative(&self, state: &State, rows: &Rows) -> DMatrix<f64> {
        /// Parts of the fixture's size: truncation 1e-10 of a fourth derivative below 1, rounding 1e-15 / step.
        const STEP: f64 = 1e-5;
        let step = STEP * self.size();
        let count = rows.jacobian.ncols();
        let mut bending = DMatrix::zeros(count, count);
        for k in 0..count {
            let by = DVector::from_fn(count, |row, _| if row == k { step } else { 0.0 });
            let [up, down] = [&by, &-&by].map(|by| self.rows(&self.moved(state, by)).jacobian);
            bending.set_column(k, &((up - down).tr_mul(&rows.residuals) / (2.0 * step)));
        }
        rows.jacobian.tr_mul(&rows.jacobian) + 0.5 * (&bending + bending.transpose())
    }

    /// The least eigenvalue of the second derivative where its first term is the identity; `None` where that is
    /// singular.
    fn steepness(&self, state: &State) -> Option<f64> {
        let rows = self.rows(state);
        let lower = rows.jacobian.tr_mul(&rows.jacobian).cholesky()?.l();
        let half = lower.solve_lower_triangular(&self.second_derivative(state, &rows))?;
        let whitened = lower.solve_lower_triangular(&half.transpose())?;
        Some(whitened.symmetric_eigenvalues().min())
    }
}

impl Rows {
    fn chi_square(&self) -> f64 {
        self.residuals.norm_squared()
    }

    fn condition(&self) -> f64 {
        // The decomposition would never settle on numbers that are not finite.
        let finite = self.jacobian.iter().all(|v| v.is_finite());
        if !finite || self.jacobian.nrows() < self.jacobian.ncols() {
            return f64::INFINITY;
        }
        let singular = self.jacobian.singular_values();
        if singular.min() > 0.0 { singular.max() / singular.min() } else { f64::INFINITY }
    }

    /// Newton's step under this second derivative, its diagonal raised by `damping` of that of the first term; `None`
    /// where that is not positive.
    fn step(&self, second: &DMatrix<f64>, damping: f64) -> Option<DVector<f64>> {
        let mut damped = second.clone();
        for k in 0..damped.ncols() {
            damped[(k, k)] += damping * self.jacobian.column(k).norm_squared();
        }
        let step = -damped.cholesky()?.solve(&self.jacobian.tr_mul(&self.residuals));
        step.iter().all(|v| v.is_finite()).then_some(step)
    }
}
