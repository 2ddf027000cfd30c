//! What counted verdicts and recorded values say of a probability.

pub mod interval;

pub mod sequential;

pub mod replicates;

pub mod audit;

pub mod difference;

pub mod distribution;

pub mod score;

pub mod sensitivity;
