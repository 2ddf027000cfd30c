//! A finished run whose samples are evaluated again.

use indicatif::HumanCount;
use stickslip_sampler::estimate::audit::{COMPARED, PlainSamples};
use stickslip_sampler::estimate::interval::{BinomialInterval, Estimate, IntervalKind};

use super::run::Run;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::randomised;
use crate::evaluate::sums::Lookups;
use crate::failure::{Failure, Signal};
use crate::interrupt::Interrupt;
use crate::job::{Answer, Effort, MapUse};
use crate::output::note;
use crate::schedule::engine::{Engine, Outcome};
use crate::schedule::mapping::Mapping;
use crate::store::layout::MAPS;
use crate::store::map_pieces;
use crate::store::tally::Tally;
use crate::tables::finished::FinishedSurface;
use crate::tables::row::unaudited;

/// A finished run whose samples can be evaluated again.
pub struct EvaluatedRun<'a> {
    /// The run.
    pub run: &'a Run,
    /// Evaluates its samples, by its verdict maps where it has any; `None` where its model was read without its files.
    pub evaluator: Option<Evaluator<'a>>,
    /// One for each cell where probabilities are integrated, else none.
    integrated: Vec<IntegratedCell>,
    /// The plain samples beside its probabilities, or the audits of its map.
    audits: Tally,
}

impl<'a> EvaluatedRun<'a> {
    /// Completes the verdict maps of a run if it needs them: for integrals, or if samples are evaluated
    /// (`needs_verdicts`). Tiles of the maps of all `runs` are used, too.
    pub fn new(
        run: &'a Run,
        needs_verdicts: bool,
        runs: &[Run],
        engine: &Engine,
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let mut integrated = Vec::new();
        // The run keeps its audits.
        let mut audits = run.directory.audits_done(&run.job)?;
        if run.job.model.unread().is_some() {
            if run.job.answer() == Answer::Integral {
                integrated = integrals_of_surface(run)?;
            }
            return Ok(Self { run, evaluator: None, integrated, audits });
        }
        let mut evaluator = Evaluator::new(&run.job)?;
        let map_use = run.job.map_use();
        if map_use == MapUse::Integrate || (map_use == MapUse::LookUp && needs_verdicts) {
            complete_maps(run, &mut evaluator, runs, engine, interrupt)?;
        }
        if run.job.answer() == Answer::Integral {
            let audited = engine.audit(&evaluator, &mut audits, None, interrupt)?;
            let (outcome, cells) = engine.integrate(&evaluator, &audits, interrupt)?;
            for outcome in [audited, outcome] {
                if let Outcome::Stopped(signal) = outcome {
                    return Err(stopped(signal));
                }
            }
            integrated = cells;
        }
        Ok(Self { run, evaluator: Some(evaluator), integrated, audits })
    }

    /// The probability of a cell, with its bounds where it is integrated, else with the interval of a confidence. Nothing is
    /// known where plain samples contradict it.
    pub fn estimate(&self, cell: u64, confidence: f64) -> Estimate {
        match self.is_contradicted(cell) {
            true => Estimate { probability: None, low: 0.0, high: 1.0 },
            false => self.without_plain_samples(cell, confidence),
        }
    }

    /// Whether the plain samples of a cell contradict its probability, as its surface has it.
    pub fn is_contradicted(&self, cell: u64) -> bool {
        if self.run.job.plain_samples() == 0 {
            return false;
        }
        let Estimate { low, high, .. } = self.without_plain_samples(cell, COMPARED);
        PlainSamples::from(self.audits.counts(cell)).contradict([low, high])
    }

    fn without_plain_samples(&self, cell: u64, confidence: f64) -> Estimate {
        let Run { job, parts, tally, .. } = self.run;
        if let Some(integrated) = self.integrated.get(cell as usize) {
            return integrated.estimate;
        }
        if let Effort::Randomisations { .. } = job.sampling.effort {
            return randomised::estimate(job, &tally.counted_parts(parts.in_cell(cell)), confidence);
        }
        let interval = BinomialInterval::new(IntervalKind::for_confidence(confidence), confidence);
        let estimate = interval.estimate(&self.run.counts(cell));
        // A job with `until` has an unbiased estimate of its own.
        let probability =
            parts.estimate_at_stop(tally, cell).map_or(estimate.probability, |at_stop| at_stop.probability);
        Estimate { probability, ..estimate }
    }

    /// How many samples of a cell, or of its audit, were looked up, simulated and audited.
    pub fn lookups(&self, cell: u64) -> Lookups {
        self.integrated.get(cell as usize).map_or_else(|| self.run.lookups(cell), |integrated| integrated.lookups)
    }

    /// The largest error of a cell's probability that the audit of its verdict map does not exclude; 0 without an
    /// audit.
    pub fn unaudited(&self, cell: u64, confidence: f64) -> f64 {
        if !self.run.is_audited() {
            return 0.0;
        }
        let samples = self.run.job.draws_samples().then(|| self.run.counts(cell).total());
        unaudited(&self.lookups(cell), samples, confidence)
    }

    /// The share of the error probability that belongs to the look at which a cell stopped; 1 without looks.
    pub fn error_share(&self, cell: u64) -> f64 {
        self.run.parts.error_share_at_stop(&self.run.tally, cell)
    }
}

/// The integrals of a run as its surface has them.
fn integrals_of_surface(run: &Run) -> Result<Vec<IntegratedCell>, Failure> {
    let surface = FinishedSurface::open(run.directory.path())?;
    let [probability, low, high] = surface.numbers(["p_unstable", "p_low", "p_high"])?;
    let of_cell = |((probability, low), high): ((Option<f64>, Option<f64>), Option<f64>)| {
        let estimate = Estimate { probability, low: low.unwrap_or(0.0), high: high.unwrap_or(1.0) };
        IntegratedCell { estimate, ..IntegratedCell::unknown() }
    };
    Ok(probability.into_iter().zip(low).zip(high).map(of_cell).collect())
}

/// Completes the verdict maps of a run, with tiles of other runs where they fit. New tiles are kept in the run, if it
/// can be written to.
fn complete_maps(
    run: &Run,
    evaluator: &mut Evaluator<'_>,
    runs: &[Run],
    engine: &Engine,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    // The run may belong to somebody else.
    let created = run.directory.create_folder(MAPS).ok();
    let own = created.or(run.directory.maps()?);
    let keep = own.as_ref().filter(|own| own.require_writable().is_ok());
    if let Some(own) = &own {
        map_pieces::load(evaluator.maps_mut(), own)?;
    }
    let mut borrowed = false;
    for other in runs.iter().filter(|other| other.directory.path() != run.directory.path()) {
        if let Ok(Some(maps)) = other.directory.maps() {
            borrowed |= map_pieces::load(evaluator.maps_mut(), &maps)? > 0;
        }
    }
    let completed = engine.complete_maps(evaluator, Mapping { keep, borrowed, ..Mapping::default() }, interrupt)?;
    if let Outcome::Stopped(signal) = completed.outcome {
        return Err(stopped(signal));
    }
    if completed.simulations > 0 {
        note(format_args!(
            "{}: verdict map of {} tiles from {} simulations{}",
            run.name,
            HumanCount(evaluator.maps().needed() as u64),
            HumanCount(completed.simulations),
            if keep.is_some() { "; kept in the run for the next time" } else { "" }
        ));
    }
    Ok(())
}

/// What is kept of a comparison that a signal ended.
pub const STOPPED: &str = "nothing was compared; finished tiles of verdict maps are kept. Run the same command again";

/// A comparison that a signal ended.
pub fn stopped(signal: Signal) -> Failure {
    Failure::stopped(signal, &STOPPED.into())
}
