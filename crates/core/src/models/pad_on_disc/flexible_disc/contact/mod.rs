//! The patch where pad and disc touch: its quadrature, and what the pressure does to the disc's modes.
//!
//! The gap (positive where the surfaces press into each other) and the loads that follow from it are averages over the
//! patch `r_a < r < b`, `|theta| < psi`, lengths scaled by h:
//!
//! ```text
//! g = w - y - r theta tan(phi),  g+ = max(g, 0),      <f> = integral of f dA / A_s
//! pressure  <g+>,      load on mode k  <psi_k g+>,      follower load on mode k  <psi_k g+ w_theta / r>
//! ```
//!
//! Friction is tangent to the deflected surface, so it has a component along the disc's axis that turns with the
//! surface: the follower load.
//!
//! While the whole patch is certainly in contact, the loads come from averages of products of mode shapes, which
//! [`averages`] computes once. Otherwise [`pressed_region`] integrates over the part that presses. If that part is the
//! whole patch after all, the loads are summed node by node, which is the same sum in another order. Mode shapes are
//! even (cosine) or odd (sine) in theta, and so is each average: half of the products vanish and are left out.

pub(crate) mod position;

pub(crate) mod node;

pub(crate) mod points;

pub(crate) mod loads;

pub(crate) mod averages;

mod pressed_region;

pub(crate) mod patch;
