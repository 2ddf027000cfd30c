//! What a thread at work is asked to do.

/// What a thread should do next, what is more urgent last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Control {
    /// Go on.
    Continue,
    /// Hand over the samples that are finished, then go on.
    Flush,
    /// Hand over the samples that are finished, and return.
    Stop,
}

/// Tells whether what is being decided is no longer wanted, as after a signal. It is asked about once a millisecond, so
/// that not even a long motion makes anybody wait.
pub type IsStopped<'a> = &'a dyn Fn() -> bool;
