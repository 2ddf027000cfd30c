#![doc = include_str!("../README.md")]
//!
//! # Which door to open
//!
//! | you want | open |
//! |---|---|
//! | to draw the samples of a cell | [`DeviateStream`](draw::deviates::DeviateStream), [`InputColumns`](inputs::InputColumns) |
//! | a probability and its interval from counted verdicts | [`BinomialInterval`](estimate::interval::BinomialInterval) |
//! | to stop when an estimate is precise enough | [`Looks`](estimate::looks::Looks) |
//! | a narrower interval from Sobol points | [`Points::Sobol`](draw::deviates::Points), [`estimate::randomisations`] |
//! | a probability without samples | [`integrate`] |
//! | few simulations for many samples of two inputs | [`verdict_map`] |
//! | a probability below one in a million | [`rare`] |
//! | which input matters, and derivatives | [`estimate::sobol_indices`], [`estimate::score`] |
//! | the value of an axis at which a probability is reached | [`limits`] |
//! | distributions from tests | [`fit`] |
//! | what a method assumes, and how you notice that it fails | [`methods`] |
//!
//! # Cells and modules
//!
//! A job is a grid of [cells](grid::Cell). A cell is the expected values of the quantities of a model, with the relative
//! standard deviations of those that are random. Sample `j` of a cell is a pure function of the seed, the cell,
//! `j` and the [results version](draw::identity::RESULTS_VERSION). Its verdict comes from `stickslip-core`.
//!
//! | module | contents |
//! |---|---|
//! | [`grid`] | axes and cells |
//! | [`special_functions`] | the normal, the chi-squared and the beta distribution |
//! | [`inputs`] | marginal distributions and correlation of random inputs |
//! | [`draw`] | the identity of a sample, its deviates, Sobol points |
//! | [`verdict_map`] | the verdict as a function of two inputs |
//! | [`integrate`] | probabilities without samples: in closed form, and from a verdict map |
//! | [`estimate`] | intervals, sequential looks, randomisations, audits, differences, derivatives, Sobol indices |
//! | [`fit`] | distributions of two inputs from tests, by maximum likelihood |
//! | [`limits`] | at which values of an axis the probability passes a target |
//! | [`rare`] | where samples of rare events are drawn, and with which weights |
//! | [`methods`] | which method answers which question, and how to notice that it has failed |
//!
//! Each module uses only those above it.

// Tests compare with formulas as a textbook writes them.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod grid;

pub mod special_functions;

mod lower_triangle;

pub mod inputs;

pub mod draw;

pub mod verdict_map;

pub mod integrate;

pub mod estimate;

pub mod fit;

pub mod limits;

pub mod rare;

pub mod methods;
