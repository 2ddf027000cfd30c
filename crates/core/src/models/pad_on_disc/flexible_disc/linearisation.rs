//! The linearised equations of motion.

use nalgebra::DMatrix;

use crate::models::pad_on_disc::flexible_disc::contact::node::ContactNode;
use crate::models::pad_on_disc::flexible_disc::equations::{FlexibleEquations, friction_slope};
use crate::models::pad_on_disc::pad::equations::PAD;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use crate::numerics::sine_cosine::sine_and_cosine;

impl FlexibleEquations {
    /// The derivatives of the accelerations in slip by displacements and by speeds, at rest in `q`.
    pub fn linearise(&self, inputs: RandomInputs, q: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
        let mu = self.coefficients.pad.steady_friction(inputs.static_friction);
        self.linearise_with(q, mu, self.friction_slope(inputs.static_friction))
    }

    /// The rise of the friction coefficient with the pad's speed in steady sliding, `d mu / d x'`: how steeply friction
    /// falls.
    pub fn friction_slope(&self, static_friction: f64) -> f64 {
        friction_slope(&self.brake, &self.coefficients.pad, static_friction)
    }

    /// [`FlexibleEquations::linearise`] for a friction coefficient and its slope, whatever law gives them.
    pub fn linearise_with(&self, q: &[f64], mu: f64, mu_by_speed: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        let (pad, size) = (&self.coefficients.pad, self.size());
        let (sine, cosine) = sine_and_cosine(q[2]);
        let tilt_by_angle = self.coefficients.tilt_scale / (cosine * cosine);
        let position = self.position(q, (sine, cosine));
        // Loads and their derivatives by y, phi and the amplitudes, node by node.
        let modes = self.coefficients.amplitudes.len();
        let mut pressure = 0.0;
        let mut by_gap = DMatrix::<f64>::zeros(1 + 2 * modes, size);
        let mut follower = vec![0.0; modes];
        let (mut gap_by, mut weighted) = (vec![0.0; size], vec![0.0; modes]);
        self.geometry.patch.for_each_contact(position, &q[PAD..], |node| {
            let &ContactNode { weight, gap, slope, arc, shapes, slopes } = node;
            pressure += weight * gap;
            gap_by[1] = -1.0;
            gap_by[2] = -arc * tilt_by_angle;
            gap_by[PAD..].copy_from_slice(shapes);
            weighted.iter_mut().zip(shapes).for_each(|(weighted, shape)| *weighted = weight * shape);
            for (column, (sums, gap_by)) in
                by_gap.as_mut_slice().chunks_exact_mut(1 + 2 * modes).zip(&gap_by).enumerate()
            {
                let slope_by = if column >= PAD { slopes[column - PAD] } else { 0.0 };
                let follower_by = gap_by * slope + gap * slope_by;
                sums[0] += weight * gap_by;
                let (on_modes, follower) = sums[1..].split_at_mut(modes);
                for ((on_mode, follower), weighted) in on_modes.iter_mut().zip(follower).zip(&weighted) {
                    *on_mode += weighted * gap_by;
                    *follower += weighted * follower_by;
                }
            }
            for (follower, shape) in follower.iter_mut().zip(shapes) {
                *follower += weight * shape * gap * slope;
            }
        });
        let pressure = pad.pressure_gain * pressure;
        let spring = pad.contact_tangential * q[0] - pad.transmission * mu * pressure;

        let mut stiffness = DMatrix::zeros(size, size);
        let mut damping = DMatrix::zeros(size, size);
        for column in 0..size {
            let by = |row: usize| f64::from(u8::from(row == column));
            let pressure_by = pad.pressure_gain * by_gap[(0, column)];
            let spring_by = pad.contact_tangential * by(0) - pad.transmission * mu * pressure_by;
            let (sine_by, cosine_by) = (cosine * by(2), -sine * by(2));
            stiffness[(0, column)] = -(pad.tangential_stiffness * by(0)
                + pressure_by * sine
                + pressure * sine_by
                + spring_by * cosine
                + spring * cosine_by);
            stiffness[(1, column)] = -(pad.normal_stiffness * by(1) - pressure_by * cosine - pressure * cosine_by
                + spring_by * sine
                + spring * sine_by);
            stiffness[(2, column)] = -(pad.angular_stiffness * by(2) + pad.arm * spring_by);
            for (k, amplitude) in self.coefficients.amplitudes.iter().enumerate() {
                stiffness[(PAD + k, column)] = -amplitude.stiffness * by(PAD + k)
                    - amplitude.compliance
                        * (by_gap[(1 + k, column)]
                            + mu * self.coefficients.slope_scale * by_gap[(1 + modes + k, column)]);
            }
        }
        let spring_by_speed = -pad.transmission * mu_by_speed * pressure;
        damping[(0, 0)] = -(pad.tangential_damping + spring_by_speed * cosine);
        damping[(1, 0)] = -spring_by_speed * sine;
        damping[(1, 1)] = -pad.normal_damping;
        damping[(2, 0)] = -pad.arm * spring_by_speed;
        damping[(2, 2)] = -pad.angular_damping;
        for (k, amplitude) in self.coefficients.amplitudes.iter().enumerate() {
            damping[(PAD + k, PAD + k)] = -self.coefficients.disc_damping;
            damping[(PAD + k, PAD + amplitude.partner)] -= amplitude.gyroscopic;
            damping[(PAD + k, 0)] = -amplitude.compliance * mu_by_speed * self.coefficients.slope_scale * follower[k];
        }
        (stiffness, damping)
    }
}

/// The matrix of `q'' = stiffness q + damping q'` as a system of first order.
pub(crate) fn first_order(stiffness: &DMatrix<f64>, damping: &DMatrix<f64>) -> DMatrix<f64> {
    let size = stiffness.nrows();
    let mut matrix = DMatrix::zeros(2 * size, 2 * size);
    for i in 0..size {
        matrix[(i, size + i)] = 1.0;
        for j in 0..size {
            matrix[(size + i, j)] = stiffness[(i, j)];
            matrix[(size + i, size + j)] = damping[(i, j)];
        }
    }
    matrix
}
