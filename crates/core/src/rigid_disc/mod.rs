//! The pad on a rigid disc: steady sliding, its stability in closed form, and the limit cycle of stick-slip.

pub mod pad_on_disc;

pub mod stability;

pub mod varying_brake;

pub(crate) mod planar_motion;

pub(crate) mod return_map;

pub mod limit_cycle;
