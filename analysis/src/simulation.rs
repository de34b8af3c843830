//! Simulated measurements: where touches could be on a fixture, and what a probe would read there.
//!
//! Everything is a function of a seeded generator: the same seed gives the same touches on every machine and for any
//! number of threads, as each trial has a generator of its own ([`generator`]).

use nalgebra::{Matrix3, Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use touchref_core::{Fixture, Frame, Noise, Probe, Problem, Touch, TouchError};

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

/// The points at which the touches of a measurement met the surfaces of its fixture, which stands at `frame`: the foot of
/// each tip centre.
#[must_use]
pub fn contacts(problem: &Problem<'_>, frame: &Frame) -> Layout {
    let contact = |touch: &Touch| {
        let tip = frame.to_fixture(&touch.at);
        let seen = problem.fixture().surfaces()[touch.surface].seen_from(&tip);
        (touch.surface, tip - seen.normal * seen.distance)
    };
    problem.touches().iter().map(contact).collect()
}

/// Checks that the fixture has every surface that is touched.
///
/// # Errors
/// [`TouchError::NoSuchSurface`] for the first touch of one that it has not.
pub fn check_surfaces(
    fixture: &dyn Fixture,
    touched: impl IntoIterator<Item = usize>,
) -> Result<(), TouchError> {
    let surfaces = fixture.surfaces().len();
    match touched.into_iter().enumerate().find(|(_, surface)| *surface >= surfaces) {
        None => Ok(()),
        Some((index, surface)) => Err(TouchError::NoSuchSurface { index, surface, surfaces }),
    }
}

/// What the probe reads when `fixture` stands at `frame` and is touched at `layout`: tip centres in the parent, each
/// coordinate with normal noise of standard deviation `sigma`.
///
/// The touches carry no sigma of their own: they are as sure as the probe says.
///
/// # Panics
/// When the layout touches a surface that the fixture does not have: [`check_surfaces`] tells for one that was not made for
/// this fixture.
pub fn simulate(
    fixture: &dyn Fixture,
    layout: &[(usize, Point3<f64>)],
    frame: &Frame,
    probe: &Probe,
    sigma: f64,
    rng: &mut impl Rng,
) -> Vec<Touch> {
    if let Err(error) = check_surfaces(fixture, layout.iter().map(|(surface, _)| *surface)) {
        panic!("the layout is not of this fixture: {error}");
    }
    let planned = layout.iter().map(|(surface, contact)| Touch::new(*surface, *contact));
    planned.map(|touch| reading(fixture, &touch, frame, probe.tip_radius, sigma, rng)).collect()
}

/// What the probe reads for one touch that is `planned` in fixture coordinates, above the foot of its `at` on the
/// surface: the tip's centre in the parent, with the touch's own noise or else that of `sigma`.
pub(crate) fn reading(
    fixture: &dyn Fixture,
    planned: &Touch,
    frame: &Frame,
    tip_radius: f64,
    sigma: f64,
    rng: &mut impl Rng,
) -> Touch {
    let seen = fixture.surfaces()[planned.surface].seen_from(&planned.at);
    let tip = planned.at + seen.normal * (tip_radius - seen.distance);
    let touch = turned(planned, frame.to_parent(&tip), &frame.rotation);
    Touch { at: touch.at + noise(&touch, sigma, rng), ..touch }
}

/// An error of a touch, in the parent: of its own noise, or else of that of `sigma` along each axis.
pub(crate) fn noise(touch: &Touch, sigma: f64, rng: &mut impl Rng) -> Vector3<f64> {
    let standard = Vector3::from(std::array::from_fn::<f64, 3, _>(|_| rng.sample(StandardNormal)));
    match &touch.noise {
        Noise::OfProbe => standard * sigma,
        Noise::Sigma(own) => standard * *own,
        Noise::Covariance(own) => square_root(own) * standard,
    }
}

/// The touch in other axes, which `rotation` leads to: its approach and covariance turned, its place `at`.
pub(crate) fn turned(touch: &Touch, at: Point3<f64>, rotation: &Rotation3<f64>) -> Touch {
    let noise = match touch.noise {
        Noise::Covariance(own) => Noise::Covariance(rotation * own * rotation.transpose()),
        other => other,
    };
    Touch { at, noise, approach: touch.approach.map(|direction| rotation * direction), ..*touch }
}

/// A matrix whose product with its own transpose is this covariance.
fn square_root(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    // Unlike Cholesky's it exists for every covariance that rounding has left.
    let eigen = covariance.symmetric_eigen();
    eigen.eigenvectors * Matrix3::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()))
}

#[cfg(test)]
mod tests {
    use touchref_core::{Parameters, Requirement, Surface};

    use super::*;

    #[derive(Debug)]
    struct Nothing(Requirement, Parameters);

    impl Fixture for Nothing {
        fn kind(&self) -> &'static str {
            "nothing"
        }
        fn parameters(&self) -> &Parameters {
            &self.1
        }
        fn surfaces(&self) -> &[Surface] {
            &[]
        }
        fn requirement(&self) -> &Requirement {
            &self.0
        }
        fn size(&self) -> f64 {
            1.0
        }
        fn nominal_layout(&self) -> Layout {
            Layout::new()
        }
    }

    #[test]
    fn a_surface_that_is_not_there_is_told() {
        let fixture = Nothing(Requirement::counts(&[]), Parameters::new());
        assert_eq!(check_surfaces(&fixture, []), Ok(()));
        let error = check_surfaces(&fixture, [3]).unwrap_err();
        assert_eq!(error, TouchError::NoSuchSurface { index: 0, surface: 3, surfaces: 0 });
    }

    #[test]
    #[should_panic(expected = "touch 0 is on surface number 3, but the fixture has 0 surfaces")]
    fn a_layout_of_another_fixture_is_not_simulated() {
        let fixture = Nothing(Requirement::counts(&[]), Parameters::new());
        let layout = [(3, Point3::origin())];
        simulate(&fixture, &layout, &Frame::identity(), &Probe::default(), 0.0, &mut generator(0, 0));
    }
}
