//! The run directory: pieces of finished work, verdict maps, provenance.

mod covered;

pub mod tally;

mod joining;

pub mod wanted;

mod clock;

pub mod lock;

pub mod digests;

pub mod layout;

pub mod file_state;

mod stored_unit;

pub mod piece;

pub mod map_pieces;

pub mod searches;

pub mod directory;

pub mod frozen_job;

pub mod provenance;

pub mod outdated;
