//! A run: its directory, the pieces of finished work in it, the computation that adds to them, and the surface that
//! comes out.

mod directory;
mod engine;
mod piece;
mod plan;
mod progress;
mod provenance;
mod publish;
mod surface;
mod tally;

pub use directory::{Access, RunDirectory};
pub use engine::{Engine, Outcome};
pub use plan::{Plan, Shard};
pub use progress::Progress;
pub use provenance::Session;
pub use surface::{DescribedColumn, Surface, SurfaceRow, job_hash_of_file, write_columns};
pub use tally::Tally;
