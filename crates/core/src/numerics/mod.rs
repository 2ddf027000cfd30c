//! Numerical methods, independent of brakes.

pub(crate) mod exponential;

pub(crate) mod logarithm;

pub(crate) mod monotone_cubic;

pub(crate) mod smoothing_spline;

pub(crate) mod schur;

pub mod eigenvalues;

pub(crate) mod fixed_point;

pub(crate) mod quadrature;

pub(crate) mod sine_cosine;

pub(crate) mod root_location;

pub(crate) mod dormand_prince;

pub(crate) mod rosenbrock;

pub(crate) mod row;

pub(crate) mod runge_kutta;
