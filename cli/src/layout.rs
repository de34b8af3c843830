//! Where a simulated fixture is touched, from the arguments that `simulate` and `study` share.

use clap::ValueEnum;
use touchref::io::InputError;

use crate::setup::Setup;

/// Where a simulated fixture is touched.
#[derive(Debug, clap::Args)]
pub(crate) struct LayoutArgs {
    /// Where the fixture is touched [default: measurement if it has touches, else nominal]
    #[arg(long, value_enum, value_name = "LAYOUT")]
    layout: Option<LayoutKind>,
    /// Touches on each surface of a random layout, in the fixture's order [default: as many as the measurement has,
    /// else the fewest]
    #[arg(long, value_name = "A,B,...", value_delimiter = ',')]
    touches_per_surface: Vec<usize>,
}

/// A kind of layout, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LayoutKind {
    /// The layout that the fixture recommends
    Nominal,
    /// Uniform over the reachable surfaces, anew every time
    Random,
    /// Where the measurement touched it
    Measurement,
}

impl LayoutKind {
    /// The name by which arguments and results know it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::Random => "random",
            Self::Measurement => "measurement",
        }
    }
}

impl LayoutArgs {
    /// The kind asked for, or the one that suits the measurement.
    pub(crate) fn kind(&self, setup: &Setup) -> LayoutKind {
        let suitable = if setup.has_touches() { LayoutKind::Measurement } else { LayoutKind::Nominal };
        self.layout.unwrap_or(suitable)
    }

    /// How many touches each surface gets in a random layout.
    pub(crate) fn counts(&self, setup: &Setup) -> Result<Vec<usize>, InputError> {
        if let Some(given) = per_surface(&self.touches_per_surface, setup)? {
            return Ok(given);
        }
        if setup.has_touches() {
            return Ok(setup.problem()?.counts());
        }
        let fewest = setup.fixture.requirement().alternatives.first();
        Ok(fewest.cloned().unwrap_or_else(|| vec![1; setup.fixture.surfaces().len()]))
    }
}

/// Counts that are given, one for each surface; `None` where none are.
pub(crate) fn per_surface(given: &[usize], setup: &Setup) -> Result<Option<Vec<usize>>, InputError> {
    let names: Vec<&str> = setup.fixture.surfaces().iter().map(|surface| surface.name.as_str()).collect();
    if given.is_empty() || given.len() == names.len() {
        return Ok(Some(given.to_vec()).filter(|given| !given.is_empty()));
    }
    let message = format!("{} counts are given for {} surfaces", given.len(), names.len());
    Err(InputError::new("invalid-input", message)
        .with_key("touches-per-surface")
        .with_help(format!("give one count for each of {}", names.join(", "))))
}
