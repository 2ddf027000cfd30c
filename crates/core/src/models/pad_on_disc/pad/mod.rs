//! The pad: its states of contact, its friction and its equations of motion, the same on every disc.

pub(crate) mod contact_state;

pub(crate) mod sliding_friction;

pub(crate) mod equations;
