//! Signals that end a process, such as Ctrl-C and SIGTERM: the first is answered by a message at once and obeyed within
//! two seconds. A second one ends the process at once.
//!
//! Threads at work see [`Interrupt::signal`] and hand over what they have finished. If some do not in time, because a
//! single motion takes longer, the thread that watches for signals ends the process without them. Where no thread is at
//! work there is nothing to hand over, and the process ends at once. Files are whole or absent whenever it ends.
//!
//! A signal that was ignored when the process began (`nohup`, `trap '' HUP`) stays so. SIGPIPE and SIGXFSZ are ignored:
//! the write fails. Faults of the processor (SIGSEGV, SIGBUS, SIGILL, SIGFPE) are left to the system.

use std::fmt;
use std::fs;
use std::io;
use std::path::PathBuf;
use std::process;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use signal_hook::consts::{
    SIGABRT, SIGALRM, SIGHUP, SIGINT, SIGPROF, SIGQUIT, SIGSYS, SIGTERM, SIGTRAP, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU,
    SIGXFSZ,
};
use signal_hook::flag;
use signal_hook::iterator::Signals;
use signal_hook::low_level;

use crate::failure::{Advice, Failure, Signal};
use crate::messages::{Code, Message};
use crate::unfinished;

/// The signals that end a process which does not handle them, on every system. The others are in [`ending`].
const ENDING: [i32; 13] = [
    SIGHUP, SIGINT, SIGQUIT, SIGTRAP, SIGABRT, SIGSYS, SIGUSR1, SIGUSR2, SIGALRM, SIGTERM, SIGXCPU, SIGVTALRM, SIGPROF,
];

/// Those that come again by themselves as time goes on, so that the second of them says nothing new.
const REPEATED: [i32; 4] = [SIGXCPU, SIGALRM, SIGVTALRM, SIGPROF];

/// What Linux says of a process.
const STATUS: &str = "/proc/self/status";

/// Time from a signal to the end of the process, but for a file that is being written then.
const GRACE: Duration = Duration::from_millis(1800);

/// Signals this soon after the first are the same one: `timeout` and batch systems send it to a process and to its
/// group.
const ECHO: Duration = Duration::from_millis(300);

/// Time between two looks at what has happened since the first signal.
const PAUSE: Duration = Duration::from_millis(10);

/// Time for removing temporary files after a second signal.
const LAST_PATIENCE: Duration = Duration::from_millis(200);

/// Watches for signals.
#[derive(Debug, Default)]
pub struct Interrupt {
    shared: Arc<Shared>,
}

/// What the process shares with the thread that watches for signals.
#[derive(Debug, Default)]
struct Shared {
    /// The number of the signal that was received; 0 before.
    signal: AtomicU8,
    /// Stretches of work in progress whose results have to be handed over.
    working: AtomicUsize,
    /// Held while a file of results is written.
    saving: Mutex<()>,
    /// What is kept of what is interrupted, and how to continue it.
    remark: Mutex<Remark>,
}

/// What is said after a signal.
#[derive(Debug, Default)]
struct Remark {
    advice: Option<Advice>,
    /// It is said only if this file is there then.
    condition: Option<PathBuf>,
}

impl Remark {
    /// What is said now.
    fn now(&self) -> Option<&Advice> {
        let is_true = self.condition.as_ref().is_none_or(|file| file.exists());
        self.advice.as_ref().filter(|_| is_true)
    }

    /// Says what a signal does, and what is kept of what it interrupts.
    fn say(&self, code: Code, what: &str) {
        let (rest, remedy) = match self.now() {
            Some(advice) => (format!("; {advice}"), advice.remedy().map(str::to_owned)),
            None => (String::new(), None),
        };
        Message { remedy, ..Message::new(code, &format!("{what}{rest}")) }.send_over_bar();
    }
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
        let failed = |error: io::Error| Failure::InputOutput(format!("cannot watch for signals: {error}"));
        // With a handler, even one that does nothing, a write beyond the limit is an error that names the file.
        flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false))).map_err(failed)?;
        let signals = Signals::new(watched()).map_err(failed)?;
        let watching = thread::Builder::new().name("signals".to_owned()).spawn(move || shared.obey(signals));
        watching.map_err(failed)?;
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
            number => Some(Signal(number)),
        }
    }

    /// Sets what the message says is kept from now on of what is interrupted, and how to continue it.
    pub fn remark(&self, remark: impl Into<Advice>) {
        *lock(&self.shared.remark) = Remark { advice: Some(remark.into()), condition: None };
    }

    /// The same, true as soon as a file is there.
    pub fn remark_once_there(&self, file: PathBuf, remark: impl Into<Advice>) {
        *lock(&self.shared.remark) = Remark { advice: Some(remark.into()), condition: Some(file) };
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
        let Some(signal) = signals.forever().find_map(|number| u8::try_from(number).ok().map(Signal)) else { return };
        let received = Instant::now();
        self.signal.store(signal.0, Ordering::SeqCst);
        let say = |code: Code, what: fmt::Arguments<'_>| lock(&self.remark).say(code, &what.to_string());
        if self.working.load(Ordering::SeqCst) == 0 {
            say(Code::Interrupted, format_args!("{signal}"));
            end(signal);
        }
        say(
            Code::Interrupting,
            format_args!("{signal}: saving what is finished, within 2 seconds (a second signal ends at once)"),
        );
        loop {
            thread::sleep(PAUSE);
            // All that are pending are taken, so that they do not count later.
            let is_repeated = signals.pending().filter(|number| !REPEATED.contains(number)).count() > 0;
            if is_repeated && received.elapsed() >= ECHO {
                let _removed = unfinished::remove_all(LAST_PATIENCE);
                low_level::exit(i32::from(signal.exit_code()));
            }
            if received.elapsed() >= GRACE
                && let Ok(_saving) = self.saving.try_lock()
            {
                say(Code::Interrupted, format_args!("{signal}; what takes longer is given up"));
                end(signal);
            }
        }
    }
}

/// Ends the process, without its temporary files.
fn end(signal: Signal) -> ! {
    let _removed = unfinished::remove_all(GRACE);
    process::exit(i32::from(signal.exit_code()))
}

/// The signals that are watched: those that end a process, but for those that were ignored when it began. Where the
/// system does not say which were, only those that always are.
fn watched() -> Vec<i32> {
    match fs::read_to_string(STATUS).ok().as_deref().and_then(ignored) {
        Some(ignored) => ending().filter(|number| ignored >> (number - 1) & 1 == 0).collect(),
        None => vec![SIGINT, SIGTERM],
    }
}

/// Every signal that ends a process which does not handle it, and that can be handled.
fn ending() -> impl Iterator<Item = i32> {
    #[cfg(target_os = "linux")]
    let others = {
        /// SIGSTKFLT, SIGIO and SIGPWR where they have these numbers, and the signals without a name, of which the C
        /// library keeps the first two to itself.
        const OTHERS: [i32; 3] =
            if cfg!(any(target_arch = "x86_64", target_arch = "aarch64")) { [16, 29, 30] } else { [34; 3] };
        OTHERS.into_iter().chain(34..=64)
    };
    #[cfg(not(target_os = "linux"))]
    let others = [];
    ENDING.into_iter().chain(others)
}

/// The signals that a process ignores, one bit each, from what Linux says of it.
fn ignored(status: &str) -> Option<u64> {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

/// Locks a mutex. A thread that panicked while it held it has not left anything half done.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_read_from_the_status_of_a_process() {
        assert_eq!(ignored("Name:\tstickslip\nSigBlk:\t0000000000000000\nSigIgn:\t0000000000001001\n"), Some(0x1001));
        assert_eq!(ignored("Name:\tstickslip\n"), None);
    }

    #[test]
    fn what_is_true_later_is_not_said_before() {
        let directory = tempfile::tempdir().unwrap();
        let (interrupt, file) = (Interrupt::unwatched(), directory.path().join("job.toml"));
        let said = || lock(&interrupt.shared.remark).now().map(ToString::to_string);
        assert_eq!(said(), None);
        interrupt.remark_once_there(file.clone(), "go on");
        assert_eq!(said(), None);
        fs::write(&file, "").unwrap();
        assert_eq!(said().unwrap(), "go on");
    }
}
