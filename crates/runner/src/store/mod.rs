//! The run directory: pieces of finished work, maps, provenance, and how files are published.

pub mod publish;

pub mod tally;

pub mod wanted;

pub mod piece;

pub mod map_pieces;

pub mod directory;

pub mod provenance;
