//! Writing files, whole or not at all, and Parquet tables whose columns carry unit and meaning; reading files that others
//! may have written.

pub mod bounded;

pub mod csv_file;

pub mod foreign;

#[cfg(test)]
pub mod forging;

pub mod publish;

pub mod folder;

pub mod table;
