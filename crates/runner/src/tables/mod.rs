//! The surface: its rows, its columns, and the file.

pub mod row;

pub mod columns;

pub mod surface;
