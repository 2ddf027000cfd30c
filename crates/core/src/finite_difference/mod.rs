//! The paper's own discretisation: the disc as a plate on a polar grid under the moving load.

pub(crate) mod plate;

pub(crate) mod patch;

pub mod brake;

pub(crate) mod motion;
