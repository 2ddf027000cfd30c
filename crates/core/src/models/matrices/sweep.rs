//! All places on a path at which the number of unstable eigenvalues in a band changes.

use std::collections::VecDeque;
use std::rc::Rc;

use super::branches::{Branches, Followed};
use super::error::Error;
use super::interval::{Change, Interval, Known, Node};
use super::region::Region;
use crate::model::critical_values::{Memory, OnInterval, UnstableValues};

/// How a sweep looks for changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Steps {
    /// Of so many intervals between the places it is given it makes one to begin with.
    pub joined: usize,
    /// How often an interval may be halved.
    pub halvings: usize,
    /// How many intervals it looks at, at most, within one that it begins with.
    pub most: usize,
    /// Whether wider intervals come before narrower ones, so that those that are left when there are enough are narrow; else they come
    /// in the order of p.
    pub widest_first: bool,
}

/// The number of unstable eigenvalues over an interval of a path, both of a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// How many there are at the lower end.
    pub at_start: usize,
    /// Where the number changes, in order of p.
    pub changes: Vec<Change>,
    /// Intervals in which the number could not be followed, with how much it changes over them.
    pub unresolved: Vec<([f64; 2], i32)>,
}

impl Sweep {
    /// The intervals, in order, with the number of unstable eigenvalues in each, `None` where it is not known.
    #[must_use]
    pub fn intervals(&self, low: f64, high: f64) -> Vec<([f64; 2], Option<usize>)> {
        let mut events: Vec<([f64; 2], i32)> = self.changes.iter().map(|change| ([change.p; 2], change.more)).collect();
        events.extend(&self.unresolved);
        events.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        let mut intervals = Vec::new();
        let mut from = low;
        let mut count = self.at_start;
        for (place, more) in events {
            intervals.push(([from, place[0]], Some(count)));
            if place[1] > place[0] {
                intervals.push((place, None));
            }
            count = count.saturating_add_signed(isize::try_from(more).unwrap_or(0));
            from = place[1];
        }
        intervals.push(([from, high], Some(count)));
        intervals
    }

    /// The values within the limits of the sweep, and their errors, at which there is an unstable eigenvalue.
    #[must_use]
    pub fn unstable(&self, [low, high]: [f64; 2]) -> UnstableValues {
        let mut unstable = UnstableValues::default();
        let error =
            |at: f64| self.changes.iter().filter(|change| change.p == at).map(|change| change.error).sum::<f64>();
        for ([from, to], count) in self.intervals(low, high) {
            if count == Some(0) {
                continue;
            }
            let by = [error(from), error(to)];
            unstable.possibly.push([from - by[0], to + by[1]]);
            if count.is_some() && from + by[0] < to - by[1] {
                unstable.surely.push([from + by[0], to - by[1]]);
            }
        }
        UnstableValues::default().or(&unstable)
    }
}

/// What tells of an interval of a path what is unstable there.
pub trait Intervals {
    /// The unstable values of an interval, all of them where one pair is unstable all along, whatever the others do; nothing if it
    /// is to be halved. No later interval begins below this one, if these come in the order of p.
    ///
    /// # Errors
    /// [`Error`], if eigenvalues are not found.
    fn unstable(&mut self, ends: [f64; 2], may_halve: bool) -> Result<OnInterval, Error>;
}

impl dyn Intervals + '_ {
    /// The values at which there is an unstable eigenvalue, between the first and the last of some places in rising order.
    /// Intervals of which too little is known are halved; `memory` may know them. `None` if that ends the search or pairs are
    /// not found. What is not known when the work ends is possibly unstable.
    pub fn unstable_values(&mut self, places: &[f64], steps: Steps, memory: &dyn Memory) -> Option<UnstableValues> {
        let intervals = settled(places, steps, |interval, may_halve| {
            let mut find = || self.unstable(interval, may_halve).ok();
            memory.next(interval, &mut find).ok_or(Error::Request("a search to go on"))
        });
        Some(intervals.ok()?.iter().fold(UnstableValues::default(), UnstableValues::or))
    }
}

/// Intervals by what is found at three places.
///
/// At both ends of an interval and in its middle all pairs and real eigenvalues are found. Nothing is left out for where it
/// seems to go: what does not count is so far from the edge of the region at all three places that it cannot reach it.
/// Critical values are then found by Newton's method on the matrices.
pub(super) struct Nodes<'a> {
    branches: &'a dyn Branches,
    region: &'a Region,
    /// The places that are still needed.
    known: Vec<Rc<Node<'a>>>,
}

impl<'a> Nodes<'a> {
    pub(super) fn new(branches: &'a dyn Branches, region: &'a Region) -> Self {
        Self { branches, region, known: Vec::new() }
    }

    /// All places at which the number of unstable eigenvalues changes, between the first and the last of some places in rising
    /// order. Intervals of which too little is known are halved. What is not known when the work ends is unresolved.
    ///
    /// # Errors
    /// [`Error::Request`] for places that do not rise, and if pairs are not found.
    #[cfg(test)]
    pub(super) fn sweep(&mut self, places: &[f64], steps: Steps) -> Result<Sweep, Error> {
        let intervals = settled(places, steps, |interval, may_halve| self.settle(interval, may_halve))?;
        let mut sweep = Sweep { at_start: 0, changes: Vec::new(), unresolved: Vec::new() };
        sweep.at_start = intervals.first().map_or(0, |first| first.at_start);
        for interval in intervals {
            sweep.changes.extend(interval.changes);
            sweep.unresolved.extend(interval.unresolved);
        }
        sweep.changes.sort_by(|a, b| a.p.total_cmp(&b.p));
        Ok(sweep)
    }

    #[cfg(test)]
    fn settle(&mut self, ends: [f64; 2], may_halve: bool) -> Result<Option<Sweep>, Error> {
        let nodes = self.of(ends)?;
        let interval = Interval::new(nodes.each_ref().map(|node| &**node), self.region);
        let [from, to] = [&nodes[0], &nodes[2]].map(|node| node.count(self.region));
        let (changes, unresolved) = match interval.known(self.branches, true)? {
            Known::Changes(changes) => (changes, Vec::new()),
            Known::Nothing if may_halve => return Ok(None),
            _ => (Vec::new(), vec![(ends, to - from)]),
        };
        Ok(Some(Sweep { at_start: usize::try_from(from).unwrap_or(0), changes, unresolved }))
    }
}

impl Intervals for Nodes<'_> {
    fn unstable(&mut self, ends: [f64; 2], may_halve: bool) -> Result<OnInterval, Error> {
        let nodes = self.of(ends)?;
        let interval = Interval::new(nodes.each_ref().map(|node| &**node), self.region);
        Ok(match interval.known(self.branches, false)? {
            Known::Unstable => Some(UnstableValues { surely: vec![ends], possibly: vec![ends] }),
            Known::Changes(changes) => {
                let at_start = usize::try_from(nodes[0].count(self.region)).unwrap_or(0);
                Some(Sweep { at_start, changes, unresolved: Vec::new() }.unstable(ends))
            }
            Known::Nothing if may_halve => None,
            _ => Some(UnstableValues { surely: Vec::new(), possibly: vec![ends] }),
        })
    }
}

impl<'a> Nodes<'a> {
    /// The nodes at both ends of an interval and in its middle. Those below it are needed no more.
    fn of(&mut self, [low, high]: [f64; 2]) -> Result<[Rc<Node<'a>>; 3], Error> {
        self.known.retain(|node| node.p >= low);
        Ok([self.node(low)?, self.node(middle(low, high))?, self.node(high)?])
    }

    fn node(&mut self, p: f64) -> Result<Rc<Node<'a>>, Error> {
        if let Some(node) = self.known.iter().find(|node| node.p == p) {
            return Ok(node.clone());
        }
        let place = self.branches.at(p)?;
        let pairs = place.pairs(self.region)?.into_iter().map(|pair| Followed::new(p, pair, &*place)).collect();
        let node = Rc::new(Node { p, place, pairs });
        self.known.push(node.clone());
        Ok(node)
    }
}

pub(super) fn middle(low: f64, high: f64) -> f64 {
    low + 0.5 * (high - low)
}

/// What is found on the intervals between places, which are halved where `settle` finds nothing. It is also told whether
/// they may be, and finds something where not.
fn settled<T>(
    places: &[f64],
    steps: Steps,
    mut settle: impl FnMut([f64; 2], bool) -> Result<Option<T>, Error>,
) -> Result<Vec<T>, Error> {
    let rise = places.windows(2).all(|two| two[0] < two[1]) && places.iter().all(|place| place.is_finite());
    let [Some(first), Some(last)] = [places.first(), places.last()] else { return Err(NO_INTERVAL) };
    if !rise || first == last {
        return Err(NO_INTERVAL);
    }
    let ends: Vec<f64> = places[1..].chunks(steps.joined.max(1)).filter_map(|joined| joined.last().copied()).collect();
    let mut settled = Vec::new();
    let mut here = *first;
    for end in ends {
        // Intervals that are left, with how often they were halved.
        let mut left = VecDeque::from([([here, end], 0)]);
        here = end;
        let mut looked_at = 0;
        while let Some((interval, halvings)) = if steps.widest_first { left.pop_front() } else { left.pop_back() } {
            let [from, to] = interval;
            looked_at += 1;
            let middle = middle(from, to);
            // Narrower ones have no three places that rounding tells apart.
            let is_wide = to - from > 16.0 * f64::EPSILON * from.abs().max(to.abs());
            let may_halve = halvings < steps.halvings && is_wide && looked_at + left.len() < steps.most;
            match settle(interval, may_halve)? {
                Some(found) => settled.push(found),
                None if may_halve => left.extend([([middle, to], halvings + 1), ([from, middle], halvings + 1)]),
                None => return Err(Error::Request("an interval that cannot be halved")),
            }
        }
    }
    Ok(settled)
}

const NO_INTERVAL: Error = Error::Request("a sweep goes from one value to a larger one");

#[cfg(test)]
mod tests;
