//! Drawing samples: the standard normal deviates of a sample are a pure function of seed, cell and sample number.

pub mod identity;

pub(crate) mod sobol;

pub mod deviates;

pub mod beyond;
