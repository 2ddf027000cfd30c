//! Integrals over the pressed region of a patch of which part has lifted off; the edge of the region is found first.
//!
//! On a line of constant radius the gap is a constant, a linear function and a few harmonics of the angle,
//!
//! ```text
//! g(theta) = -y - r theta tan(phi) + sum over n of ( A_n(r) cos(n theta) + B_n(r) sin(n theta) )
//! ```
//!
//! and its roots in theta divide the line into pieces that press and pieces that do not. On every pressed piece the
//! integrand is smooth for Gauss points. Along the radius the integral of a line is smooth too, except where the edge
//! of the pressed region meets an end of the lines (`theta = +-psi`) and where it touches a line. There pieces appear,
//! vanish, divide or join, and the length of a piece grows like a square root. The radius is cut at those places, and
//! nodes crowd towards them (`r = r_0 + t^2` near `r_0`), which makes the integrand smooth in t. A rule with fixed
//! nodes has the kinks inside, and its errors fall only like a power of the number of nodes.
//!
//! A lifted or pressed island that lies between two neighbouring probe lines and touches neither is missed; the probes
//! are an eighth of the pad's width apart. For the preset's disc bent and tilted at random, loads are within 1e-7 of
//! those with twice the points in most states, and within 2e-4 in all of 198.

pub(super) mod line;

pub(super) mod shapes;

mod survey;

mod cuts;

pub(super) mod integration;

#[cfg(test)]
mod tests;
