//! Verdicts of the models in the core, against independent references.

mod flexible_fates;
mod rigid_fates;
