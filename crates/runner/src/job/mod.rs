//! Job specs: what a user writes, checked and made into what the engine runs.

mod keys;

mod diagnosis;

mod start_value;

mod measured;

mod overrides;

pub mod friction;

mod criterion_spec;

mod distribution_spec;

mod random_spec;

mod sampling_spec;

mod axes_spec;

mod spec;

mod syntax;

mod reading;

pub mod plausibility;

mod axes;

mod random_input;

mod scatter;

mod start;

mod criterion;

mod random;

mod model;

mod sampling;

mod sampling_checks;

mod validated;

mod validation;

mod normalised;

mod identity;

mod source;

pub use criterion::Criterion;
pub use criterion_spec::{OutsidePhysics, StartKind};
pub use identity::IDENTITY_VERSION;
pub use keys::unknown_parameter;
pub use random_input::{RandomInput, value_in_cell};
pub use sampling::Effort;
pub use sampling_spec::{Audit, EvaluateMode, SamplingMethod};
pub use source::{JobSource, Overrides};
pub use spec::JobSpec;
pub use start_value::StartValue;
pub use validated::Job;
