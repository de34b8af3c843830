//! Units of length that a measurement may state.

use std::fmt;

/// Unit of every length in a measurement, and so in its result. [Dialects](crate::Dialect) alone convert.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Units {
    /// Millimetres, `mm`.
    Millimetre,
    /// Metres, `m`.
    Metre,
    /// Micrometres, `um`.
    Micrometre,
    /// Inches, `in`.
    Inch,
}

impl Units {
    /// Every unit there is.
    pub const ALL: [Self; 4] = [Self::Millimetre, Self::Metre, Self::Micrometre, Self::Inch];

    /// The name by which files state it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Metre => "m",
            Self::Micrometre => "um",
            Self::Inch => "in",
        }
    }

    /// Its length in millimetres.
    #[must_use]
    pub fn millimetres(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Metre => 1000.0,
            Self::Micrometre => 0.001,
            Self::Inch => 25.4,
        }
    }

    /// The unit of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|units| units.name() == name)
    }

    /// The names, for messages: `mm, m, um, in`.
    #[must_use]
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }
}

impl fmt::Display for Units {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
