//! Models given by matrices: sums of given matrices times factors in named parameters.

pub mod factor;

pub mod region;

pub mod error;

pub mod pair;

pub mod branches;

pub mod interval;

pub mod sweep;

pub mod terms;

pub mod condensation;

mod rigid_body;

pub mod quadratic;

mod two_coordinates;

mod refine;

mod eigenbasis;

mod discs;

mod dense_branches;

mod covering;

mod polynomial;

mod perturbation;

mod far;

mod group;

mod series;

pub mod decide;

pub mod full;

pub mod problem;

pub mod recorded;

mod limit_branch;

mod decided;

mod fast_basis;

mod boundary;

mod coupled;

mod isolated;

mod forms;

mod elimination;

mod centre;

mod centres;

mod samples;

pub mod model;

pub mod modes;

#[cfg(test)]
mod trial;
