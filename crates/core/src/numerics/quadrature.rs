//! The Gauss-Legendre rule, and the Legendre polynomials that it comes from.

/// Legendre polynomial with its first two derivatives, |x| <= 1, by the three-term recurrence.
pub(crate) fn legendre(degree: usize, x: f64) -> (f64, f64, f64) {
    let (mut p, mut dp, mut ddp) = (1.0, 0.0, 0.0);
    let (mut p_before, mut dp_before, mut ddp_before) = (0.0, 0.0, 0.0);
    for k in 1..=degree {
        let (a, b) = ((2 * k - 1) as f64 / k as f64, (k - 1) as f64 / k as f64);
        let next =
            (a * x * p - b * p_before, a * (p + x * dp) - b * dp_before, a * (2.0 * dp + x * ddp) - b * ddp_before);
        (p_before, dp_before, ddp_before) = (p, dp, ddp);
        (p, dp, ddp) = next;
    }
    (p, dp, ddp)
}

/// Nodes and weights of the Gauss-Legendre rule on [-1, 1], by Newton's iteration from Tricomi's estimate.
pub(crate) fn gauss_legendre(points: usize) -> Vec<(f64, f64)> {
    let rule = |i: usize| {
        let angle = std::f64::consts::PI * (i as f64 + 0.75) / (points as f64 + 0.5);
        let mut x = libm::cos(angle);
        for _ in 0..20 {
            let (p, dp, _) = legendre(points, x);
            let step = p / dp;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        let (_, dp, _) = legendre(points, x);
        (x, 2.0 / ((1.0 - x * x) * dp * dp))
    };
    (0..points).map(rule).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn n_points_integrate_polynomials_up_to_degree_2n_minus_1() {
        for points in [1, 2, 5, 8, 24, 48] {
            let rule = gauss_legendre(points);
            for degree in 0..2 * points as u32 {
                let integral: f64 = rule.iter().map(|(x, weight)| weight * x.powi(degree as i32)).sum();
                let exact = if degree % 2 == 0 { 2.0 / f64::from(degree + 1) } else { 0.0 };
                assert!((integral - exact).abs() < 1e-14, "{points} points, degree {degree}: {integral} {exact}");
            }
        }
    }

    #[test]
    fn derivatives_of_the_third_polynomial_are_those_of_its_formula() {
        let x = 0.3;
        let (value, first, second) = legendre(3, x);
        assert!((value - (2.5 * x * x * x - 1.5 * x)).abs() < 1e-15);
        assert!((first - (7.5 * x * x - 1.5)).abs() < 1e-15);
        assert!((second - 15.0 * x).abs() < 1e-14);
    }
}
