//! What has moved: all of the fixture, or one of its surfaces on it?
//!
//! The touches of both measurements are taken as of one fixture at one frame, and each hypothesis adds the motions that it
//! allows: of all later touches together, or of those on one surface. Each is held against the richest one, in which every
//! surface has moved by itself: by how much more it leaves unexplained is chi-square with as many degrees of freedom as it
//! has motions less, if it is true.

use nalgebra::{DMatrix, DVector, Vector6};
use touchref_core::{
    Fixture, Frame, Noise, Problem, RANK_TOLERANCE, Touch, TouchError, Twist, statistics::chi_square_p_value,
};

use crate::Linear;

/// A measurement with stated noise, and the frame that was found in it.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// The measurement.
    pub problem: Problem<'a>,
    /// Its frame.
    pub frame: Frame,
}

/// What may have moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hypothesis {
    /// All surfaces together.
    Fixture,
    /// Only the surface of this index.
    Surface(usize),
}

/// How well a hypothesis explains the touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Explanation {
    /// What has moved, by it.
    pub hypothesis: Hypothesis,
    /// By how much more it leaves unexplained than that every surface has moved by itself.
    pub chi_square: f64,
    /// How many motions less it allows.
    pub degrees_of_freedom: usize,
    /// The chance of a larger `chi_square` if it is true; 1 where it allows as much.
    pub p_value: f64,
}

/// Weighs what may have moved between the measurements of the `baseline`, in which nothing did, and a `later` one, of the
/// same fixture with the same tip: the fixture as a whole, then each surface that was touched later. `None` where no sigma
/// is stated, or where the touches leave a motion free that the fixture does not.
///
/// # Errors
/// [`TouchError`], where the measurements do not make one.
pub fn explain(baseline: &[Seen<'_>], later: &Seen<'_>) -> Result<Option<Vec<Explanation>>, TouchError> {
    let tip = |seen: &Seen<'_>| (seen.problem.probe().tip_radius, seen.problem.probe().tip_radius_u);
    let fits = |seen: &Seen<'_>| seen.problem.reference_sigma().is_some() && tip(seen) == tip(later);
    let Some(first) = baseline.first().filter(|_| baseline.iter().chain([later]).all(fits)) else {
        return Ok(None);
    };
    let before: Vec<Touch> = baseline.iter().flat_map(with_own_noise).collect();
    let joint = Joint {
        fixture: later.problem.fixture(),
        problem: &first.problem,
        frame: first.frame,
        before,
        after: with_own_noise(later).collect(),
        motion: first.frame.twist_to(&later.frame),
    };
    let touched: Vec<usize> = (0..joint.fixture.surfaces().len())
        .filter(|surface| joint.after.iter().any(|touch| touch.surface == *surface))
        .collect();
    let each: Vec<Vec<usize>> = touched.iter().map(|surface| vec![*surface]).collect();
    let Some(richest) = joint.fit(&each, true)? else { return Ok(None) };
    let mut explanations = Vec::new();
    let whole = (Hypothesis::Fixture, touched.clone());
    for (hypothesis, body) in std::iter::once(whole)
        .chain(touched.iter().map(|surface| (Hypothesis::Surface(*surface), vec![*surface])))
    {
        let Some(fit) = joint.fit(&[body], hypothesis == Hypothesis::Fixture)? else { return Ok(None) };
        let chi_square = (fit.chi_square - richest.chi_square).max(0.0);
        let degrees_of_freedom = richest.motions.saturating_sub(fit.motions);
        explanations.push(Explanation {
            hypothesis,
            chi_square,
            degrees_of_freedom,
            p_value: chi_square_p_value(chi_square, degrees_of_freedom).unwrap_or(1.0),
        });
    }
    Ok(Some(explanations))
}

/// The touches, each stating its own noise.
fn with_own_noise<'a>(seen: &'a Seen<'_>) -> impl Iterator<Item = Touch> + 'a {
    let of_probe = seen.problem.probe().sigma;
    seen.problem.touches().iter().map(move |touch| match (touch.noise, of_probe) {
        (Noise::OfProbe, Some(sigma)) => touch.with_sigma(sigma),
        _ => *touch,
    })
}

/// Two measurements as one.
struct Joint<'a> {
    fixture: &'a dyn Fixture,
    /// For its probe.
    problem: &'a Problem<'a>,
    frame: Frame,
    before: Vec<Touch>,
    after: Vec<Touch>,
    /// Of the whole fixture, along its axes: to start from.
    motion: Twist,
}

/// What a hypothesis leaves unexplained.
struct Fit {
    chi_square: f64,
    /// How many motions the touches see of those it allows.
    motions: usize,
}

impl Joint<'_> {
    /// Lets each body, a set of surfaces, move between the measurements by itself. Starts from the motion of the whole
    /// fixture, or from rest.
    fn fit(&self, bodies: &[Vec<usize>], from_motion: bool) -> Result<Option<Fit>, TouchError> {
        /// Gauss-Newton on distances that are next to linear settles in a few steps.
        const STEPS: usize = 20;
        /// Decrease of chi-square beneath which no test notices.
        const SETTLED: f64 = 1e-6;
        let start = if from_motion { Frame::identity().moved(&self.motion) } else { Frame::identity() };
        let mut moved = vec![start; bodies.len()];
        let mut fit: Option<Fit> = None;
        for _ in 0..STEPS {
            let Some(Step { chi_square, motions, steps }) = self.step(bodies, &moved)? else {
                return Ok(None);
            };
            for (body, step) in moved.iter_mut().zip(&steps) {
                *body = body.moved(step);
            }
            let settled = fit.is_some_and(|last| (last.chi_square - chi_square).abs() < SETTLED);
            fit = Some(Fit { chi_square, motions });
            if settled {
                break;
            }
        }
        Ok(fit)
    }

    /// The best motions of the bodies to first order, where they have `moved` already.
    fn step(&self, bodies: &[Vec<usize>], moved: &[Frame]) -> Result<Option<Step>, TouchError> {
        let body_of = |touch: &Touch| bodies.iter().position(|body| body.contains(&touch.surface));
        // Where a later touch would have been, had its body not moved.
        let unmoved = self.after.iter().map(|touch| match body_of(touch) {
            Some(body) => {
                let at = moved[body].to_fixture(&self.frame.to_fixture(&touch.at));
                Touch { at: self.frame.to_parent(&at), ..*touch }
            }
            None => *touch,
        });
        let touches: Vec<Touch> = self.before.iter().copied().chain(unmoved).collect();
        let problem = Problem::new(self.fixture, &touches, *self.problem.probe())?;
        let Some(linear) = Linear::at(&problem, &self.frame) else { return Ok(None) };
        let size = self.fixture.size();
        let mut columns = DMatrix::zeros(linear.observations().len(), 6 * bodies.len());
        for (index, touch) in touches.iter().enumerate().skip(self.before.len()) {
            if let Some(body) = body_of(touch) {
                let contact = problem.contact(&self.frame, index);
                let mut row = Vector6::from(contact.gradient()) / contact.sigma;
                // Turns in lengths, as shifts are.
                row.fixed_rows_mut::<3>(3).unscale_mut(size);
                columns.fixed_view_mut::<1, 6>(index, 6 * body).copy_from(&row.transpose());
            }
        }
        let seen = linear.redundancy() * &columns;
        let residuals = linear.residuals();
        let decomposed = seen.clone().svd(true, true);
        let tolerance = RANK_TOLERANCE * columns.norm();
        let motions = decomposed.rank(tolerance);
        let Ok(steps) = decomposed.solve(&-residuals, tolerance) else { return Ok(None) };
        let left: DVector<f64> = residuals + seen * &steps;
        let twist = |body: usize| {
            let mut twist = Twist::from(steps.fixed_rows::<6>(6 * body).into_owned());
            twist.rotation /= size;
            twist
        };
        Ok(Some(Step {
            chi_square: left.norm_squared(),
            motions,
            steps: (0..bodies.len()).map(twist).collect(),
        }))
    }
}

/// One step toward the best motions of some bodies.
struct Step {
    /// What they leave unexplained, to first order.
    chi_square: f64,
    motions: usize,
    /// Along the fixture's axes.
    steps: Vec<Twist>,
}
