//! What a search for limits finds in one combination of the other axes, with plain samples beside it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use stickslip_core::model::{IsStopped, ModelError};
use stickslip_sampler::estimate::audit::{COMPARED, PlainSamples};
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::limits::Limit;
use stickslip_sampler::limits::scan::Scan;

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::remembering::Asked;
use crate::failure::Failure;
use crate::job::{Job, LimitAxis};

/// What ends a search.
#[derive(Debug)]
pub enum Ended {
    /// It was stopped.
    Stopped,
    /// There is no configuration with this value of the axis.
    NoSuchConfiguration(f64, ModelError),
    /// The samples cannot be evaluated.
    Failed(Failure),
}

/// The limits of one combination.
#[derive(Debug, Clone)]
pub struct CombinationLimits {
    /// The smallest and the largest value of the axis.
    pub ends: [Beside; 2],
    /// The limits at each target; with what is beside a limit, if it has a value.
    pub of_targets: Vec<Vec<(Limit, Option<Beside>)>>,
}

/// A probability with its interval of the confidence of a search, and that which plain samples are compared with.
#[derive(Debug, Clone, Copy)]
pub struct Intervals {
    /// With the interval of the confidence of the search.
    pub estimate: Estimate,
    /// With that for plain samples.
    pub compared: Estimate,
}

impl Intervals {
    /// Of a probability that has an interval of any confidence.
    pub fn new(confidence: f64, interval: impl Fn(f64) -> Estimate) -> Self {
        Self { estimate: interval(confidence), compared: interval(COMPARED) }
    }
}

impl From<Estimate> for Intervals {
    /// Of a probability with bounds, which hold with any confidence.
    fn from(bounded: Estimate) -> Self {
        Self { estimate: bounded, compared: bounded }
    }
}

/// The same estimates, each of which is made once: several targets ask at the same values, and both ends of the axis
/// are asked for again beside the limits. They are counted.
pub fn each_once(
    counted: &AtomicU64,
    estimate: impl Fn(f64) -> Result<Intervals, Ended>,
) -> impl Fn(f64) -> Result<Intervals, Ended> {
    let known: RefCell<BTreeMap<u64, Intervals>> = RefCell::default();
    move |value: f64| {
        let seen = known.borrow().get(&value.to_bits()).copied();
        if let Some(found) = seen {
            return Ok(found);
        }
        let found = estimate(value)?;
        counted.fetch_add(1, Ordering::Relaxed);
        known.borrow_mut().insert(value.to_bits(), found);
        Ok(found)
    }
}

/// The probability at a value of the axis, and the plain samples there.
#[derive(Debug, Clone, Copy)]
pub struct Beside {
    /// The value.
    value: f64,
    /// The probability, between bounds that hold on both sides of the value.
    pub estimate: Estimate,
    /// The ends of the interval that the samples are compared with.
    compared: [f64; 2],
    /// Samples with that value, if there are any.
    pub plain: Option<PlainSamples>,
}

/// To which part of a value to each side of a limit its probability is looked at: it may jump there.
const SIDE: f64 = 1e-8;

impl Beside {
    /// Without plain samples yet.
    fn new(value: f64, found: Intervals) -> Self {
        let Intervals { estimate, compared: Estimate { low, high, .. } } = found;
        Self { value, estimate, compared: [low, high], plain: None }
    }

    /// Without plain samples. `probability` is not checked.
    pub fn unchecked(value: f64, probability: Option<f64>) -> Self {
        Self::new(value, Estimate { probability, low: 0.0, high: 1.0 }.into())
    }

    /// Whether the plain samples contradict the probability.
    pub fn is_contradicted(&self) -> bool {
        self.plain.is_some_and(|plain| plain.contradict(self.compared))
    }
}

impl CombinationLimits {
    /// From a scan and the limits at each target. `estimate` is that of the scan, which knows what it found.
    ///
    /// # Errors
    /// See [`Ended`].
    pub fn new(
        scan: &Scan,
        of_targets: Vec<Vec<Limit>>,
        estimate: impl Fn(f64) -> Result<Intervals, Ended>,
    ) -> Result<Self, Ended> {
        let ends = match scan.ends() {
            Some([(from, _), (to, _)]) => [Beside::new(from, estimate(from)?), Beside::new(to, estimate(to)?)],
            None => [Beside::unchecked(f64::NAN, None); 2],
        };
        let [from, to] = ends.map(|end| end.value);
        let both = |below: Estimate, above: Estimate| Estimate {
            probability: below.probability.or(above.probability),
            low: below.low.min(above.low),
            high: below.high.max(above.high),
        };
        let beside = |limit: Limit| -> Result<(Limit, Option<Beside>), Ended> {
            let Some(value) = limit.value else { return Ok((limit, None)) };
            let step = SIDE * (to - from);
            let below = estimate((value - step).max(from))?;
            let above = estimate((value + step).min(to))?;
            let estimate = both(below.estimate, above.estimate);
            let compared = both(below.compared, above.compared);
            Ok((limit, Some(Beside::new(value, Intervals { estimate, compared }))))
        };
        let with_estimates = |limits: Vec<Limit>| limits.into_iter().map(beside).collect::<Result<Vec<_>, _>>();
        Ok(Self { ends, of_targets: of_targets.into_iter().map(with_estimates).collect::<Result<_, _>>()? })
    }

    /// Draws plain samples of a combination at its limits and at both ends of the axis, where the job has such.
    ///
    /// # Errors
    /// See [`Ended`].
    pub fn audit(
        &mut self,
        (job, axis, cell): (&Job, &LimitAxis, u64),
        asked: &Asked<'_>,
        is_stopped: IsStopped<'_>,
    ) -> Result<(), Ended> {
        let samples = job.samples_beside_limits();
        if samples == 0 {
            return Ok(());
        }
        let limits = self.of_targets.iter_mut().flatten().filter_map(|(_, beside)| beside.as_mut());
        for beside in self.ends.iter_mut().chain(limits) {
            let read = |numbers: &[f64]| {
                let &[decided, unstable] = numbers else { return None };
                let is_count = |number: f64| number.fract() == 0.0 && (0.0..=samples as f64).contains(&number);
                let are_counts = is_count(decided) && is_count(unstable) && unstable <= decided;
                are_counts.then_some(PlainSamples { decided: decided as u64, unstable: unstable as u64 })
            };
            let write = |plain: &PlainSamples| vec![plain.decided as f64, plain.unstable as f64];
            let find = || {
                let job = axis.job_at(job, beside.value);
                let evaluator = Evaluator::new(&job).map_err(Ended::Failed)?;
                let counted = evaluator.audit_integral(cell, 0..samples, is_stopped).ok_or(Ended::Stopped)?.counts;
                Ok(counted.into())
            };
            beside.plain = Some(asked.ask(2, read, write, find)?);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::evaluate::remembering::tests::InMemory;
    use crate::job::JobSource;

    #[test]
    fn no_value_is_estimated_twice() {
        let (asked, counted) = (RefCell::new(Vec::new()), AtomicU64::new(0));
        let estimate = each_once(&counted, |value: f64| {
            asked.borrow_mut().push(value);
            Ok(Intervals::from(Estimate { probability: Some(value), low: value, high: value }))
        });
        let usual = |value: f64| estimate(value).map(|found| found.estimate);
        let scan = Scan::new(&[0.0, 0.25, 0.5, 0.75, 1.0], 1e-9, usual).unwrap();
        let of_targets = [0.3, 0.6, 0.3].map(|target| scan.limits(target, usual).unwrap());
        let found = CombinationLimits::new(&scan, of_targets.into(), &estimate).unwrap();
        assert_eq!(found.ends.map(|end| (end.value, end.estimate.probability)), [(0.0, Some(0.0)), (1.0, Some(1.0))]);
        for (target, limits) in [0.3, 0.6, 0.3].into_iter().zip(&found.of_targets) {
            let [(_, Some(beside))] = limits[..] else { panic!("{limits:?}") };
            assert!((beside.value - target).abs() < 1e-8, "{target}: {beside:?}");
        }
        let mut values = asked.take();
        let all = values.len();
        assert_eq!(counted.load(Ordering::Relaxed), all as u64);
        values.sort_by(f64::total_cmp);
        values.dedup();
        assert_eq!(values.len(), all, "a value was estimated twice");
    }

    /// A third of the pads is unstable in the middle, none at the first preload and nearly all at the last.
    const JOB: &str = "name = \"j\"\n[axes]\nrotating_speed = 15\npreload = [0.005, 0.3]\nstatic_friction = 0.39\n\
        [random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.1\n[criterion]\nkind = \"eigenvalue\"\n\
        [sampling]\nmethod = \"exact\"\n";

    #[test]
    fn plain_samples_contradict_a_wrong_probability_at_a_limit_and_at_each_end() {
        // Over a verdict map samples are simulated.
        let in_time = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"near-equilibrium\"";
        for criterion in ["kind = \"eigenvalue\"", in_time] {
            contradict_a_wrong_probability(&JOB.replace("kind = \"eigenvalue\"", criterion));
        }
    }

    fn contradict_a_wrong_probability(job: &str) {
        let job = JobSource { path: PathBuf::from("job.toml"), text: job.to_owned() }.job().unwrap();
        let axis = LimitAxis::named(&job, "preload").unwrap();
        let beside = |value: f64, p: f64| {
            let certain = Estimate { probability: Some(p), low: p, high: p };
            Beside::new(value, certain.into())
        };
        // The probability at 0.0559726 is 0.01 with an error of 0, and a limit elsewhere is none.
        let limit = Limit { state: stickslip_sampler::limits::State::Rises, value: Some(0.0), bounds: None };
        for (place, ends, middle) in [
            (None, [0.0, 0.999], 0.05),
            (Some(0), [0.5, 0.999], 0.05),
            (Some(1), [0.0, 0.5], 0.05),
            (Some(2), [0.0, 0.999], 0.5),
        ] {
            let mut found = CombinationLimits {
                ends: [beside(0.005, ends[0]), beside(0.3, ends[1])],
                of_targets: vec![vec![(limit, Some(beside(0.0635, middle)))]],
            };
            let keeper = InMemory::default();
            let audit = |found: &mut CombinationLimits, is_stopped: bool| {
                found.audit((&job, &axis, 0), &Asked::new(Some(&keeper), (0, 1)), &|| is_stopped)
            };
            audit(&mut found, false).unwrap();
            let [from, to] = found.ends;
            let all = [from, to, found.of_targets[0][0].1.unwrap()];
            let expected: Vec<bool> = (0..3).map(|each| place == Some(each)).collect();
            assert_eq!(all.map(|each| each.is_contradicted()).to_vec(), expected, "{all:?}");
            assert!(all.iter().all(|each| each.plain.is_some_and(|plain| plain.decided == 300)));
            // They are compared with the interval that is there for it, not with that of the confidence of the job.
            let wide = Estimate { probability: None, low: 0.0, high: 1.0 };
            let widened = |beside: &Beside| {
                let Beside { value, estimate, plain, .. } = *beside;
                Beside { plain, ..Beside::new(value, Intervals { estimate, compared: wide }) }
            };
            assert!(all.iter().all(|each| !widened(each).is_contradicted()));
            // What is kept is not drawn again.
            let mut again = found.clone();
            audit(&mut again, true).unwrap();
            assert_eq!(format!("{again:?}"), format!("{found:?}"));
        }
    }
}
