//! Scheduling: which work is missing, its division into units, and the one parallel loop that does it.

pub mod time_left;

pub mod cost;

pub mod within;

mod bar_line;

pub mod progress;

pub mod plan;

mod spread;

mod saving;

pub mod engine;

pub mod in_order;

pub mod mapping;

mod places;

pub mod trial;

pub mod map_trial;

pub mod integral_trial;
