//! Estimates and confidence intervals from counted verdicts, conditional probabilities and recorded values.

pub mod interval;

pub mod looks;

pub mod randomisations;

pub mod conditional;

pub mod audit;

pub mod difference;

pub mod distribution;

pub mod score;

pub mod sobol_indices;
