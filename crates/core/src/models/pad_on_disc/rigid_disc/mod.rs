//! The pad on a rigid disc: steady sliding, its stability in closed form, limit cycles,
//! and which motions return to steady sliding.

pub mod pad_on_disc;

pub mod stability;

pub mod varying_brake;

pub(crate) mod near_rest;

pub(crate) mod planar_motion;

pub(crate) mod inner_cycles;

pub(crate) mod slow_passage;

pub(crate) mod return_map;

pub mod limit_cycle;

pub mod cycle_ranges;

mod cycle_velocity;

pub mod unstable_cycle;

pub mod basin;
