//! The probability of a cell as a function of its imprecise inputs.

use stickslip_core::model::IsStopped;
use stickslip_core::model::ModelError;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_sampler::imprecise::bounds::{Family, Quantity, Role};
use stickslip_sampler::integrate::NormalPair;
use stickslip_sampler::integrate::closed_form::ExactProbability;

use crate::evaluate::open_cell::{Open, OpenCell};
use crate::evaluate::open_input::OpenInput;
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
        Ok(Self { integral, open, intervals, is_stopped })
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
            Integral::Pair { cell, .. } => cell.probability(at).map_err(Ended::NoSuchConfiguration),
            Integral::Input(input) => input.probability(&self.open, at).ok_or(Ended::NoCriticalValues(input.place())),
        }
    }

    fn normal_pair(&self, at: &[f64]) -> Result<Option<(PairBoundary, NormalPair)>, Ended> {
        self.go_on()?;
        let Integral::Pair { cell, .. } = &self.integral else { return Ok(None) };
        let precise = cell.at(at).map_err(Ended::NoSuchConfiguration)?;
        Ok(precise.correlation.is_none().then_some((precise.boundary, precise.pair)))
    }
}
