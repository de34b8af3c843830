#![allow(clippy::unwrap_used)] // A test may panic.
mod support;
use touchref::*;
use touchref::analysis::planning::*;
use nalgebra::*;
fn planner<'a>(fixture: &'a dyn Fixture, solver: &'a dyn Solver, criterion: Criterion) -> Planner<'a> {
    Planner { fixture, probe: Probe { tip_radius: 0.0, tip_radius_u: 0.0, sigma: Some(1e-3) }, solver, reach: Reach::of(fixture), points: default_points(fixture), criterion, least_redundancy: 0.1 }
}
#[test]
fn explore() {
    let solver = support::solver("least-squares");
    let fixture = support::cylinder_plane(1.0, 45.0);
    for criterion in [Criterion::Volume, Criterion::Worst] {
        for least in [0.0, 0.1] {
        for far in [false, true] {
            let mut p = planner(&*fixture, &*solver, criterion);
            p.reach = p.reach.with_extent(0, Extent::Along { from: -1.0, to: 1.0 });
            p.least_redundancy = least;
            if far { p.points = vec![Point3::new(0.0, 0.0, 500.0)]; }
            let now = std::time::Instant::now();
            match p.plan(&Wanted::PerSurface(vec![4, 3])) {
                Ok(plan) => {
            let t = now.elapsed();
            let d: Vec<(f64, f64)> = plan.layout.iter().take(4).map(|(_, a)| (a.y.atan2(a.x), a.z)).collect();
            let s = |i: usize, j: usize| (d[i].0 - d[j].0).sin();
            let z = |i: usize, j: usize| d[i].1 - d[j].1;
            let dd = s(0,1)*s(2,3)*z(0,2)*z(1,3) - s(0,2)*s(1,3)*z(0,1)*z(2,3);
            println!("{criterion:?} {least} far {far} D {dd:.9} worst {:?} naive {:?} rand {:?} {:?} poss {} {:?}", plan.worst(), plan.naive, plan.random_median, t, plan.redundancy_possible, plan.redundancy);
            println!("   {:?}", d.iter().map(|(a,z)| (a.to_degrees().round(), *z)).collect::<Vec<_>>());
            println!("   sm {:?} up {:?}", plan.trust.second_minimum.map(|m| m.chi_square), plan.trust.up_to_sigma);
                }
                Err(e) => println!("{criterion:?} {least} far {far}: {e} {:?}", now.elapsed()),
            }
        }
        }
    }
    for kind in ["cylinder-plane", "three-sphere", "cube", "composite"] {
        for parameters in support::settings(kind) {
            let fixture = support::fixture(kind, &parameters);
            let counts: Vec<usize> = { let l = fixture.nominal_layout(); (0..fixture.surfaces().len()).map(|s| l.iter().filter(|t| t.0 == s).count()).collect() };
            for far in [false, true] {
            for wanted in [Wanted::PerSurface(counts.clone()), Wanted::Total(counts.iter().sum())] {
            let mut p = planner(&*fixture, &*solver, Criterion::Worst);
            if far { p.points = vec![Point3::new(0.0, 0.0, 500.0)]; }
            let now = std::time::Instant::now();
            match p.plan(&wanted) {
                Ok(plan) => println!("{kind} far {far} {wanted:?} worst {:?} naive {:?} rand {:?} {:?} poss {} min r {:?}", plan.worst(), plan.naive, plan.random_median, now.elapsed(), plan.redundancy_possible, plan.redundancy.iter().copied().fold(1.0, f64::min)),
                Err(e) => println!("{kind} far {far} {wanted:?}: {e} {:?}", now.elapsed()),
            }
            }}
        }
    }
}
