//! Job specs: what a user writes, checked and made into what the engine runs.

mod diagnosis;
mod spec;
mod validated;

mod normalised;
mod source;

pub use source::{JobSource, Overrides};
pub use spec::JobSpec;
pub use validated::{Job, unknown_parameter};
