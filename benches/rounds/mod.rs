//! Interleaved rounds: what several methods need for the same, beside each other in one run.

#![allow(dead_code)] // Each bench uses its own part.

use std::time::Instant;

/// Rounds timed: odd, so that the median is one of them.
const ROUNDS: usize = 101;

/// Nanoseconds per problem in each round, by method.
pub(crate) struct Rounds(Vec<Vec<f64>>);

impl Rounds {
    /// Times the methods in turn, round after round; each call works through so many `problems`.
    pub(crate) fn of<const N: usize>(problems: usize, methods: [&dyn Fn(); N]) -> Self {
        Self::measured(ROUNDS, N, |method| {
            let start = Instant::now();
            methods[method]();
            start.elapsed().as_secs_f64() * 1e9 / problems as f64
        })
    }

    /// So many rounds of what `nanoseconds` measures of each of so many methods in turn.
    pub(crate) fn measured(rounds: usize, methods: usize, mut nanoseconds: impl FnMut(usize) -> f64) -> Self {
        let mut times = vec![Vec::new(); methods];
        for _ in 0..rounds {
            for (method, times) in times.iter_mut().enumerate() {
                times.push(nanoseconds(method));
            }
        }
        Self(times)
    }

    /// The median time of a method, in nanoseconds per problem.
    pub(crate) fn time(&self, method: usize) -> f64 {
        median(self.0[method].clone())
    }

    /// How many times as long as `other` a method takes: the median of the rounds' own ratios, as a disturbance hits
    /// all methods of a round alike.
    pub(crate) fn ratio(&self, method: usize, other: usize) -> f64 {
        let both = self.0[method].iter().zip(&self.0[other]);
        median(both.map(|(method, other)| method / other).collect())
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
