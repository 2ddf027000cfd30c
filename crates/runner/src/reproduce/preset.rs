//! The brake of the paper.

use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

use crate::failure::Failure;

/// The preset at a rotating speed, rad/s.
pub fn brake_at(rotating_speed: f64) -> Result<PadOnDisc, Failure> {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.operating_point.rotating_speed = rotating_speed;
    PadOnDisc::new(parameters).map_err(|error| Failure::Job(error.to_string()))
}
