//! The commands, and what several of them share.

mod adoption;
mod analyse;
mod check;
mod closing;
mod compare;
mod completion;
mod describe;
mod differences;
mod matching;
mod replay;
mod status;
mod submit;
mod trajectory;

pub use analyse::analyse;
pub use check::check;
pub use compare::compare;
pub use completion::{FinishedRun, complete_run};
pub use describe::{completions, man, schema};
pub use replay::replay;
pub use status::status;
pub use submit::{merge, resume, submit};
pub use trajectory::{columns, simulate, trajectory};
