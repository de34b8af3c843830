//! Results and failures for people.

mod batch;
mod calibration;
mod comparison;
mod element;
mod failure;
mod gauge;
mod guide;
mod history;
mod log;
mod plan;
mod plugins;
mod reliability;
mod search;
mod sheet;
mod solution;
mod study;
mod uncertainty;

use touchref::io::number;

pub(crate) use batch::batch;
pub(crate) use calibration::calibration;
pub(crate) use comparison::comparison;
pub(crate) use element::element;
pub(crate) use failure::failure;
pub(crate) use gauge::gauge;
pub(crate) use guide::answer;
pub(crate) use history::history;
pub(crate) use log::log;
pub(crate) use plan::{next, plan};
pub(crate) use plugins::{description, listing, schemas};
pub(crate) use reliability::reliability;
pub(crate) use search::search;
pub(crate) use solution::solution;
pub(crate) use study::study;
pub(crate) use uncertainty::uncertainty;

/// How text may look where it is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Look {
    /// On a terminal: fit tables to its width, and colours.
    pub(crate) terminal: bool,
    /// Box drawing and signs beyond ASCII.
    pub(crate) unicode: bool,
    /// Columns of a line of prose.
    pub(crate) width: usize,
}

/// A line for standard error: whole where a program may read it, wrapped on a terminal.
pub(crate) fn note(line: &str, look: Look) -> String {
    if look.terminal { textwrap::fill(line, look.width) } else { line.to_owned() }
}

impl Look {
    /// For a file or a pipe: plain ASCII, nothing that depends on where it runs.
    pub(crate) const PLAIN: Self = Self { terminal: false, unicode: false, width: 100 };
}
