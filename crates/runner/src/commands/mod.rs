//! The commands, and code that several of them share.

mod shipped_jobs;

mod named_job;

mod init;

mod run_progress;

mod status;

mod kept_beside;

mod costs;

mod check;

mod one_brake;

mod modes;

mod motion_report;

mod analyse;

mod parameters;

mod describe;

mod adoption;

mod limit;

mod reduce;

mod closing;

mod completion;

mod submit;

mod clusters;

mod verify;

mod trajectory;

mod replay;

mod drawn_samples;

mod samples;

mod compare;

mod brake_tests;

mod fit_picture;
mod fitted_job;

mod fit;

mod cell;

mod plot;

mod report;

mod export;

pub use analyse::analyse;
pub use check::check;
pub use clusters::submit_to_engine;
pub use compare::compare;
pub use completion::{FinishedRun, complete_run};
pub use describe::{completions, man, schema};
pub use export::export;
pub use fit::fit;
pub use init::init;
pub use limit::limit;
pub use motion_report::{columns, scales_line};
pub use parameters::parameters;
pub use plot::plot;
pub use reduce::reduce;
pub use replay::replay;
pub use report::report;
pub use samples::samples;
pub use status::status;
pub use submit::{merge, resume, submit};
pub use trajectory::{simulate, trajectory};
pub use verify::verify;
