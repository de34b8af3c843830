//! Planned layouts held against exhaustive search, against random layouts, and against what they promise.

#![allow(clippy::unwrap_used)] // A test may panic.

mod support;

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3x6, Matrix6, Point3, Unit, Vector3, Vector6};
use touchref::{
    Extent, Fixture, Frame, Parameters, Probe, Problem, SolveError, Solver, Surface,
    analysis::{
        Layout, Linear,
        planning::{
            Cone, Criterion, Effect, PlanError, Planner, REDUNDANCY_ROUNDING, Reach, Wanted, default_points,
            worst_case,
        },
        simulation::{generator, random_frame, random_layout, simulate},
    },
};

const SIGMA: f64 = 1e-3;

fn planner<'a>(fixture: &'a dyn Fixture, solver: &'a dyn Solver) -> Planner<'a> {
    Planner {
        fixture,
        probe: Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(SIGMA) },
        solver,
        reach: Reach::of(fixture),
        points: default_points(fixture),
        criterion: Criterion::Worst,
        least_redundancy: 0.0,
    }
}

fn nominal_counts(fixture: &dyn Fixture) -> Vec<usize> {
    let layout = fixture.nominal_layout();
    (0..fixture.surfaces().len()).map(|s| layout.iter().filter(|(of, _)| *of == s).count()).collect()
}

/// Four touches of a cylinder about Z, their heights counted from `middle`: how well they fix its axis, as
/// `s12 s34 z13 z24 - s13 s24 z12 z34` tells.
fn determinant(touches: &[Point3<f64>], middle: f64) -> f64 {
    let seen: Vec<(f64, f64)> = touches.iter().map(|at| (at.y.atan2(at.x), at.z - middle)).collect();
    let s = |i: usize, j: usize| (seen[i].0 - seen[j].0).sin();
    let z = |i: usize, j: usize| seen[i].1 - seen[j].1;
    s(0, 1) * s(2, 3) * z(0, 2) * z(1, 3) - s(0, 2) * s(1, 3) * z(0, 1) * z(2, 3)
}

/// Two touches at each end, a quarter turn apart within an end.
fn assert_two_at_each_end(touches: &[Point3<f64>], ends: [f64; 2]) {
    for end in ends {
        let there: Vec<_> = touches.iter().filter(|at| (at.z - end).abs() < 1e-6).collect();
        assert_eq!(there.len(), 2, "{touches:?}");
        let turn = |at: &Point3<f64>| at.y.atan2(at.x);
        let apart = (turn(there[0]) - turn(there[1])).rem_euclid(PI);
        assert!((apart - FRAC_PI_2).abs() < 1e-3, "{touches:?}");
    }
}

/// Where the frame rests on the cylinder's axis: a cylinder alone, whose slide and spin are free, and `cylinder-plane` with
/// a plane too small to tell of tilt. Radius 1, within one of the middle.
#[test]
fn four_touches_of_a_cylinder_are_two_at_each_end_a_quarter_turn_apart() {
    let pin = Parameters::new().with("type", "cylinder").with("name", "pin").with("point", [0.0; 3]);
    let pin = pin.with("axis", [0.0, 0.0, 1.0]).with("radius", 1.0).with("from", -1.0).with("to", 1.0);
    let parameters = Parameters::new().with("surface", vec![pin]).with("free", &["z", "rz"][..]);
    let solver = support::solver("least-squares");
    let alone = support::fixture("composite", &parameters);
    let with_plane = support::cylinder_plane(1.0, 45.0);
    let small = Reach::of(&*with_plane)
        .with_extent(0, Extent::Along { from: -3.0, to: -1.0 })
        .with_extent(1, Extent::Disc { radius: 1e-4 });
    for (fixture, reach, counts, middle) in
        [(&alone, Reach::of(&*alone), &[4][..], 0.0), (&with_plane, small, &[4, 3], -2.0)]
    {
        let planner = Planner { criterion: Criterion::Volume, reach, ..planner(&**fixture, &*solver) };
        let layout = planner.unconstrained(counts).unwrap();
        let touches: Vec<Point3<f64>> = layout.iter().take(4).map(|(_, at)| *at).collect();
        let determinant = determinant(&touches, middle).abs();
        assert!((determinant - 4.0).abs() < 1e-6, "{determinant} {touches:?}");
        assert_two_at_each_end(&touches, [middle - 1.0, middle + 1.0]);
    }
}

/// A touch's row of the Jacobian over its standard deviation, from its geometry alone.
fn row(surface: &Surface, at: &Point3<f64>) -> Vector6<f64> {
    let n = surface.seen_from(at).normal;
    let turn = at.coords.cross(&n);
    Vector6::new(n.x, n.y, n.z, turn.x, turn.y, turn.z) / SIGMA
}

/// Largest standard uncertainty over points by the normal equations.
fn worst(information: &Matrix6<f64>, points: &[Point3<f64>]) -> f64 {
    let Some(covariance) = information.cholesky().map(|c| c.inverse()) else { return f64::INFINITY };
    let at = |point: &Point3<f64>| {
        let lever = Matrix3x6::from_fn(|i, j| {
            if j < 3 {
                f64::from(u8::from(i == j))
            } else {
                // w x p
                Vector3::ith(j - 3, 1.0).cross(&point.coords)[i]
            }
        });
        (lever * covariance * lever.transpose()).symmetric_eigenvalues().max()
    };
    points.iter().map(at).fold(0.0, f64::max).sqrt()
}

/// Every choice of so many of these.
fn choices(rows: &[Matrix6<f64>], count: usize) -> Vec<Matrix6<f64>> {
    if count == 0 {
        return vec![Matrix6::zeros()];
    }
    (0..rows.len())
        .flat_map(|k| choices(&rows[k + 1..], count - 1).into_iter().map(move |rest| rest + rows[k]))
        .collect()
}

/// The least over every layout on a grid.
fn exhaustive(fixture: &dyn Fixture, counts: &[usize], grid: &[(f64, f64)], points: &[Point3<f64>]) -> f64 {
    let mut sums = vec![Matrix6::zeros()];
    for (surface, count) in fixture.surfaces().iter().zip(counts) {
        let rows = grid.iter().map(|(u, v)| row(surface, &surface.point_at(*u, *v)));
        let own = choices(&rows.map(|row| row * row.transpose()).collect::<Vec<_>>(), *count);
        sums = sums.iter().flat_map(|sum| own.iter().map(move |more| sum + more)).collect();
    }
    sums.iter().map(|sum| worst(sum, points)).fold(f64::INFINITY, f64::min)
}

/// A kind of fixture, touches on each surface, and a grid on each.
type Case<'a> = (&'a str, &'a [usize], &'a [(f64, f64)]);

#[test]
fn plans_are_as_good_as_exhaustive_search() {
    /// Of the acceptance of a plan.
    const WITHIN: f64 = 1.01;
    let around = |turns: u32, v: f64| (0..turns).map(move |k| (f64::from(k) / f64::from(turns), v));
    let rim: Vec<(f64, f64)> = around(8, 1.0).collect();
    let ends: Vec<(f64, f64)> = around(6, 0.0).chain(around(6, 1.0)).collect();
    let solver = support::solver("least-squares");
    let cases: [Case<'_>; 7] = [
        ("cylinder-plane", &[4, 3], &ends),
        ("cube", &[3, 0, 2, 0, 1, 0], &rim),
        ("cube", &[3, 0, 2, 0, 2, 0], &rim),
        ("composite", &[3, 2, 1], &rim),
        ("composite", &[2, 2, 2], &rim),
        ("composite", &[2, 3, 2], &rim),
        // It needs nine.
        ("three-sphere", &[3, 3, 3], &rim[..6]),
    ];
    for (kind, counts, grid) in cases {
        let fixture = support::fixture(kind, &support::settings(kind)[0]);
        for far in [false, true] {
            let mut planner = planner(&*fixture, &*solver);
            if far {
                planner.points = vec![Point3::new(0.0, 0.0, 500.0)];
            }
            let plan = planner.plan(&Wanted::PerSurface(counts.to_vec()));
            let best = exhaustive(&*fixture, counts, grid, &planner.points);
            let plan = plan.unwrap();
            assert!(plan.worst() <= WITHIN * best, "{kind} {counts:?} {far}: {} of {best}", plan.worst());
        }
    }
}

/// With a radius and a tip that are uncertain: over layouts drawn anew, by the linear model.
#[test]
fn uncertain_sizes_take_part() {
    let fixture = support::fixture("cylinder-plane", &support::uncertain("cylinder-plane"));
    let solver = support::solver("least-squares");
    let mut planner = planner(&*fixture, &*solver);
    planner.probe = Probe { tip_radius: 1.5, tip_radius_u: 0.004, sigma: Some(0.01) };
    let plan = planner.plan(&Wanted::PerSurface(vec![6, 5])).unwrap();
    let touches = planner.touches(&plan.layout);
    let problem = Problem::new(&*fixture, &touches, planner.probe).unwrap();
    let linear = Linear::at(&problem, &Frame::identity()).unwrap();
    let worst = worst_case(&linear.covariance(), &Frame::identity(), &planner.points);
    assert_eq!(plan.uncertainties, worst);
    let mut rng = generator(7, 0);
    for _ in 0..2000 {
        let layout = random_layout(&*fixture, &[6, 5], &mut rng);
        assert!(planner.worst_of(&layout).is_none_or(|random| plan.worst() < random));
    }
}

#[test]
fn far_away_a_plan_is_twice_as_sure_as_the_median_random_layout() {
    let solver = support::solver("least-squares");
    for kind in ["cylinder-plane", "three-sphere", "cube", "composite"] {
        for parameters in support::settings(kind) {
            let fixture = support::fixture(kind, &parameters);
            let mut planner = planner(&*fixture, &*solver);
            planner.points = vec![Point3::new(300.0, 0.0, 400.0)];
            planner.least_redundancy = 0.1;
            let plan = planner.plan(&Wanted::PerSurface(nominal_counts(&*fixture))).unwrap();
            // Drawn here, from another seed than the plan's own median.
            let mut rng = generator(99, 0);
            let mut random: Vec<f64> = (0..201)
                .map(|_| random_layout(&*fixture, &nominal_counts(&*fixture), &mut rng))
                .map(|layout| planner.worst_of(&layout).unwrap_or(f64::INFINITY))
                .collect();
            random.sort_by(f64::total_cmp);
            assert!(2.0 * plan.worst() <= random[100], "{kind}: {} of {}", plan.worst(), random[100]);
        }
    }
}

/// Twice the same, on any number of threads.
#[test]
fn plans_are_deterministic() {
    let solver = support::solver("least-squares");
    let fixture = support::fixture("cube", &support::settings("cube")[0]);
    let planner = planner(&*fixture, &*solver);
    let plan = || planner.plan(&Wanted::Total(8)).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(plan(), one.install(plan));
}

#[test]
fn a_cone_is_kept() {
    let solver = support::solver("least-squares");
    for (kind, from, degrees) in
        [("three-sphere", Vector3::z(), 50.0), ("cylinder-plane", Vector3::new(-1.0, 0.0, 1.0), 80.0)]
    {
        let fixture = support::fixture(kind, &support::settings(kind)[0]);
        let mut planner = planner(&*fixture, &*solver);
        let from = Unit::new_normalize(from);
        planner.reach = planner.reach.with_cone(Cone { along: -from, half_angle: f64::to_radians(degrees) });
        let plan = planner.plan(&Wanted::PerSurface(nominal_counts(&*fixture))).unwrap();
        for (surface, at) in &plan.layout {
            let normal = fixture.surfaces()[*surface].seen_from(at).normal;
            assert!(normal.angle(&from).to_degrees() <= degrees + 1e-6, "{kind} {at}");
        }
    }
    // From above a cube shows one face.
    let cube = support::fixture("cube", &support::settings("cube")[0]);
    let mut planner = planner(&*cube, &*solver);
    planner.reach = planner.reach.with_cone(Cone { along: -Vector3::z_axis(), half_angle: 1.0 });
    let counts = nominal_counts(&*cube);
    let unreachable = PlanError::Unreachable { surface: "+x".to_owned() };
    assert_eq!(planner.plan(&Wanted::PerSurface(counts)).unwrap_err(), unreachable);
    assert!(matches!(planner.plan(&Wanted::Total(9)), Err(PlanError::Unreachable { .. })));
}

/// What is planned can be measured: the solver finds the frame wherever it is, and the redundancy numbers are those of the
/// linear model.
#[test]
fn constraints_are_kept() {
    let solver = support::solver("least-squares");
    let mut rng = generator(12, 0);
    // The only touch of a cube along Z has nothing to be checked by.
    for (kind, counts, possible) in [
        ("cylinder-plane", vec![4, 3], true),
        ("cylinder-plane", vec![5, 4], true),
        ("cube", vec![3, 0, 3, 0, 1, 0], false),
    ] {
        let fixture = support::fixture(kind, &support::settings(kind)[0]);
        let planner = Planner { least_redundancy: 0.1, ..planner(&*fixture, &*solver) };
        let plan = planner.plan(&Wanted::PerSurface(counts.clone())).unwrap();
        let checked = plan.redundancy.iter().all(|r| *r >= 0.1 - REDUNDANCY_ROUNDING);
        assert_eq!((checked, plan.redundancy_possible), (possible, possible), "{kind} {:?}", plan.redundancy);
        let truth = random_frame(100.0, &mut rng);
        let touches = simulate(&*fixture, &plan.layout, &truth, &planner.probe, SIGMA, &mut rng);
        let solution = solver.solve(&Problem::new(&*fixture, &touches, planner.probe).unwrap()).unwrap();
        assert!(solution.squared_distance(&truth).unwrap() < 40.0, "{kind}");
    }
    // Six touches check nothing.
    let cube = support::fixture("cube", &support::settings("cube")[0]);
    let planner = Planner { least_redundancy: 0.1, ..planner(&*cube, &*solver) };
    let plan = planner.plan(&Wanted::PerSurface(vec![3, 0, 2, 0, 1, 0])).unwrap();
    assert!(!plan.redundancy_possible && plan.redundancy.iter().all(|r| r.abs() < 1e-9));
}

#[test]
fn a_target_is_met_with_the_fewest_touches() {
    let solver = support::solver("least-squares");
    let fixture = support::fixture("composite", &support::settings("composite")[0]);
    let planner = planner(&*fixture, &*solver);
    let seven = planner.plan(&Wanted::Total(7)).unwrap().worst();
    let eight = planner.plan(&Wanted::Total(8)).unwrap().worst();
    assert!(eight < seven);
    let plan = planner.plan(&Wanted::Target(0.5 * (seven + eight))).unwrap();
    assert_eq!((plan.layout.len(), plan.worst()), (8, eight));
}

#[test]
fn what_cannot_be_planned_is_told() {
    let solver = support::solver("least-squares");
    let fixture = support::cylinder_plane(20.0, 45.0);
    let planner = planner(&*fixture, &*solver);
    for wanted in [Wanted::PerSurface(vec![4, 2]), Wanted::Total(6), Wanted::Total(0)] {
        assert!(matches!(planner.plan(&wanted), Err(PlanError::TooFewTouches { .. })), "{wanted:?}");
    }
    let rough = Planner { probe: Probe { sigma: Some(5.0), ..planner.probe }, ..planner };
    assert!(matches!(rough.plan(&Wanted::PerSurface(vec![4, 3])), Err(PlanError::NoSoundLayout { .. })));
}

/// Ambiguous measurements, and what becomes of them with the touch that separates their frames.
#[test]
fn the_next_touch_separates_frames_that_survive() {
    const NOISE: f64 = 0.05;
    let solver = support::solver("least-squares");
    let fixture = support::cylinder_plane(20.0, 45.0);
    let probe = Probe { tip_radius: 1.5, tip_radius_u: 0.0, sigma: Some(NOISE) };
    let planner = Planner { probe, ..planner(&*fixture, &*solver) };
    let (mut seen, mut separated, mut right) = (0, 0, 0);
    for trial in 0..150 {
        let mut rng = generator(31, trial);
        let layout = random_layout(&*fixture, &[4, 3], &mut rng);
        let truth = random_frame(100.0, &mut rng);
        let mut touches = simulate(&*fixture, &layout, &truth, &probe, NOISE, &mut rng);
        let problem = Problem::new(&*fixture, &touches, probe).unwrap();
        let Err(error @ SolveError::Ambiguous(_)) = solver.solve(&problem) else { continue };
        let frames = planner.surviving(&problem, &error);
        if frames.len() < 2 {
            continue;
        }
        seen += 1;
        let next = planner.next_apart(&touches, &frames).unwrap();
        let Effect::Separates { sigmas } = next.effect else { panic!("{next:?}") };
        // Where the first of the frames has it; the fixture stands at the truth.
        let tip =
            truth
                .to_fixture(&frames[0].to_parent(
                    &fixture.surfaces()[next.surface].tip_center(&next.contact, probe.tip_radius),
                ));
        let met = fixture.surfaces()[next.surface].seen_from(&tip);
        let layout: Layout = vec![(next.surface, tip - met.normal * met.distance)];
        touches.extend(simulate(&*fixture, &layout, &truth, &probe, NOISE, &mut rng));
        let after = solver.solve(&Problem::new(&*fixture, &touches, probe).unwrap());
        if sigmas > 8.0 {
            separated += 1;
            assert!(!matches!(after, Err(SolveError::Ambiguous(_))), "trial {trial}, {sigmas}: {after:?}");
        }
        if let Ok(solution) = after {
            right += 1;
            // The level at which a frame counts as wrong.
            assert!(solution.squared_distance(&truth).unwrap() < 53.34, "trial {trial}");
        }
    }
    // Where frames cannot be told apart by one touch it says so: by few sigmas.
    assert!(seen >= 15 && 10 * separated >= 9 * seen && 10 * right >= 8 * seen, "{seen} {separated} {right}");
}

/// The touch that reduces the worst case most, against every place of a fine grid.
#[test]
fn the_next_touch_reduces_the_worst_case_most() {
    let solver = support::solver("least-squares");
    let fixture = support::cylinder_plane(20.0, 45.0);
    let planner = planner(&*fixture, &*solver);
    let mut rng = generator(5, 0);
    for _ in 0..3 {
        let layout = random_layout(&*fixture, &[5, 4], &mut rng);
        let frame = random_frame(100.0, &mut rng);
        let touches = simulate(&*fixture, &layout, &frame, &planner.probe, 0.0, &mut rng);
        let next = planner.next(&touches, &frame).unwrap();
        let Effect::Reduces { from, to } = next.effect else { panic!("{next:?}") };
        let with = |surface, at| planner.worst_of(&[layout.as_slice(), &[(surface, at)]].concat()).unwrap();
        assert!((planner.worst_of(&layout).unwrap() / from - 1.0).abs() < 1e-6);
        assert!((with(next.surface, next.contact) / to - 1.0).abs() < 1e-6);
        for (index, surface) in fixture.surfaces().iter().enumerate() {
            for (u, v) in
                (0..60).flat_map(|u| (0..=10).map(move |v| (f64::from(u) / 60.0, f64::from(v) / 10.0)))
            {
                assert!(with(index, surface.point_at(u, v)) * 1.01 >= to);
            }
        }
    }
}
