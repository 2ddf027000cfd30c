//! What `compare` compares: finished runs, and the cells that two of them share.

use std::collections::HashMap;
use std::path::Path;

use indicatif::HumanCount;
use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::grid::Cell;

use crate::evaluate::parts::Parts;
use crate::evaluate::sums::{Lookups, SumLayout};
use crate::failure::Failure;
use crate::job::{Audit, Criterion, Effort, EvaluateMode, Job};
use crate::output::{note, quoted};
use crate::store::directory::{Access, RunDirectory};
use crate::store::tally::Tally;

/// A finished run.
pub struct Run {
    /// As typed.
    pub name: String,
    /// Where it is.
    pub directory: RunDirectory,
    /// Its job; where a verdict map can tell its samples, one that uses it.
    pub job: Job,
    /// The parts of its cells.
    pub parts: Parts,
    /// Its verdicts.
    pub tally: Tally,
    /// Whether its own verdicts come from a verdict map, and which sums tell of the audit.
    audited: Option<SumLayout>,
}

impl Run {
    /// Opens a run, which must be finished.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let directory = RunDirectory::open(path, Access::Shared)?;
        let mut job = directory.job()?;
        let tally = directory.tally(&job)?;
        let parts = Parts::new(&job);
        let complete = directory.complete_cells(&job, &tally);
        if complete < job.cells() {
            return Err(Failure::Job(format!(
                "{} is not finished: {complete} of {} cells are complete. Finish it with `stickslip resume {}`, then compare",
                path.display(),
                job.cells(),
                quoted(path)
            )));
        }
        let audited = job.sampling.is_audited.then(|| SumLayout::of(&job));
        // A map gives the verdicts of "each", and a small part of the simulations.
        let can_have_map = !matches!(job.criterion, Criterion::Eigenvalue) && job.random.other().is_none();
        if can_have_map && !job.uses_maps() {
            job.sampling.evaluate = EvaluateMode::Boundary;
            job.sampling.audit = Audit::Samples(0);
            job.sampling.is_audited = false;
        }
        Ok(Self { name: path.display().to_string(), directory, job, parts, tally, audited })
    }

    /// Every verdict that was counted in a cell.
    pub fn counts(&self, cell: u64) -> VerdictCounts {
        self.parts.counts(&self.tally, cell)
    }

    /// Whether its verdicts come from a verdict map that was audited.
    pub fn is_audited(&self) -> bool {
        self.audited.is_some()
    }

    /// How the samples of a cell were judged, if they were counted.
    pub fn lookups(&self, cell: u64) -> Lookups {
        let mut lookups = Lookups::default();
        for part in self.parts.of(cell) {
            lookups.add(self.audited.map(|layout| layout.read_lookups(self.tally.sums(part))).unwrap_or_default());
        }
        lookups
    }

    /// Samples of a cell, for each of its randomisations.
    pub fn lengths(&self, cell: u64) -> Vec<u64> {
        match self.job.sampling.effort {
            Effort::Randomisations { count, points } => vec![points; count as usize],
            _ => vec![self.counts(cell).total()],
        }
    }
}

/// How the samples of a cell in two runs hang together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kinship {
    /// Sample `j` of the one and sample `j` of the other have the same deviates, and no others do.
    Paired,
    /// They share random numbers in another way.
    Dependent,
    /// They share none.
    Independent,
}

/// How two runs hang together in cells for which both draw from the same streams, and why not sample by sample.
///
/// What the deviates become (which inputs, with which distribution and correlation) does not matter: it is the deviates that
/// make two verdicts depend on each other.
fn kinship(first: &Job, second: &Job) -> (Kinship, Option<String>) {
    let (a, b) = (&first.sampling, &second.sampling);
    let independent = |why: String| (Kinship::Independent, Some(why));
    if a.method != b.method {
        return independent("their sampling.method differs".to_owned());
    }
    if a.seed != b.seed {
        return independent(format!("their seeds differ ({} and {})", a.seed, b.seed));
    }
    if a.common_random_numbers != b.common_random_numbers {
        return independent("only one of them has common_random_numbers".to_owned());
    }
    let dependent = |why: String| (Kinship::Dependent, Some(why));
    if let (Effort::Randomisations { count: a, .. }, Effort::Randomisations { count: b, .. }) = (&a.effort, &b.effort)
        && a != b
    {
        return dependent(format!("they have {a} and {b} randomisations"));
    }
    let inputs = [first, second].map(|job| job.random.inputs.len());
    if inputs[0] != inputs[1] {
        return dependent(format!("they have {} and {} random inputs", inputs[0], inputs[1]));
    }
    (Kinship::Paired, None)
}

/// The cells that two runs share.
pub struct Matching {
    /// Index in the first run, in the second, and how their samples hang together.
    pub cells: Vec<(u64, u64, Kinship)>,
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
        let (kinship, why) = if exact { (Kinship::Independent, None) } else { kinship(a, b) };
        let common = a.sampling.common_random_numbers;
        let mut cells = Vec::new();
        for index in 0..a.cells() {
            if let Some(other) = there.get_mut(&values(a, index)).and_then(Vec::pop) {
                let same_stream = common || index == other;
                cells.push((index, other, if same_stream { kinship } else { Kinship::Independent }));
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
        let unpaired = cells.iter().filter(|cell| cell.2 != Kinship::Paired).count();
        if let Some(why) = why {
            let and = match kinship {
                Kinship::Dependent => ", though they share random numbers (the same seed)",
                Kinship::Independent | Kinship::Paired => "",
            };
            note(format_args!("{} and {} cannot be paired: {why}{and}; intervals are wider for it", names.0, names.1));
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
