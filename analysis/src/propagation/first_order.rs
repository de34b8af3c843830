//! The law of propagation of uncertainty: GUM clause 5 and annex G, and JCGM 102:2011, clause 6, for several outputs.
//!
//! Derivatives are central differences, carried from steps of one standard uncertainty to the limit of step zero (Ridders
//! 1982): exact but for rounding on smooth models, nine digits or more.

use nalgebra::{DMatrix, DVector};

use super::{PropagationError, check_probability, coverage::coverage_factor, distribution::square_root};

/// Steps tried, each half of the one before.
const STEPS: usize = 16;
/// The first step is one standard uncertainty, but no smaller part of the estimate than this: rounding of the moved
/// input itself would show.
const LEAST_PART: f64 = 1e-5;

/// What is known of an input quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Input {
    /// Best estimate.
    pub estimate: f64,
    /// Standard uncertainty.
    pub u: f64,
    /// Of the standard uncertainty; infinite where that is exact.
    pub degrees_of_freedom: f64,
}

impl Input {
    /// With a standard uncertainty that is exact.
    #[must_use]
    pub fn new(estimate: f64, u: f64) -> Self {
        Self { estimate, u, degrees_of_freedom: f64::INFINITY }
    }

    /// The same with a standard uncertainty of so many degrees of freedom.
    #[must_use]
    pub fn with_degrees_of_freedom(self, degrees_of_freedom: f64) -> Self {
        Self { degrees_of_freedom, ..self }
    }

    /// The first step along it.
    fn step(&self) -> f64 {
        self.u.max(LEAST_PART * self.estimate.abs())
    }

    /// Standard uncertainty in these steps.
    fn u_in_steps(&self) -> f64 {
        self.u / self.step()
    }
}

/// A model and what is known of its inputs.
pub struct FirstOrder<'a> {
    inputs: &'a [Input],
    outputs: usize,
    correlation: Option<&'a DMatrix<f64>>,
    model: &'a dyn Fn(&[f64], &mut [f64]),
}

impl<'a> FirstOrder<'a> {
    /// A model that turns values of the inputs, in their order, into so many outputs; the inputs are independent.
    ///
    /// # Errors
    /// [`PropagationError::NoOutputs`]; [`PropagationError::Input`].
    pub fn new(
        inputs: &'a [Input],
        outputs: usize,
        model: &'a dyn Fn(&[f64], &mut [f64]),
    ) -> Result<Self, PropagationError> {
        if outputs == 0 {
            return Err(PropagationError::NoOutputs);
        }
        let valid = |input: &Input| {
            input.estimate.is_finite()
                && input.u.is_finite()
                && input.u >= 0.0
                && input.degrees_of_freedom > 0.0
        };
        if let Some(index) = inputs.iter().position(|input| !valid(input)) {
            return Err(PropagationError::Input { index });
        }
        Ok(Self { inputs, outputs, correlation: None, model })
    }

    /// The same with inputs that are correlated.
    ///
    /// # Errors
    /// [`PropagationError::Matrix`], for a matrix that cannot be that of their correlation coefficients.
    pub fn with_correlation(self, correlation: &'a DMatrix<f64>) -> Result<Self, PropagationError> {
        let (name, size) = ("correlation", self.inputs.len());
        square_root(correlation, size, name)?;
        if correlation.diagonal().iter().any(|one| (one - 1.0).abs() > f64::EPSILON) {
            return Err(PropagationError::Matrix { name, size, more: ", with ones on its diagonal" });
        }
        Ok(Self { correlation: Some(correlation), ..self })
    }

    /// Estimates, sensitivities and the covariance of the outputs.
    ///
    /// # Errors
    /// [`PropagationError::NotDifferentiable`].
    pub fn propagate(&self) -> Result<Propagation, PropagationError> {
        let estimates = self.at(&[]);
        if let Some(output) = estimates.iter().position(|value| !value.is_finite()) {
            return Err(PropagationError::NotDifferentiable { output });
        }
        let mut contributions = DMatrix::zeros(self.outputs, self.inputs.len());
        for (input, known) in self.inputs.iter().enumerate() {
            if known.u > 0.0 {
                let slopes =
                    self.limit(1, |h| (self.at(&[(input, h)]) - self.at(&[(input, -h)])) / (2.0 * h))?;
                contributions.set_column(input, &(slopes * known.u_in_steps()));
            }
        }
        let covariance = match self.correlation {
            None => &contributions * contributions.transpose(),
            Some(correlation) => &contributions * correlation * contributions.transpose(),
        };
        Ok(Propagation {
            estimates: estimates.as_slice().to_vec(),
            contributions,
            covariance,
            inputs: self.inputs.to_vec(),
            correlated: self.correlation.is_some_and(|matrix| !matrix.is_identity(0.0)),
        })
    }

    /// What the terms of the next higher order add to the variance of each output, for independent inputs that are normal
    /// or nearly (GUM 5.1.2, note): `sum of (f_ij^2 / 2 + f_i f_ijj) u_i^2 u_j^2`. It may be negative.
    ///
    /// # Errors
    /// [`PropagationError::Correlated`]; [`PropagationError::NotDifferentiable`].
    pub fn higher_order_variance(&self) -> Result<Vec<f64>, PropagationError> {
        let Propagation { contributions: slopes, correlated: false, .. } = self.propagate()? else {
            return Err(PropagationError::Correlated);
        };
        let uncertain: Vec<usize> = (0..self.inputs.len()).filter(|&i| self.inputs[i].u > 0.0).collect();
        let mut variance = DVector::zeros(self.outputs);
        for &i in &uncertain {
            for &j in &uncertain {
                let slope =
                    |x: f64, h: f64| (self.at(&[(i, x), (j, h)]) - self.at(&[(i, x), (j, -h)])) / (2.0 * h);
                let second = self.limit(2, |h| (slope(h, h) - slope(-h, h)) / (2.0 * h))?;
                let bend = |x: f64, h: f64| {
                    let ends = self.at(&[(i, x), (j, h)]) + self.at(&[(i, x), (j, -h)]);
                    (ends - self.at(&[(i, x)]) * 2.0) / (h * h)
                };
                let third = self.limit(3, |h| (bend(h, h) - bend(-h, h)) / (2.0 * h))?;
                let (u, v) = (self.inputs[i].u_in_steps(), self.inputs[j].u_in_steps());
                variance += second.component_mul(&second) * (0.5 * (u * v).powi(2));
                variance += slopes.column(i).component_mul(&third) * (u * v * v);
            }
        }
        Ok(variance.as_slice().to_vec())
    }

    /// The model with inputs moved by so many of their first steps; moves of one input add up.
    fn at(&self, moves: &[(usize, f64)]) -> DVector<f64> {
        let mut values: Vec<f64> = self.inputs.iter().map(|input| input.estimate).collect();
        for (input, by) in moves {
            values[*input] += by * self.inputs[*input].step();
        }
        let mut outputs = DVector::from_element(self.outputs, f64::NAN);
        (self.model)(&values, outputs.as_mut_slice());
        outputs
    }

    /// The limit of a difference quotient, even in its step, as the step goes to zero; `order` is the power of the step
    /// that it divides by.
    ///
    /// # Errors
    /// [`PropagationError::NotDifferentiable`], where no step gives a finite one.
    fn limit(
        &self,
        order: i32,
        quotient: impl Fn(f64) -> DVector<f64>,
    ) -> Result<DVector<f64>, PropagationError> {
        let size = self.at(&[]).abs();
        let mut best = DVector::from_element(self.outputs, f64::NAN);
        let mut error = DVector::from_element(self.outputs, f64::INFINITY);
        let mut before: Vec<DVector<f64>> = Vec::new();
        for step in (0..STEPS).map(|halvings| 0.5_f64.powi(i32::try_from(halvings).unwrap_or(i32::MAX))) {
            let mut row = vec![quotient(step)];
            let mut power = 1.0;
            for (column, coarser) in before.iter().enumerate() {
                power *= 4.0;
                let finer = (&row[column] * power - coarser) / (power - 1.0);
                for output in 0..self.outputs {
                    let moved = finer[output].abs() / (LEAST_PART * step);
                    let rounding = f64::EPSILON * (size[output] / step.powi(order) + moved);
                    let apart = f64::max(
                        (finer[output] - row[column][output]).abs(),
                        (finer[output] - coarser[output]).abs(),
                    );
                    if apart + rounding < error[output] {
                        error[output] = apart + rounding;
                        best[output] = finer[output];
                    }
                }
                row.push(finer);
            }
            before = row;
        }
        match best.iter().position(|value| !value.is_finite()) {
            None => Ok(best),
            Some(output) => Err(PropagationError::NotDifferentiable { output }),
        }
    }
}

/// What the law of propagation tells of the outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Propagation {
    /// Of each output.
    pub estimates: Vec<f64>,
    /// The budget: a row for each output, a column for each input: sensitivity coefficient times standard uncertainty.
    pub contributions: DMatrix<f64>,
    /// Of the outputs.
    pub covariance: DMatrix<f64>,
    inputs: Vec<Input>,
    correlated: bool,
}

impl Propagation {
    /// Sensitivity coefficient of an output to an input; `None` for an input without uncertainty, along which there is no
    /// step to take.
    #[must_use]
    pub fn sensitivity(&self, output: usize, input: usize) -> Option<f64> {
        let u = self.inputs.get(input)?.u;
        (u > 0.0).then(|| self.contributions[(output, input)] / u)
    }

    /// Of an output.
    #[must_use]
    pub fn standard_uncertainty(&self, output: usize) -> f64 {
        self.covariance[(output, output)].max(0.0).sqrt()
    }

    /// Correlation coefficient of two outputs; NaN where one of them is certain.
    #[must_use]
    pub fn correlation(&self, one: usize, other: usize) -> f64 {
        self.covariance[(one, other)] / (self.standard_uncertainty(one) * self.standard_uncertainty(other))
    }

    /// Effective degrees of freedom of an output by Welch and Satterthwaite (GUM G.4); `None` where inputs are correlated
    /// and their degrees of freedom finite: the formula is for independent ones.
    #[must_use]
    pub fn effective_degrees_of_freedom(&self, output: usize) -> Option<f64> {
        let finite = self.inputs.iter().any(|input| input.degrees_of_freedom.is_finite());
        if self.correlated && finite {
            return None;
        }
        let parts = self.contributions.row(output);
        let weighed: f64 =
            parts.iter().zip(&self.inputs).map(|(part, input)| part.powi(4) / input.degrees_of_freedom).sum();
        let variance = self.covariance[(output, output)];
        Some(if weighed > 0.0 { variance * variance / weighed } else { f64::INFINITY })
    }

    /// Expanded uncertainty of an output for this coverage probability; `None` without effective degrees of freedom.
    ///
    /// # Errors
    /// [`PropagationError::Probability`].
    pub fn expanded_uncertainty(
        &self,
        output: usize,
        probability: f64,
    ) -> Result<Option<f64>, PropagationError> {
        check_probability(probability)?;
        let Some(degrees) = self.effective_degrees_of_freedom(output) else { return Ok(None) };
        Ok(Some(coverage_factor(probability, degrees)? * self.standard_uncertainty(output)))
    }
}
