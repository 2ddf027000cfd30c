//! Statistics of the stability of a brake: the cells of a job, the deviates of each sample, and what the counted
//! verdicts say about a probability.
//!
//! A job is a grid of [cells](grid::Cell), each an expected preload and static friction coefficient with relative
//! standard deviations, at one rotating speed. Sample `j` of a cell is a pure function of the seed, the cell, `j` and
//! the [results version](draw::identity::RESULTS_VERSION); its verdict comes from `stickslip-core`.
//!
//! | module | what it has |
//! |---|---|
//! | [`grid`] | axes and cells |
//! | [`special_functions`] | the normal and the beta distribution |
//! | [`inputs`] | the distributions and correlations of random inputs |
//! | [`draw`] | identity of a sample, its deviates, Sobol points |
//! | [`verdict_map`] | the map of verdicts over two inputs, and its boundary curve |
//! | [`integrate`] | probabilities without samples: in closed form, and from a verdict map |
//! | [`estimate`] | intervals, sequential sampling, differences, audits, derivatives, Sobol indices |
//! | [`methods`] | which method answers which question, and how a user notices that one has failed |
//!
//! Modules are declared in reading order. Nothing here knows of threads, files or the terminal.

// Tests compare with formulas as a textbook writes them.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod grid;

pub mod special_functions;

pub mod inputs;

pub mod draw;

pub mod verdict_map;

pub mod integrate;

pub mod estimate;

pub mod methods;
