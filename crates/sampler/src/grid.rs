//! The grid of a job: the cells are the product of its axes.
//!
//! An axis holds the values of one quantity of the model. This crate knows a quantity only by its place in the model's
//! list. One more axis, that of scatter, holds the relative standard deviations of the random inputs.

use std::iter::once;

use thiserror::Error;

/// The values of one quantity over a job: at least one, all finite, none repeated.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis(Vec<f64>);

/// Why an axis was refused.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum AxisError {
    /// No values.
    #[error("the axis is empty; it needs at least one value")]
    Empty,
    /// NaN or an infinity.
    #[error("{value} is not a finite number")]
    NotFinite {
        /// The offending value.
        value: f64,
    },
    /// The same value twice.
    #[error("{value} appears twice; each value makes cells of its own, so list it once")]
    Repeated {
        /// The repeated value.
        value: f64,
    },
    /// A range of several points between equal ends.
    #[error("from = to = {value} leaves no room for {points} points; give one point, or two different ends")]
    NoExtent {
        /// Both ends.
        value: f64,
        /// Points asked for.
        points: usize,
    },
    /// A range of one point between different ends.
    #[error("one point cannot reach from {from} to {to}; give at least 2 points, or a single number")]
    SinglePoint {
        /// First end.
        from: f64,
        /// Last end.
        to: f64,
    },
    /// A logarithmic range with an end that is not positive.
    #[error(
        "{value} has no logarithm: both ends of a range with scale = \"log\" must be positive; use scale = \"linear\""
    )]
    NotPositive {
        /// The offending end.
        value: f64,
    },
}

impl Axis {
    /// An axis with these values, in the order given.
    ///
    /// # Errors
    /// [`AxisError`] if the list is empty, or a value repeated or not finite.
    pub fn from_values(values: Vec<f64>) -> Result<Self, AxisError> {
        if values.is_empty() {
            return Err(AxisError::Empty);
        }
        if let Some(&value) = values.iter().find(|value| !value.is_finite()) {
            return Err(AxisError::NotFinite { value });
        }
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(AxisError::Repeated { value: pair[0] });
        }
        Ok(Self(values))
    }

    /// An axis of `points` evenly spaced values from `from` to `to`, both included exactly.
    ///
    /// Values between the ends are rounded to 14 significant digits, so that a step of 0.01 gives 0.1 and not
    /// 0.09999999999999999.
    ///
    /// # Errors
    /// [`AxisError`] if an end is not finite, or the number of points does not fit the ends.
    pub fn evenly_spaced(from: f64, to: f64, points: usize) -> Result<Self, AxisError> {
        Self::between(from, to, points, |share| from + (to - from) * share)
    }

    /// An axis of `points` values from `from` to `to`, both included exactly, each the same multiple of the one before.
    ///
    /// Values between the ends are rounded to 14 significant digits, so that three points from 1 to 100 are 1, 10 and
    /// 100.
    ///
    /// # Errors
    /// [`AxisError`] if an end is not positive and finite, or the number of points does not fit the ends.
    pub fn log_spaced(from: f64, to: f64, points: usize) -> Result<Self, AxisError> {
        if let Some(&value) = [from, to].iter().find(|value| **value <= 0.0) {
            return Err(AxisError::NotPositive { value });
        }
        let (first, last) = (libm::log(from), libm::log(to));
        Self::between(from, to, points, |share| libm::exp(first + (last - first) * share))
    }

    /// An axis of `points` values between two ends; `inside` gives the value at a share of the way.
    fn between(from: f64, to: f64, points: usize, inside: impl Fn(f64) -> f64) -> Result<Self, AxisError> {
        if let Some(&value) = [from, to].iter().find(|value| !value.is_finite()) {
            return Err(AxisError::NotFinite { value });
        }
        match points {
            0 => Err(AxisError::Empty),
            1 if from == to => Ok(Self(vec![from])),
            1 => Err(AxisError::SinglePoint { from, to }),
            _ if from == to => Err(AxisError::NoExtent { value: from, points }),
            _ => {
                let last = points - 1;
                let value = |i: usize| match i {
                    0 => from,
                    _ if i == last => to,
                    _ => rounded(inside(i as f64 / last as f64)),
                };
                Self::from_values((0..points).map(value).collect())
            }
        }
    }

    /// The values.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.0
    }

    /// The smallest and the largest value.
    #[must_use]
    pub fn extremes(&self) -> [f64; 2] {
        let values = || self.0.iter().copied();
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    }
}

/// The nearest number with 14 significant digits. Printing and parsing round correctly, so that every machine agrees.
fn rounded(value: f64) -> f64 {
    format!("{value:.13e}").parse().unwrap_or(value)
}

/// One cell of a job: the expected values of the quantities of the model, and how much its random inputs scatter.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Position in the grid, from 0.
    pub index: u64,
    /// The expected value of each quantity of the model, in the model's order.
    pub expected: Vec<f64>,
    /// Position on the axis of scatter.
    pub scatter: usize,
}

/// An axis of a grid: values of one quantity of the model, which is known by its place in the model's list.
#[derive(Debug, Clone, PartialEq)]
pub struct GridAxis {
    /// The place of the quantity in the model's list.
    pub quantity: usize,
    /// Its values.
    pub axis: Axis,
}

/// The product of axes over quantities.
///
/// A *configuration* is a combination of values of those axes that make one: what cells have in common that differ only
/// in other quantities and in scatter.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// The expected values of all quantities of the model, in the model's order, where they are no axis. NaN: not given.
    pub expected: Vec<f64>,
    /// The axes, slowest first; no quantity has two.
    pub axes: Vec<GridAxis>,
    /// Number of values of the axis of scatter (relative standard deviations of the random inputs); at least 1.
    pub scatters: usize,
    /// How many of the axes vary more slowly than the scatter.
    pub slower_than_scatter: usize,
    /// For each quantity of the model, whether a configuration is made of it.
    pub of_configuration: Vec<bool>,
}

impl Grid {
    /// All axes, slowest first, each with its number of values. `None` is the axis of scatter.
    fn radices(&self) -> impl DoubleEndedIterator<Item = (Option<&GridAxis>, u64)> {
        let (slower, faster) = self.axes.split_at(self.slower_than_scatter);
        let with_length = |axis| (Some(axis), length(axis));
        let scatter = once((None, self.scatters as u64));
        slower.iter().map(with_length).chain(scatter).chain(faster.iter().map(with_length))
    }

    /// Whether an axis makes configurations.
    fn makes_configurations(&self, axis: Option<&GridAxis>) -> bool {
        axis.is_some_and(|axis| self.of_configuration[axis.quantity])
    }

    /// The number of cells, or `None` if it exceeds 64 bits.
    #[must_use]
    pub fn checked_len(&self) -> Option<u64> {
        self.radices().try_fold(1u64, |product, (_, length)| product.checked_mul(length))
    }

    /// The cell in the middle of every axis, of two the one before; `None` if there are more cells than 64 bits count.
    #[must_use]
    pub fn middle(&self) -> Option<u64> {
        self.checked_len()?;
        Some(self.radices().fold(0, |index, (_, length)| index * length + (length - 1) / 2))
    }

    /// The number of values on each axis and on that of scatter, slowest first.
    #[must_use]
    pub fn lengths(&self) -> Vec<u64> {
        self.radices().map(|(_, length)| length).collect()
    }

    /// The cell at `index`, which must be below the number of cells.
    #[must_use]
    pub fn cell(&self, index: u64) -> Cell {
        let mut cell = Cell { index, expected: self.expected.clone(), scatter: 0 };
        let mut rest = index;
        for (axis, length) in self.radices().rev() {
            let place = (rest % length) as usize;
            match axis {
                Some(GridAxis { quantity, axis }) => cell.expected[*quantity] = axis.0[place],
                None => cell.scatter = place,
            }
            rest /= length;
        }
        cell
    }

    /// The number of configurations.
    #[must_use]
    pub fn configurations(&self) -> usize {
        self.axes.iter().filter(|&axis| self.makes_configurations(Some(axis))).map(|axis| axis.axis.0.len()).product()
    }

    /// The index of a cell in a grid that has only the axes that `keeps` keeps.
    fn index_among(&self, index: u64, keeps: impl Fn(Option<&GridAxis>) -> bool) -> u64 {
        let (mut among, mut stride, mut rest) = (0, 1, index);
        for (axis, length) in self.radices().rev() {
            if keeps(axis) {
                among += rest % length * stride;
                stride *= length;
            }
            rest /= length;
        }
        among
    }

    /// The index of the first cell with an index in that grid.
    fn first_with(&self, among: u64, keeps: impl Fn(Option<&GridAxis>) -> bool) -> u64 {
        let (mut first, mut stride, mut rest) = (0, 1, among);
        for (axis, length) in self.radices().rev() {
            if keeps(axis) {
                first += rest % length * stride;
                rest /= length;
            }
            stride *= length;
        }
        first
    }

    /// The configuration of the cell at `index`, below [`Grid::configurations`].
    #[must_use]
    pub fn configuration_index(&self, index: u64) -> usize {
        self.index_among(index, |axis| self.makes_configurations(axis)) as usize
    }

    /// The first cell with a configuration, which must be below [`Grid::configurations`].
    #[must_use]
    pub fn first_cell_with(&self, configuration: usize) -> Cell {
        self.cell(self.first_with(configuration as u64, |axis| self.makes_configurations(axis)))
    }

    /// The index of the first cell that differs from that at `index` in the scatter and the value of one quantity at most.
    #[must_use]
    pub fn first_cell_but_for(&self, quantity: usize, index: u64) -> u64 {
        let keeps = |axis: Option<&GridAxis>| axis.is_some_and(|axis| axis.quantity != quantity);
        self.first_with(self.index_among(index, keeps), keeps)
    }

    /// The index of a cell in the grid without the axis of a quantity, if it has one.
    #[must_use]
    pub fn index_without(&self, quantity: usize, index: u64) -> u64 {
        self.index_among(index, |axis| axis.is_none_or(|axis| axis.quantity != quantity))
    }

    /// The axis of a quantity, if it has one.
    #[must_use]
    pub fn axis_of(&self, quantity: usize) -> Option<&Axis> {
        self.axes.iter().find(|axis| axis.quantity == quantity).map(|axis| &axis.axis)
    }

    /// The values of a quantity: those of its axis, or the one expected value.
    #[must_use]
    pub fn values_of(&self, quantity: usize) -> Vec<f64> {
        self.axis_of(quantity).map_or_else(|| vec![self.expected[quantity]], |axis| axis.0.clone())
    }

    /// The smallest and the largest value of a quantity.
    #[must_use]
    pub fn extremes_of(&self, quantity: usize) -> [f64; 2] {
        self.axis_of(quantity).map_or([self.expected[quantity]; 2], Axis::extremes)
    }
}

/// The number of values of an axis.
fn length(axis: &GridAxis) -> u64 {
    axis.axis.0.len() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_exact_and_spacing_even() {
        let axis = Axis::evenly_spaced(0.01, 0.30, 30).unwrap();
        assert_eq!((axis.values()[0], axis.values()[29]), (0.01, 0.30));
        let written = [0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1, 0.11, 0.12];
        assert_eq!(axis.values()[1..12], written, "short decimals");
        assert_eq!(Axis::evenly_spaced(3.0, 1.0, 3).unwrap().values(), [3.0, 2.0, 1.0]);
    }

    #[test]
    fn axes_that_define_no_cells_are_refused() {
        assert_eq!(Axis::from_values(vec![]), Err(AxisError::Empty));
        assert_eq!(Axis::evenly_spaced(0.0, 1.0, 0), Err(AxisError::Empty));
        assert_eq!(Axis::evenly_spaced(0.0, 1.0, 1), Err(AxisError::SinglePoint { from: 0.0, to: 1.0 }));
        assert_eq!(Axis::evenly_spaced(1.0, 1.0, 3), Err(AxisError::NoExtent { value: 1.0, points: 3 }));
        assert_eq!(Axis::from_values(vec![1.0, 2.0, 1.0]), Err(AxisError::Repeated { value: 1.0 }));
        assert!(matches!(Axis::from_values(vec![f64::NAN]), Err(AxisError::NotFinite { .. })));
        assert!(matches!(Axis::evenly_spaced(0.0, f64::INFINITY, 3), Err(AxisError::NotFinite { .. })));
    }

    fn axis(quantity: usize, values: &[f64]) -> GridAxis {
        GridAxis { quantity, axis: Axis::from_values(values.to_vec()).unwrap() }
    }

    #[test]
    fn the_last_axis_varies_fastest_and_the_scatter_in_its_place() {
        // Quantities: preload, static friction, rotating speed, and one without an axis.
        let grid = Grid {
            expected: vec![f64::NAN, f64::NAN, f64::NAN, 7.0],
            axes: vec![axis(2, &[10.0, 15.0]), axis(0, &[0.1, 0.2]), axis(1, &[0.3, 0.4, 0.5, 0.6])],
            scatters: 3,
            slower_than_scatter: 1,
            of_configuration: vec![false, false, true, true],
        };
        assert_eq!((grid.checked_len(), grid.lengths()), (Some(48), vec![2, 3, 2, 4]));
        let mut index = 0;
        for speed in [10.0, 15.0] {
            for scatter in 0..3 {
                for preload in [0.1, 0.2] {
                    for friction in [0.3, 0.4, 0.5, 0.6] {
                        let expected = vec![preload, friction, speed, 7.0];
                        assert_eq!(grid.cell(index), Cell { index, expected, scatter });
                        index += 1;
                    }
                }
            }
        }
        assert_eq!((grid.axis_of(3), grid.values_of(3), grid.extremes_of(3)), (None, vec![7.0], [7.0; 2]));
        assert_eq!((grid.values_of(0), grid.extremes_of(1)), (vec![0.1, 0.2], [0.3, 0.6]));
        let middle = grid.cell(grid.middle().unwrap());
        assert_eq!((middle.expected, middle.scatter), (vec![0.1, 0.4, 10.0, 7.0], 1));
    }

    #[test]
    fn more_cells_than_64_bits_count_are_refused() {
        let long: Vec<f64> = (0..1 << 16).map(f64::from).collect();
        let mut grid = Grid {
            expected: vec![0.0; 4],
            axes: (0..3).map(|quantity| axis(quantity, &long)).collect(),
            scatters: 1 << 15,
            slower_than_scatter: 0,
            of_configuration: vec![false; 4],
        };
        assert_eq!(grid.checked_len(), Some(1 << 63));
        grid.axes.push(axis(3, &long));
        assert_eq!((grid.checked_len(), grid.middle()), (None, None));
    }

    #[test]
    fn values_of_a_logarithmic_axis_have_one_ratio() {
        assert_eq!(Axis::log_spaced(1e6, 1e9, 4).unwrap().values(), [1e6, 1e7, 1e8, 1e9]);
        assert_eq!(Axis::log_spaced(100.0, 1.0, 3).unwrap().values(), [100.0, 10.0, 1.0]);
        let axis = Axis::log_spaced(3.7e7, 4.1e8, 12).unwrap();
        assert_eq!((axis.values()[0], axis.values()[11]), (3.7e7, 4.1e8), "ends are exact");
        let ratio = axis.values()[1] / axis.values()[0];
        assert!(axis.values().windows(2).all(|pair| (pair[1] / pair[0] / ratio - 1.0).abs() < 1e-12));
        for (from, to, value) in [(0.0, 1.0, 0.0), (1.0, -2.0, -2.0)] {
            assert_eq!(Axis::log_spaced(from, to, 3), Err(AxisError::NotPositive { value }));
        }
        assert!(matches!(Axis::log_spaced(1.0, f64::NAN, 3), Err(AxisError::NotFinite { .. })));
        assert_eq!(Axis::log_spaced(2.0, 2.0, 1).unwrap().values(), [2.0]);
    }

    #[test]
    fn what_cells_have_in_common_is_found_however_axes_lie_between() {
        // As for a brake: two axes of it, one of the start of a motion, the speed, the scatter, and the two inputs.
        let grid = Grid {
            expected: vec![f64::NAN; 6],
            axes: vec![
                axis(3, &[1.0, 2.0]),
                axis(4, &[3.0, 4.0, 5.0]),
                axis(5, &[6.0, 7.0]),
                axis(2, &[10.0, 15.0]),
                axis(0, &[0.1, 0.2]),
                axis(1, &[0.3, 0.4, 0.5]),
            ],
            scatters: 2,
            slower_than_scatter: 4,
            of_configuration: vec![false, false, true, true, true, false],
        };
        assert_eq!(grid.checked_len(), Some(288));
        assert_eq!(grid.configurations(), 12);
        let mut index = 0;
        for (ab, first) in [1.0, 2.0].into_iter().flat_map(|a| [3.0, 4.0, 5.0].map(|b| (a, b))).enumerate() {
            for c in [6.0, 7.0] {
                for (speed, rotating_speed) in [10.0, 15.0].into_iter().enumerate() {
                    for place in 0..12 {
                        let inputs = [[0.1, 0.2][place / 3 % 2], [0.3, 0.4, 0.5][place % 3]];
                        let expected = vec![inputs[0], inputs[1], rotating_speed, first.0, first.1, c];
                        assert_eq!(grid.cell(index), Cell { index, expected, scatter: place / 6 });
                        assert_eq!(grid.configuration_index(index), 2 * ab + speed);
                        index += 1;
                    }
                }
            }
        }
        for configuration in 0..grid.configurations() {
            let cell = grid.first_cell_with(configuration);
            assert_eq!(grid.configuration_index(cell.index), configuration);
            let before = (0..cell.index).any(|index| grid.configuration_index(index) == configuration);
            assert!(!before, "the first of configuration {configuration}");
        }
        for quantity in 0..6 {
            // Without an axis a grid has the same cells in the same order.
            let mut without = grid.clone();
            let place = without.axes.iter().position(|axis| axis.quantity == quantity).unwrap();
            without.axes.remove(place);
            without.slower_than_scatter -= usize::from(place < grid.slower_than_scatter);
            for index in 0..288 {
                let [mut cell, other] = [grid.cell(index), without.cell(grid.index_without(quantity, index))];
                cell.expected[quantity] = f64::NAN;
                let bits = |cell: &Cell| cell.expected.iter().map(|value| value.to_bits()).collect::<Vec<u64>>();
                assert_eq!((bits(&cell), cell.scatter), (bits(&other), other.scatter));
                let is_like = |other: &u64| {
                    let [mut a, mut b] = [index, *other].map(|index| grid.cell(index).expected);
                    (a[quantity], b[quantity]) = (0.0, 0.0);
                    a == b
                };
                assert_eq!(Some(grid.first_cell_but_for(quantity, index)), (0..288).find(is_like));
            }
        }
    }
}
