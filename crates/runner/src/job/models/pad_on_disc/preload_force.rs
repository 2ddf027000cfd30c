//! The preload by the force that presses the pad on the disc, which is easier to measure than a displacement.
//!
//! In steady sliding `N = h Delta k_en k_y / (k_en + k_y)`, so `Delta = N (k_en + k_y) / (h k_en k_y)`. A job that gives
//! forces is the same as one that gives these preloads.

use stickslip_core::models::pad_on_disc::parameters::{Parameters, scalar};

/// The parameter that it stands for.
pub const PRELOAD: &str = "operating_point.preload";

/// The name of its axis.
pub const NAME: &str = "preload_force";

/// Its key under `[model]` and for `--set`, and the other name of its axis.
pub const KEY: &str = "operating_point.preload_force";

/// The parameters that the relation of force and preload depends on.
pub const PARAMETERS: [&str; 3] = ["disc.thickness", "stiffness.calliper_normal", "stiffness.contact_normal"];

/// Whether this is a name of the force.
pub fn is_preload_force(name: &str) -> bool {
    name == NAME || name == KEY
}

/// The preload that presses with a force (N).
///
/// # Errors
/// What is wrong with a force beyond the limits of the preload, after its key and value.
pub fn preload(force: f64, parameters: &Parameters) -> Result<f64, String> {
    let preload = parameters.preload_of(force);
    if scalar(PRELOAD).is_some_and(|scalar| scalar.limits.contain(preload)) {
        return Ok(preload);
    }
    let largest: f64 = format!("{:.5e}", 1.0 / parameters.preload_of(1.0)).parse().unwrap_or(f64::NAN);
    Err(format!(
        "is out of range: it must be at least 0 and at most {largest} N, the force at preload 1 of this brake, N = h Delta k_en k_y / (k_en + k_y)"
    ))
}

/// What to write for a random force.
pub const AS_INPUT: &str = "write \"preload\" for \"preload_force\": the force is proportional to the preload, so its relative standard deviation and its distribution are the same";
