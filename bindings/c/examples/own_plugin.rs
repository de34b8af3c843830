//! The C library with a fixture of the house linked in: a cube of one size, which C finds by its name.
//!
//! ```text
//! cargo build -p touchref-c --example own_plugin
//! ```
//!
//! gives `target/debug/examples/libown_plugin.so`, to be linked in place of `libtouchref_c.so`. In a crate of your own it is a
//! library of `crate-type = ["cdylib"]` that depends on `touchref` and `touchref-c`. A static library will not do: what is
//! registered reaches it only where rustc itself links.

use touchref::{FixturePlugin, Parameters, fixtures::cube, register_fixture};
// Puts every function of `touchref.h` into the library.
use touchref_c as _;

static PLUGIN: FixturePlugin = FixturePlugin {
    name: "house-block",
    summary: "the cube of 80 mm that stands in every cell",
    origin: module_path!(),
    parameters: &[],
    build: |_| cube::PLUGIN.build(&Parameters::new().with("edge", 80.0)),
    ..cube::PLUGIN
};
register_fixture!(PLUGIN);
