//! Centres for the samples of all configurations of a model, which are added where samples need all their eigenvalues.
//!
//! What a centre says of a sample is proved, so it does not matter which centres there are, in which order they came and which thread
//! made them: that decides only how many samples need all their eigenvalues.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock, PoisonError, RwLock};

use super::centre::Centre;
use super::decide::RegionSet;
use super::quadratic::DenseQuadratic;
use super::region::Region;

/// A centre takes about the time of all eigenvalues of so many samples, and is added after as many that needed them.
const COST: usize = 8;

/// Centres serve where typical changes of all coefficients together have at most this norm.
const LARGEST_NORM: f64 = 3.0;

/// Where more than this part of all pairs is near to bands from 0, a proof takes ten to twenty times what a series does, which is sure of
/// most samples there, as few modes are left that may come from elsewhere.
const LARGEST_PART: f64 = 0.7;

/// After so many samples without an answer, centres are asked no more if they told less than this part of them.
const TRIAL: usize = 64;
const WORTHWHILE: f64 = 0.125;

/// Centres at most, and numbers that all of them may have, 256 MiB.
const MOST_CENTRES: usize = 256;
const MOST_NUMBERS: usize = 1 << 25;

/// Centres that are asked for a sample, the nearest first.
const ASKED: usize = 2;

/// The centres of a model for all its regions, in the unit of the problem.
pub(super) struct Centres {
    regions: Vec<Region>,
    changing: Vec<usize>,
    expected: Vec<f64>,
    /// Whether the one at the expected values of the first configuration serves.
    serve: OnceLock<bool>,
    known: RwLock<Vec<Arc<Centre>>>,
    /// How many samples were decided and how many not.
    told: AtomicUsize,
    open: AtomicUsize,
}

impl Centres {
    /// For the changes of some coefficients about the expected ones of the first configuration.
    pub(super) fn new(regions: Vec<Region>, changing: Vec<usize>, expected: Vec<f64>) -> Self {
        let [told, open] = Default::default();
        Self { regions, changing, expected, serve: OnceLock::new(), known: RwLock::default(), told, open }
    }

    /// How many samples they have told.
    #[cfg(test)]
    pub(super) fn told(&self) -> usize {
        self.told.load(Ordering::Relaxed)
    }

    /// Whether they serve for the model.
    pub(super) fn serve(&self, problem: &DenseQuadratic) -> bool {
        *self.serve.get_or_init(|| {
            let first = Centre::new(problem, &self.expected, &self.changing, &self.regions);
            let suits = |centre: &Centre| {
                let is_wide = || centre.kept() as f64 > LARGEST_PART * problem.size() as f64;
                // A zero that stays one is at the edge of a band from 0.
                let is_open = || centre.regions(&self.expected).is_none();
                let is_from_zero = self.regions.iter().any(|region| region.lowest <= 0.0);
                centre.typical_norm() <= LARGEST_NORM && !(is_from_zero && (is_wide() || is_open()))
            };
            let Some(first) = first.filter(suits) else { return false };
            self.known.write().unwrap_or_else(PoisonError::into_inner).push(Arc::new(first));
            true
        })
    }

    /// Adds a centre at a sample, in place of one for other cells if there is no room.
    fn add(&self, problem: &DenseQuadratic, coefficients: &[f64]) -> Option<Arc<Centre>> {
        let is_of_other_cells = |centre: &Arc<Centre>| centre.distance(coefficients).is_none();
        let room = || {
            let mut known = self.known.write().unwrap_or_else(PoisonError::into_inner);
            let numbers: usize = known.iter().map(|centre| centre.numbers()).sum();
            if known.len() >= MOST_CENTRES || numbers >= MOST_NUMBERS {
                let place = known.iter().position(is_of_other_cells)?;
                known.remove(place);
            }
            Some(())
        };
        room()?;
        let centre = Arc::new(Centre::new(problem, coefficients, &self.changing, &self.regions)?);
        self.known.write().unwrap_or_else(PoisonError::into_inner).push(centre.clone());
        Some(centre)
    }

    /// The regions in which a sample has an unstable pair, if centres near it tell.
    pub(super) fn regions(&self, problem: &DenseQuadratic, coefficients: &[f64]) -> Option<RegionSet> {
        if !self.serve(problem) {
            return None;
        }
        let [told, open] = [&self.told, &self.open].map(|count| count.load(Ordering::Relaxed));
        if open >= TRIAL && (told as f64) < WORTHWHILE * open as f64 {
            return None;
        }
        let tell = |centre: &Arc<Centre>| centre.regions(coefficients);
        let regions = self.near(coefficients).iter().find_map(tell);
        if regions.is_some() {
            self.told.fetch_add(1, Ordering::Relaxed);
            return regions;
        }
        // One that is made here tells of this sample too.
        let is_due = (self.open.fetch_add(1, Ordering::Relaxed) + 1).is_multiple_of(COST);
        is_due.then(|| self.add(problem, coefficients)).flatten().as_ref().and_then(tell)
    }

    /// The centres that are asked for a sample.
    fn near(&self, coefficients: &[f64]) -> Vec<Arc<Centre>> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let distance = |centre: &Arc<Centre>| centre.distance(coefficients).unwrap_or(f64::INFINITY);
        let mut distances: Vec<f64> = known.iter().map(distance).collect();
        let next = |_| {
            let nearest = (0..distances.len()).min_by(|&i, &j| distances[i].total_cmp(&distances[j]))?;
            let is_one = std::mem::replace(&mut distances[nearest], f64::INFINITY) < f64::INFINITY;
            is_one.then(|| known[nearest].clone())
        };
        (0..ASKED).map_while(next).collect()
    }
}

#[cfg(test)]
mod families;

#[cfg(test)]
mod tests {
    use super::super::centre::tests::structure;
    use super::super::decide::Decider;
    use super::super::trial::Numbers;
    use super::*;

    fn samples(count: usize, scatter: f64) -> Vec<Vec<f64>> {
        let mut numbers = Numbers(5);
        (0..count)
            .map(|_| (0..5).map(|k| if k < 3 { 1.0 } else { 1.0 + scatter * numbers.normal() }).collect())
            .collect()
    }

    fn number_of_centres(centres: &Centres) -> usize {
        centres.known.read().unwrap().len()
    }

    /// Centres come in another order with samples in another order; no verdict is another.
    #[test]
    fn centres_are_added_where_they_are_wanted_and_which_there_are_changes_no_verdict() {
        let (problem, regions) = structure(2, 20);
        let samples = samples(400, 0.09);
        let new = || Centres::new(regions.to_vec(), vec![3, 4], vec![1.0; 5]);
        let (forwards, backwards) = (new(), new());
        let tell = |centres: &Centres, sample: &Vec<f64>| centres.regions(&problem, sample);
        let first: Vec<Option<RegionSet>> = samples.iter().map(|sample| tell(&forwards, sample)).collect();
        let other: Vec<Option<RegionSet>> = samples.iter().rev().map(|sample| tell(&backwards, sample)).collect();
        for ((sample, first), other) in samples.iter().zip(&first).zip(other.iter().rev()) {
            let truth = Decider::of_each(&problem, &regions).by_all(sample);
            assert!([first, other].into_iter().flatten().all(|told| Some(*told) == truth));
        }
        let open = |told: &[Option<RegionSet>]| told.iter().filter(|told| told.is_none()).count();
        assert!(number_of_centres(&forwards) > 4, "{}", number_of_centres(&forwards));
        assert!(
            open(&first) >= 40 && open(&first[200..]) < open(&first[..200]),
            "{} {}",
            open(&first[..200]),
            open(&first)
        );
    }

    #[test]
    fn centres_that_tell_nothing_are_asked_no_more_and_not_added() {
        let (problem, regions) = structure(2, 20);
        let centres = Centres::new(regions.to_vec(), vec![3, 4], vec![1.0; 5]);
        for sample in samples(300, 3.0) {
            centres.regions(&problem, &sample);
        }
        assert!(number_of_centres(&centres) <= 1 + TRIAL / COST, "{}", number_of_centres(&centres));
        assert!(centres.open.load(Ordering::Relaxed) < 200);
    }

    /// Cells with another value of what does not change from sample to sample take the place of the centres of others.
    #[test]
    fn there_is_no_more_than_room_for_and_other_cells_make_room() {
        let (problem, regions) = structure(2, 16);
        let centres = Centres::new(regions.to_vec(), vec![4], vec![1.0; 5]);
        for place in 0..2 * MOST_CENTRES {
            centres.add(&problem, &[1.0, 1.0, 1.0, 1.0, 1.0 + 1e-3 * place as f64]);
        }
        assert_eq!(number_of_centres(&centres), MOST_CENTRES);
        let other = [1.0, 1.0, 1.0, 1.01, 1.0];
        assert!(centres.near(&other).is_empty());
        centres.add(&problem, &other);
        assert_eq!(number_of_centres(&centres), MOST_CENTRES);
        assert_eq!(centres.near(&other).len(), 1);
    }
}
