//! Draws of all that is uncertain, put through the estimate of the frame: the model of the Monte Carlo method.

use nalgebra::{Point3, Vector3, Vector6};
use rand::Rng;
use rand_distr::{ChiSquared, Distribution};
use touchref_core::{FixturePlugin, Frame, Probe, Problem, Touch};

use crate::{
    simulation::noise,
    study::{Drawn, drawn_from, drawn_parameters},
};

/// From a measurement and a frame nearby to its maximum-likelihood frame, if there is one.
pub type Estimator<'a> = dyn Fn(&Problem<'_>, &Frame) -> Option<Frame> + Sync + 'a;

/// A measurement as it could have been: every touch, uncertain size and the tip radius with another error.
///
/// JCGM 101:2008, 6.4: what is stated has a normal distribution. Where no sigma is stated that of the touches is drawn,
/// too, as the residuals tell it with their degrees of freedom, once for all touches of a draw (Student's distribution).
#[derive(Clone, Copy)]
pub struct Draws<'a> {
    /// The measurement.
    pub problem: &'a Problem<'a>,
    /// What builds its fixture with other sizes.
    pub plugin: &'a FixturePlugin,
    /// Its maximum-likelihood frame.
    pub frame: &'a Frame,
    /// Points of use, in fixture coordinates.
    pub points: &'a [Point3<f64>],
    /// How the frame is found.
    pub estimator: &'a Estimator<'a>,
    /// Where no sigma is stated: that of the residuals, and their degrees of freedom.
    pub of_residuals: Option<(f64, usize)>,
}

impl Draws<'_> {
    /// How many numbers a draw has: the places of the points, and the rotation.
    #[must_use]
    pub fn outputs(&self) -> usize {
        3 * self.points.len() + 3
    }

    /// One draw: how far each point is from where the measurement has it, then the rotation vector from the measurement's
    /// rotation; along the parent's axes. `false` where the draw has no frame: sizes that no fixture can have.
    pub fn draw(&self, rng: &mut impl Rng, outputs: &mut [f64]) -> bool {
        let Some(found) = self.drawn_frame(rng) else { return false };
        let places = self.points.iter().map(|point| found.to_parent(point) - self.frame.to_parent(point));
        let motion: Vector6<f64> = self.frame.error_to(&found);
        let turn: Vector3<f64> = motion.fixed_rows::<3>(3).into();
        for (slots, values) in outputs.chunks_mut(3).zip(places.chain([turn])) {
            slots.copy_from_slice(values.as_slice());
        }
        true
    }

    fn drawn_frame(&self, rng: &mut impl Rng) -> Option<Frame> {
        let problem = self.problem;
        let sigma = match self.of_residuals {
            None => problem.probe().sigma.unwrap_or(0.0),
            Some((sigma, degrees)) => {
                let degrees = degrees as f64;
                sigma * (degrees / ChiSquared::new(degrees).ok()?.sample(rng)).sqrt()
            }
        };
        let err = |touch: &Touch| Touch { at: touch.at + noise(touch, sigma, rng), ..*touch };
        let touches: Vec<Touch> = problem.touches().iter().map(err).collect();
        let weighed = self.of_residuals.is_none();
        let known = problem.fixture().parameters();
        let drawn = if weighed { drawn_parameters(known, Drawn::AsStated, rng) } else { known.clone() };
        let other = if drawn == *known { None } else { Some(self.plugin.build(&drawn).ok()?) };
        let fixture = other.as_deref().unwrap_or(problem.fixture());
        let Probe { tip_radius, tip_radius_u, .. } = *problem.probe();
        let tip_radius = if weighed { drawn_from(tip_radius, tip_radius_u, rng) } else { tip_radius };
        let probe = Probe { tip_radius, ..*problem.probe() };
        let drawn = Problem::new(fixture, &touches, probe).ok()?.near(*self.frame);
        let found = (self.estimator)(&drawn, self.frame)?;
        Some(fixture.freedom().nearest(&found, self.frame))
    }
}
