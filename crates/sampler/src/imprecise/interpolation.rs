//! Interpolation of a function of several variables between Chebyshev's points.

use std::collections::BTreeMap;

/// Intervals of the finest points.
pub const FINEST: usize = 128;

/// A function at the points of a grid that can be made finer along each variable, all of which go from -1 to 1.
#[derive(Debug, Clone)]
pub struct Interpolation {
    /// Intervals along each variable.
    intervals: Vec<usize>,
    /// Values by the index of the point among the finest.
    known: BTreeMap<Vec<usize>, f64>,
    /// The values on the grid, the last variable fastest.
    values: Vec<f64>,
}

/// Chebyshev's points: the extremes of his polynomial of degree [`FINEST`].
pub fn node(index: usize) -> f64 {
    match index {
        0 => -1.0,
        FINEST => 1.0,
        _ => -libm::cos(std::f64::consts::PI * index as f64 / FINEST as f64),
    }
}

impl Interpolation {
    /// A grid of so many intervals along each variable, a divisor of [`FINEST`].
    pub fn new(variables: usize, intervals: usize) -> Self {
        Self { intervals: vec![intervals; variables], known: BTreeMap::new(), values: Vec::new() }
    }

    /// Number of points of the grid.
    pub fn len(&self) -> usize {
        self.intervals.iter().map(|intervals| intervals + 1).product()
    }

    /// Twice as many intervals along a variable; false if there are no more.
    pub fn refine(&mut self, variable: usize) -> bool {
        let can = self.intervals[variable] < FINEST;
        if can {
            self.intervals[variable] *= 2;
        }
        can
    }

    /// The indices of the points among the finest, in the order of the values.
    pub fn points(&self) -> Vec<Vec<usize>> {
        let mut points = vec![Vec::new()];
        for &intervals in &self.intervals {
            let step = FINEST / intervals;
            let with = |point: &Vec<usize>, i: usize| point.iter().copied().chain([i * step]).collect::<Vec<usize>>();
            points = points.iter().flat_map(|point| (0..=intervals).map(move |i| with(point, i))).collect();
        }
        points
    }

    /// Whether the value of a point is known.
    pub fn knows(&self, point: &[usize]) -> bool {
        self.known.contains_key(point)
    }

    /// Notes the value at a point.
    pub fn set(&mut self, point: Vec<usize>, value: f64) {
        self.known.insert(point, value);
    }

    /// Takes the values that were set for the points of the grid.
    pub fn gather(&mut self) {
        self.values = self.points().iter().map(|point| self.known.get(point).copied().unwrap_or(f64::NAN)).collect();
    }

    /// The values along every line of the grid in the direction of a variable.
    pub fn lines(&self, variable: usize) -> Vec<Vec<f64>> {
        let stride: usize = self.intervals[variable + 1..].iter().map(|intervals| intervals + 1).product();
        let length = self.intervals[variable] + 1;
        let starts = (0..self.values.len()).filter(|i| (i / stride).is_multiple_of(length));
        starts.map(|start| (0..length).map(|i| self.values[start + i * stride]).collect()).collect()
    }

    /// How large the last two coefficients of Chebyshev's polynomials along a variable are.
    pub fn tail(&self, variable: usize) -> f64 {
        let n = self.intervals[variable];
        let coefficient = |line: &[f64], k: usize| {
            let term = |(i, value): (usize, &f64)| {
                let weight = if i == 0 || i == n { 0.5 } else { 1.0 };
                weight * value * libm::cos(std::f64::consts::PI * ((k * i) % (2 * n)) as f64 / n as f64)
            };
            let sum: f64 = line.iter().enumerate().map(term).sum();
            (2.0 * sum / n as f64).abs()
        };
        let of_line = |line: &Vec<f64>| coefficient(line, n - 1) + 0.5 * coefficient(line, n);
        self.lines(variable).iter().map(of_line).fold(0.0, f64::max)
    }

    /// The interpolated value.
    pub fn at(&self, point: &[f64]) -> f64 {
        let mut values = self.values.clone();
        // The slowest variable first.
        for (&x, &intervals) in point.iter().zip(&self.intervals) {
            let weights = weights(x, intervals);
            let rest = values.len() / weights.len();
            let sum = |k: usize| weights.iter().enumerate().map(|(i, weight)| weight * values[i * rest + k]).sum();
            values = (0..rest).map(sum).collect();
        }
        values[0]
    }
}

/// The weights of the values at the nodes (J.-P. Berrut, L. N. Trefethen, Barycentric Lagrange interpolation, SIAM
/// Review 46, 2004).
fn weights(x: f64, intervals: usize) -> Vec<f64> {
    let nodes: Vec<f64> = (0..=intervals).map(|i| node(i * (FINEST / intervals))).collect();
    if let Some(hit) = nodes.iter().position(|node| *node == x) {
        return (0..=intervals).map(|i| if i == hit { 1.0 } else { 0.0 }).collect();
    }
    let raw = |(i, node): (usize, &f64)| {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        let end = if i == 0 || i == intervals { 0.5 } else { 1.0 };
        sign * end / (x - node)
    };
    let weights: Vec<f64> = nodes.iter().enumerate().map(raw).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_function_is_interpolated_and_its_tail_says_how_well() {
        let f = |x: f64, y: f64| libm::exp(0.7 * x) * libm::cos(2.0 * y);
        let mut grid = Interpolation::new(2, 4);
        let mut errors = Vec::new();
        for _ in 0..3 {
            for point in grid.points() {
                if !grid.knows(&point) {
                    let value = f(node(point[0]), node(point[1]));
                    grid.set(point, value);
                }
            }
            grid.gather();
            let mut error = 0.0f64;
            for (x, y) in [(0.3, -0.7), (-0.95, 0.11), (1.0, 0.5), (-1.0, -1.0)] {
                error = error.max((grid.at(&[x, y]) - f(x, y)).abs());
            }
            assert!(error < 2.0 * (grid.tail(0) + grid.tail(1)), "{error} {} {}", grid.tail(0), grid.tail(1));
            errors.push(error);
            assert!(grid.refine(0) && grid.refine(1));
        }
        assert!(errors[2] < 1e-12 && errors[0] > 1e-4, "{errors:?}");
    }
}
