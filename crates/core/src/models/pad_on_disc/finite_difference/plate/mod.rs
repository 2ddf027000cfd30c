//! The disc as a polar grid: central differences of the annular plate, clamped at r = a and free at r = b.
//!
//! Rings of nodes lie at `r_i = a + i dr`, i = 1 .. `rings`, the last of them on the edge; each has `columns` nodes,
//! evenly spaced by `dtheta`. Lengths are scaled by h. With `d` for the second difference along a ring, over
//! `dtheta^2`, two passes of
//!
//! ```text
//! (nabla^2 f)_i = [ r_+ (f_i+1 - f_i) - r_- (f_i - f_i-1) ] / (r_i dr^2) + d f_i / r_i^2,      r_+- = r_i +- dr / 2
//! ```
//!
//! give nabla^4 w. Beyond the rims lie ghost nodes of w and of `L = nabla^2 w`. Clamped (the paper's 3.1), `w_0 = 0`
//! and `w_-1 = w_1`. At the free edge the slope is the mean of the slopes on both sides, and the ghosts follow from
//! bending moment (3.2) and shear force (3.3):
//!
//! ```text
//! f_r = [ r_+ (f_+ - f) + r_- (f - f_-) ] / (2 b dr)
//! L - (1 - nu) (w_r / b + d w / b^2) = 0,      L_r + (1 - nu) d (w_r - w / b) / b^2 = 0
//! ```
//!
//! Weighting the slopes with `r_+-` costs nothing in order, and it makes the operator symmetric under the areas of the
//! nodes, `r_i dr dtheta` and half of that on the edge: its squared frequencies are real. All ghosts are eliminated
//! beforehand, which leaves thirteen points around each node.

pub(crate) mod grid;

pub(crate) mod motion;
