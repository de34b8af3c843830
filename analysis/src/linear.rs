//! A measurement to first order: what an error of each observation does to the frame, and how far the others check it.
//!
//! Observations are the touches, and the fixture's dimensions and the tip radius where an uncertainty of them is stated:
//! each of these is an unknown beside the frame, with what is stated as one more observation of it, as in the solver
//! `least-squares`. With `J` their Jacobian, each row over the standard deviation of its observation, errors `e` (in
//! standard deviations) move the unknowns by `-S e` and leave the residuals `Q e`:
//!
//! ```text
//! S = (J^T J)^-1 J^T      Q = I - J S
//! ```
//!
//! `S S^T` is the covariance of the unknowns, the diagonal of `Q` the redundancy numbers (W. Baarda, A testing procedure
//! for use in geodetic networks, 1968): 1 where an observation is checked wholly by the others, 0 where not at all.

use nalgebra::{DMatrix, DVector, Matrix3x6, Matrix6, Matrix6xX, Point3, Vector6};
use touchref_core::{Contact, Fixture, Frame, Problem, RANK_TOLERANCE, Twist, Unknown};

/// What tells of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Observation {
    /// A touch, by its index.
    Touch(usize),
    /// What is stated of a size of the fixture or of the tip.
    Stated(Unknown),
}

/// A measurement to first order at its maximum-likelihood frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    frame: Frame,
    observations: Vec<Observation>,
    sigmas: Vec<f64>,
    sensitivities: Matrix6xX<f64>,
    redundancy: DMatrix<f64>,
    residuals: DVector<f64>,
}

impl Linear {
    /// The measurement at `frame`, which must be that of least squared misfit; `None` where the touches leave a motion
    /// free that the fixture does not.
    ///
    /// Where no sigma is stated that of each touch is taken as 1, and stated uncertainties do not count.
    #[must_use]
    pub fn at(problem: &Problem<'_>, frame: &Frame) -> Option<Self> {
        let columns = Columns::of(problem);
        let Columns { uncertain, motions, .. } = &columns;
        let touches = problem.touches().len();
        let (count, sizes) = (touches + uncertain.len(), uncertain.len());
        let mut jacobian = DMatrix::zeros(count, columns.len());
        let mut misfits = DVector::zeros(count);
        let mut sigmas = Vec::with_capacity(count);
        for (index, touch) in problem.touches().iter().enumerate() {
            let contact = problem.contact(frame, index);
            for (column, slope) in columns.row(problem.fixture(), touch.surface, &contact).enumerate() {
                jacobian[(index, column)] = slope;
            }
            misfits[index] = contact.residual / contact.sigma;
            sigmas.push(contact.sigma);
        }
        for (column, (_, u)) in uncertain.iter().enumerate() {
            // What is stated less what it is: an error adds to it, as it does to the distance of a touch.
            jacobian[(touches + column, column)] = -1.0 / u;
            sigmas.push(*u);
        }
        let Projection { solution, redundancy } = Projection::of(jacobian)?;
        let mut sensitivities = Matrix6xX::zeros(count);
        for (row, motion) in motions.iter().enumerate() {
            sensitivities.set_row(*motion, &-solution.row(sizes + row));
        }
        for mut column in sensitivities.column_iter_mut() {
            let along_fixture = Twist::from(column.clone_owned());
            column.copy_from(&Vector6::from(along_fixture.turned(&frame.rotation)));
        }
        let touched = (0..touches).map(Observation::Touch);
        Some(Self {
            frame: *frame,
            observations: touched
                .chain(uncertain.iter().map(|(what, _)| Observation::Stated(*what)))
                .collect(),
            sigmas,
            sensitivities,
            residuals: &redundancy * misfits,
            redundancy,
        })
    }

    /// The frame.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The observations: the touches in input order, then the uncertain dimensions, then the tip radius.
    #[must_use]
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    /// Standard deviation of each observation: a length, or radians; of a touch 1 where no sigma is stated.
    #[must_use]
    pub fn sigmas(&self) -> &[f64] {
        &self.sigmas
    }

    /// How the frame moves with an error of one standard deviation of observation `index`: `x y z rx ry rz` along the
    /// parent's axes about the frame's origin. A touch errs along the outward normal of its surface, a size in what is
    /// stated of it.
    #[must_use]
    pub fn sensitivity(&self, index: usize) -> Vector6<f64> {
        self.sensitivities.column(index).into_owned()
    }

    /// Covariance of the frame, in the order and along the axes of [`sensitivity`](Self::sensitivity); zero along what the
    /// fixture leaves free. For touches of sigma 1 where none is stated.
    #[must_use]
    pub fn covariance(&self) -> Matrix6<f64> {
        Matrix6::from(&self.sensitivities * self.sensitivities.transpose())
    }

    /// What of each observation's error, in its standard deviations, the residuals show: `Q`, in the order of the
    /// observations.
    #[must_use]
    pub fn redundancy(&self) -> &DMatrix<f64> {
        &self.redundancy
    }

    /// Residual of each observation at the minimum, in its standard deviations: positive where the touch lies outside its
    /// surface, or where more is stated than is estimated.
    #[must_use]
    pub fn residuals(&self) -> &DVector<f64> {
        &self.residuals
    }
}

/// How a point of the fixture, in fixture coordinates, moves with the frame's `x y z rx ry rz` along the parent's axes
/// about its origin.
#[must_use]
pub fn lever(frame: &Frame, point: &Point3<f64>) -> Matrix3x6<f64> {
    let arm = frame.rotation * point.coords;
    let mut lever = Matrix3x6::identity();
    lever.fixed_columns_mut::<3>(3).copy_from(&(-arm.cross_matrix()));
    lever
}

/// The unknowns of a measurement, a column of the Jacobian each: uncertain sizes and tip, then the motions along the
/// fixture's axes that it does not leave free.
#[derive(Debug)]
pub(crate) struct Columns {
    /// Sizes and tip, and what is stated of each: its standard uncertainty.
    pub(crate) uncertain: Vec<(Unknown, f64)>,
    /// Indices of the motions, in the order of a twist.
    pub(crate) motions: Vec<usize>,
    nominal: Vec<f64>,
}

impl Columns {
    pub(crate) fn of(problem: &Problem<'_>) -> Self {
        let freedom = problem.fixture().freedom();
        Self {
            uncertain: problem.uncertain().collect(),
            motions: (0..6).filter(|motion| !freedom.is_free(*motion)).collect(),
            nominal: problem.fixture().dimensions().iter().map(|known| known.value).collect(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.uncertain.len() + self.motions.len()
    }

    /// How the distance of a touch, in its standard deviations, grows with each of the unknowns.
    pub(crate) fn row(
        &self,
        fixture: &dyn Fixture,
        surface: usize,
        contact: &Contact,
    ) -> impl Iterator<Item = f64> {
        let sizes = self.uncertain.iter().map(move |(unknown, _)| match unknown {
            Unknown::Dimension(dimension) => {
                fixture.dimension_gradient(*dimension, surface, &contact.at, &self.nominal)
            }
            Unknown::TipRadius => -1.0,
        });
        let gradient = contact.gradient();
        let motions = self.motions.iter().map(move |motion| gradient[*motion]);
        sizes.chain(motions).map(|slope| slope / contact.sigma)
    }
}

/// What the rows of a Jacobian tell of its columns' unknowns: `S` and `Q`.
struct Projection {
    solution: DMatrix<f64>,
    redundancy: DMatrix<f64>,
}

impl Projection {
    /// `None` where some unknown is not seen.
    fn of(mut jacobian: DMatrix<f64>) -> Option<Self> {
        let (rows, columns) = jacobian.shape();
        if rows < columns {
            return None;
        }
        // Lengths and angles are of different sizes.
        let scales: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
        // Of a column that no touch sees nothing but what is no number would be left, and its singular values never end.
        if !scales.iter().all(|scale| scale.is_normal()) {
            return None;
        }
        for (mut column, scale) in jacobian.column_iter_mut().zip(&scales) {
            column /= *scale;
        }
        let (q, r) = jacobian.qr().unpack();
        let singular = r.clone().singular_values();
        if singular.min() <= RANK_TOLERANCE * singular.max() {
            return None;
        }
        let mut solution = r.solve_upper_triangular(&q.transpose())?;
        for (mut row, scale) in solution.row_iter_mut().zip(&scales) {
            row /= *scale;
        }
        let redundancy = DMatrix::identity(rows, rows) - &q * q.transpose();
        Some(Self { solution, redundancy })
    }
}
