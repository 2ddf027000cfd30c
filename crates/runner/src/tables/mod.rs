//! Tables: the surface and every other Parquet file, their columns and rows.

pub mod columns;
pub mod row;
pub mod surface;
pub mod table;
