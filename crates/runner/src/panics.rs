//! Panics: errors of the program itself, said in one line.
//!
//! The code has none on purpose. What is left are mistakes, libraries that read a forged file, and a system without
//! random numbers.

use std::any::Any;
use std::backtrace::Backtrace;
use std::cell::Cell;
use std::env;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};

use crate::messages::{Code, Message};

/// The exit code after a panic.
pub const EXIT_CODE: u8 = 70;

thread_local! {
    /// Whether panics of this thread are caught and said elsewhere.
    static IS_CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Lets every panic be said in one line. `RUST_BACKTRACE=full` adds where it came from.
pub fn say_in_a_line() {
    panic::set_hook(Box::new(|panic| {
        // The value may be gone at the end of a thread.
        if !IS_CAUGHT.try_with(Cell::get).unwrap_or(false) {
            say(panic);
        }
    }));
}

fn say(panic: &PanicHookInfo<'_>) {
    let what = text(panic.payload());
    let place = panic.location().map(|place| format!(" ({}:{})", place.file(), place.line())).unwrap_or_default();
    let wants_trace = env::var_os("RUST_BACKTRACE").is_some_and(|value| value == "full");
    let trace = if wants_trace { format!("\n{}", Backtrace::force_capture()) } else { String::new() };
    let text = format!("internal error: {what}{place}; please report it. Finished work that is on disk is kept{trace}");
    Message::new(Code::InternalError, &text).send_over_bar();
}

/// Runs `work`, and returns what a panic said as an error.
pub fn caught<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let before = IS_CAUGHT.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    IS_CAUGHT.set(before);
    result.unwrap_or_else(|payload| Err(text(&*payload)))
}

/// What a panic says, in one line.
fn text(payload: &(dyn Any + Send)) -> String {
    let text = match (payload.downcast_ref::<&str>(), payload.downcast_ref::<String>()) {
        (Some(text), _) => text,
        (None, Some(text)) => text.as_str(),
        (None, None) => "unknown",
    };
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;
    use crate::messages;

    #[test]
    fn a_panic_becomes_an_error() {
        let divided = |by: u64| caught(|| Ok(10_u64.checked_div(by).expect("no\nquotient")));
        assert_eq!(divided(5), Ok(2));
        assert_eq!(divided(0), Err("no quotient".to_owned()));
        assert!(!IS_CAUGHT.get());
    }

    /// Set in the process that panics.
    const VARIABLE: &str = "STICKSLIP_TEST_PANIC";

    #[test]
    fn a_panic_is_one_object_for_programs() {
        if env::var_os(VARIABLE).is_some() {
            messages::choose(messages::Form::Json);
            say_in_a_line();
            assert!(panic::catch_unwind(|| panic!("\u{1b}[31mred\n\"quoted\"")).is_err());
            return;
        }
        let mut command = Command::new(env::current_exe().unwrap());
        command.args(["--exact", "panics::tests::a_panic_is_one_object_for_programs", "--nocapture"]);
        let output = command.env(VARIABLE, "1").env_remove("RUST_BACKTRACE").output().unwrap();
        assert!(output.status.success());
        let object: serde_json::Value = serde_json::from_slice(&output.stderr).unwrap();
        assert_eq!(object["code"], "internal-error");
        let text = object["text"].as_str().unwrap();
        assert!(
            text.starts_with("internal error: \\u{1b}[31mred \"quoted\" (") && text.contains("report it"),
            "{text}"
        );
    }
}
