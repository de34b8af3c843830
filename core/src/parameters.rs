//! Parameters of plugins: one description feeds validation, `list`, `describe`, help and docs.

use std::fmt;

use nalgebra::Vector3;
use thiserror::Error;

/// What a plugin says of one of its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSpec {
    /// The key in a measurement file.
    pub name: &'static str,
    /// Which values it takes.
    pub kind: ParameterKind,
    /// The value taken when it is not given, or [`INSTEAD_OF`] another, or [`BY`] others; `None` for a parameter that must be given.
    pub default: Option<&'static str>,
    /// What it means, in one line.
    pub meaning: &'static str,
}

/// How the default of a parameter begins that may take the place of another one, and else is left out:
/// `"instead of radius"`.
pub const INSTEAD_OF: &str = "instead of ";

/// How the default of a parameter begins that may be left out and is then worked out from others, in words:
/// `"by the fixture's size"`.
pub const BY: &str = "by ";

impl ParameterSpec {
    /// Whether it may be left out, and others tell what takes its place.
    #[must_use]
    pub fn is_derived(&self) -> bool {
        self.default.is_some_and(|default| default.starts_with(BY))
    }

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
    /// A word that the user chooses, not empty.
    Name,
    /// Any of these words, each at most once.
    Words(&'static [&'static str]),
    /// A coordinate: a length of either sign.
    Coordinate,
    /// A point: three coordinates.
    Point,
    /// A direction: three numbers, not all zero.
    Direction,
    /// Any number of tables, at least one; each has `type`, which says what else it has.
    Tables(&'static [TableSpec]),
}

/// What a plugin says of one type of the tables that it takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableSpec {
    /// The word that `type` has.
    pub name: &'static str,
    /// What else such a table has.
    pub parameters: &'static [ParameterSpec],
}

/// The key that tells a table's type.
pub const TYPE: &str = "type";

impl fmt::Display for ParameterKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length => write!(f, "length > 0"),
            Self::Lengths3 => write!(f, "[length, length, length], each > 0"),
            Self::Angle { above, below } => write!(f, "angle in degrees, {above} < value < {below}"),
            Self::Choice(words) => write!(f, "\"{}\"", words.join("\" or \"")),
            Self::Flag => write!(f, "true or false"),
            Self::Name => write!(f, "a word"),
            Self::Words(words) => write!(f, "a list of \"{}\"", words.join("\", \"")),
            Self::Coordinate => write!(f, "length"),
            Self::Point => write!(f, "[length, length, length]"),
            Self::Direction => write!(f, "direction [i, j, k], not all zero"),
            Self::Tables(specs) => {
                let types = specs.iter().map(|spec| spec.name).collect::<Vec<_>>().join("\" or \"");
                write!(f, "tables, each with {TYPE} = \"{types}\"")
            }
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
    /// Several words.
    Words(Vec<String>),
    /// Tables of parameters of their own.
    Tables(Vec<Parameters>),
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
            Self::Words(_) => "a list of words",
            Self::Tables(_) => "a list of tables",
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

impl From<Vec<Parameters>> for Value {
    fn from(tables: Vec<Parameters>) -> Self {
        Self::Tables(tables)
    }
}

impl From<&[&str]> for Value {
    fn from(words: &[&str]) -> Self {
        Self::Words(words.iter().map(|word| (*word).to_owned()).collect())
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

    /// Sets a number by the name of the [dimension](crate::Dimension) that it is: one of a list (`radii[1]`), one of the
    /// table of that name (`bore.radius`), or a parameter of its own. A list has no uncertainties.
    pub fn set_number(&mut self, name: &str, value: f64, u: f64) {
        for (known, of_known) in &mut self.0 {
            match of_known {
                Value::Numbers(numbers) => {
                    let index = name.strip_prefix(known.as_str()).and_then(|rest| rest.strip_prefix('['));
                    let index = index.and_then(|rest| rest.strip_suffix(']')?.parse::<usize>().ok());
                    if let Some(number) = index.and_then(|index| numbers.get_mut(index)) {
                        *number = value;
                        return;
                    }
                }
                Value::Tables(tables) => {
                    for table in tables {
                        // A name may have a dot in it: only a key that the table has tells that it is this one.
                        let key = name.strip_prefix(table.word("name"));
                        let key = key.and_then(|rest| rest.strip_prefix('.'));
                        if let Some(key) = key.filter(|key| table.get(key).is_some()) {
                            table.set(key, Value::Number { value, u });
                            return;
                        }
                    }
                }
                _ => {}
            }
        }
        self.set(name, Value::Number { value, u });
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
        let mut given = Self::new();
        for (name, value) in self.iter() {
            let spec = specs.iter().find(|spec| spec.name == name).ok_or_else(|| {
                let known = specs.iter().map(|spec| spec.name);
                ParameterError::unknown(name, known)
            })?;
            given.set(name, check(spec, value)?);
        }
        let mut complete = Self::new();
        for spec in specs {
            let replacement = specs.iter().find(|other| other.replaces() == Some(spec.name));
            let replaced_by = replacement.filter(|other| given.get(other.name).is_some());
            match (given.get(spec.name), replaced_by, spec.default) {
                (Some(_), Some(other), _) => {
                    return Err(ParameterError {
                        name: other.name.to_owned(),
                        problem: format!("is given beside `{}`", spec.name),
                        expected: "one of the two".to_owned(),
                        nearest: None,
                        fault: Fault::Wrong,
                    });
                }
                (Some(value), ..) => complete.set(spec.name, value.clone()),
                (None, Some(_), _) => {}
                (None, None, Some(default)) => {
                    if spec.replaces().is_none()
                        && !spec.is_derived()
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
                        fault: Fault::Missing,
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

    /// The three numbers of that name; zeros where there are none.
    #[must_use]
    pub fn vector(&self, name: &str) -> Vector3<f64> {
        match self.get(name) {
            Some(Value::Numbers(numbers)) if numbers.len() == 3 => Vector3::from_column_slice(numbers),
            _ => Vector3::zeros(),
        }
    }

    /// The words of that name.
    #[must_use]
    pub fn words(&self, name: &str) -> &[String] {
        match self.get(name) {
            Some(Value::Words(words)) => words,
            _ => &[],
        }
    }

    /// The tables of that name.
    #[must_use]
    pub fn tables(&self, name: &str) -> &[Parameters] {
        match self.get(name) {
            Some(Value::Tables(tables)) => tables,
            _ => &[],
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
        ParameterKind::Length | ParameterKind::Angle { .. } | ParameterKind::Coordinate => {
            text.parse::<f64>().ok().map(Value::from)
        }
        ParameterKind::Lengths3 | ParameterKind::Point | ParameterKind::Direction => {
            let inside = text.trim_start_matches('[').trim_end_matches(']');
            let numbers = inside.split(',').map(|part| part.trim().parse()).collect::<Result<Vec<f64>, _>>();
            numbers.ok().map(Value::Numbers)
        }
        ParameterKind::Choice(_) | ParameterKind::Name => Some(Value::from(text)),
        ParameterKind::Flag => text.parse::<bool>().ok().map(Value::from),
        ParameterKind::Words(_) => {
            let inside = text.trim_start_matches('[').trim_end_matches(']');
            let words: Vec<&str> = inside
                .split(',')
                .map(|word| word.trim().trim_matches('"'))
                .filter(|word| !word.is_empty())
                .collect();
            Some(Value::from(words.as_slice()))
        }
        ParameterKind::Tables(_) => None,
    }
}

/// Lengths that a fixture may have: squares of these, and of their squares, are numbers. Others are no lengths in any unit.
pub const LENGTHS: std::ops::Range<f64> = 1e-60..1e60;

/// The value, if it is one of its kind; defaults filled in where it has parameters of its own.
fn check(spec: &ParameterSpec, value: &Value) -> Result<Value, ParameterError> {
    let positive = |v: f64| LENGTHS.contains(&v);
    let coordinate = |v: f64| v.abs() < LENGTHS.end;
    let told = |v: f64| {
        if v.is_finite() && v > 0.0 {
            format!("is {v:e}, not from {:e} to {:e}", LENGTHS.start, LENGTHS.end)
        } else {
            format!("is {v}")
        }
    };
    let three = |numbers: &[f64], right: &dyn Fn(f64) -> bool| {
        (numbers.len() != 3 || !numbers.iter().all(|v| right(*v))).then(|| format!("is {numbers:?}"))
    };
    let wrong = |problem: String, nearest: Option<&str>| ParameterError {
        name: spec.name.to_owned(),
        problem,
        expected: spec.kind.to_string(),
        nearest: nearest.map(str::to_owned),
        fault: Fault::Wrong,
    };
    let problem = match (spec.kind, value) {
        (ParameterKind::Length, Value::Number { value, u }) => {
            uncertainty_problem(*u).or_else(|| (!positive(*value)).then(|| told(*value)))
        }
        (ParameterKind::Angle { above, below }, Value::Number { value, u }) => uncertainty_problem(*u)
            .or_else(|| (!(*value > above && *value < below)).then(|| format!("is {value}"))),
        (ParameterKind::Coordinate, Value::Number { value, u }) => {
            (!coordinate(*value) || *u != 0.0).then(|| format!("is {value}, with the uncertainty {u}"))
        }
        (ParameterKind::Lengths3, Value::Numbers(numbers)) => three(numbers, &positive),
        (ParameterKind::Point, Value::Numbers(numbers)) => three(numbers, &coordinate),
        (ParameterKind::Direction, Value::Numbers(numbers)) => three(numbers, &f64::is_finite)
            .or_else(|| numbers.iter().all(|v| *v == 0.0).then(|| format!("is {numbers:?}"))),
        (ParameterKind::Choice(words), Value::Word(word)) => {
            if words.contains(&word.as_str()) {
                None
            } else {
                return Err(wrong(format!("is \"{word}\""), nearest(word, words.iter().copied())));
            }
        }
        (ParameterKind::Words(known), Value::Words(words)) => {
            let unknown = words.iter().find(|word| !known.contains(&word.as_str()));
            let again = |index: &usize| words[..*index].contains(&words[*index]);
            match (unknown, (0..words.len()).find(again)) {
                (Some(word), _) => {
                    return Err(wrong(format!("has \"{word}\""), nearest(word, known.iter().copied())));
                }
                (None, Some(index)) => Some(format!("has \"{}\" twice", words[index])),
                (None, None) => None,
            }
        }
        // An empty list may be one of anything.
        (ParameterKind::Words(_), Value::Numbers(numbers)) if numbers.is_empty() => {
            return Ok(Value::Words(Vec::new()));
        }
        (ParameterKind::Tables(_), Value::Numbers(numbers)) if numbers.is_empty() => {
            Some("is empty".to_owned())
        }
        (ParameterKind::Name, Value::Word(word)) => word.trim().is_empty().then(|| "is empty".to_owned()),
        (ParameterKind::Flag, Value::Flag(_)) => None,
        (ParameterKind::Tables(specs), Value::Tables(tables)) => {
            if !tables.is_empty() {
                let checked = tables.iter().enumerate().map(|(index, table)| {
                    checked_table(table, specs)
                        .map_err(|error| error.within(&format!("{}[{index}]", spec.name)))
                });
                return checked.collect::<Result<_, _>>().map(Value::Tables);
            }
            Some("is empty".to_owned())
        }
        (_, other) => Some(format!("is {}", other.kind())),
    };
    problem.map_or_else(|| Ok(value.clone()), |problem| Err(wrong(problem, None)))
}

/// A table by what its type has; the type comes first.
fn checked_table(table: &Parameters, specs: &[TableSpec]) -> Result<Parameters, ParameterError> {
    let types = || specs.iter().map(|spec| spec.name);
    let expected = || format!("\"{}\"", types().collect::<Vec<_>>().join("\" or \""));
    let wrong = |problem: &str, fault| ParameterError {
        name: TYPE.to_owned(),
        problem: problem.to_owned(),
        expected: expected(),
        nearest: None,
        fault,
    };
    let name = match table.get(TYPE) {
        Some(Value::Word(name)) => name,
        Some(other) => return Err(wrong(&format!("is {}", other.kind()), Fault::Wrong)),
        None => return Err(wrong("is missing", Fault::Missing)),
    };
    let Some(spec) = specs.iter().find(|spec| spec.name == name) else {
        let error = wrong(&format!("is \"{name}\""), Fault::Wrong);
        return Err(ParameterError { nearest: nearest(name, types()).map(str::to_owned), ..error });
    };
    let others = Parameters(table.0.iter().filter(|(key, _)| key != TYPE).cloned().collect());
    let mut checked = Parameters::new().with(TYPE, name.as_str());
    checked.0.extend(others.checked(spec.parameters)?.0);
    Ok(checked)
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
    /// In which way it is wrong.
    pub fault: Fault,
}

/// In which way a parameter is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The plugin has no parameter of this name.
    Unknown,
    /// It must be given, and is not.
    Missing,
    /// It has another value than it may have.
    Wrong,
}

impl ParameterError {
    /// A name that none of `known` is.
    pub fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> Self {
        Self {
            name: name.to_owned(),
            problem: "is not known".to_owned(),
            expected: format!("one of {}", known.clone().collect::<Vec<_>>().join(", ")),
            nearest: nearest(name, known).map(str::to_owned),
            fault: Fault::Unknown,
        }
    }

    /// The same of a parameter in a table: `surface[2].radius`.
    #[must_use]
    pub fn within(self, table: &str) -> Self {
        Self { name: format!("{table}.{}", self.name), ..self }
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

    #[test]
    fn lengths_beyond_all_measure_are_refused() {
        for (length, right) in
            [(1e-300, false), (1e-59, true), (1e59, true), (1e300, false), (f64::MAX, false)]
        {
            let checked = Parameters::new().with("radius", length).checked(SPECS);
            assert_eq!(checked.is_ok(), right, "{checked:?}");
            if let Err(error) = checked {
                assert!(error.problem.contains("not from 1e-60 to 1e60"), "{error}");
            }
        }
    }

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
    fn numbers_are_set_by_the_names_of_dimensions() {
        let table = |name: &str| Parameters::new().with("name", name).with("radius", 1.0);
        let tables = Value::Tables(vec![table("a"), table("a.radius"), table("b")]);
        let mut parameters =
            Parameters::new().with("size", 1.0).with("radii", [1.0; 3]).with("surface", tables);
        for name in ["size", "radii[2]", "a.radius.radius", "b.radius"] {
            parameters.set_number(name, 2.0, 0.5);
        }
        let set = Value::Number { value: 2.0, u: 0.5 };
        assert_eq!(parameters.get("size"), Some(&set));
        assert_eq!(parameters.get("radii"), Some(&Value::Numbers(vec![1.0, 1.0, 2.0])));
        let Some(Value::Tables(tables)) = parameters.get("surface") else { panic!("no tables") };
        assert_eq!(tables[0], table("a"));
        for table in &tables[1..] {
            assert_eq!(table.get("radius"), Some(&set));
        }
        assert_eq!(parameters.iter().count(), 3);
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
