//! The modes of a job whose model is given by matrices.

use stickslip_core::models::matrices::model::{BAND, MatrixModel};
use stickslip_core::models::matrices::modes::ModesError;
use stickslip_core::models::matrices::problem::Problem;
use stickslip_core::models::matrices::region::Region;
use stickslip_core::models::matrices::terms::Parameter;

use crate::failure::Failure;
use crate::job::Job;

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
}

/// The failure of modes that are not found.
pub fn failed(job: &Job, error: &ModesError) -> Failure {
    Failure::Job(format!("the modes of the job \"{}\": {error}", job.name))
}
