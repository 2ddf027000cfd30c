//! The configurations of a job's model, prepared for its samples.

use std::sync::{Arc, OnceLock};

use stickslip_core::model::decision::Decision;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::model::verdict::{Verdict, VerdictCounts};
use stickslip_core::model::{Columns, Configuration, IsStopped, ModelError, QueuedSample};
use stickslip_sampler::grid::Cell;

use crate::evaluate::samples::Samples;
use crate::job::Job;

/// Largest number of configurations of a grid that are kept once they are prepared; one may take some 100 kB.
const MOST_KEPT: usize = 1000;

/// What decides the samples of a job.
pub struct Criteria {
    /// One for each configuration of the grid. It is prepared when it is first wanted, and kept unless there are too many.
    /// `None` if it cannot be prepared: between the extremes of the axes, where alone this was checked, no such
    /// configuration may exist.
    kept: Vec<OnceLock<Option<Arc<dyn Configuration>>>>,
    /// The first; others share with it what does not differ.
    first: Arc<dyn Configuration>,
    /// The quantities that differ from sample to sample.
    varying: Vec<usize>,
}

/// What simulates the samples of a cell.
pub(super) struct Motions<'q> {
    prepared: &'q dyn Configuration,
    /// The configuration of the cell, where there are too many to prepare them.
    outline: Option<Arc<dyn Configuration>>,
}

impl<'q> Motions<'q> {
    /// A sample for simulation.
    pub(super) fn queued(&self, ticket: u64) -> QueuedSample<'q> {
        QueuedSample { ticket, configuration: self.prepared, outline: self.outline.clone() }
    }
}

impl Criteria {
    /// Prepares the first configuration of a job.
    ///
    /// # Errors
    /// If it cannot be prepared.
    pub fn new(job: &Job) -> Result<Self, ModelError> {
        let varying = job.varying();
        let first = Arc::from(job.model().configure(&job.grid.first_cell_with(0).expected, &varying, None)?);
        let configurations = job.grid.configurations();
        let kept = if configurations <= MOST_KEPT { configurations } else { 0 };
        Ok(Self { kept: (0..kept).map(|_| OnceLock::new()).collect(), first, varying })
    }

    /// How many configurations are kept once they are prepared: all or none.
    pub fn kept(&self) -> usize {
        self.kept.len()
    }

    /// A configuration of the grid of a job; `None` if there is no such one.
    pub fn configuration(&self, job: &Job, index: usize) -> Option<Arc<dyn Configuration>> {
        if index == 0 {
            return Some(Arc::clone(&self.first));
        }
        let prepare = || {
            let cell = job.grid.first_cell_with(index);
            let ready = job.model().configure(&cell.expected, &self.varying, Some(&*self.first));
            ready.ok().map(Arc::from)
        };
        match self.kept.get(index) {
            Some(kept) => kept.get_or_init(prepare).clone(),
            None => prepare(),
        }
    }

    /// The quantities that differ from sample to sample.
    pub fn varying(&self) -> &[usize] {
        &self.varying
    }

    /// The stability boundary of a configuration of the grid of a job, if it is known in closed form.
    pub fn boundary(&self, job: &Job, index: usize) -> Option<PairBoundary> {
        self.configuration(job, index)?.closed_form().map(stickslip_core::model::ClosedForm::boundary)
    }

    /// The stability boundary of each sample of a cell; `None` for a sample with a value that is not admissible, and
    /// where it is not known in closed form.
    pub fn boundaries(&self, job: &Job, cell: &Cell, samples: &Samples) -> Vec<Option<PairBoundary>> {
        let configuration = self.configuration(job, job.grid.configuration_index(cell.index));
        let Some(closed) = configuration.as_deref().and_then(|configuration| configuration.closed_form()) else {
            return vec![None; samples.len()];
        };
        let columns = samples.columns();
        let boundary = |sample: usize| {
            // It holds for any values of the pair.
            let values = columns.iter().enumerate().map(|(i, column)| if i < 2 { 0.0 } else { column[sample] });
            closed.boundary_of(&values.collect::<Vec<f64>>())
        };
        (0..samples.len()).map(boundary).collect()
    }

    /// The verdict counts of samples of a configuration, and how many of them are outside the model, if they are decided in
    /// closed form.
    #[inline]
    pub fn count(&self, job: &Job, index: usize, samples: &Samples) -> Option<(VerdictCounts, u64)> {
        let configuration = self.configuration(job, index)?;
        let closed = configuration.closed_form()?;
        let columns = samples.columns();
        let columns = Columns::new(samples.len(), &columns);
        Some((closed.count(&columns), configuration.count_outside(&columns)))
    }

    /// Decides some of the samples of a cell; `None` if it is stopped before.
    pub fn decide(
        &self,
        job: &Job,
        cell: &Cell,
        samples: &Samples,
        wanted: &[usize],
        is_stopped: IsStopped<'_>,
    ) -> Option<Vec<Decision>> {
        match self.configuration(job, job.grid.configuration_index(cell.index)) {
            Some(ready) => ready.decide(&Columns::new(samples.len(), &samples.columns()), wanted, is_stopped),
            None => Some(vec![Verdict::Failed.into(); wanted.len()]),
        }
    }

    /// What simulates the samples of a cell; `None` if there is no such configuration.
    pub(super) fn motions(&self, job: &Job, cell: &Cell) -> Option<Motions<'_>> {
        let index = job.grid.configuration_index(cell.index);
        if index == 0 {
            return Some(Motions { prepared: &*self.first, outline: None });
        }
        if index < self.kept.len() {
            self.configuration(job, index)?;
            return Some(Motions { prepared: self.kept[index].get()?.as_deref()?, outline: None });
        }
        // Each sample takes its configuration along.
        let outline = job.model().simulation()?.outline(&cell.expected, &self.varying).ok()?;
        Some(Motions { prepared: &*self.first, outline: Some(Arc::from(outline)) })
    }
}
