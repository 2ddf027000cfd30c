//! Criteria that decide samples: the simulation in time, its settings and the range in which it was tested, and the
//! coupled eigenvalues.

pub mod settings;

pub(crate) mod monitor;

mod swings;

mod transients;

mod cycles;

mod settled_amplitude;

pub(crate) mod rigid_monitor;

pub(crate) mod flexible_monitor;

pub(crate) mod confirmation;

pub mod time_domain;

mod met_speeds;

pub(crate) mod coupled_eigenvalues;

pub mod validity;
