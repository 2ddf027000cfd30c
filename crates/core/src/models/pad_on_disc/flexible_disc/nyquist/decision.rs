//! What the response says of each sample of a batch.

use crate::models::pad_on_disc::flexible_disc::geometry::DiscGeometry;
use crate::models::pad_on_disc::flexible_disc::nyquist::batch::{Batch, Finding};
use crate::models::pad_on_disc::flexible_disc::nyquist::bounds::{Couplings, SLACK};
use crate::models::pad_on_disc::flexible_disc::nyquist::crossing::{Crossing, crossing};
use crate::models::pad_on_disc::flexible_disc::nyquist::matrices::{
    Places, find_equilibrium, set_amplitudes, set_matrix,
};
use crate::numerics::row::Row;

/// Beyond this frequency over omega_x a single bound covers all.
const END: f64 = 8.0;

/// Intervals of frequency over omega_x on which h is bounded: those up to 0.68, and those from 1.32 to [`END`].
const FAR: [(f64, f64); 19] = [
    (0.0, 0.05),
    (0.05, 0.1),
    (0.1, 0.2),
    (0.2, 0.28),
    (0.28, 0.34),
    (0.34, 0.38),
    (0.38, 0.42),
    (0.42, 0.46),
    (0.46, 0.5),
    (0.5, 0.54),
    (0.54, 0.58),
    (0.58, 0.62),
    (0.62, 0.65),
    (0.65, 0.68),
    (4.0, END),
    (2.5, 4.0),
    (1.8, 2.5),
    (1.5, 1.8),
    (1.32, 1.5),
];

/// Half widths of the interval about omega_x, over omega_x. Each is half of the one before, and twice the first reaches
/// to [`FAR`].
const HALF_WIDTHS: [f64; 6] = [0.16, 0.08, 0.04, 0.02, 0.01, 0.005];

/// Decides the samples of a batch.
#[inline(always)]
pub(crate) fn decide<const L: usize>(geometry: &DiscGeometry, batch: &mut Batch<L>) {
    let Batch { coefficients: of, work, findings } = batch;
    set_amplitudes(geometry, of, work);
    let found = find_equilibrium(geometry, of, work);
    let places = Places::new(geometry);
    set_matrix(places, &geometry.patch.averages, of, work, true);
    let couplings = Couplings::of_scaled(places, &geometry.patch.averages, of, work);
    let omega = couplings.x_stiffness.sqrt();
    let half_width = half_width(&couplings, omega);
    let Crossing { falling, steady } = crossing(geometry, of, work, &couplings, omega, half_width);
    for l in 0..L {
        findings[l] = if found[l] == 0 {
            Finding::Open
        } else if falling.0[l] > 0.0 {
            Finding::Stable
        } else if falling.0[l] < 0.0 && steady.0[l] > 0.0 {
            Finding::FedByFriction
        } else {
            Finding::Open
        };
    }
}

/// Half of the interval about omega_x beyond which `|h| < |A_xx - omega^2|`, over omega_x; 0 if there is none.
#[inline(always)]
fn half_width<const L: usize>(couplings: &Couplings<L>, omega: Row<L>) -> Row<L> {
    let stiffness = couplings.x_stiffness;
    let mut holds = [1_u64; L];
    narrow(&mut holds, stiffness, couplings.beyond(END * omega).x, END);
    let mut half = Row::ZERO;
    let mut intervals = 0;
    // One loop over all intervals: its body is long.
    while intervals < FAR.len() + 2 * HALF_WIDTHS.len() {
        let place = intervals.wrapping_sub(FAR.len());
        let (low, high) = if intervals < FAR.len() {
            FAR[intervals]
        } else {
            let width = HALF_WIDTHS[place / 2];
            if place % 2 == 0 { (1.0 - 2.0 * width, 1.0 - width) } else { (1.0 + width, 1.0 + 2.0 * width) }
        };
        let bound = couplings.between(low * omega, high * omega).x;
        narrow(&mut holds, stiffness, bound, if high < 1.0 { high } else { low });
        if intervals >= FAR.len() && place % 2 == 1 {
            for (half, holds) in half.0.iter_mut().zip(&holds) {
                *half = if *holds == 1 { HALF_WIDTHS[place / 2] } else { *half };
            }
        }
        intervals += 1;
    }
    half
}

/// Clears `holds` in lanes where h may be larger than `|A_xx - omega^2|` at `at` times omega_x.
#[inline(always)]
fn narrow<const L: usize>(holds: &mut [u64; L], stiffness: Row<L>, bound: Row<L>, at: f64) {
    let distance = (at * at - 1.0).abs() * (2.0 - SLACK);
    for (holds, (bound, stiffness)) in holds.iter_mut().zip(bound.0.iter().zip(&stiffness.0)) {
        *holds &= u64::from(*bound < distance * stiffness);
    }
}

#[cfg(test)]
mod tests;
