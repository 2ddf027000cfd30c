//! Numbers of one sample, or of many in the lanes of vector registers.
//!
//! Formulas are written once for a [`Number`]: for one number, and for a [`Row`] of one number for each lane, which has
//! the same operations in the same order. So lanes have the bits of single samples.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use std::slice;

/// A number, or one for each lane. Everything is inlined: what is not is compiled for the processor's baseline.
pub(crate) trait Number:
    Copy + Default + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The same number in all lanes.
    fn splat(value: f64) -> Self;

    /// The numbers of the lanes.
    fn lanes(&self) -> &[f64];
    fn lanes_mut(&mut self) -> &mut [f64];

    #[inline(always)]
    fn map(mut self, function: impl Fn(f64) -> f64) -> Self {
        for value in self.lanes_mut() {
            *value = function(*value);
        }
        self
    }

    #[inline(always)]
    fn zip(mut self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        for (value, other) in self.lanes_mut().iter_mut().zip(other.lanes()) {
            *value = function(*value, *other);
        }
        self
    }

    /// `first` where `self` is not 0, `second` elsewhere.
    #[inline(always)]
    fn choose(self, first: Self, mut second: Self) -> Self {
        for ((choice, first), second) in self.lanes().iter().zip(first.lanes()).zip(second.lanes_mut()) {
            *second = if *choice != 0.0 { *first } else { *second };
        }
        second
    }

    /// Whether a number is not 0.
    #[inline(always)]
    fn any(&self) -> bool {
        self.lanes().iter().fold(false, |any, value| any | (*value != 0.0))
    }

    /// Whether none is 0.
    #[inline(always)]
    fn all(&self) -> bool {
        self.lanes().iter().fold(true, |all, value| all & (*value != 0.0))
    }

    /// Stands in a loop over rows. Else the compiler may vectorise the loop in place of the operations on each row, and
    /// gather and scatter the numbers of a lane.
    #[inline(always)]
    fn keep_lanes_together() {
        if size_of::<Self>() > size_of::<f64>() {
            std::hint::black_box(());
        }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }
}

impl Number for f64 {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn lanes(&self) -> &[f64] {
        slice::from_ref(self)
    }

    #[inline(always)]
    fn lanes_mut(&mut self) -> &mut [f64] {
        slice::from_mut(self)
    }
}

/// One number for each lane.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(crate) struct Row<const L: usize>(pub [f64; L]);

impl<const L: usize> Number for Row<L> {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; L])
    }

    #[inline(always)]
    fn lanes(&self) -> &[f64] {
        &self.0
    }

    #[inline(always)]
    fn lanes_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl<const L: usize> Default for Row<L> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<const L: usize> Row<L> {
    pub const ZERO: Self = Self([0.0; L]);

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

macro_rules! operators {
    ($($operator:ident $function:ident $symbol:tt,)*) => {
        $(impl<const L: usize> $operator for Row<L> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                self.zip(other, |a, b| a $symbol b)
            }
        })*
    };
}

operators!(Add add +, Sub sub -, Mul mul *, Div div /,);

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

/// Values of samples in lanes: a row, or a struct of rows.
pub(crate) trait Lanes {
    /// The same of one sample.
    type Sample;

    /// Sets those of one lane.
    fn set(&mut self, lane: usize, sample: &Self::Sample);

    /// Those of one lane.
    fn get(&self, lane: usize) -> Self::Sample;
}

impl<const L: usize> Lanes for Row<L> {
    type Sample = f64;

    #[inline(always)]
    fn set(&mut self, lane: usize, sample: &f64) {
        self.0[lane] = *sample;
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> f64 {
        self.0[lane]
    }
}

impl<T: Lanes> Lanes for Vec<T> {
    type Sample = Vec<T::Sample>;

    fn set(&mut self, lane: usize, samples: &Self::Sample) {
        for (lanes, sample) in self.iter_mut().zip(samples) {
            lanes.set(lane, sample);
        }
    }

    fn get(&self, lane: usize) -> Self::Sample {
        self.iter().map(|lanes| lanes.get(lane)).collect()
    }
}

/// Something that all lanes have in common.
macro_rules! shared_by_lanes {
    ($name:ty) => {
        impl $crate::numerics::row::Lanes for $name {
            type Sample = Self;

            #[inline(always)]
            fn set(&mut self, _: usize, sample: &Self) {
                *self = *sample;
            }

            #[inline(always)]
            fn get(&self, _: usize) -> Self {
                *self
            }
        }
    };
}

// An index.
shared_by_lanes!(usize);

/// Defines a struct of numbers, of one sample or of many in lanes.
macro_rules! numbers {
    (
        $(#[$attribute:meta])*
        pub(crate) struct $name:ident<N> { $($(#[$of_field:meta])* pub $field:ident: $type:ty,)* }
    ) => {
        $(#[$attribute])*
        pub(crate) struct $name<N = f64> {
            $($(#[$of_field])* pub $field: $type,)*
        }

        impl<const L: usize> $crate::numerics::row::Lanes for $name<$crate::numerics::row::Row<L>> {
            type Sample = $name;

            #[inline(always)]
            fn set(&mut self, lane: usize, sample: &$name) {
                $($crate::numerics::row::Lanes::set(&mut self.$field, lane, &sample.$field);)*
            }

            #[inline(always)]
            fn get(&self, lane: usize) -> $name {
                $name { $($field: $crate::numerics::row::Lanes::get(&self.$field, lane),)* }
            }
        }
    };
}

pub(crate) use {numbers, shared_by_lanes};
