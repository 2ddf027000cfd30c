//! The surface: its rows, its columns, the file, and how it is read back; limits read back.

pub mod row;

pub mod cell_columns;

pub mod columns;

pub mod surface;

pub mod finished;

pub mod limits;
