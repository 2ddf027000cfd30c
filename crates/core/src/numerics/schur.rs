//! The real Schur form of a matrix: `A = Q T Q^T` with an orthogonal Q, and a T that is upper triangular but for blocks of two
//! on its diagonal.
//!
//! nalgebra finds it by the implicit double-shift QR iteration (G. H. Golub and C. F. Van Loan, Matrix Computations, 4th
//! edition, section 7.5), with the first column of a sweep from the sum and the product of the shifts. Of a matrix with few
//! distinct eigenvalues that column is what rounding leaves of large terms, and the iteration stands still: so for the matrix
//! `[0, 1; -K, -C]` of motions with `C` and `K` near multiples of the unit matrix. It takes no exceptional shifts, and goes
//! round in circles for the roots of `x^4 + 1`.
//!
//! Where it does not end, the same iteration is taken with the safeguards of LAPACK's `dlahqr`: the first column from
//! differences with the shifts, sweeps that begin between two small entries, exceptional shifts (R. S. Martin, G. Peters and
//! J. H. Wilkinson, Numer. Math. 14 (1970) 219), and the deflation criterion of M. Ahues and F. Tisseur (LAPACK Working Note
//! 122, 1997). It comes second, since results keep their last bits where the first one ends.

use nalgebra::{Complex, DMatrix, Hessenberg, Schur};

/// QR sweeps allowed for each row of the matrix. Two or three are usual.
pub(crate) const SWEEPS_PER_ROW: usize = 60;

/// After so many sweeps without a new eigenvalue the shifts are exceptional ones once, and what rounding may have made is
/// taken for zero.
const PATIENCE: usize = 10;

/// Q and T of a matrix of finite numbers. `None` if neither iteration converges.
pub(crate) fn real_schur(matrix: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let sweeps = SWEEPS_PER_ROW * matrix.nrows();
    let first = Schur::try_new(matrix.clone(), f64::EPSILON, sweeps);
    first.map(Schur::unpack).or_else(|| safeguarded(matrix, sweeps))
}

/// The eigenvalues of T, in the order of its diagonal.
pub(crate) fn eigenvalues_of(triangle: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let mut values = Vec::with_capacity(triangle.nrows());
    while values.len() < triangle.nrows() {
        let row = values.len();
        if row + 1 == triangle.nrows() || triangle[(row + 1, row)] == 0.0 {
            values.push(Complex::from(triangle[(row, row)]));
            continue;
        }
        let Block { mean, square, .. } = Block::at(triangle, row);
        let root = square.abs().sqrt();
        let root = if square < 0.0 { Complex::new(0.0, root) } else { Complex::from(root) };
        values.extend([Complex::from(mean) + root, Complex::from(mean) - root]);
    }
    values
}

/// The largest power of two not above `value`, kept away from the ends of the exponent range.
pub(crate) fn power_of_two_near(value: f64) -> f64 {
    let (_, exponent) = libm::frexp(value);
    libm::ldexp(1.0, (exponent - 1).clamp(-1000, 1000))
}

/// Two rows and columns on the diagonal, whose eigenvalues are `mean +- sqrt(square)`.
struct Block {
    /// Half the difference of the diagonal.
    half: f64,
    mean: f64,
    square: f64,
}

impl Block {
    /// The block that begins in a row.
    fn at(t: &DMatrix<f64>, row: usize) -> Self {
        let (upper, lower) = (t[(row, row)], t[(row + 1, row + 1)]);
        let half = (upper - lower) * 0.5;
        let square = t[(row + 1, row)] * t[(row, row + 1)] + half * half;
        Self { half, mean: (lower + upper) * 0.5, square }
    }
}

/// The reflection `1 - factor axis axis^T` that leaves a vector its first entry, which becomes `length`.
struct Reflector {
    axis: [f64; 3],
    factor: f64,
    length: f64,
}

impl Reflector {
    /// `None` where there is nothing to do.
    fn new(vector: [f64; 3]) -> Option<Self> {
        if vector[1] == 0.0 && vector[2] == 0.0 {
            return None;
        }
        let size = vector.iter().fold(0.0, |size: f64, entry| size.max(entry.abs()));
        let [x, y, z] = vector.map(|entry| entry / size);
        let length = (x * x + y * y + z * z).sqrt().copysign(x);
        let axis = [1.0, y / (x + length), z / (x + length)];
        Some(Self { axis, factor: (x + length) / length, length: -length * size })
    }

    /// Reflects the entries of a matrix at two or three places.
    fn apply(&self, entries: &mut DMatrix<f64>, place: impl Fn(usize) -> (usize, usize)) {
        let axis = &self.axis[..if self.axis[2] == 0.0 { 2 } else { 3 }];
        let along: f64 = axis.iter().enumerate().map(|(i, share)| share * entries[place(i)]).sum();
        for (i, share) in axis.iter().enumerate() {
            entries[place(i)] -= self.factor * along * share;
        }
    }
}

/// `A = Q T Q^T` while T still has entries below its diagonal.
struct Iteration {
    q: DMatrix<f64>,
    t: DMatrix<f64>,
}

/// Q and T by the iteration with all safeguards.
fn safeguarded(matrix: &DMatrix<f64>, sweeps: usize) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let scale = power_of_two_near(matrix.amax());
    let (q, t) = Hessenberg::new(matrix / scale).unpack();
    let mut iteration = Iteration { q, t };
    let (mut end, mut fruitless) = (matrix.nrows(), 0);
    for _ in 0..sweeps {
        let start = loop {
            if end == 0 {
                return Some((iteration.q, iteration.t * scale));
            }
            let start = iteration.deflated(end, fruitless);
            if end - start > 2 {
                break start;
            }
            if end - start == 2 {
                iteration.split(start);
            }
            (end, fruitless) = (start, 0);
        };
        fruitless += 1;
        let shift = iteration.shift(start, end - 1, fruitless);
        iteration.sweep(start, end - 1, shift);
    }
    None
}

impl Iteration {
    /// The first row of the block that ends before a row and does not fall apart.
    fn deflated(&mut self, end: usize, fruitless: usize) -> usize {
        let start = (1..end).rev().find(|row| self.is_negligible(*row, fruitless)).unwrap_or(0);
        if start > 0 {
            self.t[(start, start - 1)] = 0.0;
        }
        start
    }

    /// Whether the entry of a row below the diagonal is as good as zero: beside its neighbours, by the criterion of Ahues and
    /// Tisseur. Where that leaves the iteration without progress, as between two blocks whose diagonal is rounding, beside
    /// the whole matrix, whose largest entry is near 1.
    fn is_negligible(&self, row: usize, fruitless: usize) -> bool {
        let places = [(row - 1, row - 1), (row, row), (row, row - 1), (row - 1, row)];
        let [upper, lower, below, above] = places.map(|place| self.t[place]);
        let (upper_size, lower_size, difference) = (upper.abs(), lower.abs(), (upper - lower).abs());
        let (below, above) = (below.abs(), above.abs());
        let unit = if fruitless < PATIENCE { f64::MIN_POSITIVE / f64::EPSILON } else { f64::EPSILON };
        let least = unit * self.t.nrows() as f64;
        if below <= least {
            return true;
        }
        let (large, small) = (lower_size.max(difference), lower_size.min(difference));
        let sum = large + below.max(above);
        below <= f64::EPSILON * (upper_size + lower_size)
            && below.min(above) * (below.max(above) / sum) <= least.max(f64::EPSILON * (small * (large / sum)))
    }

    /// Makes a block of two triangular if its eigenvalues are real.
    fn split(&mut self, row: usize) {
        let Block { half, square, .. } = Block::at(&self.t, row);
        if square < 0.0 {
            return;
        }
        // The vector of the eigenvalue farther from the lower entry, so that nothing cancels.
        let vector = [half + square.sqrt().copysign(half), self.t[(row + 1, row)], 0.0];
        if let Some(reflector) = Reflector::new(vector) {
            self.reflect(row, row + 1, &reflector);
        }
        self.t[(row + 1, row)] = 0.0;
    }

    /// The shift of a sweep, which is made with its conjugate: an eigenvalue of the last two rows, of real ones that nearer to
    /// the last entry; from time to time one from the last or the first entries below the diagonal.
    fn shift(&self, start: usize, last: usize, fruitless: usize) -> Complex<f64> {
        let exceptional = |corner: usize, rows: [usize; 2]| {
            let size: f64 = rows.iter().map(|&row| self.t[(row, row - 1)].abs()).sum();
            Complex::new(self.t[(corner, corner)] + 0.75 * size, 0.4375_f64.sqrt() * size)
        };
        if fruitless.is_multiple_of(2 * PATIENCE) {
            return exceptional(last, [last - 1, last]);
        }
        if fruitless.is_multiple_of(PATIENCE) {
            return exceptional(start, [start + 1, start + 2]);
        }
        let Block { half, mean, square } = Block::at(&self.t, last - 1);
        let root = square.abs().sqrt();
        if square < 0.0 { Complex::new(mean, root) } else { Complex::from(mean - root.copysign(half)) }
    }

    /// A double-shift sweep over the rows of a block of three or more.
    fn sweep(&mut self, start: usize, last: usize, shift: Complex<f64>) {
        let (first, mut column) = self.first_column(start, last, shift);
        for row in first..last {
            let rows = row..last.min(row + 2) + 1;
            if row > first {
                column = [0.0; 3];
                rows.clone().zip(&mut column).for_each(|(below, entry)| *entry = self.t[(below, row - 1)]);
            }
            let Some(reflector) = Reflector::new(column) else { continue };
            if row > first {
                rows.for_each(|below| self.t[(below, row - 1)] = 0.0);
                self.t[(row, row - 1)] = reflector.length;
            } else if row > start {
                // What the reflection makes of the two entries below this one is negligible.
                self.t[(row, row - 1)] *= 1.0 - reflector.factor;
            }
            self.reflect(row, last, &reflector);
        }
    }

    /// The row in which a sweep begins, and the first column of `(T - shift)(T - conjugate)` from there, up to a factor. That
    /// is the last row but two above which two entries below the diagonal are so small that a sweep need not begin earlier.
    fn first_column(&self, start: usize, last: usize, shift: Complex<f64>) -> (usize, [f64; 3]) {
        let t = &self.t;
        let mut row = last - 2;
        loop {
            let (here, next, below) = (t[(row, row)] - shift.re, t[(row + 1, row + 1)] - shift.re, t[(row + 1, row)]);
            let size = here.abs() + shift.im.abs() + below.abs();
            let share = below / size;
            let column = [
                share * t[(row, row + 1)] + here * (here / size) + shift.im * (shift.im / size),
                share * (here + next),
                share * t[(row + 2, row + 1)],
            ];
            if row == start {
                return (row, column);
            }
            let [kept, lost] = [column[0].abs(), t[(row, row - 1)].abs() * (column[1].abs() + column[2].abs())];
            let beside: f64 = (row - 1..=row + 1).map(|row| t[(row, row)].abs()).sum();
            if lost <= f64::EPSILON * kept * beside {
                return (row, column);
            }
            row -= 1;
        }
    }

    /// Applies a reflection of the rows and columns from `row` on, in a block that ends with the row `last`.
    fn reflect(&mut self, row: usize, last: usize, reflector: &Reflector) {
        let size = self.t.nrows();
        for column in row..size {
            reflector.apply(&mut self.t, |i| (row + i, column));
        }
        for other in 0..=last.min(row + 3) {
            reflector.apply(&mut self.t, |i| (other, row + i));
        }
        for other in 0..size {
            reflector.apply(&mut self.q, |i| (other, row + i));
        }
    }
}

#[cfg(test)]
mod tests;
