//! Simulated measurements: where touches could be on a fixture, and what a probe would read there.
//!
//! Everything is a function of a seeded generator: the same seed gives the same touches on every machine and for any
//! number of threads, as each trial has a generator of its own ([`generator`]).

use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use touchref_core::{Fixture, Frame, Noise, Probe, Touch};

/// Where a fixture is touched: surface index and contact point on that surface, in fixture coordinates.
pub type Layout = Vec<(usize, Point3<f64>)>;

/// The generator of one trial of a series; trials of one seed are independent of each other and of their order.
#[must_use]
pub fn generator(seed: u64, trial: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(trial);
    rng
}

/// Contact points uniform in area over the reachable part of each surface, `counts` of them in the order of the
/// fixture's surfaces.
pub fn random_layout(fixture: &dyn Fixture, counts: &[usize], rng: &mut impl Rng) -> Layout {
    let mut layout = Layout::new();
    for (index, (surface, &count)) in fixture.surfaces().iter().zip(counts).enumerate() {
        for _ in 0..count {
            layout.push((index, surface.point_at(rng.random(), rng.random())));
        }
    }
    layout
}

/// A frame with an origin uniform within `reach` of the parent's along each axis, and a rotation uniform over all.
pub fn random_frame(reach: f64, rng: &mut impl Rng) -> Frame {
    // Four independent normals point uniformly over the sphere of unit quaternions.
    let q = Quaternion::from_vector(std::array::from_fn::<f64, 4, _>(|_| rng.sample(StandardNormal)).into());
    let origin = Point3::from(std::array::from_fn(|_| rng.random_range(-1.0..=1.0) * reach));
    Frame { rotation: UnitQuaternion::new_normalize(q).to_rotation_matrix(), origin }
}

/// What the probe reads when `fixture` stands at `frame` and is touched at `layout`: tip centres in the parent, each
/// coordinate with normal noise of standard deviation `sigma`.
///
/// The touches carry no sigma of their own: they are as sure as the probe says.
pub fn simulate(
    fixture: &dyn Fixture,
    layout: &[(usize, Point3<f64>)],
    frame: &Frame,
    probe: &Probe,
    sigma: f64,
    rng: &mut impl Rng,
) -> Vec<Touch> {
    layout
        .iter()
        .map(|(surface, contact)| {
            let tip = fixture.surfaces()[*surface].tip_center(contact, probe.tip_radius);
            let noise = Vector3::from(std::array::from_fn::<f64, 3, _>(|_| rng.sample(StandardNormal)));
            let at = frame.to_parent(&tip) + noise * sigma;
            Touch { surface: *surface, at, noise: Noise::OfProbe, approach: None }
        })
        .collect()
}
