//! The linearised equations of motion.

use nalgebra::DMatrix;

use crate::models::pad_on_disc::flexible_disc::contact::node::ContactNode;
use crate::models::pad_on_disc::flexible_disc::equations::{FlexibleEquations, friction_slope};
use crate::models::pad_on_disc::pad::equations::PAD;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use crate::numerics::eigenvalues::{EigenvalueError, eigenvalues};
use crate::numerics::sine_cosine::sine_and_cosine;

/// The linearised equations at one point, for any slope of the friction.
pub(crate) struct Linearisation {
    /// The derivatives of the accelerations in slip by displacements.
    pub stiffness: DMatrix<f64>,
    /// Those by speeds, as long as friction does not change with speed.
    pub damping: DMatrix<f64>,
    /// What one unit of slope adds to them.
    pub damping_by_slope: DMatrix<f64>,
}

impl Linearisation {
    /// The matrix of `q'' = stiffness q + damping q'` as a system of first order.
    pub fn first_order(&self, slope: f64) -> DMatrix<f64> {
        first_order(&self.stiffness, &(&self.damping + &self.damping_by_slope * slope))
    }

    /// The largest real part of its eigenvalues.
    pub fn growth_rate(&self, slope: f64) -> Result<f64, EigenvalueError> {
        let values = eigenvalues(&self.first_order(slope))?;
        Ok(values.first().map_or(f64::NEG_INFINITY, |value| value.re))
    }
}

impl FlexibleEquations {
    /// The derivatives of the accelerations in slip by displacements and by speeds, at rest in `q`.
    pub fn linearise(&self, inputs: RandomInputs, q: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
        let mu = self.coefficients.pad.steady_friction(inputs.static_friction);
        let Linearisation { stiffness, damping, damping_by_slope } = self.linearise_with(q, mu);
        (stiffness, damping + damping_by_slope * self.friction_slope(inputs.static_friction))
    }

    /// The rise of the friction coefficient with the pad's speed in steady sliding, `d mu / d x'`: how steeply friction
    /// falls.
    pub fn friction_slope(&self, static_friction: f64) -> f64 {
        friction_slope(&self.brake, &self.coefficients.pad, static_friction)
    }

    /// [`FlexibleEquations::linearise`] for a friction coefficient, whatever law gives it.
    pub fn linearise_with(&self, q: &[f64], mu: f64) -> Linearisation {
        let (pad, size) = (&self.coefficients.pad, self.size());
        let (sine, cosine) = sine_and_cosine(q[2]);
        let tilt_by_angle = self.coefficients.tilt_scale / (cosine * cosine);
        let position = self.position(q, (sine, cosine));
        // The pressure and the load on each mode, that of friction on its slope with it, by y, phi and the amplitudes, node
        // by node.
        let modes = self.coefficients.amplitudes.len();
        let ratio = mu * self.coefficients.slope_scale;
        let mut pressure = 0.0;
        let mut by = DMatrix::<f64>::zeros(1 + modes, size);
        let mut follower = vec![0.0; modes];
        let (mut gap_by, mut weighted) = (vec![0.0; size], vec![0.0; modes]);
        self.geometry.patch.for_each_contact(position, &q[PAD..], |node| {
            let &ContactNode { weight, gap, slope, arc, shapes, slopes } = node;
            pressure += weight * gap;
            gap_by[1] = -1.0;
            gap_by[2] = -arc * tilt_by_angle;
            gap_by[PAD..].copy_from_slice(shapes);
            weighted.iter_mut().zip(shapes).for_each(|(weighted, shape)| *weighted = weight * shape);
            for (column, (sums, gap_by)) in by.as_mut_slice().chunks_exact_mut(1 + modes).zip(&gap_by).enumerate() {
                let slope_by = if column >= PAD { slopes[column - PAD] } else { 0.0 };
                let load_by = gap_by + ratio * (gap_by * slope + gap * slope_by);
                sums[0] += weight * gap_by;
                for (sum, weighted) in sums[1..].iter_mut().zip(&weighted) {
                    *sum += weighted * load_by;
                }
            }
            for (follower, weighted) in follower.iter_mut().zip(&weighted) {
                *follower += weighted * (gap * slope);
            }
        });
        let pressure = pad.pressure_gain * pressure;
        let spring = pad.contact_tangential * q[0] - pad.transmission * mu * pressure;

        let mut stiffness = DMatrix::zeros(size, size);
        let mut damping = DMatrix::zeros(size, size);
        let mut damping_by_slope = DMatrix::zeros(size, size);
        for column in 0..size {
            let is = |row: usize| f64::from(u8::from(row == column));
            let pressure_by = pad.pressure_gain * by[(0, column)];
            let spring_by = pad.contact_tangential * is(0) - pad.transmission * mu * pressure_by;
            let (sine_by, cosine_by) = (cosine * is(2), -sine * is(2));
            stiffness[(0, column)] = -(pad.tangential_stiffness * is(0)
                + pressure_by * sine
                + pressure * sine_by
                + spring_by * cosine
                + spring * cosine_by);
            stiffness[(1, column)] = -(pad.normal_stiffness * is(1) - pressure_by * cosine - pressure * cosine_by
                + spring_by * sine
                + spring * sine_by);
            stiffness[(2, column)] = -(pad.angular_stiffness * is(2) + pad.arm * spring_by);
            for (k, amplitude) in self.coefficients.amplitudes.iter().enumerate() {
                stiffness[(PAD + k, column)] =
                    -amplitude.stiffness * is(PAD + k) - amplitude.compliance * by[(1 + k, column)];
            }
        }
        damping[(0, 0)] = -pad.tangential_damping;
        damping[(1, 1)] = -pad.normal_damping;
        damping[(2, 2)] = -pad.angular_damping;
        let spring_by_slope = -pad.transmission * pressure;
        damping_by_slope[(0, 0)] = -spring_by_slope * cosine;
        damping_by_slope[(1, 0)] = -spring_by_slope * sine;
        damping_by_slope[(2, 0)] = -pad.arm * spring_by_slope;
        for (k, amplitude) in self.coefficients.amplitudes.iter().enumerate() {
            damping[(PAD + k, PAD + k)] = -self.coefficients.disc_damping;
            damping[(PAD + k, PAD + amplitude.partner)] -= amplitude.gyroscopic;
            damping_by_slope[(PAD + k, 0)] = -amplitude.compliance * self.coefficients.slope_scale * follower[k];
        }
        Linearisation { stiffness, damping, damping_by_slope }
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
