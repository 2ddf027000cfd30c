//! All places on a path at which the number of unstable pairs in a band changes.

use std::rc::Rc;

use super::branches::{Branches, Critical, Followed, Images, Place, Target, overlap};
use super::error::Error;
use super::pair::Complex;
use super::region::{RESOLUTION, Region, damping_ratio, magnitude, square_root};
use crate::model::critical_values::{Memory, OnInterval, UnstableValues};

/// How a sweep looks for changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Steps {
    /// Intervals it starts with.
    pub first: usize,
    /// How often an interval may be halved.
    pub halvings: usize,
}

/// Two pairs at the ends of an interval are one if they overlap by this; of 1.
const OVERLAP: f64 = 0.6;

/// The error of a cubic through values and slopes at both ends, as a part of the larger misses of the two tangents.
const CUBIC_ERROR: f64 = 0.1;

/// Points inside an interval at which the cubic is looked at.
const SAMPLES: usize = 32;

/// A place at which the number changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The place.
    pub p: f64,
    /// An estimate of its error.
    pub error: f64,
    /// The pair there.
    pub at: Followed,
    /// What the pair meets there: the threshold, or an end of the band.
    pub target: Target,
    /// How many unstable pairs there are more above it: 1 or -1.
    pub more: i32,
}

/// The number of unstable pairs over an interval of a path.
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
    /// The intervals, in order, with the number of unstable pairs in each, `None` where it is not known.
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
}

impl Sweep {
    /// The values within the limits of the sweep, and their errors, at which there is an unstable pair.
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

    /// The same with eigenvalues in another unit, of which one is `unit` of the new ones.
    #[must_use]
    pub(super) fn with_eigenvalues_times(mut self, unit: f64) -> Self {
        for change in &mut self.changes {
            change.at.pair.eigenvalue *= unit;
            change.at.pair.error *= unit;
            change.at.slope *= unit;
            if let Target::Frequency(frequency) = &mut change.target {
                *frequency *= unit;
            }
        }
        self
    }
}

/// All pairs at one place.
struct Node<'a> {
    p: f64,
    place: Box<dyn Place + 'a>,
    pairs: Vec<Followed>,
}

/// An interval between two places: which pairs are the same at both, and which are at one of them alone.
struct Interval<'a> {
    ends: [&'a Node<'a>; 2],
    branches: Vec<Branch<'a>>,
    alone: Vec<&'a Followed>,
}

/// The places of a sweep that are still needed.
struct Nodes<'a> {
    branches: &'a dyn Branches,
    region: &'a Region,
    known: Vec<Rc<Node<'a>>>,
}

/// A pair of an interval's lower end and the same at its upper end.
struct Branch<'a> {
    from: &'a Followed,
    to: &'a Followed,
}

impl dyn Branches + '_ {
    /// All places between `low` and `high` at which the number of unstable pairs of a region changes.
    ///
    /// At both ends of an interval all pairs of the band are found; pairs are joined by the overlap of their left and right
    /// vectors; a cubic through damping ratio, frequency and their slopes says whether a pair meets the threshold or an end of
    /// the band inside. Where pairs cannot be joined, where the cubic comes near without meeting, or where the changes do not
    /// add up to the numbers at the ends, the interval is halved; also where two pairs come near each other and what couples
    /// them may make one unstable or stable in between. Critical values are then found by Newton's method on the matrices. A pair that
    /// becomes unstable and stable again between two places, with no sign of it there in slopes and couplings, would be
    /// missed.
    ///
    /// # Errors
    /// [`Error::Request`] for an empty interval, and as [`Place::pairs`].
    pub fn sweep(&self, region: &Region, within: [f64; 2], steps: Steps) -> Result<Sweep, Error> {
        let mut nodes = Nodes::new(self, region);
        let intervals = settled(within, steps, |interval, may_halve| nodes.settle(interval, may_halve))?;
        let mut sweep = Sweep { at_start: 0, changes: Vec::new(), unresolved: Vec::new() };
        sweep.at_start = intervals.first().map_or(0, |first| first.at_start);
        for interval in intervals {
            sweep.changes.extend(interval.changes);
            sweep.unresolved.extend(interval.unresolved);
        }
        sweep.changes.sort_by(|a, b| a.p.total_cmp(&b.p));
        Ok(sweep)
    }

    /// The values within limits at which there is an unstable pair, by the same sweep, whose intervals `memory` may know; `None`
    /// if that ends it or pairs are not found.
    pub fn unstable_values(
        &self,
        region: &Region,
        within: [f64; 2],
        steps: Steps,
        memory: &dyn Memory,
    ) -> Option<UnstableValues> {
        let mut nodes = Nodes::new(self, region);
        let intervals = settled(within, steps, |interval, may_halve| {
            let mut find = || nodes.unstable(interval, may_halve).ok();
            memory.next(interval, &mut find).ok_or(Error::Request("a search to go on"))
        });
        Some(intervals.ok()?.iter().fold(UnstableValues::default(), UnstableValues::or))
    }

    /// The changes inside an interval, or nothing if it is too long to say.
    fn changes(&self, region: &Region, interval: &Interval<'_>) -> Result<Option<Vec<Change>>, Error> {
        let Interval { ends: [from, to], branches, alone } = interval;
        let step = to.p - from.p;
        if alone.iter().any(|pair| may_count(region, pair, step)) {
            return Ok(None);
        }
        let targets = targets(region);
        let mut changes = Vec::new();
        let (mut unchanged, mut changed) = (Vec::new(), Vec::new());
        for branch in branches {
            if !may_count(region, branch.from, step) && !may_count(region, branch.to, step) {
                continue;
            }
            let before = changes.len();
            for &target in &targets {
                match branch.meets(target, step) {
                    Some(None) => {}
                    Some(Some(near)) => {
                        let Some(change) = self.change(region, branch, target, near)? else { return Ok(None) };
                        changes.extend(change);
                    }
                    None => return Ok(None),
                }
            }
            (if changes.len() == before { &mut unchanged } else { &mut changed }).push(branch);
        }
        if unchanged.into_iter().any(|branch| interval.may_couple(region, branch, &changed)) {
            return Ok(None);
        }
        let more: i32 = changes.iter().map(|change| change.more).sum();
        let adds_up = signed(count(region, from)) + more == signed(count(region, to));
        Ok(adds_up.then_some(changes))
    }

    /// The critical value at which a branch meets a target, as a change if it is one; nothing if it was not found.
    fn change(
        &self,
        region: &Region,
        branch: &Branch<'_>,
        target: Target,
        near: f64,
    ) -> Result<Option<Option<Change>>, Error> {
        let interval = [branch.from.p, branch.to.p];
        let is_first = near - interval[0] < interval[1] - near;
        let start = if is_first { branch.from } else { branch.to };
        let there = self.follow(start, near);
        let critical = match there.and_then(|start| self.critical(target, &start, interval)) {
            Ok(critical) => critical,
            Err(Error::NotConverged { .. }) => return Ok(None),
            Err(error) => return Err(error),
        };
        let Critical { at, error } = critical;
        if !error.is_finite() {
            return Ok(None);
        }
        let (_, slope) = target.distance(&at);
        let (is_change, is_more, shift) = match target {
            // The threshold itself, by the tangent: samples count as unstable a little below it.
            Target::DampingRatio(_) => (region.has_frequency_of(at.pair.eigenvalue), slope < 0.0, RESOLUTION / slope),
            Target::Frequency(end) => {
                let enters = if end == region.lowest { slope > 0.0 } else { slope < 0.0 };
                (is_unstable(region, &at), enters, 0.0)
            }
        };
        let p = (at.p + shift).clamp(interval[0], interval[1]);
        Ok(Some(is_change.then_some(Change { p, error, at, target, more: if is_more { 1 } else { -1 } })))
    }
}

impl<'a> Interval<'a> {
    fn new(ends: [&'a Node<'a>; 2]) -> Self {
        let [from, to] = ends;
        let mut free: Vec<(&Followed, Images)> =
            to.pairs.iter().map(|pair| (pair, to.place.images(&pair.pair))).collect();
        let (mut branches, mut alone) = (Vec::new(), Vec::new());
        for pair in &from.pairs {
            let images = to.place.images(&pair.pair);
            let share = |(other, its): &(&Followed, Images)| overlap((&pair.pair, &images), (&other.pair, its));
            let shares = free.iter().map(share).enumerate();
            match shares.map(|(index, share)| (share, index)).max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((share, index)) if (OVERLAP..1.0 / OVERLAP).contains(&share) => {
                    branches.push(Branch { from: pair, to: free.swap_remove(index).0 });
                }
                _ => alone.push(pair),
            }
        }
        alone.extend(free.into_iter().map(|(pair, _)| pair));
        Self { ends, branches, alone }
    }

    /// Whether a pair is so near a target at both ends that its error says no more of what lies between.
    fn is_within_errors(&self, region: &Region) -> bool {
        let step = self.ends[1].p - self.ends[0].p;
        let is_near = |end: &Followed, target: Target| {
            let counts = match target {
                Target::DampingRatio(_) => region.has_frequency_of(end.pair.eigenvalue),
                Target::Frequency(_) => is_unstable(region, end),
            };
            counts && target.distance(end).0.abs() <= 2.0 * target.error(&end.pair)
        };
        self.branches.iter().filter(|branch| may_count(region, branch.from, step)).any(|branch| {
            targets(region).into_iter().any(|target| [branch.from, branch.to].iter().all(|end| is_near(end, target)))
        })
    }

    /// Whether one of the pairs is unstable all along.
    fn is_unstable_throughout(&self, region: &Region) -> bool {
        let step = self.ends[1].p - self.ends[0].p;
        self.branches.iter().any(|branch| {
            [branch.from, branch.to].iter().all(|end| region.contains(end.pair.eigenvalue))
                && targets(region).into_iter().all(|target| branch.meets(target, step) == Some(None))
                && !self.may_couple(region, branch, &[])
        })
    }

    /// Whether what couples a pair with another inside, other than with these, may make one of them unstable or stable.
    fn may_couple(&self, region: &Region, branch: &Branch<'_>, but: &[&Branch<'_>]) -> bool {
        let [from, to] = self.ends;
        let step = to.p - from.p;
        let is = |other: &Branch<'_>, one: &Branch<'_>| std::ptr::eq(other.from, one.from);
        let others = self.branches.iter().filter(|other| !is(other, branch) && !but.iter().any(|one| is(other, one)));
        others.into_iter().any(|other| {
            may_couple(region, &*from.place, [branch.from, other.from], step)
                || may_couple(region, &*to.place, [branch.to, other.to], -step)
        })
    }
}

impl<'a> Nodes<'a> {
    fn new(branches: &'a dyn Branches, region: &'a Region) -> Self {
        Self { branches, region, known: Vec::new() }
    }

    /// The sweep of an interval; nothing if it is to be halved. No later interval begins below this one.
    fn settle(&mut self, ends: [f64; 2], may_halve: bool) -> Result<Option<Sweep>, Error> {
        let [from, to] = self.ends(ends)?;
        self.settle_joined(&Interval::new([&from, &to]), may_halve)
    }

    /// The unstable values of such an interval: all of them where one pair is unstable all along, whatever the others do.
    fn unstable(&mut self, ends: [f64; 2], may_halve: bool) -> Result<OnInterval, Error> {
        let [from, to] = self.ends(ends)?;
        let interval = Interval::new([&from, &to]);
        if interval.is_unstable_throughout(self.region) {
            return Ok(Some(UnstableValues { surely: vec![ends], possibly: vec![ends] }));
        }
        Ok(self.settle_joined(&interval, may_halve)?.map(|sweep| sweep.unstable(ends)))
    }

    fn settle_joined(&self, interval: &Interval<'_>, may_halve: bool) -> Result<Option<Sweep>, Error> {
        let [from, to] = interval.ends;
        let counts = interval.ends.map(|node| count(self.region, node));
        let (changes, unresolved) = match self.branches.changes(self.region, interval)? {
            Some(changes) => (changes, Vec::new()),
            None if may_halve && !interval.is_within_errors(self.region) => return Ok(None),
            None => (Vec::new(), vec![([from.p, to.p], signed(counts[1]) - signed(counts[0]))]),
        };
        Ok(Some(Sweep { at_start: counts[0], changes, unresolved }))
    }

    /// The nodes at both ends of an interval. Those below it are needed no more.
    fn ends(&mut self, [low, high]: [f64; 2]) -> Result<[Rc<Node<'a>>; 2], Error> {
        self.known.retain(|node| node.p >= low);
        Ok([self.node(low)?, self.node(high)?])
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

/// What is found on the intervals between two ends, which are halved where `settle` finds nothing. It is also told whether
/// they may be, and finds something where not.
fn settled<T>(
    [low, high]: [f64; 2],
    steps: Steps,
    mut settle: impl FnMut([f64; 2], bool) -> Result<Option<T>, Error>,
) -> Result<Vec<T>, Error> {
    let is_interval = low.is_finite() && high.is_finite() && high > low;
    if !is_interval {
        return Err(Error::Request("a sweep goes from one value to a larger one"));
    }
    // Intervals that are left, the next one last: where each ends, how often it was halved.
    let place = |index: usize| low + (high - low) * index as f64 / steps.first as f64;
    let mut ends: Vec<(f64, usize)> =
        (1..=steps.first).rev().map(|index| (if index == steps.first { high } else { place(index) }, 0)).collect();
    let mut settled = Vec::new();
    let mut here = low;
    while let Some((end, halvings)) = ends.pop() {
        let middle = 0.5 * (here + end);
        let may_halve = halvings < steps.halvings && middle > here && middle < end;
        match settle([here, end], may_halve)? {
            Some(found) => {
                settled.push(found);
                here = end;
            }
            None if may_halve => ends.extend([(end, halvings + 1), (middle, halvings + 1)]),
            None => return Err(Error::Request("an interval that cannot be halved")),
        }
    }
    Ok(settled)
}

/// What pairs meet where they begin or end to count.
fn targets(region: &Region) -> Vec<Target> {
    let ends = [region.lowest, region.highest].into_iter().filter(|end| *end > 0.0 && end.is_finite());
    ends.map(Target::Frequency).chain([Target::DampingRatio(region.damping_ratio - RESOLUTION)]).collect()
}

/// Whether a pair has a damping ratio below the threshold, whatever its frequency.
fn is_unstable(region: &Region, followed: &Followed) -> bool {
    damping_ratio(followed.pair.eigenvalue) < region.damping_ratio - RESOLUTION
}

/// Whether a pair may count within a step from where it is.
fn may_count(region: &Region, followed: &Followed, step: f64) -> bool {
    let size = magnitude(followed.pair.eigenvalue);
    let change = 2.0 * magnitude(followed.slope * step);
    let (reach, drift) = if followed.pair.eigenvalue.im == 0.0 {
        // Two real ones that meet become a pair, whose frequency and damping ratio rise from there as a square root.
        (2.0 * change / size, change + size)
    } else {
        (2.0 * (step * followed.damping_ratio_slope()).abs(), 2.0 * (step * followed.slope.im).abs())
    };
    let (reach, drift) = (reach + 1e-3, drift + 1e-3 * region.highest);
    let frequency = followed.pair.eigenvalue.im;
    let is_known = reach.is_finite() && drift.is_finite();
    !is_known
        || followed.pair.damping_ratio() - reach < region.damping_ratio
            && frequency > region.lowest - drift
            && frequency < region.highest + drift
}

/// Whether two pairs that come near each other within a step may couple so that one becomes unstable or stable: by the problem
/// of these two alone, to first order in the step.
fn may_couple(region: &Region, place: &dyn Place, [a, b]: [&Followed; 2], step: f64) -> bool {
    let distance = a.pair.eigenvalue.im - b.pair.eigenvalue.im;
    if distance.abs() > 2.0 * (step * (a.slope.im - b.slope.im)).abs() {
        return false;
    }
    let product = place.coupling(&a.pair, &b.pair) * place.coupling(&b.pair, &a.pair);
    // Where they are nearest, if that is within the step.
    let (between, turn) = (a.pair.eigenvalue - b.pair.eigenvalue, a.slope - b.slope);
    let nearest = -(between.re * turn.re + between.im * turn.im) / turn.norm_sqr();
    let change = if nearest / step > 0.0 && nearest / step < 1.0 { nearest } else { step };
    let [first, second] = [a, b].map(|followed| followed.pair.eigenvalue + followed.slope * change);
    let (mean, half) = ((first + second) * 0.5, (first - second) * 0.5);
    let root = square_root(half * half + product * (change * change));
    let rising = |pair: [Complex; 2]| {
        let [a, b] = pair.map(damping_ratio);
        [a.min(b), a.max(b)]
    };
    let (alone, coupled) = (rising([first, second]), rising([mean + root, mean - root]));
    // What the coupling does, counted twice for what the first order leaves out.
    let beyond = [2.0 * coupled[0] - alone[0], 2.0 * coupled[1] - alone[1]];
    let unstable = |ratios: [f64; 2]| ratios.map(|ratio| ratio < region.damping_ratio - RESOLUTION).map(u8::from);
    let now = unstable(rising([a.pair.eigenvalue, b.pair.eigenvalue]));
    !root.is_finite() || unstable(alone) != now || unstable(beyond) != now
}

impl Branch<'_> {
    /// Where a cubic meets a target: once at a place, not at all, or, as the outer nothing, not to be said.
    fn meets(&self, target: Target, step: f64) -> Option<Option<f64>> {
        let ((a, slope_a), (b, slope_b)) = (target.distance(self.from), target.distance(self.to));
        let (slope_a, slope_b) = (slope_a * step, slope_b * step);
        let miss = (a + slope_a - b).abs().max((b - slope_b - a).abs());
        let error = CUBIC_ERROR * miss + target.error(&self.from.pair).max(target.error(&self.to.pair));
        let cubic = |t: f64| {
            let u = 1.0 - t;
            u * u * ((1.0 + 2.0 * t) * a + t * slope_a) + t * t * ((1.0 + 2.0 * u) * b - u * slope_b)
        };
        let values: Vec<f64> = (0..=SAMPLES).map(|index| cubic(index as f64 / SAMPLES as f64)).collect();
        let crossings: Vec<usize> =
            (0..SAMPLES).filter(|&index| (values[index] > 0.0) != (values[index + 1] > 0.0)).collect();
        let is_clear = |value: f64| value.abs() > error;
        match crossings[..] {
            [] => values.iter().all(|value| is_clear(*value)).then_some(None),
            [index] if is_clear(a) && is_clear(b) => {
                let share = values[index] / (values[index] - values[index + 1]);
                Some(Some(self.from.p + step * (index as f64 + share) / SAMPLES as f64))
            }
            _ => None,
        }
    }
}

fn count(region: &Region, node: &Node<'_>) -> usize {
    node.pairs.iter().filter(|followed| region.contains(followed.pair.eigenvalue)).count()
}

fn signed(count: usize) -> i32 {
    i32::try_from(count).unwrap_or(i32::MAX)
}
