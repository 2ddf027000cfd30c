//! Probabilities without samples: from a boundary in closed form, from the unstable values of one input, and from a verdict map.

mod normal_pair;

pub mod derivatives;

mod quadrature;

pub mod closed_form;

pub mod pair;

pub mod one_input;

pub mod verdict_map;

pub use normal_pair::NormalPair;
