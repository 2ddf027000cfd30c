//! Quadrature points of the patch.

use crate::models::pad_on_disc::flexible_disc::contact::position::PadPosition;

/// One quadrature point.
#[derive(Debug, Clone)]
pub(super) struct Node {
    /// Share of the patch's area.
    pub weight: f64,
    /// r theta.
    pub arc: f64,
    /// psi_k of every amplitude, even ones first.
    pub shapes: Vec<f64>,
    /// (1/r) d psi_k / d theta.
    pub slopes: Vec<f64>,
}

/// A node in contact, with what is known there.
pub(crate) struct ContactNode<'a> {
    /// Share of the patch's area.
    pub weight: f64,
    /// g.
    pub gap: f64,
    /// w_theta / r.
    pub slope: f64,
    /// r theta.
    pub arc: f64,
    /// psi_k of every amplitude.
    pub shapes: &'a [f64],
    /// (1/r) d psi_k / d theta.
    pub slopes: &'a [f64],
}

impl Node {
    pub fn gap_and_slope(&self, pad: PadPosition, amplitudes: &[f64]) -> (f64, f64) {
        let (mut gap, mut slope) = (-pad.normal - self.arc * pad.tilt, 0.0);
        for ((amplitude, shape), shape_slope) in amplitudes.iter().zip(&self.shapes).zip(&self.slopes) {
            gap += amplitude * shape;
            slope += amplitude * shape_slope;
        }
        (gap, slope)
    }
}
