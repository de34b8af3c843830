//! Draws the figures of the book anew, into `docs/figures/`.
//!
//! ```text
//! cargo run --release --example figures
//! ```
//!
//! Every number in them is computed here by the library. `tests/book.rs` holds the files against what this draws.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A program for the checkout may panic, and tells what it does.

mod drawn;

use std::{fs, path::Path};

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/figures");
    fs::create_dir_all(&folder).unwrap();
    for (name, picture) in drawn::all() {
        fs::write(folder.join(name), picture).unwrap();
        println!("docs/figures/{name}");
    }
}
