//! Models given by matrices of a finite-element program.

pub mod full;
