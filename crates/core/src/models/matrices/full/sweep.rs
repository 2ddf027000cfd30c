//! All places on a path at which the number of unstable pairs in a band changes.

use super::band::{Band, KrylovLimit};
use super::error::Error;
use super::follow::{Along, Critical, Followed, Target, overlap};

/// Intervals a sweep starts with.
const FIRST: usize = 4;

/// How often an interval may be halved.
const HALVINGS: usize = 10;

/// The part of the band's ends by which the search reaches beyond them.
const MARGIN: f64 = 0.02;

/// How far below the threshold damping ratios are looked for.
const FASTEST: f64 = 0.3;

/// Two pairs at the ends of an interval are one if they overlap by this; of 1.
const OVERLAP: f64 = 0.6;

/// The error of a cubic through values and slopes at both ends, as a part of the larger misses of the two tangents.
const CUBIC_ERROR: f64 = 0.1;

/// Points inside an interval at which the cubic is looked at.
const SAMPLES: usize = 32;

/// Which pairs count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question {
    /// Lowest angular frequency in rad/s.
    pub low: f64,
    /// Highest angular frequency in rad/s.
    pub high: f64,
    /// A pair of a damping ratio below this is unstable.
    pub threshold: f64,
}

impl Question {
    /// Whether a pair is unstable and in the band.
    #[must_use]
    pub fn counts(&self, followed: &Followed) -> bool {
        (self.low..=self.high).contains(&followed.pair.eigenvalue.im) && followed.pair.damping_ratio() < self.threshold
    }
}

/// A place at which the number changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The place and the pair there.
    pub critical: Critical,
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
    /// At how many places all pairs of the band were found.
    pub places: usize,
}

impl Sweep {
    /// The intervals, in order, with the number of unstable pairs in each, `None` where it is not known.
    #[must_use]
    pub fn intervals(&self, low: f64, high: f64) -> Vec<([f64; 2], Option<usize>)> {
        let mut events: Vec<([f64; 2], i32)> =
            self.changes.iter().map(|change| ([change.critical.at.p; 2], change.more)).collect();
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

/// All pairs at one place.
struct Node {
    p: f64,
    pairs: Vec<Followed>,
}

/// A pair of an interval's lower end and the same at its upper end.
struct Branch<'a> {
    from: &'a Followed,
    to: &'a Followed,
}

impl Along<'_> {
    /// All places between `low` and `high` at which the number of unstable pairs of a band changes.
    ///
    /// At both ends of an interval all pairs of the band are found; pairs are joined by the overlap of their left and right
    /// vectors; a cubic through damping ratio, frequency and their slopes says whether a pair meets the threshold or an end of
    /// the band inside. Where pairs cannot be joined, where the cubic comes near without meeting, or where the changes do not
    /// add up to the numbers at the ends, the interval is halved. Critical values are then found by Newton's method on the full
    /// matrices. A pair that becomes unstable and stable again between two places, with no sign of it in its slopes there,
    /// would be missed.
    ///
    /// # Errors
    /// [`Error::Request`] for an empty interval, and as [`Point::pairs_in`](super::quadratic::Point::pairs_in).
    pub fn sweep(&self, question: Question, [low, high]: [f64; 2], limit: KrylovLimit) -> Result<Sweep, Error> {
        let is_interval = low.is_finite() && high.is_finite() && high > low;
        if !is_interval {
            return Err(Error::Request("a sweep goes from one value to a larger one"));
        }
        let first = self.node(question, low, limit)?;
        let mut sweep =
            Sweep { at_start: count(question, &first), changes: Vec::new(), unresolved: Vec::new(), places: 1 };
        // Intervals that are left, the next one last: where each ends, how often it was halved.
        let mut ends: Vec<(f64, usize)> = (1..=FIRST)
            .rev()
            .map(|index| (if index == FIRST { high } else { low + (high - low) * index as f64 / FIRST as f64 }, 0))
            .collect();
        let mut here = first;
        let mut known: Vec<Node> = Vec::new();
        while let Some((end, halvings)) = ends.pop() {
            let there = match known.pop() {
                Some(node) if node.p == end => node,
                other => {
                    known.extend(other);
                    sweep.places += 1;
                    self.node(question, end, limit)?
                }
            };
            if let Some(changes) = self.changes(question, &here, &there)? {
                sweep.changes.extend(changes);
                here = there;
            } else if halvings < HALVINGS {
                ends.push((end, halvings + 1));
                ends.push((0.5 * (here.p + end), halvings + 1));
                known.push(there);
            } else {
                let more = signed(count(question, &there)) - signed(count(question, &here));
                sweep.unresolved.push(([here.p, there.p], more));
                here = there;
            }
        }
        sweep.changes.sort_by(|a, b| a.critical.at.p.total_cmp(&b.critical.at.p));
        Ok(sweep)
    }

    fn node(&self, question: Question, p: f64, limit: KrylovLimit) -> Result<Node, Error> {
        let band = Band {
            low: question.low * (1.0 - MARGIN),
            high: question.high * (1.0 + MARGIN),
            least_damping: (question.threshold - FASTEST).max(-0.9),
            most_damping: (question.threshold + 0.05).max(0.05),
        };
        let pairs = self.point(p)?.pairs_in(band, limit)?;
        let pairs = pairs.into_iter().map(|pair| self.with_slope(p, pair)).collect::<Result<_, _>>()?;
        Ok(Node { p, pairs })
    }

    /// The changes inside an interval, or nothing if it is too long to say.
    fn changes(&self, question: Question, from: &Node, to: &Node) -> Result<Option<Vec<Change>>, Error> {
        let step = to.p - from.p;
        let point = self.point(to.p)?;
        let mut free: Vec<&Followed> = to.pairs.iter().collect();
        let mut branches = Vec::new();
        for pair in &from.pairs {
            let best = free.iter().enumerate().map(|(index, other)| (overlap(&point, &pair.pair, &other.pair), index));
            match best.max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((share, index)) if (OVERLAP..1.0 / OVERLAP).contains(&share) => {
                    branches.push(Branch { from: pair, to: free.swap_remove(index) });
                }
                _ if question.may_count(pair, step) => return Ok(None),
                _ => {}
            }
        }
        if free.iter().any(|pair| question.may_count(pair, step)) {
            return Ok(None);
        }
        let mut changes = Vec::new();
        for branch in &branches {
            let targets = [
                Target::DampingRatio(question.threshold),
                Target::Frequency(question.low),
                Target::Frequency(question.high),
            ];
            if !question.may_count(branch.from, step) && !question.may_count(branch.to, step) {
                continue;
            }
            for target in targets {
                match branch.meets(target, step) {
                    Some(None) => {}
                    Some(Some(near)) => {
                        let Some(change) = self.change(question, branch, target, near)? else { return Ok(None) };
                        changes.extend(change);
                    }
                    None => return Ok(None),
                }
            }
        }
        let more: i32 = changes.iter().map(|change| change.more).sum();
        let adds_up = signed(count(question, from)) + more == signed(count(question, to));
        Ok(adds_up.then_some(changes))
    }

    /// The critical value at which a branch meets a target, as a change if it is one; nothing if it was not found.
    fn change(
        &self,
        question: Question,
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
        let eigenvalue = critical.at.pair.eigenvalue;
        let (_, slope) = target.distance(&critical.at);
        let (is_change, is_more) = match target {
            Target::DampingRatio(_) => ((question.low..=question.high).contains(&eigenvalue.im), slope < 0.0),
            Target::Frequency(end) => {
                let enters = if end == question.low { slope > 0.0 } else { slope < 0.0 };
                (critical.at.pair.damping_ratio() < question.threshold, enters)
            }
        };
        let more = if is_more { 1 } else { -1 };
        Ok(Some(is_change.then_some(Change { critical, target, more })))
    }
}

impl Question {
    /// Whether a pair may count within a step from where it is.
    fn may_count(&self, followed: &Followed, step: f64) -> bool {
        let reach = 2.0 * (step * followed.damping_ratio_slope()).abs() + 1e-3;
        let drift = 2.0 * (step * followed.slope.im).abs() + 1e-3 * self.high;
        let frequency = followed.pair.eigenvalue.im;
        followed.pair.damping_ratio() - reach < self.threshold
            && frequency > self.low - drift
            && frequency < self.high + drift
    }
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

fn count(question: Question, node: &Node) -> usize {
    node.pairs.iter().filter(|pair| question.counts(pair)).count()
}

fn signed(count: usize) -> i32 {
    i32::try_from(count).unwrap_or(i32::MAX)
}
