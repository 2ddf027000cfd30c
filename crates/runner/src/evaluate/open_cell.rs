//! A cell in which some of what it consists of may have any value, for integrals in closed form.

use stickslip_core::model::ModelError;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::model::quantity::Role;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::integrate::NormalPair;
use stickslip_sampler::integrate::closed_form::ExactProbability;

use crate::evaluate::integral::{correlation_of_pair, exact_probability};
use crate::job::Job;

/// What may have another value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Open {
    /// The expected value of a quantity.
    Expected(usize),
    /// The relative standard deviation of a quantity of the pair: the first or the second; or of the one random input.
    RelativeStd(usize),
    /// The correlation of the pair.
    Correlation,
    /// Nothing that has a value.
    Nothing,
}

/// A cell of a job whose boundary of stability is known in closed form, and what is open of it.
pub struct OpenCell<'a> {
    job: &'a Job,
    cell: Cell,
    open: Vec<Open>,
    /// The boundary, unless it depends on something open.
    boundary: Option<PairBoundary>,
}

/// The law of the pair with values in place of what is open.
pub struct Precise {
    /// The boundary of stability.
    pub boundary: PairBoundary,
    /// Expected values and standard deviations.
    pub pair: NormalPair,
    /// The correlation; `None` where the pair is normal and independent.
    pub correlation: Option<f64>,
}

impl<'a> OpenCell<'a> {
    /// A cell, of which this is open; `values` are some that it may have.
    ///
    /// # Errors
    /// If there is no such configuration.
    pub fn new(job: &'a Job, cell: u64, open: Vec<Open>, values: &[f64]) -> Result<Self, ModelError> {
        let mut own = Self { job, cell: job.grid.cell(cell), open, boundary: None };
        let is_of_configuration = |open: &Open| match open {
            Open::Expected(place) => job.quantity(*place).role == Role::Configuration,
            _ => false,
        };
        if !own.open.iter().any(is_of_configuration) {
            own.boundary = Some(own.at(values)?.boundary);
        }
        Ok(own)
    }

    /// The law of the pair with these values of what is open.
    ///
    /// # Errors
    /// If there is no such configuration.
    pub fn at(&self, values: &[f64]) -> Result<Precise, ModelError> {
        let cell = self.with(values);
        let (mut pair, mut correlation) = (self.job.normal_pair(&cell), correlation_of_pair(self.job));
        for (open, &value) in self.open.iter().zip(values) {
            match *open {
                Open::RelativeStd(which) => pair.relative_std[which] = value,
                Open::Correlation => correlation = Some(value),
                Open::Expected(_) | Open::Nothing => {}
            }
        }
        let boundary = self.boundary.map_or_else(|| self.job.boundary_with(&cell.expected), Ok)?;
        Ok(Precise { boundary, pair, correlation })
    }

    /// Whether more of the second quantity is never stable where less is unstable, whatever is open.
    ///
    /// # Errors
    /// If there is no configuration with these values.
    pub fn is_unstable_above(&self, values: &[f64]) -> Result<bool, ModelError> {
        if let Some(boundary) = self.boundary {
            return Ok(boundary.is_unstable_above());
        }
        let configuration = self.job.configuration_with(&self.with(values).expected)?;
        Ok(configuration.closed_form().is_some_and(stickslip_core::model::ClosedForm::is_always_unstable_above))
    }

    /// The cell with these values of what is open.
    fn with(&self, values: &[f64]) -> Cell {
        let mut cell = self.cell.clone();
        for (open, &value) in self.open.iter().zip(values) {
            if let Open::Expected(place) = *open {
                cell.expected[place] = value;
            }
        }
        cell
    }

    /// The exact probability with these values of what is open.
    ///
    /// # Errors
    /// If there is no such configuration.
    pub fn probability(&self, values: &[f64]) -> Result<ExactProbability, ModelError> {
        let Precise { boundary, pair, correlation } = self.at(values)?;
        Ok(exact_probability(self.job, &boundary, &pair, correlation))
    }
}
