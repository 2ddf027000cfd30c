//! Job specs: what a user writes, checked and made into what the engine runs.

mod start_value;

pub mod preload_force;

mod keys;

mod diagnosis;

mod measured;

mod overrides;

pub mod friction;

mod imprecise_schema;

mod criterion_spec;

mod distribution_spec;

mod random_spec;

mod sampling_spec;

mod axes_spec;

mod engine;

mod limit_spec;

mod limit_request;

mod spec;

mod syntax;

mod reading;

mod imprecise_values;

mod random_input;

mod scatter;

mod random;

pub mod plausibility;

mod axes;

mod start;

mod criterion;

mod model;

mod sampling;

mod sampling_checks;

mod validated;

mod limit_axis;

mod limit;

mod validation;

mod imprecise;

mod normalised;

mod identity;

mod source;

#[cfg(test)]
mod mutations;

pub use criterion::Criterion;
pub use criterion_spec::{OutsidePhysics, StartKind};
pub use engine::{EngineSettings, MOST_CPUS, MOST_SHARDS, Memory, SbatchOption, SlurmName, TimeLimit};
pub use identity::IDENTITY_VERSION;
pub use imprecise::{Combination, ImpreciseJob, ImpreciseQuantity};
pub use imprecise_values::{Values, What};
pub use keys::{axis_of, unknown_parameter};
pub use limit::LimitMethod;
pub use limit_axis::LimitAxis;
pub use measured::{read_csv, unreadable};
pub use random_input::RandomInput;
pub use sampling::Effort;
pub use sampling_spec::{Audit, EvaluateMode, SamplingMethod};
pub use source::{JobSource, Overrides};
pub use spec::JobSpec;
pub use start_value::StartValue;
pub use validated::Job;
