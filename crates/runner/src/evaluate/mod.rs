//! Samples evaluated: their inputs drawn, their verdicts found, looked up or simulated.

pub mod batch;
pub mod extras;
