//! Has the fixture moved? Frames of one fixture, found at different times, held against each other.
//!
//! The motion between two frames is small beside its uncertainty, or it is not: its squared Mahalanobis distance, in the
//! covariance of the difference, is chi-square with one degree of freedom for each motion that the fixture does not leave
//! free, when nothing has moved. Where a sigma was not stated but taken from the residuals, it is an F-ratio instead. What
//! both frames owe to the same cause, such as an error of the tip's radius, is the same in both as far as they were
//! touched alike, and only the rest of it is uncertain.
//!
//! [`Comparison`] tells whether there was a motion; [`explain`], whether all of the fixture made it or one surface.

use nalgebra::{
    DMatrix, DVector, Matrix3, Matrix3x6, Matrix6, MatrixXx6, Point3, Rotation3, Vector3, Vector6,
};
use thiserror::Error;
use touchref_core::{
    Fixture, Frame, Freedom, RANK_TOLERANCE, Twist, Unknown,
    statistics::{chi_square_level, chi_square_p_value, f_level, f_p_value},
};

use crate::{Estimate, Linear, Observation};

mod explanation;

pub use explanation::{Explanation, Hypothesis, Seen, explain};

/// Chance of a false alarm, where none is given: one comparison in a thousand of a fixture that stands still.
pub const ALPHA: f64 = 1e-3;

/// A frame as one measurement found it, and where its uncertainty comes from.
///
/// Covariances and effects are over `x y z rx ry rz` along the parent's axes about the fixture's origin.
#[derive(Debug, Clone, PartialEq)]
pub struct Located {
    /// The frame.
    pub frame: Frame,
    /// Covariance of what is its own: the noise of its touches.
    pub own: Matrix6<f64>,
    /// What one standard uncertainty of each cause does to it that is common to all measurements, in the same order for
    /// all; none where all of the covariance counts as its own.
    pub common: Vec<Vector6<f64>>,
    /// The noise that `own` stands on, where the residuals tell it.
    pub estimated: Option<Scatter>,
}

/// How sure the touches are, as residuals tell it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Standard deviation of one touch.
    pub sigma: f64,
    /// Degrees of freedom of the residuals, at least one.
    pub degrees_of_freedom: usize,
}

impl Scatter {
    /// Whether two estimates are hardly of one noise: the F-test of two variances, at [`ALPHA`].
    #[must_use]
    pub fn differs_from(self, other: Self) -> bool {
        let (more, less) = if self.sigma > other.sigma { (self, other) } else { (other, self) };
        let ratio = (more.sigma / less.sigma).powi(2);
        let p = f_p_value(ratio, more.degrees_of_freedom, less.degrees_of_freedom);
        // Either may be the larger.
        p.is_some_and(|p| 2.0 * p < ALPHA)
    }
}

impl Located {
    /// A frame whose covariance is all its own.
    #[must_use]
    pub fn independent(frame: Frame, covariance: Matrix6<f64>, estimated: Option<Scatter>) -> Self {
        Self { frame, own: covariance, common: Vec::new(), estimated }
    }

    /// Covariance from all causes.
    #[must_use]
    pub fn covariance(&self) -> Matrix6<f64> {
        self.common.iter().fold(self.own, |sum, effect| sum + effect * effect.transpose())
    }

    /// The same, its noise being that of `scatter`.
    fn rescaled(&self, scatter: Scatter) -> Self {
        let ratio = self.estimated.map_or(1.0, |own| scatter.sigma / own.sigma);
        Self { own: self.own * (ratio * ratio), estimated: Some(scatter), ..self.clone() }
    }
}

/// Why frames cannot be held against each other.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DriftError {
    /// The covariance is not positive, or not finite, beyond what the fixture leaves free.
    #[error("the covariance of the motion is singular, so that its significance cannot be told")]
    Singular,
    /// There is no frame to hold others against.
    #[error("there is no frame to hold others against")]
    NoBaseline,
}

/// Frames of one fixture that are held against each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// What of a frame does not count.
    freedom: Freedom,
}

/// What frames that should be one frame come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Baseline {
    /// Their mean, weighted by the inverse of their covariance.
    pub located: Located,
    /// Whether they are one frame; `None` for a single one.
    pub agreement: Option<Significance>,
}

/// A motion from one frame to another, and its covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Where it starts, in the parent.
    pub from: Frame,
    /// Translation of the fixture's origin and rotation vector, along the parent's axes; nothing of what the fixture
    /// leaves free.
    pub motion: Twist,
    /// Covariance of that.
    pub covariance: Matrix6<f64>,
    /// How sure it is that there is any.
    pub significance: Significance,
    /// How sure it is that any of it is a turn; `None` where every turn is free.
    pub turned: Option<Significance>,
}

/// How far something is from nothing, beside its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Significance {
    /// Squared Mahalanobis distance.
    pub squared_distance: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Degrees of freedom of the noise, where the residuals tell it: the distance is then an F-ratio times
    /// `degrees_of_freedom`.
    pub of_noise: Option<usize>,
}

impl Significance {
    /// The chance of a larger distance if there is nothing.
    ///
    /// With estimated noise, the F-test of a linear hypothesis (Seber and Lee, Linear Regression Analysis, 2003, theorem
    /// 4.1): exact to first order where all noise is of one estimate, and at most the stated rate of false alarms where
    /// only part of it is.
    #[must_use]
    pub fn p_value(&self) -> Option<f64> {
        let (distance, degrees) = (self.squared_distance, self.degrees_of_freedom);
        match self.of_noise {
            None => chi_square_p_value(distance, degrees),
            Some(of_noise) => f_p_value(distance / degrees as f64, degrees, of_noise),
        }
    }

    /// The squared distance that nothing exceeds with chance `alpha`.
    #[must_use]
    pub fn limit(&self, alpha: f64) -> f64 {
        let degrees = self.degrees_of_freedom;
        match self.of_noise {
            None => chi_square_level(alpha, degrees),
            Some(of_noise) => degrees as f64 * f_level(alpha, degrees, of_noise),
        }
    }

    /// Whether there is something, with the chance `alpha` of saying so where there is nothing.
    #[must_use]
    pub fn exceeds(&self, alpha: f64) -> bool {
        self.p_value().is_none_or(|p| p < alpha)
    }
}

/// How far a point has moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Displacement {
    /// From where to where, along the parent's axes.
    pub vector: Vector3<f64>,
    /// Covariance of that.
    pub covariance: Matrix3<f64>,
}

impl Displacement {
    /// Its length, and the standard uncertainty along its direction; the largest of any direction where it is zero.
    #[must_use]
    pub fn length(&self) -> Estimate {
        length(&self.vector, &self.covariance)
    }
}

impl Change {
    /// How far the fixture's origin has moved.
    #[must_use]
    pub fn shift(&self) -> Estimate {
        length(&self.motion.translation, &self.covariance.fixed_view::<3, 3>(0, 0).into())
    }

    /// By which angle the fixture has turned, radians.
    #[must_use]
    pub fn turn(&self) -> Estimate {
        length(&self.motion.rotation, &self.covariance.fixed_view::<3, 3>(3, 3).into())
    }

    /// How far a point of the fixture (fixture coordinates) has moved.
    #[must_use]
    pub fn at(&self, point: &Point3<f64>) -> Displacement {
        let (v, w) = (self.motion.translation, self.motion.rotation);
        let arm = self.from.rotation * point.coords;
        let turned = Rotation3::new(w) * arm;
        let mut by_motion = Matrix3x6::zeros();
        by_motion.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
        let by_turn = -turned.cross_matrix() * left_jacobian(&w);
        by_motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&by_turn);
        Displacement {
            vector: v + turned - arm,
            covariance: by_motion * self.covariance * by_motion.transpose(),
        }
    }

    /// The motion as a screw, along the **fixture's** axes before it: the constant twist that makes it in one unit of time.
    /// A turn of less significance than `alpha` asks for is left out: the screw's axis would be that of noise.
    #[must_use]
    pub fn screw(&self, alpha: f64) -> Twist {
        let along_fixture = self.from.rotation.inverse();
        let (v, mut w) = (self.motion.translation, self.motion.rotation);
        if !self.turned.is_some_and(|turned| turned.exceeds(alpha)) {
            w = Vector3::zeros();
        }
        Twist { translation: along_fixture * (left_jacobian_inverse(&w) * v), rotation: along_fixture * w }
    }
}

/// A length and its standard uncertainty, to first order.
fn length(vector: &Vector3<f64>, covariance: &Matrix3<f64>) -> Estimate {
    let variance = match vector.try_normalize(0.0) {
        Some(direction) => direction.dot(&(covariance * direction)),
        None => covariance.symmetric_eigenvalues().max(),
    };
    Estimate { value: vector.norm(), u: variance.max(0.0).sqrt() }
}

/// How a rotation vector's own change shows as a turn afterwards: `exp(w + dw) = exp(J dw) exp(w)`.
fn left_jacobian(w: &Vector3<f64>) -> Matrix3<f64> {
    // Every rotation vector of a frame is at most half a turn, where this has an inverse.
    left_jacobian_inverse(w).try_inverse().unwrap_or_else(Matrix3::identity)
}

/// The inverse of that: `log(exp(a) exp(w)) = w + J a` for a small turn `a` (Barfoot, State Estimation for Robotics, 2017,
/// equation 7.76).
fn left_jacobian_inverse(w: &Vector3<f64>) -> Matrix3<f64> {
    /// Angle below which the next term of the series is beneath rounding.
    const SMALL: f64 = 1e-4;
    let angle = w.norm();
    let factor = if angle < SMALL {
        1.0 / 12.0
    } else {
        let half = 0.5 * angle;
        (1.0 - half * half.cos() / half.sin()) / (angle * angle)
    };
    let cross = w.cross_matrix();
    Matrix3::identity() - 0.5 * cross + factor * cross * cross
}

/// What is seen of the motion from one frame to another, along the fixture's axes of the first: the motions that are not
/// free, in order.
struct Difference {
    /// The motion.
    motion: DVector<f64>,
    /// How it changes with the first frame and the second, along the parent's axes.
    by_frames: [MatrixXx6<f64>; 2],
}

impl Comparison {
    /// Of frames of this fixture.
    #[must_use]
    pub fn of(fixture: &dyn Fixture) -> Self {
        Self { freedom: fixture.freedom() }
    }

    /// A frame whose uncertainty a linear model of its measurement takes apart: what is `common` to all measurements, and
    /// the rest. `None` where the frame's own covariance, as its solver states it, is not that of the model.
    #[must_use]
    pub fn taken_apart(
        &self,
        linear: &Linear,
        common: impl Fn(Unknown) -> bool,
        stated: &Matrix6<f64>,
    ) -> Option<Located> {
        /// By which part variances may differ: the model is of first order, at nominal sizes.
        const AGREEMENT: f64 = 0.1;
        let mut located = Located::independent(*linear.frame(), Matrix6::zeros(), None);
        for (index, observation) in linear.observations().iter().enumerate() {
            let effect = linear.sensitivity(index);
            match observation {
                Observation::Stated(unknown) if common(*unknown) => located.common.push(effect),
                _ => located.own += effect * effect.transpose(),
            }
        }
        // As seen in units of the model, the stated covariance is the unit matrix.
        let along_fixture = Frame { rotation: linear.frame().rotation.inverse(), ..*linear.frame() };
        let seen = |covariance: &Matrix6<f64>| {
            transformed(&self.selection(), &along_fixture.to_parent_axes(covariance))
        };
        let root = seen(&located.covariance()).cholesky()?.l();
        let half = root.solve_lower_triangular(&seen(stated))?;
        let ratio = root.solve_lower_triangular(&half.transpose())?;
        let agrees = |value: &f64| (value - 1.0).abs() < AGREEMENT;
        ratio.symmetric_eigenvalues().iter().all(agrees).then_some(located)
    }

    /// How many motions count.
    fn seen(self) -> usize {
        6 - self.freedom.count()
    }

    /// Rows: the motions that count, of all.
    fn selection(self) -> MatrixXx6<f64> {
        let seen: Vec<usize> = (0..6).filter(|index| !self.freedom.is_free(*index)).collect();
        MatrixXx6::from_fn(seen.len(), |row, column| f64::from(u8::from(seen[row] == column)))
    }

    fn difference(self, from: &Frame, to: &Frame) -> Difference {
        let nearest = self.freedom.nearest(to, from);
        let w = from.error_to(&nearest).fixed_rows::<3>(3).into_owned();
        let to_turn = left_jacobian_inverse(&w);
        let along_fixture = from.rotation.inverse();
        let selection = self.selection();
        let block = |lever: &Vector3<f64>, turn: &Matrix3<f64>| {
            let mut matrix = Matrix6::zeros();
            matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(along_fixture.matrix());
            // A turn about the frame's own origin moves the origin of the one that stands nearer.
            matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(&(along_fixture.matrix() * -lever.cross_matrix()));
            matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&(along_fixture.matrix() * turn));
            &selection * matrix
        };
        Difference {
            motion: &selection * Vector6::from(from.twist_to(&nearest)),
            by_frames: [
                -block(&Vector3::zeros(), &to_turn.transpose()),
                block(&(nearest.origin - to.origin), &to_turn),
            ],
        }
    }

    /// The motion from `baseline` to `later`.
    ///
    /// Where the noise of both is told by residuals, it counts as one noise, and both estimates are pooled.
    ///
    /// # Errors
    /// [`DriftError::Singular`].
    pub fn change(&self, baseline: &Located, later: &Located) -> Result<Change, DriftError> {
        let both = alike(&[baseline.clone(), later.clone()]);
        let (before, after) = (&both[0], &both[1]);
        let Difference { motion, by_frames: [by_before, by_after] } =
            self.difference(&before.frame, &after.frame);
        let mut covariance = transformed(&by_before, &before.own) + transformed(&by_after, &after.own);
        for (first, second) in before.common.iter().zip(&after.common) {
            let effect = &by_before * first + &by_after * second;
            covariance += &effect * effect.transpose();
        }
        let of_noise = both.iter().filter_map(|one| one.estimated).map(|of| of.degrees_of_freedom).min();
        // Of the last so many motions that are seen.
        let of_last = |count: usize| -> Result<Significance, DriftError> {
            let first = motion.len() - count;
            let part = covariance.view((first, first), (count, count)).into_owned();
            let squared_distance = squared_distance(&motion.rows(first, count).into_owned(), &part)?;
            Ok(Significance { squared_distance, degrees_of_freedom: count, of_noise })
        };
        let turns = (3..6).filter(|index| !self.freedom.is_free(*index)).count();
        let significance = of_last(self.seen())?;
        let turned = if turns > 0 { Some(of_last(turns)?) } else { None };
        let all = self.selection().transpose();
        let from = before.frame;
        Ok(Change {
            from,
            motion: Twist::from(&all * motion).turned(&from.rotation),
            covariance: from.to_parent_axes(&(&all * covariance * all.transpose())),
            significance,
            turned,
        })
    }

    /// The frame that `frames`, which should be one, come to: their mean by generalised least squares.
    ///
    /// # Errors
    /// [`DriftError::NoBaseline`] of no frames, [`DriftError::Singular`].
    pub fn baseline(&self, frames: &[Located]) -> Result<Baseline, DriftError> {
        let (first, rest) = frames.split_first().ok_or(DriftError::NoBaseline)?;
        if rest.is_empty() {
            return Ok(Baseline { located: first.clone(), agreement: None });
        }
        let frames = alike(frames);
        let from = frames[0].frame;
        let (seen, count, causes) = (self.seen(), frames.len(), frames[0].common.len());
        let mut motions = DVector::zeros(seen * count);
        let mut own = DMatrix::zeros(seen * count, seen * count);
        let mut common = DMatrix::zeros(seen * count, causes);
        for (index, located) in frames.iter().enumerate() {
            let Difference { motion, by_frames: [_, by_frame] } = self.difference(&from, &located.frame);
            let row = seen * index;
            motions.rows_mut(row, seen).copy_from(&motion);
            own.view_mut((row, row), (seen, seen)).copy_from(&transformed(&by_frame, &located.own));
            for (cause, effect) in located.common.iter().enumerate() {
                common.view_mut((row, cause), (seen, 1)).copy_from(&(&by_frame * effect));
            }
        }
        let covariance = &own + &common * common.transpose();
        let each =
            DMatrix::from_fn(seen * count, seen, |row, column| f64::from(u8::from(row % seen == column)));
        let weighted = solved(&covariance, &each)?;
        let weights = solved(&(each.transpose() * &weighted), &weighted.transpose())?;
        let mean = &weights * &motions;
        let off = motions - &each * &mean;
        let all = self.selection().transpose();
        let own = &all * (&weights * own * weights.transpose()) * all.transpose();
        let effects = &all * (weights * common);
        let located = Located {
            frame: from.moved(&Twist::from(&all * mean)),
            own: from.to_parent_axes(&own),
            common: effects
                .column_iter()
                .map(|effect| Twist::from(effect.into_owned()).turned(&from.rotation).into())
                .collect(),
            estimated: frames[0].estimated,
        };
        let agreement = Significance {
            squared_distance: squared_distance(&off, &covariance)?,
            degrees_of_freedom: seen * (count - 1),
            of_noise: frames[0].estimated.map(|of| of.degrees_of_freedom),
        };
        Ok(Baseline { located, agreement: Some(agreement) })
    }
}

/// The same frames, all noise that residuals tell being one: the pooled estimate of it. What is common stays so only where
/// all know it.
fn alike(frames: &[Located]) -> Vec<Located> {
    let estimates = || frames.iter().filter_map(|located| located.estimated);
    let degrees_of_freedom: usize = estimates().map(|scatter| scatter.degrees_of_freedom).sum();
    let squares: f64 =
        estimates().map(|scatter| scatter.degrees_of_freedom as f64 * scatter.sigma * scatter.sigma).sum();
    let pooled = Scatter { sigma: (squares / degrees_of_freedom.max(1) as f64).sqrt(), degrees_of_freedom };
    let one_list = frames.iter().all(|located| located.common.len() == frames[0].common.len());
    let as_pooled = |located: &Located| {
        let located = match located.estimated {
            Some(_) => located.rescaled(pooled),
            None => located.clone(),
        };
        if one_list { located } else { Located { own: located.covariance(), common: Vec::new(), ..located } }
    };
    frames.iter().map(as_pooled).collect()
}

fn transformed(by: &MatrixXx6<f64>, covariance: &Matrix6<f64>) -> DMatrix<f64> {
    by * covariance * by.transpose()
}

/// `covariance^-1 right`.
fn solved(covariance: &DMatrix<f64>, right: &DMatrix<f64>) -> Result<DMatrix<f64>, DriftError> {
    let deviations = covariance.diagonal().map(f64::sqrt);
    // With what is no number the decomposition would never settle.
    if !covariance.iter().all(|v| v.is_finite()) || !deviations.iter().all(|v| *v > 0.0) {
        return Err(DriftError::Singular);
    }
    // Lengths and angles beside each other say nothing of rank; correlations do.
    let mut correlation = covariance.clone();
    let mut right = right.clone();
    for (index, deviation) in deviations.iter().enumerate() {
        correlation.row_mut(index).unscale_mut(*deviation);
        correlation.column_mut(index).unscale_mut(*deviation);
        right.row_mut(index).unscale_mut(*deviation);
    }
    let eigenvalues = correlation.symmetric_eigenvalues();
    if eigenvalues.min() <= RANK_TOLERANCE * RANK_TOLERANCE * eigenvalues.max() {
        return Err(DriftError::Singular);
    }
    let mut solved = correlation.cholesky().ok_or(DriftError::Singular)?.solve(&right);
    for (index, deviation) in deviations.iter().enumerate() {
        solved.row_mut(index).unscale_mut(*deviation);
    }
    Ok(solved)
}

fn squared_distance(motion: &DVector<f64>, covariance: &DMatrix<f64>) -> Result<f64, DriftError> {
    let column = DMatrix::from_column_slice(motion.len(), 1, motion.as_slice());
    Ok(solved(covariance, &column)?.dot(&column))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Comparison = Comparison { freedom: Freedom::NONE };

    fn frame(origin: [f64; 3], xyzw: [f64; 4]) -> Frame {
        Frame::from_quaternion_xyzw(Point3::from(origin), xyzw).unwrap()
    }

    /// A covariance of no symmetry at all; lengths about 0.1, angles about 0.01.
    fn covariance(seed: f64) -> Matrix6<f64> {
        let scale = |row: usize| if row < 3 { 0.1 } else { 0.01 };
        let root = Matrix6::from_fn(|i, j| {
            scale(i) * ((7 * i + j) as f64 * seed).sin() + if i == j { 2.0 * scale(i) } else { 0.0 }
        });
        root * root.transpose()
    }

    /// A frame after a small error, along the parent's axes.
    fn off(frame: &Frame, error: &Vector6<f64>) -> Frame {
        let Twist { translation, rotation } = (*error).into();
        Frame { rotation: Rotation3::new(rotation) * frame.rotation, origin: frame.origin + translation }
    }

    fn before_and_after() -> [Frame; 2] {
        [frame([10.0, -20.0, 30.0], [0.1, -0.4, 0.3, 0.8]), frame([12.0, -19.0, 28.5], [0.5, 0.3, -0.1, 0.9])]
    }

    /// Central differences: however large the motion, and however far a free one leads.
    #[test]
    fn a_motion_changes_with_both_frames_as_stated() {
        // Steps of 1e-5: truncation 1e-10 of lengths up to 10, rounding 1e-10.
        const STEP: f64 = 1e-5;
        const TOLERANCE: f64 = 1e-7;
        let [before, after] = before_and_after();
        let slid = before.moved(&Twist { translation: Vector3::new(5.0, -7.0, 0.0), rotation: Vector3::z() });
        let on_plane = Comparison { freedom: Freedom::from_names(["x", "y", "rz"]).unwrap() };
        for (comparison, after) in [(ALL, after), (on_plane, slid)] {
            let Difference { motion, by_frames } = comparison.difference(&before, &after);
            assert_eq!(motion.len(), 6 - comparison.freedom.count());
            // Along axes that do not turn with the first frame.
            let told = |first: &Frame, second: &Frame| {
                let motion = comparison.difference(first, second).motion;
                let all = comparison.selection().transpose() * motion;
                let along_parent = Twist::from(all).turned(&first.rotation);
                comparison.selection() * Vector6::from(along_parent.turned(&before.rotation.inverse()))
            };
            for k in 0..6 {
                let error = Vector6::ith(k, STEP);
                let first = told(&off(&before, &error), &after) - told(&off(&before, &-error), &after);
                let second = told(&before, &off(&after, &error)) - told(&before, &off(&after, &-error));
                for (got, by_frame) in [first, second].iter().zip(&by_frames) {
                    let expected = by_frame.column(k);
                    assert!((got / (2.0 * STEP) - expected).norm() < TOLERANCE, "{k}: {got} {expected}");
                }
            }
        }
    }

    /// A turn and a slide along what the fixture leaves free are no motion, and take no degree of freedom.
    #[test]
    fn what_is_free_does_not_count() {
        let [before, _] = before_and_after();
        let comparison = Comparison { freedom: Freedom::from_names(["z", "rz"]).unwrap() };
        let mut own = covariance(0.7);
        for index in [2, 5] {
            own.row_mut(index).fill(0.0);
            own.column_mut(index).fill(0.0);
        }
        let own = before.to_parent_axes(&own);
        let slid = before.moved(&Twist { translation: Vector3::z() * 4.0, rotation: Vector3::zeros() });
        let after = slid.moved(&Twist { translation: Vector3::zeros(), rotation: Vector3::z() });
        let located = |frame| Located::independent(frame, own, None);
        let change = comparison.change(&located(before), &located(after)).unwrap();
        assert!(change.significance.squared_distance < 1e-20 && change.motion.extent(1.0) < 1e-12);
        assert_eq!(change.significance.degrees_of_freedom, 4);
        let sideways = after.moved(&Twist { translation: Vector3::x(), rotation: Vector3::zeros() });
        let change = comparison.change(&located(before), &located(sideways)).unwrap();
        assert!((change.shift().value - 1.0).abs() < 1e-12);
        // Without the freedom nothing tells how large a turn about the axis is.
        assert_eq!(ALL.change(&located(before), &located(before)), Err(DriftError::Singular));
    }

    #[test]
    fn what_is_common_cancels_as_far_as_it_is_alike() {
        let [frame, other] = before_and_after();
        let effect = Vector6::new(0.3, -0.2, 0.1, 0.01, 0.02, -0.03);
        let with = |common: &[Vector6<f64>]| Located {
            common: common.to_vec(),
            ..Located::independent(frame, covariance(0.4), None)
        };
        let of = |first: &Located, second: &Located| ALL.change(first, second).unwrap().covariance;
        let near = |a: Matrix6<f64>, b: Matrix6<f64>| {
            assert!((a - b).abs().max() < 1e-14 * a.abs().max(), "{a} {b}");
        };
        let twice = 2.0 * covariance(0.4);
        near(of(&with(&[effect]), &with(&[effect])), twice);
        near(of(&with(&[effect]), &with(&[3.0 * effect])), twice + 4.0 * effect * effect.transpose());
        // Known of one only: all of it counts.
        near(of(&with(&[effect]), &with(&[])), twice + effect * effect.transpose());
        // A mean keeps what is common to all of it.
        let pooled = ALL.baseline(&[with(&[effect]), with(&[effect]), with(&[effect])]).unwrap().located;
        near(pooled.own, covariance(0.4) / 3.0);
        assert!((pooled.common[0] - effect).norm() < 1e-14 && pooled.frame.error_to(&frame).norm() < 1e-14);
        let moved = Located { frame: other, ..with(&[effect]) };
        assert!(ALL.change(&pooled, &moved).unwrap().significance.squared_distance > 1e3);
    }

    /// The better known counts for more: against the textbook formula for two.
    #[test]
    fn a_baseline_is_the_mean_weighted_by_what_is_known() {
        // Second order in an error of 1e-5: first order of what it is multiplied with.
        const SECOND_ORDER: f64 = 1e-4;
        let [frame, _] = before_and_after();
        let error = Vector6::new(0.1, 0.05, -0.08, 0.004, 0.01, -0.006) * 1e-3;
        let (a, b) = (covariance(0.4) * 1e-6, covariance(0.9) * 1e-6);
        let pair = [Located::independent(frame, a, None), Located::independent(off(&frame, &error), b, None)];
        let Baseline { located, agreement } = ALL.baseline(&pair).unwrap();
        let information = a.try_inverse().unwrap() + b.try_inverse().unwrap();
        let mean = information.try_inverse().unwrap() * b.try_inverse().unwrap() * error;
        assert!((frame.error_to(&located.frame) - mean).norm() < SECOND_ORDER * mean.norm());
        assert!(
            (located.own - information.try_inverse().unwrap()).norm() < SECOND_ORDER * located.own.norm()
        );
        let agreement = agreement.unwrap();
        let change = ALL.change(&pair[0], &pair[1]).unwrap();
        assert_eq!(agreement.degrees_of_freedom, 6);
        let ratio = agreement.squared_distance / change.significance.squared_distance;
        assert!((ratio - 1.0).abs() < SECOND_ORDER, "{ratio}");
    }

    #[test]
    fn estimated_noise_is_pooled() {
        let [frame, after] = before_and_after();
        let with = |frame, sigma, degrees_of_freedom| {
            let estimated = Some(Scatter { sigma, degrees_of_freedom });
            Located::independent(frame, covariance(0.4) * sigma * sigma, estimated)
        };
        let change = ALL.change(&with(frame, 2.0, 3), &with(after, 4.0, 1)).unwrap();
        // (3 * 4 + 1 * 16) / 4 for each.
        let expected = 2.0 * 7.0 * covariance(0.4);
        let same = ALL.change(
            &Located::independent(frame, expected / 2.0, None),
            &Located::independent(after, expected / 2.0, None),
        );
        let same = same.unwrap();
        assert!((change.covariance - same.covariance).norm() < 1e-12 * expected.norm());
        assert_eq!(change.significance.of_noise, Some(4));
        assert!(change.significance.p_value() > same.significance.p_value());
        assert!(change.significance.limit(1e-3) > 5.0 * same.significance.limit(1e-3));
    }

    #[test]
    fn a_screw_is_the_motion_of_every_point() {
        let [before, after] = before_and_after();
        let located = |frame| Located::independent(frame, covariance(1.3), None);
        let change = ALL.change(&located(before), &located(after)).unwrap();
        let screw = change.screw(1.0);
        // A point of the screw's axis moves along it only, by the same distance as every other point does along it.
        let axis = screw.rotation.normalize();
        let on_axis = Point3::from(screw.rotation.cross(&screw.translation) / screw.rotation.norm_squared());
        let moved = |p: &Point3<f64>| before.rotation.inverse() * (after.to_parent(p) - before.to_parent(p));
        let along = moved(&on_axis);
        assert!(along.cross(&axis).norm() < 1e-12, "{along}");
        assert!((along - screw.translation.dot(&axis) * axis).norm() < 1e-12);
        for point in [Point3::new(3.0, -4.0, 5.0), Point3::origin()] {
            let told = change.at(&point);
            assert!((told.vector - (after.to_parent(&point) - before.to_parent(&point))).norm() < 1e-12);
        }
        // As sure as nothing is, nothing is a turn.
        assert_eq!(change.screw(0.0).rotation, Vector3::zeros());
        let at_origin = change.at(&Point3::origin());
        assert!((at_origin.length().value - change.shift().value).abs() < 1e-12);
        assert!((at_origin.length().u - change.shift().u).abs() < 1e-12);
    }
}
