//! Points beyond: some of the points of a normal distribution are drawn farther out, so that no part of its tails is left out.
//!
//! Of independent standard normal deviates `u`, let `Q(u)` be the probability that others are farther from the origin. Beside
//! every [`EACH`] points with the normal density `phi` there is one beyond. Its direction is that of any other point, and its `Q`
//! lies between 1e-3 and 1e-15. From 1e-5 on each power of ten has as many points; before, their number rises from none. So they
//! have the density
//!
//! ```text
//! t(u) = phi(u) d(x) / (ln(10) Q(u)),   d(x) = min(1, (x - 3) / 2) / 11,   x = -log10 Q(u) from 3 to 15
//! ```
//!
//! All points together are a sample of the mixture of both. Whichever it was drawn from, a point counts
//!
//! ```text
//! a(u) = phi(u) / (phi(u) + t(u) / 4)
//! ```
//!
//! so that the sum of `a g` over all points, divided by the number of those with the normal density, is the mean of `g` without
//! bias, and no point counts for more than 1 (the balance heuristic: E. Veach, L. J. Guibas, SIGGRAPH 1995, 419-428). 999 of 1000
//! points with the normal density count 1, so that smooth means keep the precision of their nets. A region five standard
//! deviations out, which one of some million points would meet, gets its share of the points beyond, and each of them counts
//! some 1e-5.
//!
//! `a` is continuous, but at the far end. With as many points in the first power of ten as in others it would fall from 1 to 0.1 at
//! once, and where one point of a net over one input lies in its stratum would decide on nine tenths of it: in one randomisation of
//! twenty the sum would differ from all others, and where none of sixteen is such a one, their scatter is far too small.

use std::f64::consts::LN_10;
use std::ops::Range;

use crate::special_functions::chi_squared;

/// One point lies beyond for so many others.
pub const EACH: u64 = 4;

/// Randomisations of points beyond are numbered from here on, so that they are independent of all others.
pub const RANDOMISATIONS: u64 = 1 << 32;

/// Powers of ten of the probability of points farther out, with the sign changed: where points beyond begin and end, and over how
/// many their number rises.
const FIRST: f64 = 3.0;
const LAST: f64 = 15.0;
const RISE: f64 = 2.0;

/// How many powers of ten the same points would fill if none rose.
const DECADES: f64 = LAST - FIRST - 0.5 * RISE;

/// Halvings of a distance: to the last digit.
const HALVINGS: usize = 60;

/// No point lies farther from the origin than this and the root of the mean square: that has a probability below 1e-17.
const FARTHEST: f64 = 9.0;

/// The points beyond that belong to points of a randomisation: one to every fourth of them, from the first, second, third or
/// fourth on by turns, so that four randomisations together have one to [`EACH`] whatever their size.
#[must_use]
pub fn beside(points: Range<u64>, randomisation: u64) -> Range<u64> {
    let before = |point: u64| point.saturating_sub(randomisation % EACH).div_ceil(EACH);
    before(points.start)..before(points.end)
}

/// What a point of the normal distribution counts.
#[must_use]
pub fn weight(point: &[f64]) -> f64 {
    let decade = -libm::log10(chi_squared::upper_tail(square(point), point.len()));
    if (FIRST..LAST).contains(&decade) { weight_at(decade) } else { 1.0 }
}

/// Moves a point of the normal distribution beyond, and returns what it counts there.
///
/// The farther out of all points that it was, the nearer it comes to the others.
pub fn move_out(point: &mut [f64]) -> f64 {
    let square = square(point);
    let filled = DECADES * chi_squared::upper_tail(square, point.len());
    let rising = (2.0 * RISE * filled).sqrt();
    let decade = FIRST + if rising < RISE { rising } else { 0.5 * RISE + filled };
    let distance = distance(libm::exp(-LN_10 * decade), point.len());
    // The origin has no direction: any will do.
    let (factor, shift) = if square > 0.0 { (distance / square.sqrt(), 0.0) } else { (0.0, 1.0) };
    point.iter_mut().for_each(|u| *u *= factor);
    if let Some(first) = point.first_mut() {
        *first += shift * distance;
    }
    weight_at(decade)
}

/// What a point counts among those beyond, by the power of ten of the probability of points farther out.
fn weight_at(decade: f64) -> f64 {
    let beyond = ((decade - FIRST) / RISE).min(1.0) / DECADES;
    let others = EACH as f64 * LN_10 * libm::exp(-LN_10 * decade);
    others / (others + beyond)
}

fn square(point: &[f64]) -> f64 {
    point.iter().map(|u| u * u).sum()
}

/// The distance from the origin beyond which so many deviates lie with a probability.
fn distance(wanted: f64, deviates: usize) -> f64 {
    let (mut near, mut far) = (0.0, (deviates as f64).sqrt() + FARTHEST);
    for _ in 0..HALVINGS {
        let middle: f64 = 0.5 * (near + far);
        if chi_squared::upper_tail(middle * middle, deviates) > wanted {
            near = middle;
        } else {
            far = middle;
        }
    }
    0.5 * (near + far)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::deviates::{DeviateStream, Points};
    use crate::special_functions::normal;

    #[test]
    fn points_beyond_a_distance_have_its_probability() {
        // SciPy 1.17: chi2.sf.
        for (square, deviates, wanted) in [
            (4.0_f64, 1, 0.045_500_263_896_358_38),
            (4.0, 2, 0.135_335_283_236_612_7),
            (4.0, 3, 0.261_464_129_949_110_6),
            (30.0, 4, 4.894_437_128_029_217e-6),
            (60.0, 9, 1.340_678_048_395_962_5e-9),
            (100.0, 31, 3.464_370_244_941_618_7e-9),
        ] {
            assert!((distance(wanted, deviates) / square.sqrt() - 1.0).abs() < 1e-12, "{square} {deviates}");
        }
    }

    #[test]
    fn points_lie_beyond_with_the_weight_that_others_have_there() {
        let stream =
            |dimensions| DeviateStream { seed: 1, common_random_numbers: false, dimensions, points: Points::Sobol };
        for dimensions in [1, 2, 5, 31] {
            let mut decades = [0; 15];
            for point in stream(dimensions).draw(0, RANDOMISATIONS, 0..1024).chunks_exact(dimensions) {
                let mut moved = point.to_vec();
                let counts = move_out(&mut moved);
                let beyond = chi_squared::upper_tail(square(&moved), dimensions);
                assert!((0.99e-15..1.01e-3).contains(&beyond) && (0.0..=1.0).contains(&counts), "{beyond:e} {counts}");
                let is_at_the_end = beyond < 1.01e-15;
                assert!(is_at_the_end || (counts / weight(&moved) - 1.0).abs() < 1e-9);
                // The direction stays.
                let along: f64 = point.iter().zip(&moved).map(|(a, b)| a * b).sum();
                assert!((along / (square(point) * square(&moved)).sqrt() - 1.0).abs() < 1e-9);
                decades[(-beyond.log10()).floor().clamp(0.0, 14.0) as usize] += 1;
            }
            // An eleventh of 1024 in each, but for the first two, which have a quarter and three quarters of that.
            for (decade, count) in decades.iter().enumerate() {
                let share = [0.0, 0.0, 0.0, 0.25, 0.75].get(decade).copied().unwrap_or(1.0);
                let expected = 1024.0 / 11.0 * share;
                assert!((f64::from(*count) - expected).abs() <= 0.35 * expected, "{dimensions}: {decades:?}");
            }
        }
        let mut origin = [0.0; 3];
        let counts = move_out(&mut origin);
        assert!(origin[0] > 8.0 && (0.0..1e-12).contains(&counts), "{origin:?} {counts}");
    }

    #[test]
    fn a_fifth_of_all_points_lies_beyond() {
        for points in [1, 2, 3, 4, 16, 625, 1000] {
            let all: u64 = (0..16).map(|randomisation| beside(0..points, randomisation).end).sum();
            assert_eq!(all, 4 * points);
            for randomisation in 0..16 {
                let whole = beside(0..points, randomisation);
                assert!(whole.start == 0 && whole.end <= points.div_ceil(EACH));
                // In any pieces they are the same.
                for middle in 0..=points {
                    let [first, second] = [0..middle, middle..points].map(|piece| beside(piece, randomisation));
                    assert!(first.start == 0 && first.end == second.start && second.end == whole.end);
                    assert!(second.end - second.start <= (points - middle).div_ceil(EACH));
                }
            }
        }
        // Randomisations of a power of two have one as well.
        assert!((0..16).all(|randomisation| beside(0..256, randomisation) == (0..64)));
    }

    /// Of a region that no other point meets, too.
    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn means_over_both_kinds_of_points_have_no_bias() {
        for (dimensions, limit, most) in [(1, 1.0, 0.01), (1, 5.15, 0.03), (2, 4.0, 0.25), (5, 3.5, 0.6)] {
            let expected = normal::upper_tail(limit);
            let stream = DeviateStream { seed: 3, common_random_numbers: false, dimensions, points: Points::Sobol };
            let counted = |point: &[f64], counts: f64| if point[0] > limit { counts } else { 0.0 };
            let (points, randomisations) = (1024, 64);
            let (mut sum, mut all) = (0.0, 0.0);
            for randomisation in 0..randomisations {
                for point in stream.draw(0, randomisation, 0..points).chunks_exact(dimensions) {
                    sum += counted(point, weight(point));
                    all += weight(point);
                }
                let beyond = RANDOMISATIONS + randomisation;
                for point in stream.draw(0, beyond, 0..points / EACH).chunks_exact(dimensions) {
                    let mut moved = point.to_vec();
                    let counts = move_out(&mut moved);
                    sum += counted(&moved, counts);
                    all += counts;
                }
            }
            let count = (points * randomisations) as f64;
            assert!((all / count - 1.0).abs() < 2e-3, "{dimensions} {limit}: {all}");
            let error = sum / count / expected - 1.0;
            assert!(error.abs() < most, "{dimensions} {limit}: {error}");
        }
    }
}
