//! The grid of a job: the cells are the product of four axes.

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
                    _ => rounded(from + (to - from) * (i as f64 / last as f64)),
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

/// One cell of a job: the expected inputs and their relative standard deviations.
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

/// The product of the axes. `static_friction` varies fastest, then `preload`, `relative_std` and `rotating_speed`.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
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

    /// The number of values on each axis, slowest first.
    #[must_use]
    pub fn lengths(&self) -> [u64; 4] {
        [
            self.rotating_speed.0.len() as u64,
            self.relative_std.len() as u64,
            self.preload.0.len() as u64,
            self.static_friction.0.len() as u64,
        ]
    }

    /// The position on the axis of rotating speeds of the cell at `index`.
    #[must_use]
    pub fn rotating_speed_index(&self, index: u64) -> usize {
        let [_, stds, preloads, frictions] = self.lengths();
        (index / (frictions * preloads * stds)) as usize
    }

    /// The position on the axis of relative standard deviations of the cell at `index`.
    #[must_use]
    pub fn relative_std_index(&self, index: u64) -> usize {
        let [_, stds, preloads, frictions] = self.lengths();
        (index / (frictions * preloads) % stds) as usize
    }

    /// The cell at `index`.
    ///
    /// # Panics
    /// If `index` is not below the number of cells.
    #[must_use]
    pub fn cell(&self, index: u64) -> Cell {
        let [_, _, preloads, frictions] = self.lengths();
        let friction = index % frictions;
        let preload = index / frictions % preloads;
        Cell {
            index,
            rotating_speed: self.rotating_speed.0[self.rotating_speed_index(index)],
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
                        let cell =
                            Cell { index: expected, rotating_speed: speed, relative_std, preload, static_friction };
                        assert_eq!(grid.cell(expected), cell);
                        expected += 1;
                    }
                }
            }
        }
    }
}
