//! The models.

pub mod pad_on_disc;

pub mod belt_oscillator;

pub mod matrices;
