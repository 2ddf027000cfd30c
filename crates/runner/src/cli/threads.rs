//! The number of threads.

use clap::Args;

use super::values::threads;

/// How many threads.
#[derive(Debug, Args)]
pub struct ThreadsArgument {
    /// Threads, 1 to 1024 [default: all processors]; the result does not depend on them
    #[arg(long = "threads", value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    threads: Option<u16>,
}

impl ThreadsArgument {
    /// The number of threads, if it is given.
    pub fn given(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }

    /// The number of threads, by default one for each processor.
    pub fn count(&self) -> usize {
        self.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, std::num::NonZero::get), usize::from)
    }
}
