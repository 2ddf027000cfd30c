//! The pad: its states of contact and its equations of motion, the same on every disc.

pub(crate) mod contact_state;

pub(crate) mod equations;
