//! Statistics of the stability of a brake: which cells a job has, which deviates each sample receives, and what the
//! counted verdicts say of a probability.
//!
//! A job is a grid of [`Cell`]s, each an expected preload and static friction coefficient with relative standard
//! deviations, at one rotating speed. Sample `j` of a cell is a pure function of the seed, the cell, `j` and
//! [`RESULTS_VERSION`] ([`identity`], [`samples`]); its verdict comes from `stickslip-core`. [`inputs`] has the
//! distributions and correlations that deviates can be given, [`deviates`] the deviates of any number of inputs, also
//! from points that are spread more evenly than independent ones ([`sobol`]).
//!
//! Verdicts are counted in integers and turned into an [`Estimate`] ([`interval`]), whose limits come from [`normal`],
//! [`poisson`] and [`beta`]. [`sequential`] has intervals that hold for a cell that is looked at until it is known well
//! enough, [`replicates`] those of independent randomisations, [`difference`] those of the difference between two cells,
//! [`audit`] what an audit says of a verdict map, [`distribution`] the mean and quantiles of a
//! quantity over samples.
//!
//! Where it is known which inputs are unstable, no samples are needed: [`exact`] gives the probability and its
//! derivatives from a boundary in closed form, [`mapped`] from a verdict map, with what the map does not tell as
//! limits. [`score`] estimates the same derivatives from samples, [`sensitivity`] the Sobol indices of the inputs.
//! [`methods`] says which method is for which question, and how a user notices that one has failed.
//!
//! Modules are declared in reading order. Nothing here knows of threads, files or the terminal.

// Tests compare with formulas as a textbook writes them.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod grid;

pub mod normal;

pub mod identity;

pub mod inputs;

pub mod samples;

pub mod sobol;

pub mod deviates;

pub mod poisson;

pub mod beta;

pub mod interval;

pub mod sequential;

pub mod replicates;

pub mod audit;

pub mod difference;

pub mod distribution;

pub mod exact;

pub mod mapped;

pub mod score;

pub mod sensitivity;

pub mod methods;

pub use deviates::{DeviateStream, Points};
pub use difference::{Difference, PairedCounts};
pub use distribution::Distribution;
pub use exact::{Derivatives, ExactProbability};
pub use grid::{Axis, AxisError, Cell, Grid, RelativeStd};
pub use identity::{BLOCK_SAMPLES, ESTIMATES_VERSION, Purpose, RESULTS_VERSION};
pub use inputs::{Correlation, CorrelationError, Empirical, EmpiricalError, Marginal, MarginalError};
pub use interval::{BinomialInterval, Estimate, IntervalKind, WilsonInterval};
pub use mapped::{MapRegions, MappedProbability};
pub use samples::{SampleStream, Samples};
pub use score::{CellNumber, ScoreSums, ScoreTotals};
pub use sequential::{Looks, Precision};
pub use sobol::{ScrambledSobol, SobolCursor};
