//! The paper's own discretisation: the disc as a plate on a polar grid under the moving load.

pub(crate) mod plate;

pub(crate) mod patch;

mod pad_on_surface;

pub mod brake;

mod simulation;

mod trajectory;
