//! The registry: plugins by name.
//!
//! A plugin is a `static` carrier of its description and a build function. It comes into a [`Registry`] by two ways
//! that are merged: `inventory`, which collects what [`register_fixture!`](crate::register_fixture),
//! [`register_solver!`](crate::register_solver) and [`register_dialect!`](crate::register_dialect) submitted from any
//! crate that the program names, and the explicit lists that a caller hands in. The second exists because `inventory` alone yields nothing where a linker other
//! than rustc's drops the submissions (a static library linked by a C linker, wasm32). A plugin that came both ways
//! counts once.

use std::fmt;

use thiserror::Error;

use crate::{
    Dialect, Fixture, Solver,
    parameters::{ParameterError, ParameterSpec, Parameters, nearest},
};

/// A kind of fixture, by name.
#[derive(Debug)]
pub struct FixturePlugin {
    /// The `kind` in a measurement file.
    pub name: &'static str,
    /// What it is, in one line.
    pub summary: &'static str,
    /// Crate and module it comes from: `module_path!()`.
    pub origin: &'static str,
    /// Its parameters, in the order in which help shows them.
    pub parameters: &'static [ParameterSpec],
    /// Its surfaces: name and what it is; none where its parameters state them.
    pub surfaces: &'static [(&'static str, &'static str)],
    /// How many touches it needs, in words.
    pub touches: &'static str,
    /// Where its frame's origin and axes are, in words.
    pub frame: &'static str,
    /// The frame drawn in text.
    pub drawing: &'static str,
    /// Paper, book or standard it comes from.
    pub reference: &'static str,
    /// Builds one from checked parameters.
    pub build: fn(&Parameters) -> Result<Box<dyn Fixture>, ParameterError>,
}

/// A way to solve, by name.
#[derive(Debug)]
pub struct SolverPlugin {
    /// The name that `--solver` takes.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// Crate and module it comes from: `module_path!()`.
    pub origin: &'static str,
    /// Its parameters.
    pub parameters: &'static [ParameterSpec],
    /// What it does and when to take it, in a paragraph.
    pub about: &'static str,
    /// Paper, book or standard it comes from.
    pub reference: &'static str,
    /// Builds one from checked parameters.
    pub build: fn(&Parameters) -> Result<Box<dyn Solver>, ParameterError>,
}

/// A way to write a frame, by name.
#[derive(Debug)]
pub struct DialectPlugin {
    /// The name that `--dialect` takes.
    pub name: &'static str,
    /// For which machine or program it is, in one line.
    pub summary: &'static str,
    /// Crate and module it comes from: `module_path!()`.
    pub origin: &'static str,
    /// Its parameters, in the order in which `--dialect NAME:VALUE:VALUE` gives them.
    pub parameters: &'static [ParameterSpec],
    /// Manual, standard or source that tells its convention.
    pub reference: &'static str,
    /// Builds one from checked parameters.
    pub build: fn(&Parameters) -> Result<Box<dyn Dialect>, ParameterError>,
}

/// What every plugin has.
pub trait Plugin: fmt::Debug + Sync {
    /// Which kind of thing it makes: `fixture`, `solver` or `dialect`.
    const KIND: &'static str;
    /// What it makes.
    type Product: ?Sized;
    /// The name that finds it.
    fn name(&self) -> &'static str;
    /// What it is, in one line.
    fn summary(&self) -> &'static str;
    /// Crate and module it comes from.
    fn origin(&self) -> &'static str;
    /// Its parameters.
    fn parameters(&self) -> &'static [ParameterSpec];
    /// Checks the parameters against their descriptions, then builds.
    ///
    /// # Errors
    /// The first parameter that is unknown, missing or out of its range.
    fn build(&self, parameters: &Parameters) -> Result<Box<Self::Product>, ParameterError>;
}

macro_rules! plugin {
    ($type:ty, $kind:literal, $product:ty) => {
        impl Plugin for $type {
            const KIND: &'static str = $kind;
            type Product = $product;
            fn name(&self) -> &'static str {
                self.name
            }
            fn summary(&self) -> &'static str {
                self.summary
            }
            fn origin(&self) -> &'static str {
                self.origin
            }
            fn parameters(&self) -> &'static [ParameterSpec] {
                self.parameters
            }
            fn build(&self, parameters: &Parameters) -> Result<Box<$product>, ParameterError> {
                (self.build)(&parameters.checked(self.parameters)?)
            }
        }

        // The same without the trait in scope.
        impl $type {
            /// Checks the parameters against their descriptions, then builds.
            ///
            /// # Errors
            /// The first parameter that is unknown, missing or out of its range.
            pub fn build(&self, parameters: &Parameters) -> Result<Box<$product>, ParameterError> {
                Plugin::build(self, parameters)
            }
        }
    };
}
plugin!(FixturePlugin, "fixture", dyn Fixture);
plugin!(SolverPlugin, "solver", dyn Solver);
plugin!(DialectPlugin, "dialect", dyn Dialect);

/// What `inventory` carries for a fixture; made by [`register_fixture!`](crate::register_fixture).
#[derive(Debug)]
pub struct FixtureEntry(pub &'static FixturePlugin);
/// What `inventory` carries for a solver; made by [`register_solver!`](crate::register_solver).
#[derive(Debug)]
pub struct SolverEntry(pub &'static SolverPlugin);
/// What `inventory` carries for a dialect; made by [`register_dialect!`](crate::register_dialect).
#[derive(Debug)]
pub struct DialectEntry(pub &'static DialectPlugin);
inventory::collect!(FixtureEntry);
inventory::collect!(SolverEntry);
inventory::collect!(DialectEntry);

/// Registers a `static` [`FixturePlugin`] so that every program that names its crate finds it.
#[macro_export]
macro_rules! register_fixture {
    ($plugin:path) => {
        $crate::inventory::submit! { $crate::FixtureEntry(&$plugin) }
    };
}

/// Registers a `static` [`SolverPlugin`] so that every program that names its crate finds it.
#[macro_export]
macro_rules! register_solver {
    ($plugin:path) => {
        $crate::inventory::submit! { $crate::SolverEntry(&$plugin) }
    };
}

/// Registers a `static` [`DialectPlugin`] so that every program that names its crate finds it.
#[macro_export]
macro_rules! register_dialect {
    ($plugin:path) => {
        $crate::inventory::submit! { $crate::DialectEntry(&$plugin) }
    };
}

/// Every plugin that is linked in, sorted by name; a snapshot.
#[derive(Debug, Clone)]
pub struct Registry {
    fixtures: Vec<&'static FixturePlugin>,
    solvers: Vec<&'static SolverPlugin>,
    dialects: Vec<&'static DialectPlugin>,
}

impl Registry {
    /// What `inventory` collected, and these lists.
    ///
    /// # Errors
    /// [`RegistryError::Duplicate`] when two different plugins of one kind have one name.
    pub fn linked(
        fixtures: &[&'static FixturePlugin],
        solvers: &[&'static SolverPlugin],
        dialects: &[&'static DialectPlugin],
    ) -> Result<Self, RegistryError> {
        let submitted_fixtures = inventory::iter::<FixtureEntry>().map(|entry| entry.0);
        let submitted_solvers = inventory::iter::<SolverEntry>().map(|entry| entry.0);
        let submitted_dialects = inventory::iter::<DialectEntry>().map(|entry| entry.0);
        Ok(Self {
            fixtures: merged(submitted_fixtures.chain(fixtures.iter().copied()))?,
            solvers: merged(submitted_solvers.chain(solvers.iter().copied()))?,
            dialects: merged(submitted_dialects.chain(dialects.iter().copied()))?,
        })
    }

    /// The fixtures, sorted by name.
    #[must_use]
    pub fn fixtures(&self) -> &[&'static FixturePlugin] {
        &self.fixtures
    }

    /// The solvers, sorted by name.
    #[must_use]
    pub fn solvers(&self) -> &[&'static SolverPlugin] {
        &self.solvers
    }

    /// The dialects, sorted by name.
    #[must_use]
    pub fn dialects(&self) -> &[&'static DialectPlugin] {
        &self.dialects
    }

    /// The fixture of that name.
    ///
    /// # Errors
    /// [`RegistryError::Unknown`], with the nearest known name.
    pub fn fixture(&self, name: &str) -> Result<&'static FixturePlugin, RegistryError> {
        find(&self.fixtures, name)
    }

    /// The solver of that name.
    ///
    /// # Errors
    /// [`RegistryError::Unknown`], with the nearest known name.
    pub fn solver(&self, name: &str) -> Result<&'static SolverPlugin, RegistryError> {
        find(&self.solvers, name)
    }

    /// The dialect of that name.
    ///
    /// # Errors
    /// [`RegistryError::Unknown`], with the nearest known name.
    pub fn dialect(&self, name: &str) -> Result<&'static DialectPlugin, RegistryError> {
        find(&self.dialects, name)
    }
}

fn merged<P: Plugin>(plugins: impl Iterator<Item = &'static P>) -> Result<Vec<&'static P>, RegistryError> {
    let mut all: Vec<&'static P> = plugins.collect();
    // The order of collection differs between builds; names, then origins, do not.
    all.sort_by_key(|plugin| (plugin.name(), plugin.origin()));
    all.dedup_by(|a, b| std::ptr::eq(*a, *b));
    match all.windows(2).find(|pair| pair[0].name() == pair[1].name()) {
        Some(pair) => Err(RegistryError::Duplicate {
            kind: P::KIND,
            name: pair[0].name(),
            first: pair[0].origin(),
            second: pair[1].origin(),
        }),
        None => Ok(all),
    }
}

fn find<P: Plugin>(all: &[&'static P], name: &str) -> Result<&'static P, RegistryError> {
    all.iter().copied().find(|plugin| plugin.name() == name).ok_or_else(|| RegistryError::Unknown {
        kind: P::KIND,
        name: name.to_owned(),
        known: all.iter().map(|plugin| plugin.name()).collect(),
        nearest: nearest(name, all.iter().map(|plugin| plugin.name())),
    })
}

/// A name that finds no plugin, or more than one.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RegistryError {
    /// No plugin has this name.
    #[error("no {kind} is named `{name}`; known: {}", known.join(", "))]
    Unknown {
        /// `fixture`, `solver` or `dialect`.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<&'static str>,
        /// The one nearest to the name asked for.
        nearest: Option<&'static str>,
    },
    /// Two plugins of one kind have one name.
    #[error("two {kind}s are named `{name}`: one from `{first}`, one from `{second}`")]
    Duplicate {
        /// `fixture`, `solver` or `dialect`.
        kind: &'static str,
        /// The name they share.
        name: &'static str,
        /// Where one comes from.
        first: &'static str,
        /// Where the other comes from.
        second: &'static str,
    },
}
