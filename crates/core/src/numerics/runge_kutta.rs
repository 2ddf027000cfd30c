//! One step of the classical Runge-Kutta method.

use crate::numerics::row::Number;

/// Equations of motion `q'' = a(q, u)`, `u = q'`. A trait and not a closure: what is not inlined is compiled for the
/// processor's baseline.
pub(crate) trait Accelerations<N> {
    /// The accelerations at displacements `q` and speeds `u`.
    fn accelerations(&mut self, q: &[N], u: &[N], accelerations: &mut [N]);
}

/// Displacements and speeds after a step, and the acceleration of the first displacement at its beginning and as the
/// last stage sees it at its end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepEnd<N, const D: usize> {
    pub q: [N; D],
    pub u: [N; D],
    pub acceleration: (N, N),
}

/// One step of length `h` from displacements `q` and speeds `u`, of which the first `size` count.
#[inline(always)]
pub(crate) fn step<N: Number, const D: usize>(
    equations: &mut impl Accelerations<N>,
    size: usize,
    (q, u): (&[N; D], &[N; D]),
    h: N,
) -> StepEnd<N, D> {
    let (mut next_q, mut next_u) = (*q, *u);
    let mut k = [[N::default(); D]; 4];
    step_in_place(equations, (&q[..size], &u[..size]), h, (&mut next_q[..size], &mut next_u[..size]), &mut k);
    StepEnd { q: next_q, u: next_u, acceleration: (k[0][0], k[3][0]) }
}

/// The same in given memory; `k` gets the accelerations at the four stages.
#[inline(always)]
pub(crate) fn step_in_place<N: Number>(
    equations: &mut impl Accelerations<N>,
    (q, u): (&[N], &[N]),
    h: N,
    (next_q, next_u): (&mut [N], &mut [N]),
    k: &mut [impl AsMut<[N]>; 4],
) {
    let n = q.len();
    let (half, sixth) = (N::splat(0.5) * h, h / N::splat(6.0));
    next_q.copy_from_slice(q);
    next_u.copy_from_slice(u);
    // One copy of the accelerations, not four: with many lanes the loop over stages has to stay in the processor's cache
    // of instructions.
    for (stage, k) in k.iter_mut().enumerate() {
        let k = &mut k.as_mut()[..n];
        equations.accelerations(next_q, next_u, k);
        if stage == 3 {
            break;
        }
        let part = if stage < 2 { half } else { h };
        for i in 0..n {
            N::keep_lanes_together();
            next_q[i] = q[i] + part * next_u[i];
            next_u[i] = u[i] + part * k[i];
        }
    }
    let [k1, k2, k3, k4] = k.each_mut().map(AsMut::as_mut);
    for i in 0..n {
        N::keep_lanes_together();
        next_q[i] = q[i] + h * (u[i] + sixth * (k1[i] + k2[i] + k3[i]));
        next_u[i] = u[i] + sixth * (k1[i] + N::splat(2.0) * (k2[i] + k3[i]) + k4[i]);
    }
}
