//! The friction law's exponential: few operations, no branch, the same bits on every machine and in every lane.
//!
//! ```text
//! exp(x) = 2^n exp(r),   n = round(x / ln 2),   r = x - n ln 2 in two parts,   |r| <= ln(2) / 2
//! ```
//!
//! `exp(r) = 1 + r + r^2 q(r)` with a polynomial q of degree 9, fitted at Chebyshev nodes in 60-digit arithmetic; its
//! relative error is 1.6e-17. Rounding adds the rest: less than one unit in the last place, which the tests measure.

const LOG2_E: f64 = std::f64::consts::LOG2_E;

/// ln 2 in two parts; the first has 21 zero bits at its end, so that its product with n is exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// 1.5 * 2^52: a sum with it is rounded to a whole number, which its last bits then hold.
pub(crate) const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Beyond it the result would leave the range of normal numbers; arguments are clamped to it.
const LARGEST: f64 = 708.0;

/// Coefficients of q, from the constant one upwards.
const Q: [f64; 10] = [
    0.500_000_000_000_000_1,
    0.166_666_666_666_666_69,
    0.041_666_666_666_624_13,
    0.008_333_333_333_330_062,
    0.001_388_888_891_721_371_7,
    1.984_126_986_305_361_8e-4,
    2.480_152_129_595_437_6e-5,
    2.755_726_845_999_706_4e-6,
    2.762_008_844_540_974_6e-7,
    2.510_038_549_551_032e-8,
];

/// `exp(x)` to less than one unit in the last place for `|x| <= 708`; arguments beyond are clamped, NaN gives NaN.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    // Comparisons and not `clamp`, `min` or `max`: those choose between NaN and limit differently.
    let x = if x > LARGEST { LARGEST } else { x };
    let x = if x < -LARGEST { -LARGEST } else { x };
    let shifted = x * LOG2_E + ROUNDER;
    let n = shifted - ROUNDER;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    // Two chains of r^2 (Estrin's first step) instead of one of r: half the latency, the same operations.
    let s = r * r;
    let even = (((Q[8] * s + Q[6]) * s + Q[4]) * s + Q[2]) * s + Q[0];
    let odd = (((Q[9] * s + Q[7]) * s + Q[5]) * s + Q[3]) * s + Q[1];
    let value = 1.0 + (r + s * (even + r * odd));
    // n + 1023 as biased exponent; the low bits of `shifted` hold n, whatever its sign.
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    value * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance in units in the last place of the reference.
    fn ulps(value: f64, reference: f64) -> f64 {
        let unit = f64::from_bits(reference.to_bits() + 1) - reference;
        ((value - reference) / unit).abs()
    }

    #[test]
    fn less_than_one_unit_in_the_last_place_from_libm() {
        // libm's exp is itself within one unit; two correct results may thus lie up to two apart, and do not.
        let mut largest = 0.0_f64;
        for i in 0..2_000_000 {
            let x = -40.0 + 50.0 * (f64::from(i) + 0.37) / 2_000_000.0;
            largest = largest.max(ulps(exp(x), libm::exp(x)));
        }
        for i in -7080..=7080 {
            let x = 0.1 * f64::from(i);
            largest = largest.max(ulps(exp(x), libm::exp(x)));
        }
        assert!(largest <= 1.0, "{largest} ulps");
    }

    #[test]
    fn values_to_forty_digits() {
        // mpmath 1.4, rounded to the nearest double: the error against the true value, not against another program.
        let table = [
            (-0.5, 0.606_530_659_712_633_4),
            (-1.0, 0.367_879_441_171_442_33),
            (-2.806_25, 0.060_431_184_959_839_59),
            (-20.0, 2.061_153_622_438_558e-9),
            (1.0, std::f64::consts::E),
            (-700.0, 9.859_676_543_759_77e-305),
        ];
        for (x, expected) in table {
            assert!(ulps(exp(x), expected) <= 1.0, "{x}: {} {expected}", exp(x));
        }
    }

    #[test]
    fn the_static_coefficient_is_met_exactly() {
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-0.0), 1.0);
    }

    #[test]
    fn arguments_without_a_result_are_clamped_and_nan_stays() {
        assert_eq!(exp(-1e300), exp(-708.0));
        assert_eq!(exp(f64::NEG_INFINITY), exp(-708.0));
        assert!(exp(-708.0) > 0.0);
        assert_eq!(exp(1e300), exp(708.0));
        assert!(exp(f64::NAN).is_nan());
    }
}
