//! Ctrl-C and SIGTERM: a signal is answered in words at once and obeyed within two seconds. A second one ends the
//! process at once.
//!
//! Threads at work see [`Interrupt::signal`] and hand over what they have finished. If some do not in time, because a
//! single motion takes longer, the thread that watches for signals ends the process without them. Where no thread is at
//! work there is nothing to hand over, and the process ends at once. Files are whole or absent whenever it ends.

use std::process;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level;

use crate::failure::{Failure, Signal};
use crate::output::note_over_bar;

/// Time from a signal to the end of the process, but for a file that is being written then.
const GRACE: Duration = Duration::from_millis(1800);

/// Signals this soon after the first are the same one: `timeout` and batch systems send it to a process and to its
/// group.
const ECHO: Duration = Duration::from_millis(300);

/// Time between two looks at what has happened since the first signal.
const PAUSE: Duration = Duration::from_millis(10);

/// Watches for signals.
#[derive(Debug, Default)]
pub struct Interrupt {
    shared: Arc<Shared>,
}

/// What the process shares with the thread that watches for signals.
#[derive(Debug, Default)]
struct Shared {
    /// The number of the signal that was received; 0 before.
    signal: AtomicUsize,
    /// Stretches of work in progress whose results have to be handed over.
    working: AtomicUsize,
    /// Held while a file of results is written.
    saving: Mutex<()>,
    /// How to continue what is interrupted.
    advice: Mutex<Option<String>>,
}

/// A stretch of work in progress, see [`Interrupt::working`].
pub struct Working<'a>(&'a Shared);

impl Drop for Working<'_> {
    fn drop(&mut self) {
        self.0.working.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Interrupt {
    /// Starts to watch for signals.
    pub fn watch() -> Result<Self, Failure> {
        let interrupt = Self::default();
        let shared = Arc::clone(&interrupt.shared);
        let signals = Signals::new([SIGINT, SIGTERM]);
        let signals = signals.map_err(|error| Failure::InputOutput(format!("cannot watch for signals: {error}")))?;
        let watching = thread::Builder::new().name("signals".to_owned()).spawn(move || shared.obey(signals));
        watching.map_err(|error| Failure::InputOutput(format!("cannot watch for signals: {error}")))?;
        Ok(interrupt)
    }

    /// Does not watch: a signal ends the process at once, and [`Interrupt::signal`] is always `None`.
    pub fn unwatched() -> Self {
        Self::default()
    }

    /// The signal that was received, if any.
    pub fn signal(&self) -> Option<Signal> {
        match self.shared.signal.load(Ordering::Relaxed) {
            0 => None,
            number => Some(signal_of(number)),
        }
    }

    /// Says how to continue what is interrupted from now on.
    pub fn advise(&self, how: &str) {
        *lock(&self.shared.advice) = Some(how.to_owned());
    }

    /// Begins a stretch of work. A signal during it leaves time to hand over its results.
    pub fn working(&self) -> Working<'_> {
        self.shared.working.fetch_add(1, Ordering::SeqCst);
        Working(&self.shared)
    }

    /// Begins to write a file of results. The process does not end before it is written.
    pub fn saving(&self) -> MutexGuard<'_, ()> {
        lock(&self.shared.saving)
    }
}

impl Shared {
    /// Waits for signals, and obeys them.
    fn obey(&self, mut signals: Signals) {
        let Some(number) = signals.forever().next() else { return };
        let received = Instant::now();
        self.signal.store(number as usize, Ordering::SeqCst);
        let signal = signal_of(number as usize);
        let advice = lock(&self.advice).clone();
        let kept = advice.as_ref().map_or_else(String::new, |advice| format!("; what is finished is kept; {advice}"));
        if self.working.load(Ordering::SeqCst) == 0 {
            note_over_bar(format_args!("{signal}{kept}"));
            process::exit(i32::from(signal.exit_code()));
        }
        let then = advice.map_or_else(String::new, |advice| format!("; then {advice}"));
        note_over_bar(format_args!(
            "{signal}: saving what is finished, within 2 seconds (a second signal ends at once){then}"
        ));
        loop {
            thread::sleep(PAUSE);
            let is_repeated = signals.pending().next().is_some();
            if is_repeated && received.elapsed() >= ECHO {
                low_level::exit(i32::from(signal.exit_code()));
            }
            if received.elapsed() >= GRACE
                && let Ok(_saving) = self.saving.try_lock()
            {
                note_over_bar(format_args!("{signal}; what takes longer is given up{kept}"));
                process::exit(i32::from(signal.exit_code()));
            }
        }
    }
}

fn signal_of(number: usize) -> Signal {
    if number == SIGTERM as usize { Signal::Terminate } else { Signal::Interrupt }
}

/// Locks a mutex. A thread that panicked while it held it has not left anything half done.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
