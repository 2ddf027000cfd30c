//! The probability of a cell as a function of its imprecise inputs.

use stickslip_core::model::IsStopped;
use stickslip_core::model::ModelError;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_sampler::imprecise::bounds::{Bounds, Family, Quantity, Role, bounds};
use stickslip_sampler::imprecise::result::{Direction, Evidence, Extreme, Trend};
use stickslip_sampler::integrate::NormalPair;
use stickslip_sampler::integrate::closed_form::ExactProbability;

use crate::evaluate::open_cell::{Open, OpenCell};
use crate::evaluate::open_input::OpenInput;
use crate::evaluate::remembered_intervals::RememberedIntervals;
use crate::evaluate::remembering::{Asked, Keeper, Key, is_probability};
use crate::job::{ImpreciseQuantity, Job, Values, What};

/// Why there is no probability.
#[derive(Debug)]
pub enum Ended {
    /// The search was stopped.
    Stopped,
    /// There is no such configuration.
    NoSuchConfiguration(ModelError),
    /// The critical values of the quantity at this place cannot be found.
    NoCriticalValues(usize),
}

/// A cell of a job with some quantities known as intervals.
pub struct ImpreciseCell<'a> {
    integral: Integral<'a>,
    open: Vec<Open>,
    /// The ends of the intervals, each with its place among all that is imprecise.
    intervals: Vec<(usize, [f64; 2])>,
    is_stopped: IsStopped<'a>,
    /// Its probabilities.
    asked: Asked<'a>,
}

/// The bounds of a cell that is made with its probabilities, and the places of its quantities. Both are kept, if there is a
/// keeper: in the searches with twice this number, and one more.
///
/// # Errors
/// See [`Ended`].
pub fn kept_bounds<'a>(
    keeper: Option<&'a dyn Keeper>,
    (cell, number): Key,
    imprecise: impl FnOnce(Asked<'a>) -> Result<ImpreciseCell<'a>, Ended>,
) -> Result<(Bounds, Vec<usize>), Ended> {
    let imprecise = imprecise(Asked::new(keeper, (cell, 2 * number)))?;
    let quantities = imprecise.quantities();
    let asked = Asked::new(keeper, (cell, 2 * number + 1));
    let numbers = NUMBERS + NUMBERS_EACH * quantities.len();
    let found = asked.ask(numbers, read_bounds, written_bounds, || bounds(&imprecise, &quantities))?;
    Ok((found, imprecise.places()))
}

/// Numbers that bounds are kept as: in all, and further ones for each quantity.
const NUMBERS: usize = 9;
const NUMBERS_EACH: usize = 3;

const EVIDENCE: [Evidence; 3] = [Evidence::Proved, Evidence::Checked, Evidence::Searched];
const DIRECTIONS: [Direction; 4] = [Direction::Rises, Direction::Falls, Direction::Turns, Direction::Constant];

/// Bounds as numbers.
fn written_bounds(found: &Bounds) -> Vec<f64> {
    let place = |is_it: Option<usize>| is_it.map_or(f64::NAN, |place| place as f64);
    let mut numbers = vec![found.evaluations as f64];
    for (extreme, evidence) in found.extremes.iter().zip(found.evidence) {
        let ExactProbability { value, error_bound } = extreme.probability;
        numbers.extend([value, error_bound, extreme.bound.unwrap_or(f64::NAN)]);
        numbers.push(place(EVIDENCE.iter().position(|other| *other == evidence)));
        numbers.extend(&extreme.at);
    }
    for Trend { direction, is_proved } in &found.trends {
        let direction = DIRECTIONS.iter().position(|other| other == direction);
        numbers.push(place(direction.map(|direction| 2 * direction + usize::from(*is_proved))));
    }
    numbers
}

/// Bounds from numbers, if they can be some.
fn read_bounds(numbers: &[f64]) -> Option<Bounds> {
    let count = (numbers.len() - NUMBERS) / NUMBERS_EACH;
    let (&evaluations, rest) = numbers.split_first()?;
    let (ends, trends) = rest.split_at(rest.len() - count);
    let end = |numbers: &[f64]| {
        let (&[value, error_bound, bound, evidence], at) = numbers.split_first_chunk::<4>()?;
        let bound = Some(bound).filter(|bound| !bound.is_nan());
        let is_sound = is_probability(value) && error_bound >= 0.0 && at.iter().all(|at| at.is_finite());
        let probability = ExactProbability { value, error_bound };
        let extreme = is_sound.then(|| Extreme { at: at.to_vec(), probability, bound })?;
        Some((extreme, *EVIDENCE.get(index(evidence)?)?))
    };
    let (low, high) = ends.split_at(ends.len() / 2);
    let ((low, of_low), (high, of_high)) = (end(low)?, end(high)?);
    let trend = |&code: &f64| {
        let code = index(code)?;
        Some(Trend { direction: *DIRECTIONS.get(code / 2)?, is_proved: code % 2 == 1 })
    };
    Some(Bounds {
        extremes: [low, high],
        evidence: [of_low, of_high],
        trends: trends.iter().map(trend).collect::<Option<_>>()?,
        evaluations: index(evaluations)? as u64,
    })
}

/// A number that counts something.
fn index(number: f64) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0 && number < 9_007_199_254_740_992.0).then_some(number as usize)
}

/// What the probability is an integral over.
enum Integral<'a> {
    /// The pair of the model. More of the second of it is never stable where less is unstable, if `is_unstable_above`.
    Pair { cell: OpenCell<'a>, pair: Option<[usize; 2]>, is_unstable_above: bool },
    /// The one random input.
    Input(OpenInput<'a>),
}

impl<'a> ImpreciseCell<'a> {
    /// A cell of a job that has the lower ends of all intervals.
    ///
    /// # Errors
    /// If there is no such configuration.
    pub fn new(
        job: &'a Job,
        cell: u64,
        quantities: &'a [ImpreciseQuantity],
        is_stopped: IsStopped<'a>,
        asked: Asked<'a>,
    ) -> Result<Self, Ended> {
        let integrated = job.integrated();
        let pair = job.model().pair();
        let which = |place: Option<usize>| match (integrated, pair) {
            (Some(_), _) => Some(0),
            (None, pair) => pair.and_then(|pair| pair.iter().position(|own| Some(*own) == place)),
        };
        let opened = |what: &What| match what {
            What::Expected(name) => job.model().place(name).map_or(Open::Nothing, Open::Expected),
            What::RelativeStd(name) => which(job.model().place(name)).map_or(Open::Nothing, Open::RelativeStd),
            What::Correlation => Open::Correlation,
            What::Distribution(_) => Open::Nothing,
        };
        let (mut open, mut intervals) = (Vec::new(), Vec::new());
        for (place, quantity) in quantities.iter().enumerate() {
            if let Values::Between(ends) = quantity.values {
                open.push(opened(&quantity.what));
                intervals.push((place, ends));
            }
        }
        let integral = if let Some(input) = integrated {
            let ends: Vec<[f64; 2]> = intervals.iter().map(|(_, ends)| *ends).collect();
            Integral::Input(OpenInput::new(job, cell, input, &open, &ends))
        } else {
            let lower: Vec<f64> = intervals.iter().map(|(_, ends)| ends[0]).collect();
            let cell = OpenCell::new(job, cell, open.clone(), &lower).map_err(Ended::NoSuchConfiguration)?;
            let is_unstable_above = cell.is_unstable_above(&lower).map_err(Ended::NoSuchConfiguration)?;
            Integral::Pair { cell, pair, is_unstable_above }
        };
        Ok(Self { integral, open, intervals, is_stopped, asked })
    }

    /// The places of the intervals among all imprecise quantities.
    pub fn places(&self) -> Vec<usize> {
        self.intervals.iter().map(|(place, _)| *place).collect()
    }

    /// What is known of the quantities that are intervals.
    pub fn quantities(&self) -> Vec<Quantity> {
        let role = |open: &Open| match (*open, &self.integral) {
            (Open::Expected(place), Integral::Pair { pair: Some([first, second]), is_unstable_above, .. }) => {
                let rises = place == *first || place == *second && *is_unstable_above;
                if rises { Role::Rising } else { Role::Unknown }
            }
            (Open::RelativeStd(which), Integral::Pair { .. }) => Role::RelativeStd(which),
            _ => Role::Unknown,
        };
        let quantity =
            |(open, (_, interval)): (&Open, &(usize, [f64; 2]))| Quantity { role: role(open), interval: *interval };
        self.open.iter().zip(&self.intervals).map(quantity).collect()
    }

    fn go_on(&self) -> Result<(), Ended> {
        if (self.is_stopped)() { Err(Ended::Stopped) } else { Ok(()) }
    }
}

impl Family for ImpreciseCell<'_> {
    type Error = Ended;

    fn probability(&self, at: &[f64]) -> Result<ExactProbability, Ended> {
        self.go_on()?;
        match &self.integral {
            Integral::Pair { cell, .. } => {
                self.asked.integral(|| cell.probability(at).map_err(Ended::NoSuchConfiguration))
            }
            Integral::Input(input) => {
                let memory = RememberedIntervals { asked: &self.asked, is_stopped: self.is_stopped };
                let found = input.probability(&self.open, at, &memory);
                self.go_on()?;
                found.ok_or(Ended::NoCriticalValues(input.place()))
            }
        }
    }

    fn normal_pair(&self, at: &[f64]) -> Result<Option<(PairBoundary, NormalPair)>, Ended> {
        self.go_on()?;
        let Integral::Pair { cell, .. } = &self.integral else { return Ok(None) };
        let precise = cell.at(at).map_err(Ended::NoSuchConfiguration)?;
        Ok(precise.correlation.is_none().then_some((precise.boundary, precise.pair)))
    }
}
