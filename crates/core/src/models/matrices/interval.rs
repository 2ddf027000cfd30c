//! What the eigenvalues at three places say of the interval between them.

use super::branches::{Branches, Critical, Followed, Images, Place, Target, overlap};
use super::error::Error;
use super::pair::Complex;
use super::region::{RESOLUTION, Region, damping_ratio, magnitude};

/// Two pairs at neighbouring places are one if they overlap by this; of 1.
const OVERLAP: f64 = 0.6;

/// So many of the nearest pairs are compared by their vectors.
const COMPARED: usize = 6;

/// Pairs that do not come nearer to each other than this part of their way towards each other are followed apart.
const APART: f64 = 1.0 / 3.0;

/// How much of the distance of two pairs a pair may be off from what was interpolated.
const AGREES: f64 = 0.1;

/// Eigenvalues that differ by less, of 1, are not told apart.
const EQUAL: f64 = 1e-9;

/// What lies between places is at most so many times as far away as the slopes there say.
const REACH: f64 = 2.0;

/// Points of each half at which interpolated eigenvalues are looked at.
const SAMPLES: usize = 16;

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
    /// How many unstable eigenvalues there are more above it: 2 or -2, for a pair, 1 or -1 for a real one.
    pub more: i32,
}

/// All eigenvalues at one place that are not below the real axis.
pub(super) struct Node<'a> {
    pub(super) p: f64,
    pub(super) place: Box<dyn Place + 'a>,
    pub(super) pairs: Vec<Followed>,
}

impl Node<'_> {
    /// How many eigenvalues are unstable, both of a pair.
    pub(super) fn count(&self, region: &Region) -> i32 {
        let unstable = self.pairs.iter().filter(|followed| region.contains(followed.pair.eigenvalue));
        unstable.map(|followed| multiplicity(followed.pair.eigenvalue)).sum()
    }
}

/// An eigenvalue stands for itself, or for itself and its conjugate.
fn multiplicity(eigenvalue: Complex) -> i32 {
    if eigenvalue.im == 0.0 { 1 } else { 2 }
}

/// A pair at the lower end of an interval, in its middle and at its upper end.
struct Track<'a> {
    at: [&'a Followed; 3],
    /// The values of an interpolation at [`SAMPLES`] points of each half, and at the upper end.
    between: Vec<Complex>,
    /// How far the pair in the middle is off from what the ends say of it.
    miss: f64,
}

/// An interval: its ends and its middle, the pairs that are at all three, and those that are not.
pub(super) struct Interval<'a> {
    nodes: [&'a Node<'a>; 3],
    region: &'a Region,
    tracks: Vec<Track<'a>>,
    alone: Vec<(&'a Followed, f64)>,
}

/// What is known of an interval.
pub(super) enum Known {
    /// Where the number of unstable eigenvalues changes.
    Changes(Vec<Change>),
    /// Some pair is unstable all along.
    Unstable,
    /// Too little.
    Nothing,
    /// Too little, for the errors of eigenvalues: halving does not help.
    Errors,
}

impl<'a> Interval<'a> {
    pub(super) fn new(nodes: [&'a Node<'a>; 3], region: &'a Region) -> Self {
        let [from, middle, to] = nodes;
        let [first, second] = [joined(from, middle), joined(middle, to)];
        let (mut tracks, mut alone) = (Vec::new(), Vec::new());
        let mut is_tracked = [from, middle, to].map(|node| vec![false; node.pairs.len()]);
        for (index, in_middle) in first.into_iter().enumerate() {
            let Some((in_middle, at_end)) = in_middle.and_then(|place| Some((place, second[place]?))) else { continue };
            for (tracked, place) in is_tracked.iter_mut().zip([index, in_middle, at_end]) {
                tracked[place] = true;
            }
            tracks.push(Track::new([&from.pairs[index], &middle.pairs[in_middle], &to.pairs[at_end]]));
        }
        let half = 0.5 * (to.p - from.p);
        for (place, tracked) in is_tracked.iter().enumerate() {
            let neighbours = [place.wrapping_sub(1), place + 1].into_iter().filter_map(|place| nodes.get(place));
            for (followed, _) in nodes[place].pairs.iter().zip(tracked).filter(|(_, tracked)| !**tracked) {
                let nearest = |node: &&&Node<'_>| {
                    let distances = node.pairs.iter().map(|other| distance(followed, other));
                    distances.fold(f64::INFINITY, f64::min)
                };
                // An eigenvalue without vectors has no slope: the eigenvalues near by say how far it goes.
                let slope = magnitude(followed.slope) * half;
                let way = if slope.is_finite() {
                    slope
                } else {
                    neighbours.clone().map(|node| nearest(&node)).fold(0.0, f64::max)
                };
                alone.push((followed, way));
            }
        }
        Self { nodes, region, tracks, alone }
    }

    /// Which changes there are inside, by all eigenvalues at the three places.
    ///
    /// A pair counts for nothing where it is so far from the region, or so far inside, that its slopes, and those of the pairs
    /// that it meets, do not reach the edge. All others have to be followed: joined at all three places by their vectors;
    /// apart from all other pairs; in the middle where the ends say; and with interpolated distances to the threshold and to
    /// the ends of the band that pass zero once or stay away from it by more than what the middle was off.
    pub(super) fn known(&self, branches: &dyn Branches, is_all: bool) -> Result<Known, Error> {
        let told: Vec<Option<bool>> = (0..self.tracks.len()).map(|index| self.told(index)).collect();
        if !is_all && (told.contains(&Some(true)) || self.follows_an_unstable_one(&told)) {
            return Ok(Known::Unstable);
        }
        let mut changes = Vec::new();
        for (index, track) in self.tracks.iter().enumerate().filter(|(index, _)| told[*index].is_none()) {
            if track.is_within_errors(self.region) {
                return Ok(Known::Errors);
            }
            if !self.is_followed(index) {
                return Ok(Known::Nothing);
            }
            for target in track.targets(self.region) {
                let Some(crossing) = track.meets(target) else { return Ok(Known::Nothing) };
                let Some(near) = crossing else { continue };
                let Some(change) = self.change(branches, track, target, near)? else { return Ok(Known::Nothing) };
                changes.extend(change);
            }
        }
        let is_told = |&(followed, way): &(&Followed, f64)| {
            let radius = REACH * way + self.way_to_others(followed, way) + followed.pair.error.min(way);
            self.region.sure(followed.pair.eigenvalue, radius).is_some()
        };
        if !self.alone.iter().all(is_told) {
            return Ok(Known::Nothing);
        }
        let [from, middle, to] = self.nodes;
        let adds_up = |from: &Node<'_>, to: &Node<'_>| {
            let inside = changes.iter().filter(|change| from.p <= change.p && change.p < to.p);
            from.count(self.region) + inside.map(|change| change.more).sum::<i32>() == to.count(self.region)
        };
        Ok(if adds_up(from, middle) && adds_up(middle, to) { Known::Changes(changes) } else { Known::Nothing })
    }

    fn half(&self) -> f64 {
        0.5 * (self.nodes[2].p - self.nodes[0].p)
    }

    /// Whether a pair is unstable all along, or nowhere, by its distance from the edge of the region.
    fn told(&self, index: usize) -> Option<bool> {
        let track = &self.tracks[index];
        let way = track.way(self.half());
        let others = self.others(index).filter(|other| !self.are_apart(track, other));
        let others = others.map(|other| other.way(self.half())).fold(0.0, f64::max);
        let alone = track.at.iter().map(|followed| self.way_to_alone(followed, way)).fold(0.0, f64::max);
        let radius = REACH * (way + others + alone);
        let mut told = track.at.iter().map(|followed| {
            let error = if followed.pair.error.is_finite() { followed.pair.error } else { 0.0 };
            self.region.sure(followed.pair.eigenvalue, radius + error)
        });
        let first = told.next()??;
        told.all(|other| other == Some(first)).then_some(first)
    }

    /// Whether one of the pairs that are not told by their distance is followed and unstable throughout.
    fn follows_an_unstable_one(&self, told: &[Option<bool>]) -> bool {
        self.tracks.iter().enumerate().any(|(index, track)| {
            told[index].is_none()
                && track.at.iter().all(|followed| self.region.contains(followed.pair.eigenvalue))
                && self.is_followed(index)
                && track.targets(self.region).into_iter().all(|target| track.meets(target) == Some(None))
        })
    }

    fn others(&self, index: usize) -> impl Iterator<Item = &Track<'a>> {
        self.tracks.iter().enumerate().filter(move |(other, _)| *other != index).map(|(_, other)| other)
    }

    /// Whether a pair keeps apart from all others and from its conjugate, and is in the middle where the ends say.
    fn is_followed(&self, index: usize) -> bool {
        let track = &self.tracks[index];
        let size = track.at.iter().map(|followed| magnitude(followed.pair.eigenvalue)).fold(0.0, f64::max);
        let agrees = |apart: f64| track.miss <= AGREES * apart + EQUAL * size;
        let is_real = track.is_real();
        let conjugate = track.between.iter().map(|value| 2.0 * value.im).fold(f64::INFINITY, f64::min);
        let turn = track.at.iter().map(|followed| 2.0 * followed.slope.im.abs()).fold(0.0, f64::max);
        let is_clear_of_conjugate =
            is_real || APART * turn * self.half() <= conjugate + EQUAL * size && agrees(conjugate);
        is_clear_of_conjugate
            && self.others(index).all(|other| self.are_apart(track, other) && agrees(track.nearest(other)))
            && track.at.iter().all(|followed| self.way_to_alone(followed, track.way(self.half())) == 0.0)
    }

    /// Whether two pairs come no nearer to each other than a part of their way towards each other.
    fn are_apart(&self, one: &Track<'_>, other: &Track<'_>) -> bool {
        let turns = one.at.iter().zip(&other.at).map(|(one, other)| magnitude(one.slope - other.slope));
        let size = magnitude(one.at[1].pair.eigenvalue);
        APART * turns.fold(0.0, f64::max) * self.half() <= one.nearest(other) + EQUAL * size
    }

    /// How far the pairs go that are not at all three places, and that an eigenvalue may meet which goes so far.
    fn way_to_alone(&self, followed: &Followed, way: f64) -> f64 {
        let meets = |&&(other, its): &&(&Followed, f64)| {
            !std::ptr::eq(other, followed) && APART * (way + its) > distance(followed, other)
        };
        self.alone.iter().filter(meets).map(|(_, its)| way + its).fold(0.0, f64::max)
    }

    /// The same of all pairs.
    fn way_to_others(&self, followed: &Followed, way: f64) -> f64 {
        let tracked = self.tracks.iter().flat_map(|track| {
            let its = track.way(self.half());
            track.at.iter().map(move |other| (*other, its))
        });
        let ways = tracked.filter(|(other, its)| APART * (way + its) > distance(followed, other));
        ways.map(|(_, its)| way + its).fold(self.way_to_alone(followed, way), f64::max)
    }

    /// The critical value at which a pair meets a target, as a change if it is one; nothing if it was not found.
    fn change(
        &self,
        branches: &dyn Branches,
        track: &Track<'_>,
        target: Target,
        near: f64,
    ) -> Result<Option<Option<Change>>, Error> {
        let [from, middle, to] = track.at;
        let within = if near < middle.p { [from.p, middle.p] } else { [middle.p, to.p] };
        let start = track.at.into_iter().min_by(|a, b| (a.p - near).abs().total_cmp(&(b.p - near).abs()));
        let there = branches.follow(start.unwrap_or(middle), near);
        let Critical { at, error } = match there.and_then(|start| branches.critical(target, &start, within)) {
            Ok(critical) => critical,
            Err(Error::NotConverged { .. }) => return Ok(None),
            Err(error) => return Err(error),
        };
        if !error.is_finite() {
            return Ok(None);
        }
        let (_, slope) = target.distance(&at);
        let region = self.region;
        let (is_change, is_more) = match target {
            Target::DampingRatio(_) => (region.has_frequency_of(at.pair.eigenvalue), slope < 0.0),
            Target::Frequency(end) => {
                let enters = if end == region.lowest { slope > 0.0 } else { slope < 0.0 };
                (is_unstable(region, &at), enters)
            }
            Target::Growth => (region.lowest <= 0.0, slope < 0.0),
        };
        let more = multiplicity(from.pair.eigenvalue) * if is_more { 1 } else { -1 };
        Ok(Some(is_change.then_some(Change { p: at.p, error, at, target, more })))
    }
}

impl<'a> Track<'a> {
    fn new(at: [&'a Followed; 3]) -> Self {
        let [from, middle, to] = at;
        let value = |followed: &Followed| (followed.pair.eigenvalue, followed.slope);
        let interpolated = |from: &Followed, to: &Followed, t: f64| cubic([value(from), value(to)], to.p - from.p, t);
        let miss = magnitude(interpolated(from, to, 0.5) - middle.pair.eigenvalue);
        let halves = [(from, middle), (middle, to)].into_iter().flat_map(|(from, to)| {
            (0..SAMPLES).map(move |index| interpolated(from, to, index as f64 / SAMPLES as f64))
        });
        Self { between: halves.chain([to.pair.eigenvalue]).collect(), at, miss }
    }

    fn is_real(&self) -> bool {
        self.at[1].pair.eigenvalue.im == 0.0
    }

    /// How far it goes within half of the interval.
    fn way(&self, half: f64) -> f64 {
        let slopes = self.at.iter().map(|followed| magnitude(followed.slope) * half);
        let steps = self.at.windows(2).map(|ends| distance(ends[0], ends[1]));
        slopes.chain(steps).fold(0.0, f64::max)
    }

    /// How near two come to each other.
    fn nearest(&self, other: &Self) -> f64 {
        let squares = self.between.iter().zip(&other.between).map(|(one, other)| (one - other).norm_sqr());
        squares.fold(f64::INFINITY, f64::min).sqrt()
    }

    /// What it meets where it begins or ends to count.
    fn targets(&self, region: &Region) -> Vec<Target> {
        if self.is_real() {
            return if region.lowest <= 0.0 { vec![Target::Growth] } else { Vec::new() };
        }
        let ends = [region.lowest, region.highest].into_iter().filter(|end| *end > 0.0 && end.is_finite());
        ends.map(Target::Frequency).chain([Target::DampingRatio(region.damping_ratio - RESOLUTION)]).collect()
    }

    /// Whether it is so near a target at all three places that its error says no more of what lies between.
    fn is_within_errors(&self, region: &Region) -> bool {
        let is_near = |followed: &Followed, target: Target| {
            let counts = match target {
                Target::DampingRatio(_) => region.has_frequency_of(followed.pair.eigenvalue),
                Target::Frequency(_) => is_unstable(region, followed),
                Target::Growth => true,
            };
            counts && target.distance(followed).0.abs() <= 2.0 * target.error(&followed.pair)
        };
        self.targets(region).into_iter().any(|target| self.at.iter().all(|followed| is_near(followed, target)))
    }

    /// Where its distance to a target passes zero: once at a place, not at all, or, as the outer nothing, not to be said.
    fn meets(&self, target: Target) -> Option<Option<f64>> {
        let [from, middle, to] = self.at;
        let value = |followed: &Followed| target.distance(followed);
        let miss = (cubic([value(from), value(to)], to.p - from.p, 0.5) - value(middle).0).abs();
        let error = miss + self.at.iter().map(|followed| target.error(&followed.pair)).fold(0.0, f64::max);
        let mut values = Vec::with_capacity(2 * SAMPLES + 1);
        for (from, to) in [(from, middle), (middle, to)] {
            let step = to.p - from.p;
            values.extend((0..SAMPLES).map(|index| {
                let t = index as f64 / SAMPLES as f64;
                (from.p + step * t, cubic([value(from), value(to)], step, t))
            }));
        }
        values.push((to.p, value(to).0));
        let is_clear = |value: f64| value.abs() > error;
        let mut crossings = values.windows(2).filter(|two| (two[0].1 > 0.0) != (two[1].1 > 0.0));
        match (crossings.next(), crossings.next()) {
            (None, _) => values.iter().all(|value| is_clear(value.1)).then_some(None),
            (Some(two), None) if is_clear(values[0].1) && is_clear(value(to).0) => {
                let share = two[0].1 / (two[0].1 - two[1].1);
                Some(Some(two[0].0 + share * (two[1].0 - two[0].0)))
            }
            _ => None,
        }
    }
}

/// The cubic through values and slopes at both ends of a step, at a share `t` of it.
fn cubic<V>([(a, slope_a), (b, slope_b)]: [(V, V); 2], step: f64, t: f64) -> V
where
    V: std::ops::Mul<f64, Output = V> + std::ops::Add<Output = V> + std::ops::Sub<Output = V> + Copy,
{
    let u = 1.0 - t;
    (a * (1.0 + 2.0 * t) + slope_a * (t * step)) * (u * u) + (b * (1.0 + 2.0 * u) - slope_b * (u * step)) * (t * t)
}

fn distance(one: &Followed, other: &Followed) -> f64 {
    magnitude(one.pair.eigenvalue - other.pair.eigenvalue)
}

/// Whether a pair has a damping ratio below the threshold, whatever its frequency.
fn is_unstable(region: &Region, followed: &Followed) -> bool {
    damping_ratio(followed.pair.eigenvalue) < region.damping_ratio - RESOLUTION
}

/// Which pair of another place each of one place is, by their vectors.
fn joined(from: &Node<'_>, to: &Node<'_>) -> Vec<Option<usize>> {
    let step = to.p - from.p;
    let images: Vec<Images> = to.pairs.iter().map(|pair| to.place.images(&pair.pair)).collect();
    let mut is_free = vec![true; to.pairs.len()];
    let of_pair = |pair: &Followed| {
        if pair.pair.right.is_empty() {
            return None;
        }
        let expected = pair.pair.eigenvalue + pair.slope * step;
        let is_real = |followed: &Followed| followed.pair.eigenvalue.im == 0.0;
        let off = |other: &Followed| {
            let back = other.pair.eigenvalue - other.slope * step;
            magnitude(expected - other.pair.eigenvalue) + magnitude(back - pair.pair.eigenvalue)
        };
        let alike = to.pairs.iter().enumerate().filter(|(_, other)| is_real(other) == is_real(pair));
        let with_vectors = alike.filter(|(_, other)| !other.pair.right.is_empty());
        let mut near: Vec<(f64, usize)> = with_vectors.map(|(place, other)| (off(other), place)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let own = to.place.images(&pair.pair);
        let share = |place: usize| overlap((&pair.pair, &own), (&to.pairs[place].pair, &images[place]));
        let mut nearest = near.into_iter().take(COMPARED).map(|(_, place)| place);
        let place = nearest.find(|place| is_free[*place] && (OVERLAP..1.0 / OVERLAP).contains(&share(*place)))?;
        is_free[place] = false;
        Some(place)
    };
    from.pairs.iter().map(of_pair).collect()
}
