//! The motion of pad and disc in time: sliding, sticking and separated, on a rigid and on a flexible disc.

pub(crate) mod friction_steps;

pub(crate) mod integrator;

pub(crate) mod substep;

pub(crate) mod advance;

pub mod start;

pub mod start_value;

pub(crate) mod event_log;

pub mod moment;

pub(crate) mod rigid;

pub(crate) mod rigid_with_angle;

pub(crate) mod flexible;
