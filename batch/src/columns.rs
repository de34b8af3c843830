//! Touches out of Arrow record batches.

use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StringArray, cast::AsArray, types::Int64Type};
use arrow_cast::{CastOptions, cast_with_options};
use arrow_ord::partition::partition;
use arrow_schema::{DataType, Field, Schema};
#[cfg(feature = "files")]
use touchref_core::Warning;
use touchref_core::{Fixture, Units};
use touchref_io::{InputError, table::nearest_column};

use crate::{
    NameType,
    placement::{Gathering, Name, Placement},
    touch::{APPROACH, AT, Row},
};

/// The columns that a table must have.
const REQUIRED: [&str; 5] = ["placement", "surface", "x", "y", "z"];
/// The columns that it may have beside them.
const OPTIONAL: [&str; 5] = ["sigma", "i", "j", "k", "units"];
/// What a field or a schema says under this key is the unit of its lengths.
pub const UNITS_KEY: &str = "units";
/// The columns that are lengths.
const LENGTHS: [&str; 4] = ["x", "y", "z", "sigma"];

/// Where the rows of a batch stand, for messages.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Rows<'a> {
    /// The file.
    pub(crate) file: Option<&'a str>,
    /// The row group, from 0.
    pub(crate) group: Option<usize>,
    /// The number of the first row, from 0.
    pub(crate) first: u64,
}

impl Rows<'_> {
    fn told(&self, row: usize) -> String {
        let file = self.file.map_or(String::new(), |file| format!("{file}, "));
        let group = self.group.map_or(String::new(), |group| format!("row group {group}, "));
        format!("{file}{group}row {}", self.first + row as u64)
    }
}

/// Checks that a table has the columns that touches need, of types that can be theirs, and in the right unit.
///
/// # Errors
/// `missing-column`, `unknown-column` for one that is misspelt, and `invalid-input` for a type or a unit that is wrong.
pub(crate) fn check(schema: &Schema, units: Units) -> Result<NameType, InputError> {
    for name in REQUIRED {
        if schema.field_with_name(name).is_err() {
            let misspelt = schema.fields().iter().find(|field| nearest_column(field.name()) == Some(name));
            let message = format!("column `{name}` is missing");
            let error = InputError::new("missing-column", message).with_key(name);
            return Err(match misspelt {
                Some(field) => error.with_help(format!("is it `{}`? rename it `{name}`", field.name())),
                None => error.with_help("a table of touches has the columns placement, surface, x, y, z"),
            });
        }
    }
    for field in schema.fields() {
        let name = field.name().as_str();
        let Some(expected) = expected_type(name) else {
            if let Some(near) = nearest_column(name) {
                return Err(InputError::new("unknown-column", format!("column `{name}` is not known"))
                    .with_nearest(Some(near))
                    .with_key(name));
            }
            continue;
        };
        if !expected.admits(field.data_type()) {
            let message = format!("column `{name}` is {}; expected {}", field.data_type(), expected.words());
            return Err(InputError::new("invalid-input", message).with_key(name));
        }
        if LENGTHS.contains(&name) {
            check_units(schema, field, units)?;
        }
    }
    if let Some(alone) = APPROACH.iter().find(|name| schema.field_with_name(name).is_err())
        && APPROACH.iter().any(|name| schema.field_with_name(name).is_ok())
    {
        return Err(InputError::new("missing-column", format!("column `{alone}` is missing"))
            .with_key(*alone)
            .with_help("the approach direction takes all three of i, j, k, or none"));
    }
    let placement = schema.field_with_name("placement").map(Field::data_type);
    Ok(if placement.is_ok_and(DataType::is_integer) { NameType::Integer } else { NameType::Text })
}

/// The unit that a table states for a column must be that of the measurement.
fn check_units(schema: &Schema, field: &Field, units: Units) -> Result<(), InputError> {
    let stated = field.metadata().get(UNITS_KEY).or_else(|| schema.metadata().get(UNITS_KEY));
    match stated {
        Some(stated) if stated != units.name() => {
            let name = field.name();
            let message = format!(
                "column `{name}` is in `{stated}`, but the measurement in `{units}`: lengths are not converted"
            );
            Err(InputError::new("invalid-input", message)
                .with_key(name.as_str())
                .with_help("state the table's unit in the measurement, with all its lengths"))
        }
        _ => Ok(()),
    }
}

/// What a column may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Name,
    Text,
    Number,
}

/// The columns of a file of which touches are not made, and that tell nothing of them either.
#[cfg(feature = "files")]
pub(crate) fn ignored(schema: &Schema, file: &str) -> Vec<Warning> {
    let names = schema.fields().iter().map(|field| field.name().as_str());
    let unused = names.filter(|name| !is_column(name) && *name != "id");
    unused
        .map(|name| {
            let message = format!("column `{name}` of {file} is not used");
            Warning { code: "ignored-column", message }
        })
        .collect()
}

/// Whether touches are made of a column of this name.
#[cfg(feature = "files")]
pub(crate) fn is_column(name: &str) -> bool {
    expected_type(name).is_some()
}

fn expected_type(column: &str) -> Option<Kind> {
    match column {
        "placement" => Some(Kind::Name),
        "surface" | "units" => Some(Kind::Text),
        _ if REQUIRED.contains(&column) || OPTIONAL.contains(&column) => Some(Kind::Number),
        _ => None,
    }
}

impl Kind {
    fn admits(self, found: &DataType) -> bool {
        let text = match found {
            DataType::Dictionary(_, values) => is_text(values),
            other => is_text(other),
        };
        match self {
            Self::Name => text || (found.is_integer() && *found != DataType::UInt64),
            Self::Text => text,
            // All of a number of 32 bits is kept; of others a table of coordinates has no use.
            Self::Number => matches!(
                found,
                DataType::Float64 | DataType::Float32 | DataType::Int8 | DataType::Int16 | DataType::Int32
            ),
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Name => "text, or a signed integer of up to 64 bits",
            Self::Text => "text",
            Self::Number => "a floating-point number, or an integer of up to 32 bits",
        }
    }

    fn cast_to(self, found: &DataType) -> DataType {
        match self {
            Self::Name if found.is_integer() => DataType::Int64,
            Self::Name | Self::Text => DataType::Utf8,
            Self::Number => DataType::Float64,
        }
    }
}

fn is_text(found: &DataType) -> bool {
    matches!(found, DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View)
}

/// The columns of a batch that touches are made of.
struct Columns {
    placement: ArrayRef,
    surface: StringArray,
    at: [Float64Array; 3],
    sigma: Option<Float64Array>,
    approach: [Option<Float64Array>; 3],
    units: Option<StringArray>,
}

impl Columns {
    fn of(batch: &RecordBatch) -> Result<Self, InputError> {
        let text = |name| Ok(column(batch, name)?.map(|array| array.as_string::<i32>().clone()));
        let number = |name| Ok(column(batch, name)?.map(|array| array.as_primitive().clone()));
        let [x, y, z] = AT.map(|name| required(number(name), name));
        let [i, j, k] = APPROACH.map(number);
        Ok(Self {
            placement: required(column(batch, "placement"), "placement")?,
            surface: required(text("surface"), "surface")?,
            at: [x?, y?, z?],
            sigma: number("sigma")?,
            approach: [i?, j?, k?],
            units: text("units")?,
        })
    }

    fn name(&self, row: usize) -> Option<Name> {
        if self.placement.is_null(row) {
            return None;
        }
        match self.placement.as_primitive_opt::<Int64Type>() {
            Some(numbers) => Some(Name::Integer(numbers.value(row))),
            None => Some(self.placement.as_string::<i32>().value(row))
                .filter(|text| !text.is_empty())
                .map(|text| Name::Text(text.to_owned())),
        }
    }

    fn row(&self, row: usize) -> Row<'_> {
        let number = |column: &Float64Array| column.is_valid(row).then(|| column.value(row));
        let at = [&self.at[0], &self.at[1], &self.at[2]];
        Row {
            surface: self.surface.is_valid(row).then(|| self.surface.value(row)),
            at: at.map(number),
            sigma: self.sigma.as_ref().and_then(number),
            approach: [0, 1, 2].map(|axis| self.approach[axis].as_ref().and_then(number)),
            units: self.units.as_ref().and_then(|units| units.is_valid(row).then(|| units.value(row))),
        }
    }
}

fn required<T>(found: Result<Option<T>, InputError>, name: &str) -> Result<T, InputError> {
    let missing = || InputError::new("missing-column", format!("column `{name}` is missing")).with_key(name);
    found?.ok_or_else(missing)
}

/// A column in the type that it is read as; `None` where there is none.
fn column(batch: &RecordBatch, name: &str) -> Result<Option<ArrayRef>, InputError> {
    let (Some(array), Some(kind)) = (batch.column_by_name(name), expected_type(name)) else {
        return Ok(None);
    };
    let exact = CastOptions { safe: false, ..CastOptions::default() };
    let cast = cast_with_options(array, &kind.cast_to(array.data_type()), &exact);
    cast.map(Some)
        .map_err(|error| InputError::new("invalid-input", format!("column `{name}`: {error}")).with_key(name))
}

/// Adds the rows of a batch to the placements, and hands out those that are complete.
///
/// # Errors
/// A placement that comes again or has no name; what is wrong with a row otherwise concerns its placement only.
pub(crate) fn gather(
    batch: &RecordBatch,
    rows: Rows<'_>,
    fixture: &dyn Fixture,
    units: Units,
    gathering: &mut Gathering,
    mut complete: impl FnMut(Placement),
) -> Result<(), InputError> {
    let columns = Columns::of(batch)?;
    let ranges = partition(std::slice::from_ref(&columns.placement)).map_err(|error| {
        InputError::new("invalid-input", format!("column `placement`: {error}")).with_key("placement")
    })?;
    for range in ranges.ranges() {
        let Some(name) = columns.name(range.start) else {
            let message = format!("{}: the touch belongs to no placement", rows.told(range.start));
            return Err(InputError::new("invalid-input", message).with_key("placement"));
        };
        for row in range {
            let touch = columns.row(row).touch(fixture, units, || rows.told(row));
            if let Some(placement) = gathering.add(&name, touch, || rows.told(row))? {
                complete(placement);
            }
        }
    }
    Ok(())
}
