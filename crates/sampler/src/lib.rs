//! Statistics of the stability of a brake: the cells of a job, the random samples of each cell, and the probability of
//! instability with its confidence interval.
//!
//! A job is a grid of [cells](grid::Cell). A cell is an expected preload and static friction coefficient with their
//! relative standard deviations, at one rotating speed. Sample `j` of a cell is a pure function of the seed, the cell,
//! `j` and the [results version](draw::identity::RESULTS_VERSION). Its verdict comes from `stickslip-core`.
//!
//! | module | contents |
//! |---|---|
//! | [`grid`] | axes and cells |
//! | [`special_functions`] | the normal and the beta distribution |
//! | [`inputs`] | marginal distributions and correlation of random inputs |
//! | [`draw`] | the identity of a sample, its deviates, Sobol points |
//! | [`verdict_map`] | the verdict as a function of preload and static friction |
//! | [`integrate`] | probabilities without samples: in closed form, and from a verdict map |
//! | [`imprecise`] | the least and the greatest probability over inputs that are known as intervals |
//! | [`estimate`] | intervals, sequential looks, randomisations, audits, differences, derivatives, Sobol indices |
//! | [`fit`] | distributions of the inputs from tests of brakes, by maximum likelihood |
//! | [`limits`] | at which values of an axis the probability passes a target |
//! | [`rare`] | where samples of rare events are drawn, and with which weights |
//! | [`methods`] | which method answers which question, and how to notice that it has failed |
//!
//! Each module uses only those above it. The crate does not know threads, files or the terminal.

// Tests compare with formulas as a textbook writes them.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod grid;

pub mod special_functions;

mod lower_triangle;

pub mod inputs;

pub mod draw;

pub mod verdict_map;

pub mod integrate;

pub mod imprecise;

pub mod estimate;

pub mod fit;

pub mod limits;

pub mod rare;

pub mod methods;
