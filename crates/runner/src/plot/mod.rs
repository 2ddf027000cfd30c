//! Plots of results for papers and slides, as SVG, PDF and PNG.
//!
//! Everything is drawn by the same few shapes on a [`canvas`], so that all plots look alike. Pages and images
//! have a font that is part of the program.

pub mod canvas;

pub mod svg;

pub mod font;

pub mod png;

pub mod pdf;

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

pub mod friction;
