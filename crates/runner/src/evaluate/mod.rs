//! Evaluation of samples: drawing their inputs, and finding their verdicts in closed form, by looking up or by
//! simulation.

pub mod control;

pub mod parts;

pub mod samples;

pub mod criteria;

pub mod maps;

pub mod unit;

pub mod sums;

pub mod conditional;

pub mod unstable_values;

pub mod remembering;

pub mod remembered_intervals;

pub mod rare_events;

pub mod evaluator;

pub mod tiles;

pub mod integral;

pub mod randomised;

pub mod limits_found;

pub mod weighted_limits;

pub mod limits;

mod stream;

pub mod work;
