//! What any model is, and what it may be able to do beyond that.
//!
//! A [`Model`] names its [quantities](quantity::Quantity) in one list, in which they are known by their places. Given
//! the expected values of all of them it prepares a [`Configuration`], what samples share, and that returns
//! [decisions](decision::Decision) on columns of values of the quantities that differ from sample to sample. Nobody
//! else needs to know what the model is of.
//!
//! What only some models can do are capabilities, each a small trait that a model or a configuration has or has not:
//!
//! | capability | trait | what it is for |
//! |---|---|---|
//! | the boundary of stability in two quantities in closed form | [`ClosedForm`] | integrals in place of samples, critical values |
//! | critical values of one quantity | [`CriticalValues`] | integrals over it, limits |
//! | decisions by simulation, many at once, interruptible | [`Simulation`] | samples that cost much |
//! | growth rate and limit cycle | [`Behaviours`] | what a cell with exactly the expected values does |
//! | a limit state of samples | [`Configuration::limit_states`] | rare events by design points |
//! | frequencies of unstable samples | [`Configuration::unstable_frequencies`] | which modes make the probability |
//! | a map of verdicts over two quantities | [`Configuration::map_origin`] | samples that are looked up, integrals |
//! | continuous results beside the verdict | [`Model::recorded`] | distributions of them |
//!
//! A model of a few lines, whose samples are unstable beyond a threshold:
//!
//! ```
//! use stickslip_core::model::decision::Decision;
//! use stickslip_core::model::quantity::Quantity;
//! use stickslip_core::model::verdict::Verdict;
//! use stickslip_core::model::{Columns, Configuration, IsStopped, Model, ModelError};
//!
//! #[derive(Debug)]
//! struct Threshold([Quantity; 2]);
//!
//! impl Model for Threshold {
//!     fn quantities(&self) -> &[Quantity] {
//!         &self.0
//!     }
//!     fn configure(
//!         &self,
//!         expected: &[f64],
//!         varying: &[usize],
//!         _: Option<&dyn Configuration>,
//!     ) -> Result<Box<dyn Configuration>, ModelError> {
//!         Ok(Box::new(Shared { expected: expected.to_vec(), varying: varying.to_vec() }))
//!     }
//! }
//!
//! struct Shared {
//!     expected: Vec<f64>,
//!     varying: Vec<usize>,
//! }
//!
//! impl Configuration for Shared {
//!     fn decide(&self, samples: &Columns<'_>, wanted: &[usize], _: IsStopped<'_>) -> Option<Vec<Decision>> {
//!         let verdict = |&sample: &usize| {
//!             let [load, strength] = samples.complete(sample, &self.expected, &self.varying)[..] else { unreachable!() };
//!             if load > strength { Verdict::Unstable } else { Verdict::Stable }
//!         };
//!         Some(wanted.iter().map(verdict).map(Decision::from).collect())
//!     }
//! }
//!
//! let model = Threshold([Quantity::new("load", "N", "load"), Quantity::new("strength", "N", "strength")]);
//! let shared = model.configure(&[1.0, 1.5], &[0], None)?;
//! let decisions = shared.decide(&Columns::new(2, &[&[1.4, 1.6]]), &[0, 1], &|| false);
//! assert_eq!(decisions.unwrap()[1].verdict, Verdict::Unstable);
//! # Ok::<(), ModelError>(())
//! ```

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use thiserror::Error;

use self::behaviour::Behaviours;
use self::critical_values::CriticalValues;
use self::decision::{Decision, Source};
use self::pair_boundary::PairBoundary;
use self::quantity::{Quantity, Role};
use self::recorded::RecordedResult;
use self::verdict::VerdictCounts;

pub mod verdict;

pub mod recorded;

pub mod decision;

pub mod quantity;

pub mod pair_boundary;

pub mod critical_values;

pub mod behaviour;

/// Whether to stop. It is asked often.
pub type IsStopped<'a> = &'a dyn Fn() -> bool;

/// Why there is no such model, or no such configuration of it.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct ModelError(pub String);

/// A model, with the criterion that decides its samples.
pub trait Model: fmt::Debug + Send + Sync {
    /// Its quantities, in the order in which random inputs are drawn. Elsewhere they are known by their places here.
    fn quantities(&self) -> &[Quantity];

    /// Prepares what samples share that have these expected values of all quantities and differ in the `varying` ones:
    /// first all of [`Role::Input`], then others. What does not differ from `like`, a configuration of the same model
    /// and varying quantities, is not computed again.
    ///
    /// # Errors
    /// If there is no such configuration: a value is not admissible, or values contradict each other.
    fn configure(
        &self,
        expected: &[f64],
        varying: &[usize],
        like: Option<&dyn Configuration>,
    ) -> Result<Box<dyn Configuration>, ModelError>;

    /// What may feed an unstable motion, if decisions name it; unstable samples whose decision names none are counted
    /// with the first.
    fn sources(&self) -> &'static [Source] {
        &[]
    }

    /// Which samples lie outside the model, in a few words.
    fn outside_meaning(&self) -> &'static str {
        "values without a meaning"
    }

    /// What the motion of a stable and of an unstable sample is called.
    fn verdict_names(&self) -> [&'static str; 2] {
        ["stable", "unstable"]
    }

    /// What recorded lengths are over, in m, with these expected values of all quantities; `None` if there are none.
    fn length_scale(&self, expected: &[f64]) -> Option<f64> {
        let _ = expected;
        None
    }

    /// What single configurations do, if that is known without samples.
    fn behaviours(&self) -> Option<Behaviours<'_>> {
        None
    }

    /// On what part of the model the growth rate and the limit cycle of [`Model::behaviours`] are found, as " on a rigid
    /// disc"; nothing if it is the whole.
    fn behaviours_on(&self) -> [&'static str; 2] {
        [""; 2]
    }

    /// What decisions have beside the verdict, [`MOST_RECORDED`](recorded::MOST_RECORDED) at most.
    fn recorded(&self) -> &[RecordedResult] {
        &[]
    }

    /// Whether a sample takes so long, from about 100 microseconds on, that few of them make a unit of work.
    fn has_slow_samples(&self) -> bool {
        false
    }

    /// Whether a sample takes longer than some 10 milliseconds.
    fn has_very_slow_samples(&self) -> bool {
        false
    }

    /// Whether its configurations have [`ClosedForm`].
    fn has_closed_form(&self) -> bool {
        false
    }

    /// Over which of these random inputs integrals go, as places of quantities, if its configurations have
    /// [`CriticalValues`].
    fn integrated(&self, inputs: &[usize]) -> Option<usize> {
        let _ = inputs;
        None
    }

    /// Its simulation, if it decides by one.
    fn simulation(&self) -> Option<&dyn Simulation> {
        None
    }

    /// The quantities of [`Role::Input`], if there are two.
    fn pair(&self) -> Option<[usize; 2]> {
        let inputs = self.quantities().iter().enumerate().filter(|(_, quantity)| quantity.role == Role::Input);
        <[usize; 2]>::try_from(inputs.map(|(place, _)| place).collect::<Vec<_>>()).ok()
    }

    /// The place of a quantity by its name, or by its path in the tables of the model.
    fn place(&self, name: &str) -> Option<usize> {
        self.quantities().iter().position(|quantity| quantity.name == name || quantity.path == name)
    }
}

/// The values of samples, one column for each quantity that varies.
#[derive(Debug, Clone, Copy)]
pub struct Columns<'a> {
    len: usize,
    columns: &'a [&'a [f64]],
}

impl<'a> Columns<'a> {
    /// Columns of so many samples.
    ///
    /// # Panics
    /// If a column has another length.
    #[must_use]
    pub fn new(len: usize, columns: &'a [&'a [f64]]) -> Self {
        assert!(columns.iter().all(|column| column.len() == len), "one value for each sample");
        Self { len, columns }
    }

    /// The number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The values of the varying quantity at `place` among these.
    #[must_use]
    pub fn column(&self, place: usize) -> &'a [f64] {
        self.columns[place]
    }

    /// All columns.
    #[must_use]
    pub fn columns(&self) -> &'a [&'a [f64]] {
        self.columns
    }

    /// The values of one sample.
    pub fn sample(&self, sample: usize) -> impl Iterator<Item = f64> + use<'a> {
        self.columns.iter().map(move |column| column[sample])
    }

    /// The values of all quantities in one sample: expected ones but for those that vary.
    #[must_use]
    pub fn complete(&self, sample: usize, expected: &[f64], varying: &[usize]) -> Vec<f64> {
        let mut values = expected.to_vec();
        varying.iter().zip(self.sample(sample)).for_each(|(&place, value)| values[place] = value);
        values
    }
}

/// What samples of a model share, prepared.
pub trait Configuration: Any + Send + Sync {
    /// Decides the samples that are `wanted`, by their places in the columns; `None` if it is stopped before all are
    /// decided.
    fn decide(&self, samples: &Columns<'_>, wanted: &[usize], is_stopped: IsStopped<'_>) -> Option<Vec<Decision>>;

    /// Which samples lie outside the model: it decides them as stable by definition, not by its equations. None where
    /// it has no such samples.
    fn outside(&self, samples: &Columns<'_>) -> Option<Vec<bool>> {
        let _ = samples;
        None
    }

    /// How many samples lie outside the model.
    fn count_outside(&self, samples: &Columns<'_>) -> u64 {
        self.outside(samples).map_or(0, |outside| outside.iter().filter(|is_outside| **is_outside).count() as u64)
    }

    /// Values of the quantities of [`Role::Input`] that are moved to the edge of the model where they lie outside.
    fn clamped(&self, samples: &Columns<'_>) -> Option<[Vec<f64>; 2]> {
        let _ = samples;
        None
    }

    /// The second quantity of the pair at which a map of verdicts over both begins: less of it is stable, whatever the
    /// first. `None` if the verdicts of this model make no such map.
    fn map_origin(&self) -> Option<f64> {
        None
    }

    /// Its boundary of stability, if it is known in closed form.
    fn closed_form(&self) -> Option<&dyn ClosedForm> {
        None
    }

    /// Its critical values, if they can be found.
    fn critical_values(&self) -> Option<&dyn CriticalValues> {
        None
    }

    /// Limit states of samples: a function of what varies that is below zero where a sample is unstable, continuous with a
    /// gradient nearly everywhere within the model. Not a number for samples that have none; `None` if it is known of no sample. Unless a
    /// model says more, that of its closed form.
    fn limit_states(&self, samples: &Columns<'_>) -> Option<Vec<f64>> {
        let form = self.closed_form()?;
        let of_sample = |sample: usize| {
            let values: Vec<f64> = samples.sample(sample).collect();
            form.boundary_of(&values).map_or(f64::NAN, |boundary| boundary.limit_state(values[0], values[1]))
        };
        Some((0..samples.len()).map(of_sample).collect())
    }

    /// How many limit states samples have beside that one, each below zero only where a sample is unstable, as those of single
    /// modes.
    fn limit_branches(&self) -> usize {
        0
    }

    /// All of these of each sample, which are found together: not a number where one has none. `None` if there are none.
    fn branch_limit_states(&self, samples: &Columns<'_>) -> Option<Vec<Vec<f64>>> {
        let _ = samples;
        None
    }

    /// The frequency in Hz of the least damped unstable mode of each sample, not a number for samples that are stable;
    /// `None` if frequencies are not known.
    fn unstable_frequencies(&self, samples: &Columns<'_>) -> Option<Vec<f64>> {
        let _ = samples;
        None
    }
}

/// The boundary of stability in the two quantities of [`Role::Input`], in closed form. It does not depend on their values.
pub trait ClosedForm {
    /// The boundary with the expected values of what else varies.
    fn boundary(&self) -> PairBoundary;

    /// The boundary of a sample with these values of the varying quantities; `None` if one is not admissible.
    fn boundary_of(&self, values: &[f64]) -> Option<PairBoundary>;

    /// The verdicts on samples, counted.
    fn count(&self, samples: &Columns<'_>) -> VerdictCounts;
}

/// A model that decides by simulation. Samples of many configurations share the simulation.
pub trait Simulation {
    /// A configuration that is not prepared, for samples that are queued beside a prepared one.
    ///
    /// # Errors
    /// As [`Model::configure`].
    fn outline(&self, expected: &[f64], varying: &[usize]) -> Result<Box<dyn Configuration>, ModelError>;

    /// Decides the samples of a queue, until there are no more, or until the queue stops.
    fn run<'q>(&self, queue: &mut dyn SampleQueue<'q>);
}

/// A sample to simulate.
pub struct QueuedSample<'q> {
    /// What the decision is returned with.
    pub ticket: u64,
    /// The prepared configuration, its own or one like it.
    pub configuration: &'q dyn Configuration,
    /// Its own configuration, not prepared, if the other is not.
    pub outline: Option<Arc<dyn Configuration>>,
}

/// Samples to simulate, in any order and from any cells and units of work.
pub trait SampleQueue<'q> {
    /// The next sample, and in `values`, in place of what they hold, its values of the varying quantities; `None` if
    /// there are no more.
    fn next(&mut self, values: &mut Vec<f64>) -> Option<QueuedSample<'q>>;

    /// Receives the decision on the sample with this ticket. Samples are decided in any order.
    fn decided(&mut self, ticket: u64, decision: Decision);

    /// Whether to stop: samples that are not decided are dropped. It is asked about once a millisecond.
    fn is_stopped(&self) -> bool {
        false
    }
}
