//! Refinement beside its peers: the plain loop and argmin's `Executor` over the same step, argmin's own Gauss-Newton,
//! and the `levenberg-marquardt` crate.
//!
//! ```text
//! cargo bench --bench refinement -- [problems timed] [bad starts]
//! ```
//!
//! First the time from a root of the closed form to the least-squares frame of 4 + 3 touches: medians of interleaved
//! rounds in one run, and their ratios. Then the share of bad starts, 30 degrees and 30 mm off, from which each reaches
//! the frame of 16 + 14 touches.
//!
//! The peers know vectors only. They get the twist that leads from the start to the frame, with exact derivatives, and
//! what was computed for residuals is kept for derivatives ([`Chart`]). They are told to stop where the library does.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)] // A bench may panic, and tells its figures.

mod rounds;
#[path = "../tests/support/mod.rs"]
mod support;

use std::{cell::RefCell, hint::black_box};

use argmin::{
    core::{Error, Executor, IterState, Jacobian, Operator, State},
    solver::gaussnewton::GaussNewton,
};
use levenberg_marquardt::LeastSquaresProblem;
use nalgebra::{Vector3, Vector6};
use nalgebra_0_34::{
    Const, DMatrix, DVector, DefaultAllocator, DimMax, DimMaximum, DimMin, SMatrix, SVector, U6,
    allocator::{Allocator, Reallocator},
    storage::Owned,
};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use rounds::Rounds;
use touchref::{
    Contact, Fixture, Frame, Probe, Problem, Root, Touch, Twist,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
    solvers::{
        Unknowns,
        refinement::{LevenbergMarquardt, Misfit, RefinementState, descend},
    },
};

const PROBE: Probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(0.01) };
/// Two ends nearer than this are one frame: what the plain loop promises, standard deviations.
const SAME: f64 = 1e-4;
/// A bad start that ends as near as this to where the truth leads has reached it, standard deviations.
const REACHED: f64 = 1e-3;
/// How far off a bad start is turned, radians.
const TURN: f64 = std::f64::consts::FRAC_PI_6;
/// How far off its origin lies.
const SHIFT: f64 = 30.0;
/// Steps the library allows itself.
const STEPS: u64 = 100;

fn main() {
    // `cargo bench` adds an argument of its own.
    let arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let mut sizes = arguments.map(|argument| argument.parse::<u64>().unwrap());
    let (problems, starts) = (sizes.next().unwrap_or(1000), sizes.next().unwrap_or(10_000));
    let fixture = support::cylinder_plane(20.0, 45.0);
    derivatives_are_true(&*fixture);
    time_from_roots(&*fixture, problems);
    println!();
    share_of_bad_starts(&*fixture, starts);
}

/// Random touches of a fixture at a random frame, and that frame.
fn measurement(fixture: &dyn Fixture, counts: [usize; 2], rng: &mut impl Rng) -> (Vec<Touch>, Frame) {
    let layout = random_layout(fixture, &counts, rng);
    let truth = random_frame(1000.0, rng);
    (simulate(fixture, &layout, &truth, &PROBE, 0.01, rng), truth)
}

/// The distance between two frames in standard deviations that the touches give the first.
fn deviations(problem: &Problem<'_>, from: &Frame, to: &Frame) -> f64 {
    let twist = Vector6::from(from.twist_to(to));
    let rises = (0..problem.touches().len()).map(|index| {
        let contact = problem.contact(from, index);
        Vector6::from(contact.gradient()).dot(&twist) / contact.sigma
    });
    rises.map(|rise| rise * rise).sum::<f64>().sqrt()
}

/// A frame, and the steps that were tried on the way there.
struct End {
    frame: Frame,
    steps: u64,
}

/// A way from a start to the least-squares frame; judged by where it ends, whatever it says of that.
struct Method {
    name: &'static str,
    run: for<'a> fn(&'a Problem<'a>, &Frame) -> Option<End>,
}

/// The plain loop, the `Executor`, and the peers, for `N` touches.
fn methods<const N: usize>() -> [Method; 4]
where
    Const<N>: DimMin<U6> + DimMax<U6>,
    DefaultAllocator: Allocator<DimMaximum<Const<N>, U6>, U6>
        + Reallocator<f64, Const<N>, U6, DimMaximum<Const<N>, U6>, U6>,
{
    [
        Method {
            name: "plain loop",
            run: |problem, start| {
                let end = descend(problem, start);
                Some(End { frame: end.frame, steps: end.steps as u64 })
            },
        },
        Method {
            name: "the same by argmin's Executor",
            run: |problem, start| {
                let start = Unknowns::at(*start);
                let result = Executor::new(Misfit::<6>::new(problem, &[]), LevenbergMarquardt::default())
                    .configure(|state: RefinementState| state.param(start).max_iters(STEPS).counting(false))
                    .ctrlc(false)
                    .run()
                    .ok()?;
                Some(End { frame: result.state().get_param()?.frame, steps: result.state().get_iter() })
            },
        },
        Method {
            name: "argmin's Gauss-Newton",
            run: |problem, start| {
                let chart = Chart::<N>::new(problem, start);
                // By default it stops when the norm of the residuals changes by less than 1.5e-8: where that norm is
                // one, a step of 1.7e-4 standard deviations. The library stops at 1e-4.
                let result = Executor::new(OfVectors(RefCell::new(chart)), GaussNewton::new())
                    .configure(|state: IterState<_, (), _, (), _, f64>| {
                        state.param(DVector::zeros(6)).max_iters(STEPS).counting(false)
                    })
                    .ctrlc(false)
                    .run()
                    .ok()?;
                let twist = Vector6::from_column_slice(result.state().get_param()?.as_slice());
                Some(End { frame: start.moved(&Twist::from(twist)), steps: result.state().get_iter() })
            },
        },
        Method {
            name: "levenberg-marquardt crate",
            run: |problem, start| {
                // The library's own bounds on cost, step and gradient.
                let (chart, report) = levenberg_marquardt::LevenbergMarquardt::new()
                    .with_ftol(1e-8)
                    .with_xtol(1e-9)
                    .with_gtol(1e-12)
                    .minimize(Chart::<N>::new(problem, start));
                let steps = report.number_of_evaluations as u64 - 1;
                Some(End { frame: chart.frame, steps })
            },
        },
    ]
}

/// `N` touches over a chart of the frames about a start, `x -> start.moved(x)`, seen from one `x`.
#[derive(Clone)]
struct Chart<'a, const N: usize> {
    problem: &'a Problem<'a>,
    start: Frame,
    x: [f64; 6],
    frame: Frame,
    contacts: [Contact; N],
}

impl<'a, const N: usize> Chart<'a, N> {
    fn new(problem: &'a Problem<'a>, start: &Frame) -> Self {
        let contacts = std::array::from_fn(|index| problem.contact(start, index));
        Self { problem, start: *start, x: [0.0; 6], frame: *start, contacts }
    }

    #[expect(clippy::float_cmp, reason = "whether it is the very same place")]
    fn move_to(&mut self, x: &[f64]) {
        if self.x != x {
            self.x.copy_from_slice(x);
            self.frame = self.start.moved(&Twist::from(Vector6::from(self.x)));
            self.contacts = std::array::from_fn(|index| self.problem.contact(&self.frame, index));
        }
    }

    /// In standard deviations.
    fn residuals(&self) -> [f64; N] {
        self.contacts.map(|contact| contact.residual / contact.sigma)
    }

    /// Of each residual over `x = (v, w)`.
    ///
    /// A change `(dv, dw)` of `x` moves the frame by the twist `(exp(-w) dv, J dw)` along its own axes, where
    /// `J = 1 - a [w] + b [w]^2`, `a = (1 - cos |w|) / |w|^2`, `b = (|w| - sin |w|) / |w|^3`, is the right Jacobian of
    /// rotations (Sola et al., "A micro Lie theory", equation 143).
    fn gradients(&self) -> [[f64; 6]; N] {
        /// Below this square of an angle, the next term of the series of `b` is less than rounding.
        const SMALL: f64 = 1e-4;
        let w = Vector3::new(self.x[3], self.x[4], self.x[5]);
        let exp = self.start.rotation.matrix().tr_mul(self.frame.rotation.matrix());
        let square = w.norm_squared();
        let (a, b) = if square < SMALL {
            (
                0.5 - square / 24.0 + square * square / 720.0,
                1.0 / 6.0 - square / 120.0 + square * square / 5040.0,
            )
        } else {
            let (sine, cosine) = square.sqrt().sin_cos();
            ((1.0 - cosine) / square, (1.0 - sine / square.sqrt()) / square)
        };
        self.contacts.map(|contact| {
            let [x, y, z, rx, ry, rz] = contact.gradient();
            let (by_v, by_w) = (Vector3::new(x, y, z), Vector3::new(rx, ry, rz));
            let crossed = w.cross(&by_w);
            let by_v = exp * by_v / contact.sigma;
            let by_w = (by_w + a * crossed + b * w.cross(&crossed)) / contact.sigma;
            [by_v.x, by_v.y, by_v.z, by_w.x, by_w.y, by_w.z]
        })
    }
}

/// For argmin, which never says that it is still at the same `x`, and wants a Jacobian, its transpose and their product
/// to be of one type: matrices of fixed size will not do.
struct OfVectors<'a, const N: usize>(RefCell<Chart<'a, N>>);

impl<const N: usize> Operator for OfVectors<'_, N> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;

    fn apply(&self, x: &DVector<f64>) -> Result<DVector<f64>, Error> {
        let mut chart = self.0.borrow_mut();
        chart.move_to(x.as_slice());
        Ok(DVector::from_column_slice(&chart.residuals()))
    }
}

impl<const N: usize> Jacobian for OfVectors<'_, N> {
    type Param = DVector<f64>;
    type Jacobian = DMatrix<f64>;

    fn jacobian(&self, x: &DVector<f64>) -> Result<DMatrix<f64>, Error> {
        let mut chart = self.0.borrow_mut();
        chart.move_to(x.as_slice());
        let rows = chart.gradients();
        Ok(DMatrix::from_fn(N, 6, |i, j| rows[i][j]))
    }
}

impl<const N: usize> LeastSquaresProblem<f64, Const<N>, U6> for Chart<'_, N> {
    type ResidualStorage = Owned<f64, Const<N>>;
    type JacobianStorage = Owned<f64, Const<N>, U6>;
    type ParameterStorage = Owned<f64, U6>;

    fn set_params(&mut self, x: &SVector<f64, 6>) {
        self.move_to(x.as_slice());
    }

    fn params(&self) -> SVector<f64, 6> {
        self.x.into()
    }

    fn residuals(&self) -> Option<SVector<f64, N>> {
        Some(self.residuals().into())
    }

    fn jacobian(&self) -> Option<SMatrix<f64, N, 6>> {
        let rows = self.gradients();
        Some(SMatrix::from_fn(|i, j| rows[i][j]))
    }
}

/// The peers' derivatives against central differences, near the start and far from it.
fn derivatives_are_true(fixture: &dyn Fixture) {
    /// Of the differences: lengths and radians.
    const STEP: f64 = 1e-5;
    /// What truncation and rounding leave of a derivative, in parts of the largest.
    const LEFT: f64 = 1e-8;
    for trial in 0..20 {
        let mut rng = generator(21, trial);
        let (touches, truth) = measurement(fixture, [4, 3], &mut rng);
        let problem = Problem::new(fixture, &touches, PROBE).unwrap();
        let mut chart = Chart::<7>::new(&problem, &truth);
        // Turns from 1e-4 radians, where the series holds, to 1.
        let reach = 10.0_f64.powf(-0.2 * trial as f64);
        let x: [f64; 6] = std::array::from_fn(|_| reach * rng.random_range(-1.0..1.0));
        chart.move_to(&x);
        let exact = chart.gradients();
        let largest = exact.iter().flatten().fold(0.0_f64, |most, slope| most.max(slope.abs()));
        for k in 0..6 {
            let [ahead, behind] = [STEP, -STEP].map(|step| {
                let mut moved = x;
                moved[k] += step;
                chart.move_to(&moved);
                chart.residuals()
            });
            for i in 0..7 {
                let difference = (ahead[i] - behind[i]) / (2.0 * STEP);
                let off = (difference - exact[i][k]).abs() / largest;
                assert!(off < LEFT, "trial {trial}, touch {i}, unknown {k}: {off:e} of the largest");
            }
        }
    }
}

/// Times from the root nearest the truth to the least-squares frame of 4 + 3 touches, where all methods find the same.
fn time_from_roots(fixture: &dyn Fixture, count: u64) {
    let measurements: Vec<_> =
        (0..count).map(|trial| measurement(fixture, [4, 3], &mut generator(22, trial))).collect();
    let methods = methods::<7>();
    let mut problems: Vec<(Problem<'_>, Frame)> = Vec::new();
    let (mut without_root, mut steps, mut elsewhere) = (0, [0; 4], [0; 4]);
    for (touches, truth) in &measurements {
        let problem = Problem::new(fixture, touches, PROBE).unwrap();
        let Some(start) = nearest_root(&problem, truth) else {
            without_root += 1;
            continue;
        };
        let ends = methods.each_ref().map(|method| (method.run)(&problem, &start));
        let ours = ends[0].as_ref().unwrap().frame;
        let same = ends
            .each_ref()
            .map(|end| end.as_ref().is_some_and(|end| deviations(&problem, &ours, &end.frame) <= SAME));
        for (count, same) in elsewhere.iter_mut().zip(same) {
            *count += u64::from(!same);
        }
        if same == [true; 4] {
            for (sum, end) in steps.iter_mut().zip(ends) {
                *sum += end.unwrap().steps;
            }
            problems.push((problem, start));
        }
    }

    let runs = methods.each_ref().map(|method| {
        || {
            for (problem, start) in &problems {
                black_box((method.run)(black_box(problem), black_box(start)));
            }
        }
    });
    let rounds = Rounds::of(problems.len(), runs.each_ref().map(|run| run as &dyn Fn()));
    println!("from the root nearest the truth to the frame of 4 + 3 touches, random layouts");
    println!("{:30}   median   steps   times plain loop   times Executor   elsewhere", "");
    for (index, method) in methods.iter().enumerate() {
        println!(
            "{:30} {:6.0} ns {:7.2} {:18.2} {:16.2} {:11}",
            method.name,
            rounds.time(index),
            steps[index] as f64 / problems.len() as f64,
            rounds.ratio(index, 0),
            rounds.ratio(index, 1),
            elsewhere[index],
        );
    }
    println!(
        "timed: {} of {count}, where all end within {SAME} standard deviations of the plain loop, not elsewhere; \
         {without_root} have no root",
        problems.len()
    );
}

/// The frame of the closed form's root that is nearest the truth.
fn nearest_root(problem: &Problem<'_>, truth: &Frame) -> Option<Frame> {
    let mut nearest: Option<(f64, Frame)> = None;
    let mut keep = |root: Root| {
        let off = truth.twist_to(&root.frame).extent(problem.fixture().size());
        if nearest.is_none_or(|(least, _)| off < least) {
            nearest = Some((off, root.frame));
        }
    };
    problem.fixture().closed_form().unwrap().roots(problem, &mut keep).unwrap();
    nearest.map(|(_, frame)| frame)
}

/// How many bad starts lead to where the truth leads, with 16 + 14 touches.
fn share_of_bad_starts(fixture: &dyn Fixture, count: u64) {
    let methods = methods::<30>();
    let mut reached = [0_u64; 4];
    for trial in 0..count {
        let mut rng = generator(23, trial);
        let (touches, truth) = measurement(fixture, [16, 14], &mut rng);
        let problem = Problem::new(fixture, &touches, PROBE).unwrap();
        let mut direction = || Vector3::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal)).normalize();
        let start = truth.moved(&Twist { translation: direction() * SHIFT, rotation: direction() * TURN });
        let goal = descend(&problem, &truth).frame;
        for (count, method) in reached.iter_mut().zip(&methods) {
            let end = (method.run)(&problem, &start);
            *count += u64::from(end.is_some_and(|end| deviations(&problem, &goal, &end.frame) <= REACHED));
        }
    }
    println!(
        "{count} starts turned by {:.0} degrees and shifted by {SHIFT} mm, to the frame of 16 + 14 touches",
        TURN.to_degrees()
    );
    println!("{:30}   share that reach it", "");
    for (method, reached) in methods.iter().zip(reached) {
        println!("{:30} {:18.2} %", method.name, 100.0 * reached as f64 / count as f64);
    }
}
