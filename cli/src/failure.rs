//! Why there is no result: what a subcommand can fail with, and its exit status.

use std::{fmt::Display, io};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use touchref::{
    DialectError, RegistryError, SolveError,
    analysis::planning::PlanError,
    io::{ErrorRecord, InputError, PlacementTouches, TouchRecord, Units, refusal::ConcernedPlacement},
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

/// A solver's refusal, with the touches it is about.
#[derive(Debug)]
pub(crate) struct Refused {
    pub(crate) error: SolveError,
    pub(crate) units: Units,
    pub(crate) touches: Vec<TouchRecord>,
    /// The file of the touches.
    pub(crate) file: String,
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
            Self::Refused(refused) => {
                let mut record = ErrorRecord::of_refusal(&refused.error, refused.units, &refused.touches);
                // Suspects are no place in the input.
                if let (true, [touch, ..]) =
                    (refused.error.is_input_error(), record.error.findings.touches.as_slice())
                {
                    record.error.place.line = touch.line;
                    record.error.place.file = Some(refused.file.clone());
                }
                record
            }
            Self::Uncalibrated(refused) => refused.record(),
            Self::Unplanned(error) => of_plan(error),
            Self::Undetermined(error) => ErrorRecord::new(
                "degenerate",
                error.to_string(),
                "touch more of the surface, in other places",
            ),
            Self::Untold(error) => of_dialect(error),
            Self::Call(error) => of_call(error),
        }
    }
}

/// What a dialect cannot tell, with the angle and its bound in degrees.
fn of_dialect(error: &DialectError) -> ErrorRecord {
    let mut record = ErrorRecord::new(error.code(), error.to_string(), error.help());
    record.error.place.key = Some("dialect".to_owned());
    if let DialectError::Lossy { lost, .. } = error {
        let findings = &mut record.error.findings;
        findings.units = Some(lost.units.name());
        findings.quantity = Some(lost.omission.map_or("angle in degrees", |_| "tilt in degrees"));
        findings.value = Some(lost.angle.to_degrees());
        findings.bound = Some(lost.angle_bound.to_degrees());
    }
    record
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
