//! Which surfaces were touched, where it is not known: every labelling that fits.
//!
//! All labellings that give each surface the touches that the fixture needs are tried, in order. A search for all frames
//! decides on each, as in [`robust`](crate::robust): what is above the 1e-6 level is excluded, and of the others only one
//! may be left. Before that, lower bounds of the misfit that need no frame rule out most: touches of one plane are
//! coplanar within their noise, and touches of one sphere no farther apart than its diameter.
//!
//! Fixtures that look the same from several sides, as a cube does, have several labellings by nature.

use nalgebra::{Matrix3, Point3, Unit, Vector3};
use touchref_core::{Fixture, Limit, Noise, Probe, Problem, Refusal, Shape, SolveError, Touch, Trust};

use crate::{
    acceptance::{AMBIGUOUS, Verdict},
    robust::require_sigma,
    words::joined,
};

/// Most labellings that are held against all frames: a second or two of work.
const MOST: usize = 20_000;
/// So many that fit are enough to say that there are several.
const TOLD: usize = 8;
/// Standard uncertainties by which a sphere may be larger than stated.
const LARGER: f64 = 6.0;

/// A touch whose surface may not be known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tip {
    /// Index of its surface, where it is known.
    pub surface: Option<usize>,
    /// Centre of the tip, in the parent.
    pub at: Point3<f64>,
    /// How sure the position is.
    pub noise: Noise,
    /// Direction in which the probe moved toward the surface, in the parent.
    pub approach: Option<Unit<Vector3<f64>>>,
}

impl Tip {
    /// The touch, of this surface.
    #[must_use]
    pub fn on(&self, surface: usize) -> Touch {
        Touch { surface, at: self.at, noise: self.noise, approach: self.approach }
    }
}

/// The surface of each touch, where only one labelling fits.
///
/// # Errors
/// [`SolveError::Ambiguous`] where several fit, [`SolveError::Inconsistent`] where none does,
/// [`SolveError::InvalidTouches`] where there are too many to try, and [`SolveError::Unsupported`] without a sigma.
pub fn label(fixture: &dyn Fixture, tips: &[Tip], probe: Probe) -> Result<Vec<usize>, SolveError> {
    let mut found = labellings(fixture, tips, probe)?;
    if found.len() == 1 {
        return Ok(found.swap_remove(0));
    }
    let sigma = probe.sigma;
    let trust = Trust {
        sigma,
        from_sigma: f64::NAN,
        up_to_sigma: f64::NAN,
        limited_by: Limit::Ambiguity,
        second_minimum: None,
        nonlinearity: None,
    };
    let open = (0..tips.len()).filter(|index| tips[*index].surface.is_none());
    let refuse = |message, help: &str| {
        let (help, touches) = (help.to_owned(), open.clone().collect());
        Box::new(Refusal {
            message,
            help,
            touches,
            roots: Vec::new(),
            trust: trust.clone(),
            observability: None,
        })
    };
    if found.is_empty() {
        let message = "no labels of the touches without one make them fit the fixture".to_owned();
        let help = "check units, tip radius, the fixture's sizes and the stated sigma; each surface needs its touches; a \
                    bad touch is told only where all labels are given";
        return Err(SolveError::Inconsistent(refuse(message, help)));
    }
    let in_words = |labels: &Vec<usize>| {
        let told =
            open.clone().map(|index| format!("{index} on `{}`", fixture.surfaces()[labels[index]].name));
        told.collect::<Vec<String>>().join(", ")
    };
    let all: Vec<String> = found.iter().map(in_words).collect();
    let count = if found.len() < TOLD { found.len().to_string() } else { format!("{TOLD} or more") };
    let message = format!("{count} labellings fit: touches {}", joined(&all, ";", "or"));
    let help = "label some of the touches, give approach directions, or touch each surface once more";
    Err(SolveError::Ambiguous(refuse(message, help)))
}

/// Every labelling that is not excluded, the surface of each touch; of many, the first few.
///
/// # Errors
/// [`SolveError::InvalidTouches`] where there are too many to try, and [`SolveError::Unsupported`] without a sigma.
pub fn labellings(fixture: &dyn Fixture, tips: &[Tip], probe: Probe) -> Result<Vec<Vec<usize>>, SolveError> {
    // Whatever their surfaces are, the touches must be sound, and their noise known.
    let touches: Vec<Touch> = tips.iter().map(|tip| tip.on(tip.surface.unwrap_or(0))).collect();
    require_sigma(&Problem::new(fixture, &touches, probe)?)?;
    let mut search = Search { fixture, tips, probe, found: Vec::new(), tried: 0 };
    search.extend(&mut tips.iter().map(|tip| tip.surface).collect())?;
    Ok(search.found)
}

/// A search through labellings, one touch after the other.
struct Search<'a> {
    fixture: &'a dyn Fixture,
    tips: &'a [Tip],
    probe: Probe,
    found: Vec<Vec<usize>>,
    /// Labellings held against all frames.
    tried: usize,
}

impl Search<'_> {
    /// Tries every surface for the first touch that has none, and goes on with the next.
    fn extend(&mut self, labels: &mut Vec<Option<usize>>) -> Result<(), SolveError> {
        let Some(next) = labels.iter().position(Option::is_none) else { return self.weigh(labels) };
        for surface in 0..self.fixture.surfaces().len() {
            labels[next] = Some(surface);
            if self.found.len() < TOLD && self.is_enough(labels) && self.may_be(surface, labels) {
                self.extend(labels)?;
            }
        }
        labels[next] = None;
        Ok(())
    }

    /// Holds a complete labelling against all frames.
    fn weigh(&mut self, labels: &[Option<usize>]) -> Result<(), SolveError> {
        let labels: Vec<usize> = labels.iter().copied().flatten().collect();
        if self.tried >= MOST {
            let open = (0..labels.len()).filter(|index| self.tips[*index].surface.is_none());
            return Err(SolveError::InvalidTouches {
                problem: format!("the surfaces of the touches could be labelled in more than {MOST} ways"),
                help: "label some of the touches".to_owned(),
                touches: open.collect(),
            });
        }
        self.tried += 1;
        let touches: Vec<Touch> = self.tips.iter().zip(&labels).map(|(tip, label)| tip.on(*label)).collect();
        if Verdict::of(&Problem::new(self.fixture, &touches, self.probe)?) != Verdict::Excluded {
            self.found.push(labels);
        }
        Ok(())
    }

    /// Whether the touches without label are enough for what the surfaces still need.
    fn is_enough(&self, labels: &[Option<usize>]) -> bool {
        let left = labels.iter().filter(|label| label.is_none()).count();
        let missing = |need: &Vec<usize>| -> usize {
            let on = |surface: usize| labels.iter().filter(|label| **label == Some(surface)).count();
            need.iter().enumerate().map(|(surface, need)| need.saturating_sub(on(surface))).sum()
        };
        self.fixture.requirement().alternatives.iter().any(|need| missing(need) <= left)
    }

    /// Whether the touches of a surface may be on one of its shape, wherever that stands.
    fn may_be(&self, surface: usize, labels: &[Option<usize>]) -> bool {
        let on =
            || self.tips.iter().zip(labels).filter(|(_, label)| **label == Some(surface)).map(|(tip, _)| tip);
        match self.fixture.surfaces()[surface].shape {
            Shape::Plane { .. } => {
                let count = on().count();
                count <= 3 || self.off_plane(on()) <= AMBIGUOUS.value(count - 3)
            }
            Shape::Sphere { radius, .. } => {
                let uncertain = self.fixture.dimensions().iter().map(|dimension| dimension.u).sum::<f64>();
                let most = radius + self.probe.tip_radius + LARGER * (uncertain + self.probe.tip_radius_u);
                let close = |one: &Tip, other: &Tip| {
                    let beyond = (one.at - other.at).norm() - 2.0 * most;
                    // The least sum of squares with which two errors close the gap.
                    let variance = self.sigma(one).powi(2) + self.sigma(other).powi(2);
                    beyond <= 0.0 || beyond * beyond <= variance * AMBIGUOUS.value(2)
                };
                on().all(|one| on().all(|other| close(one, other)))
            }
            _ => true,
        }
    }

    /// The least squared misfit of touches to a plane.
    fn off_plane<'t>(&self, tips: impl Iterator<Item = &'t Tip> + Clone) -> f64 {
        /// Rounding of an eigenvalue, in parts of the largest.
        const ROUNDING: f64 = 64.0 * f64::EPSILON;
        let weighted = tips.map(|tip| (self.sigma(tip).powi(-2), tip.at));
        let (mut total, mut center) = (0.0, Vector3::zeros());
        for (weight, at) in weighted.clone() {
            total += weight;
            center += at.coords * weight;
        }
        center /= total;
        let mut scatter = Matrix3::zeros();
        for (weight, at) in weighted {
            let from_center = at.coords - center;
            scatter += from_center * from_center.transpose() * weight;
        }
        let squares = scatter.symmetric_eigenvalues();
        squares.min() - ROUNDING * squares.max()
    }

    /// Standard deviation of a touch in the direction in which it is least sure.
    fn sigma(&self, tip: &Tip) -> f64 {
        match tip.noise {
            Noise::OfProbe => self.probe.sigma.unwrap_or(f64::INFINITY),
            Noise::Sigma(sigma) => sigma,
            Noise::Covariance(covariance) => covariance.symmetric_eigenvalues().max().sqrt(),
        }
    }
}
