//! `surface.parquet`: one row for each cell, sorted by cell.

use std::cell::OnceCell;
use std::fmt;
use std::io::{self, BufWriter, Write};

use parquet::errors::ParquetError;
use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::draw::identity::RESULTS_VERSION;
use stickslip_sampler::estimate::audit::{COMPARED, PlainSamples};
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::weighted::WeightedEstimate;

use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::parts::Parts;
use crate::evaluate::randomised;
use crate::evaluate::sums::{Lookups, SumLayout};
use crate::evaluate::unit::{Recorded, add_recorded};
use crate::failure::Failure;
use crate::files::table::TableWriter;
use crate::job::{Answer, Effort, Job};
use crate::store::digests::digest_of_file;
use crate::store::directory::{JOB_HASH_KEY, JOB_KEY, RunDirectory};
use crate::store::layout::SURFACE;
use crate::store::tally::Tally;
use crate::tables::columns::{self, Column};
use crate::tables::row::{CONTRADICTED, SurfaceRow, distrust, unaudited, widened};
use crate::version::VERSION;

/// Number of rows that are held in memory at once, and in a row group.
const BATCH_ROWS: u64 = 65_536;

/// The result of a job.
#[derive(Debug)]
pub struct Surface<'a> {
    job: &'a Job,
    tally: &'a Tally,
    /// The integral of each cell, if probabilities are integrated; empty otherwise.
    integrated: &'a [IntegratedCell],
    /// The plain samples beside probabilities, by cell, where there are some.
    audits: Option<&'a Tally>,
    parts: Parts,
    layout: SumLayout,
    /// With looks, the estimate of each cell, kept because rows are made more than once.
    at_stop: OnceCell<Vec<Estimate>>,
}

impl<'a> Surface<'a> {
    /// The surface of a run in its present state.
    pub fn new(job: &'a Job, tally: &'a Tally) -> Self {
        Self {
            job,
            tally,
            integrated: &[],
            audits: None,
            parts: Parts::new(job),
            layout: SumLayout::for_job(job),
            at_stop: OnceCell::new(),
        }
    }

    /// The surface of a job that integrates, with an integral for each cell.
    pub fn integrated(job: &'a Job, tally: &'a Tally, integrated: &'a [IntegratedCell]) -> Self {
        Self { integrated, ..Self::new(job, tally) }
    }

    /// The same with the plain samples beside its probabilities.
    pub fn audited(self, audits: Option<&'a Tally>) -> Self {
        Self { audits: audits.filter(|_| self.job.plain_samples() > 0), ..self }
    }

    /// Its job.
    pub fn job(&self) -> &Job {
        self.job
    }

    /// The row of one cell.
    pub fn row(&self, cell: u64) -> SurfaceRow {
        let counts = self.parts.counts(self.tally, cell);
        let mut recorded = Recorded::default();
        let mut sums = Vec::new();
        for part in self.parts.in_cell(cell) {
            self.tally.recorded(part).into_iter().for_each(|of_part| add_recorded(&mut recorded, of_part));
            add_sums(&mut sums, &self.tally.sums(part));
        }
        let integrated = self.integrated.get(cell as usize).copied();
        let lookups = integrated.map_or_else(|| self.layout.read_lookups(&sums), |integrated| integrated.lookups);
        // Where every sample was simulated or audited, none was looked up alone.
        let is_audited = self.job.sampling.is_audited && lookups.simulated + lookups.audited < counts.total();
        let confidence = self.job.confidence(is_audited);
        let (counted, weighted) = self.found(cell, &counts, confidence);
        let plain = self.audits.map(|audits| PlainSamples::from(audits.counts(cell)));
        let is_contradicted = plain.is_some_and(|plain| {
            let (Estimate { low, high, .. }, _) = self.found(cell, &counts, COMPARED);
            plain.contradict([low, high])
        });
        // Of conditional probabilities those may be open that count as undecided.
        let may_be_open = integrated.is_some() || (self.job.answer() == Answer::Probability && counts.undecided > 0);
        let is_open = may_be_open && counted.probability.is_none();
        let distrust = distrust(weighted.as_ref(), is_open, is_contradicted);
        let counted = if distrust == CONTRADICTED { Estimate { probability: None, ..counted } } else { counted };
        let unaudited =
            self.job.sampling.is_audited.then(|| {
                unaudited(&lookups, integrated.is_none().then_some(counts.total()), self.job.audit_confidence())
            });
        SurfaceRow {
            cell: self.job.grid.cell(cell),
            counts,
            estimate: widened(&counted, unaudited.unwrap_or(0.0)),
            unaudited,
            recorded,
            outside_physics: self.layout.read_outside_physics(&sums).unwrap_or(0),
            lookups,
            sums,
            weighted,
            integrated,
            plain,
            distrust,
        }
    }

    /// The probability of a cell with its bounds, or else with its interval of a confidence; and what there is to say of its
    /// samples where these have weights.
    fn found(&self, cell: u64, counts: &VerdictCounts, confidence: f64) -> (Estimate, Option<WeightedEstimate>) {
        if let Some(integrated) = self.integrated.get(cell as usize) {
            return (integrated.estimate, None);
        }
        let parts = || self.tally.counted_parts(self.parts.in_cell(cell));
        let is_weighted = self.job.answer().is_of_rare_events();
        match is_weighted.then(|| randomised::of_weights(self.job, &parts(), confidence)).flatten() {
            Some(weighted) => (weighted.estimate, Some(weighted)),
            None => (self.estimate(cell, counts, confidence), None),
        }
    }

    /// The probability of a cell, with the interval of a confidence from its counts.
    fn estimate(&self, cell: u64, counts: &VerdictCounts, confidence: f64) -> Estimate {
        match self.job.sampling.effort {
            Effort::Samples(_) => self.job.interval(confidence).estimate(counts),
            Effort::Randomisations { .. } => {
                randomised::estimate(self.job, &self.tally.counted_parts(self.parts.in_cell(cell)), confidence)
            }
            Effort::Until(_) => {
                let nothing = Estimate { probability: None, low: 0.0, high: 1.0 };
                let of_cell = |cell| self.parts.estimate_at_stop(self.tally, cell).unwrap_or(nothing);
                self.at_stop.get_or_init(|| (0..self.job.cells()).map(of_cell).collect())[cell as usize]
            }
        }
    }

    /// The largest probability that a sample is undecided, where probabilities are integrated.
    pub fn largest_undecided(&self) -> f64 {
        self.integrated.iter().map(|cell| cell.undecided).fold(0.0, f64::max)
    }

    /// How many samples of all cells were simulated and audited, in jobs with verdict maps.
    pub fn lookups(&self) -> Lookups {
        let mut lookups = Lookups::default();
        for part in 0..self.parts.count() {
            lookups.add(self.layout.read_lookups(&self.tally.sums(part)));
        }
        self.integrated.iter().for_each(|cell| lookups.add(cell.lookups));
        lookups
    }

    /// All rows, in order.
    pub fn rows(&self) -> impl Iterator<Item = SurfaceRow> + '_ {
        (0..self.job.cells()).map(|cell| self.row(cell))
    }

    /// Whether the run directory has this surface, byte for byte.
    pub fn is_published(&self, directory: &RunDirectory) -> Result<bool, Failure> {
        // A hash compares the bytes without holding them in memory.
        let present = directory.open_surface().ok().flatten().and_then(|file| digest_of_file(file).ok());
        let Some(present) = present else { return Ok(false) };
        let mut hasher = blake3::Hasher::new();
        self.encode(&mut hasher).map_err(|error| Failure::writing(&directory.surface(), error))?;
        Ok(hasher.finalize().to_hex().as_str() == present)
    }

    /// Writes `surface.parquet` into a run directory, whole or not at all. Returns false if the file has the same bytes
    /// already.
    pub fn publish(&self, directory: &RunDirectory) -> Result<bool, Failure> {
        if self.is_published(directory)? {
            // Its digest may have been removed.
            let digest = directory.open_surface()?.map(digest_of_file).transpose();
            let digest = digest.map_err(|error| Failure::reading(&directory.surface(), error))?;
            digest.map(|digest| directory.expect(SURFACE, &digest)).transpose()?;
            return Ok(false);
        }
        let failed = |error: &dyn fmt::Display| Failure::writing(&directory.surface(), error);
        let mut file = directory.root().begin().map_err(|error| failed(&error))?;
        let mut written = Hashed { out: BufWriter::new(&mut file), hasher: blake3::Hasher::new() };
        self.encode(&mut written).map_err(|error| failed(&error))?;
        written.flush().map_err(|error| failed(&error))?;
        let digest = written.hasher.finalize().to_hex();
        drop(written);
        directory.publish_file(SURFACE, file, &digest)?;
        Ok(true)
    }

    fn encode(&self, out: &mut (dyn Write + Send)) -> Result<(), ParquetError> {
        let columns = columns::for_job(self.job, self.layout);
        let mut writer = TableWriter::new(out, columns.iter().map(Column::field).collect(), &footer(self.job))?;
        let (mut first, cells) = (0, self.job.cells());
        while first < cells {
            let end = cells.min(first + BATCH_ROWS);
            let rows: Vec<SurfaceRow> = (first..end).map(|cell| self.row(cell)).collect();
            writer.write(columns.iter().map(|column| column.read(&rows)).collect())?;
            first = end;
        }
        writer.finish()
    }
}

/// What the footers of files with samples of a job say of it. Nothing in it differs between two runs of one job.
pub fn footer(job: &Job) -> Vec<(&'static str, String)> {
    vec![
        (JOB_KEY, job.normalised()),
        (JOB_HASH_KEY, job.hash()),
        ("stickslip:seed", job.sampling.seed.to_string()),
        ("stickslip:engine_version", VERSION.to_owned()),
        ("stickslip:results_version", RESULTS_VERSION.to_string()),
    ]
}

fn add_sums(total: &mut Vec<i128>, sums: &[i128]) {
    total.resize(total.len().max(sums.len()), 0);
    total.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
}

/// Writes on, and hashes what is written.
struct Hashed<W> {
    out: W,
    hasher: blake3::Hasher,
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
