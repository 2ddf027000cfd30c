//! The values of one quantity that make samples unstable, whatever else they have.

/// Values of a quantity at which a sample is unstable, as intervals in rising order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct UnstableValues {
    /// Where it surely is.
    pub surely: Vec<[f64; 2]>,
    /// Where it is or may be: errors of critical values, and stretches on which eigenvalues could not be followed.
    pub possibly: Vec<[f64; 2]>,
}

impl UnstableValues {
    /// Where this or another is.
    #[must_use]
    pub fn or(self, other: &Self) -> Self {
        Self { surely: joined(self.surely, &other.surely), possibly: joined(self.possibly, &other.possibly) }
    }
}

/// Intervals without overlaps that have all values of these.
fn joined(mut all: Vec<[f64; 2]>, more: &[[f64; 2]]) -> Vec<[f64; 2]> {
    all.extend(more);
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for interval in all {
        match joined.last_mut() {
            Some(last) if interval[0] <= last[1] => last[1] = last[1].max(interval[1]),
            _ => joined.push(interval),
        }
    }
    joined
}

/// What a search finds on an interval: its unstable values, or nothing where it is to be halved.
pub type OnInterval = Option<UnstableValues>;

/// Remembers what a search finds, interval by interval. Searches for the same are of the same intervals in the same order, so
/// that one that begins anew can be given what is known.
pub trait Memory {
    /// What the next interval has: what is remembered, or what `find` says. `None` ends the search, which is stopped or found
    /// nothing.
    fn next(&self, interval: [f64; 2], find: &mut dyn FnMut() -> Option<OnInterval>) -> Option<OnInterval>;
}

/// Remembers nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoMemory;

impl Memory for NoMemory {
    fn next(&self, _: [f64; 2], find: &mut dyn FnMut() -> Option<OnInterval>) -> Option<OnInterval> {
        find()
    }
}

/// Critical values of a quantity: what separates its stable from its unstable values, with all other quantities fixed.
pub trait CriticalValues {
    /// The values of the varying quantity at `place` among these at which a sample is unstable that has `values` of all
    /// varying quantities (that at `place` counts for nothing). They are looked for between the first and the last of
    /// `places`, which rise; the search begins with the intervals between them. `None` if they cannot be found, or `memory` ends the search.
    fn unstable(&self, values: &[f64], place: usize, places: &[f64], memory: &dyn Memory) -> Option<UnstableValues>;
}

/// With how many intervals a search begins where nothing says which values matter.
pub const INTERVALS: usize = 12;

/// The ends of intervals of one width.
#[must_use]
pub fn evenly([low, high]: [f64; 2], intervals: usize) -> Vec<f64> {
    let place = |index: usize| low + (high - low) * index as f64 / intervals as f64;
    (0..intervals).map(place).chain([high]).collect()
}

/// The places within limits, and the limits where places lie beyond; `None` if nothing lies within.
#[must_use]
pub fn within(places: &[f64], [minimum, maximum]: [f64; 2]) -> Option<Vec<f64>> {
    let [low, high] = [places.first()?.max(minimum), places.last()?.min(maximum)];
    let inside = places.iter().copied().filter(|place| low < *place && *place < high);
    (low < high).then(|| [low].into_iter().chain(inside).chain([high]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_that_touch_or_overlap_become_one() {
        let of = |surely: &[[f64; 2]]| UnstableValues { surely: surely.to_vec(), possibly: vec![] };
        let both = of(&[[3.0, 4.0], [0.0, 1.0]]).or(&of(&[[0.5, 2.0], [4.0, 5.0], [7.0, 8.0]]));
        assert_eq!(both.surely, [[0.0, 2.0], [3.0, 5.0], [7.0, 8.0]]);
    }
}
