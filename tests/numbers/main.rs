//! What the program computes, against independent references and regression values.

#[path = "../common/mod.rs"]
mod common;

mod audits;
mod axes;
mod belt_oscillator;
mod brake_of_a_job;
mod cases;
mod compare;
mod conditional;
mod estimates;
mod fit;
mod friction_laws;
mod inputs;
mod limit_methods;
mod limits;
mod limits_of_runs;
mod map_only;
mod matrices;
mod mission;
mod preload_force;
mod probabilities;
mod published_models;
mod rare_events;
mod recorded;
mod reproduction;
mod rough_inputs;
mod samples;
mod time_domain;
mod units;
mod without_friction;
