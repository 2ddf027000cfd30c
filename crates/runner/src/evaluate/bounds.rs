//! The probability of a cell as a function of its imprecise inputs.

use stickslip_core::model::IsStopped;
use stickslip_core::model::ModelError;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_sampler::imprecise::bounds::{Family, Quantity, Role};
use stickslip_sampler::integrate::NormalPair;
use stickslip_sampler::integrate::closed_form::ExactProbability;

use crate::evaluate::open_cell::{Open, OpenCell};
use crate::job::{ImpreciseQuantity, Job, Values, What};

/// Why there is no probability.
#[derive(Debug)]
pub enum Ended {
    /// The search was stopped.
    Stopped,
    /// There is no such configuration.
    NoSuchConfiguration(ModelError),
}

/// A cell of a job with some quantities known as intervals.
pub struct ImpreciseCell<'a> {
    cell: OpenCell<'a>,
    /// The ends of the intervals, each with its place among all that is imprecise.
    intervals: Vec<(usize, [f64; 2])>,
    /// Whether more of the second quantity is never stable where less is unstable.
    is_unstable_above: bool,
    pair: Option<[usize; 2]>,
    is_stopped: IsStopped<'a>,
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
        let pair = job.model().pair();
        let which = |place: Option<usize>| pair.and_then(|pair| pair.iter().position(|own| Some(*own) == place));
        let open = |what: &What| match what {
            What::Expected(name) => job.model().place(name).map_or(Open::Nothing, Open::Expected),
            What::RelativeStd(name) => which(job.model().place(name)).map_or(Open::Nothing, Open::RelativeStd),
            What::Correlation => Open::Correlation,
            What::Distribution(_) => Open::Nothing,
        };
        let (mut opened, mut intervals) = (Vec::new(), Vec::new());
        for (place, quantity) in quantities.iter().enumerate() {
            if let Values::Between(ends) = quantity.values {
                opened.push(open(&quantity.what));
                intervals.push((place, ends));
            }
        }
        let lower: Vec<f64> = intervals.iter().map(|(_, ends)| ends[0]).collect();
        let cell = OpenCell::new(job, cell, opened, &lower).map_err(Ended::NoSuchConfiguration)?;
        let is_unstable_above = cell.is_unstable_above(&lower).map_err(Ended::NoSuchConfiguration)?;
        Ok(Self { cell, intervals, is_unstable_above, pair, is_stopped })
    }

    /// The places of the intervals among all imprecise quantities.
    pub fn places(&self) -> Vec<usize> {
        self.intervals.iter().map(|(place, _)| *place).collect()
    }

    /// What is known of the quantities that are intervals.
    pub fn quantities(&self) -> Vec<Quantity> {
        let role = |open: &Open| match *open {
            Open::Expected(place) => match self.pair {
                Some([first, _]) if place == first => Role::Rising,
                Some([_, second]) if place == second && self.is_unstable_above => Role::Rising,
                _ => Role::Unknown,
            },
            Open::RelativeStd(which) => Role::RelativeStd(which),
            Open::Correlation | Open::Nothing => Role::Unknown,
        };
        let quantity =
            |(open, (_, interval)): (&Open, &(usize, [f64; 2]))| Quantity { role: role(open), interval: *interval };
        self.cell.open().iter().zip(&self.intervals).map(quantity).collect()
    }

    fn go_on(&self) -> Result<(), Ended> {
        if (self.is_stopped)() { Err(Ended::Stopped) } else { Ok(()) }
    }
}

impl Family for ImpreciseCell<'_> {
    type Error = Ended;

    fn probability(&self, at: &[f64]) -> Result<ExactProbability, Ended> {
        self.go_on()?;
        self.cell.probability(at).map_err(Ended::NoSuchConfiguration)
    }

    fn normal_pair(&self, at: &[f64]) -> Result<Option<(PairBoundary, NormalPair)>, Ended> {
        self.go_on()?;
        let precise = self.cell.at(at).map_err(Ended::NoSuchConfiguration)?;
        Ok(precise.correlation.is_none().then_some((precise.boundary, precise.pair)))
    }
}
