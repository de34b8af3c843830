//! The honest locate: how long `least-squares` takes from touches to a frame or a refusal, the complete search for other
//! frames and the verdict included. Median and 90th percentile over measurements, one core.
//!
//! ```text
//! cargo bench --bench locate -- [measurements]
//! ```

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)] // A bench may panic, and prints its figures.

use std::{hint::black_box, time::Instant};

use touchref::{
    Fixture, Parameters, Probe, Problem,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
};

const SIGMA: f64 = 0.01;
/// Calls of which the fastest counts: what disturbs a call makes it slower, never faster.
const CALLS: usize = 5;

fn main() {
    // Cargo adds an argument of its own.
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let measurements: u64 = arguments.next().map_or(2000, |argument| argument.parse().unwrap());
    let fixtures: [(&str, Parameters, &[&[usize]]); 3] = [
        (
            "cylinder-plane",
            Parameters::new().with("radius", 20.0).with("angle_deg", 45.0),
            &[&[4, 3], &[5, 4], &[8, 6], &[30, 20]],
        ),
        (
            "three-sphere",
            Parameters::new().with("radius", 20.0).with("ab", 100.0).with("bc", 90.0).with("ca", 80.0),
            &[&[3, 3, 3], &[5, 5, 5]],
        ),
        ("cube", Parameters::new().with("edge", 40.0), &[&[3, 0, 2, 0, 1], &[3, 0, 3, 0, 3]]),
    ];
    let registry = touchref::registry().unwrap();
    println!(
        "{measurements} measurements each, sigma 10 um: microseconds of a locate{:>11}{:>12}",
        "median", "90 % below"
    );
    for (name, parameters, random) in fixtures {
        let fixture = registry.fixture(name).unwrap().build(&parameters).unwrap();
        let nominal = fixture.nominal_layout();
        print(&*fixture, &format!("{name}, nominal, {} touches", nominal.len()), measurements, None);
        for counts in random {
            let list: Vec<String> =
                counts.iter().filter(|count| **count > 0).map(ToString::to_string).collect();
            print(&*fixture, &format!("{name}, random {}", list.join(" + ")), measurements, Some(counts));
        }
    }
}

fn print(fixture: &dyn Fixture, what: &str, measurements: u64, counts: Option<&[usize]>) {
    let solver = touchref::registry().unwrap();
    let solver = solver.solver("least-squares").unwrap().build(&Parameters::new()).unwrap();
    let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) };
    let mut times: Vec<f64> = (0..measurements)
        .map(|trial| {
            let mut rng = generator(11, trial);
            let layout = counts
                .map_or_else(|| fixture.nominal_layout(), |counts| random_layout(fixture, counts, &mut rng));
            let frame = random_frame(1000.0, &mut rng);
            let touches = simulate(fixture, &layout, &frame, &probe, SIGMA, &mut rng);
            let problem = Problem::new(fixture, &touches, probe).unwrap();
            let call = |_| {
                let start = Instant::now();
                let _ = black_box(solver.solve(black_box(&problem)));
                start.elapsed().as_secs_f64() * 1e6
            };
            (0..CALLS).map(call).fold(f64::INFINITY, f64::min)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let (median, most) = (times[times.len() / 2], times[times.len() * 9 / 10]);
    println!("  {what:<54} {median:>10.1} {most:>11.1}");
}
