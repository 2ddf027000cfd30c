//! Numerical methods that know nothing of brakes.

pub(crate) mod exponential;

pub mod eigenvalues;

pub(crate) mod quadrature;

pub(crate) mod sine_cosine;

pub(crate) mod root_location;

pub(crate) mod dormand_prince;
