//! Friction laws: the coefficient of friction over the sliding speed.
//!
//! With the sliding speed v and its ratio `r` to the speed scale of the law, every law is a sum that is linear in the
//! friction coefficients:
//!
//! ```text
//! mu(v) = f_c + (f_s - f_c) a(r) + e b(r)
//! ```
//!
//! | law | r | a(r) | f_c | e b(r) |
//! |---|---|---|---|---|
//! | Stribeck | abs(v) / v_s | `exp(-r^delta)` | kinetic coefficient | viscous term, `k_v abs(v)` |
//! | rational | abs(v) / v_s | `1 / (1 + r)` | kinetic coefficient | viscous term |
//! | table | abs(v) in m/s | T(r) / T(0), a measured curve | 0 | `z S(r)`: z standard deviations of the curve |
//!
//! | module | contents |
//! |---|---|
//! | [`measured_curve`] | a measured curve, its smoothing and its monotone interpolation |
//! | `shape` | a and b as integration steps evaluate them, one by one or in lanes |
//! | [`law`] | a law with its coefficients: value, slope, where it is steepest |

pub mod measured_curve;

pub(crate) mod shape;

pub mod law;
