//! The C interface of touchref: `include/touchref.h`, which is made from this crate.
//!
//! README.md beside it tells how to build, link and use it. In Rust depend on `touchref` instead; on this crate only to
//! link plugins of your own into the library: `examples/own_plugin.rs`.
//!
//! `interface` has what C sees, `foreign` reads the caller's memory, `error` keeps panics in; the rest is safe Rust on top
//! of [`touchref::locate`].

mod error;
mod fixture;
mod foreign;
mod interface;
mod solution;

use std::ffi::CString;

pub use error::Error;
pub use fixture::Fixture;
pub use foreign::Text;
pub use interface::*;
pub use solution::{Literal, Solution};

/// A string for C, which ends at the first zero byte: there is none in what is told but by a file's doing.
fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "?")).unwrap_or_default()
}
