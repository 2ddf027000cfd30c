//! The search for limits in all combinations of the other axes.

use std::borrow::Cow;
use std::sync::atomic::{AtomicU64, Ordering};

use stickslip_core::model::ModelError;
use stickslip_sampler::estimate::interval::simultaneous_confidence;
use stickslip_sampler::integrate::verdict_map::MapRegions;

use super::report::{Found, Row};
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::limits::{LimitSearch, expected_estimates, scanned};
use crate::evaluate::limits_found::{CombinationLimits, Ended};
use crate::evaluate::remembering::Keeper;
use crate::failure::{Advice, Failure};
use crate::files::folder::Folder;
use crate::interrupt::Interrupt;
use crate::job::{Job, LimitAxis, LimitMethod};
use crate::schedule::engine::{Engine, Outcome};
use crate::schedule::in_order::Steps;
use crate::schedule::mapping::Mapping;
use crate::schedule::progress::Total;
use crate::store::map_pieces;
use crate::store::searches::digest_of_searches;
use stickslip_core::model::IsStopped;

/// What is sought.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    pub job: &'a Job,
    pub axis: &'a LimitAxis,
    pub method: LimitMethod,
    /// The probabilities that must not be exceeded.
    pub targets: &'a [f64],
}

/// Where tiles of verdict maps are taken from, and kept.
#[derive(Clone, Copy, Default)]
pub struct Tiles<'a> {
    pub known: Option<&'a Folder>,
    pub keep: Option<&'a Folder>,
}

impl<'a> Wanted<'a> {
    /// The limits that nothing was found of yet.
    pub fn nothing_found(self) -> Found<'a> {
        let Self { job, axis, method, targets } = self;
        let scanned = scanned(axis, method).map(|values| values.len());
        let confidence = self.confidence();
        Found { job, axis, targets, method, scanned, confidence, rows: Vec::new() }
    }

    /// What its searches are of: everything that their answers depend on.
    pub fn searches_of(self) -> String {
        digest_of_searches("limits, no value twice", &self.job.experiment_hash(), &self.nothing_found().footer())
    }

    /// Finds them. `stopped` is what is said after a signal; `keeper` keeps the answers of the searches.
    pub fn find(
        self,
        engine: &Engine,
        tiles: Tiles<'_>,
        interrupt: &Interrupt,
        stopped: &Advice,
        keeper: Option<&dyn Keeper>,
    ) -> Result<Found<'a>, Failure> {
        let Self { job, axis, method, targets } = self;
        let combinations = axis.combinations(job);
        let regions = match method {
            LimitMethod::MapIntegral => self.regions(engine, tiles, interrupt, stopped)?,
            _ => Vec::new(),
        };
        let (estimated, finished) = (AtomicU64::new(0), AtomicU64::new(0));
        let confidence = self.confidence().unwrap_or(f64::NAN);
        let search = LimitSearch { job, axis, method, confidence, regions: &regions, keeper, estimated: &estimated };
        let count = combinations.len() as u64;
        let steps = match scanned(axis, method) {
            Some(values) => {
                let expected = expected_estimates(job, axis, method, targets.len()) as u64;
                let total = count * expected.max(values.len() as u64);
                Steps { done: &estimated, total, total_is: Total::Expected, unit: "values of the axis" }
            }
            None => Steps { done: &finished, total: count, total_is: Total::Known, unit: "combinations" },
        };
        let work = |index: u64, is_stopped: IsStopped<'_>| {
            let cell = combinations[index as usize];
            match search.limits(cell, targets, is_stopped) {
                Ok(limits) => {
                    finished.fetch_add(1, Ordering::Relaxed);
                    Ok(Some(self.rows(cell, &limits)))
                }
                Err(Ended::Stopped) => Ok(None),
                Err(Ended::Failed(failure)) => Err(failure),
                Err(Ended::NoSuchConfiguration(value, error)) => Err(self.no_brake(cell, value, &error)),
            }
        };
        let rows = engine.in_order(count, &steps, interrupt, stopped, work)?;
        Ok(Found { rows: rows.concat(), ..self.nothing_found() })
    }

    /// Confidence of the intervals, of which a job that integrates has none.
    fn confidence(self) -> Option<f64> {
        let Self { job, axis, method, targets } = self;
        let sampling = &job.sampling;
        let intervals = (axis.combinations(job).len() * targets.len()) as u64;
        let is_integral = matches!(method, LimitMethod::Integral | LimitMethod::MapIntegral);
        (!is_integral).then(|| match sampling.simultaneous {
            true => simultaneous_confidence(sampling.confidence, intervals),
            false => sampling.confidence,
        })
    }

    fn rows(self, cell: u64, found: &CombinationLimits) -> Vec<Row> {
        let of_target = |(&target, limits): (&f64, &Vec<_>)| {
            let row = |&(limit, beside)| Row { cell, target, limit, beside, ends: found.ends };
            limits.iter().map(row).collect::<Vec<Row>>()
        };
        self.targets.iter().zip(&found.of_targets).flat_map(of_target).collect()
    }

    fn no_brake(self, cell: u64, value: f64, error: &ModelError) -> Failure {
        let name = &self.axis.name;
        Failure::Job(format!(
            "there is no configuration with {name} = {value} in the combination of cell {cell}: {error}; choose values of axes.{name} between which there is one everywhere"
        ))
    }

    /// The regions of the verdict maps that the whole range of the axis needs.
    fn regions(
        self,
        engine: &Engine,
        tiles: Tiles<'_>,
        interrupt: &Interrupt,
        stopped: &Advice,
    ) -> Result<Vec<MapRegions>, Failure> {
        let values = scanned(self.axis, self.method).map_or_else(|| Cow::Borrowed(&self.axis.values), Cow::Owned);
        let job = self.axis.job_with(self.job, values.into_owned());
        let mut evaluator = Evaluator::new(&job)?;
        tiles.known.map(|known| map_pieces::load(evaluator.maps_mut(), known)).transpose()?;
        let mapping = Mapping { keep: tiles.keep, ..Mapping::default() };
        match engine.complete_maps(&mut evaluator, mapping, interrupt)?.outcome {
            Outcome::Stopped(signal) => Err(Failure::stopped(signal, stopped)),
            Outcome::Finished => Ok(evaluator.regions()),
        }
    }
}
