//! Oscillators on a belt as pads on a disc.

use std::any::Any;
use std::sync::Arc;

use crate::model::decision::Decision;
use crate::model::pair_boundary::PairBoundary;
use crate::model::verdict::VerdictCounts;
use crate::model::{ClosedForm, Columns, Configuration, IsStopped, QueuedSample, SampleQueue};

/// A configuration of the oscillator: that of the pad which moves in the same way.
pub(super) struct OnBelt {
    pub(super) pad: Arc<dyn Configuration>,
    /// For each varying quantity of the pad, the column that it follows, with its factor.
    pub(super) columns: Vec<(usize, f64)>,
}

impl OnBelt {
    pub(super) fn from_any(configuration: &dyn Configuration) -> Option<&Self> {
        let any: &dyn Any = configuration;
        any.downcast_ref()
    }

    /// Hands samples over as those of the pad.
    fn with_columns<T>(&self, samples: &Columns<'_>, then: impl FnOnce(&dyn Configuration, &Columns<'_>) -> T) -> T {
        let scaled = |&(column, factor): &(usize, f64)| -> Vec<f64> {
            if factor == 1.0 {
                return Vec::new();
            }
            samples.column(column).iter().map(|value| factor * value).collect()
        };
        let scaled: Vec<Vec<f64>> = self.columns.iter().map(scaled).collect();
        let mut columns: Vec<&[f64]> = Vec::with_capacity(self.columns.len());
        for (&(column, factor), scaled) in self.columns.iter().zip(&scaled) {
            columns.push(if factor == 1.0 { samples.column(column) } else { scaled });
        }
        then(&*self.pad, &Columns::new(samples.len(), &columns))
    }

    fn values(&self, values: &[f64]) -> impl Iterator<Item = f64> {
        self.columns.iter().map(|(column, factor)| factor * values[*column])
    }
}

impl Configuration for OnBelt {
    fn decide(&self, samples: &Columns<'_>, wanted: &[usize], is_stopped: IsStopped<'_>) -> Option<Vec<Decision>> {
        self.with_columns(samples, |pad, samples| pad.decide(samples, wanted, is_stopped))
    }

    fn outside(&self, samples: &Columns<'_>) -> Option<Vec<bool>> {
        self.with_columns(samples, Configuration::outside)
    }

    fn count_outside(&self, samples: &Columns<'_>) -> u64 {
        self.with_columns(samples, Configuration::count_outside)
    }

    fn clamped(&self, samples: &Columns<'_>) -> Option<[Vec<f64>; 2]> {
        self.with_columns(samples, Configuration::clamped)
    }

    fn map_origin(&self) -> Option<f64> {
        self.pad.map_origin()
    }

    fn closed_form(&self) -> Option<&dyn ClosedForm> {
        self.pad.closed_form().is_some().then_some(self)
    }
}

impl ClosedForm for OnBelt {
    fn boundary(&self) -> PairBoundary {
        // It was asked for a closed form, which the pad has.
        self.pad.closed_form().map_or(NEVER, ClosedForm::boundary)
    }

    fn boundary_of(&self, values: &[f64]) -> Option<PairBoundary> {
        self.pad.closed_form()?.boundary_of(&self.values(values).collect::<Vec<_>>())
    }

    fn count(&self, samples: &Columns<'_>) -> VerdictCounts {
        let count =
            |pad: &dyn Configuration, samples: &Columns<'_>| pad.closed_form().map(|closed| closed.count(samples));
        self.with_columns(samples, count).unwrap_or_default()
    }
}

/// A boundary beyond which nothing is unstable.
const NEVER: PairBoundary =
    PairBoundary { critical_product: f64::INFINITY, by_second: 1.0, offset: 0.0, least_second: 0.0 };

/// The samples of a queue of oscillators as those of pads.
pub(super) struct Queue<'s, 'q> {
    samples: &'s mut dyn SampleQueue<'q>,
    /// The values of the sample taken last.
    values: Vec<f64>,
}

impl<'s, 'q> Queue<'s, 'q> {
    pub(super) fn new(samples: &'s mut dyn SampleQueue<'q>) -> Self {
        Self { samples, values: Vec::new() }
    }
}

impl<'q> SampleQueue<'q> for Queue<'_, 'q> {
    fn next(&mut self, values: &mut Vec<f64>) -> Option<QueuedSample<'q>> {
        loop {
            let QueuedSample { ticket, configuration, outline } = self.samples.next(&mut self.values)?;
            let outline = outline.as_deref().and_then(OnBelt::from_any).map(|own| own.pad.clone());
            match OnBelt::from_any(configuration) {
                Some(own) => {
                    values.clear();
                    values.extend(own.values(&self.values));
                    return Some(QueuedSample { ticket, configuration: &*own.pad, outline });
                }
                None => self.samples.decided(ticket, Decision::FAILED),
            }
        }
    }

    fn decided(&mut self, ticket: u64, decision: Decision) {
        self.samples.decided(ticket, decision);
    }

    fn is_stopped(&self) -> bool {
        self.samples.is_stopped()
    }
}
