//! Simulated placements of one fixture whose sizes and tip differ from what is stated of them.

// Each of those who use it has its own part; a test may panic.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use touchref::{
    Calibration, Fixture, FixturePlugin, Frame, Parameters, Probe, Problem, Touch, Unknown, Value,
    analysis::simulation::{Layout, random_frame, simulate},
    solvers::Extra,
    statistics::chi_square_level,
};

/// Frames lie within this distance of the parent's origin.
const REACH: f64 = 1000.0;

/// Placements of one fixture, and what is true of them.
pub struct Placements {
    pub plugin: &'static FixturePlugin,
    /// As stated.
    pub fixture: Box<dyn Fixture>,
    /// As stated.
    pub probe: Probe,
    pub touches: Vec<Vec<Touch>>,
    pub frames: Vec<Frame>,
    /// True values of the fixture's parameters, and of the tip's radius.
    pub truth: (Parameters, f64),
}

impl Placements {
    /// So many placements touched at `layout`; the truth is drawn from what is stated.
    pub fn drawn(
        plugin: &'static FixturePlugin,
        stated: &Parameters,
        probe: Probe,
        (layout, count): (&Layout, usize),
        rng: &mut impl Rng,
    ) -> Self {
        let mut normal = |value: f64, u: f64| value + u * rng.sample::<f64, _>(StandardNormal);
        let mut parameters = Parameters::new();
        for (name, value) in stated.iter() {
            let value = match value {
                Value::Number { value, u } => Value::from(normal(*value, *u)),
                other => other.clone(),
            };
            parameters.set(name, value);
        }
        let tip_radius = normal(probe.tip_radius, probe.tip_radius_u);
        Self::of_truth(plugin, stated, probe, (layout, count), (parameters, tip_radius), rng)
    }

    /// The same with this truth.
    pub fn of_truth(
        plugin: &'static FixturePlugin,
        stated: &Parameters,
        probe: Probe,
        (layout, count): (&Layout, usize),
        truth: (Parameters, f64),
        rng: &mut impl Rng,
    ) -> Self {
        let (fixture, real) = (plugin.build(stated).unwrap(), plugin.build(&truth.0).unwrap());
        let real_probe = Probe { tip_radius: truth.1, tip_radius_u: 0.0, ..probe };
        let frames: Vec<Frame> = (0..count).map(|_| random_frame(REACH, rng)).collect();
        let sigma = probe.sigma.unwrap();
        let touches = frames.iter().map(|frame| simulate(&*real, layout, frame, &real_probe, sigma, rng));
        let touches = touches.collect();
        Self { plugin, fixture, probe, touches, frames, truth }
    }

    pub fn problems(&self) -> Vec<Problem<'_>> {
        let touches = self.touches.iter();
        touches.map(|touches| Problem::new(&*self.fixture, touches, self.probe).unwrap()).collect()
    }

    /// The true value of a parameter, a length or degrees.
    pub fn true_value(&self, name: &str) -> f64 {
        if name == "tip_radius" { self.truth.1 } else { self.truth.0.number(name) }
    }

    /// Squared error of the parameters in their own covariance: chi-square with as many degrees of freedom.
    pub fn squared_error(&self, calibration: &Calibration) -> f64 {
        let errors = calibration.parameters.iter().map(|p| p.value - self.true_value(&p.name));
        let errors = nalgebra::DVector::from_iterator(calibration.parameters.len(), errors);
        errors.dot(&calibration.covariance.clone().cholesky().unwrap().solve(&errors))
    }

    /// Whether the joint 95 % region of the parameters holds their true values.
    pub fn holds_the_truth(&self, calibration: &Calibration) -> bool {
        self.squared_error(calibration) <= chi_square_level(0.05, calibration.parameters.len())
    }
}

/// What of the fixture and the probe is unknown, by name, each with what is stated of it.
pub fn unknowns(fixture: &dyn Fixture, probe: &Probe, names: &[&str]) -> Vec<Extra> {
    let stated = |u: f64| Some(u).filter(|u| *u > 0.0);
    let unknown = |name: &&str| match fixture.dimensions().iter().position(|d| d.name == *name) {
        Some(index) => {
            Extra { what: Unknown::Dimension(index), prior: stated(fixture.dimensions()[index].u) }
        }
        None => Extra { what: Unknown::TipRadius, prior: stated(probe.tip_radius_u) },
    };
    names.iter().map(unknown).collect()
}

/// Twelve touches of `cylinder-plane`: two rings of four, a half step apart, and a square on the plane.
pub fn twelve(fixture: &dyn Fixture) -> Layout {
    let quarters = [0.0, 0.25, 0.5, 0.75];
    let on = |surface: usize, u: f64, v: f64| (surface, fixture.surfaces()[surface].point_at(u, v));
    let rings = quarters.map(|u| on(0, u, 0.0)).into_iter().chain(quarters.map(|u| on(0, u + 0.125, 1.0)));
    rings.chain(quarters.map(|u| on(1, u, 1.0))).collect()
}
