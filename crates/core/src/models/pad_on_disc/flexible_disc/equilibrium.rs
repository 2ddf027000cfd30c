//! Steady sliding of pad and flexible disc together.

use nalgebra::{DMatrix, DVector};

use crate::models::pad_on_disc::flexible_disc::contact::loads::ContactLoads;
use crate::models::pad_on_disc::flexible_disc::continuation::is_upright;
use crate::models::pad_on_disc::flexible_disc::equations::FlexibleEquations;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::equations::PAD;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{LARGEST_ROTATION, RandomInputs};

/// Finds equilibria by Newton's method with the linearisation at one operating point.
#[derive(Debug, Clone)]
pub(crate) struct EquilibriumSearch {
    /// Of the derivatives of the accelerations by the displacements, unless they are singular there.
    approximate_inverse: Option<DMatrix<f64>>,
}

impl EquilibriumSearch {
    /// Linearises at the operating point of the brake, or at the preset's preload if that has none.
    pub fn new(equations: &FlexibleEquations) -> Self {
        let parameters = equations.brake.parameters();
        let preload = parameters.operating_point.preload;
        let inputs = RandomInputs {
            preload: if preload > 0.0 { preload } else { 0.1 },
            static_friction: parameters.friction.static_coefficient,
        };
        let at = equations.equilibrium_on_rigid_disc(inputs);
        let (stiffness, _) = equations.linearise(inputs, &at);
        Self { approximate_inverse: stiffness.try_inverse() }
    }

    /// The displacements of steady sliding: all accelerations vanish without any speed, as far as numbers resolve it.
    /// A soft disc may have several. One near that of a rigid disc, within small angles, is taken; else that on the branch
    /// from nearly none to all of preload and friction.
    ///
    /// # Errors
    /// [`FlexibleError::NotPressed`] for a preload of zero or less, [`FlexibleError::NoEquilibrium`] if neither Newton's
    /// method nor [continuation](FlexibleEquations::equilibrium_by_rising_load) finds one,
    /// [`FlexibleError::Rotated`] if the pad turns too far in it.
    pub fn find(&self, equations: &FlexibleEquations, inputs: RandomInputs) -> Result<Vec<f64>, FlexibleError> {
        if inputs.preload.is_nan() || inputs.preload <= 0.0 {
            return Err(FlexibleError::NotPressed { preload: inputs.preload });
        }
        let found = match self.near_rigid_disc(equations, inputs) {
            Some(q) if q[2].abs() <= LARGEST_ROTATION => Some(q),
            elsewhere => equations.equilibrium_by_rising_load(inputs).or(elsewhere),
        };
        let RandomInputs { preload, static_friction } = inputs;
        match found {
            Some(q) if q[2].abs() > LARGEST_ROTATION => Err(FlexibleError::Rotated { angle: q[2] }),
            Some(q) => Ok(q),
            None => Err(FlexibleError::NoEquilibrium { preload, static_friction }),
        }
    }

    /// By Newton's method from the equilibrium on a rigid disc, which may end on another branch: far away, with the pad
    /// turned.
    pub(super) fn near_rigid_disc(&self, equations: &FlexibleEquations, inputs: RandomInputs) -> Option<Vec<f64>> {
        let start = equations.equilibrium_on_rigid_disc(inputs);
        let inverse = self.approximate_inverse.as_ref();
        let found = inverse.and_then(|inverse| equations.iterate(inputs, start.clone(), inverse));
        // The fixed linearisation may be too far off: linearise again at each step.
        found.or_else(|| equations.newton(inputs, start)).filter(|q| is_upright(q))
    }
}

impl FlexibleEquations {
    /// Steady sliding as if the disc did not yield.
    pub fn equilibrium_on_rigid_disc(&self, inputs: RandomInputs) -> Vec<f64> {
        let rigid = self.brake.sliding_equilibrium_at(inputs);
        let mut q = vec![0.0; self.size()];
        q[..PAD].copy_from_slice(&[rigid.tangential, rigid.normal, rigid.angle]);
        q
    }

    /// Newton's method, linearised again at each step.
    pub(super) fn newton(&self, inputs: RandomInputs, mut q: Vec<f64>) -> Option<Vec<f64>> {
        let mut inverse = DMatrix::zeros(0, 0);
        for _ in 0..50 {
            inverse = self.linearise(inputs, &q).0.try_inverse()?;
            match self.iterate_once(inputs, &mut q, &inverse) {
                step if step.is_nan() => return None,
                step if step < 1e-3 => break,
                _ => {}
            }
        }
        self.iterate(inputs, q, &inverse)
    }

    /// Newton's method with a fixed linearisation, until the steps are lost in rounding.
    fn iterate(&self, inputs: RandomInputs, mut q: Vec<f64>, inverse: &DMatrix<f64>) -> Option<Vec<f64>> {
        let mut before = f64::INFINITY;
        for _ in 0..60 {
            let step = self.iterate_once(inputs, &mut q, inverse);
            let shrinks = step < 0.5 * before;
            if !shrinks {
                // It shrinks no more: converged if that happens among rounding errors.
                return (step.max(before) < 1e-13).then_some(q);
            }
            before = step;
        }
        None
    }

    /// One step; returns its size relative to the displacements.
    fn iterate_once(&self, inputs: RandomInputs, q: &mut [f64], inverse: &DMatrix<f64>) -> f64 {
        let size = self.size();
        let mut loads = ContactLoads::zero();
        let (rest, mut rate) = (vec![0.0; size], vec![0.0; size]);
        self.accelerations(inputs, ContactState::Slip, q, &rest, &mut loads, &mut rate);
        let step = inverse * DVector::from_vec(rate);
        let (mut largest, mut scale) = (0.0_f64, 0.0_f64);
        for (q, step) in q.iter_mut().zip(step.iter()) {
            *q -= step;
            largest = if step.abs() > largest || step.is_nan() { step.abs() } else { largest };
            scale = scale.max(q.abs());
        }
        largest / scale
    }
}
