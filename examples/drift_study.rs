//! How often does `compare` find a motion where there is none, and how often one that there is?
//!
//! ```text
//! cargo run --release --example drift_study [TRIALS [SEED]]
//! ```
//!
//! Ten thousand pairs of measurements of each fixture by default, of composites one in fifty of these, as their search takes
//! longer. False alarms: the same fixture with the same tip, once with everything exact but the touches, once with a
//! tip and sizes whose errors, drawn once per pair, are common to both measurements; those counted as independent,
//! for comparison; and with the noise told by the residuals. Power: the fixture moved by three standard deviations of the difference,
//! along the motion seen least and the one seen best.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A study may panic, and prints its figures.

#[path = "../tests/support/pairs.rs"]
mod pairs;
#[path = "../tests/support/mod.rs"]
mod support;

use nalgebra::Vector6;
use pairs::{Found, cases};
use touchref::{Twist, analysis::Share};

const ALPHAS: [f64; 3] = [0.05, 0.01, 0.001];

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>().unwrap());
    let (trials, seed) = (arguments.next().unwrap_or(10_000), arguments.next().unwrap_or(1));
    let solver = support::solver("least-squares");
    let still = Twist::from(Vector6::zeros());
    println!("alpha {ALPHAS:?}; intervals of 95 %");
    for case in cases(seed) {
        let trials = if case.plugin.name == "composite" { trials / 50 } else { trials };
        println!("\n{}", case.name);
        for (name, pairs) in case.kinds(&*solver) {
            println!("  false alarms, {name}: {}", told(&pairs.found(trials, &still, &ALPHAS)));
        }
        let exact = case.exact(&*solver);
        for (name, motion) in ["least", "best"].iter().zip(exact.motions(3.0)) {
            println!(
                "  found of 3 sigma along the motion seen {name}: {}",
                told(&exact.found(trials, &motion, &ALPHAS))
            );
        }
    }
}

fn told(found: &[Found]) -> String {
    let part = |found: &Found| {
        let share = Share::of(found.moved, found.pairs).unwrap();
        format!("{:.4} ({:.4} to {:.4}, {} pairs)", share.value, share.low, share.high, found.pairs)
    };
    found.iter().map(part).collect::<Vec<_>>().join("; ")
}
