//! Parameters of plugins: one description feeds validation, `list`, `describe`, help and docs.

use std::fmt;

use thiserror::Error;

/// What a plugin says of one of its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSpec {
    /// The key in a measurement file.
    pub name: &'static str,
    /// Which values it takes.
    pub kind: ParameterKind,
    /// The value taken when it is not given, or [`INSTEAD_OF`] another; `None` for a parameter that must be given.
    pub default: Option<&'static str>,
    /// What it means, in one line.
    pub meaning: &'static str,
}

/// How the default of a parameter begins that may take the place of another one, and else is left out:
/// `"instead of radius"`.
pub const INSTEAD_OF: &str = "instead of ";

impl ParameterSpec {
    /// The parameter whose place this one may take: either is given, not both.
    #[must_use]
    pub fn replaces(&self) -> Option<&'static str> {
        self.default?.strip_prefix(INSTEAD_OF)
    }
}

/// Which values a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ParameterKind {
    /// A positive length, in the measurement's unit; may carry a standard uncertainty.
    Length,
    /// Three positive lengths.
    Lengths3,
    /// An angle in degrees, strictly between two bounds; may carry a standard uncertainty.
    Angle {
        /// Lower bound, excluded, degrees.
        above: f64,
        /// Upper bound, excluded, degrees.
        below: f64,
    },
    /// One of these words.
    Choice(&'static [&'static str]),
    /// `true` or `false`.
    Flag,
}

impl fmt::Display for ParameterKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length => write!(f, "length > 0"),
            Self::Lengths3 => write!(f, "[length, length, length], each > 0"),
            Self::Angle { above, below } => write!(f, "angle in degrees, {above} < value < {below}"),
            Self::Choice(words) => write!(f, "\"{}\"", words.join("\" or \"")),
            Self::Flag => write!(f, "true or false"),
        }
    }
}

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Value {
    /// A number with its standard uncertainty (0 when known exactly).
    Number {
        /// The value.
        value: f64,
        /// Its standard uncertainty.
        u: f64,
    },
    /// Several numbers.
    Numbers(Vec<f64>),
    /// A word.
    Word(String),
    /// A truth value.
    Flag(bool),
}

impl Value {
    /// What it is, for messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Number { .. } => "a number",
            Self::Numbers(_) => "a list of numbers",
            Self::Word(_) => "a word",
            Self::Flag(_) => "a truth value",
        }
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Number { value, u: 0.0 }
    }
}

impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl From<&str> for Value {
    fn from(value: &str) -> Self {
        Self::Word(value.to_owned())
    }
}

impl From<[f64; 3]> for Value {
    fn from(values: [f64; 3]) -> Self {
        Self::Numbers(values.to_vec())
    }
}

/// Named values in the order given.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parameters(Vec<(String, Value)>);

impl Parameters {
    /// No parameters.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a parameter, or replaces the one of that name.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.set(name, value.into());
        self
    }

    /// Adds a parameter, or replaces the one of that name.
    pub fn set(&mut self, name: &str, value: Value) {
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = value,
            None => self.0.push((name.to_owned(), value)),
        }
    }

    /// The value of that name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }

    /// Names and values in the order given.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// Checks every value against its description and fills in the defaults.
    ///
    /// # Errors
    /// The first unknown name (with the nearest known one), missing parameter, value of the wrong kind or range, or
    /// parameter given beside the one whose place it would take.
    pub fn checked(&self, specs: &[ParameterSpec]) -> Result<Self, ParameterError> {
        for (name, value) in self.iter() {
            let spec = specs.iter().find(|spec| spec.name == name).ok_or_else(|| {
                let known = specs.iter().map(|spec| spec.name);
                ParameterError::unknown(name, known)
            })?;
            check(spec, value)?;
        }
        let mut complete = Self::new();
        for spec in specs {
            let replacement = specs.iter().find(|other| other.replaces() == Some(spec.name));
            let replaced_by = replacement.filter(|other| self.get(other.name).is_some());
            match (self.get(spec.name), replaced_by, spec.default) {
                (Some(_), Some(other), _) => {
                    return Err(ParameterError {
                        name: other.name.to_owned(),
                        problem: format!("is given beside `{}`", spec.name),
                        expected: "one of the two".to_owned(),
                        nearest: None,
                    });
                }
                (Some(value), ..) => complete.set(spec.name, value.clone()),
                (None, Some(_), _) => {}
                (None, None, Some(default)) => {
                    if spec.replaces().is_none()
                        && let Some(value) = parse(spec.kind, default)
                    {
                        complete.set(spec.name, value);
                    }
                }
                (None, None, None) => {
                    let or = replacement.map_or(String::new(), |other| format!(", or `{}`", other.name));
                    return Err(ParameterError {
                        name: spec.name.to_owned(),
                        problem: "is missing".to_owned(),
                        expected: format!("{}: {}{or}", spec.kind, spec.meaning),
                        nearest: None,
                    });
                }
            }
        }
        Ok(complete)
    }

    /// The number of that name; 0 where there is none (after [`checked`](Self::checked) there always is).
    #[must_use]
    pub fn number(&self, name: &str) -> f64 {
        self.uncertain(name).0
    }

    /// The number of that name and its standard uncertainty.
    #[must_use]
    pub fn uncertain(&self, name: &str) -> (f64, f64) {
        match self.get(name) {
            Some(Value::Number { value, u }) => (*value, *u),
            _ => (0.0, 0.0),
        }
    }

    /// The word of that name; empty where there is none.
    #[must_use]
    pub fn word(&self, name: &str) -> &str {
        match self.get(name) {
            Some(Value::Word(word)) => word,
            _ => "",
        }
    }

    /// The truth value of that name; `false` where there is none.
    #[must_use]
    pub fn flag(&self, name: &str) -> bool {
        matches!(self.get(name), Some(Value::Flag(true)))
    }
}

/// Reads the text of a default or of a `-p NAME=VALUE` argument.
///
/// `None` when the text is not a value of that kind.
#[must_use]
pub fn parse(kind: ParameterKind, text: &str) -> Option<Value> {
    let text = text.trim();
    match kind {
        ParameterKind::Length | ParameterKind::Angle { .. } => text.parse::<f64>().ok().map(Value::from),
        ParameterKind::Lengths3 => {
            let inside = text.trim_start_matches('[').trim_end_matches(']');
            let numbers = inside.split(',').map(|part| part.trim().parse()).collect::<Result<Vec<f64>, _>>();
            numbers.ok().map(Value::Numbers)
        }
        ParameterKind::Choice(_) => Some(Value::from(text)),
        ParameterKind::Flag => text.parse::<bool>().ok().map(Value::from),
    }
}

fn check(spec: &ParameterSpec, value: &Value) -> Result<(), ParameterError> {
    let positive = |v: f64| v.is_finite() && v > 0.0;
    let problem = match (spec.kind, value) {
        (ParameterKind::Length, Value::Number { value, u }) => {
            uncertainty_problem(*u).or_else(|| (!positive(*value)).then(|| format!("is {value}")))
        }
        (ParameterKind::Angle { above, below }, Value::Number { value, u }) => uncertainty_problem(*u)
            .or_else(|| (!(*value > above && *value < below)).then(|| format!("is {value}"))),
        (ParameterKind::Lengths3, Value::Numbers(numbers)) => {
            (numbers.len() != 3 || !numbers.iter().copied().all(positive)).then(|| format!("is {numbers:?}"))
        }
        (ParameterKind::Choice(words), Value::Word(word)) => {
            if words.contains(&word.as_str()) {
                None
            } else {
                return Err(ParameterError {
                    name: spec.name.to_owned(),
                    problem: format!("is \"{word}\""),
                    expected: spec.kind.to_string(),
                    nearest: nearest(word, words.iter().copied()).map(str::to_owned),
                });
            }
        }
        (ParameterKind::Flag, Value::Flag(_)) => None,
        (_, other) => Some(format!("is {}", other.kind())),
    };
    problem.map_or(Ok(()), |problem| {
        Err(ParameterError {
            name: spec.name.to_owned(),
            problem,
            expected: spec.kind.to_string(),
            nearest: None,
        })
    })
}

fn uncertainty_problem(u: f64) -> Option<String> {
    (!(u.is_finite() && u >= 0.0))
        .then(|| format!("has the standard uncertainty {u}, which must be 0 or more"))
}

/// A parameter that a plugin cannot take.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("parameter `{name}` {problem}; expected {expected}")]
pub struct ParameterError {
    /// Name of the parameter as it was given, or as it is missing.
    pub name: String,
    /// What is wrong with it.
    pub problem: String,
    /// What would be right.
    pub expected: String,
    /// The nearest right name or word.
    pub nearest: Option<String>,
}

impl ParameterError {
    /// A name that none of `known` is.
    pub fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> Self {
        Self {
            name: name.to_owned(),
            problem: "is not known".to_owned(),
            expected: format!("one of {}", known.clone().collect::<Vec<_>>().join(", ")),
            nearest: nearest(name, known).map(str::to_owned),
        }
    }
}

/// The known name that `name` was most likely meant to be, if any is near.
#[must_use]
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    /// Below this Jaro-Winkler likeness a suggestion confuses more than it helps.
    const LIKENESS: f64 = 0.75;
    /// What a name loses that is like another only without the marks around it: `x` for `+x`.
    const MARKS: f64 = 0.99;
    let like = |a: &str, b: &str| strsim::jaro_winkler(a, b);
    let bare = |name: &str| name.trim_matches(|c: char| !c.is_alphanumeric()).to_owned();
    let lower = name.to_lowercase();
    known
        .map(|candidate| {
            let known = candidate.to_lowercase();
            (like(&lower, &known).max(MARKS * like(&bare(&lower), &bare(&known))), candidate)
        })
        .filter(|(likeness, _)| *likeness > LIKENESS)
        .max_by(|(a, first), (b, second)| a.total_cmp(b).then(second.cmp(first)))
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPECS: &[ParameterSpec] = &[
        ParameterSpec { name: "radius", kind: ParameterKind::Length, default: None, meaning: "radius" },
        ParameterSpec {
            name: "angle_deg",
            kind: ParameterKind::Angle { above: 0.0, below: 90.0 },
            default: Some("45"),
            meaning: "angle",
        },
        ParameterSpec {
            name: "side",
            kind: ParameterKind::Choice(&["behind", "front"]),
            default: Some("behind"),
            meaning: "side",
        },
    ];

    #[test]
    fn defaults_fill_in() {
        let checked = Parameters::new().with("radius", 2.0).checked(SPECS).unwrap();
        assert_eq!((checked.number("angle_deg"), checked.word("side")), (45.0, "behind"));
    }

    #[test]
    fn one_parameter_may_take_the_place_of_another() {
        let radii = ParameterSpec {
            name: "radii",
            kind: ParameterKind::Lengths3,
            default: Some("instead of radius"),
            meaning: "three radii",
        };
        let specs = [SPECS[0], radii];
        let (one, each) = (Parameters::new().with("radius", 1.0), Parameters::new().with("radii", [1.0; 3]));
        for given in [&one, &each] {
            assert_eq!(&given.checked(&specs).unwrap(), given);
        }
        let both = one.with("radii", [1.0; 3]).checked(&specs).unwrap_err();
        assert_eq!(both.to_string(), "parameter `radii` is given beside `radius`; expected one of the two");
        let none = Parameters::new().checked(&specs).unwrap_err();
        assert_eq!(
            none.to_string(),
            "parameter `radius` is missing; expected length > 0: radius, or `radii`"
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        let with_radius = || Parameters::new().with("radius", 1.0);
        let table = [
            (Parameters::new(), "parameter `radius` is missing", None),
            (with_radius().with("radios", 1.0), "parameter `radios` is not known", Some("radius")),
            (Parameters::new().with("radius", -1.0), "`radius` is -1; expected length > 0", None),
            (Parameters::new().with("radius", f64::NAN), "`radius` is NaN", None),
            (with_radius().with("angle_deg", 90.0), "expected angle in degrees, 0 < value < 90", None),
            (with_radius().with("angle_deg", "steep"), "`angle_deg` is a word", None),
            (with_radius().with("side", "fornt"), "\"behind\" or \"front\"", Some("front")),
        ];
        for (parameters, message, nearest) in table {
            let error = parameters.checked(SPECS).unwrap_err();
            assert!(error.to_string().contains(message), "{error}");
            assert_eq!(error.nearest.as_deref(), nearest);
        }
    }

    #[test]
    fn marks_around_a_name_are_easily_forgotten() {
        let faces = ["+x", "-x", "+y", "-y", "+z", "-z"];
        let table = [("x", "+x"), ("Y", "+y"), ("z-", "+z"), ("-X", "-x"), ("+ z", "+z")];
        for (name, expected) in table {
            assert_eq!(nearest(name, faces.into_iter()), Some(expected), "{name}");
        }
        assert_eq!(nearest("?", faces.into_iter()), None);
    }
}
