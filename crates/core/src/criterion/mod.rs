//! What a motion in time says of a brake: the criterion, its settings, and the range in which it was tested.

pub mod judge;

pub mod time_domain;

pub mod validity;
