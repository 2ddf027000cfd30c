//! Distribution functions and their inverses, to full precision in both tails.

pub mod normal;

pub mod beta;
