//! A limit of time that ends waiting also for what cannot be interrupted, such as the eigenvalues of a large matrix.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use crate::failure::Failure;

/// Room for recursion, as on the main thread.
const STACK: usize = 8 << 20;

/// What `work` gives on a thread of its own; `None` if that takes longer. Then nobody waits for it any more: it goes on, and
/// ends with the process at the latest.
///
/// # Errors
/// If no thread can be started, or if `work` panics.
pub fn within<T: Send + 'static>(
    limit: Duration,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<Option<T>, Failure> {
    let (sender, receiver) = mpsc::sync_channel(1);
    let started = thread::Builder::new().stack_size(STACK).spawn(move || {
        // An answer that nobody waits for is dropped.
        sender.send(work()).ok();
    });
    started.map_err(|error| Failure::InputOutput(format!("cannot start one more thread: {error}")))?;
    match receiver.recv_timeout(limit) {
        Ok(answer) => Ok(Some(answer)),
        Err(RecvTimeoutError::Timeout) => Ok(None),
        Err(RecvTimeoutError::Disconnected) => {
            Err(Failure::Internal("a thread failed; please report this as a bug".to_owned()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_ends_gives_its_answer() {
        assert_eq!(within(Duration::from_secs(600), || 42).unwrap(), Some(42));
    }

    #[test]
    fn work_that_does_not_end_is_left() {
        let (never, nothing) = mpsc::channel::<()>();
        let work = move || nothing.recv().is_ok();
        assert_eq!(within(Duration::ZERO, work).unwrap(), None);
        // It waited all the while.
        drop(never);
    }

    #[test]
    fn work_that_fails_is_an_error() {
        let work = || -> u8 { panic!("on purpose") };
        assert!(within(Duration::from_secs(600), work).unwrap_err().to_string().contains("a thread failed"));
    }
}
