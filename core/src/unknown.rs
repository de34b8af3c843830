//! What may be unknown besides the frame: sizes of the fixture, and the probe's tip.

use std::borrow::Cow;

use crate::{Adjustment, Fixture, Probe, Problem};

/// A quantity that may be unknown besides the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// A dimension of the fixture, by its index in [`Fixture::dimensions`].
    Dimension(usize),
    /// The radius of the probe's tip.
    TipRadius,
}

impl Unknown {
    /// What is stated of it.
    ///
    /// # Panics
    /// When the fixture has no dimension of that index.
    #[must_use]
    pub fn stated(self, fixture: &dyn Fixture, probe: &Probe) -> Stated {
        match self {
            Self::Dimension(index) => {
                let dimension = &fixture.dimensions()[index];
                let scale = dimension.quantity.scale();
                let (name, nominal, u) = (dimension.name.clone(), dimension.value, dimension.u);
                Stated { name, nominal, u, scale }
            }
            Self::TipRadius => Stated {
                name: Cow::Borrowed("tip_radius"),
                nominal: probe.tip_radius,
                u: probe.tip_radius_u,
                scale: 1.0,
            },
        }
    }
}

/// What is stated of a quantity that may be unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    /// Name of the dimension, or `tip_radius`.
    pub name: Cow<'static, str>,
    /// Its nominal value: a length, or radians.
    pub nominal: f64,
    /// Standard uncertainty of that; 0 where it is exact.
    pub u: f64,
    /// By what it is multiplied to be told: lengths stay, radians become degrees.
    pub scale: f64,
}

impl Stated {
    /// What the touches make of it, told: `deviation` from the nominal value, of the standard uncertainty `u`, where the
    /// nominal value was taken to have `nominal_u`.
    #[must_use]
    pub fn adjusted(self, nominal_u: Option<f64>, deviation: f64, u: f64) -> Adjustment {
        let Self { name, nominal, scale, .. } = self;
        Adjustment {
            name,
            nominal: nominal * scale,
            nominal_u: nominal_u.map(|u| u * scale),
            value: (nominal + deviation) * scale,
            u: u * scale,
        }
    }
}

impl<'a> Problem<'a> {
    /// Dimensions and tip radius whose stated uncertainty makes them unknowns, each known to that.
    ///
    /// Without a stated sigma of touches there is nothing to weigh them against, and they are taken as exact.
    pub fn uncertain(&self) -> impl Iterator<Item = (Unknown, f64)> + use<'a> {
        let dimensions = self.fixture().dimensions().iter().enumerate();
        let of_dimensions = dimensions.map(|(index, dimension)| (Unknown::Dimension(index), dimension.u));
        let weighed = self.reference_sigma().is_some();
        let of_tip = (Unknown::TipRadius, self.probe().tip_radius_u);
        of_dimensions.chain([of_tip]).filter(move |(_, u)| weighed && *u > 0.0)
    }
}
