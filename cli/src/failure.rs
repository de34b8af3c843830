//! Why there is no result: what a subcommand can fail with, and its exit status.

use std::{fmt::Display, io};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use touchref::{
    DialectError, RegistryError,
    analysis::planning::PlanError,
    io::{ErrorRecord, InputError, PlacementTouches, Units, refusal::ConcernedPlacement},
    locate::{self, Refused},
    solvers::{bundle::BundleError, element::ElementError},
};

/// Why there is no result.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An input or an argument is wrong.
    Input(InputError),
    /// A solver gives no frame.
    Refused(Box<Refused>),
    /// Placements give no calibration.
    Uncalibrated(Box<Uncalibrated>),
    /// There is no layout to touch that does what is wanted.
    Unplanned(Box<PlanError>),
    /// The touches do not determine what is wanted.
    Undetermined(ElementError),
    /// A frame was found, but cannot be told in a dialect that was asked for.
    Untold(DialectError),
    /// The call is wrong; or help or the version was asked for.
    Call(clap::Error),
}

/// A refusal to calibrate, with the placements it is about.
#[derive(Debug)]
pub(crate) struct Uncalibrated {
    pub(crate) error: BundleError,
    pub(crate) units: Units,
    pub(crate) placements: Vec<PlacementTouches>,
}

impl Uncalibrated {
    fn record(&self) -> ErrorRecord {
        let Self { error, units, placements } = self;
        let mut record = ErrorRecord::new(error.code(), error.to_string(), error.help());
        let concerned = error.placement().and_then(|index| Some((index, placements.get(index)?)));
        if let (BundleError::Placement { error, .. }, Some((_, placement))) = (error, concerned) {
            record.error.findings =
                ErrorRecord::of_refusal(error, *units, &placement.touches.records).error.findings;
        }
        let findings = &mut record.error.findings;
        findings.units = Some(units.name());
        findings.placement =
            concerned.map(|(index, placement)| ConcernedPlacement { index, name: placement.name.clone() });
        if let BundleError::Degenerate { parameters, quantity, value, bound, .. } = error {
            findings.parameters = parameters.iter().map(ToString::to_string).collect();
            findings.quantity = Some(*quantity);
            (findings.value, findings.bound) = (Some(*value), Some(*bound));
        }
        record
    }
}

impl Failure {
    /// A file that cannot be written.
    pub(crate) fn writing(what: impl Display, error: &io::Error) -> Self {
        let message = format!("cannot write {what}: {error}");
        Self::Input(InputError::new("unwritable", message).with_help("check the folder and its permissions"))
    }

    /// Help or the version: what was asked for, and no failure.
    pub(crate) fn is_help(&self) -> bool {
        match self {
            Self::Call(error) => matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion),
            _ => false,
        }
    }

    /// The exit status.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Refused(refused) if !refused.error.is_input_error() => 1,
            Self::Uncalibrated(refused) if !refused.error.is_input_error() => 1,
            Self::Undetermined(_) | Self::Unplanned(_) | Self::Untold(_) => 1,
            _ if self.is_help() => 0,
            _ => 2,
        }
    }

    /// For programs.
    pub(crate) fn record(&self) -> ErrorRecord {
        match self {
            Self::Input(error) => error.into(),
            Self::Refused(refused) => refused.record(),
            Self::Uncalibrated(refused) => refused.record(),
            Self::Unplanned(error) => of_plan(error),
            Self::Undetermined(error) => ErrorRecord::new(
                "degenerate",
                error.to_string(),
                "touch more of the surface, in other places",
            ),
            Self::Untold(error) => error.into(),
            Self::Call(error) => of_call(error),
        }
    }
}

fn of_plan(error: &PlanError) -> ErrorRecord {
    let (code, help) = match error {
        PlanError::NotMet { .. } => {
            ("not-met", "a smaller sigma, more precisely known sizes, or points of use nearer to the fixture")
        }
        PlanError::NoSoundLayout { refusal, .. } => {
            (refusal.code(), "plan more touches, a wider reach, or with a smaller sigma")
        }
        _ => ("degenerate", "plan more touches, on other surfaces, or a wider reach"),
    };
    ErrorRecord::new(code, error.to_string(), help)
}

/// The first paragraph of what clap says, and the argument it is about.
fn of_call(error: &clap::Error) -> ErrorRecord {
    let text = error.to_string();
    let paragraph: Vec<&str> = text.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
    let paragraph = paragraph.join(" ");
    let message = paragraph.trim_start_matches("error: ");
    let mut record = ErrorRecord::new("usage", message, "`touchref help` tells how it is called");
    let word = |kind| match error.get(kind) {
        Some(ContextValue::String(word)) => Some(word.clone()),
        Some(ContextValue::Strings(words)) => words.first().cloned(),
        _ => None,
    };
    record.error.place.key = word(ContextKind::InvalidArg).or_else(|| word(ContextKind::InvalidSubcommand));
    record.error.place.nearest =
        [ContextKind::SuggestedValue, ContextKind::SuggestedArg, ContextKind::SuggestedSubcommand]
            .into_iter()
            .find_map(word);
    record
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<RegistryError> for Failure {
    fn from(error: RegistryError) -> Self {
        Self::Input(error.into())
    }
}

impl From<Refused> for Failure {
    fn from(refused: Refused) -> Self {
        Self::Refused(Box::new(refused))
    }
}

impl From<locate::Failure> for Failure {
    fn from(failure: locate::Failure) -> Self {
        match failure {
            locate::Failure::Input(error) => Self::Input(error),
            locate::Failure::Refused(refused) => Self::Refused(refused),
            locate::Failure::Untold(error) => Self::Untold(error),
        }
    }
}

impl From<DialectError> for Failure {
    fn from(error: DialectError) -> Self {
        Self::Untold(error)
    }
}

impl From<clap::Error> for Failure {
    fn from(error: clap::Error) -> Self {
        Self::Call(error)
    }
}
