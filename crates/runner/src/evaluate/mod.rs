//! Samples evaluated: their inputs drawn, their verdicts found, looked up or simulated.

pub mod parts;

pub mod samples;

pub mod criteria;

pub mod maps;

pub mod sums;

pub mod unit;

pub mod evaluator;

pub mod tiles;

pub mod integral;
