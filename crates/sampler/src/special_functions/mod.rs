//! Distribution functions and their inverses, to full precision in both tails.

pub(crate) mod gauss_legendre;

pub mod normal;

pub(crate) mod chi_squared;

pub mod beta;
