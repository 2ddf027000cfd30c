//! Estimates, their intervals, and predictions.

use stickslip_core::model::pair_boundary::PairBoundary;
use thiserror::Error;

use super::data::{TestData, Verdicts};
use super::goodness::{Goodness, goodness};
use super::likelihood::{FitModel, LEAST, Likelihood, Unlikely};
use super::maximum::{Matrix, Maximum, maximum, product, slopes};
use super::parameter::{ESTIMABLE, FitValues, LEAST_STD, Range};
use super::root::reached;
use crate::inputs::{Marginal, PairParameter};
use crate::special_functions::normal;

/// Coordinates up to which an interval is sought.
const FARTHEST: f64 = 12.0;

/// A likelihood whose logarithm is greater by this belongs to another maximum.
const BETTER: f64 = 1e-4;

/// Most maxima that are left for a better one.
const MOST_MAXIMA: usize = 5;

/// A likelihood that lies less deep than this, in standard deviations, is as high as the maximum.
const SHALLOW: f64 = 0.05;

/// How far the end of an interval is sought first where the curvature says nothing, and the farthest in any case.
const FIRST_STEPS: [f64; 2] = [0.05, 1.5];

/// The same for the weight of a predicted quantity.
const WEIGHTS: [f64; 2] = [8.0, 1e4];

/// A place found is followed to at most this share of its distance.
const MOST_BEYOND: f64 = 1.5;

/// A likelihood this many times as deep as the level is sought from another start as well.
const TOO_DEEP: f64 = 1.5;

/// Standard deviations at which the search begins as well if some tests are as good as impossible.
const WIDE_STDS: [f64; 3] = [0.5, 1.0, 3.0];

/// Most tests of each result that are left out in turn where the likelihood ends at a limit.
const MOST_SUSPECTS: usize = 3;

/// Most rows that a message names.
const MOST_LISTED: usize = 5;

/// An estimated parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedParameter {
    /// Which.
    pub parameter: PairParameter,
    /// The value with which the likelihood is greatest.
    pub value: f64,
    /// The lower end of its interval; `None` if the data have none within the limits of the parameters.
    pub low: Option<f64>,
    /// The upper end likewise.
    pub high: Option<f64>,
}

/// A probability of squeal, with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// With the estimates.
    pub probability: f64,
    /// The least of all parameters whose likelihood is high enough.
    pub low: f64,
    /// The greatest.
    pub high: f64,
}

/// Why nothing is estimated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// All verdicts are the same.
    #[error(
        "{}, so that nothing shows where squeal begins; add tests at {} {}",
        if *.squealed { "every test squealed" } else { "no test squealed" },
        if *.squealed { "higher speeds or a lower" } else { "lower speeds or a higher" },
        .first
    )]
    OneSided {
        /// Whether they squealed.
        squealed: bool,
        /// The name of the first input.
        first: String,
    },
    /// There are no tests.
    #[error("there are no tests")]
    NoTests,
    /// Some tests are as good as impossible with the values that explain the others.
    #[error(
        "the model cannot produce the test{0} of line{0} {1}, whose probability is below 1e-300 with all values that were tried; correct the line{0} (is the speed right?), or take {2} out and say so",
        if .rows.len() > 1 { "s" } else { "" },
        listed(.rows),
        if .rows.len() > 1 { "them" } else { "it" }
    )]
    Impossible {
        /// Their rows.
        rows: Vec<u64>,
    },
    /// The standard deviation is that of measured values.
    #[error("{parameter} cannot be estimated: the job has measured values, which scatter as they do; leave it out")]
    Measured {
        /// The name of the parameter.
        parameter: String,
    },
    /// In all conditions but one the verdicts are alike, so that any small scatter explains them.
    #[error(
        "the tests that squealed and those that did not are separated (in all conditions but at most one they are \
         alike), so that any small {parameter} explains them; test in conditions between those where all and where \
         none squeal, or leave {parameter} out of what is estimated and set it in the job"
    )]
    Separated {
        /// The name of the parameter.
        parameter: String,
    },
    /// The likelihood is greatest without a scatter.
    #[error(
        "the tests scatter no more than everything else explains, so that the likelihood grows until {parameter} is \
         {limit:.4}, the least that is sought; leave {parameter} out of what is estimated and set it in the job, set \
         less scatter of the other input, or add tests"
    )]
    NoScatter {
        /// The name of the parameter.
        parameter: String,
        /// The least that is sought.
        limit: f64,
    },
    /// The likelihood is greatest at a limit of a parameter.
    #[error(
        "the likelihood grows until {parameter} is {limit:.4}, the limit up to which it is sought; leave {parameter} \
         out of what is estimated and set it in the job, or test in more different conditions{}",
        suspected(.suspects)
    )]
    AtLimit {
        /// The name of the parameter.
        parameter: String,
        /// The limit.
        limit: f64,
        /// The tests without which it would not, with their probabilities by what the others say.
        suspects: Vec<Unlikely>,
    },
    /// Other values explain the data as well, without end in either direction.
    #[error(
        "the tests do not determine {}: other values explain them as well; estimate fewer parameters and set the \
         others in the job, or test in more different conditions (speeds and values of {first})",
        .parameters.join(" and ")
    )]
    NotIdentified {
        /// The names of the parameters.
        parameters: Vec<String>,
        /// The name of the first input.
        first: String,
    },
}

/// The first rows of a list.
fn listed(rows: &[u64]) -> String {
    let first: Vec<String> = rows.iter().take(MOST_LISTED).map(u64::to_string).collect();
    let more = if rows.len() > MOST_LISTED { format!(" and {} more", rows.len() - MOST_LISTED) } else { String::new() };
    first.join(", ") + &more
}

/// What is said of tests that lead a fit astray; nothing of none.
fn suspected(tests: &[Unlikely]) -> String {
    let each = |test: &Unlikely| format!("line {} (p = {:.1e} by the others)", test.row, test.p_value);
    let lines: Vec<String> = tests.iter().map(each).collect();
    if lines.is_empty() {
        return String::new();
    }
    format!(". It would not without {}: look whether that is right", lines.join(" or without "))
}

/// What the tests say.
pub struct Fit<'a> {
    likelihood: Likelihood<'a>,
    best: Maximum,
    /// The square root of the quantile of the chi-squared distribution.
    level: f64,
    /// The estimated parameters, in the order of [`ESTIMABLE`].
    pub parameters: Vec<FittedParameter>,
    /// All values, the estimates among them.
    pub values: FitValues,
    /// The logarithm of the likelihood.
    pub log_likelihood: f64,
}

/// Why there are no intervals.
enum Stop {
    /// There is a better maximum.
    Better(Vec<f64>),
    /// The likelihood is as high at a limit of a parameter alone.
    Limit(PairParameter, f64),
}

/// Estimates parameters from tests, with intervals of a confidence.
///
/// # Errors
/// [`FitError`] if the tests do not determine the parameters.
pub fn fit<'a>(
    model: &'a FitModel,
    data: &'a TestData,
    estimated: &[PairParameter],
    confidence: f64,
) -> Result<Fit<'a>, FitError> {
    let estimated: Vec<PairParameter> = ESTIMABLE.into_iter().filter(|one| estimated.contains(one)).collect();
    check(model, data, &estimated)?;
    let ranges = estimated.iter().map(|&parameter| (parameter, Range::new(parameter, &model.marginals))).collect();
    let likelihood = Likelihood { model, data, estimated: ranges };
    let level = -normal::quantile(0.5 * (1.0 - confidence));
    let not_identified =
        |parameters: Vec<String>| FitError::NotIdentified { parameters, first: model.names[0].clone() };
    let mut best = best_of_starts(&likelihood, &[]);
    let rows = likelihood.impossible(&best.place);
    if !rows.is_empty() {
        // With more scatter all may be possible.
        best = best_of_starts(&likelihood, &WIDE_STDS);
        if check_limits(&likelihood, &best).is_err() || !likelihood.impossible(&best.place).is_empty() {
            return Err(FitError::Impossible { rows });
        }
    }
    for _ in 0..MOST_MAXIMA {
        check_limits(&likelihood, &best)?;
        let logarithm = |y: &[f64]| likelihood.logarithm(y);
        match intervals(&likelihood, &best, level) {
            Err(Stop::Better(better)) => best = maximum(&logarithm, &better, None),
            Err(Stop::Limit(which, limit)) => return Err(at_limit(&likelihood, &best.place, which, limit)),
            Ok(parameters) => {
                let flat = parameters.iter().filter(|fitted| fitted.low.is_none() && fitted.high.is_none());
                let flat: Vec<String> = flat.map(|fitted| model.name(fitted.parameter)).collect();
                if !flat.is_empty() {
                    return Err(not_identified(flat));
                }
                let (values, log_likelihood) = (likelihood.values(&best.place), best.value);
                return Ok(Fit { likelihood, best, level, parameters, values, log_likelihood });
            }
        }
    }
    Err(not_identified(estimated.iter().map(|&parameter| model.name(parameter)).collect()))
}

fn check(model: &FitModel, data: &TestData, estimated: &[PairParameter]) -> Result<(), FitError> {
    for (input, marginal) in model.marginals.iter().enumerate() {
        let parameter = PairParameter::RelativeStd(input);
        if estimated.contains(&parameter) && matches!(marginal, Marginal::Empirical(_)) {
            return Err(FitError::Measured { parameter: model.name(parameter) });
        }
    }
    let one_sided = |squealed: bool| FitError::OneSided { squealed, first: model.names[0].clone() };
    match data.counts() {
        [0.0, 0.0] => Err(FitError::NoTests),
        [_, 0.0] if data.onsets.is_empty() => Err(one_sided(true)),
        [0.0, _] => Err(one_sided(false)),
        _ => Ok(()),
    }
}

/// The best of the maxima that are reached from the two best of many starts, with further standard deviations.
fn best_of_starts(likelihood: &Likelihood<'_>, stds: &[f64]) -> Maximum {
    let mut starts: Vec<Vec<f64>> = vec![Vec::new()];
    let has_second = likelihood.estimated.iter().any(|(parameter, _)| *parameter == PairParameter::Expected(1));
    for (parameter, range) in &likelihood.estimated {
        let own = likelihood.model.values.get(*parameter);
        let values: Vec<f64> = match parameter {
            PairParameter::Expected(0) if has_second => vec![own],
            PairParameter::Expected(_) => (-8..=8).map(|step| own * libm::exp(0.12 * f64::from(step))).collect(),
            PairParameter::RelativeStd(0) => [&[own, 0.1], stds].concat(),
            PairParameter::RelativeStd(_) => [&[own, 0.03, 0.1, 0.25], stds].concat(),
            PairParameter::Correlation => vec![own, -0.5, 0.5],
        };
        let extended = |start: &Vec<f64>| {
            let with = |value: &f64| [&start[..], &[range.coordinate(*value)]].concat();
            values.iter().map(with).collect::<Vec<_>>()
        };
        starts = starts.iter().flat_map(extended).collect();
    }
    let f = |y: &[f64]| likelihood.logarithm(y);
    let mut rated: Vec<(f64, Vec<f64>)> = starts.into_iter().map(|start| (f(&start), start)).collect();
    rated.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut best = maximum(&f, &rated[0].1, None);
    if let Some((_, second)) = rated.get(1) {
        let other = maximum(&f, second, None);
        if other.value > best.value {
            best = other;
        }
    }
    best
}

/// Refuses a maximum at a limit.
fn check_limits(likelihood: &Likelihood<'_>, best: &Maximum) -> Result<(), FitError> {
    let mut parameters = likelihood.estimated.iter().zip(&best.place);
    let found = parameters.find_map(|((parameter, range), &y)| Some((*parameter, range.limit(y)?)));
    found.map_or(Ok(()), |(parameter, limit)| Err(at_limit(likelihood, &best.place, parameter, limit)))
}

/// What is said of a likelihood that is as high at a limit as anywhere.
fn at_limit(likelihood: &Likelihood<'_>, place: &[f64], parameter: PairParameter, limit: f64) -> FitError {
    let is_std = matches!(parameter, PairParameter::RelativeStd(_));
    let is_mixed = |verdicts: &&Verdicts| verdicts.squealed > 0.0 && verdicts.quiet > 0.0;
    let mixed = likelihood.data.verdicts.iter().filter(is_mixed).count();
    let parameter = likelihood.model.name(parameter);
    if is_std && likelihood.data.onsets.is_empty() && mixed <= 1 {
        FitError::Separated { parameter }
    } else if is_std && limit < 2.0 * LEAST_STD {
        FitError::NoScatter { parameter, limit }
    } else {
        FitError::AtLimit { parameter, limit, suspects: suspects(likelihood, place) }
    }
}

/// The tests that alone lead the likelihood to a limit: without one of them its maximum lies within, and makes that one
/// improbable. Sought among those that the limit makes most improbable, one by one, of those that squealed and of those
/// that did not: with a value at its limit these need not be the worst.
fn suspects(likelihood: &Likelihood<'_>, place: &[f64]) -> Vec<Unlikely> {
    let mut single = likelihood.single(&likelihood.values(place));
    let mut found = Vec::new();
    for tests in &mut single {
        tests.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
        for &Unlikely { row, .. } in tests.iter().take(MOST_SUSPECTS) {
            let others = likelihood.data.without(row);
            if check(likelihood.model, &others, &[]).is_err() {
                continue;
            }
            let of_others =
                Likelihood { model: likelihood.model, data: &others, estimated: likelihood.estimated.clone() };
            let best = best_of_starts(&of_others, &[]);
            if of_others.estimated.iter().zip(&best.place).all(|((_, range), &y)| range.limit(y).is_none()) {
                let p_values = likelihood.p_values(&likelihood.values(&best.place));
                found.extend(p_values.into_iter().filter(|test| test.row == row));
            }
        }
    }
    likelihood.worst(found)
}

/// The intervals of all parameters.
fn intervals(likelihood: &Likelihood<'_>, best: &Maximum, level: f64) -> Result<Vec<FittedParameter>, Stop> {
    let interval = |(i, (parameter, range)): (usize, &(PairParameter, Range))| {
        let [below, above] = [bound(likelihood, best, i, -1.0, level)?, bound(likelihood, best, i, 1.0, level)?];
        let end = |bound: &Bound| match bound {
            Bound::At(y) => Some(range.value(*y)),
            Bound::Open { .. } => None,
        };
        let value = range.value(best.place[i]);
        let fitted = FittedParameter { parameter: *parameter, value, low: end(&below), high: end(&above) };
        // Open to both sides is another matter.
        match [below, above] {
            [Bound::Open { depth }, Bound::At(_)] if depth < SHALLOW => {
                Err(Stop::Limit(*parameter, range.value(f64::NEG_INFINITY)))
            }
            [Bound::At(_), Bound::Open { depth }] if depth < SHALLOW => {
                Err(Stop::Limit(*parameter, range.value(f64::INFINITY)))
            }
            _ => Ok(fitted),
        }
    };
    likelihood.estimated.iter().enumerate().map(interval).collect()
}

impl Maximum {
    /// How far a likelihood lies below the maximum: the standard deviations of a normal one.
    fn depth(&self, value: f64) -> f64 {
        (2.0 * (self.value - value)).max(0.0).sqrt()
    }

    /// About the step from here to where the likelihood is as deep as a level, and a quantity with this `gradient`
    /// greatest. `None` if that is far away.
    fn step(&self, gradient: &[f64], level: f64) -> Option<Vec<f64>> {
        let direction: Vec<f64> = self.inverse.iter().map(|row| product(row, gradient)).collect();
        let variance = product(&direction, gradient);
        let step: Vec<f64> = direction.iter().map(|part| part * level / variance.sqrt()).collect();
        let [_, farthest] = FIRST_STEPS;
        step.iter().all(|part| part.abs() <= farthest).then_some(step)
    }
}

/// A place on the line from `here` to `there`, at a share of their distance, but little beyond.
fn along(here: &[f64], there: &[f64], share: f64) -> Vec<f64> {
    let share = if share > MOST_BEYOND { 1.0 } else { share };
    here.iter().zip(there).map(|(here, there)| here + share * (there - here)).collect()
}

/// The end of an interval.
enum Bound {
    /// At a coordinate.
    At(f64),
    /// None within the limits, where the likelihood is so deep at last.
    Open { depth: f64 },
}

/// The end of the interval of one parameter.
fn bound(likelihood: &Likelihood<'_>, best: &Maximum, which: usize, direction: f64, level: f64) -> Result<Bound, Stop> {
    let gradient: Vec<f64> = (0..best.place.len()).map(|i| if i == which { direction } else { 0.0 }).collect();
    // Where the other parameters were at the last distance, or are by the curvature.
    let [mut first, _] = FIRST_STEPS;
    let mut found = (1.0, best.place.clone());
    if let Some(step) = best.step(&gradient, level) {
        first = step[which].abs();
        found = (first, best.place.iter().zip(&step).map(|(place, step)| place + step).collect());
    }
    let mut inverse: Option<Matrix> = None;
    // The last place within.
    let mut below = best.place.clone();
    let mut better = None;
    let mut last = 0.0;
    let whole = |others: &[f64], y: f64| {
        let mut place = others.to_vec();
        place.insert(which, y);
        place
    };
    let profile = |distance: f64| {
        let y = best.place[which] + direction * distance;
        let of = |others: &[f64]| likelihood.logarithm(&whole(others, y));
        let from = |mut place: Vec<f64>, inverse: Option<&Matrix>| {
            place.remove(which);
            maximum(&of, &place, inverse)
        };
        let mut inner = from(along(&best.place, &found.1, distance / found.0), inverse.as_ref());
        // So deep, it may have begun on the wrong side of a ridge.
        if best.depth(inner.value) > TOO_DEEP * level {
            let other = from(below.clone(), None);
            inner = if other.value > inner.value { other } else { inner };
        }
        let place = whole(&inner.place, y);
        found = (distance, place.clone());
        inverse = Some(inner.inverse);
        if inner.value > best.value + BETTER {
            better = Some(place.clone());
        }
        last = best.depth(inner.value);
        if last < level {
            below.clone_from(&place);
        }
        (last, place)
    };
    let farthest = FARTHEST - direction * best.place[which];
    let end = reached(level, first, farthest, profile);
    if let Some(place) = better {
        return Err(Stop::Better(place));
    }
    // With another parameter at its limit, it is that limit which ends the interval, not the data.
    let is_free =
        |place: &Vec<f64>| likelihood.estimated.iter().zip(place).all(|((_, range), &y)| range.limit(y).is_none());
    Ok(match end.filter(is_free) {
        Some(place) => Bound::At(place[which]),
        None => Bound::Open { depth: last },
    })
}

impl Fit<'_> {
    /// How well the model with the estimates explains the tests.
    #[must_use]
    pub fn goodness(&self) -> Vec<Goodness> {
        goodness(self.likelihood.model, self.likelihood.data, &self.values, self.parameters.len())
    }

    /// The tests that the estimates explain worst, three at most: conditions and onset speeds whose probability is below
    /// 0.05 over the number of them all.
    #[must_use]
    pub fn worst(&self) -> Vec<Unlikely> {
        self.likelihood.worst(self.likelihood.p_values(&self.values))
    }

    /// The probability of squeal at a nominal first input, with the boundary at the speed. Its interval reaches from
    /// the least to the greatest value that it has with parameters whose profile likelihood is high enough, found by
    /// maximising the logarithm of the likelihood plus a multiple of the deviate of the probability: the multiple grows
    /// until the likelihood has fallen to its bound.
    #[must_use]
    pub fn predict(&self, nominal: f64, boundary: &PairBoundary) -> Prediction {
        let Self { likelihood, best, level, .. } = self;
        let both = |y: &[f64]| likelihood.model.probabilities(&likelihood.values(y), nominal, boundary);
        let of = |y: &[f64]| both(y)[0];
        let deviate = |y: &[f64]| match both(y) {
            [squeal, none] if squeal > 0.5 => -normal::quantile(none.max(LEAST)),
            [squeal, _] => normal::quantile(squeal.max(LEAST)),
        };
        let probability = of(&best.place);
        let (gradient, _) = slopes(&deviate, &best.place, deviate(&best.place));
        let [low, high] = [-1.0, 1.0].map(|direction| {
            let mut last = probability;
            let [mut first, greatest] = WEIGHTS;
            let mut found = (first, best.place.clone());
            if let Some(step) = best.step(&gradient, *level) {
                first = (level * level / product(&step, &gradient)).min(greatest);
                found = (first, best.place.iter().zip(&step).map(|(place, step)| place + direction * step).collect());
            }
            let mut inverse = best.inverse.clone();
            let weighted = |weight: f64| {
                let objective = |y: &[f64]| likelihood.logarithm(y) + direction * weight * deviate(y);
                let start = along(&best.place, &found.1, weight / found.0);
                let Maximum { place, inverse: next, .. } = maximum(&objective, &start, Some(&inverse));
                inverse = next;
                last = of(&place);
                let depth = best.depth(likelihood.logarithm(&place));
                found = (weight, place);
                (depth, last)
            };
            reached(*level, first, greatest, weighted).unwrap_or(last)
        });
        Prediction { probability, low: low.min(probability), high: high.max(probability) }
    }
}

#[cfg(test)]
mod tests;
