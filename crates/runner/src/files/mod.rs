//! Files: written whole or not at all, and Parquet tables whose columns are described.

pub mod publish;

pub mod table;
