//! Samples of models given by matrices: verdicts, limit states and critical values.

use std::any::Any;
use std::sync::{Arc, OnceLock};

use super::centres::Centres;
use super::decide::{Decider, MOST_REGIONS, RegionSet, region_at};
use super::decided::{Asked, Decided, Found};
use super::limit_branch::limit_states;
use super::problem::Problem;
use super::quadratic::DenseQuadratic;
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

/// Coordinates of dense matrices from which on all eigenvalues of a sample are found once for all bands: with fewer, that takes
/// hardly longer than to look up what was found.
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
    /// What is found for all bands at once.
    together: Option<Arc<Together>>,
    /// The places of those that count among them.
    places: RegionSet,
    /// Another configuration, whose series serves where it reaches well beyond the expected values.
    like: Option<Arc<Shared>>,
    /// Whether it does.
    serves: OnceLock<bool>,
}

/// What all configurations of a model share: cells that differ by band alone have the same samples.
struct Together {
    /// All bands, in the unit of the problem.
    regions: Vec<Region>,
    /// What was found of samples, where there are several.
    decided: Option<Decided>,
    centres: Centres,
}

impl Together {
    /// The bands in which a sample is unstable, at least of its `own` ones, where its eigenvalues are found; `None` if they are being
    /// found for another band and the sample is not `wanted_now`.
    fn bands(
        &self,
        problem: &Problem,
        coefficients: &[f64],
        own: RegionSet,
        wanted_now: bool,
    ) -> Option<Option<RegionSet>> {
        let find = |wanted: RegionSet| self.find(problem, coefficients, wanted);
        let alone = || find(own).map(|found| found.unstable);
        let Some(decided) = &self.decided else { return Some(alone()) };
        match decided.ask(coefficients, own) {
            Asked::InWork if !wanted_now => None,
            Asked::InWork => Some(alone()),
            Asked::Decided(regions) => Some(Some(regions)),
            Asked::Unknown(undecided) => Some(find(own & !undecided.known()).map(|found| undecided.decided(found))),
        }
    }

    /// What a sample is in bands: in all from a centre or by all eigenvalues, with full matrices in the `wanted` ones, one by one.
    fn find(&self, problem: &Problem, coefficients: &[f64], wanted: RegionSet) -> Option<Found> {
        if let Problem::Dense(problem) = problem {
            let by_all = || Decider::of_each(problem, &self.regions).by_all(coefficients);
            let unstable = self.centres.regions(problem, coefficients).or_else(by_all)?;
            return Some(Found { known: RegionSet::MAX, unstable });
        }
        let mut found = Found { known: wanted, unstable: 0 };
        for (place, region) in self.regions.iter().enumerate().filter(|(place, _)| region_at(*place) & wanted != 0) {
            if is_unstable(problem, coefficients, std::slice::from_ref(region))? {
                found.unstable |= region_at(place);
            }
        }
        Some(found)
    }
}

/// A configuration with the series about its expected values, made when it is first wanted.
struct Shared {
    matrices: Arc<Matrices>,
    problem: Problem,
    /// rad/s.
    regions: Vec<Region>,
    /// The same in the unit of the problem.
    scaled: Vec<Region>,
    expected: Vec<f64>,
    varying: Vec<usize>,
    recorded: Vec<PairResult>,
    /// Numbers that the vectors of the series may have.
    most_numbers: usize,
    series: OnceLock<Option<ModeSeries>>,
}

impl Shared {
    fn origin(&self) -> Vec<f64> {
        self.matrices.coefficients(&self.expected)
    }

    /// The coefficients that differ from sample to sample.
    fn changing(&self) -> Vec<usize> {
        let terms = self.matrices.damping.iter().chain(&self.matrices.stiffness).enumerate();
        let changes = |term: &Term| term.factor.parameters().any(|own| self.varying.contains(&own));
        terms.filter(|(_, term)| changes(term)).map(|(place, _)| place).collect()
    }

    fn series(&self) -> Option<&ModeSeries> {
        let make = || {
            let Problem::Dense(problem) = &self.problem else { return None };
            ModeSeries::new(problem, &self.origin(), &self.changing(), &self.scaled, self.most_numbers)
        };
        self.series.get_or_init(make).as_ref()
    }
}

/// The smallest damping ratio in some regions, rad/s, less its threshold, by all eigenvalues; 1 where there is no pair in a region.
fn least_excess(problem: &Problem, coefficients: &[f64], regions: &[Region]) -> Option<f64> {
    let values = problem.eigenvalues(coefficients, regions).ok()?;
    Some(values.iter().map(|value| excess(regions, *value)).fold(1.0, f64::min))
}

/// Whether that is below the threshold.
fn is_unstable(problem: &Problem, coefficients: &[f64], regions: &[Region]) -> Option<bool> {
    least_excess(problem, coefficients, regions).map(|excess| excess < -RESOLUTION)
}

impl Samples {
    /// The samples with these expected values of all quantities that differ in the `varying` ones.
    pub(super) fn boxed(
        matrices: &Arc<Matrices>,
        problem: &Problem,
        Bands { all, own, places }: Bands,
        recorded: &[PairResult],
        expected: &[f64],
        varying: &[usize],
        like: Option<&dyn Configuration>,
    ) -> Box<dyn Configuration> {
        let scale = |regions: &[Region]| regions.iter().map(|region| region.in_unit(problem.unit())).collect();
        let is_first = like.is_none();
        let like = like.and_then(Self::from_any);
        let others = like.and_then(|like| like.together.clone());
        let like = like.map(|like| like.shared.clone());
        let like = like.filter(|like| like.regions == own && like.varying == varying);
        let shared = Shared {
            matrices: matrices.clone(),
            problem: problem.clone(),
            scaled: scale(&own),
            regions: own,
            expected: expected.to_vec(),
            varying: varying.to_vec(),
            recorded: recorded.to_vec(),
            most_numbers: if is_first { MOST_NUMBERS_OF_FIRST } else { MOST_NUMBERS },
            series: OnceLock::new(),
        };
        let is_large = matches!(problem, Problem::Sparse(_)) || matrices.size() >= LARGE;
        let new = || {
            let regions: Vec<Region> = scale(&all);
            Arc::new(Together {
                decided: (regions.len() > 1).then(Decided::default),
                centres: Centres::new(regions.clone(), shared.changing(), shared.origin()),
                regions,
            })
        };
        let is_wanted = is_first && is_large && (1..=MOST_REGIONS).contains(&all.len());
        let together = others.or_else(|| is_wanted.then(new));
        Box::new(Self { shared: Arc::new(shared), together, places, like, serves: OnceLock::new() })
    }

    fn from_any(configuration: &dyn Configuration) -> Option<&Self> {
        let any: &dyn Any = configuration;
        any.downcast_ref()
    }

    fn series(&self) -> Option<&ModeSeries> {
        let other = self.like.as_ref();
        let reaches =
            |other: &Arc<Shared>| other.series().is_some_and(|series| series.reaches_beyond(&self.shared.origin()));
        let serves = *self.serves.get_or_init(|| other.is_some_and(reaches));
        other.filter(|_| serves).unwrap_or(&self.shared).series()
    }

    fn coefficients(&self, samples: &Columns<'_>, sample: usize) -> Vec<f64> {
        self.shared.matrices.coefficients(&samples.complete(sample, &self.shared.expected, &self.shared.varying))
    }

    /// The verdict of a sample; `None` if all its eigenvalues are being found for another band and it is not `wanted_now`.
    fn verdict(&self, coefficients: &[f64], wanted_now: bool) -> Option<Verdict> {
        if coefficients.iter().any(|value| !value.is_finite()) {
            return Some(Verdict::Failed);
        }
        let Shared { problem, regions, scaled, .. } = &*self.shared;
        let together = self.together.as_ref();
        let by_series = |problem: &DenseQuadratic| {
            let is_proved = together.is_some_and(|together| together.centres.serve(problem));
            if is_proved { None } else { Decider::of_any(problem, scaled, self.series()).by_series(coefficients) }
        };
        let told = if let Problem::Dense(problem) = problem { by_series(problem) } else { None };
        let unstable = match (told, together, problem) {
            (Some((regions, _)), ..) => Some(regions != 0),
            (None, Some(together), _) => {
                let regions = together.bands(problem, coefficients, self.places, wanted_now)?;
                regions.map(|regions| regions & self.places != 0)
            }
            (None, None, Problem::Dense(problem)) => {
                let regions = Decider::of_any(problem, scaled, self.series()).by_all(coefficients);
                regions.map(|regions| regions != 0)
            }
            (None, None, Problem::Sparse(_)) => is_unstable(problem, coefficients, regions),
        };
        Some(match unstable {
            Some(true) => Verdict::Unstable,
            Some(false) => Verdict::Stable,
            None => Verdict::Failed,
        })
    }

    /// The eigenvalue that this is of, in rad/s, with the series if there is one.
    fn least_damped(&self, coefficients: &[f64], series: Option<&ModeSeries>) -> Option<Eigenvalue> {
        let Shared { problem, regions, scaled, .. } = &*self.shared;
        if let Problem::Dense(problem) = problem {
            return Decider::of_any(problem, scaled, series).least_damped(coefficients);
        }
        let values = problem.eigenvalues(coefficients, regions).ok()?;
        values.into_iter().min_by(|a, b| excess(regions, *a).total_cmp(&excess(regions, *b)))
    }

    /// The same for a sample with this verdict.
    fn least_damped_for(&self, verdict: Verdict, coefficients: &[f64]) -> Option<Eigenvalue> {
        let Some(series) = self.series() else { return self.least_damped(coefficients, None) };
        let least = self.least_damped(coefficients, Some(series));
        let is_unstable = least.is_some_and(|pair| self.shared.regions.iter().any(|region| region.contains(pair)));
        // The verdict may be proved, what the series finds is not.
        let agrees = is_unstable == (verdict == Verdict::Unstable);
        if agrees { least } else { self.least_damped(coefficients, None) }
    }

    /// What is recorded of a sample with this verdict.
    fn recorded(&self, verdict: Verdict, coefficients: &[f64]) -> RecordedValues {
        let mut values = NOTHING;
        let recorded = &self.shared.recorded;
        if !recorded.is_empty() && verdict != Verdict::Failed {
            let least = self.least_damped_for(verdict, coefficients);
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
        // What is being found for another band comes last.
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
                    Decider::of_any(problem, &self.shared.scaled, self.series()).limit_state(&coefficients)
                }
                problem @ Problem::Sparse(_) => least_excess(problem, &coefficients, &self.shared.regions),
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
            let mut states = limit_states(&values, &self.shared.scaled);
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
            let coefficients = self.coefficients(samples, sample);
            let is_unstable =
                !self.is_outside(samples, sample) && self.verdict(&coefficients, true) == Some(Verdict::Unstable);
            let least = is_unstable.then(|| self.least_damped_for(Verdict::Unstable, &coefficients)).flatten();
            least.map_or(f64::NAN, |value| value.im.abs() / std::f64::consts::TAU)
        };
        Some((0..samples.len()).map(of_sample).collect())
    }
}

impl CriticalValues for Samples {
    /// Values beyond the ranges of parameters are outside the model, and not unstable.
    fn unstable(&self, values: &[f64], place: usize, places: &[f64], memory: &dyn Memory) -> Option<UnstableValues> {
        let Shared { matrices, problem, regions, expected, varying, .. } = &*self.shared;
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

#[cfg(test)]
mod tests;
