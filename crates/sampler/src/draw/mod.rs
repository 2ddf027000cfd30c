//! The deviates of every sample: a pure function of seed, cell and index.

pub mod identity;

pub mod sobol;

pub mod deviates;
