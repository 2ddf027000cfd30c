//! Linear stability of many brakes, each with coefficients of its own, by Nyquist's criterion.
//!
//! The eigenvalues of all degrees of freedom cost some hundred microseconds. Here most samples are decided by their
//! frequency response at a single frequency, and by bounds everywhere else. What the bounds leave open is left to the
//! eigenvalues, so that the decision is theirs always.
//!
//! # Why it is right
//!
//! Steady sliding is stable if no zero of `det L(s)`, `L(s) = s^2 + s B + A`, has a positive real part; `A` and `B` are
//! those of [`linearise`](crate::models::pad_on_disc::flexible_disc::equations::FlexibleEquations::linearise) with the sign changed. The
//! degrees of freedom are eliminated in three steps: the *core*, y and the amplitudes of the disc; then phi; then x.
//!
//! **The core.** With the amplitudes scaled to the mass of the pad (weights `k_en / (M compliance)`),
//!
//! ```text
//! A = A0 + N,    A0 = diag(k_y / M, omega_k^2 - n_k^2 Om^2) + Gram,      B = diag(c_y / M, eta1) + G
//! ```
//!
//! `Gram`, the contact stiffness, is symmetric and positive semidefinite, the gyroscopic `G` is skew and not larger
//! than `gamma = max 2 n Om`, and `N` is all the rest: the follower load of friction and the tilt of the pad, not
//! larger than `nu`. For a unit vector v, the real and the imaginary part of `v* L(i omega) v` say that
//!
//! ```text
//! 1 / |L^-1| >= max( omega c - nu,   least - omega^2 - omega gamma - nu,   omega^2 - most - omega gamma - nu )
//! ```
//!
//! with `c = min(c_y / M, eta1)`, and `least` and `most` bounds of the eigenvalues of A0. Even and odd amplitudes are
//! coupled by no more than `omega gamma + nu`, and the pressure couples y, phi and x to the even ones by parallel rows:
//! the bounds use both, and eliminate y first where that is better. Where this is positive at all frequencies, no zero
//! of the determinant crosses the imaginary axis while N grows from nothing to what it is. Without N the core is damped
//! and stable, so it is stable with N.
//!
//! **phi.** With the row a and the column b that couple phi and the core, what is left after the elimination of the
//! core is `S = s^2 + s c_phi + k_phi - a L^-1 b`. If the bound of `|a L^-1 b|` is smaller than the rest at all
//! frequencies, S has as many zeros with positive real part as without it: none (Rouche's theorem).
//!
//! **x.** What is left in the end is `f(s) = s^2 + s B_xx + A_xx - h(s)`, `h = r R^-1 c`, with the row r and the column
//! c that couple x and all the rest R. R is stable, so f has the zeros of `det L` with positive real part. Where `|h| <
//! |A_xx - omega^2|`, the real part of f has the sign of `A_xx - omega^2`. Let this hold outside an interval about
//! `omega_x = sqrt(A_xx)`. If the imaginary part of `f(i omega)` is positive wherever the real part may vanish inside,
//! f passes from the positive to the negative side above the origin, and has no zero with positive real part; if it is
//! negative there, f has two.
//!
//! **Inside the interval**, h is known from its value and slope at `omega_x`: with `w = r R^-1`, `z = R^-1 c` and
//! `R(i omega) = R + Delta`,
//!
//! ```text
//! r (R + Delta)^-1 c = r R^-1 c - w Delta z + w Delta (R + Delta)^-1 Delta z
//! ```
//!
//! and the last term is at most `|w| |z| |Delta|^2 |(R + Delta)^-1|`.
//!
//! The slope of friction enters c and `B_xx` alone. So the same elimination says whether the sample would be stable
//! with friction that does not fall with speed: then the tangential motion feeds what grows.

mod elimination;

mod batch;

mod matrices;

mod bounds;

mod crossing;

mod decision;

pub(crate) use batch::Batch;
pub(crate) use decision::decide;
