//! Models given by matrices: sums of given matrices times factors in named parameters.

pub mod factor;

pub mod region;

pub mod quadratic;

pub mod refine;

mod eigenbasis;

mod perturbation;

mod far;

mod series;

pub mod decide;

pub mod model;

pub mod full;

pub mod modes;
