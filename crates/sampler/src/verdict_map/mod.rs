//! The verdict map: the verdict on a sample as a function of its two random inputs.
//!
//! With all else given, the verdict is a deterministic function of two inputs, constant except across a few curves. A
//! map stores that function. It knows verdicts and the plane of the two inputs; it asks its caller for the verdicts, and
//! knows no physics.
//!
//! The first coordinate of the plane is the first input, the second is the second input above an origin, below which no
//! sample is unstable. The plane is divided into [tiles](tile), an eighth wide below 1 and wider beyond. Each tile is a
//! quadtree of boxes, divided until every box is one of three kinds:
//!
//! * **uniform**: all points of a grid in the box and around it have one verdict;
//! * **crossed**: a [`BoundaryCurve`](boundary_curve::BoundaryCurve) separates two verdicts;
//! * **unresolved**: the box is too small to divide further, as at corners and ends of boundaries.
//!
//! The verdict on a sample is looked up, unless the sample lies within the resolution of a curve or in an unresolved
//! box. Such a sample has to be simulated.
//!
//! Samples in undecided regions are simulated too. Whether a motion is decided just before its horizon depends on the
//! phase of its cycle there, so that these regions have ragged edges and are crossed by lines of decided samples too
//! thin for any grid. The map keeps the regions for integration, which counts them for neither verdict.
//!
//! A tile is a pure function of the verdicts. Maps of different jobs can therefore be joined.
//!
//! **Limit.** A map does not see an island of another verdict that is smaller than the grid of its box (1/32 below 1)
//! and touches no point of it. Such islands occur at short horizons: a sliver of undecided samples, some thousandths
//! wide, may run along a boundary through a tile none of whose grid points is undecided. Looked-up verdicts are
//! therefore [audited](crate::estimate::audit).

pub mod boundary_curve;

mod boundary_search;

pub mod tile;

pub mod resolve;

pub mod map;

#[cfg(test)]
mod tests;
