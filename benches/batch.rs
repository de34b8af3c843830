//! Many placements: how many frames a second `touchref::batch` finds, from Parquet to Parquet, on one thread and on two, and
//! how much memory it takes for tables of different lengths; each placement alone, and plain ones many at once.
//!
//! ```text
//! cargo bench --features batch --bench batch -- [placements]
//! ```
//!
//! Each run is a process of its own, so that its peak memory is its own. Runs alternate, and of [`ROUNDS`] the fastest
//! counts: what disturbs a run makes it slower, never faster. Outputs that differ in a byte end the bench.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)] // A bench may panic, and prints its figures.

mod columns;

use std::{
    env,
    fs::{self, File},
    hint::black_box,
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

use columns::record_batch;
use rayon::ThreadPoolBuilder;
use touchref::{
    Fixture, Parameters, Probe, Problem, Touch, Units,
    analysis::simulation::{generator, random_frame, simulate},
    batch::{
        Counts, Locator,
        table::{self, Form},
    },
    io::{Input, InputError},
};

const SEED: u64 = 20_261_124;
const SIGMA: f64 = 0.01;
const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };
/// Placements that are simulated and written at once.
const TOGETHER: u64 = 10_000;
const ROUNDS: usize = 3;
/// The most placements that are held in memory at once.
const IN_MEMORY: u64 = 50_000;
/// What stands before the arguments of a process that locates.
const LOCATE: &str = "locate";

fn main() {
    // Cargo adds an argument of its own.
    let arguments: Vec<String> = env::args().skip(1).filter(|argument| argument != "--bench").collect();
    match &arguments[..] {
        [mode, touches, frames, threads, fast] if mode == LOCATE => {
            let (threads, fast) = (threads.parse().unwrap(), fast.parse().unwrap());
            locate(Path::new(touches), Path::new(frames), threads, fast);
        }
        [] => compare(1_000_000),
        [placements] => compare(placements.parse().unwrap()),
        _ => panic!("expected: [placements]"),
    }
}

/// A run: a table of so many placements, on so many threads.
struct Run {
    placements: u64,
    threads: usize,
    fast: bool,
    seconds: f64,
    megabytes: Option<f64>,
}

fn compare(placements: u64) {
    let folder = env::temp_dir().join(format!("touchref-bench-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let small = placements / 10;
    let tables = [small, placements].map(|count| {
        let path = folder.join(format!("{count}.parquet"));
        write(&path, count);
        (count, path)
    });
    let mut runs: Vec<Run> = Vec::new();
    for _ in 0..ROUNDS {
        for ((count, touches), fast) in tables.iter().flat_map(|table| [(table, false), (table, true)]) {
            let outputs = [1, 2].map(|threads| {
                let frames = touches.with_extension(format!("{threads}.parquet"));
                let (seconds, megabytes) = run(touches, &frames, threads, fast);
                let same =
                    |run: &&mut Run| (run.placements, run.threads, run.fast) == (*count, threads, fast);
                let known = runs.iter_mut().find(same);
                match known {
                    Some(known) => {
                        known.seconds = known.seconds.min(seconds);
                        known.megabytes = known.megabytes.zip(megabytes).map(|(a, b)| a.max(b));
                    }
                    None => runs.push(Run { placements: *count, threads, fast, seconds, megabytes }),
                }
                fs::read(frames).unwrap()
            });
            assert!(outputs[0] == outputs[1], "two threads write other bytes than one");
        }
    }
    fs::remove_dir_all(folder).unwrap();
    println!(
        "cylinder-plane, nominal 4 + 3 touches, sigma 10 um, Parquet to Parquet; outputs equal to the byte"
    );
    println!("  placements  threads        how    seconds  placements/s  peak MB");
    for run in &runs {
        let Run { placements, threads, fast, seconds, megabytes } = run;
        let how = if *fast { "at once" } else { "alone" };
        let memory = megabytes.map_or_else(|| "-".to_owned(), |megabytes| format!("{megabytes:.0}"));
        #[allow(clippy::cast_precision_loss)] // Far fewer than 2^53.
        let rate = *placements as f64 / seconds;
        println!("  {placements:>10} {threads:>8} {how:>10} {seconds:>10.2} {rate:>13.0} {memory:>8}");
    }
    let of = |threads, fast| {
        let same = |run: &&Run| (run.placements, run.threads, run.fast) == (placements, threads, fast);
        runs.iter().find(same).map_or(f64::NAN, |run| run.seconds)
    };
    for (fast, how) in [(false, "alone"), (true, "at once")] {
        println!("  {how}: two threads are {:.2} times as fast as one", of(1, fast) / of(2, fast));
    }
    println!("  one thread: at once is {:.2} times as fast as alone", of(1, false) / of(1, true));
    in_memory(placements.min(IN_MEMORY));
}

/// The same without tables: touches in memory, each alone by the solver and all together, nanoseconds a placement.
fn in_memory(placements: u64) {
    let registry = touchref::registry().unwrap();
    let solver = registry.solver("least-squares").unwrap().build(&Parameters::new()).unwrap();
    let fixture = fixture();
    let together = fixture.together(&PROBE, &solver.rule().unwrap()).unwrap();
    let measurements: Vec<Vec<Touch>> = (0..placements)
        .map(|placement| {
            let mut rng = generator(SEED, placement);
            let frame = random_frame(1000.0, &mut rng);
            simulate(&*fixture, &fixture.nominal_layout(), &frame, &PROBE, SIGMA, &mut rng)
        })
        .collect();
    let touches: Vec<_> = measurements.iter().flatten().map(|touch| touch.at).collect();
    let mut least = [f64::INFINITY; 2];
    let mut certain = 0;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        for touches in &measurements {
            let _ = black_box(solver.solve(&Problem::new(&*fixture, touches, PROBE).unwrap()));
        }
        let alone = start.elapsed();
        certain = 0;
        let start = Instant::now();
        together.locate(&touches, &mut |_, frame| {
            black_box(frame);
            certain += 1;
        });
        for (least, time) in least.iter_mut().zip([alone, start.elapsed()]) {
            *least = least.min(time.as_secs_f64() * 1e9);
        }
    }
    #[allow(clippy::cast_precision_loss)] // Far fewer than 2^53.
    let [alone, at_once] = least.map(|time| time / placements as f64);
    println!(
        "  in memory, one thread: alone {alone:.0} ns a placement, at once {at_once:.0} ns: {:.1} times as fast; {certain} of \
         {placements} were certain",
        alone / at_once
    );
}

fn fixture() -> Box<dyn Fixture> {
    let parameters = Parameters::new().with("radius", 20.0).with("angle_deg", 45.0);
    touchref::registry().unwrap().fixture("cylinder-plane").unwrap().build(&parameters).unwrap()
}

/// Writes a table of simulated touches.
fn write(path: &Path, placements: u64) {
    let fixture = fixture();
    let mut batches = (0..placements).step_by(usize::try_from(TOGETHER).unwrap()).map(|first| {
        let touches: Vec<(u64, Vec<Touch>)> = (first..placements.min(first + TOGETHER))
            .map(|placement| {
                let mut rng = generator(SEED, placement);
                let frame = random_frame(1000.0, &mut rng);
                (placement, simulate(&*fixture, &fixture.nominal_layout(), &frame, &PROBE, SIGMA, &mut rng))
            })
            .collect();
        record_batch(&*fixture, &touches)
    });
    let first = batches.next().expect("a table has placements");
    let mut sink = table::create(Form::Parquet, &first.schema(), File::create(path).unwrap()).unwrap();
    sink.write(&first).unwrap();
    batches.for_each(|batch| sink.write(&batch).unwrap());
    sink.finish().unwrap();
}

/// Seconds and peak megabytes of a process that locates.
fn run(touches: &Path, frames: &Path, threads: usize, fast: bool) -> (f64, Option<f64>) {
    let program: PathBuf = env::current_exe().unwrap();
    let how = [threads.to_string(), fast.to_string()];
    let output = Command::new(program).arg(LOCATE).args([touches, frames]).args(how).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let words = String::from_utf8(output.stdout).unwrap();
    let mut numbers = words.split_whitespace().map(|word| word.parse().unwrap());
    (numbers.next().unwrap(), numbers.next())
}

/// What the process of its own does: prints its seconds and, where the system tells it, its peak megabytes.
fn locate(touches: &Path, frames: &Path, threads: usize, fast: bool) {
    let registry = touchref::registry().unwrap();
    let solver = registry.solver("least-squares").unwrap().build(&Parameters::new()).unwrap();
    let fixture = fixture();
    let locator = Locator {
        fixture: &*fixture,
        solver: &*solver,
        probe: PROBE,
        units: Units::Millimetre,
        near: None,
        fast,
    };
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let start = Instant::now();
    let input = Input::from(touches.to_owned());
    let mut source = table::open(&input, Form::Parquet, &*fixture, Units::Millimetre).unwrap();
    let mut file = File::create(frames).unwrap();
    let mut sink = table::create(Form::Parquet, &locator.schema(source.names()), &mut file).unwrap();
    let counts: Result<Counts, InputError> = pool.install(|| {
        locator.run(&mut *source, &mut |located| {
            sink.write(&located.frames).unwrap();
            Ok(())
        })
    });
    let counts = counts.unwrap();
    sink.finish().unwrap();
    let seconds = start.elapsed().as_secs_f64();
    assert!(counts.located() * 100 > counts.placements() * 99, "{counts:?}");
    println!("{seconds} {}", peak_megabytes().map_or_else(String::new, |megabytes| megabytes.to_string()));
}

/// The most memory that the process has held, where the system tells it (Linux).
fn peak_megabytes() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024.0 / 1e6)
}
