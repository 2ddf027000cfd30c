//! Single motions: their record moment by moment, what they settle to, and sweeps of the rotating speed.

pub mod settled;

pub mod recording;

pub mod sweep;
