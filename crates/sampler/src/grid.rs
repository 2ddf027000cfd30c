//! The grid of a job: the cells are the product of its axes.
//!
//! Four axes are always there: rotating speed, relative standard deviation, preload and static friction. A grid may
//! have further axes, which vary more slowly. Each has a name, which this crate does not interpret.

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

/// Relative standard deviations (standard deviation over expected value) of preload and static friction; 0 for an input
/// that does not scatter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeStd {
    /// Of the preload.
    pub preload: f64,
    /// Of the static friction coefficient.
    pub static_friction: f64,
}

/// One cell of a job: the expected inputs and their relative standard deviations. [`Grid::further_values`] has its
/// values on further axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Position in the grid, from 0.
    pub index: u64,
    /// Rotating speed Omega, rad/s.
    pub rotating_speed: f64,
    /// Relative standard deviations.
    pub relative_std: RelativeStd,
    /// Expected preload Delta, dimensionless.
    pub preload: f64,
    /// Expected static friction coefficient f_s.
    pub static_friction: f64,
}

/// An axis of a quantity that has none in every grid.
#[derive(Debug, Clone, PartialEq)]
pub struct FurtherAxis {
    /// Which quantity, as the caller names it.
    pub name: String,
    /// Its values.
    pub axis: Axis,
}

/// The product of the axes. `static_friction` varies fastest, then `preload`, `relative_std`, `rotating_speed` and the
/// further axes, the last of them first.
///
/// A *brake* is a combination of values of the axes of the brake and a rotating speed: what cells have in common that
/// differ only in the inputs, their scatter and the start.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Further axes of the brake, slowest first.
    pub of_brake: Vec<FurtherAxis>,
    /// Further axes of the start of a motion, slowest first. They vary faster than those of the brake.
    pub of_start: Vec<FurtherAxis>,
    /// Rotating speeds, rad/s.
    pub rotating_speed: Axis,
    /// Relative standard deviations; never empty.
    pub relative_std: Vec<RelativeStd>,
    /// Expected preloads.
    pub preload: Axis,
    /// Expected static friction coefficients.
    pub static_friction: Axis,
}

impl Grid {
    /// The number of cells, or `None` if it exceeds 64 bits.
    #[must_use]
    pub fn checked_len(&self) -> Option<u64> {
        self.lengths().iter().try_fold(1u64, |product, &length| product.checked_mul(length))
    }

    /// The further axes, slowest first.
    #[must_use]
    pub fn further(&self) -> impl DoubleEndedIterator<Item = &FurtherAxis> {
        self.of_brake.iter().chain(&self.of_start)
    }

    /// The number of values on each axis, slowest first; the last four are always there.
    #[must_use]
    pub fn lengths(&self) -> Vec<u64> {
        let mut lengths: Vec<u64> = self.further().map(|further| further.axis.0.len() as u64).collect();
        lengths.extend(self.usual_lengths());
        lengths
    }

    /// The numbers of rotating speeds, standard deviations, preloads and static friction coefficients.
    fn usual_lengths(&self) -> [u64; 4] {
        let lengths = [&self.rotating_speed, &self.preload, &self.static_friction].map(|axis| axis.0.len() as u64);
        [lengths[0], self.relative_std.len() as u64, lengths[1], lengths[2]]
    }

    /// The number of brakes.
    #[must_use]
    pub fn brakes(&self) -> usize {
        let of_brake: usize = self.of_brake.iter().map(|further| further.axis.0.len()).product();
        of_brake * self.rotating_speed.0.len()
    }

    /// The brake of the cell at `index`, below [`Grid::brakes`]. Without further axes it is the position on the axis of
    /// rotating speeds.
    #[must_use]
    pub fn brake_index(&self, index: u64) -> usize {
        let [speeds, stds, preloads, frictions] = self.usual_lengths();
        let starts: u64 = self.of_start.iter().map(|further| further.axis.0.len() as u64).product();
        let place = index / (frictions * preloads * stds);
        (place / speeds / starts * speeds + place % speeds) as usize
    }

    /// The first cell with a brake, which must be below [`Grid::brakes`].
    #[must_use]
    pub fn first_cell_with(&self, brake: usize) -> Cell {
        let [speeds, stds, preloads, frictions] = self.usual_lengths();
        let starts: u64 = self.of_start.iter().map(|further| further.axis.0.len() as u64).product();
        let brake = brake as u64;
        self.cell((brake / speeds * starts * speeds + brake % speeds) * stds * preloads * frictions)
    }

    /// The position on the axis of relative standard deviations of the cell at `index`.
    #[must_use]
    pub fn relative_std_index(&self, index: u64) -> usize {
        let [_, stds, preloads, frictions] = self.usual_lengths();
        (index / (frictions * preloads) % stds) as usize
    }

    /// The values of the further axes in the cell at `index`, in their order.
    #[must_use]
    pub fn further_values(&self, index: u64) -> Vec<f64> {
        let [speeds, stds, preloads, frictions] = self.usual_lengths();
        let mut place = index / (frictions * preloads * stds * speeds);
        let mut values = Vec::new();
        for FurtherAxis { axis, .. } in self.further().rev() {
            let length = axis.0.len() as u64;
            values.push(axis.0[(place % length) as usize]);
            place /= length;
        }
        values.reverse();
        values
    }

    /// The cell at `index`, which must be below the number of cells.
    #[must_use]
    pub fn cell(&self, index: u64) -> Cell {
        let [speeds, stds, preloads, frictions] = self.usual_lengths();
        let friction = index % frictions;
        let preload = index / frictions % preloads;
        let speed = index / (frictions * preloads * stds) % speeds;
        Cell {
            index,
            rotating_speed: self.rotating_speed.0[speed as usize],
            relative_std: self.relative_std[self.relative_std_index(index)],
            preload: self.preload.0[preload as usize],
            static_friction: self.static_friction.0[friction as usize],
        }
    }
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

    #[test]
    fn static_friction_varies_fastest_and_rotating_speed_slowest() {
        let std = |value| RelativeStd { preload: value, static_friction: value };
        let grid = Grid {
            of_brake: Vec::new(),
            of_start: Vec::new(),
            rotating_speed: Axis::from_values(vec![10.0, 15.0]).unwrap(),
            relative_std: vec![std(0.1), std(0.2), std(0.3)],
            preload: Axis::from_values(vec![0.1, 0.2]).unwrap(),
            static_friction: Axis::from_values(vec![0.3, 0.4, 0.5, 0.6]).unwrap(),
        };
        assert_eq!(grid.checked_len(), Some(48));
        let mut expected = 0;
        for &speed in grid.rotating_speed.values() {
            for &relative_std in &grid.relative_std {
                for &preload in grid.preload.values() {
                    for &static_friction in grid.static_friction.values() {
                        let cell = grid.cell(expected);
                        assert_eq!((cell.rotating_speed, cell.relative_std), (speed, relative_std));
                        assert_eq!((cell.preload, cell.static_friction), (preload, static_friction));
                        assert_eq!((cell.index, grid.further_values(expected)), (expected, Vec::new()));
                        expected += 1;
                    }
                }
            }
        }
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
    fn further_axes_vary_slowest_and_those_of_the_start_make_no_brake() {
        let axis = |name: &str, values: &[f64]| FurtherAxis {
            name: name.to_owned(),
            axis: Axis::from_values(values.to_vec()).unwrap(),
        };
        let of = |values: &[f64]| Axis::from_values(values.to_vec()).unwrap();
        let grid = Grid {
            of_brake: vec![axis("a", &[1.0, 2.0]), axis("b", &[3.0, 4.0, 5.0])],
            of_start: vec![axis("c", &[6.0, 7.0])],
            rotating_speed: of(&[10.0, 15.0]),
            relative_std: vec![RelativeStd { preload: 0.1, static_friction: 0.0 }],
            preload: of(&[0.1, 0.2]),
            static_friction: of(&[0.3, 0.4, 0.5]),
        };
        assert_eq!(grid.checked_len(), Some(144));
        assert_eq!(grid.brakes(), 12);
        let mut index = 0;
        for (ab, first) in [1.0, 2.0].into_iter().flat_map(|a| [3.0, 4.0, 5.0].map(|b| (a, b))).enumerate() {
            for c in [6.0, 7.0] {
                for (speed, rotating_speed) in [10.0, 15.0].into_iter().enumerate() {
                    for place in 0..6 {
                        let cell = grid.cell(index);
                        assert_eq!(grid.further_values(index), [first.0, first.1, c]);
                        assert_eq!(cell.rotating_speed, rotating_speed);
                        assert_eq!(cell.static_friction, [0.3, 0.4, 0.5][place % 3]);
                        assert_eq!(grid.brake_index(index), 2 * ab + speed);
                        index += 1;
                    }
                }
            }
        }
        for brake in 0..grid.brakes() {
            let cell = grid.first_cell_with(brake);
            assert_eq!(grid.brake_index(cell.index), brake);
            let before = (0..cell.index).any(|index| grid.brake_index(index) == brake);
            assert!(!before, "the first of brake {brake}");
        }
    }
}
