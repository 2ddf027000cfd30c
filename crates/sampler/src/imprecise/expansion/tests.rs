//! Derivatives against differences, and the bounds of all derivatives.

use super::*;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

fn boundary() -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", 15.0).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

fn cell(preload: f64, static_friction: f64) -> NormalPair {
    NormalPair { expected: [0.1, 0.39], relative_std: [preload, static_friction] }
}

fn value(coefficients: &Coefficients, [x, y]: [f64; 2]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, row| sum * x + row.iter().rev().fold(0.0, |sum, c| sum * y + c))
}

#[test]
fn the_polynomial_is_the_probability_up_to_its_remainder() {
    for (stds, width) in
        [((0.2, 0.1), 0.1), ((0.1, 0.3), 0.25), ((0.2, 0.0), 0.3), ((0.0, 0.1), 0.3), ((0.3, 0.2), 0.4)]
    {
        let centre = cell(stds.0, stds.1);
        let coefficients = expansion(&boundary(), &centre);
        let widths = [stds.0, stds.1].map(|std| if std > 0.0 { width } else { 0.0 });
        let bound = remainder(widths, [0, 0], true);
        let mut largest = 0.0f64;
        for x in [-1.0, -0.6, 0.0, 0.3, 1.0] {
            for y in [-1.0, -0.2, 0.0, 0.7, 1.0] {
                let [x, y] = [x * widths[0], y * widths[1]];
                let exact = closed_form::probability(&boundary(), &cell(stds.0 * x.exp(), stds.1 * y.exp()));
                largest = largest.max((value(&coefficients, [x, y]) - exact.value).abs());
            }
        }
        assert!(largest <= bound, "{stds:?}: {largest:e} {bound:e}");
        // The bound is of the right kind: not a thousand times too large, nor too small to matter.
        assert!(bound < 1e4 * largest.max(1e-9), "{stds:?}: {largest:e} {bound:e}");
    }
}

#[test]
fn no_derivative_of_a_tail_and_no_mean_exceeds_its_bound() {
    let limit = 14.0;
    let points = 280_000;
    let step = 2.0 * limit / f64::from(points);
    let (mut tails, mut means) = ([0.0f64; TERMS], [0.0f64; TERMS + 1]);
    let factorial = |k: usize| (1..=k).fold(1.0, |product, factor| product * factor as f64);
    // The next of each sequence, of the order of the remainder, from the recursions as they are written.
    let next_tail = |t: f64| derivative_of_tail(TERMS, t);
    for i in 0..=points {
        let z = -limit + step * f64::from(i);
        let derivatives = tail_derivatives(z);
        for k in 1..TERMS {
            tails[k - 1] = tails[k - 1].max((derivatives[k] * factorial(k)).abs());
        }
        tails[TERMS - 1] = tails[TERMS - 1].max(next_tail(z).abs());
        for k in 0..TERMS {
            means[k] += step * normal::density(z) * (even_polynomial(&DENSITIES[k], z * z) * factorial(k)).abs();
        }
        // p_k phi is the density of the derivative of the tail.
        let slope = (derivative_of_tail(TERMS, z + 1e-4) - derivative_of_tail(TERMS, z - 1e-4)) / 2e-4;
        means[TERMS] += step * slope.abs();
    }
    for (found, bound) in tails.iter().zip(MOST_OF_TAIL).chain(means.iter().zip(MEAN)) {
        assert!(*found <= bound * (1.0 + 1e-6) && *found > bound * (1.0 - 1e-4), "{found} {bound}");
    }
}

/// The derivative of the tail beyond `t`, by the recursion on coefficients of all powers.
fn derivative_of_tail(order: usize, t: f64) -> f64 {
    let mut coefficients = vec![0.0, 1.0];
    for _ in 1..order {
        let mut next = vec![0.0; coefficients.len() + 2];
        for (power, coefficient) in coefficients.iter().enumerate() {
            next[power + 2] += coefficient;
            next[power] -= power as f64 * coefficient;
        }
        coefficients = next;
    }
    normal::density(t) * coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

#[test]
fn the_remainder_of_a_band_is_that_of_both_its_tails() {
    // Unstable between two static friction coefficients: the derivatives of the two ends may add up.
    for half_width in [0.1, 0.5] {
        for by in [0, 1, 3] {
            let [tail, band] =
                [true, false].map(|is_single| remainder([0.0, half_width], [0, by], is_single) - ROUNDING);
            assert!(tail > 0.0 && (band / tail - 2.0).abs() < 1e-9, "{tail} {band}");
        }
    }
    // Such a band: the greatest derivative of a tail, and its opposite at the other end.
    let greatest = (-5000..5000).map(|i| derivative_of_tail(TERMS, f64::from(i) * 1e-3)).fold(0.0, f64::max);
    let least = (-5000..5000).map(|i| derivative_of_tail(TERMS, f64::from(i) * 1e-3)).fold(0.0, f64::min);
    let factorial = (1..=TERMS).fold(1.0, |product, factor| product * factor as f64);
    let bound = remainder([0.0, 1.0], [0, 0], false);
    assert!((greatest - least) / factorial <= bound, "{greatest} {least} {bound}");
}
