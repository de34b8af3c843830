//! Many placements at once: what the function from Arrow to Arrow promises.

#![allow(clippy::unwrap_used)] // A test may panic.

mod support;

use std::{collections::HashMap, sync::Arc};

use arrow_array::{
    Array, ArrayRef, DictionaryArray, Float32Array, Float64Array, Int32Array, Int64Array, LargeStringArray,
    RecordBatch, StringArray, cast::AsArray, types::Float64Type,
};
use arrow_schema::{DataType, Field, Schema};
use rand::RngExt;
use rayon::ThreadPoolBuilder;
use touchref::{
    Fixture, Probe, Problem, Solution, SolveError, Solver, Touch, Units,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
    batch::{Locator, UNITS_KEY},
};

const SEED: u64 = 70_311;
const PLACEMENTS: usize = 300;

/// Placements of which some are located, some ambiguous, some degenerate and some short of touches.
struct Table {
    fixture: Box<dyn Fixture>,
    solver: Box<dyn Solver>,
    probe: Probe,
    touches: Vec<Vec<Touch>>,
}

impl Table {
    fn new() -> Self {
        let fixture = support::cylinder_plane(20.0, 45.0);
        let probe = Probe { tip_radius: 1.5, sigma: Some(0.01), ..Probe::default() };
        let touches = (0..PLACEMENTS).map(|index| {
            let mut rng = generator(SEED, index as u64);
            let counts = if index % 3 == 0 { [6, 4] } else { [4, 3] };
            let layout = random_layout(&*fixture, &counts, &mut rng);
            let frame = random_frame(1000.0, &mut rng);
            let noise = rng.random_range(0.0..0.02);
            let mut touches = simulate(&*fixture, &layout, &frame, &probe, noise, &mut rng);
            match index % 20 {
                7 => touches.truncate(3),
                13 => touches[1] = touches[0],
                _ => {}
            }
            touches
        });
        let touches = touches.collect();
        Self { solver: support::solver("least-squares"), fixture, probe, touches }
    }

    fn locator(&self) -> Locator<'_> {
        Locator {
            fixture: &*self.fixture,
            solver: &*self.solver,
            probe: self.probe,
            units: Units::Millimetre,
            near: None,
            fast: false,
        }
    }

    /// Placements are called by number.
    fn batch(&self) -> RecordBatch {
        let rows = || (0_i64..).zip(&self.touches).flat_map(|(name, all)| all.iter().map(move |t| (name, t)));
        let surfaces = self.fixture.surfaces();
        let columns: [(&str, ArrayRef); 5] = [
            ("placement", Arc::new(Int64Array::from_iter_values(rows().map(|(name, _)| name)))),
            (
                "surface",
                Arc::new(StringArray::from_iter_values(rows().map(|(_, t)| &surfaces[t.surface].name))),
            ),
            ("x", Arc::new(Float64Array::from_iter_values(rows().map(|(_, t)| t.at.x)))),
            ("y", Arc::new(Float64Array::from_iter_values(rows().map(|(_, t)| t.at.y)))),
            ("z", Arc::new(Float64Array::from_iter_values(rows().map(|(_, t)| t.at.z)))),
        ];
        RecordBatch::try_from_iter(columns).unwrap()
    }

    fn alone(&self) -> Vec<Result<Solution, SolveError>> {
        let solve = |touches: &Vec<Touch>| {
            self.solver.solve(&Problem::new(&*self.fixture, touches, self.probe).unwrap())
        };
        self.touches.iter().map(solve).collect()
    }
}

fn with_column(batch: &RecordBatch, name: &str, column: ArrayRef) -> RecordBatch {
    let schema = batch.schema();
    let fields = schema.fields().iter().zip(batch.columns()).map(|(field, old)| {
        (field.name().clone(), if field.name() == name { Arc::clone(&column) } else { Arc::clone(old) })
    });
    let mut all: Vec<(String, ArrayRef)> = fields.collect();
    if !all.iter().any(|(known, _)| known == name) {
        all.push((name.to_owned(), column));
    }
    RecordBatch::try_from_iter(all).unwrap()
}

fn number(batch: &RecordBatch, column: &str, row: usize) -> Option<f64> {
    let column = batch.column_by_name(column).unwrap().as_primitive::<Float64Type>();
    column.is_valid(row).then(|| column.value(row))
}

fn text<'b>(batch: &'b RecordBatch, column: &str, row: usize) -> Option<&'b str> {
    let column = batch.column_by_name(column).unwrap().as_string::<i32>();
    column.is_valid(row).then(|| column.value(row))
}

#[test]
fn each_frame_is_bit_for_bit_that_of_the_placement_alone() {
    let table = Table::new();
    let frames = table.locator().locate(&table.batch()).unwrap();
    assert_eq!(frames.num_rows(), PLACEMENTS);
    let mut statuses: HashMap<&str, usize> = HashMap::new();
    for (row, alone) in table.alone().iter().enumerate() {
        let status = text(&frames, "status", row).unwrap();
        *statuses.entry(status).or_default() += 1;
        match alone {
            Ok(solution) => {
                assert_eq!(status, "ok", "placement {row}");
                let frame = &solution.frame;
                let quaternion = frame.quaternion_xyzw();
                let pose = [frame.origin.x, frame.origin.y, frame.origin.z].into_iter().chain(quaternion);
                for (column, value) in ["x", "y", "z", "qx", "qy", "qz", "qw"].into_iter().zip(pose) {
                    assert_eq!(number(&frames, column, row), Some(value), "placement {row}, {column}");
                }
                let covariance = solution.covariance.as_ref().unwrap().matrix;
                assert_eq!(number(&frames, "cov_y_rz", row), Some(covariance[(1, 5)]));
                assert_eq!(number(&frames, "cov_rz_rz", row), Some(covariance[(5, 5)]));
                assert_eq!(number(&frames, "chi_square", row), solution.chi_square);
                assert_eq!(number(&frames, "p_value", row), solution.p_value);
                assert_eq!(number(&frames, "condition", row), Some(solution.observability.condition));
                assert_eq!(text(&frames, "message", row), None);
            }
            Err(error) => {
                assert_eq!(status, error.code(), "placement {row}");
                assert_eq!(text(&frames, "message", row), Some(error.to_string().as_str()));
                for column in ["x", "qw", "chi_square", "p_value", "condition", "cov_x_x", "cov_rz_rz"] {
                    assert_eq!(number(&frames, column, row), None, "placement {row}, {column}");
                }
            }
        }
    }
    assert!(
        statuses["ok"] > PLACEMENTS / 2 && statuses["too-few-touches"] == PLACEMENTS / 20,
        "{statuses:?}"
    );
    assert!(statuses.len() >= 3, "{statuses:?}");
}

#[test]
fn threads_and_the_size_of_batches_change_no_bit() {
    let table = Table::new();
    let (touches, locator) = (table.batch(), table.locator());
    let whole = locator.locate(&touches).unwrap();
    for threads in 1..=3 {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| locator.locate(&touches)).unwrap(), whole, "{threads} threads");
    }
    for size in [1, 5, 64, 100_000] {
        let mut stream = locator.stream(&touches.schema()).unwrap();
        let mut rows = 0;
        let mut compare = |frames: &RecordBatch| {
            assert_eq!(*frames, whole.slice(rows, frames.num_rows()), "batches of {size}");
            rows += frames.num_rows();
        };
        for start in (0..touches.num_rows()).step_by(size) {
            let part = touches.slice(start, size.min(touches.num_rows() - start));
            compare(&stream.add(&part).unwrap());
        }
        compare(&stream.finish().unwrap());
        assert_eq!(rows, PLACEMENTS);
    }
}

#[test]
fn columns_may_come_in_other_types_and_in_any_order() {
    let table = Table::new();
    let (touches, locator) = (table.batch(), table.locator());
    let whole = locator.locate(&touches).unwrap();
    let names: Vec<String> = touches
        .column(0)
        .as_primitive::<arrow_array::types::Int64Type>()
        .values()
        .iter()
        .map(ToString::to_string)
        .collect();
    let surfaces: Vec<&str> = touches.column(1).as_string::<i32>().iter().flatten().collect();

    let encoded: DictionaryArray<arrow_array::types::Int8Type> = surfaces.iter().copied().collect();
    let of = with_column(&touches, "surface", Arc::new(encoded));
    assert_eq!(locator.locate(&of).unwrap(), whole, "dictionary");
    let of = with_column(&touches, "surface", Arc::new(LargeStringArray::from(surfaces)));
    assert_eq!(locator.locate(&of).unwrap(), whole, "large text");
    let reversed: Vec<(String, ArrayRef)> = (0..touches.num_columns())
        .rev()
        .map(|index| (touches.schema().field(index).name().clone(), Arc::clone(touches.column(index))))
        .collect();
    assert_eq!(locator.locate(&RecordBatch::try_from_iter(reversed).unwrap()).unwrap(), whole, "reversed");

    let by_text =
        locator.locate(&with_column(&touches, "placement", Arc::new(StringArray::from(names)))).unwrap();
    assert_eq!(by_text.column_by_name("placement").unwrap().as_string::<i32>().value(17), "17");
    assert_eq!(by_text.columns()[1..], whole.columns()[1..]);

    // Every touch states the sigma that the probe states otherwise.
    let sigma = Arc::new(Float64Array::from(vec![0.01; touches.num_rows()]));
    let stated = locator.locate(&with_column(&touches, "sigma", sigma)).unwrap();
    assert_eq!(stated.column_by_name("x"), whole.column_by_name("x"));
    let coarse = touches.column(2).as_primitive::<Float64Type>();
    #[allow(clippy::cast_possible_truncation)] // That is what is tried.
    let coarse: Float32Array = coarse.iter().map(|x| x.map(|x| x as f32)).collect();
    assert_eq!(locator.locate(&with_column(&touches, "x", Arc::new(coarse))).unwrap().num_rows(), PLACEMENTS);
}

/// Fast, every placement has the status that it has alone, and numbers that differ by less than is promised; on any number
/// of threads the same.
#[test]
fn fast_frames_are_those_of_the_solver() {
    /// Of the frame's length in parts of its standard deviation, and of what is told of it in parts.
    const SAME: f64 = 1e-6;
    let table = Table::new();
    let touches = table.batch();
    let whole = table.locator().locate(&touches).unwrap();
    let fast = Locator { fast: true, ..table.locator() };
    let threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fast.locate(&touches).unwrap())
    };
    let frames = threads(1);
    assert_eq!(frames, threads(3));
    assert_ne!(frames, whole, "none was located fast");
    for name in ["placement", "status", "degrees_of_freedom", "warnings", "message"] {
        assert_eq!(frames.column_by_name(name), whole.column_by_name(name), "{name}");
    }
    for (sd, names) in [("cov_x_x", ["x"]), ("cov_y_y", ["y"]), ("cov_z_z", ["z"])] {
        for placement in 0..PLACEMENTS {
            let Some(variance) = number(&whole, sd, placement) else { continue };
            let of = |frames| number(frames, names[0], placement).unwrap();
            assert!((of(&whole) - of(&frames)).abs() < SAME * variance.sqrt(), "{names:?} of {placement}");
        }
    }
    for name in ["chi_square", "p_value", "condition", "cov_x_x", "cov_ry_ry", "qx", "qw"] {
        for placement in 0..PLACEMENTS {
            let (a, b) = (number(&whole, name, placement), number(&frames, name, placement));
            let same = a == b || a.zip(b).is_some_and(|(a, b)| (a - b).abs() < SAME * a.abs().max(1e-3));
            assert!(same, "{name} of {placement}: {a:?} {b:?}");
        }
    }
    // Where a frame is expected, the solver decides.
    let near = whole.column_by_name("x").map(|_| touchref::Frame::parallel_at(nalgebra::Point3::origin()));
    let (near, fast) = (Locator { near, ..table.locator() }, Locator { near, ..fast });
    assert_eq!(near.locate(&touches).unwrap(), fast.locate(&touches).unwrap());
}

/// What is wrong with a touch concerns its placement, and no other.
#[test]
fn a_wrong_touch_refuses_its_placement_only() {
    let table = Table::new();
    let (touches, locator) = (table.batch(), table.locator());
    let whole = locator.locate(&touches).unwrap();
    let row = 30;
    let placement =
        usize::try_from(touches.column(0).as_primitive::<arrow_array::types::Int64Type>().value(row))
            .unwrap();
    let at = |value: Option<f64>| -> ArrayRef {
        let x = touches.column(2).as_primitive::<Float64Type>();
        Arc::new(
            x.iter().enumerate().map(|(i, x)| if i == row { value } else { x }).collect::<Float64Array>(),
        )
    };
    let surface = |name: Option<&str>| -> ArrayRef {
        let all = touches.column(1).as_string::<i32>();
        Arc::new(
            all.iter().enumerate().map(|(i, s)| if i == row { name } else { s }).collect::<StringArray>(),
        )
    };
    let alone = |value: f64| -> ArrayRef {
        Arc::new((0..touches.num_rows()).map(|i| (i == row).then_some(value)).collect::<Float64Array>())
    };
    let unit = || -> ArrayRef {
        Arc::new(
            (0..touches.num_rows())
                .map(|i| Some(if i == row { "in" } else { "mm" }))
                .collect::<StringArray>(),
        )
    };
    let cases: [(&str, ArrayRef, &str, &str); 8] = [
        ("x", at(Some(f64::NAN)), "invalid-input", "row 30, column `x` is NaN; expected a finite number"),
        (
            "x",
            at(Some(f64::INFINITY)),
            "invalid-input",
            "row 30, column `x` is inf; expected a finite number",
        ),
        ("x", at(None), "invalid-input", "row 30, column `x` is empty; expected a finite number"),
        ("surface", surface(Some("plan")), "unknown-surface", "row 30: the fixture has no surface `plan`"),
        ("surface", surface(None), "unknown-surface", "row 30: the fixture has no surface ``"),
        ("sigma", alone(-1.0), "invalid-input", "row 30, column `sigma` is -1; expected a length > 0"),
        ("sigma", alone(f64::NAN), "invalid-input", "row 30, column `sigma` is NaN; expected a length > 0"),
        ("units", unit(), "invalid-input", "row 30, column `units` is `in`; expected `mm`"),
    ];
    for (column, values, code, message) in cases {
        let frames = locator.locate(&with_column(&touches, column, values)).unwrap();
        assert_eq!(text(&frames, "status", placement), Some(code), "{message}");
        assert!(text(&frames, "message", placement).unwrap().starts_with(message), "{frames:?}");
        assert_eq!(number(&frames, "x", placement), None);
        assert_eq!(frames.slice(0, placement), whole.slice(0, placement));
        let after = placement + 1;
        assert_eq!(frames.slice(after, PLACEMENTS - after), whole.slice(after, PLACEMENTS - after));
    }
}

#[test]
fn a_wrong_table_is_told_by_its_column() {
    let table = Table::new();
    let (touches, locator) = (table.batch(), table.locator());
    let schema = touches.schema();
    let renamed = |from: &str, to: &str| {
        let fields = schema.fields().iter().map(|field| {
            let name = if field.name() == from { to } else { field.name() };
            Field::new(name, field.data_type().clone(), true)
        });
        let schema = Arc::new(Schema::new(fields.collect::<Vec<_>>()));
        RecordBatch::try_new(schema, touches.columns().to_vec()).unwrap()
    };
    let in_units = |units: &str, field: bool| {
        let metadata = HashMap::from([(UNITS_KEY.to_owned(), units.to_owned())]);
        let schema = if field {
            let z = schema.field(4).clone().with_metadata(metadata);
            let kept = schema.fields()[..4].iter().map(|field| (**field).clone());
            Schema::new(kept.chain([z]).collect::<Vec<_>>())
        } else {
            (*schema).clone().with_metadata(metadata)
        };
        RecordBatch::try_new(Arc::new(schema), touches.columns().to_vec()).unwrap()
    };
    let count = touches.num_rows();
    let rows = i64::try_from(count).unwrap();
    let words: ArrayRef = Arc::new(StringArray::from(vec!["1.0"; count]));
    let unnamed: ArrayRef = Arc::new((0..rows).map(|row| (row > 9).then_some(row)).collect::<Int64Array>());
    let again: ArrayRef =
        Arc::new(Int32Array::from_iter_values((0..count).map(|row| i32::from(row % 20 < 10))));
    let sixes: ArrayRef = Arc::new(Float64Array::from(vec![6.0; count]));
    let cases = [
        (renamed("x", "x_mm"), "missing-column", "x", "column `x` is missing"),
        (renamed("placement", "placment"), "missing-column", "placement", "column `placement` is missing"),
        (
            with_column(&touches, "Sigma", Arc::clone(&sixes)),
            "unknown-column",
            "Sigma",
            "column `Sigma` is not known",
        ),
        (with_column(&touches, "i", sixes), "missing-column", "j", "column `j` is missing"),
        (
            with_column(&touches, "y", words),
            "invalid-input",
            "y",
            "column `y` is Utf8; expected a floating-point number",
        ),
        (in_units("in", true), "invalid-input", "z", "column `z` is in `in`, but the measurement in `mm`"),
        (in_units("m", false), "invalid-input", "x", "column `x` is in `m`, but the measurement in `mm`"),
        (
            with_column(&touches, "placement", unnamed),
            "invalid-input",
            "placement",
            "row 0: the touch belongs to no",
        ),
        (
            with_column(&touches, "placement", again),
            "invalid-input",
            "placement",
            "row 20: placement `1` comes again",
        ),
    ];
    for (batch, code, key, message) in cases {
        let error = locator.locate(&batch).unwrap_err();
        assert_eq!((error.code(), error.key()), (code, Some(key)), "{error}");
        assert!(error.to_string().starts_with(message), "{error}");
    }
    assert_eq!(locator.locate(&in_units("mm", false)).unwrap().num_rows(), PLACEMENTS);
    assert_eq!(locator.locate(&touches.slice(0, 0)).unwrap().num_rows(), 0);
    assert_eq!(locator.schema(touchref::batch::NameType::Text).field(0).data_type(), &DataType::Utf8);
}
