//! Arguments of `reduce`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::Args;

use super::values::whole_number_in;

/// Numbers of vectors that a basis may have.
const VECTORS: RangeInclusive<u64> = 1..=400;

/// Samples of an audit.
const AUDIT: RangeInclusive<u64> = 0..=100_000;

/// Arguments of `reduce`.
#[derive(Debug, Args)]
pub struct ReduceArguments {
    /// The job spec, whose model is given by matrices
    #[arg(value_name = "JOB.toml")]
    pub job: PathBuf,
    /// The number of vectors of the basis, and of coordinates of the reduced model, up to 400
    #[arg(
        long,
        value_name = "N",
        default_value = "100",
        value_parser = whole_number_in(VECTORS),
        allow_negative_numbers = true
    )]
    pub vectors: u64,
    /// Samples of the first cell at which reduced and full matrices are compared
    #[arg(
        long,
        value_name = "N",
        default_value = "20",
        value_parser = whole_number_in(AUDIT),
        allow_negative_numbers = true
    )]
    pub audit: u64,
    /// The job with the reduced matrices, which must not exist; they lie beside it, in a file with the ending .mat; if
    /// it is interrupted, the same command goes on [default: the name of the job and the number of vectors]
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
}
