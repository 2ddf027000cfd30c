//! Rare events: where the samples that matter lie, and with which weights samples drawn there are counted.
//!
//! The random inputs of a sample are functions of independent standard normal deviates `u`. The probability of
//! instability is the mean of `g(u)` over these: 1 for an unstable sample and 0 for another, or the probability given
//! `u` if two further inputs are integrated over.
//!
//! | module | contents |
//! |---|---|
//! | [`gaussian`] | normal densities, and their fit to points |
//! | [`scatters`] | the enlarged scatters with which points are tried |
//! | [`points`] | points in the space of deviates, and what is known of them |
//! | [`exploration`] | points tried with these scatters |
//! | [`population`] | deviates with the density `g(u) phi(u) / P`, found from such points |
//! | [`mixture`] | groups of points, each with a normal density |
//! | [`design_points`] | the most probable points of regions, by the gradient of a limit state |
//! | [`proposal`] | the density from which samples are drawn, and their weights |
//! | [`whole`] | a whole estimate in one call |

pub mod gaussian;

pub mod scatters;

pub mod points;

pub mod exploration;

pub mod population;

pub mod mixture;

pub mod design_points;

pub mod proposal;

pub mod whole;

#[cfg(test)]
mod tests;
