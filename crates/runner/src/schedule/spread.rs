//! The order in which units are computed: spread over the whole job from the beginning, so that what is finished shows
//! what the rest costs.

/// Largest number of places at which the work goes on in turn. Samples of a part that are finished out of order are
/// remembered as so many ranges at most.
const MOST_PLACES: u64 = 1 << 14;

/// The golden section, whose multiples are spread evenly however many there are.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// A permutation of numbers, the first of which are spread evenly over all.
#[derive(Debug, Clone)]
pub struct Spread {
    count: u64,
    /// The order of the places: their ranks by the fractional parts of the multiples of the golden section.
    places: Vec<u64>,
}

impl Spread {
    /// A permutation of the numbers below `count`.
    pub fn over(count: u64) -> Self {
        let multiples = (0..count.min(MOST_PLACES)).map(|turn| (turn as f64 * GOLDEN_SECTION).fract());
        let mut by_rank: Vec<(usize, f64)> = multiples.enumerate().collect();
        by_rank.sort_by(|(_, a), (_, b)| a.total_cmp(b));
        let mut places = vec![0; by_rank.len()];
        by_rank.iter().zip(0..).for_each(|(&(turn, _), rank)| places[turn] = rank);
        Self { count, places }
    }

    /// The number at position `turn`; `None` after the last.
    pub fn at(&self, turn: u64) -> Option<u64> {
        // Each place has the numbers from its own first to that of the next place. A round takes one of each; the last
        // one those of the places that are longer by one.
        let places = self.places.len() as u64;
        let (round, position) = (turn.checked_div(places)?, turn % places);
        if round < self.count / places {
            return Some(self.first(self.places[position as usize]) + round);
        }
        (turn < self.count).then(|| self.first(position) + round)
    }

    /// The first number of a place. The first places are longer by one, as far as the numbers go.
    fn first(&self, place: u64) -> u64 {
        let places = self.places.len() as u64;
        place * (self.count / places) + place.min(self.count % places)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_comes_once() {
        for count in [0, 1, 2, 3, 10, 780, 16_384, 16_385, 40_000] {
            let spread = Spread::over(count);
            let mut numbers: Vec<u64> = (0..).map_while(|turn| spread.at(turn)).collect();
            assert_eq!(numbers.len() as u64, count);
            numbers.sort_unstable();
            assert!(numbers.iter().copied().eq(0..count), "{count}");
        }
    }

    #[test]
    fn the_first_numbers_are_spread_evenly() {
        for (count, first) in [(780, 40), (16_384, 100), (1_000_000, 100)] {
            let spread = Spread::over(count);
            let mut numbers: Vec<u64> = (0..first).filter_map(|turn| spread.at(turn)).collect();
            numbers.sort_unstable();
            let widest = numbers.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap();
            assert!(widest < 3 * count / first, "{count}: a gap of {widest}");
        }
    }
}
