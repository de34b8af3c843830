//! What there is to draw of a result, in numbers: any fixture, as it is drawn from its surfaces.
//!
//! Everything is in the parent, but for the meshes of surfaces, which are in fixture coordinates: the frame and those of
//! rejected roots place them.

mod mesh;

use nalgebra::{Matrix3, Point3, Vector3};
use touchref_analysis::uncertainty::Spread;
use touchref_core::{Frame, Shape, Surface};
use touchref_io::words;

pub use self::mesh::{Edge, Mesh};
use crate::subject::{Contact, Subject};

/// The most rejected roots that are drawn: the best of them.
const MOST_GHOSTS: usize = 12;

/// The most touches of which each has an ellipsoid.
const MOST_ELLIPSOIDS: usize = 60;

/// What there is to draw; lengths in the unit of the result.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Middle of what was touched, in the parent.
    pub center: Point3<f64>,
    /// Radius of the ball about it that holds all but the rejected roots.
    pub radius: f64,
    /// From where it is seen best.
    pub view: View,
    /// The frame that was found.
    pub frame: Frame,
    /// Length of its axes.
    pub axis: f64,
    /// The surfaces that were touched, and all others, in the fixture's order.
    pub patches: Vec<Patch>,
    /// The touches, in input order.
    pub touches: Vec<TouchMark>,
    /// Radius of the probe's tip.
    pub tip_radius: f64,
    /// By how much residuals are drawn longer than they are.
    pub residuals_magnified: f64,
    /// Uncertainty of places on the fixture: of its origin first, then of the touches.
    pub ellipsoids: Vec<Ellipsoid>,
    /// By how much ellipsoids are drawn larger than they are.
    pub ellipsoids_magnified: f64,
    /// Rejected roots, the best first.
    pub ghosts: Vec<Ghost>,
    /// How many more there are.
    pub ghosts_left_out: usize,
}

/// Direction from which a scene is seen, told as on a globe about the parent's Z axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Angle from the parent's X axis to where the viewer stands, radians.
    pub azimuth: f64,
    /// Angle of the viewer above the parent's XY plane, radians.
    pub elevation: f64,
}

impl View {
    /// Unit vectors of the parent to the right, up, and toward the viewer.
    #[must_use]
    pub fn axes(&self) -> [Vector3<f64>; 3] {
        let (sin, cos) = self.azimuth.sin_cos();
        let (high, level) = self.elevation.sin_cos();
        [
            Vector3::new(-sin, cos, 0.0),
            Vector3::new(-high * cos, -high * sin, level),
            Vector3::new(level * cos, level * sin, high),
        ]
    }
}

/// A surface, as far as it is drawn.
#[derive(Debug, Clone)]
pub struct Patch {
    /// Name of the surface.
    pub name: String,
    /// Its mesh, in fixture coordinates.
    pub mesh: Mesh,
    /// For each patch: whether this one lies wholly on its outward side, or wholly on the other; `None` for one that is no
    /// plane, or that it crosses.
    pub above: Vec<Option<bool>>,
}

/// A touch.
#[derive(Debug, Clone)]
pub struct TouchMark {
    /// What is said of it.
    pub text: String,
    /// The centre of the tip.
    pub tip: Point3<f64>,
    /// The point of the surface that is nearest.
    pub foot: Point3<f64>,
    /// Outward normal of the surface there.
    pub normal: Vector3<f64>,
    /// How far the touch is from its surface, less the tip radius.
    pub residual: f64,
    /// Whether the frame does not rest on it.
    pub excluded: bool,
}

/// A region that covers a place of the fixture with a stated chance.
#[derive(Debug, Clone, Copy)]
pub struct Ellipsoid {
    /// The place.
    pub at: Point3<f64>,
    /// Its half axes, as columns; the region is what this matrix makes of the unit ball.
    pub half_axes: Matrix3<f64>,
}

/// A rejected root.
#[derive(Debug, Clone)]
pub struct Ghost {
    /// Its frame.
    pub frame: Frame,
    /// Why it is out.
    pub reason: String,
}

impl Scene {
    /// What there is to draw of a result; `None` where that does not tell where the touches were.
    #[must_use]
    pub fn of(subject: &Subject<'_>) -> Option<Self> {
        let contacts = subject.contacts.as_ref()?;
        let patches = patches(subject, contacts);
        let axis = 0.6 * subject.fixture.size();
        let (center, radius) = ball(subject, contacts, &patches, axis);
        let touches = touches(subject, contacts);
        let largest = touches.iter().filter(|touch| !touch.excluded).map(|touch| touch.residual.abs());
        let largest = largest.fold(0.0, f64::max);
        let ellipsoids = ellipsoids(subject, contacts);
        let widest = ellipsoids.iter().map(|ellipsoid| ellipsoid.half_axes.norm()).fold(0.0, f64::max);
        let mut rejected: Vec<_> = subject.record.roots.iter().filter(|root| !root.selected).collect();
        rejected.sort_by(|a, b| {
            let misfit = |root: Option<f64>| root.unwrap_or(f64::INFINITY);
            misfit(a.misfit).total_cmp(&misfit(b.misfit))
        });
        let ghosts = rejected.iter().take(MOST_GHOSTS).filter_map(|root| {
            let frame = Frame::from_quaternion_xyzw(root.frame.origin.into(), root.frame.quaternion_xyzw)?;
            frame.is_sound().then(|| Ghost { frame, reason: root.reason.clone() })
        });
        Some(Self {
            center,
            radius,
            view: best_view(contacts),
            frame: subject.frame,
            axis,
            patches,
            touches,
            tip_radius: subject.probe.tip_radius,
            residuals_magnified: magnification(largest, 0.16 * radius),
            ellipsoids,
            ellipsoids_magnified: magnification(widest, 0.12 * radius),
            ghosts: ghosts.collect(),
            ghosts_left_out: rejected.len().saturating_sub(MOST_GHOSTS),
        })
    }
}

/// What `drawn` should be made of `largest`: 1, 2 or 5 times a power of ten, and never smaller than it is.
fn magnification(largest: f64, drawn: f64) -> f64 {
    let wanted = drawn / largest;
    // Nothing to magnify, or nothing that would be seen.
    if !(1.0..1e12).contains(&wanted) {
        return 1.0;
    }
    let power = 10f64.powf(wanted.log10().floor());
    let step = [5.0, 2.0].into_iter().find(|step| wanted >= step * power).unwrap_or(1.0);
    step * power
}

/// The surfaces, each without what lies beyond a plane of the fixture that none of its own touches is beyond: there it ends,
/// as far as was seen.
fn patches(subject: &Subject<'_>, contacts: &[Contact]) -> Vec<Patch> {
    /// Part of the fixture's size by which a touch may be beyond a plane and on it all the same.
    const ON: f64 = 1e-3;
    /// The same of what was cut at it.
    const ROUNDING: f64 = 1e-9;
    let surfaces = subject.fixture.surfaces();
    let shapes: Vec<Shape> = (0..surfaces.len()).map(|index| subject.shape(index)).collect();
    let size = subject.fixture.size();
    // How far apart touches are: beyond that there is nothing to see.
    let middle =
        contacts.iter().map(|contact| contact.foot.coords).sum::<Vector3<f64>>() / contacts.len() as f64;
    let reach = contacts.iter().map(|contact| (contact.foot.coords - middle).norm()).fold(0.0, f64::max);
    let planes = || shapes.iter().enumerate().filter(|(_, shape)| matches!(shape, Shape::Plane { .. }));
    let patch = |(index, surface): (usize, &Surface)| {
        let feet = contacts.iter().filter(|contact| contact.surface == index);
        let feet: Vec<_> = feet.map(|contact| subject.frame.to_fixture(&contact.foot)).collect();
        let mut mesh = Mesh::of(&shapes[index], &surface.extent, &feet, reach);
        for (_, plane) in planes().filter(|(other, _)| *other != index && !feet.is_empty()) {
            match side(plane, &feet, ON * size) {
                Some(false) => mesh = mesh.cut(|point| plane.seen_from(point).distance),
                Some(true) => mesh = mesh.cut(|point| -plane.seen_from(point).distance),
                None => {}
            }
        }
        let mut above = vec![None; shapes.len()];
        for (other, plane) in planes().filter(|(other, _)| *other != index) {
            above[other] = side(plane, &mesh.vertices, ROUNDING * size);
        }
        Patch { name: surface.name.clone(), mesh, above }
    };
    surfaces.iter().enumerate().map(patch).collect()
}

/// Whether points are all on the outward side of a plane, or all on the other.
fn side(plane: &Shape, points: &[Point3<f64>], tolerance: f64) -> Option<bool> {
    let depths = points.iter().map(|point| plane.seen_from(point).distance);
    let [low, high] = depths.fold([0.0_f64; 2], |[low, high], depth| [low.min(depth), high.max(depth)]);
    match (low >= -tolerance, high <= tolerance) {
        (_, true) => Some(false),
        (true, false) => Some(true),
        (false, false) => None,
    }
}

/// The ball that holds surfaces, touches and axes.
fn ball(subject: &Subject<'_>, contacts: &[Contact], patches: &[Patch], axis: f64) -> (Point3<f64>, f64) {
    let frame = &subject.frame;
    let corners = patches.iter().flat_map(|patch| &patch.mesh.vertices).map(|point| frame.to_parent(point));
    let tips = contacts.iter().map(|contact| contact.at);
    let ends = (0..3).map(|k| frame.origin + frame.axis(k) * axis);
    let all: Vec<Point3<f64>> = corners.chain(tips).chain(ends).chain([frame.origin]).collect();
    let (low, high) = all.iter().fold((frame.origin, frame.origin), |(low, high), point| {
        (low.coords.inf(&point.coords).into(), high.coords.sup(&point.coords).into())
    });
    let center = nalgebra::center(&low, &high);
    (center, all.iter().map(|point| (point - center).norm()).fold(f64::MIN_POSITIVE, f64::max))
}

/// From where most touches are in sight, a little from above.
fn best_view(contacts: &[Contact]) -> View {
    const AROUND: u32 = 16;
    const ELEVATIONS: [f64; 4] = [25.0, 40.0, 10.0, -25.0];
    /// From below, a picture is harder to read: it must show this much more.
    const FROM_BELOW: f64 = 0.7;
    let in_sight = |view: &View| {
        let toward = view.axes()[2];
        // What is seen slantwise is seen less.
        let seen = contacts.iter().map(|contact| contact.normal.dot(&toward).clamp(0.0, 0.6)).sum::<f64>();
        if view.elevation < 0.0 { FROM_BELOW * seen } else { seen }
    };
    let azimuths =
        (0..AROUND).map(|step| (f64::from(step) + 0.35) * std::f64::consts::TAU / f64::from(AROUND));
    let all = azimuths
        .flat_map(|azimuth| ELEVATIONS.map(|elevation| View { azimuth, elevation: elevation.to_radians() }));
    let best = all.reduce(|best, next| if in_sight(&next) > in_sight(&best) + 1e-9 { next } else { best });
    best.unwrap_or(View { azimuth: -0.9, elevation: 0.5 })
}

fn touches(subject: &Subject<'_>, contacts: &[Contact]) -> Vec<TouchMark> {
    let units = subject.units.name();
    let marks = subject.record.touches.iter().zip(contacts).map(|(touch, contact)| TouchMark {
        text: words::touch(touch, units),
        tip: contact.at,
        foot: contact.foot,
        normal: contact.normal,
        residual: touch.residual.unwrap_or(0.0),
        excluded: touch.excluded,
    });
    marks.collect()
}

fn ellipsoids(subject: &Subject<'_>, contacts: &[Contact]) -> Vec<Ellipsoid> {
    let factor = subject.coverage_factor_of_region();
    let drawn = if contacts.len() > MOST_ELLIPSOIDS { &[] } else { contacts };
    let places = [subject.frame.origin].into_iter().chain(drawn.iter().map(|contact| contact.foot));
    let ellipsoid = |at: Point3<f64>| {
        let Spread(covariance) = subject.spread_of_point(&subject.frame.to_fixture(&at))?;
        let eigen = covariance.symmetric_eigen();
        let deviations = eigen.eigenvalues.map(|variance| factor * variance.max(0.0).sqrt());
        Some(Ellipsoid { at, half_axes: eigen.eigenvectors * Matrix3::from_diagonal(&deviations) })
    };
    places.filter_map(ellipsoid).collect()
}
