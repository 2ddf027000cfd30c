//! Job specs: what a user writes, checked and made into what the engine runs.

mod diagnosis;
mod spec;

mod distribution;
mod measured;
mod scatter;

mod criterion;
mod random;
mod sampling;
mod sampling_spec;
mod validated;

mod normalised;
mod source;

pub use criterion::Criterion;
pub use random::RandomInput;
pub use sampling::Effort;
pub use sampling_spec::{Audit, EvaluateMode, SamplingMethod};
pub use source::{JobSource, Overrides};
pub use spec::{JobSpec, StartKind};
pub use validated::{Job, unknown_parameter};
