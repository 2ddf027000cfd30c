//! What the response says of each sample of a batch.

use crate::flexible_disc::geometry::DiscGeometry;
use crate::flexible_disc::nyquist::batch::{Batch, Finding};
use crate::flexible_disc::nyquist::bounds::{Couplings, SLACK};
use crate::flexible_disc::nyquist::crossing::{Crossing, crossing};
use crate::flexible_disc::nyquist::matrices::{Places, find_equilibrium, set_amplitudes, set_matrix};
use crate::flexible_disc::nyquist::row::Row;

/// Frequencies over omega_x between which h is bounded below and above omega_x, from far to near.
const FAR_BELOW: [f64; 15] = [0.0, 0.05, 0.1, 0.2, 0.28, 0.34, 0.38, 0.42, 0.46, 0.5, 0.54, 0.58, 0.62, 0.65, 0.68];
const FAR_ABOVE: [f64; 6] = [8.0, 4.0, 2.5, 1.8, 1.5, 1.32];

/// Half widths of the interval about omega_x, over omega_x; each is half of the one before.
const HALF_WIDTHS: [f64; 6] = [0.16, 0.08, 0.04, 0.02, 0.01, 0.005];

/// Decides the samples of a batch.
#[inline(always)]
pub(crate) fn decide<const L: usize>(geometry: &DiscGeometry, batch: &mut Batch<L>) {
    let Batch { coefficients: of, work, findings } = batch;
    set_amplitudes(geometry, of, work);
    let found = find_equilibrium(geometry, of, work);
    let places = Places::of(geometry);
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
    let narrow = |holds: &mut [u64; L], bound: Row<L>, at: f64| {
        let distance = (at * at - 1.0).abs() * (2.0 - SLACK);
        for l in 0..L {
            holds[l] &= u64::from(bound.0[l] < distance * stiffness.0[l]);
        }
    };
    narrow(&mut holds, couplings.beyond(FAR_ABOVE[0] * omega).x, FAR_ABOVE[0]);
    for edges in FAR_ABOVE.windows(2) {
        narrow(&mut holds, couplings.between(edges[1] * omega, edges[0] * omega).x, edges[1]);
    }
    for edges in FAR_BELOW.windows(2) {
        narrow(&mut holds, couplings.between(edges[0] * omega, edges[1] * omega).x, edges[1]);
    }
    let mut half = Row::ZERO;
    for width in HALF_WIDTHS {
        let below = couplings.between((1.0 - 2.0 * width) * omega, (1.0 - width) * omega);
        narrow(&mut holds, below.x, 1.0 - width);
        let above = couplings.between((1.0 + width) * omega, (1.0 + 2.0 * width) * omega);
        narrow(&mut holds, above.x, 1.0 + width);
        for l in 0..L {
            half.0[l] = if holds[l] == 1 { width } else { half.0[l] };
        }
    }
    half
}
