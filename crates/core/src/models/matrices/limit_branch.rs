//! A limit state of each pair, so that a search finds regions in which another pair than the least damped one is unstable.

use super::region::{RESOLUTION, Region, ZERO, magnitude};
use crate::numerics::eigenvalues::Eigenvalue;

/// A pair of eigenvalues, or two real ones.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Oscillator {
    /// The root of the product of both: the undamped angular frequency.
    size: f64,
    /// `-(lambda_1 + lambda_2) / (2 size)`: the damping ratio, also beyond 1; -1 where one of two real ones grows by more than
    /// [`ZERO`].
    damping: f64,
    /// The angular frequency, 0 of real ones.
    frequency: f64,
}

/// The limit states of all pairs, by rising undamped frequency: the damping ratio less the threshold, in the nearest of the
/// regions; outside of all bands, at least the distance to the nearest in parts of the frequency.
///
/// What grows or oscillates by no more than [`ZERO`] does so by rounding, as the zeros of a rigid-body motion: it makes nothing
/// unstable here either.
///
/// Overdamped pairs have one that goes on beyond a damping ratio of 1, so that its gradient leads to where they oscillate. Of several
/// of these the eigenvalue nearest to zero is joined with the one farthest away, and so on.
pub(super) fn limit_states(eigenvalues: &[Eigenvalue], regions: &[Region]) -> Vec<f64> {
    let mut oscillators: Vec<Oscillator> = eigenvalues
        .iter()
        .filter(|value| value.im > ZERO)
        .map(|value| {
            let size = magnitude(*value);
            Oscillator { size, damping: -value.re / size, frequency: value.im }
        })
        .collect();
    let mut real: Vec<f64> = eigenvalues.iter().filter(|value| value.im.abs() <= ZERO).map(|value| value.re).collect();
    real.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    // One that is left over is a motion that dampers alone hold: joined with itself, it is as damped as it can be, or grows.
    for (near, far) in real.iter().zip(real.iter().rev()).take(real.len().div_ceil(2)) {
        let size = (near * far).abs().sqrt();
        let damping = if *near > ZERO || *far > ZERO {
            -1.0
        } else if size > 0.0 {
            // Of two that do not grow it is 1 at least, but for rounding.
            (-0.5 * (near + far) / size).max(1.0)
        } else {
            1.0
        };
        oscillators.push(Oscillator { size, damping, frequency: 0.0 });
    }
    oscillators.sort_by(|a, b| a.size.total_cmp(&b.size));
    let of_region = |oscillator: &Oscillator, region: &Region| {
        let outside = (region.lowest - oscillator.frequency).max(oscillator.frequency - region.highest);
        // As for verdicts, so that the rounding of undamped pairs leads nowhere.
        let excess = oscillator.damping - (region.damping_ratio - RESOLUTION);
        if outside > 0.0 { excess.max(outside / oscillator.size) } else { excess }
    };
    let of_all = |oscillator: &Oscillator| {
        regions.iter().map(|region| of_region(oscillator, region)).fold(f64::INFINITY, f64::min)
    };
    oscillators.iter().map(of_all).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pair_has_its_own_limit_state() {
        let band = [Region { lowest: 1.0, highest: 5.0, damping_ratio: 0.1 }];
        let pair = |re: f64, im: f64| [Eigenvalue::new(re, im), Eigenvalue::new(re, -im)];
        // Below the band, unstable within it, overdamped, and above the band.
        let mut values = [pair(0.3, 0.4), pair(0.6, 1.9), pair(-6.0, 8.0)].concat();
        values.extend([Eigenvalue::new(-1.0, 0.0), Eigenvalue::new(-16.0, 0.0)]);
        let states = limit_states(&values, &band);
        let expected = [(1.0 - 0.4) / 0.5, -0.6 / 0.6_f64.hypot(1.9) - 0.1, 17.0 / 8.0 - 0.1, 0.6 - 0.1];
        assert!(states.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-8), "{states:?}");
        let all = [Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 }];
        let divergent = [Eigenvalue::new(2.0, 0.0), Eigenvalue::new(-3.0, 0.0)];
        assert!((limit_states(&divergent, &all)[0] + 1.0).abs() < 1e-8);
        for rounding in [-1e-17, 1e-17] {
            assert!(limit_states(&pair(rounding, 1.0), &all)[0] > 0.5 * RESOLUTION);
        }
    }

    #[test]
    fn what_grows_or_oscillates_by_rounding_alone_is_not_below_the_threshold() {
        let all = [Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 }];
        let real = |near: f64, far: f64| [Eigenvalue::new(near, 0.0), Eigenvalue::new(far, 0.0)];
        let pair = |re: f64, im: f64| [Eigenvalue::new(re, im), Eigenvalue::new(re, -im)];
        let rounding = 0.1 * ZERO;
        for zeros in [
            real(rounding, -3.0),
            real(rounding, -rounding),
            real(rounding, rounding),
            real(0.0, 0.0),
            pair(rounding, rounding),
            pair(rounding, 0.5 * ZERO),
        ] {
            let found = limit_states(&zeros, &all);
            assert!(found.len() == 1 && found[0] >= 1.0, "{zeros:?}: {found:?}");
            assert!(!zeros.iter().any(|value| all[0].contains(*value)), "{zeros:?}");
        }
        for growing in [real(10.0 * ZERO, -3.0), real(-rounding, 10.0 * ZERO), pair(10.0 * ZERO, 10.0 * ZERO)] {
            let found = limit_states(&growing, &all);
            assert!(found.len() == 1 && found[0] < 0.0, "{growing:?}: {found:?}");
            assert!(growing.iter().any(|value| all[0].contains(*value)), "{growing:?}");
        }
    }

    #[test]
    fn a_limit_state_goes_on_where_a_pair_ceases_to_oscillate() {
        let all = [Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 }];
        for damping in [0.2, 0.999, 1.001, 4.0] {
            // lambda^2 + 2 damping lambda + 1 = 0.
            let root = Eigenvalue::new(damping * damping - 1.0, 0.0).sqrt();
            let values = [root, -root].map(|root| root - damping);
            let found = limit_states(&values, &all);
            assert!((found[0] - damping).abs() < 1e-8, "{damping}: {found:?}");
        }
    }
}
