//! Many samples at once, in the lanes of vector registers.
//!
//! The scalar code (module `motion`) defines the results; lanes only compute them faster. Every lane has a sample with
//! coefficients, a step length and a time of its own. All lanes take their trial steps (module `motion::substep`)
//! together, by the same operations in the same order as the scalar code, so every lane has the bits that it has, on
//! every instruction set: nothing here is contracted, reassociated or approximated. The equations of pad, friction and
//! disc and the Runge-Kutta step are the scalar ones, written for a number or for a row of them
//! (module `numerics::row`).
//!
//! | a trial step | who judges it |
//! |---|---|
//! | completes a substep, and nothing happened in it | lanes, without a branch |
//! | is too long for the friction law | the scalar code finds a shorter length; lanes take that step |
//! | turns | lanes; the scalar code locates the turning point and passes it to the monitor |
//! | meets the disc's speed, or releases the pad | the scalar code, which asks lanes for one trial step after the other |
//! | is in a state of contact that the lanes do not know, or with part of the patch lifted | the scalar code takes it |
//!
//! Samples flow from a queue: a lane whose sample is decided takes the next one. When they run out, the scalar code
//! finishes the last few.
//!
//! Loops over arrays of lanes are left to the compiler to vectorise, once for each instruction set; the widest one that
//! the processor has is chosen at run time.

#[doc(hidden)]
pub mod dispatch;

pub mod closed_form;

pub mod linear_stability;

pub mod queue;

mod pace;

mod findings;

mod bundle;

mod scheduling;

mod rigid_step;

mod rigid;

mod contact_loads;

mod flexible_step;

mod flexible;

pub mod batch;

/// Neighbouring lanes, whose values of one kind make a row: all lanes of a flexible disc, a quarter of those of a rigid
/// one. So many keep a step in registers, or all degrees of freedom in the first-level cache.
const BLOCK: usize = 16;

/// One value for each lane of a block.
type Row = crate::numerics::row::Row<BLOCK>;
