//! Job specs: what a user writes, checked and made into what the engine runs.

mod diagnosis;
mod spec;
mod validated;

pub use spec::JobSpec;
pub use validated::{Job, JobSource, Overrides, unknown_parameter};
