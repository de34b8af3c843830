//! The targets of the fuzzer (`fuzz/`) without the fuzzer: all their seeds, the examples, and inputs made of these by
//! cutting, joining and damaging. The long run is the fuzzer's: fuzz/README.md.
//!
//! `RUNS=100000 cargo test --release --test fuzz` makes more of them.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a target that panics has found something"
)]

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use rand::{Rng, RngExt};
use rayon::prelude::*;
use touchref::analysis::simulation::generator;

#[path = "../fuzz/src/lib.rs"]
mod targets;

/// Inputs made for each target, where `RUNS` does not say how many.
const RUNS: u64 = 300;
/// Of so many inputs that another target takes one is located: by equations, and everywhere, which takes up to a tenth of a
/// second.
const LOCATE: [(&str, u64); 2] = [("locate", 2), ("locate_everywhere", 10)];
/// The longest input made, in bytes.
const LONGEST: usize = 4096;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Files of a folder and of those in it, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.unwrap().path();
        if path.is_dir() { all.extend(files(&path)) } else { all.push(path) }
    }
    all.sort();
    all
}

/// What a target begins with: its own seeds, and every example that is data.
fn seeds(target: &str) -> Vec<Vec<u8>> {
    let own = files(&folder("fuzz/seeds").join(target));
    let examples =
        files(&folder("examples")).into_iter().filter(|path| path.extension().is_none_or(|of| of != "rs"));
    own.into_iter().chain(examples).map(|path| fs::read(path).unwrap()).collect()
}

/// An input made of one or two seeds.
fn made(seeds: &[Vec<u8>], rng: &mut impl Rng) -> Vec<u8> {
    const PIECES: &[&str] = &[
        "\n", "\"", ",", ";", "[", "]", "{", "}", "-", "1e999", "nan", "0", "\u{e4}", "\u{feff}", "\0", "#",
        "=", "::",
    ];
    let any = |rng: &mut _| seeds[RngExt::random_range(rng, 0..seeds.len())].as_slice();
    let mut input = any(rng).to_vec();
    if rng.random_bool(0.2) {
        let other = any(rng);
        input.truncate(rng.random_range(0..=input.len()));
        input.extend(&other[rng.random_range(0..=other.len())..]);
    }
    for _ in 0..rng.random_range(1..6) {
        let from = rng.random_range(0..=input.len());
        let to = (from + rng.random_range(0..12)).min(input.len());
        match rng.random_range(0..4) {
            0 => drop(input.drain(from..to)),
            1 => input[from..to].iter_mut().for_each(|byte| *byte = rng.random()),
            2 => drop(input.splice(from..from, input[from..to].to_vec())),
            _ => drop(input.splice(from..to, PIECES[rng.random_range(0..PIECES.len())].bytes())),
        }
    }
    input.truncate(LONGEST);
    input
}

#[test]
fn what_holds_of_every_input_holds_of_seeds_and_of_what_is_made_of_them() {
    let runs = std::env::var("RUNS").map_or(RUNS, |runs| runs.parse().unwrap());
    targets::TARGETS.par_iter().enumerate().for_each(|(stream, (name, target))| {
        let seeds = seeds(name);
        let share = LOCATE.iter().find(|(located, _)| located == name).map_or(1, |(_, share)| *share);
        let runs = runs / share;
        for seed in &seeds {
            target(seed);
        }
        let mut rng = generator(20_261_122, stream as u64);
        for run in 0..runs {
            let input = made(&seeds, &mut rng);
            let outcome = std::panic::catch_unwind(|| target(&input));
            assert!(outcome.is_ok(), "{name}, input {run}: {}", String::from_utf8_lossy(&input));
        }
    });
}

/// A target that is not everywhere is never run.
#[test]
fn every_target_has_a_binary_and_seeds() {
    let named = |paths: Vec<PathBuf>| -> BTreeSet<String> {
        paths.iter().map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
    };
    let targets: BTreeSet<String> = targets::TARGETS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(named(files(&folder("fuzz/fuzz_targets"))), targets);
    for importer in touchref::io::log::ALL {
        let target = format!("log_{}", importer.name.replace('-', "_"));
        assert!(targets.contains(&target), "no target reads logs of {}", importer.name);
    }
    let manifest = fs::read_to_string(folder("fuzz/Cargo.toml")).unwrap();
    for name in &targets {
        assert!(manifest.contains(&format!("name = \"{name}\"\n")), "{name}");
        targets::run(name, b"");
    }
    let all: u64 = files(&folder("fuzz/seeds")).iter().map(|path| fs::metadata(path).unwrap().len()).sum();
    assert!(all < 200_000, "seeds are small: {all} bytes");
}
