//! Measurement files, touch tables and results of touchref.
//!
//! * [`Measurement`]: fixture, probe and touches from TOML or JSON;
//! * [`parameter`]: parameters of plugins from arguments;
//! * [`table`]: touch tables (CSV), read row by row;
//! * [`log`]: touches from the logs of machines;
//! * [`solution`], [`calibration`] and [`refusal`]: the JSON of a frame, of a calibration, and of an error;
//! * [`frame`]: frames as text;
//! * [`dialect`]: a frame in the words of the machine that will use it;
//! * [`export`]: results in the forms that other programs read;
//! * [`schema`]: JSON Schema of all of these;
//! * [`number`] and [`words`]: numbers as text, and what results say, in words;
//! * [`mod@write`]: measurement files and touch tables as text;
//! * `history`, a feature of that name: results kept over time.
//!
//! Whatever is wrong with an input is an [`InputError`] that names the file, line, column and key, and the nearest
//! right name. Lengths stay in the unit that the file states: only a dialect that has a unit of its own, and a log in another
//! one, are converted, and nothing is guessed.

pub mod calibration;
pub mod dialect;
pub mod error;
pub mod export;
pub mod frame;
#[cfg(feature = "history")]
pub mod history;
pub mod log;
pub mod measurement;
pub mod number;
pub mod parameter;
pub mod refusal;
pub mod schema;
pub mod solution;
pub mod source;
pub mod table;
mod tree;
mod walk;
pub mod words;
pub mod write;

pub use calibration::CalibrationRecord;
pub use error::InputError;
pub use frame::{FrameRecord, read_frame};
pub use measurement::{Measurement, PlacementSource, PlacementTouches, TouchRecord, TouchSource, Touches};
pub use refusal::ErrorRecord;
pub use solution::SolutionRecord;
pub use source::{Input, Place};
pub use touchref_core::Units;
