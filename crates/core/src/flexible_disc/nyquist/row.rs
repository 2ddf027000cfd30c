//! One number for each lane.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// One number for each lane. Everything is inlined: what is not is compiled for the processor's baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(crate) struct Row<const L: usize>(pub [f64; L]);

impl<const L: usize> Row<L> {
    pub const ZERO: Self = Self([0.0; L]);

    #[inline(always)]
    pub fn of(value: f64) -> Self {
        Self([value; L])
    }

    #[inline(always)]
    pub fn map(self, function: impl Fn(f64) -> f64) -> Self {
        let mut row = self;
        for value in &mut row.0 {
            *value = function(*value);
        }
        row
    }

    #[inline(always)]
    pub fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let mut row = self;
        for (value, other) in row.0.iter_mut().zip(&other.0) {
            *value = function(*value, *other);
        }
        row
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        self.map(f64::abs)
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    pub fn reciprocal(self) -> Self {
        self.map(|value| 1.0 / value)
    }

    /// The larger of two numbers; the second if either is no number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// The smaller of two numbers; the second if either is no number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
}

impl<const L: usize> Add for Row<L> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const L: usize> Sub for Row<L> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const L: usize> Mul for Row<L> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl<const L: usize> Mul<Row<L>> for f64 {
    type Output = Row<L>;

    #[inline(always)]
    fn mul(self, row: Row<L>) -> Row<L> {
        row.map(|value| self * value)
    }
}

impl<const L: usize> Neg for Row<L> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|value| -value)
    }
}

impl<const L: usize> AddAssign for Row<L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const L: usize> SubAssign for Row<L> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
