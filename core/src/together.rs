//! Many measurements of one fixture at once.

use std::fmt;

use nalgebra::{Matrix6, Point3};

use crate::Frame;

/// What a frame must satisfy to stand: of the solver that would judge each measurement by itself.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// How far other frames are looked for, in the stated sigmas.
    pub noise: f64,
    /// Squared misfit, with so many degrees of freedom, up to which the touches are consistent.
    pub consistent: fn(usize) -> f64,
    /// Relative curvature up to which a first-order covariance is trusted.
    pub curvature: f64,
    /// How far the quadratic model must hold, in standard deviations, and by what part of its own rise the misfit may miss it
    /// there.
    pub reach: f64,
    /// See [`reach`](Self::reach).
    pub rise: f64,
    /// Codes of the warnings that so many degrees of freedom bring.
    pub warnings: fn(usize) -> &'static [&'static str],
}

/// Finds the frames of many measurements at once, those of which it is cheaply certain that they stand.
///
/// It leaves out whatever is not plain; a solver looks at that. What it hands out is the frame that a solver would accept, to a
/// millionth of its standard deviations, and does not depend on the measurements beside it.
pub trait Together: fmt::Debug + Send + Sync {
    /// How many touches a measurement has on each surface: no others are taken.
    fn counts(&self) -> &[usize];

    /// Hands to `emit` the frames that certainly stand, each with the index of its measurement, in order.
    ///
    /// `touches` are tip centres in the parent, measurement after measurement, each in the order of the surfaces.
    fn locate(&self, touches: &[Point3<f64>], emit: &mut dyn FnMut(usize, &Certain));
}

const _: Option<&dyn Together> = None;

/// A frame that stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certain {
    /// The frame.
    pub frame: Frame,
    /// Its covariance along the parent's axes, about its origin: translation first; radians.
    pub covariance: Matrix6<f64>,
    /// Squared misfit of the touches.
    pub chi_square: f64,
    /// Touches less unknowns.
    pub degrees_of_freedom: usize,
    /// Codes of what the user should know.
    pub warnings: &'static [&'static str],
    /// Largest over smallest singular value of the Jacobian, rotations scaled by the fixture's size.
    pub condition: f64,
}
