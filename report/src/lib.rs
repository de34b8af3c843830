//! A result of touchref as one HTML page that opens by itself: the verdict in words, a view in three dimensions, charts,
//! tables, the frame in every dialect, and the record of what was measured.
//!
//! The page needs no network and may not use one: its content security policy allows its own style and script, by their
//! hashes, and nothing else. Without JavaScript it shows a drawing in the place of the view. All that comes from a result
//! is escaped.
//!
//! * [`Subject`]: a result, its fixture rebuilt and its numbers held against each other;
//! * [`Scene`]: what there is to draw of it, in numbers;
//! * [`svg`]: its picture;
//! * [`page`]: the page.

mod charts;
mod dialects;
mod page;
mod raw;
pub mod scene;
mod subject;
pub mod svg;
mod verdict;
mod view;

pub use page::{Options, page};
pub use scene::Scene;
pub use subject::Subject;
