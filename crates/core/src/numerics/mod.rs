//! Numerical methods that know nothing of brakes.

pub mod exponential;

pub mod eigenvalues;
