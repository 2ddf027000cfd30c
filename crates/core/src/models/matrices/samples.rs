//! Samples of models given by matrices: verdicts, limit states and critical values.

use std::any::Any;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use super::decide::{Decider, MOST_REGIONS, RegionSet, region_at};
use super::decided::{Asked, Decided};
use super::limit_branch::limit_states;
use super::problem::Problem;
use super::recorded::PairResult;
use super::region::{RESOLUTION, Region, excess};
use super::series::ModeSeries;
use super::terms::{Matrices, OverParameter, Term};
use crate::model::critical_values::{CriticalValues, Memory, UnstableValues, within};
use crate::model::decision::Decision;
use crate::model::quantity::Limits;
use crate::model::recorded::{NOTHING, RecordedValues};
use crate::model::verdict::Verdict;
use crate::model::{Columns, Configuration, IsStopped};
use crate::numerics::eigenvalues::Eigenvalue;

/// Numbers in the vectors of the series of the first configuration, 0.25 GiB, and of others, 4 MiB: of those a thousand may be
/// kept.
const MOST_NUMBERS_OF_FIRST: usize = 1 << 24;
const MOST_NUMBERS: usize = 1 << 18;

/// Coordinates from which on a sample is decided once for all bands: with fewer, that takes hardly longer than to look up what
/// was decided.
const LARGE: usize = 16;

/// The bands of a model, and which of them count.
pub(super) struct Bands {
    /// All of them, rad/s.
    pub(super) all: Vec<Region>,
    /// Those that count, rad/s.
    pub(super) own: Vec<Region>,
    /// Their places among all.
    pub(super) places: RegionSet,
}

/// What samples with the same expected values share.
pub(super) struct Samples {
    shared: Arc<Shared>,
    /// Another configuration, whose series serves where it reaches well beyond the expected values.
    like: Option<Arc<Shared>>,
    /// Whether it does.
    serves: OnceLock<bool>,
    /// The bands that count: in rad/s, in the unit of the problem, and their places among those of [`Shared`].
    regions: Vec<Region>,
    scaled: Vec<Region>,
    places: RegionSet,
    family: Arc<Family>,
}

/// All configurations of a model, of which those that differ by band alone share what is computed.
struct Family {
    members: Mutex<Vec<Weak<Shared>>>,
    /// What was decided for one band and is asked for again for the others.
    decided: Decided,
}

/// A configuration with the series about its expected values, made when it is first wanted.
struct Shared {
    matrices: Arc<Matrices>,
    problem: Problem,
    /// The bands that samples are decided for together, rad/s.
    regions: Vec<Region>,
    /// The same in the unit of the problem.
    scaled: Vec<Region>,
    /// Those of the parameters.
    expected: Vec<f64>,
    varying: Vec<usize>,
    recorded: Vec<PairResult>,
    /// Numbers that the vectors of the series may have.
    most_numbers: usize,
    series: OnceLock<Option<ModeSeries>>,
    /// Whether samples are decided for several bands together.
    is_shared: bool,
}

impl Shared {
    fn origin(&self) -> Vec<f64> {
        self.matrices.coefficients(&self.expected)
    }

    fn series(&self) -> Option<&ModeSeries> {
        let make = || {
            let Problem::Dense(problem) = &self.problem else { return None };
            let terms = self.matrices.damping.iter().chain(&self.matrices.stiffness).enumerate();
            let changes = |term: &Term| term.factor.parameters().any(|own| self.varying.contains(&own));
            let changing: Vec<usize> = terms.filter(|(_, term)| changes(term)).map(|(place, _)| place).collect();
            ModeSeries::new(problem, &self.origin(), &changing, &self.scaled, self.most_numbers)
        };
        self.series.get_or_init(make).as_ref()
    }

    /// The bands in which a sample is unstable; `None` if its eigenvalues do not converge.
    fn unstable(&self, series: Option<&ModeSeries>, coefficients: &[f64]) -> Option<RegionSet> {
        match &self.problem {
            Problem::Dense(problem) => {
                Decider::new(problem, &self.scaled, series).unstable(coefficients).map(|(regions, _)| regions)
            }
            Problem::Sparse(_) => {
                let values = self.problem.eigenvalues(coefficients, &self.regions).ok()?;
                let is_below = |region: &Region| {
                    values.iter().any(|value| excess(std::slice::from_ref(region), *value) < -RESOLUTION)
                };
                let below = self.regions.iter().enumerate().filter(|(_, region)| is_below(region));
                Some(below.fold(0, |found, (place, _)| found | region_at(place)))
            }
        }
    }
}

impl Samples {
    /// The samples with these expected values of all parameters that differ in the `varying` ones.
    pub(super) fn boxed(
        matrices: &Arc<Matrices>,
        problem: &Problem,
        bands: Bands,
        recorded: &[PairResult],
        expected: &[f64],
        varying: &[usize],
        like: Option<&dyn Configuration>,
    ) -> Box<dyn Configuration> {
        let like = like.and_then(Self::from_any);
        let is_shared = (2..=MOST_REGIONS).contains(&bands.all.len()) && matrices.size() >= LARGE;
        let own = bands.own;
        let (all, places) = if is_shared { (bands.all, bands.places) } else { (own.clone(), RegionSet::MAX) };
        let new_family = || Arc::new(Family { members: Mutex::default(), decided: Decided::new(all.len() as u32) });
        let family = like.map_or_else(new_family, |like| like.family.clone());
        let is_same = |shared: &Arc<Shared>| {
            let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<u64>>();
            shared.regions == all && shared.varying == varying && bits(&shared.expected) == bits(expected)
        };
        let scale = |regions: &[Region]| regions.iter().map(|region| region.in_unit(problem.unit())).collect();
        let make = || Shared {
            matrices: matrices.clone(),
            problem: problem.clone(),
            scaled: scale(&all),
            regions: all.clone(),
            expected: expected.to_vec(),
            varying: varying.to_vec(),
            recorded: recorded.to_vec(),
            most_numbers: if like.is_none() { MOST_NUMBERS_OF_FIRST } else { MOST_NUMBERS },
            series: OnceLock::new(),
            is_shared,
        };
        let shared = {
            let mut known = family.members.lock().unwrap_or_else(PoisonError::into_inner);
            known.retain(|shared| shared.strong_count() > 0);
            let found = known.iter().filter_map(Weak::upgrade).find(is_same);
            found.unwrap_or_else(|| {
                let made = Arc::new(make());
                known.push(Arc::downgrade(&made));
                made
            })
        };
        let like = like.map(|like| like.shared.clone());
        let like = like.filter(|like| like.regions == shared.regions && like.varying == varying);
        let (scaled, serves) = (scale(&own), OnceLock::new());
        Box::new(Self { shared, like, serves, regions: own, scaled, places, family })
    }

    fn from_any(configuration: &dyn Configuration) -> Option<&Self> {
        let any: &dyn Any = configuration;
        any.downcast_ref()
    }

    fn series(&self) -> Option<&ModeSeries> {
        let other = self.like.as_ref().filter(|other| !Arc::ptr_eq(other, &self.shared));
        let reaches =
            |other: &Arc<Shared>| other.series().is_some_and(|series| series.reaches_beyond(&self.shared.origin()));
        let serves = *self.serves.get_or_init(|| other.is_some_and(reaches));
        other.filter(|_| serves).unwrap_or(&self.shared).series()
    }

    fn coefficients(&self, samples: &Columns<'_>, sample: usize) -> Vec<f64> {
        self.shared.matrices.coefficients(&samples.complete(sample, &self.shared.expected, &self.shared.varying))
    }

    /// The verdict of a sample; `None` if it is being decided for another band and is not `wanted_now`.
    fn verdict(&self, coefficients: &[f64], wanted_now: bool) -> Option<Verdict> {
        if coefficients.iter().any(|value| !value.is_finite()) {
            return Some(Verdict::Failed);
        }
        let decide = || self.shared.unstable(self.series(), coefficients);
        let Shared { expected, is_shared, .. } = &*self.shared;
        let unstable = match is_shared.then(|| self.family.decided.ask([expected, coefficients])) {
            Some(Asked::InWork) if !wanted_now => return None,
            Some(Asked::InWork) | None => decide(),
            Some(Asked::Decided(unstable)) => unstable,
            Some(Asked::Unknown(undecided)) => undecided.decided(decide()),
        };
        Some(match unstable {
            Some(regions) if regions & self.places != 0 => Verdict::Unstable,
            Some(_) => Verdict::Stable,
            None => Verdict::Failed,
        })
    }

    /// The smallest damping ratio in the bands less its threshold, by all eigenvalues; 1 where there is no pair in a band.
    fn excess(&self, coefficients: &[f64]) -> Option<f64> {
        let values = self.shared.problem.eigenvalues(coefficients, &self.regions).ok()?;
        Some(values.iter().map(|value| excess(&self.regions, *value)).fold(1.0, f64::min))
    }

    /// The eigenvalue that this is of, in rad/s.
    fn least_damped(&self, coefficients: &[f64]) -> Option<Eigenvalue> {
        let (problem, regions) = (&self.shared.problem, &self.regions);
        if let Problem::Dense(problem) = problem {
            return Decider::new(problem, &self.scaled, self.series()).least_damped(coefficients);
        }
        let values = problem.eigenvalues(coefficients, regions).ok()?;
        values.into_iter().min_by(|a, b| excess(regions, *a).total_cmp(&excess(regions, *b)))
    }

    /// What is recorded of a sample with this verdict.
    fn recorded(&self, verdict: Verdict, coefficients: &[f64]) -> RecordedValues {
        let mut values = NOTHING;
        let recorded = &self.shared.recorded;
        if !recorded.is_empty() && verdict != Verdict::Failed {
            let least = self.least_damped(coefficients);
            values.iter_mut().zip(recorded).for_each(|(value, result)| *value = least.map(|pair| result.value(pair)));
        }
        values
    }

    /// The range of the quantity at a place, if that is a parameter.
    fn range(&self, place: usize) -> Option<Limits> {
        self.shared.matrices.parameters.get(place).map(|parameter| parameter.range)
    }

    /// Whether a quantity with this value is beyond its range.
    fn is_beyond(&self, place: usize, value: f64) -> bool {
        self.range(place).is_some_and(|range| !range.contain(value))
    }

    fn is_outside(&self, samples: &Columns<'_>, sample: usize) -> bool {
        let mut values = self.shared.varying.iter().zip(samples.sample(sample));
        values.any(|(&place, value)| self.is_beyond(place, value))
    }

    fn has_ranges(&self) -> bool {
        self.shared.varying.iter().any(|&place| self.range(place).is_some_and(|range| range != Limits::ANY))
    }
}

impl Configuration for Samples {
    fn decide(&self, samples: &Columns<'_>, wanted: &[usize], is_stopped: IsStopped<'_>) -> Option<Vec<Decision>> {
        let decide = |sample: usize, wanted_now: bool| {
            if self.is_outside(samples, sample) {
                return Some(Decision::OUTSIDE_PHYSICS);
            }
            let coefficients = self.coefficients(samples, sample);
            let verdict = self.verdict(&coefficients, wanted_now)?;
            Some(Decision { recorded: self.recorded(verdict, &coefficients), ..verdict.into() })
        };
        // What is being decided for another band comes last.
        let mut decisions = vec![None; wanted.len()];
        for wanted_now in [false, true] {
            for (decision, &sample) in decisions.iter_mut().zip(wanted).filter(|(decision, _)| decision.is_none()) {
                if is_stopped() {
                    return None;
                }
                *decision = decide(sample, wanted_now);
            }
        }
        decisions.into_iter().collect()
    }

    fn outside(&self, samples: &Columns<'_>) -> Option<Vec<bool>> {
        self.has_ranges().then(|| (0..samples.len()).map(|sample| self.is_outside(samples, sample)).collect())
    }

    /// The smallest damping ratio in the bands less the threshold.
    fn limit_states(&self, samples: &Columns<'_>) -> Option<Vec<f64>> {
        let state = |sample: usize| {
            let coefficients = self.coefficients(samples, sample);
            let state = match &self.shared.problem {
                Problem::Dense(problem) => {
                    Decider::new(problem, &self.scaled, self.series()).limit_state(&coefficients)
                }
                Problem::Sparse(_) => self.excess(&coefficients),
            };
            state.unwrap_or(f64::NAN)
        };
        Some((0..samples.len()).map(state).collect())
    }

    /// One for each pair, with dense matrices.
    fn limit_branches(&self) -> usize {
        match &self.shared.problem {
            Problem::Dense(problem) => problem.size(),
            Problem::Sparse(_) => 0,
        }
    }

    fn branch_limit_states(&self, samples: &Columns<'_>) -> Option<Vec<Vec<f64>>> {
        let Problem::Dense(problem) = &self.shared.problem else { return None };
        let states = |sample: usize| {
            let values = problem.at(&self.coefficients(samples, sample)).eigenvalues();
            let Ok(values) = values else { return vec![f64::NAN; problem.size()] };
            let mut states = limit_states(&values, &self.scaled);
            // Two motions that dampers alone hold have one together.
            states.resize(problem.size(), 1.0);
            states
        };
        Some((0..samples.len()).map(states).collect())
    }

    fn critical_values(&self) -> Option<&dyn CriticalValues> {
        Some(self)
    }

    fn unstable_frequencies(&self, samples: &Columns<'_>) -> Option<Vec<f64>> {
        let of_sample = |sample: usize| {
            let least = self.least_damped(&self.coefficients(samples, sample));
            let is_unstable = |value: &Eigenvalue| self.regions.iter().any(|region| region.contains(*value));
            let unstable = least.filter(|value| !self.is_outside(samples, sample) && is_unstable(value));
            unstable.map_or(f64::NAN, |value| value.im.abs() / std::f64::consts::TAU)
        };
        Some((0..samples.len()).map(of_sample).collect())
    }
}

impl CriticalValues for Samples {
    /// Values beyond the ranges of parameters are outside the model, and not unstable.
    fn unstable(&self, values: &[f64], place: usize, places: &[f64], memory: &dyn Memory) -> Option<UnstableValues> {
        let (Shared { matrices, problem, expected, varying, .. }, regions) = (&*self.shared, &self.regions);
        let mut complete = expected.clone();
        varying.iter().zip(values).for_each(|(&place, value)| complete[place] = *value);
        let place = *varying.get(place)?;
        let mut values = varying.iter().zip(values);
        if values.any(|(&other, &value)| other != place && self.is_beyond(other, value)) {
            return Some(UnstableValues::default());
        }
        let range = self.range(place)?;
        let Some(places) = within(places, [range.minimum, range.maximum]) else {
            return Some(UnstableValues::default());
        };
        if places.iter().any(|place| !place.is_finite()) {
            return None;
        }
        let path = OverParameter { matrices, values: &complete, place };
        let mut all = UnstableValues::default();
        for region in regions {
            all = all.or(&problem.unstable_values(&path, region, &places, memory)?);
        }
        Some(all)
    }
}
