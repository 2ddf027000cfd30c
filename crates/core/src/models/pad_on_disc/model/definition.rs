//! The parameters of a pad on a disc together with its criterion.

use crate::model::ModelError;
use crate::model::quantity::Quantity;
use crate::model::recorded::{RecordedOf, RecordedResult};
use crate::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use crate::models::pad_on_disc::criterion::time_domain::DiscModel;
use crate::models::pad_on_disc::motion::start::{GivenStart, Start};
use crate::models::pad_on_disc::motion::start_value::StartValue;
use crate::models::pad_on_disc::parameters::{Parameters, Scalar};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

use super::linear_results::{LinearRecord, LinearResult};
use super::quantities::{
    PRELOAD, PRELOAD_KEY, STATIC_FRICTION, STATIC_FRICTION_KEY, configuration_scalars, error, first_of_start,
    quantities,
};

/// The amplitude that is recorded of motions.
pub const AMPLITUDE: RecordedResult = RecordedResult {
    name: "amplitude",
    unit: "1",
    noun: "settled amplitude",
    meaning: "half peak to peak of x over disc thickness",
    of: RecordedOf::Unstable,
    is_length: true,
    has_mean: true,
};

/// What decides whether a sample is stable.
#[derive(Debug, Clone)]
pub enum Criterion {
    /// Closed form on a rigid disc.
    Eigenvalue {
        /// What is recorded of samples.
        record: LinearRecord,
    },
    /// Eigenvalues of pad and flexible disc.
    CoupledEigenvalue {
        /// Disc modes that are kept.
        modes: usize,
        /// What is recorded of samples: the growth rate, or nothing.
        record: LinearRecord,
    },
    /// The motion itself.
    TimeDomain {
        /// The disc.
        disc: DiscModel,
        /// How it is simulated.
        settings: TimeDomainSettings,
    },
}

impl Criterion {
    /// Disc modes that are kept, on a flexible disc.
    #[must_use]
    pub fn modes(&self) -> Option<usize> {
        match self {
            Self::Eigenvalue { .. } | Self::TimeDomain { disc: DiscModel::Rigid, .. } => None,
            Self::CoupledEigenvalue { modes, .. } | Self::TimeDomain { disc: DiscModel::Flexible { modes }, .. } => {
                Some(*modes)
            }
        }
    }

    /// What is recorded of samples that are decided by linear stability.
    #[must_use]
    pub fn linear_record(&self) -> LinearRecord {
        match self {
            Self::Eigenvalue { record } | Self::CoupledEigenvalue { record, .. } => *record,
            Self::TimeDomain { .. } => LinearRecord::default(),
        }
    }

    fn recorded(&self) -> Vec<RecordedResult> {
        match self {
            Self::TimeDomain { settings, .. } => settings.record_amplitude.then_some(AMPLITUDE).into_iter().collect(),
            _ => self.linear_record().results().map(LinearResult::described).collect(),
        }
    }

    /// The start in numbers, if it is given so.
    #[must_use]
    pub fn given_start(&self) -> Option<GivenStart> {
        match self {
            Self::TimeDomain { settings: TimeDomainSettings { start: Start::Given(start), .. }, .. } => Some(*start),
            _ => None,
        }
    }
}

/// The pad on the disc with a criterion.
#[derive(Debug, Clone)]
pub struct PadModel {
    parameters: Parameters,
    criterion: Criterion,
    pub(super) quantities: Vec<Quantity>,
    pub(super) recorded: Vec<RecordedResult>,
}

impl PadModel {
    /// A brake with these parameters, of which the expected values of the quantities replace all but the preload and
    /// the static friction coefficient.
    #[must_use]
    pub fn new(parameters: Parameters, criterion: Criterion) -> Self {
        let quantities = quantities(&criterion.given_start().unwrap_or_default());
        let recorded = criterion.recorded();
        Self { parameters, criterion, quantities, recorded }
    }

    /// The parameters, with the values that axes do not have.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// What decides.
    #[must_use]
    pub fn criterion(&self) -> &Criterion {
        &self.criterion
    }

    /// The brake with these expected values of all quantities.
    ///
    /// # Errors
    /// If a value is not admissible, or values contradict each other.
    pub fn brake(&self, expected: &[f64]) -> Result<PadOnDisc, ModelError> {
        let mut parameters = self.parameters.clone();
        let given = configuration_scalars().zip(&expected[2..]).filter(|(_, value)| !value.is_nan());
        for (scalar, &value) in given {
            parameters.set(scalar.key, value).map_err(error)?;
        }
        PadOnDisc::new(parameters).map_err(error)
    }

    /// The same with these values of the preload and the static friction coefficient, too.
    ///
    /// # Errors
    /// As [`PadModel::brake`].
    pub fn complete_brake(&self, expected: &[f64]) -> Result<PadOnDisc, ModelError> {
        let mut parameters = self.brake(expected)?.parameters().clone();
        parameters.set(PRELOAD_KEY, expected[PRELOAD]).map_err(error)?;
        parameters.set(STATIC_FRICTION_KEY, expected[STATIC_FRICTION]).map_err(error)?;
        PadOnDisc::new(parameters).map_err(error)
    }

    /// The start with these expected values of all quantities, if it is given in numbers.
    #[must_use]
    pub fn given_start(&self, expected: &[f64]) -> Option<GivenStart> {
        let mut start = self.criterion.given_start()?;
        for (number, &value) in StartValue::ALL.into_iter().zip(&expected[first_of_start()..]) {
            if !value.is_nan() {
                number.set(&mut start, value);
            }
        }
        Some(start)
    }

    /// The expected values of all quantities, where nothing else is said: those of the parameters and of the start. What
    /// is not given has none (NaN): it follows from the others.
    #[must_use]
    pub fn expected(&self) -> Vec<f64> {
        let friction = &self.parameters.friction;
        let start = self.criterion.given_start().unwrap_or_default();
        let value = |scalar: &Scalar| {
            if scalar.is_given(&self.parameters) { scalar.value(&self.parameters) } else { f64::NAN }
        };
        [self.parameters.operating_point.preload, friction.static_coefficient]
            .into_iter()
            .chain(configuration_scalars().map(value))
            .chain(StartValue::ALL.map(|number| number.value_in(&start).unwrap_or(f64::NAN)))
            .collect()
    }
}
