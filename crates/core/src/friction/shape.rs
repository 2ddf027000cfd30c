//! Friction laws as integration steps evaluate them.

use crate::friction::measured_curve::SharedCurve;
use crate::numerics::exponential::exp;
use crate::numerics::logarithm::power;
use crate::numerics::row::{Number, shared_by_lanes};

/// How friction depends on the sliding speed, without any coefficient: what all samples in the lanes of a register have
/// in common. It is matched outside of loops over lanes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) enum Shape {
    /// Stribeck's law with the exponent 1.
    #[default]
    Tustin,
    /// Stribeck's law with the exponent 2.
    Gaussian,
    /// Stribeck's law with any exponent. The exponents 1 and 2 give the bits of the two above.
    Stribeck,
    /// `1 / (1 + r)`.
    Rational,
    /// A measured curve.
    Table(SharedCurve),
}

impl Shape {
    /// The shape of Stribeck's law with an exponent.
    pub fn of_stribeck(exponent: f64) -> Self {
        match exponent {
            1.0 => Self::Tustin,
            2.0 => Self::Gaussian,
            _ => Self::Stribeck,
        }
    }

    /// The parts a and b of the law ([`crate::friction`]) at `r`, the sliding speed over the law's speed scale; the
    /// friction coefficient is `f_c + (f_s - f_c) a + e b`.
    ///
    /// A step may reach a little beyond the moment at which the sliding speed vanishes. Curves are continued to
    /// negative `r` so that the step keeps its order: smoothly for the exponents 1 and 2, the rational law and a table
    /// that begins at rest, as an even function for other exponents, whose derivatives at rest are infinite in any
    /// case.
    /// Every lane has its own exponent, which counts for [`Shape::Stribeck`] alone.
    #[inline(always)]
    pub fn parts<N: Number>(self, r: N, exponent: N) -> (N, N) {
        let (mut a, mut b) = (r, r);
        let (r, exponent) = (r.lanes(), exponent.lanes());
        // A macro and no closure: a closure is inlined only if it does little.
        macro_rules! each_lane {
            (|$l:ident| $parts:expr) => {
                for $l in 0..r.len() {
                    (a.lanes_mut()[$l], b.lanes_mut()[$l]) = $parts;
                }
            };
        }
        match self {
            Self::Tustin => each_lane!(|l| (exp(-tustin_power(r[l])), r[l])),
            Self::Gaussian => each_lane!(|l| (exp(-(r[l] * r[l])), r[l])),
            Self::Stribeck => each_lane!(|l| (exp(-stribeck_power(r[l], exponent[l])), r[l])),
            Self::Rational => each_lane!(|l| (rational(r[l]), r[l])),
            Self::Table(curve) if curve.deviations().is_none() => each_lane!(|l| (curve.shape_alone(r[l]), 0.0)),
            Self::Table(curve) => each_lane!(|l| curve.values(r[l])),
        }
        (a, b)
    }
}

// The lanes of a register have the shape of their friction law in common.
shared_by_lanes!(Shape);

/// `r^delta` for the exponent 1, down to `r = -1`.
#[inline(always)]
fn tustin_power(r: f64) -> f64 {
    if r < -1.0 { -1.0 } else { r }
}

#[inline(always)]
fn stribeck_power(r: f64, exponent: f64) -> f64 {
    let general = power(r.abs(), exponent);
    let squared = if exponent == 2.0 { r * r } else { general };
    if exponent == 1.0 { tustin_power(r) } else { squared }
}

#[inline(always)]
fn rational(r: f64) -> f64 {
    let r = if r < -0.5 { -0.5 } else { r };
    1.0 / (1.0 + r)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::law::FrictionLaw;
    use crate::friction::measured_curve::MeasuredCurve;
    use crate::numerics::row::Row;

    fn curve() -> SharedCurve {
        let curve = MeasuredCurve::new(&[0.0, 0.4, 1.0, 3.0], &[0.5, 0.3, 0.35, 0.4], Some(&[0.1, 0.0, 0.1, 0.2]));
        SharedCurve::new(curve.unwrap())
    }

    fn laws() -> Vec<FrictionLaw> {
        let stribeck =
            [0.3, 0.5, 1.0, 1.7, 2.0, 3.0, 5.0].map(|exponent| FrictionLaw::stribeck(0.4, 0.25, 0.7, exponent));
        let others = [FrictionLaw::rational(0.4, 0.25, 0.7), FrictionLaw::table(curve(), 0.4, 0.9)];
        stribeck.into_iter().chain(others).map(|law| law.with_additional(0.3)).collect()
    }

    #[test]
    fn parts_are_those_of_the_law() {
        for law in laws() {
            for i in 0..1000 {
                let r = 0.01 * f64::from(i);
                let (a, b) = law.shape.parts(r, law.exponent);
                let mu = 0.3 * b + law.kinetic_coefficient + law.falling() * a;
                assert!((mu - law.coefficient(r * law.speed_scale)).abs() < 1e-15 * 4.0, "{law:?} {r}");
            }
        }
    }

    #[test]
    fn lanes_have_the_bits_of_single_values() {
        for law in laws() {
            let r: [f64; 64] = std::array::from_fn(|i| -0.9 + 0.13 * i as f64);
            let (a, b) = law.shape.parts(Row(r), Row::splat(law.exponent));
            for (i, r) in r.into_iter().enumerate() {
                assert_eq!((a.0[i], b.0[i]), law.shape.parts(r, law.exponent), "{law:?} {r}");
            }
        }
    }

    #[test]
    fn the_exponents_one_and_two_have_the_same_bits_among_others() {
        for i in -200..2000 {
            let r = 0.01 * f64::from(i);
            for (exponent, shape) in [(1.0, Shape::Tustin), (2.0, Shape::Gaussian)] {
                assert_eq!(Shape::Stribeck.parts(r, exponent), shape.parts(r, exponent), "{r} {exponent}");
            }
        }
    }

    #[test]
    fn curves_go_on_smoothly_beyond_rest() {
        let smooth = [Shape::Tustin, Shape::Gaussian, Shape::Rational, Shape::Table(curve())];
        for shape in smooth {
            let at = |r: f64| shape.parts(r, 1.0).0;
            let third = at(2e-3) - 3.0 * at(1e-3) + 3.0 * at(0.0) - at(-1e-3);
            assert!(third.abs() < 1e-7, "{shape:?} {third}");
        }
        for law in laws() {
            assert!((-300..0).all(|i| law.shape.parts(0.1 * f64::from(i), law.exponent).0.abs() < 4.0), "{law:?}");
            assert_eq!(law.shape.parts(0.0, law.exponent).0, 1.0, "{law:?}");
        }
    }
}
