//! Statistics of the stability of a brake: which cells a job has, which deviates each sample receives, and what the
//! counted verdicts say of a probability.
//!
//! A job is a grid of [`Cell`]s, each an expected preload and static friction coefficient with relative standard
//! deviations, at one rotating speed. Sample `j` of a cell is a pure function of the seed, the cell, `j` and
//! [`RESULTS_VERSION`] ([`identity`]); its verdict comes from `stickslip-core`. Verdicts are counted in integers
//! and turned into an [`Estimate`] ([`interval`]); where the boundary is known in closed form, [`exact`] gives
//! the probability itself.
//!
//! Modules are declared in reading order. Nothing here knows of threads, files or the terminal.

// Tests compare with formulas as a textbook writes them.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod grid;

pub mod identity;

pub mod inputs;

pub mod samples;

pub mod sobol;

pub mod normal;

pub mod poisson;

pub mod beta;

pub mod interval;

pub mod sequential;

pub mod difference;

pub mod distribution;

pub mod exact;

pub use difference::{Difference, PairedCounts};
pub use distribution::Distribution;
pub use grid::{Axis, AxisError, Cell, Grid, RelativeStd};
pub use identity::{BLOCK_SAMPLES, Purpose, RESULTS_VERSION};
pub use inputs::{Correlation, CorrelationError, Marginal, MarginalError};
pub use interval::{BinomialInterval, Estimate, IntervalKind, WilsonInterval};
pub use samples::{SampleStream, Samples};
pub use sequential::Looks;
pub use sobol::{ScrambledSobol, SobolCursor};
