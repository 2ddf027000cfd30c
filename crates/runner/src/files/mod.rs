//! Writing files, whole or not at all, and Parquet tables whose columns carry unit and meaning.

pub mod publish;

pub mod folder;

pub mod table;
