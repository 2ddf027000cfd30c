//! What `compare` compares: finished runs, and the cells that two of them share.

use std::collections::HashMap;
use std::path::Path;

use indicatif::HumanCount;
use stickslip_core::VerdictCounts;
use stickslip_sampler::Cell;

use crate::failure::Failure;
use crate::job::{Criterion, Effort, EvaluateMode, Job};
use crate::output::{note, quoted};
use crate::run::{Access, RunDirectory, Slots, Tally};

/// A finished run.
pub struct Run {
    /// As typed.
    pub name: String,
    /// Where it is.
    pub directory: RunDirectory,
    /// Its job; where a verdict map can tell its samples, one that uses it.
    pub job: Job,
    /// The parts of its cells.
    pub slots: Slots,
    /// Its verdicts.
    pub tally: Tally,
}

impl Run {
    /// Opens a run, which must be finished.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let directory = RunDirectory::open(path, Access::Shared)?;
        let mut job = directory.job()?;
        let tally = directory.tally(&job)?;
        let slots = Slots::new(&job);
        let complete = directory.complete_cells(&job, &tally);
        if complete < job.cells() {
            return Err(Failure::Job(format!(
                "{} is not finished: {complete} of {} cells are complete. Finish it with `stickslip resume {}`, then compare",
                path.display(),
                job.cells(),
                quoted(path)
            )));
        }
        // A map gives the verdicts of "each", and a small part of the simulations.
        let can_have_map = !matches!(job.criterion, Criterion::Eigenvalue) && job.random.other().is_none();
        if can_have_map && !job.uses_maps() {
            job.sampling.evaluate = EvaluateMode::Boundary;
            job.sampling.audit = 0.0;
        }
        Ok(Self { name: path.display().to_string(), directory, job, slots, tally })
    }

    /// Every verdict that was counted in a cell.
    pub fn counts(&self, cell: u64) -> VerdictCounts {
        self.slots.counts(&self.tally, cell)
    }

    /// Samples of a cell, for each of its randomisations.
    pub fn lengths(&self, cell: u64) -> Vec<u64> {
        match self.job.sampling.effort {
            Effort::Randomisations { count, points } => vec![points; count as usize],
            _ => vec![self.counts(cell).total()],
        }
    }
}

/// Why two runs do not draw the same samples, if they do not.
fn why_unpaired(first: &Job, second: &Job) -> Option<String> {
    let (a, b) = (&first.sampling, &second.sampling);
    let names = |job: &Job| job.random.inputs.iter().map(|input| input.name()).collect::<Vec<_>>();
    if a.method != b.method {
        return Some("their sampling.method differs".to_owned());
    }
    if a.seed != b.seed {
        return Some(format!("their seeds differ ({} and {})", a.seed, b.seed));
    }
    if a.common_random_numbers != b.common_random_numbers {
        return Some("only one of them has common_random_numbers".to_owned());
    }
    if let (Effort::Randomisations { count: a, .. }, Effort::Randomisations { count: b, .. }) = (&a.effort, &b.effort)
        && a != b
    {
        return Some(format!("they have {a} and {b} randomisations"));
    }
    if names(first) != names(second) {
        return Some("their random.inputs differ".to_owned());
    }
    if first.random.marginals != second.random.marginals || first.random.pairs != second.random.pairs {
        return Some("distribution or correlation of their inputs differs".to_owned());
    }
    None
}

/// The cells that two runs share.
pub struct Matching {
    /// Index in the first run, in the second, and whether both draw the same samples there.
    pub cells: Vec<(u64, u64, bool)>,
}

impl Matching {
    /// Of two runs; at least one cell. Says which cells are left out, and what cannot be paired.
    pub fn new(first: &Run, second: &Run) -> Result<Self, Failure> {
        let (a, b) = (&first.job, &second.job);
        let names = |job: &Job| job.random.inputs.iter().map(|input| input.name()).collect::<Vec<_>>();
        let same_inputs = names(a) == names(b);
        let stds = |job: &Job, cell: u64| job.random.relative_stds[job.grid.relative_std_index(cell)].clone();
        let values = |job: &Job, index: u64| -> Vec<u64> {
            let Cell { rotating_speed, relative_std, preload, static_friction, .. } = job.grid.cell(index);
            let mut values =
                vec![rotating_speed, relative_std.preload, relative_std.static_friction, preload, static_friction];
            // What scatters beside preload and static friction belongs to the cell as well, where both runs have it.
            values.extend(same_inputs.then(|| stds(job, index)).into_iter().flatten());
            values.into_iter().map(f64::to_bits).collect()
        };
        let mut there: HashMap<Vec<u64>, Vec<u64>> = HashMap::new();
        (0..b.cells()).rev().for_each(|index| there.entry(values(b, index)).or_default().push(index));
        let exact = a.is_integrated() || b.is_integrated();
        let why = if exact { None } else { why_unpaired(a, b) };
        let common = a.sampling.common_random_numbers;
        let mut cells = Vec::new();
        for index in 0..a.cells() {
            if let Some(other) = there.get_mut(&values(a, index)).and_then(Vec::pop) {
                let same_stds = stds(a, index) == stds(b, other);
                let is_paired = !exact && why.is_none() && same_stds && (common || index == other);
                cells.push((index, other, is_paired));
            }
        }
        let names = (&first.name, &second.name);
        if cells.is_empty() {
            return Err(Failure::Job(format!(
                "{} and {} have no cell in common: no rotating speed, relative std, expected preload and static friction of the one is in the other. Compare runs whose [axes] and random.relative_std share values",
                names.0, names.1
            )));
        }
        let left_out = (a.cells() - cells.len() as u64, b.cells() - cells.len() as u64);
        if left_out != (0, 0) {
            note(format_args!(
                "{} cells are in both runs; left out are {} of {} in {} and {} of {} in {}",
                HumanCount(cells.len() as u64),
                HumanCount(left_out.0),
                HumanCount(a.cells()),
                names.0,
                HumanCount(left_out.1),
                HumanCount(b.cells()),
                names.1
            ));
        }
        let unpaired = cells.iter().filter(|cell| !cell.2).count();
        if let Some(why) = why {
            note(format_args!("{} and {} cannot be paired: {why}; intervals are wider for it", names.0, names.1));
        } else if unpaired > 0 && !exact {
            note(format_args!(
                "{} of {} cells cannot be paired: they have other places in the two grids and draw other samples there (sampling.common_random_numbers = true gives every cell the same); their intervals are wider for it",
                HumanCount(unpaired as u64),
                HumanCount(cells.len() as u64)
            ));
        }
        Ok(Self { cells })
    }
}
