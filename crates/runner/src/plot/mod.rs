//! Plots of results for papers and slides, as SVG and PNG.
//!
//! Everything is drawn by the same few primitives on a [`canvas`], so that all plots look alike; the crate kuva writes
//! them as SVG, PNG or PDF, with metrics of a font of its own.

pub mod canvas;

pub mod drawing;

pub mod contours;

pub mod levels;

pub mod panel;

pub mod legend;

pub mod histogram;

pub mod axes;

pub mod values;

pub mod form;

pub mod curves;

pub mod area;

pub mod regions;

pub mod cells;

pub mod level_lines;

pub mod limit_lines;

pub mod surface;

pub mod difference;

pub mod sobol;

pub mod verdict_map;

pub mod chart;

pub mod motion;

pub mod fit;

pub mod modes;

pub mod frequencies;

pub mod inputs;

pub mod scatter;

pub mod convergence;

pub mod distribution;
