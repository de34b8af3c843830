//! What a report is about: a result, its fixture rebuilt and its numbers held against each other.

use nalgebra::{DVector, Matrix6, Point3, Vector3, Vector6};
use touchref_analysis::{
    Linear, Observation, Reliability, Test, Uncertainty, linear::lever, uncertainty::Spread,
};
use touchref_core::{
    Covariance, Fixture, Frame, Probe, Problem, Registry, Shape, SigmaSource, Surface, Touch, Unknown,
    statistics::{chi_square_level, f_level, student_factor},
};
use touchref_io::{InputError, SolutionRecord, Units};

/// Chance with which the intervals and ellipsoids of a report cover the true value.
pub(crate) const PROBABILITY: f64 = 0.95;

/// No probe was ever so far from its parent, in any unit: numbers beyond are a mistake, and squares of them no numbers.
const FARTHEST: f64 = 1e12;

/// The most touches of which each is weighed by itself: what they know of each other grows with the square.
const MOST_WEIGHED: usize = 2000;

/// A result, with its fixture rebuilt.
#[derive(Debug)]
pub struct Subject<'a> {
    pub(crate) record: &'a SolutionRecord,
    pub(crate) fixture: Box<dyn Fixture>,
    pub(crate) units: Units,
    pub(crate) frame: Frame,
    pub(crate) probe: Probe,
    pub(crate) covariance: Option<Covariance>,
    /// Every touch in input order; `None` for an older result, which does not tell where they were.
    pub(crate) contacts: Option<Vec<Contact>>,
    /// The touches that count.
    used: Option<Vec<Touch>>,
}

/// A touch on the fixture where that was found, in the parent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact {
    /// Index of the surface.
    pub(crate) surface: usize,
    /// The centre of the tip.
    pub(crate) at: Point3<f64>,
    /// The point of the surface that is nearest.
    pub(crate) foot: Point3<f64>,
    /// Outward normal of the surface there.
    pub(crate) normal: Vector3<f64>,
}

/// What one observation does to the frame, and how far the others check it.
#[derive(Debug)]
pub(crate) struct Influence {
    pub(crate) of: Observed,
    /// Part of its error that the others see.
    pub(crate) redundancy: f64,
    /// Residual over its own standard deviation; `None` where nothing checks it, or no sigma is stated.
    pub(crate) test_value: Option<f64>,
    /// Smallest error that is noticed; `None` where none is, or no sigma is stated.
    pub(crate) smallest_detectable: Option<f64>,
    /// How such an error, unnoticed, moves the frame.
    pub(crate) unnoticed: Option<Vector6<f64>>,
    /// How the frame moves when it is left out; `None` where nothing else tells what it tells.
    pub(crate) left_out: Option<Vector6<f64>>,
}

/// What tells of the frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Observed {
    /// A touch, by its place in the result.
    Touch(usize),
    /// What is stated of a size of the fixture or of the tip.
    Stated(String),
}

impl<'a> Subject<'a> {
    /// Rebuilds the fixture of a result, and checks that its numbers belong together.
    ///
    /// # Errors
    /// `unknown-fixture`, or `invalid-input` for a result that contradicts itself.
    pub fn new(record: &'a SolutionRecord, registry: &Registry) -> Result<Self, InputError> {
        let units = Units::from_name(&record.units).ok_or_else(|| {
            let known = Units::ALL.iter().map(|units| units.name());
            InputError::unknown("unknown-name", "unit", &record.units, known).with_key("units")
        })?;
        let fixture = record.fixture.build(registry)?;
        let frame =
            record.located_frame().filter(Frame::is_sound).ok_or_else(|| wrong("frame", "is none"))?;
        let probe: Probe = record.probe.into();
        let used = record.used_touches(&*fixture)?;
        if let Some(used) = &used {
            Problem::new(&*fixture, used, probe)?;
        }
        let covariance = record.covariance.as_ref().map(Covariance::from);
        let mut subject = Self { record, fixture, units, frame, probe, covariance, contacts: None, used };
        subject.check()?;
        subject.contacts = subject.placed()?;
        Ok(subject)
    }

    /// That no number is absurd.
    fn check(&self) -> Result<(), InputError> {
        let near = |point: &[f64]| point.iter().all(|v| v.abs() < FARTHEST);
        let ends = |surface: &Surface| [0.0, 0.5, 1.0].map(|v| surface.point_at(v, v));
        let mut ends = self.fixture.surfaces().iter().flat_map(ends);
        if !ends.all(|end| near(end.coords.as_slice())) {
            return Err(wrong("fixture", "reaches farther than any probe"));
        }
        let Self { record, frame, covariance, .. } = self;
        if !near(&record.frame.origin) {
            return Err(wrong("frame.origin", "is farther away than any probe reaches"));
        }
        let turned = Matrix6::from_fn(|row, column| {
            if row < 3 && column < 3 {
                record.frame.matrix[row][column] - frame.matrix()[(row, column)]
            } else {
                0.0
            }
        });
        // What is no number is no agreement.
        if !turned.iter().all(|off| off.abs() < 1e-9) {
            return Err(wrong(
                "frame",
                "contradicts itself: its matrix is not the rotation of its quaternion",
            ));
        }
        for (index, touch) in record.touches.iter().enumerate() {
            let key = format!("touches[{index}]");
            if touch.index != index {
                return Err(wrong(&key, "is out of order"));
            }
            if !touch.at.as_ref().is_none_or(|at| near(at)) {
                return Err(wrong(&key, "is farther away than any probe reaches"));
            }
        }
        match covariance {
            Some(covariance) if !is_covariance(&covariance.matrix) => {
                Err(wrong("covariance", "is none: it is not symmetric, or a variance is negative"))
            }
            _ => Ok(()),
        }
    }

    /// The touches where they meet the fixture.
    fn placed(&self) -> Result<Option<Vec<Contact>>, InputError> {
        /// By which part of the fixture's size and of the way to the touch a residual may differ from that of the result: far
        /// beyond rounding, far below what any use would notice.
        const AGREEMENT: f64 = 1e-7;
        let (sizes, tip_radius) = self.as_estimated();
        let mut contacts = Vec::with_capacity(self.record.touches.len());
        for (index, touch) in self.record.touches.iter().enumerate() {
            let surface = self.fixture.surface_index(&touch.surface)?;
            let Some(at) = touch.at.map(Point3::from) else { return Ok(None) };
            let seen = self.fixture.shape_with(surface, &sizes).seen_from(&self.frame.to_fixture(&at));
            let reach = self.fixture.size() + (at - self.frame.origin).norm();
            let residual = seen.distance - tip_radius;
            // What is no number is no agreement.
            let agrees = |told: f64| (residual - told).abs() <= AGREEMENT * reach;
            if !touch.residual.is_none_or(agrees) {
                let told = format!(
                    "contradicts itself: the touch is {residual} {} off its surface, and the result says {}",
                    self.units,
                    touch.residual.unwrap_or_default()
                );
                return Err(wrong(&format!("touches[{index}].residual"), &told));
            }
            let normal = self.frame.rotation * seen.normal;
            contacts.push(Contact { surface, at, foot: at - normal * seen.distance, normal });
        }
        Ok(Some(contacts))
    }

    /// Sizes of the fixture and tip radius, with what the touches made of them.
    fn as_estimated(&self) -> (Vec<f64>, f64) {
        let estimate = |unknown: Unknown| {
            let stated = unknown.stated(&*self.fixture, &self.probe);
            let adjusted = self.record.adjustments.iter().find(|adjusted| adjusted.name == stated.name);
            adjusted.and_then(|adjusted| adjusted.value).map_or(stated.nominal, |value| value / stated.scale)
        };
        let sizes = 0..self.fixture.dimensions().len();
        (sizes.map(|index| estimate(Unknown::Dimension(index))).collect(), estimate(Unknown::TipRadius))
    }

    /// The shape of a surface as drawn.
    pub(crate) fn shape(&self, surface: usize) -> Shape {
        self.fixture.shape_with(surface, &self.as_estimated().0)
    }

    /// Where the touches were, in the parent.
    pub(crate) fn touched(&self) -> Vec<Point3<f64>> {
        self.contacts.iter().flatten().map(|contact| contact.at).collect()
    }

    /// Uncertainty of the place of a point that moves with the fixture, in fixture coordinates.
    pub(crate) fn spread_of_point(&self, point: &Point3<f64>) -> Option<Spread> {
        let lever = lever(&self.frame, point);
        Some(Spread(lever * self.covariance.as_ref()?.matrix * lever.transpose()))
    }

    /// Uncertainty of the rotation, as a rotation vector.
    pub(crate) fn spread_of_turn(&self) -> Option<Spread> {
        Some(Spread(self.covariance.as_ref()?.matrix.fixed_view::<3, 3>(3, 3).into_owned()))
    }

    /// Degrees of freedom of the uncertainties; `None` where they are as sure as the stated sigma.
    pub(crate) fn degrees_of_freedom(&self) -> Option<usize> {
        let covariance = self.covariance.as_ref()?;
        (covariance.sigma_source == SigmaSource::Residuals).then(|| self.record.degrees_of_freedom.max(1))
    }

    /// By which a standard uncertainty is multiplied for an interval that covers with [`PROBABILITY`].
    pub(crate) fn coverage_factor(&self) -> f64 {
        student_factor(PROBABILITY, self.degrees_of_freedom().map_or(f64::INFINITY, |degrees| degrees as f64))
    }

    /// The same for a region of three coordinates.
    pub(crate) fn coverage_factor_of_region(&self) -> f64 {
        let level = 1.0 - PROBABILITY;
        match self.degrees_of_freedom() {
            None => chi_square_level(level, 3).sqrt(),
            Some(degrees) => (3.0 * f_level(level, 3, degrees)).sqrt(),
        }
    }

    /// Where the uncertainty comes from, or why that is not told.
    pub(crate) fn sources(&self) -> Result<Uncertainty, String> {
        /// By which part variances may differ from those of the result: the model is of first order, at nominal sizes.
        const AGREEMENT: f64 = 0.1;
        let stated = self.covariance.as_ref().ok_or("the result has no covariance")?.matrix;
        let uncertainty =
            Uncertainty::of(&self.problem()?, &self.frame).map_err(|error| error.to_string())?;
        let off = uncertainty.covariance() - stated;
        let agrees = |row: usize, column: usize| {
            off[(row, column)].abs()
                <= AGREEMENT * (stated[(row, row)] * stated[(column, column)]).sqrt() + f64::MIN_POSITIVE
        };
        if (0..36).all(|entry| agrees(entry / 6, entry % 6)) {
            Ok(uncertainty)
        } else {
            Err(self.weighs_otherwise())
        }
    }

    /// What each observation does to the frame, or why that is not told.
    pub(crate) fn influences(&self) -> Result<Vec<Influence>, String> {
        let problem = self.problem()?;
        if problem.reference_sigma().is_none() {
            return self.influences_without_sigma(&problem);
        }
        self.sources()?;
        let reliability =
            Reliability::of(&problem, &self.frame, Test::default()).map_err(|error| error.to_string())?;
        let influence = |checked: &touchref_analysis::reliability::Checked| {
            let check = checked.check.as_ref();
            Influence {
                of: self.observed(checked.observation),
                redundancy: checked.redundancy,
                test_value: check.map(|check| check.test_value),
                smallest_detectable: check
                    .map(|check| check.smallest_detectable * self.scale(checked.observation)),
                unnoticed: checked.undetected_shift(),
                left_out: checked.shift_without(),
            }
        };
        Ok(reliability.observations.iter().map(influence).collect())
    }

    /// Without a stated sigma no error is large or small; how far touches check each other is known all the same.
    fn influences_without_sigma(&self, problem: &Problem<'_>) -> Result<Vec<Influence>, String> {
        /// Redundancy below which a touch is checked by nothing but rounding.
        const UNCHECKED: f64 = 1e-9;
        /// By which part of the residuals they may differ from those of least squares, and of the fixture's size.
        const AGREEMENT: [f64; 2] = [1e-3, 1e-9];
        let linear = Linear::at(problem, &self.frame).ok_or("the touches leave a motion free")?;
        let residual = |index: usize, _| problem.contact(&self.frame, index).residual;
        let told = DVector::from_fn(problem.touches().len(), residual);
        let off = (linear.residuals() - &told).norm();
        if off > AGREEMENT[0] * told.norm() + AGREEMENT[1] * self.fixture.size() {
            return Err(self.weighs_otherwise());
        }
        let influence = |(index, observation): (usize, &Observation)| {
            let redundancy = linear.redundancy()[(index, index)].clamp(0.0, 1.0);
            let apparent_error = (redundancy > UNCHECKED).then(|| linear.residuals()[index] / redundancy);
            Influence {
                of: self.observed(*observation),
                redundancy,
                test_value: None,
                smallest_detectable: None,
                unnoticed: None,
                left_out: apparent_error.map(|error| linear.sensitivity(index) * -error),
            }
        };
        Ok(linear.observations().iter().enumerate().map(influence).collect())
    }

    fn weighs_otherwise(&self) -> String {
        format!(
            "the solver `{}` weighs its touches in its own way, not as least squares does",
            self.record.solver
        )
    }

    /// The touches that count, as a measurement.
    pub(crate) fn problem(&self) -> Result<Problem<'_>, String> {
        let used = self.used.as_ref().ok_or("the result does not tell where the touches were")?;
        if used.len() > MOST_WEIGHED {
            return Err(format!("there are more than {MOST_WEIGHED} touches"));
        }
        Problem::new(&*self.fixture, used, self.probe).map_err(|error| error.to_string())
    }

    /// The place of an observation in the result.
    fn observed(&self, observation: Observation) -> Observed {
        match observation {
            Observation::Touch(index) => {
                let mut used = self.record.touches.iter().filter(|touch| !touch.excluded);
                Observed::Touch(used.nth(index).map_or(index, |touch| touch.index))
            }
            Observation::Stated(unknown) => {
                Observed::Stated(unknown.stated(&*self.fixture, &self.probe).name.into_owned())
            }
        }
    }

    /// By what the error of an observation is multiplied to be told: radians become degrees.
    fn scale(&self, observation: Observation) -> f64 {
        match observation {
            Observation::Touch(_) => 1.0,
            Observation::Stated(unknown) => unknown.stated(&*self.fixture, &self.probe).scale,
        }
    }

    /// How far a motion of the frame moves a point of the fixture.
    pub(crate) fn moved(&self, point: &Point3<f64>, motion: &Vector6<f64>) -> f64 {
        (lever(&self.frame, point) * motion).norm()
    }
}

/// Whether a matrix may be a covariance, as far as its numbers two by two tell.
fn is_covariance(matrix: &Matrix6<f64>) -> bool {
    /// Rounding of a correlation.
    const ROUNDING: f64 = 1e-6;
    (0..36).all(|entry| {
        let (row, column) = (entry / 6, entry % 6);
        let largest = (matrix[(row, row)] * matrix[(column, column)]).sqrt();
        let (here, across) = (matrix[(row, column)], matrix[(column, row)]);
        // What is no number fails.
        here.abs() <= (1.0 + ROUNDING) * largest
            && (here - across).abs() <= ROUNDING * largest
            && largest < FARTHEST * FARTHEST
            && matrix[(row, row)] >= 0.0
    })
}

fn wrong(key: &str, problem: &str) -> InputError {
    InputError::new("invalid-input", format!("the result cannot be reported: its {key} {problem}"))
        .with_key(key)
        .with_help("give a result as `touchref locate --format json` printed it, unedited")
}
