//! Placements: the touches that were made while the fixture stood at one place.

use std::{
    collections::{HashMap, HashSet},
    fmt,
};

use roaring::RoaringTreemap;
use touchref_core::Touch;
use touchref_io::InputError;

use crate::NameType;

/// What a placement is called.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Name {
    /// A number.
    Integer(i64),
    /// A text.
    Text(String),
}

impl Name {
    /// What it is.
    #[must_use]
    pub fn name_type(&self) -> NameType {
        match self {
            Self::Integer(_) => NameType::Integer,
            Self::Text(_) => NameType::Text,
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(number) => number.fmt(f),
            Self::Text(text) => text.fmt(f),
        }
    }
}

/// The touches of one placement, or what is wrong with the first of them that is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// What it is called.
    pub name: Name,
    /// How many rows of the table are its.
    pub rows: u64,
    /// Its touches, in the order of the table.
    pub touches: Result<Vec<Touch>, InputError>,
}

/// Makes placements of touches that come one after the other.
///
/// The touches of a placement stand together, so that a table may be of any length. One that comes again, when its
/// frame may be told already, is an error.
#[derive(Debug, Default)]
pub(crate) struct Gathering {
    current: Option<Placement>,
    seen: Seen,
}

impl Gathering {
    /// Adds a touch, and returns the placement that is complete as the touch is of another; `row` says where the touch
    /// stands.
    ///
    /// # Errors
    /// A placement that comes again.
    pub(crate) fn add(
        &mut self,
        name: &Name,
        touch: Result<Touch, InputError>,
        row: impl FnOnce() -> String,
    ) -> Result<Option<Placement>, InputError> {
        if let Some(current) = &mut self.current
            && current.name == *name
        {
            current.rows += 1;
            match (&mut current.touches, touch) {
                (Ok(touches), Ok(touch)) => touches.push(touch),
                (Ok(_), Err(error)) => current.touches = Err(error),
                (Err(_), _) => {}
            }
            return Ok(None);
        }
        if !self.seen.insert(name) {
            let message = format!("{}: placement `{name}` comes again after others", row());
            return Err(InputError::new("invalid-input", message)
                .with_key("placement")
                .with_help("the touches of a placement stand together: sort the table by `placement`"));
        }
        let next = Placement { name: name.clone(), rows: 1, touches: touch.map(|touch| vec![touch]) };
        Ok(self.current.replace(next))
    }

    /// The last placement, at the end of the touches.
    pub(crate) fn finish(&mut self) -> Option<Placement> {
        self.current.take()
    }
}

/// The names that came already. Numbers, and texts that end in one, take little room however many they are.
#[derive(Debug, Default)]
struct Seen {
    integers: RoaringTreemap,
    /// The numbers at the end of texts, by what is before them and by how many digits they have.
    numbered: HashMap<(String, usize), RoaringTreemap>,
    others: HashSet<String>,
}

impl Seen {
    /// Longer numbers do not fit into 64 bits.
    const MOST_DIGITS: usize = 18;
    /// Beyond so many beginnings of texts there is nothing to be saved by telling them apart.
    const MOST_BEGINNINGS: usize = 1024;

    /// Whether the name is new.
    fn insert(&mut self, name: &Name) -> bool {
        match name {
            // The bits of a number tell it from every other.
            Name::Integer(number) => self.integers.insert(number.cast_unsigned()),
            Name::Text(text) => self.insert_text(text),
        }
    }

    fn insert_text(&mut self, text: &str) -> bool {
        if self.others.contains(text) {
            return false;
        }
        let beginning = text.trim_end_matches(|c: char| c.is_ascii_digit());
        let number = &text[beginning.len()..];
        if let Ok(value) = number.parse()
            && number.len() <= Self::MOST_DIGITS
        {
            let key = (beginning.to_owned(), number.len());
            let room = self.numbered.len() < Self::MOST_BEGINNINGS;
            if room || self.numbered.contains_key(&key) {
                return self.numbered.entry(key).or_default().insert(value);
            }
        }
        self.others.insert(text.to_owned())
    }
}
