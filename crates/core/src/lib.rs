#![doc = include_str!("../README.md")]
//!
//! # Which door to open
//!
//! | you want | open |
//! |---|---|
//! | to set up a brake from its parameters | [`Parameters`](models::pad_on_disc::parameters::Parameters), [`PadOnDisc`](models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc) |
//! | its equilibrium, eigenvalues, critical speeds, the boundary of stability | [`PadOnDisc`](models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc) |
//! | a verdict by simulation, of one brake or of many in vector registers | [`criterion`](models::pad_on_disc::criterion), [`lanes`](models::pad_on_disc::lanes) |
//! | a motion, its limit cycle, the smallest knock that starts one | [`trajectory`](models::pad_on_disc::trajectory), [`rigid_disc`](models::pad_on_disc::rigid_disc) |
//! | a friction law, also a measured one | [`friction`] |
//! | the equations and the notation | [`models::pad_on_disc`] |
//!
//! # Modules
//!
//! | module | contents |
//! |---|---|
//! | [`numerics`] | methods, independent of brakes: eigenvalues, quadrature, root location, steps, monotone
//! interpolation, exponential, logarithm, sine and cosine |
//! | [`friction`] | the friction laws: Stribeck's, the rational one, measured curves |
//! | [`model`] | what any model is: its quantities, the decisions that it returns, and what it can do beyond them |
//! | [`models`] | the models: [the pad on the disc](models::pad_on_disc) |
//!
//! Modules are declared in reading order, and each imports only earlier ones.

// Tests compare with formulas as a textbook writes them.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod numerics;

pub mod friction;

pub mod model;

pub mod models;
