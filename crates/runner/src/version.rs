//! What this program is: its version, the commit and target that it was built for, what it computes with here, and the
//! versions of what it computes.

use std::sync::LazyLock;

use stickslip_core::models::pad_on_disc::lanes::dispatch::InstructionSet;
use stickslip_sampler::draw::identity::RESULTS_VERSION;

/// Its version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Version of the files from which a run resumes, and of how a job is identified in them. It changes whenever this program
/// could no longer go on with what the one before wrote, or the other way round.
pub const FORMAT_VERSION: u32 = 1;

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
            ("format version", FORMAT_VERSION.to_string()),
            ("licence", env!("CARGO_PKG_LICENSE").to_owned()),
        ];
        lines.iter().fold(VERSION.to_owned(), |text, (name, value)| format!("{text}\n{name}: {value}"))
    });
    &TEXT
}
