//! Simulated pairs of measurements of one fixture that has moved between them, or not.

// Each of those who use it has its own part; a test may panic.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

use nalgebra::{Matrix6, Vector6};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use rayon::prelude::*;
use touchref::{
    Fixture, FixturePlugin, Frame, Parameters, Probe, Problem, Solution, Solver, Touch, Twist, Value,
    analysis::{
        Linear,
        drift::{Change, Comparison, Located, Scatter},
        simulation::{Layout, generator, random_frame, random_layout, simulate},
    },
    fixture::touches_per_surface,
    fixtures::{composite, cube, cylinder_plane, three_sphere},
};

/// Frames lie within this distance of the parent's origin.
const REACH: f64 = 500.0;

/// Standard deviation of one touch.
const SIGMA: f64 = 0.005;

/// Errors that are common, not counted as such: for comparison.
pub const INDEPENDENT: &str = "these counted as independent";

/// Pairs of measurements with the same true sizes and tip, drawn from what is stated of them.
pub struct Pairs<'a> {
    pub plugin: &'static FixturePlugin,
    /// As stated.
    pub parameters: Parameters,
    /// As stated.
    pub probe: Probe,
    /// Where the fixture is touched.
    pub layout: Layout,
    /// Whether the second measurement has one more touch on each surface, somewhere.
    pub more: bool,
    /// Count the errors of sizes and tip as common.
    pub common: bool,
    /// Take the noise from the residuals, as solvers do where no sigma is stated: these would search much longer.
    pub estimated: bool,
    pub solver: &'a dyn Solver,
    pub seed: u64,
}

/// A fixture with uncertain sizes, and how it is touched.
pub struct Case {
    pub name: &'static str,
    pub plugin: &'static FixturePlugin,
    /// With uncertain sizes, as far as it has them.
    pub uncertain: Parameters,
    pub exact: Parameters,
    pub seed: u64,
}

/// Every built-in fixture; one that leaves a motion free, too.
pub fn cases(seed: u64) -> Vec<Case> {
    let new = Parameters::new;
    let about = |value: f64| Value::Number { value, u: 0.02 };
    let sides = || new().with("radius", 12.7).with("ab", 100.0).with("bc", 110.0);
    let case = |name, plugin, exact: Parameters, uncertain: Parameters| Case {
        name,
        plugin,
        uncertain,
        exact,
        seed,
    };
    let (block, bore) = (super::support::v_block(), super::support::bore_with_two_faces());
    vec![
        case(
            "cylinder-plane",
            &cylinder_plane::PLUGIN,
            new().with("radius", 20.0),
            new().with("radius", about(20.0)),
        ),
        case(
            "three-sphere",
            &three_sphere::PLUGIN,
            sides().with("ca", 90.0),
            sides().with("ca", about(90.0)),
        ),
        case("cube", &cube::PLUGIN, new().with("edge", 50.0), new().with("edge", 50.0)),
        case("V-block", &composite::PLUGIN, block.clone(), block),
        case("bore and two faces, spin free", &composite::PLUGIN, bore.clone(), bore),
    ]
}

impl Case {
    /// Everything but the touches exact; both measurements touch alike.
    pub fn exact<'a>(&self, solver: &'a dyn Solver) -> Pairs<'a> {
        Pairs {
            plugin: self.plugin,
            parameters: self.exact.clone(),
            probe: Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) },
            layout: doubled(&*self.plugin.build(&self.exact).unwrap()),
            more: false,
            common: false,
            estimated: false,
            solver,
            seed: self.seed,
        }
    }

    /// What false alarms may come from.
    pub fn kinds<'a>(&self, solver: &'a dyn Solver) -> Vec<(&'static str, Pairs<'a>)> {
        let exact = || Pairs { more: true, ..self.exact(solver) };
        let uncertain = || Pairs {
            parameters: self.uncertain.clone(),
            probe: Probe { tip_radius_u: 0.02, ..exact().probe },
            ..exact()
        };
        vec![
            ("all exact but the touches", exact()),
            ("common errors of sizes and tip", Pairs { common: true, ..uncertain() }),
            (INDEPENDENT, uncertain()),
            ("noise told by the residuals", Pairs { estimated: true, ..exact() }),
        ]
    }
}

/// The fixture's own layout, and as many touches again elsewhere: enough that every measurement gives a frame.
fn doubled(fixture: &dyn Fixture) -> Layout {
    let mut layout = fixture.nominal_layout();
    let counts = touches_per_surface(fixture.surfaces().len(), layout.iter().map(|(surface, _)| *surface));
    layout.extend(random_layout(fixture, &counts, &mut generator(0, 0)));
    layout
}

/// How often a motion was found.
#[derive(Debug, Default, Clone, Copy)]
pub struct Found {
    /// Pairs of which both measurements gave a frame.
    pub pairs: u64,
    /// Of these, how many were told to have moved.
    pub moved: u64,
}

impl Found {
    pub fn rate(&self) -> f64 {
        self.moved as f64 / self.pairs as f64
    }
}

impl Pairs<'_> {
    /// Which of so many pairs are told to have moved, at each `alpha`, the fixture having moved by `motion` along its axes.
    pub fn found(&self, trials: u64, motion: &Twist, alphas: &[f64]) -> Vec<Found> {
        let fixture = self.plugin.build(&self.parameters).unwrap();
        let changes: Vec<Option<Change>> =
            (0..trials).into_par_iter().map(|trial| self.pair(&*fixture, trial, motion)).collect();
        let of = |alpha: &f64| {
            let told = changes.iter().flatten().map(|change| change.significance.exceeds(*alpha));
            Found { pairs: told.clone().count() as u64, moved: told.filter(|moved| *moved).count() as u64 }
        };
        alphas.iter().map(of).collect()
    }

    /// One pair; `None` where a measurement gave no frame.
    pub fn pair(&self, fixture: &dyn Fixture, trial: u64, motion: &Twist) -> Option<Change> {
        let mut rng = generator(self.seed, trial);
        let mut drawn = |value: f64, u: f64| value + u * rng.sample::<f64, _>(StandardNormal);
        let mut parameters = Parameters::new();
        for (name, value) in self.parameters.iter() {
            let value = match value {
                Value::Number { value, u } => Value::from(drawn(*value, *u)),
                other => other.clone(),
            };
            parameters.set(name, value);
        }
        let tip_radius = drawn(self.probe.tip_radius, self.probe.tip_radius_u);
        let truth = (self.plugin.build(&parameters).unwrap(), Probe { tip_radius, ..self.probe });
        let before = random_frame(REACH, &mut rng);
        let counts = (0..fixture.surfaces().len())
            .map(|surface| usize::from(self.layout.iter().any(|(of, _)| *of == surface)))
            .collect::<Vec<_>>();
        let mut more = self.layout.clone();
        if self.more {
            more.extend(random_layout(fixture, &counts, &mut rng));
        }
        let first = self.located(fixture, &truth, &self.layout, &before, &mut rng)?;
        let second = self.located(fixture, &truth, &more, &before.moved(motion), &mut rng)?;
        Some(Comparison::of(fixture).change(&first, &second).unwrap())
    }

    fn located(
        &self,
        fixture: &dyn Fixture,
        (true_fixture, true_probe): &(Box<dyn Fixture>, Probe),
        layout: &Layout,
        frame: &Frame,
        rng: &mut impl Rng,
    ) -> Option<Located> {
        let touched = at(layout);
        let planned = Problem::new(&**true_fixture, &touched, *true_probe).unwrap();
        let contacts: Layout = touchref::analysis::contacts(&planned, &Frame::identity());
        let touches = simulate(&**true_fixture, &contacts, frame, true_probe, SIGMA, rng);
        let problem = Problem::new(fixture, &touches, self.probe).unwrap();
        let solution = self.solver.solve(&problem).ok()?;
        Some(self.judged(fixture, &problem, &solution))
    }

    fn judged(&self, fixture: &dyn Fixture, problem: &Problem<'_>, solution: &Solution) -> Located {
        let covariance = solution.covariance.as_ref().unwrap();
        if self.common {
            let linear = Linear::at(problem, &solution.frame).unwrap();
            return Comparison::of(fixture).taken_apart(&linear, |_| true, &covariance.matrix).unwrap();
        }
        if self.estimated {
            let degrees_of_freedom = solution.degrees_of_freedom;
            let variance = solution.chi_square.unwrap() / degrees_of_freedom as f64;
            let scatter = Scatter { sigma: SIGMA * variance.sqrt(), degrees_of_freedom };
            return Located::independent(solution.frame, covariance.matrix * variance, Some(scatter));
        }
        Located::independent(solution.frame, covariance.matrix, None)
    }

    /// Motions along the fixture's axes, of so many standard deviations of the difference: along the weakest direction,
    /// and along the best known one. Where both measurements touch alike, and sizes and tip are exact.
    pub fn motions(&self, deviations: f64) -> [Twist; 2] {
        let fixture = self.plugin.build(&self.parameters).unwrap();
        let size = fixture.size();
        let mut scale = Vector6::repeat(1.0);
        scale.fixed_rows_mut::<3>(3).fill(size);
        let touches = at(&self.layout);
        let surface_points = Probe { tip_radius: 0.0, sigma: Some(SIGMA), ..self.probe };
        let problem = Problem::new(&*fixture, &touches, surface_points).unwrap();
        let linear = Linear::at(&problem, &Frame::identity()).unwrap();
        let covariance = 2.0 * linear.covariance();
        let scaled = Matrix6::from_diagonal(&scale) * covariance * Matrix6::from_diagonal(&scale);
        let eigen = scaled.symmetric_eigen();
        let known = |index: &usize| eigen.eigenvalues[*index] > 1e-12 * eigen.eigenvalues.max();
        let least =
            (0..6).filter(known).min_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        [eigen.eigenvalues.imax(), least.unwrap()].map(|index| {
            let direction = eigen.eigenvectors.column(index) * (deviations * eigen.eigenvalues[index].sqrt());
            Twist::from(Vector6::from(direction.component_div(&scale)))
        })
    }
}

/// Touches of surface points where the layout touches.
fn at(layout: &Layout) -> Vec<Touch> {
    layout.iter().map(|(surface, contact)| Touch::new(*surface, *contact)).collect()
}
