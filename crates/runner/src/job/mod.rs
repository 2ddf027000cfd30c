//! Job specs: what a user writes, checked and made into what the engine runs.

pub mod keys;

mod diagnosis;

mod measured;

mod distribution_spec;

mod random_spec;

mod sampling_spec;

mod axes_spec;

mod limit_spec;

mod target_spec;

mod limit_request;

mod syntax;

mod spec;

mod reading;

mod scatter;

mod random;

pub mod reduction;

mod model;

mod axes;

pub mod models;

mod sampling_key;

mod sampling_numbers;

mod needs;

mod method;

mod methods;

mod sampling_checks;

mod sampling;

mod validated;

mod limit_axis;

mod limit;

mod operating_point;

mod validation;

mod normalised;

mod identity;

mod source;

#[cfg(test)]
mod mutations;

pub use limit::LimitMethod;
pub use limit_axis::LimitAxis;
pub use limit_request::LimitRequest;
pub use method::{Answer, Computed, MapUse, Sampling};
pub use model::OutsidePhysics;
pub use models::matrices::terms::{with_full_matrices, with_reduced_matrices};
pub use models::pad_on_disc::keys::unknown_parameter;
pub use models::pad_on_disc::{friction, measured_friction, plausibility};
pub use models::schema;
pub use models::start_spec::StartKind;
pub use sampling_numbers::Effort;
pub use sampling_spec::Audit;
pub use source::{JobSource, Overrides};
pub use validated::Job;
