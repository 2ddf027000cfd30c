//! Steady sliding found by continuation, where Newton's method from the equilibrium on a rigid disc fails or
//! ends with the pad turned far.
//!
//! A soft disc may have several equilibria. That of a brake is reached when it is pressed: under a small share of its
//! preload and with the same share of its friction it is that of springs in contact, which Newton's method with shortened
//! steps finds. From there the share `s` of both is raised to 1, and the equilibrium is followed by its arc length: each
//! point is predicted along the tangent of the branch and corrected on the plane across it (H. B. Keller, "Numerical
//! solution of bifurcation and nonlinear eigenvalue problems", in Applications of Bifurcation Theory, 1977). So a branch
//! that turns back on its way, at a share that falls again for a while, is followed all the same.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{DMatrix, DVector};

use crate::models::pad_on_disc::flexible_disc::contact::loads::ContactLoads;
use crate::models::pad_on_disc::flexible_disc::equations::FlexibleEquations;
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;

/// Length of the first step along the branch. Its unit is the share, or the size of the displacements on a rigid disc.
const FIRST_STEP: f64 = 0.1;

/// The share at which the branch begins.
const FIRST_SHARE: f64 = 1e-3;

/// A longer step is not made, and a shorter one gives up.
const STEPS: (f64, f64) = (1e-5, 0.5);

/// Points of the branch after which it is given up.
const MOST_POINTS: usize = 200;

/// Iterations of one correction.
const CORRECTIONS: usize = 6;

/// Size of the last correction, relative to the displacements. The end of the branch is refined until the steps are
/// lost in rounding.
const CORRECTED: f64 = 1e-6;

/// A pad that has turned over is a solution of the equations, but of no brake.
pub(super) fn is_upright(q: &[f64]) -> bool {
    q[2].abs() < FRAC_PI_2
}

/// The brake with any share of its preload and friction.
struct Branch<'a> {
    equations: &'a FlexibleEquations,
    inputs: RandomInputs,
    /// What displacements are measured in, one after the other.
    units: DVector<f64>,
}

impl FlexibleEquations {
    /// Steady sliding by continuation from nearly none to all of preload and friction; `None` if the branch ends or the
    /// pad turns over on the way.
    pub fn equilibrium_by_rising_load(&self, inputs: RandomInputs) -> Option<Vec<f64>> {
        let (little, of_it) = self.with_share(inputs, FIRST_SHARE);
        let start = little.shortened_newton(of_it, little.equilibrium_on_rigid_disc(of_it))?;
        let whole = self.equilibrium_on_rigid_disc(inputs);
        let size = whole.iter().fold(0.0_f64, |size, q| size.max(q.abs()));
        let mut units = DVector::from_element(start.len(), size);
        // What an angle moves the patch by.
        units[2] = size * self.brake.parameters().disc.thickness / self.brake.parameters().disc.outer_radius;
        let branch = Branch { equations: self, inputs, units };
        let end = branch.follow(DVector::from_vec(start))?;
        self.newton(inputs, end.as_slice().to_vec()).filter(|q| is_upright(q))
    }

    /// The same brake with a share of its preload, and of its friction coefficient at every speed.
    fn with_share(&self, inputs: RandomInputs, share: f64) -> (Self, RandomInputs) {
        let mut equations = self.clone();
        let pad = &mut equations.coefficients.pad;
        pad.kinetic_friction *= share;
        pad.additional_friction *= share;
        let RandomInputs { preload, static_friction } = inputs;
        (equations, RandomInputs { preload: share * preload, static_friction: share * static_friction })
    }

    /// Accelerations at rest.
    fn residual(&self, inputs: RandomInputs, q: &DVector<f64>) -> DVector<f64> {
        let mut accelerations = DVector::zeros(q.len());
        let (rest, mut loads) = (vec![0.0; q.len()], ContactLoads::zero());
        self.accelerations(inputs, ContactState::Slip, q.as_slice(), &rest, &mut loads, accelerations.as_mut_slice());
        accelerations
    }

    /// Newton's method whose steps are halved until the accelerations fall.
    fn shortened_newton(&self, inputs: RandomInputs, start: Vec<f64>) -> Option<Vec<f64>> {
        let mut q = DVector::from_vec(start);
        let mut residual = self.residual(inputs, &q);
        for _ in 0..100 {
            let mut step = self.linearise(inputs, q.as_slice()).0.lu().solve(&residual)?;
            let mut next = None;
            for _ in 0..30 {
                let ahead = self.residual(inputs, &(&q - &step));
                if ahead.norm() < residual.norm() {
                    next = Some(ahead);
                    break;
                }
                step *= 0.5;
            }
            let Some(ahead) = next else { break };
            let is_last = step.amax() < CORRECTED * q.amax();
            q -= &step;
            residual = ahead;
            if is_last {
                break;
            }
        }
        self.newton(inputs, q.as_slice().to_vec()).filter(|q| is_upright(q))
    }
}

impl Branch<'_> {
    /// Follows the branch from its first point to that with all of preload and friction.
    fn follow(&self, start: DVector<f64>) -> Option<DVector<f64>> {
        let (mut q, mut share, mut length) = (start, FIRST_SHARE, FIRST_STEP);
        // The direction in which the share rises first.
        let mut before = (DVector::zeros(q.len()), 1.0);
        for _ in 0..MOST_POINTS {
            let tangent = self.tangent(&q, share, &before)?;
            let point = loop {
                // The last step ends at the whole.
                let reach = share + length * tangent.1;
                let this = if reach > 1.0 { length * (1.0 - share) / (reach - share) } else { length };
                if let Some(point) = self.corrected(&q, share, &tangent, this) {
                    break point;
                }
                length *= 0.5;
                if length < STEPS.0 {
                    return None;
                }
            };
            let (next, at, corrections) = point;
            if !is_upright(next.as_slice()) {
                return None;
            }
            let passed = at >= 1.0 - 1e-6;
            (q, share, before) = (next, at, tangent);
            if passed {
                return Some(q);
            }
            if corrections <= 3 {
                length = (2.0 * length).min(STEPS.1);
            }
        }
        None
    }

    /// Accelerations at a share, and their derivatives by the displacements over their units.
    fn at(&self, q: &DVector<f64>, share: f64) -> (DVector<f64>, DMatrix<f64>) {
        let (equations, inputs) = self.equations.with_share(self.inputs, share);
        let mut stiffness = equations.linearise(inputs, q.as_slice()).0;
        for (mut column, unit) in stiffness.column_iter_mut().zip(self.units.iter()) {
            column *= *unit;
        }
        (equations.residual(inputs, q), stiffness)
    }

    /// Their derivative by the share, in which they are linear.
    fn by_share(&self, q: &DVector<f64>) -> DVector<f64> {
        let of_share = |share: f64| {
            let (equations, inputs) = self.equations.with_share(self.inputs, share);
            equations.residual(inputs, q)
        };
        of_share(1.0) - of_share(0.0)
    }

    /// Solves for displacements over their units and the share: accelerations, and along a direction.
    fn solve(
        &self,
        (q, stiffness): (&DVector<f64>, DMatrix<f64>),
        direction: &(DVector<f64>, f64),
        (accelerations, along): (&DVector<f64>, f64),
    ) -> Option<(DVector<f64>, f64)> {
        let size = q.len();
        let mut matrix = stiffness.resize(size + 1, size + 1, 0.0);
        matrix.view_mut((0, size), (size, 1)).copy_from(&self.by_share(q));
        matrix.view_mut((size, 0), (1, size)).copy_from(&direction.0.transpose());
        matrix[(size, size)] = direction.1;
        let right = accelerations.clone().push(along);
        let solution = matrix.lu().solve(&right)?;
        solution.iter().all(|value| value.is_finite()).then(|| (solution.rows(0, size).into_owned(), solution[size]))
    }

    /// The unit tangent of the branch at a point, in the sense of the one before.
    fn tangent(&self, q: &DVector<f64>, share: f64, before: &(DVector<f64>, f64)) -> Option<(DVector<f64>, f64)> {
        let (residual, stiffness) = self.at(q, share);
        let (direction, by_share) = self.solve((q, stiffness), before, (&(0.0 * residual), 1.0))?;
        let norm = libm::hypot(direction.norm(), by_share);
        Some((direction / norm, by_share / norm))
    }

    /// The point of the branch on the plane across the tangent at a distance, and the corrections that it took.
    fn corrected(
        &self,
        q: &DVector<f64>,
        share: f64,
        tangent: &(DVector<f64>, f64),
        length: f64,
    ) -> Option<(DVector<f64>, f64, usize)> {
        let mut point = q + (&tangent.0 * length).component_mul(&self.units);
        let mut at = share + length * tangent.1;
        let mut last = 2.0 * length;
        for corrections in 1..=CORRECTIONS {
            let (residual, stiffness) = self.at(&point, at);
            let (step, by_share) = self.solve((&point, stiffness), tangent, (&residual, 0.0))?;
            let size = libm::hypot(step.norm(), by_share);
            if size.is_nan() || size > 0.5 * last {
                return None;
            }
            point -= step.component_mul(&self.units);
            at -= by_share;
            if size < CORRECTED {
                return Some((point, at, corrections));
            }
            last = size;
        }
        None
    }
}
