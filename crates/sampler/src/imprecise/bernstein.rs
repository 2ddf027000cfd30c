//! Bounds of a polynomial on a square, by its coefficients in Bernstein's basis.
//!
//! A polynomial lies between the least and the greatest of these coefficients, and those at the corners of the square are
//! its values there. Halving the square brings the bounds together (R. T. Farouki, The Bernstein polynomial basis: a
//! centennial retrospective, Computer Aided Geometric Design 29, 2012).

use super::expansion::{Coefficients, DEGREE, TERMS};

/// Halvings at most.
const MOST_HALVINGS: usize = 4000;

/// A polynomial on a part of the square from -1 to 1 in both variables.
#[derive(Debug, Clone)]
pub struct Patch {
    coefficients: Coefficients,
    /// The part: from and to of each variable.
    ends: [[f64; 2]; 2],
}

/// The least value of a polynomial.
#[derive(Debug, Clone, Copy)]
pub struct Least {
    /// Not more than any value.
    pub bound: f64,
    /// The least value that was found.
    pub value: f64,
    /// Where.
    pub at: [f64; 2],
}

impl Patch {
    /// The polynomial of these coefficients of powers, on the whole square.
    pub fn new(powers: &Coefficients) -> Self {
        // First the powers of u with x = 2 u - 1, which goes from 0 to 1.
        let mut coefficients = *powers;
        for row in &mut coefficients {
            *row = to_bernstein(row);
        }
        transpose(&mut coefficients);
        for row in &mut coefficients {
            *row = to_bernstein(row);
        }
        transpose(&mut coefficients);
        Self { coefficients, ends: [[-1.0, 1.0]; 2] }
    }

    /// The least and the greatest coefficient.
    pub fn bounds(&self) -> [f64; 2] {
        let all = || self.coefficients.iter().flatten();
        [all().copied().fold(f64::INFINITY, f64::min), all().copied().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// The values at the corners.
    pub fn corners(&self) -> [f64; 4] {
        [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| self.coefficients[i * DEGREE][j * DEGREE])
    }

    /// The least value at a corner, and where it is.
    fn least_corner(&self) -> (f64, [f64; 2]) {
        let corners = [(0, 0), (0, 1), (1, 0), (1, 1)];
        let value = |(i, j): (usize, usize)| self.coefficients[i * DEGREE][j * DEGREE];
        let best = corners.into_iter().min_by(|&a, &b| value(a).total_cmp(&value(b))).unwrap_or_default();
        (value(best), [self.ends[0][best.0], self.ends[1][best.1]])
    }

    /// Both halves along a variable.
    fn halves(mut self, along: usize) -> [Self; 2] {
        if along == 0 {
            transpose(&mut self.coefficients);
        }
        let mut other = self.clone();
        for (row, right) in self.coefficients.iter_mut().zip(&mut other.coefficients) {
            // De Casteljau's scheme: its first entries are the left half, its last ones the right half.
            for level in 1..TERMS {
                for k in (level..TERMS).rev() {
                    row[k] = 0.5 * (row[k - 1] + row[k]);
                }
                right[DEGREE - level] = row[DEGREE];
            }
        }
        if along == 0 {
            transpose(&mut self.coefficients);
            transpose(&mut other.coefficients);
        }
        let [from, to] = self.ends[along];
        let middle = 0.5 * (from + to);
        self.ends[along] = [from, middle];
        other.ends[along] = [middle, to];
        [self, other]
    }

    /// The least value, to a tolerance.
    pub fn least(self, tolerance: f64) -> Least {
        let (value, at) = self.least_corner();
        let mut best = Least { bound: self.bounds()[0], value, at };
        let mut open = vec![(best.bound, self)];
        for _ in 0..MOST_HALVINGS {
            let lowest = (0..open.len()).min_by(|&a, &b| open[a].0.total_cmp(&open[b].0));
            let Some(lowest) = lowest else { break };
            best.bound = open[lowest].0.min(best.value);
            if best.value - best.bound <= tolerance {
                break;
            }
            let (_, patch) = open.swap_remove(lowest);
            let along = patch.steeper();
            for half in patch.halves(along) {
                let (value, at) = half.least_corner();
                if value < best.value {
                    (best.value, best.at) = (value, at);
                }
                open.push((half.bounds()[0], half));
            }
        }
        best
    }

    /// The variable along which neighbouring coefficients differ more.
    fn steeper(&self) -> usize {
        let step = |(a, b): (&f64, &f64)| (b - a).abs();
        let between = |a: &[f64; TERMS], b: &[f64]| a.iter().zip(b).map(step).fold(0.0, f64::max);
        let rows = &self.coefficients;
        let change = [
            rows.windows(2).map(|pair| between(&pair[0], &pair[1])).fold(0.0, f64::max),
            rows.iter().map(|row| between(row, &row[1..])).fold(0.0, f64::max),
        ];
        usize::from(change[1] > change[0])
    }
}

fn transpose(coefficients: &mut Coefficients) {
    let before = *coefficients;
    *coefficients = std::array::from_fn(|i| std::array::from_fn(|j| before[j][i]));
}

/// Bernstein coefficients on the interval from -1 to 1 from those of powers.
fn to_bernstein(powers: &[f64; TERMS]) -> [f64; TERMS] {
    // x^m = (2 u - 1)^m, by Horner's rule in u.
    let mut of_unit = [0.0; TERMS];
    for power in powers.iter().rev() {
        for k in (0..TERMS).rev() {
            let lower = if k > 0 { of_unit[k - 1] } else { *power };
            of_unit[k] = if k > 0 { 2.0 * lower - of_unit[k] } else { lower - of_unit[0] };
        }
    }
    let mut bernstein = [0.0; TERMS];
    for (k, coefficient) in bernstein.iter_mut().enumerate() {
        *coefficient = (0..=k).map(|i| of_unit[i] * choose(k, i) / choose(DEGREE, i)).sum();
    }
    bernstein
}

/// Binomial coefficients.
fn choose(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(powers: &Coefficients, [x, y]: [f64; 2]) -> f64 {
        powers.iter().rev().fold(0.0, |sum, row| sum * x + row.iter().rev().fold(0.0, |sum, c| sum * y + c))
    }

    /// Coefficients without a pattern, up to the degree together.
    fn some_polynomial(seed: u32) -> Coefficients {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        std::array::from_fn(|i| std::array::from_fn(|j| if i + j < TERMS { next() } else { 0.0 }))
    }

    #[test]
    fn the_least_value_is_that_of_a_dense_grid() {
        for seed in 1..20 {
            let powers = some_polynomial(seed);
            let least = Patch::new(&powers).least(1e-6);
            assert!((value(&powers, least.at) - least.value).abs() < 1e-12, "seed {seed}: {least:?}");
            assert!(least.bound <= least.value && least.value - least.bound <= 1e-6, "seed {seed}: {least:?}");
            let mut on_grid = f64::INFINITY;
            for i in 0..=200 {
                for j in 0..=200 {
                    on_grid = on_grid.min(value(&powers, [i, j].map(|k| f64::from(k) / 100.0 - 1.0)));
                }
            }
            assert!(least.bound <= on_grid && least.value <= on_grid + 1e-6, "seed {seed}: {least:?} {on_grid}");
        }
    }

    #[test]
    fn halves_have_the_values_of_the_whole() {
        let powers = some_polynomial(7);
        for along in [0, 1] {
            for half in Patch::new(&powers).halves(along) {
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let expected = value(&powers, [half.ends[0][i], half.ends[1][j]]);
                    assert!((half.coefficients[i * DEGREE][j * DEGREE] - expected).abs() < 1e-12);
                }
            }
        }
    }
}
