//! The subcommands, one file each: what was typed becomes what is to be printed.

pub(crate) mod batch;
pub(crate) mod calibrate;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod describe;
pub(crate) mod element;
pub(crate) mod export;
pub(crate) mod gauge;
pub(crate) mod guide;
pub(crate) mod history;
pub(crate) mod list;
pub(crate) mod locate;
pub(crate) mod log;
pub(crate) mod man;
pub(crate) mod plan;
pub(crate) mod reliability;
pub(crate) mod report;
pub(crate) mod schema;
pub(crate) mod simulate;
pub(crate) mod study;
pub(crate) mod uncertainty;
