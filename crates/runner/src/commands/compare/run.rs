//! A finished run that is compared with others.

use std::path::Path;

use stickslip_core::model::verdict::VerdictCounts;

use crate::evaluate::parts::Parts;
use crate::evaluate::sums::{Lookups, SumLayout};
use crate::failure::Failure;
use crate::job::{Effort, Job};
use crate::messages::Code;
use crate::output::quoted;
use crate::store::directory::RunDirectory;
use crate::store::lock::{AN_INSTANT, Access};
use crate::store::tally::Tally;

/// A finished run.
pub struct Run {
    /// The path of its directory, as typed.
    pub name: String,
    /// Its directory.
    pub directory: RunDirectory,
    /// Its job.
    pub job: Job,
    /// The parts of its cells.
    pub parts: Parts,
    /// Its verdicts.
    pub tally: Tally,
    /// Where its sums count the audit of its own verdict map; `None` if its verdicts were not looked up and audited.
    audited: Option<SumLayout>,
}

impl Run {
    /// Opens a finished run.
    ///
    /// # Errors
    /// Among others, a run that is not finished.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let directory = RunDirectory::open(path, Access::Reading, AN_INSTANT)?;
        let job = directory.job_to_read()?;
        let tally = directory.tally(&job)?;
        let parts = Parts::new(&job);
        let complete = directory.complete_cells(&job, &tally);
        if complete < job.cells() {
            let resume = format!("stickslip resume {}", quoted(path));
            return Err(Failure::Job(format!(
                "{} is not finished: {complete} of {} cells are complete. Finish it with `{resume}`, then compare",
                path.display(),
                job.cells(),
            ))
            .coded(Code::Incomplete)
            .remedied(resume));
        }
        let audited = job.sampling.is_audited.then(|| SumLayout::for_job(&job));
        Ok(Self { name: path.display().to_string(), directory, job, parts, tally, audited })
    }

    /// The verdicts that the run counted in a cell.
    pub fn counts(&self, cell: u64) -> VerdictCounts {
        self.parts.counts(&self.tally, cell)
    }

    /// Whether its verdicts were looked up in a verdict map and audited.
    pub fn is_audited(&self) -> bool {
        self.audited.is_some()
    }

    /// How many samples of a cell were looked up, simulated and audited.
    pub fn lookups(&self, cell: u64) -> Lookups {
        let mut lookups = Lookups::default();
        for part in self.parts.in_cell(cell) {
            lookups.add(self.audited.map(|layout| layout.read_lookups(&self.tally.sums(part))).unwrap_or_default());
        }
        lookups
    }

    /// The number of samples in each randomisation of a cell; one number without randomisations.
    pub fn lengths(&self, cell: u64) -> Vec<u64> {
        match self.job.sampling.effort {
            Effort::Randomisations { count, points } => vec![points; count as usize],
            _ => vec![self.counts(cell).total()],
        }
    }
}
