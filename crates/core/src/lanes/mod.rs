//! Many samples at once, in the lanes of vector registers.
//!
//! The scalar code (module `motion`) defines the results; lanes only compute them faster. Lanes take one whole step of
//! slip together, by the same operations in the same order, so every lane has the bits that the scalar code has, on
//! every instruction set: nothing here is contracted, reassociated or approximated. Whatever is not plain slip
//! (sticking, release, lift-off, large angles, breakdown) sends the lane through the scalar step from the same state. A
//! lane whose sample is decided takes the next one. When samples run out, the scalar code finishes the last few.
//!
//! Loops over arrays of lanes are left to the compiler to vectorise, once for each instruction set; the widest one that
//! the processor has is chosen at run time. Only Tustin's law (exponent 1) has lanes: other exponents need a power
//! function, and their samples are simulated one by one.

#[doc(hidden)]
pub mod dispatch;

pub mod closed_form;

mod findings;

mod scheduling;

mod rigid;

mod flexible_step;

mod flexible;

mod batch;

pub mod linear_stability;
