//! Scheduling: which work is missing, its division into units, and the one parallel loop that does it.

pub mod progress;

pub mod plan;

pub mod engine;

pub mod mapping;
