//! Bounds of the response over intervals of frequency; the module documentation proves them.

use crate::models::pad_on_disc::flexible_disc::contact::averages::Averages;
use crate::models::pad_on_disc::flexible_disc::nyquist::batch::{Coefficients, Work};
use crate::models::pad_on_disc::flexible_disc::nyquist::matrices::Places;
use crate::numerics::row::{Number, Row};

/// Relative excess of the bounds over what is computed of them, for rounding.
pub(super) const SLACK: f64 = 1.0 + 1e-9;

/// What the bounds are made of. Vectors are those of the core, scaled to the mass of the pad.
pub(super) struct Couplings<const L: usize> {
    /// Bounds of the eigenvalues of A0.
    pub least: Row<L>,
    pub most: Row<L>,
    /// c, gamma and nu.
    pub damping: Row<L>,
    pub gyroscopic: Row<L>,
    pub remainder: Row<L>,
    /// A_yy and B_yy.
    pub y_stiffness: Row<L>,
    pub y_damping: Row<L>,
    /// Size of the row that couples y to the amplitudes, and sizes of the column at the even and at the odd ones.
    pub y_row: Row<L>,
    pub y_column: [Row<L>; 2],
    /// The rows of x and of phi: at y, and along that of y.
    pub x_row: [Row<L>; 2],
    pub phi_row: [Row<L>; 2],
    /// The column of phi: at y, and its sizes at the even and at the odd amplitudes.
    pub phi_column: [Row<L>; 3],
    /// The column of x, in A and in B: at y, and its size at the amplitudes.
    pub x_column: [Row<L>; 2],
    pub x_column_damping: [Row<L>; 2],
    /// Row x and column phi of A; row phi and column x of A and of B.
    pub x_by_phi: Row<L>,
    pub phi_by_x: Row<L>,
    pub phi_by_x_damping: Row<L>,
    pub phi_stiffness: Row<L>,
    pub phi_damping: Row<L>,
    /// A_xx.
    pub x_stiffness: Row<L>,
}

/// Bounds over an interval of frequency, infinite or no number where none is known.
pub(super) struct Response<const L: usize> {
    /// Of the inverse of the core.
    pub core: Row<L>,
    /// Of `1 / S`.
    pub phi: Row<L>,
    /// Of h.
    pub x: Row<L>,
}

impl<const L: usize> Couplings<L> {
    /// Scales the core to the mass of the pad, and finds what the bounds are made of.
    #[inline(always)]
    pub fn of_scaled(places: Places, averages: &Averages, of: &Coefficients<L>, work: &mut Work<L>) -> Self {
        let Places { size, phi, x, even, .. } = places;
        let first = Places::FIRST_AMPLITUDE;
        let Work { matrix, damping_by_x, stiffness, gyroscopic, compliance, left, .. } = work;
        // The root of the weight of each amplitude, and its reciprocal.
        let roots = &mut left[..places.amplitudes()];
        for (root, compliance) in roots.iter_mut().zip(&*compliance) {
            let squared = of.pad.pressure_gain * compliance.reciprocal();
            root.0 = squared.sqrt();
            root.1 = root.0.reciprocal();
        }
        for (i, row) in matrix.chunks_exact_mut(size).enumerate() {
            for (entry, root) in row[first..phi].iter_mut().zip(&*roots) {
                *entry = *entry * root.1;
            }
            if (first..phi).contains(&i) {
                for entry in row {
                    *entry = *entry * roots[i - first].0;
                }
                damping_by_x[i] = damping_by_x[i] * roots[i - first].0;
            }
        }
        let (mut least, mut most) = (of.pad.normal_stiffness, of.pad.normal_stiffness);
        let (mut trace, mut turning) = (of.pad.pressure_gain, Row::ZERO);
        // N: what is left of the core without A0.
        let without_preload = matrix[0] - of.pad.normal_stiffness - of.pad.pressure_gain;
        let mut remainder = without_preload * without_preload;
        for k in 0..places.amplitudes() {
            let (is_even, index) = if k < even { (true, k) } else { (false, k - even) };
            let (products, start, shape) = if is_even {
                (&averages.even_even[index * even..][..even], first, averages.shape[index])
            } else {
                (&averages.odd_odd[index * places.odd..][..places.odd], first + even, 0.0)
            };
            least = least.min(stiffness[k]);
            most = most.max(stiffness[k]);
            turning = turning.max(gyroscopic[k].abs());
            trace += products[index] * compliance[k];
            let gain = compliance[k] * roots[k].0;
            let row = &matrix[(first + k) * size..][..size];
            let by_normal = row[0] + shape * gain;
            let normal_by = matrix[first + k] + shape * gain;
            remainder += by_normal * by_normal + normal_by * normal_by;
            for (column, entry) in row[first..phi].iter().enumerate() {
                let column = first + column;
                let mut rest = *entry;
                if column >= start && column < start + products.len() {
                    rest -= products[column - start] * (gain * roots[column - first].1);
                }
                if column == first + k {
                    rest -= stiffness[k];
                }
                remainder += rest * rest;
            }
        }
        // The pressure couples y, phi and x to the even amplitudes, so their rows are parallel.
        let of_y = &matrix[first..first + even];
        let y_row = along(of_y, &matrix[first..]).sqrt();
        let per_y_row = y_row.reciprocal();
        let in_row = |row: usize| [SLACK * matrix[row * size], along(of_y, &matrix[row * size + first..]) * per_y_row];
        let in_column = |column: usize, from: usize, to: usize| size_of_column(matrix, size, column, from..to);
        Self {
            least: (2.0 - SLACK) * least,
            most: SLACK * (most + trace),
            damping: (2.0 - SLACK) * of.pad.normal_damping.min(of.disc_damping),
            gyroscopic: SLACK * turning,
            remainder: SLACK * remainder.sqrt(),
            y_stiffness: matrix[0],
            y_damping: of.pad.normal_damping,
            y_row,
            y_column: [in_column(0, first, first + even), in_column(0, first + even, phi)],
            x_row: in_row(x),
            phi_row: in_row(phi),
            phi_column: [matrix[phi].abs(), in_column(phi, first, first + even), in_column(phi, first + even, phi)],
            x_column: [matrix[x].abs(), in_column(x, first, phi)],
            x_column_damping: [damping_by_x[0].abs(), size_of_column(damping_by_x, 1, 0, first..phi)],
            x_by_phi: matrix[x * size + phi].abs(),
            phi_by_x: matrix[phi * size + x].abs(),
            phi_by_x_damping: damping_by_x[phi].abs(),
            phi_stiffness: matrix[phi * size + phi],
            phi_damping: of.pad.angular_damping,
            x_stiffness: matrix[x * size + x],
        }
    }

    /// Between two frequencies.
    #[inline(always)]
    pub fn between(&self, low: Row<L>, high: Row<L>) -> Response<L> {
        let (low_square, high_square) = (low * low, high * high);
        let shift = high * self.gyroscopic + self.remainder;
        let damped = low * self.damping - self.remainder;
        let below = self.least - high_square - shift;
        let above = low_square - self.most - shift;
        let core = damped.max(below).max(above).max(Row::ZERO).reciprocal();
        let least = |stiffness: Row<L>, damping: Row<L>| distance(stiffness, damping, (low, low_square), high_square);
        let y = least(self.y_stiffness, self.y_damping).reciprocal();
        let phi = least(self.phi_stiffness, self.phi_damping);
        self.response([low_square, high_square], high, shift, (core, y, phi))
    }

    /// From a frequency on. The bound of h holds at that frequency, and grows no faster than its square.
    #[inline(always)]
    pub fn beyond(&self, low: Row<L>) -> Response<L> {
        let square = low * low;
        let shift = low * self.gyroscopic + self.remainder;
        let core = (low * self.damping - self.remainder).max(square - self.most - shift).max(Row::ZERO).reciprocal();
        // What the elimination of y gives may vanish at a single frequency; without it all parts are monotonic.
        let y = Row::splat(f64::INFINITY);
        self.response([square, square], low, shift, (core, y, square - self.phi_stiffness))
    }

    /// `core` bounds the inverse of the core, `y` that of its entry at y, and `phi` is the least size of S without what
    /// the core adds.
    #[inline(always)]
    fn response(
        &self,
        squares: [Row<L>; 2],
        high: Row<L>,
        shift: Row<L>,
        (core, y, phi): (Row<L>, Row<L>, Row<L>),
    ) -> Response<L> {
        // The odd amplitudes are coupled to the even ones by no more than `shift`.
        let through = core * shift;
        let x_column =
            [self.x_column[0] + high * self.x_column_damping[0], self.x_column[1] + high * self.x_column_damping[1]];
        let y_column = self.y_column[0] + through * self.y_column[1];
        let [at_y, even, odd] = self.phi_column;
        let phi_column = Column {
            at_y,
            eliminated: even + at_y * y_column * y + through * odd,
            whole: core * (norm(&[at_y, even]) + through * odd),
        };
        let amplitudes = x_column[1] * (Row::splat(1.0) + through);
        let x_column = Column {
            at_y: x_column[0],
            eliminated: amplitudes + x_column[0] * y_column * y,
            whole: core * norm(&x_column),
        };
        let x_row = self.row(self.x_row, squares, high, (core, y));
        let phi_row = self.row(self.phi_row, squares, high, (core, y));
        let phi = (phi - phi_row.through(&phi_column, y)).max(Row::ZERO).reciprocal();
        let phi_by_x = self.phi_by_x + high * self.phi_by_x_damping + phi_row.through(&x_column, y);
        let x = x_row.through(&x_column, y) + (self.x_by_phi + x_row.through(&phi_column, y)) * phi_by_x * phi;
        Response { core, phi, x }
    }

    /// A row that couples the core, at y and along that of y.
    #[inline(always)]
    fn row(&self, row: [Row<L>; 2], squares: [Row<L>; 2], high: Row<L>, (core, y): (Row<L>, Row<L>)) -> CoreRow<L> {
        let [at_y, along] = row;
        let first = (along * (self.y_stiffness - squares[0]) - at_y * self.y_row).abs();
        let second = (along * (self.y_stiffness - squares[1]) - at_y * self.y_row).abs();
        let at_amplitudes = first.max(second) + along.abs() * high * self.y_damping;
        CoreRow { at_y: at_y.abs(), eliminated: core * y * at_amplitudes, whole: norm(&row) }
    }
}

/// A row that couples the core: at y; its size at the amplitudes, times the inverse of the core, once y is eliminated;
/// and its whole size.
struct CoreRow<const L: usize> {
    at_y: Row<L>,
    eliminated: Row<L>,
    whole: Row<L>,
}

/// A column that couples the core: at y; its size at the amplitudes once y is eliminated; and a bound of the inverse of
/// the core times all of it.
struct Column<const L: usize> {
    at_y: Row<L>,
    eliminated: Row<L>,
    whole: Row<L>,
}

impl<const L: usize> CoreRow<L> {
    /// Bound of the row times the inverse of the core times the column. Near the resonance of y it is better not to
    /// eliminate y.
    #[inline(always)]
    fn through(&self, column: &Column<L>, y: Row<L>) -> Row<L> {
        (self.at_y * column.at_y * y + self.eliminated * column.eliminated).min(self.whole * column.whole)
    }
}

/// The least size of `stiffness - omega^2 + i omega damping` between two frequencies.
#[inline(always)]
fn distance<const L: usize>(
    stiffness: Row<L>,
    damping: Row<L>,
    (low, low_square): (Row<L>, Row<L>),
    high_square: Row<L>,
) -> Row<L> {
    (stiffness - high_square).max(low_square - stiffness).max(low * damping)
}

#[inline(always)]
fn along<const L: usize>(of_y: &[Row<L>], entries: &[Row<L>]) -> Row<L> {
    let mut sum = Row::ZERO;
    for (of_y, entry) in of_y.iter().zip(entries) {
        sum += *of_y * *entry;
    }
    sum
}

#[inline(always)]
fn size_of_column<const L: usize>(
    matrix: &[Row<L>],
    size: usize,
    column: usize,
    rows: std::ops::Range<usize>,
) -> Row<L> {
    let mut sum = Row::ZERO;
    for row in rows {
        let entry = matrix[row * size + column];
        sum += entry * entry;
    }
    SLACK * sum.sqrt()
}

/// The root of the sum of squares.
#[inline(always)]
pub(super) fn norm<const L: usize>(of: &[Row<L>]) -> Row<L> {
    let mut sum = Row::ZERO;
    for part in of {
        sum += *part * *part;
    }
    sum.sqrt()
}
