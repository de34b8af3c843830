//! Starting frames that cover all there are: for a search that knows nothing of the fixture but its surfaces.
//!
//! Rotations lie on a super-Fibonacci spiral (M. Alexa, "Super-Fibonacci Spirals: Fast, Low-Discrepancy Sampling of
//! SO(3)", CVPR 2022); to each belongs a translation from the additive sequence of the generalised golden ratio of
//! three dimensions (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018). Nothing is random,
//! so the same touches have the same starts.

use std::f64::consts::{SQRT_2, TAU};

use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use touchref_core::{Frame, Problem};

/// Starts of the first round; each further one has twice as many.
const FIRST: usize = 512;
/// Rounds at most: where a nearly free motion makes ever new minima, more would tell no more.
const ROUNDS: u32 = 4;
/// How far the origin may lie from where the middles of touches and touched surfaces coincide, in parts of the
/// fixture's size or of the touches' spread, whichever is larger: minima far from there have one that is nearer.
const REACH: f64 = 1.5;

/// Starts, round by round: every round covers all frames, the next twice as densely.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cover {
    /// Middle of the touches, in the parent.
    touches: Vector3<f64>,
    /// Middle of the touched surfaces, in the fixture.
    surfaces: Vector3<f64>,
    reach: f64,
}

impl Cover {
    pub(crate) fn of(problem: &Problem<'_>) -> Self {
        /// Of the unit square, a point in the middle of a surface's extent.
        const MIDDLE: (f64, f64) = (0.0, 0.5);
        let (fixture, touches) = (problem.fixture(), problem.touches());
        let count = touches.len() as f64;
        let middle = problem.centroid();
        let of_surface = |surface: usize| fixture.surfaces()[surface].point_at(MIDDLE.0, MIDDLE.1).coords;
        let surfaces = touches.iter().map(|touch| of_surface(touch.surface)).sum::<Vector3<f64>>() / count;
        let spread = touches.iter().map(|touch| (touch.at - middle).norm()).fold(0.0, f64::max);
        Self { touches: middle.coords, surfaces, reach: REACH * spread.max(fixture.size()) }
    }

    /// How many starts each round has.
    pub(crate) fn rounds() -> impl Iterator<Item = usize> {
        (0..ROUNDS).map(|round| FIRST << round)
    }

    /// The starts of a round of so many.
    pub(crate) fn starts(self, count: usize) -> impl Iterator<Item = Frame> {
        (0..count).map(move |index| {
            let rotation = rotation(index, count).to_rotation_matrix();
            let offset = translation(index) * self.reach;
            Frame { rotation, origin: Point3::from(self.touches + offset - rotation * self.surfaces) }
        })
    }
}

/// Point `index` of `count` on the spiral (Alexa 2022, Algorithm 1).
fn rotation(index: usize, count: usize) -> UnitQuaternion<f64> {
    /// The positive root of `psi^4 = psi + 4`.
    const PSI: f64 = 1.533_751_168_755_204_3;
    let s = index as f64 + 0.5;
    let share = s / count as f64;
    let (inner, outer) = (share.sqrt(), (1.0 - share).sqrt());
    let ((sin_a, cos_a), (sin_b, cos_b)) = ((TAU * s / SQRT_2).sin_cos(), (TAU * s / PSI).sin_cos());
    UnitQuaternion::new_normalize(Quaternion::new(outer * cos_b, inner * sin_a, inner * cos_a, outer * sin_b))
}

/// Member `index` of the sequence, in the cube from -1 to 1.
fn translation(index: usize) -> Vector3<f64> {
    /// The positive root of `g^4 = g + 1`.
    const GOLDEN: f64 = 1.220_744_084_605_759_5;
    let s = index as f64 + 0.5;
    let at = |power: i32| 2.0 * (s / GOLDEN.powi(power)).fract() - 1.0;
    Vector3::new(at(1), at(2), at(3))
}
