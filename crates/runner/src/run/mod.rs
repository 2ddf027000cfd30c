//! A run: its directory, the pieces of finished work in it, the computation that adds to them, and the surface that
//! comes out.

mod batch;
mod columns;
mod directory;
mod engine;
mod extras;
mod mapping;
mod maps;
mod piece;
mod plan;
mod progress;
mod provenance;
mod publish;
mod row;
mod slots;
mod surface;
mod tables;
mod tally;

pub use batch::Batch;
pub use directory::{Access, RunDirectory};
pub use engine::{Engine, Outcome};
pub use extras::{Extras, Lookups};
pub use plan::{Plan, Shard};
pub use progress::Progress;
pub use provenance::Session;
pub use row::{IntegratedCell, SurfaceRow, unaudited};
pub use slots::Slots;
pub use surface::Surface;
pub use tables::{DescribedColumn, TableColumn, TableValues, write_columns, write_table};
pub use tally::Tally;
