//! The problems that all methods solve, and the files by which other programs read them.

use std::{fs, io, path::Path};

use touchref::{
    Fixture, Frame, Probe, Problem, RootKind, Touch,
    analysis::simulation::{generator, random_frame, random_layout, simulate},
};

use super::{ANGLE_DEG, RADIUS, SEED, SIGMA};

/// Touches are surface points.
pub(crate) const PROBE: Probe = Probe { tip_radius: 0.0, tip_radius_u: 0.0, sigma: Some(SIGMA) };

/// Problems with touches of the same numbers.
#[derive(Debug)]
pub(crate) struct Set {
    /// Of its column, and of its file.
    pub(crate) name: &'static str,
    /// Touches on the cylinder and on the plane.
    pub(crate) counts: [usize; 2],
    pub(crate) measurements: Vec<Measurement>,
}

/// One problem.
#[derive(Debug)]
pub(crate) struct Measurement {
    pub(crate) touches: Vec<Touch>,
    /// Where refinements start: what the closed form gives.
    pub(crate) start: Frame,
}

impl Set {
    /// So many seeded problems: touches anywhere on the surfaces, or where the fixture would have them.
    ///
    /// A measurement of which the closed form makes no frame is drawn again.
    pub(crate) fn draw(
        fixture: &dyn Fixture,
        name: &'static str,
        counts: [usize; 2],
        nominal: bool,
        problems: usize,
    ) -> Self {
        let drawn = (0..).filter_map(|trial| {
            let mut rng = generator(SEED, trial);
            let layout =
                if nominal { fixture.nominal_layout() } else { random_layout(fixture, &counts, &mut rng) };
            let frame = random_frame(1000.0, &mut rng);
            let touches = simulate(fixture, &layout, &frame, &PROBE, SIGMA, &mut rng);
            let start = start(&Problem::new(fixture, &touches, PROBE).unwrap())?;
            Some(Measurement { touches, start })
        });
        Self { name, counts, measurements: drawn.take(problems).collect() }
    }

    pub(crate) fn touches(&self) -> usize {
        self.counts.iter().sum()
    }

    /// Six numbers (problems, touches on cylinder and plane, radius, angle in radians, sigma), then the start of every
    /// problem ([`numbers`]), then the touches of every problem.
    pub(crate) fn write(&self, folder: &Path) -> io::Result<()> {
        let sizes = [self.measurements.len(), self.counts[0], self.counts[1]].map(|size| size as f64);
        let fixture = [RADIUS, ANGLE_DEG.to_radians(), SIGMA];
        let starts = self.measurements.iter().flat_map(|measurement| numbers(&measurement.start));
        let touches = self.measurements.iter().flat_map(|measurement| &measurement.touches);
        let all = sizes.into_iter().chain(fixture).chain(starts);
        let all = all.chain(touches.flat_map(|touch| [touch.at.x, touch.at.y, touch.at.z]));
        let bytes: Vec<u8> = all.flat_map(f64::to_le_bytes).collect();
        fs::write(file(folder, self.name), bytes)
    }
}

/// The file of a set, or of the frames that a method of another program has found.
pub(crate) fn file(folder: &Path, name: &str) -> std::path::PathBuf {
    folder.join(format!("{name}.f64"))
}

/// A frame as twelve numbers: its rotation row by row, its origin.
fn numbers(frame: &Frame) -> [f64; 12] {
    let (r, o) = (frame.rotation.matrix(), frame.origin);
    std::array::from_fn(|i| if i < 9 { r[(i / 3, i % 3)] } else { o[i - 9] })
}

/// The frame of these [`numbers`]; none of any that is no number.
pub(crate) fn frame(numbers: &[f64]) -> Option<Frame> {
    let axis = |k: usize| nalgebra::Vector3::new(numbers[k], numbers[3 + k], numbers[6 + k]);
    Frame::from_z_and_x([numbers[9], numbers[10], numbers[11]].into(), axis(2), axis(0))
}

/// What the closed form gives: of its frames the one that fits the known geometry best.
pub(crate) fn start(problem: &Problem<'_>) -> Option<Frame> {
    let mut best: Option<(f64, Frame)> = None;
    let mut choose = |root: touchref::Root| {
        let misfit: f64 = (0..problem.touches().len())
            .map(|index| problem.contact(&root.frame, index).residual.powi(2))
            .sum();
        if best.is_none_or(|(least, _)| misfit < least) {
            best = Some((misfit, root.frame));
        }
    };
    problem.fixture().closed_form()?.roots(problem, &mut choose).ok()?;
    best.map(|(_, frame)| frame)
}

/// Every frame that satisfies the equations; the sum of something of each, so that none is left out.
pub(crate) fn every_root(problem: &Problem<'_>) -> f64 {
    let mut sum = 0.0;
    let closed_form = problem.fixture().closed_form().unwrap();
    closed_form
        .roots(problem, &mut |root| {
            if root.kind == RootKind::Real {
                sum += root.frame.origin.x + root.measures[0];
            }
        })
        .unwrap();
    sum
}
