//! The pad on a flexible disc: the modes of the disc, contact over the patch, the equations of motion, the equilibrium
//! of both, and its stability.

pub mod plate_modes;

pub(crate) mod compliance;

pub mod error;

pub(crate) mod contact;

pub(crate) mod geometry;

pub(crate) mod equations;

mod linearisation;

mod continuation;

mod equilibrium;

mod critical_products;

pub mod brake;

pub mod linear_stability;

pub(crate) mod nyquist;

pub mod mode_count;
