//! The motion of pad and disc in time: sliding, sticking and separated, on a rigid and on a flexible disc.

pub(crate) mod friction_steps;

pub(crate) mod integrator;

pub(crate) mod rigid;

pub(crate) mod flexible;
