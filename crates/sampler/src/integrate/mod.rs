//! Probabilities without samples: from a boundary in closed form, and from a verdict map.

pub mod derivatives;

mod quadrature;

pub mod closed_form;

pub mod pair;

pub mod verdict_map;
