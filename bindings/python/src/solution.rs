//! A frame that was found.

use nalgebra::Point3;
use pyo3::prelude::*;
use touchref::{
    Frame, Literal,
    io::{InputError, SolutionRecord, dialect, measurement::units_named, solution::DialectNote, write::json},
    report::{Options, Scene, Subject, page, svg},
};

use crate::{errors::Failure, registry};

/// A result.
#[pyclass(frozen, module = "touchref._touchref")]
pub(crate) struct Solution {
    pub(crate) record: SolutionRecord,
    /// The frame to the last bit; the record has its quaternion.
    pub(crate) frame: Frame,
}

impl Solution {
    fn literal(&self, name: &str) -> Result<Literal, Failure> {
        let dialect = dialect::find(registry()?, name)?;
        let units = units_named(&self.record.units)?;
        let touched: Vec<_> =
            self.record.touches.iter().filter_map(|touch| touch.at.map(Point3::from)).collect();
        Ok(Literal::new(name, &*dialect, &self.frame, units, &touched)?)
    }
}

#[pymethods]
impl Solution {
    /// A result read back.
    #[staticmethod]
    fn from_json(text: &str, name: &str) -> Result<Self, Failure> {
        let record = SolutionRecord::from_text(name, text)?;
        let frame = record
            .located_frame()
            .ok_or_else(|| InputError::new("invalid-input", "the result has no frame"))?;
        Ok(Self { record, frame })
    }

    /// The document `touchref.solution/1` as the command line prints it, with the frame in these dialects.
    fn json(&self, dialects: Vec<String>) -> Result<String, Failure> {
        let mut record = self.record.clone();
        for name in &dialects {
            record.tell(name, &self.literal(name)?);
        }
        Ok(json(&record))
    }

    /// The frame in a dialect, and what its numbers mean as JSON.
    fn dialect(&self, name: &str) -> Result<(String, String), Failure> {
        let literal = self.literal(name)?;
        let note = serde_json::to_string(&DialectNote::from(&literal)).unwrap_or_default();
        Ok((literal.text, note))
    }

    /// The page for the record.
    fn page(
        &self,
        title: Option<String>,
        notes: Vec<String>,
        points: Vec<[f64; 3]>,
    ) -> Result<String, Failure> {
        let points = points.into_iter().map(Point3::from).collect();
        Ok(page(&self.record, registry()?, &Options { title, notes, points })?)
    }

    /// Its picture as SVG; `None` for an older result, which does not tell where the touches were.
    fn picture(&self, title: &str) -> Result<Option<String>, Failure> {
        let subject = Subject::new(&self.record, registry()?)?;
        Ok(Scene::of(&subject).map(|scene| svg::picture(&scene, title).into_string()))
    }
}
