//! The motion of the plate in explicit steps.

use crate::models::pad_on_disc::finite_difference::plate::grid::{PlateGrid, Stencil};

/// Nodes repeated on either side of a ring, so that stencils need not wrap around.
const HALO: usize = 2;

/// Rings of zeros inside and outside of the plate, so that stencils need not end.
const MARGIN: usize = 2;

/// Deflections and speeds of the nodes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlateMotion {
    /// w, ring by ring with halo and margin.
    deflections: Vec<f64>,
    /// W_t in the disc's frame, half a step behind.
    speeds: Vec<f64>,
}

/// What explicit steps of a certain length multiply with.
#[derive(Debug, Clone)]
pub(crate) struct ExplicitStep {
    length: f64,
    /// The share of the speed that damping leaves, and the speed that one unit of force brings.
    keep: f64,
    gain: f64,
    /// `eta1 Om / (2 dtheta)` times the gain.
    drag: f64,
    stencils: Vec<Stencil>,
}

impl PlateGrid {
    fn stride(&self) -> usize {
        self.columns + 2 * HALO
    }

    /// Where a ring, 1 to the edge, begins among the deflections, less its halo.
    fn begin(&self, ring: usize) -> usize {
        (ring - 1 + MARGIN) * self.stride()
    }

    /// The plate at rest with `deflection` (ring by ring).
    pub fn at_rest(&self, deflection: &[f64]) -> PlateMotion {
        let deflections = vec![0.0; (self.rings + 2 * MARGIN) * self.stride()];
        let mut motion = PlateMotion { deflections, speeds: vec![0.0; deflection.len()] };
        for (ring, row) in deflection.chunks_exact(self.columns).enumerate() {
            let begin = self.begin(ring + 1) + HALO;
            motion.deflections[begin..begin + self.columns].copy_from_slice(row);
        }
        self.repeat_ends(&mut motion);
        motion
    }

    /// The plate with a deflection that stands still in the frame in which the disc turns with `spin`; speeds half a
    /// step of `length` behind.
    pub fn standing_still(&self, deflection: &[f64], spin: f64, length: f64) -> PlateMotion {
        let mut motion = self.at_rest(deflection);
        for ring in 1..=self.rings {
            for column in 0..self.columns {
                let at = self.begin(ring) + HALO + column;
                let [behind, own, ahead] =
                    [-1, 0, 1].map(|next: isize| motion.deflections[at.wrapping_add_signed(next)]);
                let speed = spin * (ahead - behind) / (2.0 * self.angle);
                let acceleration = spin * spin * (ahead - 2.0 * own + behind) / (self.angle * self.angle);
                motion.speeds[(ring - 1) * self.columns + column] = speed - 0.5 * length * acceleration;
            }
        }
        motion
    }

    fn repeat_ends(&self, motion: &mut PlateMotion) {
        for row in motion.deflections.chunks_exact_mut(self.stride()) {
            row.copy_within(self.columns..self.columns + HALO, 0);
            row.copy_within(HALO..2 * HALO, self.columns + HALO);
        }
    }

    /// Deflections of the four nodes from the one before `column` on, on a ring; all zero on the clamped rim, ring 0.
    pub fn four_nodes(&self, motion: &PlateMotion, ring: usize, column: usize) -> [f64; 4] {
        let at = (ring + MARGIN - 1) * self.stride() + HALO + column;
        [motion.deflections[at - 1], motion.deflections[at], motion.deflections[at + 1], motion.deflections[at + 2]]
    }

    /// Explicit steps of `length` with the damping `eta1 (W_t - Om W_theta)`, that of the space-fixed frame in which
    /// the disc turns with `spin`.
    pub fn explicit_step(&self, length: f64, damping: f64, spin: f64) -> ExplicitStep {
        let loss = 0.5 * damping * length;
        let gain = length / (1.0 + loss);
        ExplicitStep {
            length,
            keep: (1.0 - loss) / (1.0 + loss),
            gain,
            drag: gain * damping * spin / (2.0 * self.angle),
            stencils: (1..=self.rings).map(|ring| self.stencil(ring, gain)).collect(),
        }
    }

    /// Speeds from half a step behind to half a step ahead, without loads: central differences in time.
    pub fn accelerate(&self, step: &ExplicitStep, motion: &mut PlateMotion) {
        let (columns, stride) = (self.columns, self.stride());
        for ((ring, stencil), speeds) in (1..).zip(&step.stencils).zip(motion.speeds.chunks_exact_mut(columns)) {
            let row = |offset: usize, nodes: usize| {
                let begin = self.begin(ring) + offset * stride - MARGIN * stride + HALO - nodes;
                &motion.deflections[begin..begin + columns + 2 * nodes]
            };
            let (far_inside, inside, own, outside, far_outside) =
                (row(0, 0), row(1, 1), row(2, 2), row(3, 1), row(4, 0));
            let s = stencil;
            for (j, speed) in speeds.iter_mut().enumerate() {
                let force = s.own[0] * own[j + 2]
                    + s.own[1] * (own[j + 1] + own[j + 3])
                    + s.own[2] * (own[j] + own[j + 4])
                    + s.inside[0] * inside[j + 1]
                    + s.inside[1] * (inside[j] + inside[j + 2])
                    + s.outside[0] * outside[j + 1]
                    + s.outside[1] * (outside[j] + outside[j + 2])
                    + s.far_inside * far_inside[j]
                    + s.far_outside * far_outside[j];
                *speed = step.keep * *speed - force + step.drag * (own[j + 3] - own[j + 1]);
            }
        }
    }

    /// Adds what a load (an acceleration) on one node does to its speed.
    pub fn push(&self, step: &ExplicitStep, motion: &mut PlateMotion, ring: usize, column: usize, load: f64) {
        motion.speeds[(ring - 1) * self.columns + column] += step.gain * load;
    }

    /// Deflections one step on.
    pub fn drift(&self, step: &ExplicitStep, motion: &mut PlateMotion) {
        let first = self.begin(1);
        let rows = motion.deflections[first..].chunks_exact_mut(self.stride());
        for (row, speeds) in rows.zip(motion.speeds.chunks_exact(self.columns)) {
            for (w, speed) in row[HALO..].iter_mut().zip(speeds) {
                *w += step.length * speed;
            }
        }
        self.repeat_ends(motion);
    }
}

#[cfg(test)]
mod tests;
