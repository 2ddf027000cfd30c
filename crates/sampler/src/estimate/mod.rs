//! Estimates and confidence intervals from counted verdicts, conditional probabilities, weighted samples and recorded values.

pub mod interval;

pub mod looks;

pub mod randomisations;

pub mod fixed_point;

pub mod conditional;

pub mod groups;

pub mod weighted;

pub mod audit;

pub mod difference;

pub mod distribution;

pub mod score;

pub mod sobol_indices;

pub mod value_indices;
