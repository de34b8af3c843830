//! Does `global` agree with `least-squares`, and does it list every minimum that random starts find?
//!
//! ```text
//! cargo run --release --example certify_study [TRIALS [SEED]]
//! ```
//!
//! Ten thousand measurements of each layout by default: about ten minutes on two cores.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A study may panic, and prints its figures.

#[path = "../tests/support/mod.rs"]
mod support;

use support::certify::{agreement, completeness};

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>().unwrap());
    let (trials, seed) = (arguments.next().unwrap_or(10_000), arguments.next().unwrap_or(1));
    let [global, other] = ["global", "least-squares"].map(support::solver);
    let layouts: [(&str, &[usize]); 6] = [
        ("cylinder-plane", &[4, 3]),
        ("cylinder-plane", &[5, 4]),
        ("three-sphere", &[3, 3, 3]),
        ("three-sphere", &[4, 4, 4]),
        ("cube", &[3, 0, 2, 0, 1, 0]),
        ("cube", &[3, 0, 3, 0, 3, 0]),
    ];
    for (kind, counts) in layouts {
        let fixture = support::fixture(kind, &support::settings(kind)[0]);
        let agreed = agreement((&*global, &*other), &*fixture, counts, seed, trials);
        println!("{kind} {counts:?}: {agreed:?}");
        let complete = completeness(&*global, &*fixture, counts, seed + 1, trials / 10);
        println!("{kind} {counts:?}: {complete:?}");
    }
}
