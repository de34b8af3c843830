//! What a fixture is: named surfaces in one frame, how many touches it needs, and its closed form if it has one.

use std::{borrow::Cow, fmt};

use nalgebra::Point3;

use crate::{
    Frame, Freedom, Probe, Problem, Rule, Shape, SolveError, Surface, Together, Touch, TouchError,
    parameters::{Parameters, nearest},
};

/// Named surfaces placed rigidly in one fixture frame.
///
/// A solver knows a fixture only through this trait. Object safe; a fixture is immutable once built.
pub trait Fixture: fmt::Debug + Send + Sync {
    /// The name its plugin is registered under.
    fn kind(&self) -> &'static str;

    /// The parameters it was built from, defaults filled in.
    fn parameters(&self) -> &Parameters;

    /// Its surfaces, in fixture coordinates; touches refer to them by index.
    fn surfaces(&self) -> &[Surface];

    /// The fewest touches that fix the frame.
    fn requirement(&self) -> &Requirement;

    /// Motions that its frame need not fix, as no touch of any of its surfaces sees them.
    fn freedom(&self) -> Freedom {
        Freedom::NONE
    }

    /// Whether the search of its closed form finds every frame from so many touches on each surface; without one the search
    /// is everywhere.
    ///
    /// A solver that leaves touches out asks with fewer than the requirement, too.
    fn can_search(&self, counts: &[usize]) -> bool {
        self.closed_form().is_none() || self.requirement().missing(counts, self.surfaces()).is_none()
    }

    /// A length typical of the fixture: radians times this are comparable with lengths on it.
    fn size(&self) -> f64;

    /// Lengths and angles of the fixture that can be measured by touches or be uncertain; at most [`MAX_DIMENSIONS`].
    fn dimensions(&self) -> &[Dimension] {
        &[]
    }

    /// The geometry of a surface when the [`dimensions`](Self::dimensions) have these `values` instead of their own.
    fn shape_with(&self, surface: usize, _values: &[f64]) -> Shape {
        self.surfaces()[surface].shape.clone()
    }

    /// How fast the signed distance of `at` (fixture coordinates) from a surface grows with a dimension, the frame
    /// held fixed and the dimensions at `values`: length per unit of the dimension.
    fn dimension_gradient(
        &self,
        _dimension: usize,
        _surface: usize,
        _at: &Point3<f64>,
        _values: &[f64],
    ) -> f64 {
        0.0
    }

    /// Why the fixture cannot stand at `frame` although its surfaces pass through the touches there (a touch would
    /// lie beyond the edge of its surface, say), in words; `None` when nothing speaks against it.
    fn objection(&self, _problem: &Problem<'_>, _frame: &Frame) -> Option<String> {
        None
    }

    /// The closed form, for a fixture that has one.
    fn closed_form(&self) -> Option<&dyn ClosedForm> {
        None
    }

    /// A way to the frames of many measurements at once, each with this probe and judged by this rule, for a fixture that
    /// has one.
    fn together(&self, _probe: &Probe, _rule: &Rule) -> Option<Box<dyn Together>> {
        None
    }

    /// A good layout of the fewest touches, for simulation and documentation: surface index and contact point
    /// (on the surface, in fixture coordinates).
    fn nominal_layout(&self) -> Vec<(usize, Point3<f64>)>;

    /// The index of the surface of that name.
    ///
    /// # Errors
    /// [`TouchError::UnknownSurface`] with the nearest known name.
    fn surface_index(&self, name: &str) -> Result<usize, TouchError> {
        let names = || self.surfaces().iter().map(|surface| surface.name.as_str());
        names().position(|known| known == name).ok_or_else(|| TouchError::UnknownSurface {
            name: name.to_owned(),
            known: names().map(str::to_owned).collect(),
            nearest: nearest(name, names()).map(str::to_owned),
        })
    }

    /// A touch of the surface of that name, its tip centre at `at` in the parent.
    ///
    /// # Errors
    /// [`TouchError::UnknownSurface`] with the nearest known name.
    fn touch(&self, surface: &str, at: [f64; 3]) -> Result<Touch, TouchError> {
        Ok(Touch::new(self.surface_index(surface)?, Point3::from(at)))
    }
}

const _: Option<&dyn Fixture> = None;

/// The most dimensions of a fixture.
pub const MAX_DIMENSIONS: usize = 8;

/// A length or an angle of a fixture.
#[derive(Debug, Clone, PartialEq)]
pub struct Dimension {
    /// Name of the parameter that sets it.
    pub name: Cow<'static, str>,
    /// Its value: a length, or radians.
    pub value: f64,
    /// Its standard uncertainty; 0 where it is taken as exact.
    pub u: f64,
    /// What it is.
    pub quantity: Quantity,
}

/// What a [`Dimension`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A length.
    Length,
    /// An angle; kept in radians, written in degrees.
    Angle,
}

impl Quantity {
    /// By what a value is multiplied to be written: lengths stay, radians become degrees.
    #[must_use]
    pub fn scale(self) -> f64 {
        match self {
            Self::Length => 1.0,
            Self::Angle => 1.0_f64.to_degrees(),
        }
    }
}

/// How many touches each of so many surfaces has, from the surface of each touch.
#[must_use]
pub fn touches_per_surface(surfaces: usize, touched: impl IntoIterator<Item = usize>) -> Vec<usize> {
    let mut counts = vec![0; surfaces];
    for surface in touched {
        counts[surface] += 1;
    }
    counts
}

/// The fewest touches that fix a frame: alternatives, each a count for every surface in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Requirement {
    /// Each row is enough.
    pub alternatives: Vec<Vec<usize>>,
    /// The fewest touches altogether, where that is more than any row has.
    pub total: usize,
}

impl Requirement {
    /// One alternative only.
    #[must_use]
    pub fn counts(per_surface: &[usize]) -> Self {
        Self { alternatives: vec![per_surface.to_vec()], total: 0 }
    }

    /// So many touches altogether, on whichever of so many surfaces; which layouts of them do, only the layout tells.
    #[must_use]
    pub fn total(total: usize, surfaces: usize) -> Self {
        Self { alternatives: vec![vec![0; surfaces]], total }
    }

    /// A sentence of what is missing, or `None` when `counts` (touches on each surface) is enough.
    ///
    /// Where several alternatives exist, the one that needs the fewest further touches is told.
    #[must_use]
    pub fn missing(&self, counts: &[usize], surfaces: &[Surface]) -> Option<String> {
        let short = |need: &[usize]| -> usize {
            need.iter().zip(counts).map(|(need, have)| need.saturating_sub(*have)).sum()
        };
        let best = self.alternatives.iter().min_by_key(|need| short(need))?;
        if short(best) == 0 {
            let have: usize = counts.iter().sum();
            return (have < self.total).then(|| format!("there are {have} of {} touches", self.total));
        }
        let parts: Vec<String> = best
            .iter()
            .zip(counts)
            .zip(surfaces)
            .filter(|((need, have), _)| have < need)
            .map(|((need, have), surface)| format!("`{}` has {have} of {need} touches", surface.name))
            .collect();
        Some(parts.join(", "))
    }
}

/// All frames that satisfy a fixture's equations, found without a starting guess.
///
/// Choosing among them is the solver's job.
pub trait ClosedForm: fmt::Debug {
    /// Which [`dimensions`](Fixture::dimensions) the equations leave free, so that each root measures them.
    fn measured(&self) -> &'static [usize];

    /// Hands every real root to `emit`, unranked, and every near miss: a stationary point of the equations that noise
    /// may have lifted off zero.
    ///
    /// # Errors
    /// [`SolveError::Degenerate`] when the touches of a surface do not determine it (in a line, coincident), and
    /// [`SolveError::InvalidTouches`] when they contradict the fixture (touches on the wrong side).
    fn roots(&self, problem: &Problem<'_>, emit: &mut dyn FnMut(Root)) -> Result<(), SolveError>;

    /// Hands to `emit` a frame in every basin that touches as noisy as `noise` times the problem's own sigmas may
    /// hold, the roots' among them; returns the largest such factor up to which the search claims to be complete.
    ///
    /// # Errors
    /// As [`roots`](Self::roots).
    fn candidates(
        &self,
        problem: &Problem<'_>,
        noise: f64,
        emit: &mut dyn FnMut(Frame),
    ) -> Result<f64, SolveError> {
        let _ = noise;
        self.roots(problem, &mut |root| emit(root.frame))?;
        Ok(f64::INFINITY)
    }
}

const _: Option<&dyn ClosedForm> = None;

/// The most dimensions that a closed form can measure.
pub const MAX_MEASURES: usize = 3;

/// One frame that satisfies the closed-form equations, and the dimensions it implies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Root {
    /// The frame.
    pub frame: Frame,
    /// Values of the dimensions that [`ClosedForm::measured`] lists, in that order.
    pub measures: [f64; MAX_MEASURES],
    /// Whether the equations are met.
    pub kind: RootKind,
}

/// Whether a root meets the equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RootKind {
    /// It does.
    Real,
    /// It comes nearest to meeting them: two roots that noise made complex, or a double root.
    NearMiss,
}
