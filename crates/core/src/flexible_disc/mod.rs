//! The pad on a flexible disc: the modes of the disc, contact over the patch, the equilibrium of both, and its stability.

pub mod plate_modes;

pub(crate) mod contact;

pub(crate) mod partial_contact;

pub mod brake;

pub(crate) mod stability;

pub mod linear_stability;

pub mod mode_count;
