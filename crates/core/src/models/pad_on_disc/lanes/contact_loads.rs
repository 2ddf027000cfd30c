//! The loads of a contact that covers the whole patch, in lanes.
//!
//! They are sums of products of amplitudes with the averages of [`crate::models::pad_on_disc::flexible_disc::contact`], which all lanes
//! share. Most of the work of a flexible step is here. Some rows of sums stay in registers together while the products
//! pass by, so that a product is computed once for all of them and used at once.

#![allow(clippy::needless_range_loop, reason = "constant indices keep sums in registers")]

use crate::models::pad_on_disc::flexible_disc::contact::averages::Averages;
use crate::models::pad_on_disc::lanes::{BLOCK, Row};

/// Loads whose sums are kept in registers together.
const MOST_AT_ONCE: usize = 5;

/// Some loads that are summed together, and the factors of one product after the other in them.
#[derive(Debug, Clone, PartialEq)]
struct Group {
    first: usize,
    loads: usize,
    /// For each product one factor for each load.
    factors: Vec<f64>,
}

impl Group {
    /// Groups of loads from the factors of each load.
    fn from_loads(loads: &[Vec<f64>]) -> Vec<Self> {
        let transposed = |loads: &[Vec<f64>]| -> Vec<f64> {
            let products = loads.first().map_or(0, Vec::len);
            (0..products).flat_map(|product| loads.iter().map(move |load| load[product])).collect()
        };
        let groups = loads.chunks(MOST_AT_ONCE).zip((0..).step_by(MOST_AT_ONCE));
        groups.map(|(loads, first)| Self { first, loads: loads.len(), factors: transposed(loads) }).collect()
    }
}

/// The averages that the loads are sums of.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tables {
    pub even: usize,
    pub odd: usize,
    pub averages: Averages,
    even_even: Vec<Group>,
    odd_odd: Vec<Group>,
    even_follower: Vec<Group>,
    odd_follower: Vec<Group>,
}

impl Tables {
    pub fn new(averages: &Averages) -> Self {
        let (even, odd) = (averages.shape.len(), averages.arc_shape.len());
        Self {
            even,
            odd,
            averages: averages.clone(),
            even_even: Group::from_loads(&rows(&averages.even_even, even)),
            odd_odd: Group::from_loads(&rows(&averages.odd_odd, odd)),
            even_follower: Group::from_loads(&averages.even_follower),
            odd_follower: Group::from_loads(&averages.odd_follower),
        }
    }
}

/// The rows of a square matrix.
fn rows(matrix: &[f64], size: usize) -> Vec<Vec<f64>> {
    matrix.chunks(size.max(1)).map(<[f64]>::to_vec).collect()
}

/// The loads on the modes.
#[derive(Debug, Clone)]
pub(super) struct LoadRows {
    pub on_modes: Vec<Row>,
    pub follower: Vec<Row>,
}

/// Some lanes of a row.
#[inline(always)]
fn part<const W: usize>(row: &Row, first: usize) -> [f64; W] {
    let mut part = [0.0; W];
    part.copy_from_slice(&row.0[first..first + W]);
    part
}

/// Sums in registers: `R` loads in `W` lanes. Products are added in the order of the scalar code.
struct Sums<'a, const R: usize, const W: usize> {
    sums: [[f64; W]; R],
    /// The factors of the products to come.
    factors: &'a [[f64; R]],
    /// The first of the lanes.
    lane: usize,
}

impl<'a, const R: usize, const W: usize> Sums<'a, R, W> {
    #[inline(always)]
    fn new(group: &'a Group, lane: usize) -> Self {
        Self { sums: [[0.0; W]; R], factors: group.factors.as_chunks().0, lane }
    }

    /// Adds the products of some rows with a factor of their own each.
    #[inline(always)]
    fn add(&mut self, rows: &[Row]) {
        let (present, rest) = self.factors.split_at(rows.len().min(self.factors.len()));
        for (row, factors) in rows.iter().zip(present) {
            let row: [f64; W] = part(row, self.lane);
            for r in 0..R {
                for l in 0..W {
                    self.sums[r][l] += factors[r] * row[l];
                }
            }
        }
        self.factors = rest;
    }

    /// Adds those of the products of one row with others.
    #[inline(always)]
    fn add_products(&mut self, by: &Row, rows: &[Row]) {
        let by: [f64; W] = part(by, self.lane);
        let (present, rest) = self.factors.split_at(rows.len().min(self.factors.len()));
        for (row, factors) in rows.iter().zip(present) {
            let row: [f64; W] = part(row, self.lane);
            let mut product = [0.0; W];
            for l in 0..W {
                product[l] = by[l] * row[l];
            }
            for r in 0..R {
                for l in 0..W {
                    self.sums[r][l] += factors[r] * product[l];
                }
            }
        }
        self.factors = rest;
    }

    /// Writes the sums to the rows of the group.
    #[inline(always)]
    fn write(&self, rows: &mut [Row; R]) {
        // Everything by constant indices, or the sums would not stay in registers.
        for r in 0..R {
            for l in 0..W {
                rows[r].0[self.lane + l] = self.sums[r][l];
            }
        }
    }
}

/// What the loads are made of: y and tan(phi) with their signs turned, the even amplitudes and the odd ones.
#[derive(Clone, Copy)]
pub(super) struct Amplitudes<'a> {
    pub minus_y: &'a Row,
    pub minus_tilt: &'a Row,
    pub even: &'a [Row],
    pub odd: &'a [Row],
}

/// Loads of one kind.
trait Loads {
    /// Those of a group, of `R` loads, in `W` lanes from `lane` on.
    fn find<const R: usize, const W: usize>(&self, group: &Group, rows: &mut [Row; R], lane: usize);
}

/// The loads on even modes, or on odd ones: the shapes times a row, and a sum over the amplitudes.
struct Linear<'a> {
    shapes: &'a [f64],
    by_shape: &'a Row,
    amplitudes: &'a [Row],
}

impl Loads for Linear<'_> {
    #[inline(always)]
    fn find<const R: usize, const W: usize>(&self, group: &Group, rows: &mut [Row; R], lane: usize) {
        let by_shape = part::<W>(self.by_shape, lane);
        let mut sums = Sums::<R, W>::new(group, lane);
        let Some(shapes) = self.shapes[group.first..].first_chunk::<R>() else { return };
        for r in 0..R {
            for l in 0..W {
                sums.sums[r][l] = by_shape[l] * shapes[r];
            }
        }
        sums.add(self.amplitudes);
        sums.write(rows);
    }
}

/// The follower loads on even modes.
struct EvenFollower<'a>(Amplitudes<'a>);

impl Loads for EvenFollower<'_> {
    #[inline(always)]
    fn find<const R: usize, const W: usize>(&self, group: &Group, rows: &mut [Row; R], lane: usize) {
        let Amplitudes { minus_y, minus_tilt, even, odd } = self.0;
        let mut sums = Sums::<R, W>::new(group, lane);
        for a in even {
            sums.add_products(a, odd);
        }
        sums.add_products(minus_y, odd);
        sums.add_products(minus_tilt, even);
        sums.write(rows);
    }
}

/// The follower loads on odd modes.
struct OddFollower<'a>(Amplitudes<'a>);

impl Loads for OddFollower<'_> {
    #[inline(always)]
    fn find<const R: usize, const W: usize>(&self, group: &Group, rows: &mut [Row; R], lane: usize) {
        let Amplitudes { minus_y, minus_tilt, even, odd } = self.0;
        let mut sums = Sums::<R, W>::new(group, lane);
        for amplitudes in [even, odd] {
            let mut others = amplitudes;
            while let [first, rest @ ..] = others {
                sums.add_products(first, others);
                others = rest;
            }
        }
        sums.add_products(minus_y, even);
        sums.add_products(minus_tilt, odd);
        sums.write(rows);
    }
}

/// Finds the loads of all groups of a kind.
#[inline(always)]
fn find<const W: usize>(loads: &impl Loads, groups: &[Group], rows: &mut [Row], lane: usize) {
    for group in groups {
        let rows = &mut rows[group.first..];
        match group.loads {
            1 => find_group::<1, W>(loads, group, rows, lane),
            2 => find_group::<2, W>(loads, group, rows, lane),
            3 => find_group::<3, W>(loads, group, rows, lane),
            4 => find_group::<4, W>(loads, group, rows, lane),
            _ => find_group::<MOST_AT_ONCE, W>(loads, group, rows, lane),
        }
    }
}

#[inline(always)]
fn find_group<const R: usize, const W: usize>(loads: &impl Loads, group: &Group, rows: &mut [Row], lane: usize) {
    if let Some(rows) = rows.first_chunk_mut::<R>() {
        loads.find::<R, W>(group, rows, lane);
    }
}

/// The loads in all lanes, `W` lanes at a time.
#[inline(always)]
pub(super) fn contact_loads<const W: usize>(tables: &Tables, amplitudes: Amplitudes<'_>, loads: &mut LoadRows) {
    if W == BLOCK {
        loads_of_lanes::<W>(tables, amplitudes, loads, 0);
    } else {
        for lane in (0..BLOCK).step_by(W) {
            loads_of_lanes::<W>(tables, amplitudes, loads, lane);
        }
    }
}

#[inline(always)]
fn loads_of_lanes<const W: usize>(tables: &Tables, amplitudes: Amplitudes<'_>, loads: &mut LoadRows, lane: usize) {
    let (on_even, on_odd) = loads.on_modes.split_at_mut(tables.even);
    let (even_follower, odd_follower) = loads.follower.split_at_mut(tables.even);
    let Amplitudes { minus_y, minus_tilt, even, odd } = amplitudes;
    let linear_even = Linear { shapes: &tables.averages.shape, by_shape: minus_y, amplitudes: even };
    let linear_odd = Linear { shapes: &tables.averages.arc_shape, by_shape: minus_tilt, amplitudes: odd };
    find::<W>(&linear_even, &tables.even_even, on_even, lane);
    find::<W>(&linear_odd, &tables.odd_odd, on_odd, lane);
    find::<W>(&EvenFollower(amplitudes), &tables.even_follower, even_follower, lane);
    find::<W>(&OddFollower(amplitudes), &tables.odd_follower, odd_follower, lane);
}
