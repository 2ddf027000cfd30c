//! Which work is open, its division into units, and the one parallel loop that does it.

pub mod engine;
pub mod mapping;
pub mod plan;
pub mod progress;
pub mod slots;
