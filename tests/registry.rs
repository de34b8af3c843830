//! What must hold for every plugin that is linked in, whoever wrote it; and how the registry answers.

#![allow(clippy::unwrap_used)] // A test may panic.

mod support;

use touchref::{
    Fixture, FixturePlugin, ParameterError, ParameterKind, ParameterSpec, Parameters, Plugin, Probe, Problem,
    Registry, RegistryError, SolverPlugin, Surface, Touch, fixtures, io, parameters::parse, registry,
    solvers,
};

/// Columns of a terminal that a drawing must fit with two of margin.
const COLUMNS: usize = 100;
/// Rounding of a point's distance from its surface, in parts of the fixture's size: a few sums and one square root.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Values for the parameters that must be given, inside their ranges; defaults stand for the others.
fn example(specs: &[ParameterSpec]) -> Parameters {
    let mut parameters = Parameters::new();
    for spec in specs.iter().filter(|spec| spec.default.is_none()) {
        parameters = match spec.kind {
            ParameterKind::Length => parameters.with(spec.name, 10.0),
            ParameterKind::Lengths3 => parameters.with(spec.name, [10.0, 11.0, 12.0]),
            ParameterKind::Angle { above, below } => parameters.with(spec.name, 0.5 * (above + below)),
            ParameterKind::Choice(words) => parameters.with(spec.name, words[0]),
            ParameterKind::Flag => parameters.with(spec.name, false),
            ParameterKind::Tables(_) => {
                parameters.with(spec.name, support::v_block().tables(spec.name).to_vec())
            }
            other => panic!("no example of a value of kind {other}"),
        };
    }
    parameters
}

fn built(plugin: &FixturePlugin) -> Box<dyn Fixture> {
    plugin.build(&example(plugin.parameters)).unwrap()
}

fn is_kebab_case(name: &str) -> bool {
    let word =
        |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
    name.split('-').all(word)
}

/// What `list`, `describe` and the help show of any plugin.
fn assert_described<P: Plugin>(plugin: &P) {
    let name = plugin.name();
    assert!(is_kebab_case(name), "`{name}` is not in kebab case");
    assert!(!plugin.origin().is_empty(), "{name}: no origin");
    let summary = plugin.summary();
    assert!(!summary.trim().is_empty() && summary.lines().count() == 1, "{name}: summary {summary:?}");
    assert!(!summary.ends_with('.'), "{name}: a summary is no sentence: {summary:?}");
    for (index, spec) in plugin.parameters().iter().enumerate() {
        let parameter = spec.name;
        assert!(!spec.meaning.trim().is_empty(), "{name}: `{parameter}` has no meaning");
        let before = &plugin.parameters()[..index];
        assert!(before.iter().all(|other| other.name != parameter), "{name}: `{parameter}` twice");
        if let Some(replaced) = spec.replaces() {
            let known =
                plugin.parameters().iter().any(|other| other.name == replaced && other.default.is_none());
            assert!(known, "{name}: `{parameter}` takes the place of `{replaced}`, which need not be given");
        } else if let Some(default) = spec.default.filter(|_| !spec.is_derived()) {
            let value = parse(spec.kind, default);
            assert!(
                value.is_some(),
                "{name}: the default of `{parameter}`, {default:?}, is no {}",
                spec.kind
            );
        }
    }
    let checked = example(plugin.parameters()).checked(plugin.parameters());
    let checked = checked.unwrap_or_else(|error| panic!("{name}: its own defaults: {error}"));
    let expected =
        plugin.parameters().iter().filter(|spec| spec.replaces().is_none() && !spec.is_derived()).count();
    assert_eq!(checked.iter().count(), expected, "{name}: a default was lost");
}

/// Building (`build` gives what it was refused for) with a parameter that does not exist, or without one that must be
/// given, names that parameter.
fn assert_parameters_are_checked<P: Plugin>(
    plugin: &P,
    build: impl Fn(&Parameters) -> Option<ParameterError>,
) {
    let name = plugin.name();
    let refused = |parameters: &Parameters| {
        build(parameters).unwrap_or_else(|| panic!("{name} was built with {parameters:?}"))
    };
    let complete = example(plugin.parameters());
    assert_eq!(build(&complete), None, "{name} cannot be built with {complete:?}");
    assert_eq!(refused(&complete.clone().with("no_such_parameter", 1.0)).name, "no_such_parameter");
    for missing in plugin.parameters().iter().filter(|spec| spec.default.is_none()) {
        let mut rest = Parameters::new();
        for (other, value) in complete.iter().filter(|(other, _)| *other != missing.name) {
            rest.set(other, value.clone());
        }
        assert_eq!(refused(&rest).name, missing.name, "{name}");
    }
}

#[test]
fn every_plugin_is_described_and_checks_its_parameters() {
    let registry = registry().unwrap();
    for plugin in registry.fixtures() {
        assert_described(*plugin);
        assert_parameters_are_checked(*plugin, |parameters| plugin.build(parameters).err());
    }
    for plugin in registry.solvers() {
        assert_described(*plugin);
        assert_parameters_are_checked(*plugin, |parameters| plugin.build(parameters).err());
    }
    for plugin in registry.dialects() {
        assert_described(*plugin);
        assert_parameters_are_checked(*plugin, |parameters| plugin.build(parameters).err());
    }
}

#[test]
fn every_list_is_sorted_and_its_names_are_unique() {
    fn ascends<P: Plugin>(plugins: &[&P]) -> bool {
        !plugins.is_empty() && plugins.windows(2).all(|pair| pair[0].name() < pair[1].name())
    }
    let registry = registry().unwrap();
    assert!(ascends(registry.fixtures()), "{:?}", registry.fixtures());
    assert!(ascends(registry.solvers()), "{:?}", registry.solvers());
    assert!(ascends(registry.dialects()), "{:?}", registry.dialects());
}

#[test]
fn every_fixture_is_what_its_description_says() {
    for plugin in registry().unwrap().fixtures() {
        let (name, fixture) = (plugin.name, built(plugin));
        assert_eq!(fixture.kind(), name);
        let described: Vec<&str> = plugin.surfaces.iter().map(|(surface, _)| *surface).collect();
        let surfaces: Vec<&str> = fixture.surfaces().iter().map(|surface| surface.name.as_str()).collect();
        // Unless the measurement states them.
        assert!(described.is_empty() || described == surfaces, "{name}: {described:?} {surfaces:?}");
        for (text, what) in
            [(plugin.touches, "touches"), (plugin.frame, "frame"), (plugin.reference, "reference")]
        {
            assert!(!text.trim().is_empty(), "{name}: nothing is said of its {what}");
        }
        for line in plugin.drawing.lines() {
            assert!(line.chars().count() <= COLUMNS, "{name}: the drawing is wider than {COLUMNS}: {line}");
        }
    }
}

#[test]
fn every_nominal_layout_lies_on_its_surfaces_and_is_enough() {
    for plugin in registry().unwrap().fixtures() {
        let (name, fixture) = (plugin.name, built(plugin));
        let layout = fixture.nominal_layout();
        let mut counts = vec![0; fixture.surfaces().len()];
        for (surface, point) in &layout {
            let surface_of_touch: &Surface = &fixture.surfaces()[*surface];
            let off = surface_of_touch.seen_from(point).distance.abs();
            assert!(
                off <= ROUNDING * (fixture.size() + point.coords.norm()),
                "{name}: {point} is off by {off:e}"
            );
            counts[*surface] += 1;
        }
        assert_eq!(fixture.requirement().missing(&counts, fixture.surfaces()), None, "{name}");
    }
}

/// One touch fewer than the nominal layout has on any surface is told where the nominal layout is the fewest.
#[test]
fn every_fixture_says_which_touches_are_missing() {
    for plugin in registry().unwrap().fixtures() {
        let fixture = built(plugin);
        let first = fixture.nominal_layout()[0];
        let touches = [Touch::new(first.0, first.1)];
        let problem = Problem::new(&*fixture, &touches, Probe::default()).unwrap();
        let missing = problem.require_enough().unwrap_err();
        assert_eq!(missing.code(), "too-few-touches", "{}", plugin.name);
        assert!(missing.to_string().contains('`'), "{}: {missing}", plugin.name);
    }
}

#[test]
fn every_solver_goes_by_the_name_of_its_plugin() {
    for plugin in registry().unwrap().solvers() {
        assert_eq!(plugin.build(&example(plugin.parameters)).unwrap().name(), plugin.name);
        assert!(!plugin.about.trim().is_empty(), "{}: nothing is said about it", plugin.name);
    }
}

/// A plugin of this name and origin that nobody builds.
const fn hand_made(name: &'static str, origin: &'static str) -> FixturePlugin {
    FixturePlugin {
        name,
        summary: "made by hand",
        origin,
        parameters: &[],
        surfaces: &[],
        touches: "none",
        frame: "nowhere",
        drawing: "",
        reference: "none",
        build: |_| unreachable!("only its name is asked for"),
    }
}

/// The same, of a solver.
const fn hand_made_solver(name: &'static str, origin: &'static str) -> SolverPlugin {
    SolverPlugin {
        name,
        summary: "made by hand",
        origin,
        parameters: &[],
        about: "nothing",
        reference: "none",
        build: |_| unreachable!("only its name is asked for"),
    }
}

static ONE: FixturePlugin = hand_made("twin", "crate_one::twin");
static OTHER: FixturePlugin = hand_made("twin", "crate_other::twin");
static USURPER: SolverPlugin = hand_made_solver("closed-form", "crate_other::closed_form");

#[test]
fn a_name_that_two_plugins_share_is_an_error_that_names_both() {
    for list in [[&ONE, &OTHER], [&OTHER, &ONE]] {
        let error = Registry::linked(&list, &[], &[]).unwrap_err();
        let expected = RegistryError::Duplicate {
            kind: "fixture",
            name: "twin",
            first: "crate_one::twin",
            second: "crate_other::twin",
        };
        assert_eq!(error, expected);
        let told = error.to_string();
        assert!(
            ["twin", "crate_one::twin", "crate_other::twin"].iter().all(|word| told.contains(word)),
            "{told}"
        );
    }
}

#[test]
fn plugins_are_sorted_whatever_the_order_they_come_in() {
    static FIRST: FixturePlugin = hand_made("aardvark", "crate_one::aardvark");
    static LAST: FixturePlugin = hand_made("zebra", "crate_one::zebra");
    for list in [[&FIRST, &LAST], [&LAST, &FIRST]] {
        let registry = Registry::linked(&list, &[], &[]).unwrap();
        let names: Vec<&str> = registry.fixtures().iter().map(|plugin| plugin.name).collect();
        assert!(
            names.is_sorted() && names.starts_with(&["aardvark"]) && names.ends_with(&["zebra"]),
            "{names:?}"
        );
    }
}

#[test]
fn a_built_in_name_cannot_be_taken() {
    let error = Registry::linked(fixtures::ALL, &[&USURPER], &[]).unwrap_err();
    let RegistryError::Duplicate { kind, name, first, second } = error else { panic!("{error}") };
    assert_eq!((kind, name), ("solver", "closed-form"));
    let mut origins = [first, second];
    origins.sort_unstable();
    assert_eq!(origins, ["crate_other::closed_form", solvers::closed_form::PLUGIN.origin]);
}

/// A fixture and a solver may share a name: each is asked for by its kind.
#[test]
fn kinds_have_names_of_their_own() {
    static SOLVER: SolverPlugin = hand_made_solver("twin", "crate_one::twin");
    let registry = Registry::linked(&[&ONE], &[&SOLVER], &[]).unwrap();
    assert_eq!(registry.fixture("twin").unwrap().origin, registry.solver("twin").unwrap().origin);
}

#[test]
fn an_unknown_name_gives_the_nearest() {
    let registry = registry().unwrap();
    let fixture = registry.fixture("cylinder-plan").unwrap_err();
    let solver = registry.solver("closedform").unwrap_err();
    for (error, wanted, asked) in
        [(fixture, "cylinder-plane", "cylinder-plan"), (solver, "closed-form", "closedform")]
    {
        let RegistryError::Unknown { name, known, nearest, .. } = &error else { panic!("{error}") };
        assert_eq!((name.as_str(), *nearest), (asked, Some(wanted)));
        assert!(known.contains(&wanted) && error.to_string().contains(asked), "{error}");
    }
    let RegistryError::Unknown { nearest, .. } = registry.fixture("qqq").unwrap_err() else { panic!() };
    assert_eq!(nearest, None);
}

/// The built-in plugins come through `inventory`, and a list that names them again changes nothing.
#[test]
fn a_plugin_that_comes_both_ways_counts_once() {
    let submitted = Registry::linked(&[], &[], &[]).unwrap();
    for plugin in fixtures::ALL {
        assert!(std::ptr::eq(submitted.fixture(plugin.name).unwrap(), *plugin));
    }
    for plugin in solvers::ALL {
        assert!(std::ptr::eq(submitted.solver(plugin.name).unwrap(), *plugin));
    }
    let twice = [fixtures::ALL, fixtures::ALL].concat();
    for plugin in io::dialect::ALL {
        assert!(std::ptr::eq(submitted.dialect(plugin.name).unwrap(), *plugin));
    }
    let listed = Registry::linked(&twice, solvers::ALL, io::dialect::ALL).unwrap();
    assert_eq!(listed.dialects().len(), submitted.dialects().len());
    assert_eq!(listed.fixtures().len(), submitted.fixtures().len());
    assert_eq!(listed.solvers().len(), submitted.solvers().len());
}
