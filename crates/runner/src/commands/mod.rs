//! The commands, one file each.

mod analyse;
mod check;
mod compare;
mod describe;
mod differences;
mod matching;
mod status;
mod submit;
mod trajectory;

pub use analyse::analyse;
pub use check::check;
pub use compare::compare;
pub use describe::{completions, man, schema};
pub use status::status;
pub use submit::{FinishedRun, complete_run, merge, resume, submit};
pub use trajectory::{columns, follow, replay, trajectory};
