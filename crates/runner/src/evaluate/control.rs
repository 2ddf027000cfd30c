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
