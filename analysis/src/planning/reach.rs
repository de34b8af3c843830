//! Where a probe can touch a fixture.

use nalgebra::{Point3, Unit, Vector3};
use touchref_core::{Extent, Fixture, Shape, Surface};

/// What of a fixture's surfaces a probe can reach, in fixture coordinates.
#[derive(Debug, Clone)]
pub struct Reach {
    surfaces: Vec<Surface>,
    cone: Option<Cone>,
}

/// Directions from which a probe can come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// How the probe moves toward the fixture, in fixture coordinates.
    pub along: Unit<Vector3<f64>>,
    /// Largest angle between that and the way into the surface (against its outward normal), radians.
    pub half_angle: f64,
}

/// A place on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Site {
    pub(crate) surface: usize,
    /// Within the surface's extent, as [`Surface::point_at`] takes it.
    pub(crate) uv: [f64; 2],
    /// The same in fixture coordinates.
    pub(crate) at: Point3<f64>,
}

/// Steps of the coarsest grid on a surface: around, and from one end (or the middle) to the other (or the rim).
pub(crate) const GRID: [u32; 2] = [24, 4];
/// A grid on a surface of which a cone leaves fewer places than this is made twice as fine, so many times at most.
const ENOUGH: usize = 24;
const REFINEMENTS: u32 = 4;
/// Rounding of a coordinate, in parts of the extent.
const ROUNDING: f64 = 1e-9;

impl Reach {
    /// The extents that the fixture itself states, from all sides.
    #[must_use]
    pub fn of(fixture: &dyn Fixture) -> Self {
        Self { surfaces: fixture.surfaces().to_vec(), cone: None }
    }

    /// The same with another extent of one surface.
    ///
    /// # Panics
    /// When there is no surface of that index.
    #[must_use]
    pub fn with_extent(mut self, surface: usize, extent: Extent) -> Self {
        self.surfaces[surface].extent = extent;
        self
    }

    /// The same with a limit to the directions from which the probe comes.
    #[must_use]
    pub fn with_cone(self, cone: Cone) -> Self {
        Self { cone: Some(cone), ..self }
    }

    /// The surfaces with their extents.
    #[must_use]
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Whether a contact point (fixture coordinates) on a surface lies within its extent and the cone.
    ///
    /// # Panics
    /// When there is no surface of that index.
    #[must_use]
    pub fn holds(&self, surface: usize, point: &Point3<f64>) -> bool {
        self.approached(surface, point) && within(&self.surfaces[surface], point)
    }

    /// Whether the cone lets the probe come to a point of a surface.
    pub(crate) fn approached(&self, surface: usize, point: &Point3<f64>) -> bool {
        self.cone.is_none_or(|cone| {
            let inward = self.surfaces[surface].approach(point);
            inward.angle(&cone.along) <= cone.half_angle + ROUNDING
        })
    }

    /// The place at `uv` of a surface, the first coordinate around and the second kept within the extent; `None` where
    /// the probe does not reach it.
    pub(crate) fn site(&self, surface: usize, uv: [f64; 2]) -> Option<Site> {
        let [u, v] = [uv[0].rem_euclid(1.0), uv[1].clamp(0.0, 1.0)];
        let at = self.surfaces[surface].point_at(u, v);
        self.approached(surface, &at).then_some(Site { surface, uv: [u, v], at })
    }

    /// A grid of places on a surface, its ends and rim among them; finer where a cone leaves little.
    pub(crate) fn grid(&self, surface: usize) -> Vec<Site> {
        let mut sites = Vec::new();
        for refinement in 0..=REFINEMENTS {
            sites = self.grid_of(surface, GRID.map(|steps| steps << refinement));
            if sites.len() >= ENOUGH {
                break;
            }
        }
        sites
    }

    /// A grid of so many steps, without places that coincide (the middle of a disc).
    pub(crate) fn grid_of(&self, surface: usize, [around, along]: [u32; 2]) -> Vec<Site> {
        let mut sites: Vec<Site> = Vec::new();
        for step in 0..=along {
            let from = sites.len();
            for turn in 0..around {
                let uv = [f64::from(turn) / f64::from(around), f64::from(step) / f64::from(along)];
                let new = |site: &Site| sites[from..].iter().all(|other| other.at != site.at);
                if let Some(site) = self.site(surface, uv).filter(new) {
                    sites.push(site);
                }
            }
        }
        sites
    }
}

/// Whether a point of a surface lies within its extent.
fn within(surface: &Surface, point: &Point3<f64>) -> bool {
    let between = |value: f64, from: f64, to: f64| {
        let slack = ROUNDING * (to - from).abs().max(to.abs());
        value >= from - slack && value <= to + slack
    };
    match (&surface.shape, surface.extent) {
        (Shape::Plane { point: middle, .. }, Extent::Disc { radius }) => {
            between((point - middle).norm(), 0.0, radius)
        }
        (
            Shape::Cylinder { point: start, axis, .. } | Shape::Cone { apex: start, axis, .. },
            Extent::Along { from, to },
        ) => between(axis.dot(&(point - start)), from, to),
        (Shape::Sphere { center, .. }, Extent::Cap { axis, half_angle }) => {
            between(axis.angle(&(point - center)), 0.0, half_angle)
        }
        // An extent of another kind limits nothing that this shape has.
        _ => true,
    }
}
