//! The run directory: pieces of finished work, maps, provenance, and how files are published.

pub mod directory;
pub mod maps;
pub mod piece;
pub mod provenance;
pub mod publish;
pub mod tally;
