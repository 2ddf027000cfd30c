//! Natural logarithm and power for the friction law: few operations, no branch, the same bits on every machine and in
//! every lane.
//!
//! ```text
//! ln(x) = k ln 2 + ln(m),    x = 2^k m,   sqrt(1/2) <= m < sqrt(2)
//! ln(m) = 2 s + s^3 q(s^2),  s = (m - 1) / (m + 1)
//! ```
//!
//! The polynomial q of degree 6 was fitted at Chebyshev nodes in 60-digit arithmetic; its relative error in ln(m) is
//! 4.7e-18. With `f = m - 1` the sum is taken as `f - s (f - s^2 q)`, whose second term is small where the first has to
//! be accurate. The tests measure an error of less than one unit in the last place.

use crate::numerics::exponential::{ROUNDER, exp};

/// ln 2 in two parts; the first has 21 zero bits at its end, so that its product with k is exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// The bits of the number next below sqrt(1/2), and of 1.
const LEAST_SIGNIFICAND: u64 = 0x3fe6_a09e_667f_3bcc;
const ONE: u64 = 0x3ff0_0000_0000_0000;

/// The bits of 2^52: with a small whole number in its last bits it is 2^52 plus that number.
const TWO_52: u64 = 0x4330_0000_0000_0000;
const TWO_52_AND_BIAS: f64 = 4_503_599_627_370_496.0 + 1023.0;

/// The bits of a significand.
const SIGNIFICAND: u64 = 0x000f_ffff_ffff_ffff;

/// `log2(1 + f)` is `f + LOG2_BEND f (1 - f)`, to 0.01 for `0 <= f <= 1`.
const LOG2_BEND: f64 = 0.344;

/// `2^g` is `1 + EXP2_SLOPE g + EXP2_BEND g^2`, to 0.4 % for `|g| <= 1/2`, and continuous from one whole number to the
/// next: twice its value at -1/2 is that at 1/2.
const EXP2_SLOPE: f64 = 0.707_106_781_186_547_5;
const EXP2_BEND: f64 = 0.242_640_687_119_285_1;

/// Coefficients of q, from the constant one upwards.
const Q: [f64; 7] = [
    0.666_666_666_666_667,
    0.399_999_999_998_995_05,
    0.285_714_286_259_754_87,
    0.222_222_111_347_950_8,
    0.181_828_891_252_617_23,
    0.153_317_216_005_560_42,
    0.146_164_496_850_434_06,
];

/// `ln(x)` to less than one unit in the last place, for positive normal numbers. For zero and for subnormal numbers it
/// is a number between -710 and -708.
#[inline(always)]
pub(crate) fn ln(x: f64) -> f64 {
    // The exponent of x over the least significand, and what is left when it is taken away. k + 1023 is not negative.
    let above_least = x.to_bits().wrapping_sub(LEAST_SIGNIFICAND);
    let biased = above_least.wrapping_add(ONE) >> 52;
    let k = f64::from_bits(TWO_52 | biased) - TWO_52_AND_BIAS;
    let m = f64::from_bits(x.to_bits().wrapping_sub((biased << 52).wrapping_sub(ONE)));
    let f = m - 1.0;
    let s = f / (m + 1.0);
    let z = s * s;
    // Two chains of z^2: half the latency, the same operations.
    let w = z * z;
    let even = ((Q[6] * w + Q[4]) * w + Q[2]) * w + Q[0];
    let odd = (Q[5] * w + Q[3]) * w + Q[1];
    let tail = z * (even + z * odd);
    k * LN_2_HIGH - ((s * (f - tail) - k * LN_2_LOW) - f)
}

/// `x^y` for `x >= 0`, with a relative error of less than `(2 + 2 |ln(x^y)|) 2^-52`; 0 for `x = 0`. Results are kept
/// within `exp(-708)` and `exp(708)`.
///
/// In the friction law, where `x^y` is the argument p of `exp(-p)`, this is an absolute error of less than 3e-16 in
/// `exp(-p)`.
#[inline(always)]
pub(crate) fn power(x: f64, y: f64) -> f64 {
    let value = exp(y * ln(x));
    if x > 0.0 { value } else { 0.0 }
}

/// `x^y` to 10 % for `y` up to 10, and the closer the smaller y is: for limits that friction sets to steps. It grows
/// with x, and is kept within `2^-1000` and `2^1000`; 0 for `x = 0`.
#[inline(always)]
pub(crate) fn rough_power(x: f64, y: f64) -> f64 {
    let k = f64::from_bits(TWO_52 | (x.to_bits() >> 52)) - TWO_52_AND_BIAS;
    let f = f64::from_bits((x.to_bits() & SIGNIFICAND) | ONE) - 1.0;
    // log2(1 + f) and 2^g by parabolas through their values at both ends.
    let log2 = k + f * (LOG2_BEND + 1.0 - LOG2_BEND * f);
    let exponent = y * log2;
    let exponent = if exponent > 1000.0 { 1000.0 } else { exponent };
    let exponent = if exponent < -1000.0 { -1000.0 } else { exponent };
    let shifted = exponent + ROUNDER;
    let nearest = shifted - ROUNDER;
    let g = exponent - nearest;
    let value = 1.0 + g * (EXP2_SLOPE + EXP2_BEND * g);
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    if x > 0.0 { value * scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance in units in the last place of the reference.
    fn ulps(value: f64, reference: f64) -> f64 {
        let unit = f64::from_bits(reference.abs().to_bits() + 1) - reference.abs();
        ((value - reference) / unit).abs()
    }

    #[test]
    fn the_logarithm_is_less_than_one_unit_in_the_last_place_from_libm() {
        let mut largest = 0.0_f64;
        let mut compare = |x: f64| largest = largest.max(ulps(ln(x), libm::log(x)));
        for i in 0..2_000_000 {
            let share = (f64::from(i) + 0.37) / 2_000_000.0;
            compare(3.0 * share);
            compare(libm::exp(-60.0 + 120.0 * share));
        }
        for i in -1021..=1023 {
            compare(libm::ldexp(1.3, i));
        }
        assert!(largest <= 1.0, "{largest} ulps");
    }

    #[test]
    fn logarithms_to_forty_digits() {
        // mpmath 1.4, rounded to the nearest double.
        let table = [
            (1e-300, -690.775_527_898_213_7),
            (1e-12, -27.631_021_115_928_547),
            (0.001, -6.907_755_278_982_137),
            (0.5, -std::f64::consts::LN_2),
            (0.72, -0.328_504_066_972_036_1),
            (0.9999, -0.000_100_005_000_333_347_32),
            (1.0001, 9.999_500_033_329_732e-5),
            (1.41, 0.343_589_704_390_076_86),
            (1.5, 0.405_465_108_108_164_4),
            (2.0, std::f64::consts::LN_2),
            (7.3, 1.987_874_348_154_345_5),
            (1e5, 11.512_925_464_970_229),
            (1e300, 690.775_527_898_213_7),
        ];
        for (x, expected) in table {
            assert!(ulps(ln(x), expected) <= 1.0, "{x}: {} {expected}", ln(x));
        }
        assert_eq!(ln(1.0), 0.0);
    }

    #[test]
    fn significands_are_split_at_the_root_of_a_half() {
        for x in [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::SQRT_2] {
            for bits in [x.to_bits() - 1, x.to_bits(), x.to_bits() + 1] {
                let x = f64::from_bits(bits);
                assert!(ulps(ln(x), libm::log(x)) <= 1.0, "{x}");
            }
        }
    }

    #[test]
    fn powers_keep_their_bound() {
        let mut largest = 0.0_f64;
        for y in [0.01, 0.3, 0.5, 0.77, 1.0, 1.5, 2.0, 3.3, 5.0, 10.0] {
            for i in 0..20_000 {
                let x = libm::exp(-14.0 + 21.0 * (f64::from(i) + 0.37) / 20_000.0);
                let expected = libm::pow(x, y);
                let error = (power(x, y) / expected - 1.0).abs() / f64::EPSILON;
                largest = largest.max(error / (2.0 + 2.0 * libm::log(expected).abs()));
            }
        }
        assert!(largest < 1.0, "{largest}");
    }

    #[test]
    fn powers_to_forty_digits() {
        // mpmath 1.4, rounded to the nearest double.
        let table = [
            (0.3, 0.3, 0.696_845_301_935_949),
            (1e-5, 0.5, 0.003_162_277_660_168_379_4),
            (0.7, 1.5, 0.585_662_018_573_852_8),
            (2.5, 3.0, 15.625),
            (12.0, 0.7, 5.694_123_367_516_26),
            (1.9, 9.5, 444.794_295_788_548_94),
            (0.001, 4.2, 2.511_886_431_509_577_5e-13),
            (30.0, 1.2, 59.230_514_575_044_59),
            (0.999, 10.0, 0.990_044_880_209_748_2),
        ];
        for (x, y, expected) in table {
            let bound = (2.0 + 2.0 * libm::log(expected).abs()) * f64::EPSILON;
            assert!((power(x, y) / expected - 1.0).abs() < bound, "{x} {y}: {} {expected}", power(x, y));
        }
    }

    #[test]
    fn rough_powers_are_right_to_ten_per_cent_and_grow() {
        for y in [0.1, 0.5, 1.0, 1.3, 3.0, 10.0] {
            let mut before = 0.0;
            for i in 0..100_000 {
                let x = libm::exp(-14.0 + 21.0 * (f64::from(i) + 0.37) / 100_000.0);
                let rough = rough_power(x, y);
                let error = (rough / libm::pow(x, y) - 1.0).abs();
                assert!(error < 0.005 + 0.0095 * y, "{x} {y}: {error}");
                assert!(rough >= before, "{x} {y}");
                before = rough;
            }
            assert_eq!(rough_power(0.0, y), 0.0);
        }
    }

    #[test]
    fn zero_to_any_power_is_zero_and_large_powers_are_clamped() {
        assert_eq!(power(0.0, 0.001), 0.0);
        assert_eq!(power(0.0, 10.0), 0.0);
        assert_eq!(power(1e300, 10.0), exp(708.0));
        assert!(power(f64::MIN_POSITIVE, 10.0) > 0.0 && power(f64::MIN_POSITIVE, 10.0) < 1e-300);
        assert_eq!(power(1.0, 3.7), 1.0);
    }
}
