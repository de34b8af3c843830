//! The promises of a fixture.

use nalgebra::{Point3, Vector3};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use rayon::prelude::*;
use touchref_core::{
    ClosedForm, Dimension, Extent, Fixture, Frame, MAX_DIMENSIONS, MAX_MEASURES, ParameterSpec, Parameters,
    Plugin, Probe, Problem, Quantity, Root, RootKind, Shape, Surface, Touch, Twist, Unknown, Value,
    parameters::parse,
};

use super::{
    Finding, Promise,
    case::{Case, Places, REGULAR, SOUND, UNIT},
    ensure, without_panic,
};
use crate::reference::{Magnitude, NullSpace, condition, condition_at, descend};

pub(super) use super::case::Subject;

/// What is said of a fixture holds to this, in parts of its size: a few sums and one square root.
const ROUNDING: f64 = 1e-12;

/// What is promised.
pub(super) fn checks<'a>() -> Vec<Promise<Subject<'a>>> {
    vec![
        ("description", description),
        ("parameters", parameters),
        ("requirement", requirement),
        ("surfaces", surfaces),
        ("nominal-layout", nominal_layout),
        ("dimensions", dimensions),
        ("unit", unit),
        ("roots", roots),
        ("invariance", invariance),
        ("candidates", candidates),
        ("objection", objection),
        ("wild-touches", wild_touches),
        ("null-space", null_space),
    ]
}

fn description(subject: &Subject<'_>) -> Finding {
    let (plugin, fixture) = (subject.plugin, &*subject.fixture);
    ensure!(fixture.kind() == plugin.name, "the fixture calls itself `{}`", fixture.kind());
    let told = [
        ("summary", plugin.summary),
        ("origin", plugin.origin),
        ("touches", plugin.touches),
        ("frame", plugin.frame),
        ("reference", plugin.reference),
    ];
    for (what, words) in told {
        ensure!(!words.trim().is_empty(), "nothing is said of its {what}");
    }
    ensure!(plugin.summary.lines().count() == 1, "the summary has more than one line");
    let described: Vec<&str> = plugin.surfaces.iter().map(|(name, _)| *name).collect();
    let built: Vec<&str> = fixture.surfaces().iter().map(|surface| surface.name.as_str()).collect();
    // A fixture whose surfaces its parameters state describes none.
    ensure!(
        described.is_empty() || described == built,
        "described are the surfaces {described:?}, built {built:?}"
    );
    for (index, (name, meaning)) in plugin.surfaces.iter().enumerate() {
        ensure!(!built[..index].contains(name), "two surfaces are named `{name}`");
        ensure!(!meaning.trim().is_empty(), "nothing is said of surface `{name}`");
    }
    let size = fixture.size();
    ensure!(size.is_finite() && size > 0.0, "its size is {size}");
    Ok(format!("{} surfaces, size {size}", built.len()))
}

/// What holds of the parameters of every plugin.
pub(super) fn documented<P: Plugin>(plugin: &P, complete: &Parameters) -> Result<(), String> {
    /// A name that no plugin has.
    const UNKNOWN: &str = "no such parameter";
    for (index, spec) in plugin.parameters().iter().enumerate() {
        let ParameterSpec { name, kind, default, meaning } = *spec;
        ensure!(!meaning.trim().is_empty(), "nothing is said of parameter `{name}`");
        let twice = plugin.parameters()[..index].iter().any(|other| other.name == name);
        ensure!(!twice, "two parameters are named `{name}`");
        if let Some(default) = default {
            // A parameter that takes the place of another names it instead.
            let replaces = plugin.parameters().iter().any(|other| spec.replaces() == Some(other.name));
            let is_value = replaces || spec.is_derived() || parse(kind, default).is_some();
            ensure!(is_value, "the default of `{name}`, {default:?}, is no {kind}");
        }
    }
    match plugin.build(&complete.clone().with(UNKNOWN, 1.0)) {
        Err(error) if error.name == UNKNOWN => Ok(()),
        Err(error) => Err(format!("an unknown parameter is refused with other words: {error}")),
        Ok(_) => Err("an unknown parameter is taken".to_owned()),
    }
}

fn parameters(subject: &Subject<'_>) -> Finding {
    documented(subject.plugin, &subject.parameters)?;
    let (fixture, own) = (&*subject.fixture, subject.fixture.parameters());
    for (name, value) in subject.parameters.iter() {
        let kept = own.get(name);
        ensure!(kept == Some(value), "built with `{name}` {value:?}, it says {kept:?}");
    }
    let again = subject.plugin.build(own).map_err(|error| format!("from its own parameters: {error}"))?;
    let same = again.surfaces() == fixture.surfaces()
        && again.requirement() == fixture.requirement()
        && again.dimensions() == fixture.dimensions()
        && again.nominal_layout() == fixture.nominal_layout()
        && again.size().total_cmp(&fixture.size()).is_eq();
    ensure!(same, "rebuilt from its own parameters it is another fixture");
    Ok(format!("{} parameters, rebuilt from them it is the same", own.iter().count()))
}

fn requirement(subject: &Subject<'_>) -> Finding {
    /// Unknowns of a frame.
    const UNKNOWNS: usize = 6;
    let fixture = &*subject.fixture;
    let (requirement, surfaces) = (fixture.requirement(), fixture.surfaces());
    ensure!(!requirement.alternatives.is_empty(), "it names no alternative");
    for counts in &requirement.alternatives {
        let (named, built) = (counts.len(), surfaces.len());
        ensure!(named == built, "{counts:?} counts {named} surfaces, the fixture has {built}");
        let touches = counts.iter().sum::<usize>();
        ensure!(touches >= UNKNOWNS, "{counts:?} are {touches} touches for {UNKNOWNS} unknowns");
        let missing = requirement.missing(counts, surfaces);
        ensure!(missing.is_none(), "{counts:?} is an alternative, and not enough: {missing:?}");
        let others = requirement.alternatives.iter().filter(|other| *other != counts);
        let larger = |other: &Vec<usize>| other.iter().zip(counts).all(|(other, own)| other <= own);
        let useless = others.into_iter().any(larger);
        ensure!(!useless, "{counts:?} asks for more than another alternative");
        for surface in (0..counts.len()).filter(|surface| counts[*surface] > 0) {
            let mut fewer = counts.clone();
            fewer[surface] -= 1;
            let missing = requirement.missing(&fewer, surfaces);
            ensure!(missing.is_some_and(|words| words.contains('`')), "{fewer:?} is not told as too few");
        }
    }
    Ok(format!("{} alternatives", requirement.alternatives.len()))
}

fn surfaces(subject: &Subject<'_>) -> Finding {
    /// Central differences of this step (parts of the size): truncation 1e-10 on a surface a tenth of the size,
    /// rounding 1e-9.
    const STEP: f64 = 1e-6;
    const GRADIENT: f64 = 1e-7;
    let mut rng = subject.generator(Places::Nominal, 0);
    let (size, tip) = (subject.size(), subject.tip_radius());
    for surface in subject.fixture.surfaces() {
        let name = &surface.name;
        well_formed(surface).map_err(|words| format!("surface `{name}`: {words}"))?;
        for _ in 0..subject.suite.trials {
            let contact = surface.point_at(rng.random(), rng.random());
            let off = surface.seen_from(&contact).distance.abs() / size;
            ensure!(off <= ROUNDING, "surface `{name}`: its point {contact} is off by {off:e} sizes");
            let at = surface.tip_center(&contact, tip);
            let here = surface.seen_from(&at);
            let off = (here.distance - tip).abs() / size;
            ensure!(off <= ROUNDING, "surface `{name}`: a tip that touches is off by {off:e} sizes");
            let slope = Vector3::from_fn(|axis, _| {
                let step = Vector3::ith(axis, STEP * size);
                let difference =
                    surface.seen_from(&(at + step)).distance - surface.seen_from(&(at - step)).distance;
                difference / (2.0 * STEP * size)
            });
            let off = (slope - here.normal).norm();
            ensure!(
                off <= GRADIENT,
                "surface `{name}`: normal and gradient of the distance differ by {off:e}"
            );
        }
    }
    Ok(format!("{} points on each of {} surfaces", subject.suite.trials, subject.fixture.surfaces().len()))
}

/// What makes the numbers of a surface a surface.
fn well_formed(surface: &Surface) -> Result<(), String> {
    /// Unit vectors made by normalisation.
    const UNIT_LENGTH: f64 = 1e-14;
    let unit = |what: &str, v: &Vector3<f64>| {
        let off = (v.norm() - 1.0).abs();
        ensure!(off <= UNIT_LENGTH, "its {what} has length {}", v.norm());
        Ok(())
    };
    let positive = |what: &str, length: f64| {
        ensure!(length.is_finite() && length > 0.0, "its {what} is {length}");
        Ok(())
    };
    match (&surface.shape, &surface.extent) {
        (Shape::Plane { normal, .. }, Extent::Disc { radius }) => {
            unit("normal", normal)?;
            positive("extent", *radius)
        }
        (Shape::Cylinder { axis, radius, .. }, Extent::Along { from, to }) => {
            unit("axis", axis)?;
            positive("radius", *radius)?;
            positive("length", to - from)
        }
        (Shape::Sphere { radius, .. }, Extent::Cap { axis, half_angle }) => {
            unit("middle of the cap", axis)?;
            positive("radius", *radius)?;
            positive("cap", *half_angle)
        }
        (Shape::Cone { axis, half_angle, .. }, Extent::Along { from, to }) => {
            unit("axis", axis)?;
            positive("half-angle", *half_angle)?;
            positive("distance of its reachable part from the apex", *from)?;
            positive("length", to - from)
        }
        (shape, extent) => Err(format!("an extent {extent:?} is none for {shape:?}")),
    }
}

fn nominal_layout(subject: &Subject<'_>) -> Finding {
    let fixture = &*subject.fixture;
    let layout = fixture.nominal_layout();
    let mut counts = vec![0; fixture.surfaces().len()];
    for (surface, point) in &layout {
        ensure!(*surface < counts.len(), "it touches surface number {surface} of {}", counts.len());
        let name = &fixture.surfaces()[*surface].name;
        let off = fixture.surfaces()[*surface].seen_from(point).distance.abs() / subject.size();
        ensure!(off <= ROUNDING, "its point {point} is {off:e} sizes off `{name}`");
        counts[*surface] += 1;
    }
    let missing = fixture.requirement().missing(&counts, fixture.surfaces());
    ensure!(missing.is_none(), "it is not enough: {}", missing.unwrap_or_default());
    let case = subject.case(Places::Nominal, 0, 0.0, None);
    let problem = Problem::new(fixture, &case.touches, case.probe).map_err(|error| error.to_string())?;
    let condition = condition(&problem, &subject.measured(), &case.truth);
    ensure!(condition <= SOUND, "its condition is {condition:.3e}, at most {SOUND} is sound");
    Ok(format!("{} touches, condition {condition:.1}", layout.len()))
}

/// Values of the dimensions, padded as solvers hand them over.
fn padded(values: &[f64]) -> [f64; MAX_DIMENSIONS] {
    std::array::from_fn(|index| values.get(index).copied().unwrap_or(0.0))
}

fn dimensions(subject: &Subject<'_>) -> Finding {
    /// Part by which dimensions are varied: far more than any that are uncertain, and less than makes a fixture
    /// impossible.
    const VARIED: f64 = 0.02;
    let fixture = &*subject.fixture;
    let all = fixture.dimensions();
    ensure!(all.len() <= MAX_DIMENSIONS, "{} dimensions are more than {MAX_DIMENSIONS}", all.len());
    for dimension in all {
        is_its_parameter(subject, dimension)?;
    }
    let nominal: Vec<f64> = all.iter().map(|dimension| dimension.value).collect();
    let mut rng = subject.generator(Places::Nominal, 0);
    let places = |rng: &mut dyn Rng| -> Vec<Point3<f64>> {
        let place = |surface: &Surface| {
            let contact = surface.point_at(rng.random(), rng.random());
            surface.tip_center(&contact, subject.tip_radius())
        };
        fixture.surfaces().iter().map(place).collect()
    };
    for trial in 0..subject.suite.trials {
        let at = places(&mut rng);
        let vary = |value: &f64| value * (1.0 + VARIED * rng.random_range(-1.0..=1.0));
        let values: Vec<f64> = if trial == 0 { nominal.clone() } else { nominal.iter().map(vary).collect() };
        let made = subject.plugin.build(&with_dimensions(subject, &values)).ok();
        let made = made.filter(|made| has_dimensions(&**made, &values));
        for (surface, at) in at.iter().enumerate() {
            let name = &fixture.surfaces()[surface].name;
            let shape = fixture.shape_with(surface, &padded(&values));
            ensure!(
                shape == fixture.shape_with(surface, &values),
                "`{name}` is another with values beyond the dimensions"
            );
            // Where parameters cannot make it, there is nothing to hold the shape against.
            if let Some(made) = &made {
                let expected = made.surfaces()[surface].seen_from(at).distance;
                let off = (shape.seen_from(at).distance - expected).abs() / subject.size();
                ensure!(
                    off <= ROUNDING,
                    "with dimensions {values:?} `{name}` is {off:e} sizes from where the fixture built so has it"
                );
            }
            gradients(subject, surface, at, &values)?;
        }
    }
    Ok(format!("{} dimensions, at {} sets of values", all.len(), subject.suite.trials))
}

/// A dimension has the name, the value and the uncertainty of its parameter.
fn is_its_parameter(subject: &Subject<'_>, dimension: &Dimension) -> Result<(), String> {
    /// An uncertainty that any dimension may have, in parts of its value.
    const UNCERTAIN: f64 = 1e-3;
    let Dimension { name, value, quantity, .. } = dimension;
    // One of several numbers is named with its index: `radii[0]`.
    let parameter = name.split('[').next();
    let known = subject.plugin.parameters.iter().any(|spec| {
        // One of a table is named after that: `bore.radius`.
        let of_table = subject.parameters.tables(spec.name).iter().any(|table| {
            name.split_once('.').is_some_and(|(of, key)| table.word("name") == of && table.get(key).is_some())
        });
        of_table || Some(spec.name) == parameter
    });
    ensure!(known, "dimension `{name}` is no parameter");
    let Some(Value::Number { value: of_parameter, .. }) = subject.parameters.get(name) else { return Ok(()) };
    let in_library = |number: f64| if *quantity == Quantity::Angle { number.to_radians() } else { number };
    let close = |a: f64, b: f64| (a - b).abs() <= ROUNDING * b.abs();
    let expected = in_library(*of_parameter);
    ensure!(close(*value, expected), "dimension `{name}` is {value}, its parameter {expected}");
    let uncertain = Value::Number { value: *of_parameter, u: UNCERTAIN * of_parameter };
    let built = subject.plugin.build(&subject.parameters.clone().with(name, uncertain));
    let built = built.map_err(|error| format!("with an uncertain `{name}`: {error}"))?;
    let u = built.dimensions().iter().find(|other| other.name == *name).map(|other| other.u);
    ensure!(
        u.is_some_and(|u| close(u, UNCERTAIN * expected)),
        "of an uncertainty {} of `{name}` its dimension says {u:?}",
        UNCERTAIN * expected
    );
    Ok(())
}

/// The parameters that give the dimensions these values, as far as they are single numbers.
fn with_dimensions(subject: &Subject<'_>, values: &[f64]) -> Parameters {
    let mut parameters = subject.parameters.clone();
    for (dimension, value) in subject.fixture.dimensions().iter().zip(values) {
        if let Some(Value::Number { u, .. }) = subject.parameters.get(&dimension.name) {
            let angle = dimension.quantity == Quantity::Angle;
            let value = if angle { value.to_degrees() } else { *value };
            parameters.set(&dimension.name, Value::Number { value, u: *u });
        }
    }
    parameters
}

fn has_dimensions(fixture: &dyn Fixture, values: &[f64]) -> bool {
    fixture
        .dimensions()
        .iter()
        .zip(values)
        .all(|(dimension, value)| (dimension.value - value).abs() <= ROUNDING * value.abs())
}

/// Stated gradients over the dimensions beside central differences of the shapes' distances.
fn gradients(subject: &Subject<'_>, surface: usize, at: &Point3<f64>, values: &[f64]) -> Result<(), String> {
    /// Of the difference, in parts of the dimension: truncation 1e-12, rounding 1e-10.
    const STEP: f64 = 1e-6;
    /// In parts of the size for the dimension's own value.
    const GRADIENT: f64 = 1e-7;
    let fixture = &*subject.fixture;
    for (index, dimension) in fixture.dimensions().iter().enumerate() {
        let step = STEP * values[index];
        let distance = |by: f64| {
            let mut values = padded(values);
            values[index] += by;
            fixture.shape_with(surface, &values).seen_from(at).distance
        };
        let slope = (distance(step) - distance(-step)) / (2.0 * step);
        let stated = fixture.dimension_gradient(index, surface, at, &padded(values));
        let off = (slope - stated).abs() * values[index] / subject.size();
        ensure!(
            off <= GRADIENT,
            "the distance from `{}` grows with `{}` by {slope}, stated is {stated}",
            fixture.surfaces()[surface].name,
            dimension.name
        );
    }
    Ok(())
}

fn unit(subject: &Subject<'_>) -> Finding {
    let (one, other) = (&*subject.fixture, &*subject.in_other_unit);
    let close = |got: f64, expected: f64| (got - expected).abs() <= ROUNDING * UNIT * subject.size();
    ensure!(close(other.size(), one.size() * UNIT), "the size is {}, not {UNIT} times", other.size());
    ensure!(one.requirement() == other.requirement(), "it needs other touches");
    let mut rng = subject.generator(Places::Nominal, 0);
    for (surface, seen) in one.surfaces().iter().zip(other.surfaces()) {
        for _ in 0..subject.suite.trials {
            let (u, v) = (rng.random(), rng.random());
            let at = surface.tip_center(&surface.point_at(u, v), subject.tip_radius());
            let expected = surface.seen_from(&at).distance * UNIT;
            let got = seen.seen_from(&(at * UNIT)).distance;
            ensure!(close(got, expected), "surface `{}` is not {UNIT} times as large", surface.name);
            let reach = (seen.point_at(u, v) - surface.point_at(u, v) * UNIT).norm();
            ensure!(
                close(reach, 0.0),
                "what can be reached of `{}` is not {UNIT} times as large",
                surface.name
            );
        }
    }
    let layouts = one.nominal_layout().into_iter().zip(other.nominal_layout());
    for ((surface, point), (seen_surface, seen)) in layouts {
        let same = surface == seen_surface && close((seen - point * UNIT).norm(), 0.0);
        ensure!(same, "the nominal layout is not {UNIT} times as large");
    }
    for (dimension, seen) in one.dimensions().iter().zip(other.dimensions()) {
        let factor = if dimension.quantity == Quantity::Length { UNIT } else { 1.0 };
        ensure!(close(seen.value, dimension.value * factor), "`{}` is {}", dimension.name, seen.value);
    }
    Ok(format!("all lengths times {UNIT}"))
}

/// The closed form's roots.
fn roots_of(closed_form: &dyn ClosedForm, problem: &Problem<'_>) -> Result<Vec<Root>, String> {
    let mut roots = Vec::new();
    closed_form.roots(problem, &mut |root| roots.push(root)).map_err(|refusal| refusal.to_string())?;
    Ok(roots)
}

/// How far a root is from a frame and from the values of its measured dimensions, in parts of the size and radians.
fn off_by(fixture: &dyn Fixture, root: &Root, frame: &Frame, measures: &[f64]) -> f64 {
    let dimensions = fixture.dimensions();
    let measured = fixture.closed_form().map_or(&[][..], |closed_form| closed_form.measured());
    let of_measures = measured.iter().zip(root.measures).zip(measures).map(|((m, got), expected)| {
        let length = dimensions[*m].quantity == Quantity::Length;
        (got - expected).abs() / if length { fixture.size() } else { 1.0 }
    });
    root.frame.twist_to(frame).extent(fixture.size()) + of_measures.sum::<f64>()
}

/// In parts of the size and radians, for a condition of one: coordinates ten sizes away round to 2e-15 of a size, which
/// the equations' own arithmetic should not make fifty times worse.
const ROOT: f64 = 1e-13;
/// The same with more touches than unknowns, where a root may be the minimum of a misfit: found to the square root of
/// rounding, 1.5e-8.
const ROOT_OF_MANY: f64 = 1e-7;

fn root_tolerance(fixture: &dyn Fixture, touches: usize, condition: f64) -> f64 {
    let measured = fixture.closed_form().map_or(0, |closed_form| closed_form.measured().len());
    condition * if touches <= 6 + measured { ROOT } else { ROOT_OF_MANY }
}

fn roots(subject: &Subject<'_>) -> Finding {
    let fixture = &*subject.fixture;
    let Some(closed_form) = fixture.closed_form() else { return Ok("no closed form".to_owned()) };
    let measured = closed_form.measured();
    ensure!(measured.len() <= MAX_MEASURES, "it measures more than {MAX_MEASURES} dimensions");
    for (index, dimension) in measured.iter().enumerate() {
        let exists = *dimension < fixture.dimensions().len() && !measured[..index].contains(dimension);
        ensure!(exists, "it measures {measured:?} of {} dimensions", fixture.dimensions().len());
    }
    let values: Vec<f64> = measured.iter().map(|m| fixture.dimensions()[*m].value).collect();
    let (mut count, mut worst) = (0, 0.0_f64);
    for places in Places::ALL {
        for case in subject.cases(places, 0.0, None, REGULAR)? {
            let problem = Problem::new(fixture, &case.touches, case.probe).map_err(|e| e.to_string())?;
            let found = roots_of(closed_form, &problem).map_err(|words| format!("{}: {words}", case.what))?;
            let nearest = found.iter().map(|root| off_by(fixture, root, &case.truth, &values));
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            let condition = condition(&problem, &subject.measured(), &case.truth);
            let bound = root_tolerance(fixture, case.touches.len(), condition);
            ensure!(
                nearest <= bound,
                "{}: of {} roots the nearest to the true frame is off by {nearest:.2e} (parts of the size, radians), \
                 at most {bound:.1e} at condition {condition:.1}",
                case.what,
                found.len()
            );
            worst = worst.max(nearest / bound);
            count += 1;
        }
    }
    Ok(format!("{count} sets of exact touches, at worst {worst:.1e} of the bound"))
}

fn invariance(subject: &Subject<'_>) -> Finding {
    let Some(closed_form) = subject.fixture.closed_form() else { return Ok("no closed form".to_owned()) };
    let mut compared = 0;
    for places in [Places::Nominal, Places::Fewest] {
        for (trial, case) in (0..).zip(subject.cases(places, subject.sigma(), None, REGULAR)?) {
            let problem =
                Problem::new(&*subject.fixture, &case.touches, case.probe).map_err(|e| e.to_string())?;
            let found = roots_of(closed_form, &problem).map_err(|words| format!("{}: {words}", case.what))?;
            for view in subject.views(&case, &mut subject.generator(places, trial)) {
                let told = format!("{}, {}", case.what, view.what);
                let other =
                    Problem::new(view.fixture, &view.touches, view.probe).map_err(|e| e.to_string())?;
                let other_form = view.fixture.closed_form().ok_or("in another unit it has no closed form")?;
                let seen = roots_of(other_form, &other).map_err(|words| format!("{told}: {words}"))?;
                for root in found.iter().filter(|root| root.kind == RootKind::Real) {
                    let condition = condition_of_root(subject, &problem, root);
                    if condition > REGULAR {
                        continue;
                    }
                    let measures = closed_form.measured().iter().zip(root.measures).map(|(m, value)| {
                        let length = subject.fixture.dimensions()[*m].quantity == Quantity::Length;
                        value * if length { view.unit } else { 1.0 }
                    });
                    let (frame, measures) = (view.of(&root.frame), measures.collect::<Vec<f64>>());
                    let nearest = seen.iter().map(|other| off_by(view.fixture, other, &frame, &measures));
                    let nearest = nearest.fold(f64::INFINITY, f64::min);
                    let bound = root_tolerance(&*subject.fixture, case.touches.len(), condition);
                    ensure!(
                        nearest <= bound,
                        "{told}: of {} roots the nearest to one of before is off by {nearest:.2e}, at most {bound:.1e}",
                        seen.len()
                    );
                    compared += 1;
                }
            }
        }
    }
    Ok(format!("{compared} roots compared"))
}

/// Condition at a root, its measured dimensions having the values that it implies.
fn condition_of_root(subject: &Subject<'_>, problem: &Problem<'_>, root: &Root) -> f64 {
    let fixture = &*subject.fixture;
    let measured = fixture.closed_form().map_or(&[][..], |closed_form| closed_form.measured());
    let deviations =
        measured.iter().zip(root.measures).map(|(m, value)| value - fixture.dimensions()[*m].value);
    condition_at(problem, &subject.measured(), &root.frame, deviations.collect())
}

fn candidates(subject: &Subject<'_>) -> Finding {
    /// Minima this near (parts of the size, radians) are one: descents end at rounding.
    const SAME: f64 = 1e-6;
    /// Part of sound layouts for which the search may be refused.
    const REFUSED: f64 = 0.1;
    let fixture = &*subject.fixture;
    let Some(closed_form) = fixture.closed_form() else { return Ok("no closed form".to_owned()) };
    let (mut count, mut refused, mut starts) = (0, 0, 0);
    let sigma = subject.sigma();
    for places in Places::ALL {
        for case in subject.cases(places, sigma, Some(sigma), SOUND)? {
            let problem = Problem::new(fixture, &case.touches, case.probe).map_err(|e| e.to_string())?;
            let Some(best) = descend(&problem, &[], &case.truth) else { continue };
            count += 1;
            let mut found = Vec::new();
            let complete = closed_form.candidates(&problem, 1.0, &mut |frame| found.push(frame));
            let Ok(complete_up_to) = complete else {
                refused += 1;
                continue;
            };
            ensure!(complete_up_to >= 0.0, "{}: complete up to {complete_up_to}", case.what);
            if complete_up_to < 1.0 {
                refused += 1;
                continue;
            }
            starts += found.len();
            let apart = |frame: &Frame| frame.twist_to(&best.frame).extent(subject.size());
            found.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
            let leads_there =
                |frame: &Frame| descend(&problem, &[], frame).is_some_and(|end| apart(&end.frame) <= SAME);
            ensure!(
                found.iter().any(leads_there),
                "{}: none of {} candidates leads to the minimum at the true frame; the nearest is off by {:.2e} \
                 (parts of the size, radians)",
                case.what,
                found.len(),
                found.first().map_or(f64::INFINITY, apart)
            );
        }
    }
    ensure!(
        f64::from(refused) <= REFUSED * f64::from(count),
        "of {count} sound layouts the search for candidates is refused for {refused}"
    );
    Ok(format!("{count} sets of noisy touches, {starts} candidates, {refused} refused"))
}

fn objection(subject: &Subject<'_>) -> Finding {
    let (sigma, mut count) = (subject.sigma(), 0);
    for places in Places::ALL {
        for noise in [0.0, sigma] {
            for case in subject.cases(places, noise, Some(sigma), SOUND)? {
                let problem =
                    Problem::new(&*subject.fixture, &case.touches, case.probe).map_err(|e| e.to_string())?;
                let said = subject.fixture.objection(&problem, &case.truth);
                ensure!(said.is_none(), "{}: {}", case.what, said.unwrap_or_default());
                count += 1;
            }
        }
    }
    Ok(format!("{count} sets of touches"))
}

fn wild_touches(subject: &Subject<'_>) -> Finding {
    /// Noise at which candidates are asked for, in the problem's sigmas.
    const NOISES: [f64; 3] = [0.0, 1.0, 1e6];
    // Where no sigma is stated, noise is a length.
    let lengths = [0.0, subject.sigma()];
    no_harm(subject, |problem| {
        let stated = problem.reference_sigma().is_some();
        asked(&*subject.fixture, problem, if stated { &NOISES } else { &lengths })
    })
}

/// Holds absurd touches, with a sigma and without, against a verdict on each set.
pub(super) fn no_harm(
    subject: &Subject<'_>,
    verdict: impl Fn(&Problem<'_>) -> Result<(), String> + Sync,
) -> Finding {
    let wild = subject.wild();
    let of = |what: &str, touches: &[Touch], probe: Probe| {
        let problem = Problem::new(&*subject.fixture, touches, probe).ok()?;
        let words = without_panic(|| verdict(&problem)).and_then(|verdict| verdict).err()?;
        Some(format!("{what}, sigma {:?}: {words}", probe.sigma))
    };
    let both = |(what, touches, probe): &(String, Vec<Touch>, Probe)| {
        [probe.sigma, None].map(|sigma| of(what, touches, Probe { sigma, ..*probe }))
    };
    let wrong: Vec<String> = wild.par_iter().flat_map_iter(both).flatten().collect();
    ensure!(wrong.is_empty(), "{} times; {}", wrong.len(), wrong.join("; "));
    Ok(format!("{} absurd sets of touches", wild.len()))
}

/// What a fixture hands out for these touches: frames, or refusals in words.
fn asked(fixture: &dyn Fixture, problem: &Problem<'_>, noises: &[f64]) -> Result<(), String> {
    let _ = fixture.objection(problem, &Frame::identity());
    let Some(closed_form) = fixture.closed_form() else { return Ok(()) };
    let mut wrong = None;
    let mut look = |frame: &Frame, measures: &[f64]| {
        if !frame.is_sound() {
            wrong = Some(format!("a frame that is none, at {}", frame.origin));
        } else if !measures.iter().all(|value| value.is_finite()) {
            wrong = Some(format!("a root that measures {measures:?}"));
        }
    };
    let measured = closed_form.measured().len();
    let mut refusals = Vec::new();
    let outcome = closed_form.roots(problem, &mut |root| look(&root.frame, &root.measures[..measured]));
    refusals.extend(outcome.err());
    for noise in noises {
        let outcome = closed_form.candidates(problem, *noise, &mut |frame| look(&frame, &[]));
        refusals.extend(outcome.err());
    }
    for refusal in refusals {
        let told = !refusal.to_string().is_empty() && !refusal.help().is_empty();
        ensure!(told, "refused as `{}` without words or help", refusal.code());
    }
    wrong.map_or(Ok(()), Err)
}

fn null_space(subject: &Subject<'_>) -> Finding {
    let fixture = &*subject.fixture;
    let (mut worst, mut count) = (0.0_f64, 0);
    for trial in 0..subject.suite.trials {
        let mut rng = subject.generator(Places::More, trial);
        let Some((case, reference)) = null_space_case(subject, &[], trial) else { continue };
        let problem = Problem::new(fixture, &reference.touches, case.probe).map_err(|e| e.to_string())?;
        let off = Vector3::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal)).normalize() * START;
        let off = Twist { translation: off * subject.size(), rotation: off };
        let Some(end) = descend(&problem, &[], &reference.frame.moved(&off)) else {
            return Err(format!("{}: no minimum is found from beside the design frame", case.what));
        };
        let (apart, bound) =
            (end.frame.twist_to(&reference.frame).extent(subject.size()), RECOVERED * reference.condition);
        ensure!(
            apart <= bound,
            "{}: the minimum is {apart:.2e} from the design frame (parts of the size, radians), at most {bound:.1e}",
            case.what
        );
        worst = worst.max(apart / bound);
        count += 1;
    }
    ensure!(
        count * 2 >= subject.suite.trials,
        "only {count} of {} layouts give reference data",
        subject.suite.trials
    );
    Ok(format!("{count} sets of reference data, at worst {worst:.1e} of the bound"))
}

/// How far beside the design frame a descent starts: parts of the size, radians.
const START: f64 = 1e-4;
/// Frames of reference data come back to this times their condition: parts of the size, radians. Coordinates ten sizes
/// away round to 2e-15 of a size.
pub(super) const RECOVERED: f64 = 1e-12;

/// Reference data on random places, residuals between a millionth and a twentieth of the size, and the measurement
/// whose layout and probe they have.
pub(super) fn null_space_case(
    subject: &Subject<'_>,
    unknowns: &[Unknown],
    trial: u64,
) -> Option<(Case, crate::reference::ReferenceMeasurement)> {
    /// Powers of ten of the largest residual, in parts of the size: a twentieth at most.
    const LEAST: f64 = -6.0;
    const MOST: f64 = -1.301;
    let case = subject.case(Places::More, trial, 0.0, None);
    let mut rng = subject.generator(Places::More, trial + (1 << 31));
    let largest = subject.size() * 10.0_f64.powf(rng.random_range(LEAST..MOST));
    let reference = NullSpace {
        fixture: &*subject.fixture,
        layout: &case.layout,
        sigmas: &[],
        probe: case.probe,
        frame: case.truth,
        unknowns,
        magnitude: Magnitude::Largest(largest),
    };
    let drawn = reference.draw(&mut rng)?;
    Some((case, drawn))
}
