//! Ctrl-C and SIGTERM: after the first signal the run writes what is finished and ends, the second ends it at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::failure::{Failure, Signal};

/// Watches for signals.
#[derive(Debug)]
pub struct Interrupt {
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Starts to watch for signals.
    pub fn watch() -> Result<Self, Failure> {
        let signal = Arc::new(AtomicUsize::new(0));
        for (number, exit_code) in [(SIGINT, 130), (SIGTERM, 143)] {
            let armed = Arc::new(AtomicBool::new(false));
            // The order matters: at the first signal the shutdown is not armed yet, and is armed after it.
            let registered = flag::register_conditional_shutdown(number, exit_code, Arc::clone(&armed))
                .and_then(|_| flag::register(number, armed))
                .and_then(|_| flag::register_usize(number, Arc::clone(&signal), number as usize));
            registered.map_err(|error| Failure::InputOutput(format!("cannot watch for signals: {error}")))?;
        }
        Ok(Self { signal })
    }

    /// The signal that was received, if any.
    pub fn signal(&self) -> Option<Signal> {
        match self.signal.load(Ordering::Relaxed) as i32 {
            0 => None,
            SIGTERM => Some(Signal::Terminate),
            _ => Some(Signal::Interrupt),
        }
    }
}
