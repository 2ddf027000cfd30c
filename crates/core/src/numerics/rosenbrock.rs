//! One step of a Rosenbrock method for stiff motions with one degree of freedom.

/// The Jacobian of `x' = u`, `u' = f(x, u)`: the derivatives of f by x and by u.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slopes {
    pub by_x: f64,
    pub by_u: f64,
}

/// One step of length `h` of the method RODAS (Hairer and Wanner, *Solving Ordinary Differential Equations II*, section
/// IV.7) for `state' = rate(state)`, which begins with these slopes; the second value is the estimate of its error, the
/// difference to the embedded third-order method.
///
/// It is of fourth order, takes six stages, and solves linear equations only. It damps what decays fast however long the
/// step is (it is L-stable), so that a pad that creeps where friction rises steeply can take steps as long as its creep
/// allows.
pub(crate) fn step(
    rate: impl Fn([f64; 2]) -> [f64; 2],
    slopes: Slopes,
    state: [f64; 2],
    h: f64,
) -> ([f64; 2], [f64; 2]) {
    const GAMMA: f64 = 0.25;
    // The inverse of 1 / (gamma h) - J.
    let a = 1.0 / (GAMMA * h);
    let d = a - slopes.by_u;
    let per_determinant = 1.0 / (a * d - slopes.by_x);
    let solve = |[p, q]: [f64; 2]| [(d * p + q) * per_determinant, (slopes.by_x * p + a * q) * per_determinant];
    let combine = |from: [f64; 2], factor: f64, terms: &[(f64, [f64; 2])]| {
        terms.iter().fold(from, |sum, (weight, k)| [sum[0] + factor * weight * k[0], sum[1] + factor * weight * k[1]])
    };
    let stage = |at: [f64; 2], terms: &[(f64, [f64; 2])]| solve(combine(rate(at), 1.0 / h, terms));
    let k1 = stage(state, &[]);
    let k2 = stage(combine(state, 1.0, &[(1.544, k1)]), &[(-5.6688, k1)]);
    let k3 = stage(
        combine(state, 1.0, &[(0.946_678_528_081_582_6, k1), (0.255_701_169_898_328_4, k2)]),
        &[(-2.430_093_356_833_875, k1), (-0.206_359_915_709_191_5, k2)],
    );
    let k4 = stage(
        combine(state, 1.0, &[(3.314_825_187_068_521, k1), (2.896_124_015_972_201, k2), (0.998_641_913_997_781_7, k3)]),
        &[(-0.107_352_905_815_137_5, k1), (-9.594_562_251_023_355, k2), (-20.470_286_148_096_16, k3)],
    );
    let fifth = combine(
        state,
        1.0,
        &[
            (1.221_224_509_226_641, k1),
            (6.019_134_481_288_629, k2),
            (12.537_083_329_320_87, k3),
            (-0.687_886_036_105_895, k4),
        ],
    );
    let k5 = stage(
        fifth,
        &[
            (7.496_443_313_967_647, k1),
            (-10.246_804_314_643_52, k2),
            (-33.999_903_528_199_05, k3),
            (11.708_908_932_061_6, k4),
        ],
    );
    let embedded = combine(fifth, 1.0, &[(1.0, k5)]);
    let error = stage(
        embedded,
        &[
            (8.083_246_795_921_522, k1),
            (-7.981_132_988_064_893, k2),
            (-31.521_594_328_743_71, k3),
            (16.319_305_431_231_36, k4),
            (-6.058_818_238_834_054, k5),
        ],
    );
    ([embedded[0] + error[0], embedded[1] + error[1]], error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_step_and_its_estimate_have_the_orders_of_the_method() {
        // u' = -x - x^2 - 2 u^2: compared with two hundred steps of Dormand and Prince's method.
        let rate = |[x, u]: [f64; 2]| [u, -x - x * x - 2.0 * u * u];
        let of = |h: f64| {
            let start = [0.7, -0.4];
            let slopes = Slopes { by_x: -1.0 - 2.0 * start[0], by_u: -4.0 * start[1] };
            let (next, estimate) = step(rate, slopes, start, h);
            let exact =
                (0..200).fold(start, |state, _| crate::numerics::dormand_prince::step(rate, state, h / 200.0).0);
            (f64::hypot(next[0] - exact[0], next[1] - exact[1]), f64::hypot(estimate[0], estimate[1]))
        };
        for h in [0.1, 0.05] {
            let ((error, estimate), (half_error, half_estimate)) = (of(h), of(0.5 * h));
            assert!((error / half_error).log2() > 4.7, "{h}: {error} {half_error}");
            assert!((estimate / half_estimate).log2() > 3.7, "{h}: {estimate} {half_estimate}");
        }
    }

    #[test]
    fn a_long_step_damps_what_decays_fast_and_follows_what_does_not() {
        // u' = -1e8 (u + x): a step of a million times the fast decay takes u near -x, and x has fallen as exp(-t).
        let rate = |[x, u]: [f64; 2]| [u, -1e8 * (u + x)];
        let slopes = Slopes { by_x: -1e8, by_u: -1e8 };
        let (next, _) = step(rate, slopes, [1.0, 5.0], 0.01);
        assert!((next[1] + next[0]).abs() < 1e-4, "{next:?}");
        assert!((next[0] - libm::exp(-0.01)).abs() < 1e-6, "{next:?}");
    }
}
