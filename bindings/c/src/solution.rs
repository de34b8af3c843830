//! Frames that were found, and told.

use std::ffi::CString;

use nalgebra::Point3;
use touchref::{
    Frame, Solver, Units,
    io::{FrameRecord, InputError, Measurement, dialect, parameter, solution::DialectNote, write::json},
    locate::{Setup, locating_solver},
};

use crate::{
    c_string,
    error::Error,
    interface::{self, Covariance, Options, Pose, Root},
};

/// A frame with all that was weighed on the way.
#[derive(Debug)]
pub struct Solution {
    pub(crate) solved: touchref::Solution,
    units: Units,
    /// Where the touches are, in the parent.
    touched: Vec<Point3<f64>>,
    reasons: Vec<CString>,
    pub(crate) warning_codes: Vec<CString>,
    pub(crate) warning_messages: Vec<CString>,
    /// `touchref.solution/1`.
    pub(crate) json: CString,
}

/// A frame in the words of a machine.
#[derive(Debug)]
pub struct Literal {
    pub(crate) text: CString,
    pub(crate) note: CString,
}

/// What the command line's `locate` does.
///
/// # Errors
/// Its errors.
pub(crate) fn locate(measurement: Measurement, options: Option<&Options<'_>>) -> Result<Solution, Error> {
    let registry = touchref::registry()?;
    let name = options.map_or(Ok(None), |options| options.solver.optional("options.solver"))?;
    let parameters = options
        .map_or(Ok(None), |options| options.solver_parameters.optional("options.solver_parameters"))?;
    let parameters = parameter::read("solver_parameters", parameters.unwrap_or_default())?;
    let solver = locating_solver(&registry, name, &parameters)?;
    let near = options.and_then(|options| options.near_frame).map(near_frame).transpose()?;
    Solution::new(&Setup::new(measurement, &registry)?, &*solver, near)
}

fn near_frame(pose: &Pose) -> Result<Frame, InputError> {
    Frame::from_quaternion_xyzw(Point3::from(pose.origin), pose.quaternion_xyzw).ok_or_else(|| {
        let message =
            "the frame near which the answer is expected has no rotation, or a number is not finite";
        InputError::new("invalid-input", message).with_key("options.near_frame")
    })
}

impl Solution {
    fn new(setup: &Setup, solver: &dyn Solver, near: Option<Frame>) -> Result<Self, Error> {
        let solved = setup.solve(solver, near)?;
        let record = setup.record(&solved)?;
        Ok(Self {
            units: setup.measurement.units,
            touched: setup.touches()?.touches.iter().map(|touch| touch.at).collect(),
            reasons: solved.roots.iter().map(|root| c_string(&root.reason)).collect(),
            warning_codes: record.warnings.iter().map(|warning| c_string(&warning.code)).collect(),
            warning_messages: record.warnings.iter().map(|warning| c_string(&warning.message)).collect(),
            json: c_string(&json(&record)),
            solved,
        })
    }

    pub(crate) fn frame(&self) -> interface::Frame {
        (&self.solved.frame).into()
    }

    pub(crate) fn covariance(&self) -> Option<Covariance> {
        let covariance = self.solved.covariance.as_ref()?;
        Some(Covariance { matrix: covariance.matrix.transpose().into(), sigma: covariance.sigma })
    }

    pub(crate) fn root(&self, index: usize) -> Option<Root> {
        let (root, reason) = (self.solved.roots.get(index)?, self.reasons.get(index)?);
        Some(Root {
            frame: (&root.frame).into(),
            misfit: root.misfit.unwrap_or(f64::NAN),
            selected: root.selected.into(),
            reason: reason.as_ptr(),
        })
    }

    /// The frame in the words of a machine.
    ///
    /// # Errors
    /// `unknown-dialect` and the like, and what the dialect cannot tell.
    pub(crate) fn tell(&self, name: &str) -> Result<Literal, Error> {
        let dialect = dialect::find(&touchref::registry()?, name)?;
        let literal = touchref::Literal::new(name, &*dialect, &self.solved.frame, self.units, &self.touched)?;
        Ok(Literal { text: c_string(&literal.text), note: c_string(&json(&DialectNote::from(&literal))) })
    }
}

impl From<&Frame> for interface::Frame {
    fn from(frame: &Frame) -> Self {
        let FrameRecord { origin, quaternion_xyzw, matrix, .. } = frame.into();
        Self { origin, quaternion_xyzw, matrix }
    }
}
