//! Touches: where the tip centre was when the probe met a surface, and how sure that is.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// One probe contact.
///
/// Touches are **tip centres**: the tip radius lies between tip centre and surface along the surface normal, so the
/// residual of a touch is `signed_distance(surface, R^T (at - origin)) - tip_radius`, whatever the approach was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Index into the fixture's [`surfaces`](crate::Fixture::surfaces).
    pub surface: usize,
    /// Centre of the tip, in the parent.
    pub at: Point3<f64>,
    /// How sure the position is.
    pub noise: Noise,
    /// Direction in which the probe moved toward the surface, in the parent.
    pub approach: Option<Unit<Vector3<f64>>>,
}

impl Touch {
    /// A touch of the surface with this index, its noise that of the probe, its approach unknown.
    #[must_use]
    pub fn new(surface: usize, at: Point3<f64>) -> Self {
        Self { surface, at, noise: Noise::OfProbe, approach: None }
    }

    /// The same touch with its own standard deviation along the surface normal.
    #[must_use]
    pub fn with_sigma(self, sigma: f64) -> Self {
        Self { noise: Noise::Sigma(sigma), ..self }
    }

    /// The same touch with a covariance of its position (parent axes, length squared).
    #[must_use]
    pub fn with_covariance(self, covariance: Matrix3<f64>) -> Self {
        Self { noise: Noise::Covariance(covariance), ..self }
    }

    /// The same touch with the direction in which the probe moved (any length; a zero vector means unknown).
    #[must_use]
    pub fn with_approach(self, direction: Vector3<f64>) -> Self {
        Self { approach: crate::direction(direction), ..self }
    }
}

/// How sure a touch is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Noise {
    /// As the probe's [`sigma`](Probe::sigma) says.
    #[default]
    OfProbe,
    /// Standard deviation along the surface normal.
    Sigma(f64),
    /// Covariance of the position, along parent axes.
    Covariance(Matrix3<f64>),
}

impl Noise {
    /// Standard deviation along the unit vector `normal` (parent axes); `of_probe` where the touch has none of its
    /// own.
    #[must_use]
    #[inline]
    pub fn along(&self, normal: &Vector3<f64>, of_probe: f64) -> f64 {
        match self {
            Self::OfProbe => of_probe,
            Self::Sigma(sigma) => *sigma,
            Self::Covariance(c) => normal.dot(&(c * normal)).max(0.0).sqrt(),
        }
    }
}

/// What is known of the probe.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Probe {
    /// Radius of the spherical tip; 0 where touches are surface points.
    pub tip_radius: f64,
    /// Standard uncertainty of the tip radius, common to all touches; 0 where it is known exactly.
    pub tip_radius_u: f64,
    /// Standard deviation of one touch along the surface normal, where the touch does not state its own.
    pub sigma: Option<f64>,
}
