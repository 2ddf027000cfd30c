//! Distribution functions and their inverses, to full precision in both tails.

pub(crate) mod gauss_legendre;

pub mod normal;

pub mod beta;
