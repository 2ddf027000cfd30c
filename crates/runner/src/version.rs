//! What this program is: its version, the commit and target that it was built for, what it computes with here, and the
//! versions of what it computes.

use std::sync::LazyLock;

use stickslip_core::criterion::time_domain::VERDICTS_VERSION;
use stickslip_core::lanes::dispatch::InstructionSet;
use stickslip_sampler::draw::identity::{ESTIMATES_VERSION, RESULTS_VERSION};

use crate::job::IDENTITY_VERSION;

/// Its version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The commit that it was built from, as far as its build script knew.
pub const COMMIT: &str = env!("STICKSLIP_BUILD_COMMIT");

/// The target that it was built for, as rustc names it.
pub const TARGET: &str = env!("STICKSLIP_BUILD_TARGET");

/// The instruction set with which it simulates samples on this machine.
pub fn instruction_set() -> &'static str {
    InstructionSet::widest().name()
}

/// What `--version` prints after the name of the program: its version, and a line for everything else.
pub fn in_full() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let lines = [
            ("commit", COMMIT.to_owned()),
            ("target", TARGET.to_owned()),
            ("instruction set", instruction_set().to_owned()),
            ("results version", RESULTS_VERSION.to_string()),
            ("verdicts version", VERDICTS_VERSION.to_string()),
            ("estimates version", ESTIMATES_VERSION.to_string()),
            ("identity version", IDENTITY_VERSION.to_string()),
            ("licence", env!("CARGO_PKG_LICENSE").to_owned()),
        ];
        lines.iter().fold(VERSION.to_owned(), |text, (name, value)| format!("{text}\n{name}: {value}"))
    });
    &TEXT
}
