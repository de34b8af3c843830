//! The Monte Carlo method: JCGM 101:2008, clause 7, and JCGM 102:2011, clause 7, for several outputs.

use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::{PropagationError, check_digits, check_probability, coverage::Interval, numerical_tolerance};
use crate::simulation::generator;

/// Trials that one thread works through before it takes the next; results do not depend on it, nor on the threads.
const CHUNK: usize = 64;
/// Trials of a block (JCGM 101:2008, 7.9.4 b) are at least so many.
const LEAST_BLOCK: u64 = 10_000;
/// A fixed number of trials is cut into so many blocks at least, to see how they scatter.
const LEAST_BLOCKS: u64 = 10;

/// One trial: draws the inputs from the generator and fills the row of outputs. Returns `false` where this draw has no
/// value.
pub type Draw<'a> = dyn Fn(&mut ChaCha8Rng, &mut [f64]) -> bool + Sync + 'a;

/// How many trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trials {
    /// So many.
    Fixed(u64),
    /// Until the results are stable (JCGM 101:2008, 7.9), or so many are made.
    Adaptive {
        /// Where it ends at the latest.
        most: u64,
    },
}

/// Draws from the distributions of the inputs, put through a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonteCarlo {
    /// Coverage probability of the intervals.
    pub probability: f64,
    /// Significant digits of the standard uncertainty that count: 1 or 2.
    pub digits: u32,
    /// The same seed gives the same results, whatever the number of threads.
    pub seed: u64,
    /// How many trials.
    pub trials: Trials,
    /// Which interval.
    pub interval: Interval,
}

/// What the Monte Carlo method tells of the outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Propagated {
    /// Of each output.
    pub outputs: Vec<Output>,
    /// Of the outputs.
    pub covariance: DMatrix<f64>,
    /// How many trials were made.
    pub trials: u64,
    /// How many of them had no value; the results are of the others.
    pub failed: u64,
    /// Into how many blocks they were cut, to see how results scatter.
    pub blocks: usize,
    /// Whether all results are known to their numerical tolerance. For a fixed number of trials, too, where it is no more
    /// than told.
    pub stable: bool,
    /// The values of each output, sorted.
    values: Vec<Vec<f64>>,
}

/// One output quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    /// Mean of the values.
    pub estimate: f64,
    /// Their standard deviation.
    pub u: f64,
    /// Low end of the coverage interval.
    pub low: f64,
    /// High end.
    pub high: f64,
    /// Half a unit of the last of the digits that count.
    pub tolerance: f64,
    /// How far the numbers above would scatter with other seeds.
    pub numerical: Numerical,
}

/// Standard deviations of the results of a Monte Carlo calculation, as far as its blocks tell them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numerical {
    /// Of the estimate.
    pub estimate: f64,
    /// Of the standard uncertainty.
    pub u: f64,
    /// Of the low end.
    pub low: f64,
    /// Of the high end.
    pub high: f64,
}

impl MonteCarlo {
    /// Makes the trials, on all threads: trial `k` draws from [`generator`]`(seed, k)`. Calls `progress` with how many
    /// more were made, from any thread.
    ///
    /// With [`Trials::Adaptive`] it goes on until every output is stable by the rule for
    /// one: JCGM 102:2011, 7.8, asks for the coverage factor and the correlations to be, too, which is left out here.
    ///
    /// Holds all values in memory: so many times the outputs.
    ///
    /// # Errors
    /// Those of [`PropagationError`] that concern numbers of outputs, trials and digits, probabilities, values that are not
    /// finite and too many trials without one.
    pub fn run(
        &self,
        outputs: usize,
        draw: &Draw<'_>,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Propagated, PropagationError> {
        check_probability(self.probability)?;
        check_digits(self.digits)?;
        if outputs == 0 {
            return Err(PropagationError::NoOutputs);
        }
        let block = self.block()?;
        let mut series = Series::new(*self, outputs);
        match self.trials {
            Trials::Fixed(all) => {
                while series.trials < all {
                    // What does not fill a block goes into the last one.
                    let left = all - series.trials;
                    series.add(if left < 2 * block { left } else { block }, draw, progress)?;
                }
            }
            Trials::Adaptive { most } => {
                while !series.stable()? && series.trials + block <= most {
                    series.add(block, draw, progress)?;
                }
            }
        }
        series.finish()
    }

    /// Trials of a block.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a positive number of trials"
    )]
    fn block(&self) -> Result<u64, PropagationError> {
        let beyond = 1.0 - self.probability;
        let whole = LEAST_BLOCK.max((100.0 / beyond).ceil() as u64);
        let (trials, block, least) = match self.trials {
            // Two values beyond the interval at least.
            Trials::Fixed(all) => {
                (all, whole.min(all / LEAST_BLOCKS), LEAST_BLOCKS * (2.0 / beyond).ceil() as u64)
            }
            Trials::Adaptive { most } => (most, whole, 2 * whole),
        };
        if trials < least {
            return Err(PropagationError::TooFewTrials { trials, least, probability: self.probability });
        }
        Ok(block)
    }
}

/// Blocks of trials as they come.
struct Series {
    settings: MonteCarlo,
    trials: u64,
    failed: u64,
    /// The values of each output, in the order of the trials.
    values: Vec<Vec<f64>>,
    /// Of each output.
    blocks: Vec<Blocks>,
}

/// What the blocks told of one output.
#[derive(Default)]
struct Blocks {
    /// Estimate, standard uncertainty, low and high end: one of each a block.
    results: [Vec<f64>; 4],
    /// Of all values: how many, their mean, and the sum of their squared distances from it.
    moments: Moments,
}

/// Count, mean, and sum of squared distances from the mean; sums of parts by Chan and others (1983).
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        Self { count, mean, squares: values.iter().map(|value| (value - mean).powi(2)).sum() }
    }

    fn add(&mut self, other: Self) {
        let (count, apart) = (self.count + other.count, other.mean - self.mean);
        self.squares += other.squares + apart * apart * self.count * other.count / count;
        self.mean += apart * other.count / count;
        self.count = count;
    }

    fn deviation(&self) -> f64 {
        (self.squares / (self.count - 1.0)).sqrt()
    }
}

impl Blocks {
    /// Standard deviations of the averages over the blocks (JCGM 101:2008, 7.9.4 f); infinite for fewer than two.
    fn deviations(&self) -> [f64; 4] {
        self.results.each_ref().map(|results| {
            let blocks = results.len() as f64;
            if blocks < 2.0 { f64::INFINITY } else { Moments::of(results).deviation() / blocks.sqrt() }
        })
    }
}

impl Series {
    fn new(settings: MonteCarlo, outputs: usize) -> Self {
        let blocks = (0..outputs).map(|_| Blocks::default()).collect();
        Self { settings, trials: 0, failed: 0, values: vec![Vec::new(); outputs], blocks }
    }

    /// So many more trials.
    fn add(
        &mut self,
        trials: u64,
        draw: &Draw<'_>,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<(), PropagationError> {
        let outputs = self.values.len();
        let count = usize::try_from(trials).unwrap_or(usize::MAX);
        let mut rows = vec![f64::NAN; count * outputs];
        let mut drawn = vec![false; count];
        let first = self.trials;
        rows.par_chunks_mut(CHUNK * outputs).zip(drawn.par_chunks_mut(CHUNK)).enumerate().for_each(
            |(chunk, (rows, drawn))| {
                for (k, (row, drawn)) in rows.chunks_mut(outputs).zip(drawn.iter_mut()).enumerate() {
                    let trial = first + (chunk * CHUNK + k) as u64;
                    *drawn = draw(&mut generator(self.settings.seed, trial), row);
                }
                progress(drawn.len() as u64);
            },
        );
        self.trials += trials;
        let before = self.values[0].len();
        for (trial, row) in
            (first..).zip(rows.chunks(outputs)).zip(&drawn).filter_map(|(row, drawn)| drawn.then_some(row))
        {
            if let Some(output) = row.iter().position(|value| !value.is_finite()) {
                return Err(PropagationError::NotFinite { trial, output });
            }
            for (values, value) in self.values.iter_mut().zip(row) {
                values.push(*value);
            }
        }
        self.failed += drawn.iter().filter(|drawn| !**drawn).count() as u64;
        for output in 0..outputs {
            let mut block = self.values[output][before..].to_vec();
            block.sort_unstable_by(f64::total_cmp);
            let interval = self.settings.interval.of(&block, self.settings.probability);
            let [low, high] = interval.ok_or_else(|| self.too_many_failed())?;
            let moments = Moments::of(&block);
            let blocks = &mut self.blocks[output];
            for (results, result) in
                blocks.results.iter_mut().zip([moments.mean, moments.deviation(), low, high])
            {
                results.push(result);
            }
            blocks.moments.add(moments);
        }
        Ok(())
    }

    /// Whether twice the standard deviation of every result is below the numerical tolerance (JCGM 101:2008, 7.9.4 i).
    fn stable(&self) -> Result<bool, PropagationError> {
        for blocks in &self.blocks {
            let tolerance = numerical_tolerance(blocks.moments.deviation(), self.settings.digits)?;
            // An output that is certain has a tolerance of 0, and no scatter.
            if !blocks.deviations().iter().all(|s| 2.0 * s < tolerance || *s == 0.0) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Results from all values (JCGM 101:2008, 7.9.4 j).
    fn finish(mut self) -> Result<Propagated, PropagationError> {
        let stable = self.stable()?;
        let outputs = self.values.len();
        let means: Vec<f64> = self.blocks.iter().map(|blocks| blocks.moments.mean).collect();
        let covariance = DMatrix::from_fn(outputs, outputs, |i, j| {
            let pairs = self.values[i].iter().zip(&self.values[j]);
            let sum: f64 = pairs.map(|(a, b)| (a - means[i]) * (b - means[j])).sum();
            sum / (self.values[i].len() as f64 - 1.0)
        });
        for values in &mut self.values {
            values.par_sort_unstable_by(f64::total_cmp);
        }
        let one = |output: usize| {
            let settings = &self.settings;
            let blocks = &self.blocks[output];
            let interval = settings.interval.of(&self.values[output], settings.probability);
            let [low, high] = interval.ok_or_else(|| self.too_many_failed())?;
            let u = covariance[(output, output)].sqrt();
            let [estimate_s, u_s, low_s, high_s] = blocks.deviations();
            // Ends of a shortest interval come nearer with the cube root of the number of values only (Kim and Pollard
            // 1990): those from all values scatter more than the averages over the blocks.
            let slower = match settings.interval {
                Interval::Symmetric => 1.0,
                Interval::Shortest => (blocks.results[0].len() as f64).powf(1.0 / 6.0),
            };
            Ok(Output {
                estimate: means[output],
                u,
                low,
                high,
                tolerance: numerical_tolerance(u, settings.digits)?,
                numerical: Numerical {
                    estimate: estimate_s,
                    u: u_s,
                    low: slower * low_s,
                    high: slower * high_s,
                },
            })
        };
        let results = (0..outputs).map(one).collect::<Result<_, PropagationError>>()?;
        let blocks = self.blocks[0].results[0].len();
        let Self { trials, failed, values, .. } = self;
        Ok(Propagated { outputs: results, covariance, trials, failed, blocks, stable, values })
    }

    fn too_many_failed(&self) -> PropagationError {
        PropagationError::TooManyFailed { failed: self.failed, trials: self.trials }
    }
}

impl Propagated {
    /// Another coverage interval of an output from the same trials; `None` where they are too few to tell it.
    ///
    /// # Errors
    /// [`PropagationError::Probability`].
    pub fn interval(
        &self,
        output: usize,
        probability: f64,
        interval: Interval,
    ) -> Result<Option<[f64; 2]>, PropagationError> {
        check_probability(probability)?;
        Ok(self.values.get(output).and_then(|values| interval.of(values, probability)))
    }
}
