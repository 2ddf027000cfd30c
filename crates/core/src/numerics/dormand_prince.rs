//! One step of Dormand and Prince's method.

/// One step of length `h` of Dormand and Prince's fifth-order Runge-Kutta method for `y' = rate(y)`; the second value
/// is the estimate of its error, the difference to the embedded fourth-order method.
pub(crate) fn step<const N: usize>(
    rate: impl Fn([f64; N]) -> [f64; N],
    state: [f64; N],
    h: f64,
) -> ([f64; N], [f64; N]) {
    let combine = |terms: &[(f64, [f64; N])]| {
        let mut sum = [0.0; N];
        for (factor, rate) in terms {
            for i in 0..N {
                sum[i] += factor * rate[i];
            }
        }
        sum
    };
    let moved = |by: [f64; N]| std::array::from_fn(|i| state[i] + h * by[i]);
    let at = |terms: &[(f64, [f64; N])]| rate(moved(combine(terms)));
    let k1 = rate(state);
    let k2 = at(&[(1.0 / 5.0, k1)]);
    let k3 = at(&[(3.0 / 40.0, k1), (9.0 / 40.0, k2)]);
    let k4 = at(&[(44.0 / 45.0, k1), (-56.0 / 15.0, k2), (32.0 / 9.0, k3)]);
    let k5 = at(&[(19_372.0 / 6561.0, k1), (-25_360.0 / 2187.0, k2), (64_448.0 / 6561.0, k3), (-212.0 / 729.0, k4)]);
    let k6 = at(&[
        (9017.0 / 3168.0, k1),
        (-355.0 / 33.0, k2),
        (46_732.0 / 5247.0, k3),
        (49.0 / 176.0, k4),
        (-5103.0 / 18_656.0, k5),
    ]);
    let next = moved(combine(&[
        (35.0 / 384.0, k1),
        (500.0 / 1113.0, k3),
        (125.0 / 192.0, k4),
        (-2187.0 / 6784.0, k5),
        (11.0 / 84.0, k6),
    ]));
    let k7 = rate(next);
    let error = combine(&[
        (71.0 / 57_600.0, k1),
        (-71.0 / 16_695.0, k3),
        (71.0 / 1920.0, k4),
        (-17_253.0 / 339_200.0, k5),
        (22.0 / 525.0, k6),
        (-1.0 / 40.0, k7),
    ]);
    (next, error.map(|error| h * error))
}

/// How many times longer the next step may be after one with this error over the allowed one; below 1 where the step is
/// to be taken again.
pub(crate) fn growth(error: f64) -> f64 {
    (0.9 * libm::pow(error.max(1e-10), -0.2)).clamp(0.2, 5.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_step_and_its_estimate_have_the_orders_of_the_method() {
        // y'' = -y, and the same time as a third component.
        let rate = |[x, u, _]: [f64; 3]| [u, -x, 1.0];
        let of = |h: f64| {
            let (next, estimate) = step(rate, [1.0, 0.0, 5.0], h);
            assert!((next[2] - 5.0 - h).abs() < 1e-15);
            (f64::hypot(next[0] - h.cos(), next[1] + h.sin()), f64::hypot(estimate[0], estimate[1]))
        };
        for h in [0.4, 0.2] {
            let ((error, estimate), (half_error, half_estimate)) = (of(h), of(0.5 * h));
            assert!((error / half_error).log2() > 5.7, "{h}: {error} {half_error}");
            assert!((estimate / half_estimate).log2() > 4.7, "{h}: {estimate} {half_estimate}");
        }
    }
}
