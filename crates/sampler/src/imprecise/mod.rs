//! The least and the greatest probability of instability over inputs that are known as intervals.
//!
//! | module | contents |
//! |---|---|
//! | [`result`] | what is found, and how far it is certain |
//! | [`normal_inputs`] | standard deviations of normal, independent inputs: with a proof |
//! | [`search`] | any other quantities: an interpolation that is refined until it agrees |
//! | [`bounds`] | all quantities of a cell together |
//!
//! A greater expected value of the first input never lowers the probability: an input is its expected value times a
//! ratio, and from an unstable sample every greater first input is unstable. The same holds for the second input where
//! samples are unstable above the boundary.

pub mod result;

mod tolerance;

mod expansion;

mod bernstein;

pub mod normal_inputs;

mod interpolation;

pub mod search;

pub mod bounds;
