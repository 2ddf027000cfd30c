//! Cubic smoothing splines: the curve that is near noisy points and yet bends little (Reinsch 1967).
//!
//! Of all curves g it minimises `sum (y_i - g(x_i))^2 + lambda integral g''^2 dx`. With the second differences Q of the
//! values and the Gram matrix R of the second derivatives its values at the knots are
//!
//! ```text
//! g = y - Q u,      (R / lambda + Q^T Q) u = Q^T y
//! ```
//!
//! and its second derivatives there `u / lambda`; it is straight beyond the first and the last knot.
//!
//! The matrix has five diagonals, so a curve takes a time that grows like the number of its knots. `1 / lambda` is called
//! the softness: without it the curve is the straight line of least squares, and with much of it the points themselves.
//!
//! The softness is the one with the least score of generalised cross-validation (Craven and Wahba 1979)
//!
//! ```text
//! n |y - g|^2 / (n - INFLATION p)^2
//! ```
//!
//! with the number p of free parameters of the curve, the trace of the matrix that makes g of y. Without inflation some
//! curves follow the noise; with 1.4 (Kim and Gu 2004) hardly any does.

/// What a free parameter counts for in the score.
const INFLATION: f64 = 1.4;

/// The softness that is tried first, over the number of knots: the curve is a straight line but for a thousandth.
const FIRST: f64 = 0.1;

/// The softness that is tried last, times the third power of the least distance of knots: the points themselves.
const LAST: f64 = 1e3;

/// Each softness that is tried is so many times the one before.
const STEP: f64 = 1.25;

/// Least distance of two knots, over the distance of the first and the last; what is nearer counts as that far apart.
const LEAST_GAP: f64 = 1e-6;

/// The matrices of some knots. Of the symmetric ones each row has its diagonal and what follows.
pub(crate) struct SmoothingSpline {
    /// Distance of the first and the last knot; that of neighbours over it.
    range: f64,
    gaps: Vec<f64>,
    /// Q: of each inner knot the weights of the knots before, at and after it.
    differences: Vec<[f64; 3]>,
    /// R.
    gram: Vec<[f64; 2]>,
    /// Q^T Q.
    penalty: Vec<[f64; 3]>,
    last_softness: f64,
}

impl SmoothingSpline {
    /// For these knots in rising order, at least three of them.
    pub fn new(knots: &[f64]) -> Self {
        let range = knots.last().copied().unwrap_or(0.0) - knots.first().copied().unwrap_or(0.0);
        let gaps: Vec<f64> = knots.windows(2).map(|pair| ((pair[1] - pair[0]) / range).max(LEAST_GAP)).collect();
        let differences: Vec<[f64; 3]> = gaps
            .windows(2)
            .map(|pair| {
                let [before, after] = [1.0 / pair[0], 1.0 / pair[1]];
                [before, -before - after, after]
            })
            .collect();
        let inner = differences.len();
        let gram = (0..inner).map(|i| {
            let beside = if i + 1 < inner { gaps[i + 1] / 6.0 } else { 0.0 };
            [(gaps[i] + gaps[i + 1]) / 3.0, beside]
        });
        let gram = gram.collect();
        let penalty = (0..inner).map(|i| {
            let [a, b, c] = differences[i];
            let beside = differences.get(i + 1).map_or(0.0, |next| b * next[0] + c * next[1]);
            let far = differences.get(i + 2).map_or(0.0, |next| c * next[0]);
            [a * a + b * b + c * c, beside, far]
        });
        let penalty = penalty.collect();
        let least = gaps.iter().copied().fold(1.0, f64::min);
        Self { range, gaps, differences, gram, penalty, last_softness: LAST / (least * least * least) }
    }

    /// The softness with the least score for these values at the knots.
    pub fn best_softness(&self, values: &[f64]) -> f64 {
        let knots = values.len() as f64;
        let mut softness = FIRST / knots;
        let mut best = (f64::INFINITY, softness);
        while softness <= self.last_softness {
            let factor = self.factor(softness);
            let free = factor.trace(&self.penalty);
            let left = knots - INFLATION * (knots - free);
            if left <= 0.0 {
                break;
            }
            let residuals = self.residuals(&self.solution(&factor, values));
            let squares: f64 = residuals.iter().map(|residual| residual * residual).sum();
            let score = squares / (left * left);
            if score < best.0 {
                best = (score, softness);
            }
            softness *= STEP;
        }
        best.1
    }

    /// The values of the curve at the knots, and its slopes.
    pub fn smoothed(&self, values: &[f64], softness: f64) -> (Vec<f64>, Vec<f64>) {
        let solution = self.solution(&self.factor(softness), values);
        let residuals = self.residuals(&solution);
        let smoothed: Vec<f64> = values.iter().zip(residuals).map(|(value, residual)| value - residual).collect();
        // Of the second derivative, at all knots.
        let bends: Vec<f64> = std::iter::once(0.0).chain(solution.iter().map(|u| softness * u)).chain([0.0]).collect();
        let last = self.gaps.len();
        let slope = |knot: usize| {
            let (from, sign) = if knot < last { (knot, -1.0) } else { (knot - 1, 1.0) };
            let far = if knot < last { knot + 1 } else { from };
            let secant = (smoothed[from + 1] - smoothed[from]) / self.gaps[from];
            (secant + sign * self.gaps[from] * (2.0 * bends[knot] + bends[far]) / 6.0) / self.range
        };
        let slopes = (0..=last).map(slope).collect();
        (smoothed, slopes)
    }

    /// The number of free parameters of a curve with a softness: 2 of a straight line, that of the knots of the points.
    pub fn parameters(&self, softness: f64) -> f64 {
        (self.differences.len() + 2) as f64 - self.factor(softness).trace(&self.penalty)
    }

    /// u.
    fn solution(&self, factor: &Factor, values: &[f64]) -> Vec<f64> {
        let weighted = |(weights, at): (&[f64; 3], &[f64])| weights.iter().zip(at).map(|(w, y)| w * y).sum::<f64>();
        let mut solution: Vec<f64> = self.differences.iter().zip(values.windows(3)).map(weighted).collect();
        factor.solve(&mut solution);
        solution
    }

    /// Q u: by how much the values exceed the curve.
    fn residuals(&self, solution: &[f64]) -> Vec<f64> {
        let mut residuals = vec![0.0; self.gaps.len() + 1];
        for (i, (weights, u)) in self.differences.iter().zip(solution).enumerate() {
            for (residual, weight) in residuals[i..].iter_mut().zip(weights) {
                *residual += weight * u;
            }
        }
        residuals
    }

    /// The factors of `R softness + Q^T Q`.
    fn factor(&self, softness: f64) -> Factor {
        let inner = self.penalty.len();
        let mut diagonal: Vec<f64> = Vec::with_capacity(inner);
        let mut below: Vec<[f64; 2]> = Vec::with_capacity(inner);
        for i in 0..inner {
            let [mut own, mut next, far] = self.penalty[i];
            own += softness * self.gram[i][0];
            next += softness * self.gram[i][1];
            if i > 0 {
                let [first, second] = below[i - 1];
                own -= first * first * diagonal[i - 1];
                next -= first * second * diagonal[i - 1];
            }
            if i > 1 {
                let second = below[i - 2][1];
                own -= second * second * diagonal[i - 2];
            }
            diagonal.push(own);
            below.push([next / own, far / own]);
        }
        Factor { diagonal, below }
    }
}

/// The factors L and D of a matrix `L D L^T` with five diagonals.
struct Factor {
    diagonal: Vec<f64>,
    /// Of each column of L the two entries below its diagonal, which is 1.
    below: Vec<[f64; 2]>,
}

impl Factor {
    /// Replaces the right-hand side by the solution.
    fn solve(&self, x: &mut [f64]) {
        let count = x.len();
        for i in 1..count {
            let far = if i > 1 { self.below[i - 2][1] * x[i - 2] } else { 0.0 };
            x[i] -= self.below[i - 1][0] * x[i - 1] + far;
        }
        for i in (0..count).rev() {
            let after = |steps: usize| if i + steps < count { self.below[i][steps - 1] * x[i + steps] } else { 0.0 };
            let value = x[i] / self.diagonal[i] - after(1) - after(2);
            x[i] = value;
        }
    }

    /// The trace of the inverse times another matrix with five diagonals, by those diagonals of the inverse (Hutchinson and
    /// de Hoog 1985).
    fn trace(&self, other: &[[f64; 3]]) -> f64 {
        let mut trace = 0.0;
        // Of the inverse: the entries at and beside the diagonal one row later, and at it two rows later.
        let (mut next, mut beside_next, mut second) = (0.0, 0.0, 0.0);
        for ((pivot, [a, b]), row) in self.diagonal.iter().zip(&self.below).zip(other).rev() {
            let beside = -a * next - b * beside_next;
            let far = -a * beside_next - b * second;
            let own = 1.0 / pivot - a * beside - b * far;
            trace += own * row[0] + 2.0 * (beside * row[1] + far * row[2]);
            (next, beside_next, second) = (own, beside, next);
        }
        trace
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOTS: [f64; 8] = [0.0, 0.1, 0.25, 0.4, 0.8, 1.0, 1.7, 2.0];
    const VALUES: [f64; 8] = [0.5, 0.41, 0.37, 0.39, 0.30, 0.31, 0.27, 0.28];

    #[test]
    fn without_softness_it_is_the_line_of_least_squares() {
        let spline = SmoothingSpline::new(&KNOTS);
        let count = KNOTS.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
        let (x, y) = (mean(&KNOTS), mean(&VALUES));
        let products = KNOTS.iter().zip(VALUES).map(|(knot, value)| (knot - x) * (value - y)).sum::<f64>();
        let slope = products / KNOTS.iter().map(|knot| (knot - x) * (knot - x)).sum::<f64>();
        for (knot, value) in KNOTS.iter().zip(spline.smoothed(&VALUES, 0.0).0) {
            assert!((value - y - slope * (knot - x)).abs() < 1e-12, "{knot}: {value}");
        }
        assert!((spline.parameters(0.0) - 2.0).abs() < 1e-10);
    }

    #[test]
    fn with_much_softness_it_goes_through_the_points() {
        let spline = SmoothingSpline::new(&KNOTS);
        for (value, smoothed) in VALUES.iter().zip(spline.smoothed(&VALUES, 1e12).0) {
            assert!((value - smoothed).abs() < 1e-6, "{value}: {smoothed}");
        }
        assert!((spline.parameters(1e12) - 8.0).abs() < 1e-4);
    }

    /// The values minimise the sum of squares and bending: no change of one of them makes it less.
    #[test]
    fn it_solves_its_equations() {
        let (spline, softness) = (SmoothingSpline::new(&KNOTS), 300.0);
        let (smoothed, _) = spline.smoothed(&VALUES, softness);
        // Bending of the natural spline through g: (Q^T g)^T R^-1 (Q^T g), with R tridiagonal.
        let bending = |values: &[f64]| {
            let mut x: Vec<f64> = spline
                .differences
                .iter()
                .zip(values.windows(3))
                .map(|(weights, at)| weights.iter().zip(at).map(|(w, y)| w * y).sum::<f64>())
                .collect();
            let right = x.clone();
            let (mut pivots, count) = (vec![spline.gram[0][0]], x.len());
            for i in 1..count {
                let share = spline.gram[i - 1][1] / pivots[i - 1];
                pivots.push(spline.gram[i][0] - share * spline.gram[i - 1][1]);
                x[i] -= share * x[i - 1];
            }
            for i in (0..count).rev() {
                let after = if i + 1 < count { spline.gram[i][1] * x[i + 1] } else { 0.0 };
                x[i] = (x[i] - after) / pivots[i];
            }
            x.iter().zip(right).map(|(x, right)| x * right).sum::<f64>()
        };
        let cost = |values: &[f64]| {
            let squares: f64 = values.iter().zip(VALUES).map(|(g, y)| (g - y) * (g - y)).sum();
            softness * squares + bending(values)
        };
        let least = cost(&smoothed);
        for i in 0..smoothed.len() {
            for step in [-1e-5, 1e-5] {
                let mut other = smoothed.clone();
                other[i] += step;
                assert!(cost(&other) > least, "{i}: {step}");
            }
        }
    }

    #[test]
    fn the_number_of_parameters_is_the_trace_of_what_smooths() {
        let spline = SmoothingSpline::new(&KNOTS);
        for softness in [0.1, 30.0, 1e4] {
            let own = (0..KNOTS.len()).map(|i| {
                let mut unit = [0.0; 8];
                unit[i] = 1.0;
                spline.smoothed(&unit, softness).0[i]
            });
            let trace: f64 = own.sum();
            assert!((spline.parameters(softness) - trace).abs() < 1e-9, "{softness}: {trace}");
        }
    }

    #[test]
    fn values_and_slopes_are_scipys() {
        // scipy 1.17.1, make_smoothing_spline(KNOTS, VALUES, lam=8 / 300): the range of the knots to the third power over
        // the softness.
        let expected = [
            (0.458937317733690, -0.245547930587184),
            (0.434639166439136, -0.237848677662250),
            (0.401040630234888, -0.207822248147862),
            (0.372330595774719, -0.177033743034640),
            (0.315869699806538, -0.102218446988703),
            (0.298983748184280, -0.069845421731118),
            (0.274111680651760, -0.006733675267382),
            (0.274087161174987, 0.003244240249827),
        ];
        let (smoothed, slopes) = SmoothingSpline::new(&KNOTS).smoothed(&VALUES, 300.0);
        for ((value, slope), expected) in smoothed.iter().zip(&slopes).zip(expected) {
            assert!((value - expected.0).abs() < 1e-12 && (slope - expected.1).abs() < 1e-12, "{value} {slope}");
        }
    }

    #[test]
    fn knots_that_are_very_near_are_no_fault() {
        let spline = SmoothingSpline::new(&[0.0, 1e-160, 1.0, 2.0, 3.0]);
        let values = [0.5, 0.4, 0.3, 0.3, 0.2];
        let (smoothed, slopes) = spline.smoothed(&values, spline.best_softness(&values));
        assert!(slopes.iter().all(|slope| slope.is_finite()), "{slopes:?}");
        assert!(smoothed.iter().all(|value| (0.1..0.6).contains(value)), "{smoothed:?}");
    }
}
