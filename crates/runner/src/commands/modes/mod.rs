//! The modes of a job whose model is given by matrices.

use stickslip_core::models::matrices::model::{BAND, MatrixModel};
use stickslip_core::models::matrices::modes::ModesError;
use stickslip_core::models::matrices::problem::Problem;
use stickslip_core::models::matrices::region::Region;
use stickslip_core::models::matrices::terms::Parameter;

use super::one_brake::not_a_number;
use crate::failure::Failure;
use crate::job::Job;
use crate::job::keys::nearest;

pub mod lines;

pub mod squeal;

/// What modes of a job are found by.
pub struct JobModes<'a> {
    pub model: &'a MatrixModel,
    /// Where the band that counts stands among the quantities, if there are several.
    band: Option<usize>,
}

impl<'a> JobModes<'a> {
    /// Of a job.
    ///
    /// # Errors
    /// For any other kind of model.
    pub fn new(job: &'a Job) -> Result<Self, Failure> {
        let model = job.model.as_matrices().ok_or_else(|| {
            Failure::Usage(format!(
                "the job \"{}\" has a model that is not given by matrices (kind = \"matrices\"), so it has no modes to show",
                job.name
            ))
        })?;
        Ok(Self { model, band: job.model().place(BAND) })
    }

    /// Whether modes are found by sparse matrices: those in the bands alone, at a cost.
    pub fn is_sparse(&self) -> bool {
        matches!(self.model.problem(), Problem::Sparse(_))
    }

    /// Its parameters.
    pub fn own(&self) -> &'a [Parameter] {
        &self.model.matrices().parameters
    }

    /// The bands that count with these values of all quantities, rad/s.
    pub fn regions(&self, values: &[f64]) -> Vec<Region> {
        self.model.criterion().regions(self.band.map_or(0, |band| values[band] as usize))
    }

    /// The values of the parameters among those of all quantities.
    pub fn parameters<'v>(&self, values: &'v [f64]) -> &'v [f64] {
        &values[..self.own().len()]
    }

    /// Values of all quantities with `NAME=VALUE` changes.
    ///
    /// # Errors
    /// A name that no parameter has, and a value that is no number or out of range.
    pub fn changed(&self, job: &Job, values: &[f64], changes: &[String]) -> Result<Vec<f64>, Failure> {
        let mut values = values.to_vec();
        let mut changed: Vec<usize> = Vec::new();
        for change in changes {
            let refused = |message: String| Failure::Usage(format!("--set {change}: {message}"));
            let (name, value) = change
                .split_once('=')
                .ok_or_else(|| refused("write NAME=VALUE, for example friction=0.45".to_owned()))?;
            let (name, value) = (name.trim(), value.trim());
            let place = job.model().place(name).ok_or_else(|| {
                let names = job.model().quantities().iter().map(|quantity| &*quantity.name);
                let near = nearest(name, names.clone()).map_or(String::new(), |near| format!("; did you mean {near}?"));
                refused(format!(
                    "there is no parameter {name}{near} (there are {})",
                    names.collect::<Vec<_>>().join(", ")
                ))
            })?;
            if changed.contains(&place) {
                return Err(refused(format!("{name} is set a second time; leave one of the two out")));
            }
            changed.push(place);
            let number: f64 = value.parse().map_err(|_| refused(not_a_number(value)))?;
            let limits = job.quantity(place).limits;
            let is_band = |number: f64| Some(place) != self.band || number.fract() == 0.0;
            if !(number.is_finite() && limits.contain(number) && is_band(number)) {
                let whole = if is_band(number) { "" } else { "a whole number, " };
                return Err(refused(format!("{number} is out of range: it must be {whole}{limits}")));
            }
            values[place] = number;
        }
        Ok(values)
    }
}

/// The failure of modes that are not found.
pub fn failed(job: &Job, error: &ModesError) -> Failure {
    Failure::Job(format!("the modes of the job \"{}\": {error}", job.name))
}
