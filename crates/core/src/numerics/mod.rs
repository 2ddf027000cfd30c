//! Numerical methods that know nothing of brakes.

pub mod exponential;

pub mod eigenvalues;

pub mod quadrature;

pub(crate) mod sine_cosine;

pub(crate) mod root_location;
