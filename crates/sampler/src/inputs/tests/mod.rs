//! Properties of every distribution, and errors.

mod deviates;
mod moments;
mod quantiles;

use proptest::prelude::*;

use super::marginal::WIDEST_UNIFORM;
use super::*;
use crate::special_functions::gauss_legendre::NODES_32;
use crate::special_functions::normal;

const MEASURED: [f64; 7] = [0.31, 0.42, 0.35, 0.42, 0.58, 0.29, 0.37];

const EXPECTED: f64 = 0.39;

const DEVIATES: [f64; 9] = [-8.0, -3.0, -1.0, -0.1, 0.0, 0.5, 2.0, 6.0, 8.0];

const SYMMETRIC: Marginal = Marginal::Triangular { mode: 0.5 };

const BETA: Marginal = Marginal::Beta { low: 0.5, high: 2.0 };

fn truncated(low: f64, high: f64) -> Marginal {
    Marginal::TruncatedNormal { low, high }
}

#[test]
fn values_that_define_no_distribution_are_refused() {
    use EmpiricalError as E;
    assert_eq!(Empirical::new(&[]), Err(E::TooFew { count: 0 }));
    assert_eq!(Empirical::new(&[1.0]), Err(E::TooFew { count: 1 }));
    assert_eq!(Empirical::new(&[1.0, f64::INFINITY]), Err(E::NotFinite { value: f64::INFINITY }));
    assert!(matches!(Empirical::new(&[1.0, f64::NAN]), Err(E::NotFinite { .. })));
    assert_eq!(Empirical::new(&[0.5; 3]), Err(E::AllEqual { value: 0.5 }));
    assert_eq!(Empirical::new(&[-1.0, 1.0]), Err(E::Mean { mean: 0.0 }));
    assert!(matches!(Empirical::new(&[-f64::MAX, f64::MAX, 1e-300]), Err(E::Mean { .. })));
    assert!(Empirical::new(&[f64::MAX, 0.0]).is_ok());
}

proptest! {
    #[test]
    fn every_distribution_rises_with_the_deviate(
        choice in 0_usize..6,
        share in 0.0_f64..=1.0,
        place in 0.0_f64..=1.0,
        values in prop::collection::vec(0.01_f64..10.0, 2..30),
        from in -8.5_f64..8.5,
        step in 0.0_f64..3.0,
    ) {
        let (marginal, relative_std) = match choice {
            0 => (Marginal::Weibull, 10.0 * share),
            1 => (Marginal::Gumbel, 2.0 * share),
            2 => (Marginal::Triangular { mode: place }, 0.35 * share),
            3 => (Marginal::Beta { low: 0.9 * place, high: 1.5 }, 0.02 + 0.17 * share),
            4 => (truncated(-3.0 * place - 0.1, 4.0 * share + 0.1), 0.3),
            _ => (Empirical::new(&values).map_or(Marginal::Normal, Marginal::Empirical), 0.3),
        };
        prop_assert_eq!(marginal.check(EXPECTED, relative_std), Ok(()));
        let [low, high] = [from, from + step].map(|z| marginal.value(EXPECTED, relative_std, z));
        prop_assert!(low.is_finite() && high.is_finite());
        prop_assert!(high >= low * (1.0 - 1e-14) - 1e-15, "{:?} {}: {} {}", marginal, relative_std, low, high);
    }
}

#[test]
fn inputs_rise_with_the_deviate_and_stay_inside_their_interval() {
    for marginal in [
        Marginal::Normal,
        Marginal::Lognormal,
        Marginal::Uniform,
        truncated(-2.0, 3.0),
        truncated(-0.1, 0.1),
        truncated(5.0, f64::INFINITY),
        Marginal::Weibull,
        Marginal::Gumbel,
        SYMMETRIC,
        Marginal::Triangular { mode: 0.0 },
        BETA,
    ] {
        let mut previous = f64::NEG_INFINITY;
        for i in -8000_i32..=8000 {
            let value = marginal.value(EXPECTED, 0.25, f64::from(i) * 1e-3);
            // Values next to an end are equal to rounding.
            assert!(value > previous - 1e-15, "{marginal:?} at {i}: {value} after {previous}");
            assert!(i.abs() > 5000 || value > previous, "{marginal:?} at {i}: {value} after {previous}");
            if let Marginal::TruncatedNormal { low, high } = marginal {
                assert!(value >= EXPECTED * (1.0 + 0.25 * low) && value <= EXPECTED * (1.0 + 0.25 * high));
            }
            previous = value;
        }
    }
}

#[test]
fn rounding_keeps_values_inside_the_interval() {
    for i in 1..=100 {
        let [low, high] = [-0.05 * f64::from(i), 0.07 * f64::from(i)];
        for z in [-37.0, 37.0] {
            let value = truncated(low, high).value(EXPECTED, 0.25, z);
            let ends = [low, high].map(|end| EXPECTED * (1.0 + 0.25 * end));
            assert!((ends[0]..=ends[1]).contains(&value), "{low}, {high}: {value} at {z}");
        }
    }
}

#[test]
fn many_deviates_have_the_inputs_of_each() {
    let measured = Marginal::Empirical(Empirical::new(&MEASURED).unwrap());
    for marginal in [
        Marginal::Normal,
        Marginal::Lognormal,
        Marginal::Uniform,
        truncated(-2.0, 3.0),
        Marginal::Weibull,
        Marginal::Gumbel,
        SYMMETRIC,
        BETA,
        measured,
    ] {
        let mut values = DEVIATES;
        marginal.apply(EXPECTED, 0.25, &mut values);
        assert_eq!(values, DEVIATES.map(|z| marginal.value(EXPECTED, 0.25, z)));
    }
}

#[test]
fn impossible_marginals_are_refused() {
    use MarginalError as E;
    for value in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(Marginal::Normal.check(value, 0.1), Err(E::Expected { value }));
    }
    assert!(matches!(Marginal::Normal.check(f64::NAN, 0.1), Err(E::Expected { .. })));
    assert_eq!(Marginal::Lognormal.check(1.0, -0.1), Err(E::RelativeStd { value: -0.1 }));
    assert!(matches!(Marginal::Lognormal.check(1.0, f64::NAN), Err(E::RelativeStd { .. })));
    assert_eq!(Marginal::Lognormal.check(1.0, 3.0), Ok(()));
    for marginal in [Marginal::Lognormal, Marginal::Weibull, Marginal::Gumbel] {
        assert_eq!(marginal.check(1.0, 10.0), Ok(()));
        assert_eq!(marginal.check(1.0, 20.0), Err(E::RelativeStd { value: 20.0 }));
    }
    assert_eq!(Marginal::Normal.check(1.0, 1.0), Ok(()));
    assert_eq!(Marginal::Normal.check(1.0, 1.1), Err(E::NormalTooWide { value: 1.1 }));
    assert_eq!(truncated(-0.5, 9.0).check(1.0, 2.0), Ok(()));
    assert_eq!(truncated(-1.0, 9.0).check(1.0, 2.0), Err(E::TruncatedTooWide { value: 2.0, low: -1.0, lowest: -0.5 }));
    assert_eq!(Marginal::Triangular { mode: 1.5 }.check(1.0, 0.1), Err(E::Mode { mode: 1.5 }));
    assert_eq!(SYMMETRIC.check(1.0, 0.408_24), Ok(()));
    assert!(matches!(SYMMETRIC.check(1.0, 0.408_25), Err(E::TriangularTooWide { .. })));
    for (low, high) in [(-0.1, 2.0), (1.0, 2.0), (0.5, 1.0), (0.5, f64::INFINITY), (f64::NAN, 2.0)] {
        assert!(matches!(Marginal::Beta { low, high }.check(1.0, 0.1), Err(E::BetaEnds { .. })), "{low} {high}");
    }
    assert_eq!(BETA.check(1.0, 0.0), Ok(()));
    for value in [1e-6, 0.708] {
        assert!(matches!(BETA.check(1.0, value), Err(E::BetaStd { .. })), "{value}");
    }
    assert_eq!(Marginal::Uniform.check(1.0, 1.0 / 3f64.sqrt()), Ok(()));
    assert_eq!(Marginal::Uniform.check(1.0, 0.578), Err(E::UniformTooWide { value: 0.578 }));
    assert_eq!(truncated(3.0, 3.0).check(1.0, 0.1), Err(E::NoInterval { low: 3.0, high: 3.0 }));
    assert!(matches!(truncated(f64::NAN, 3.0).check(1.0, 0.1), Err(E::NoInterval { .. })));
    assert_eq!(truncated(10.0, 20.0).check(1.0, 0.1), Err(E::IntervalTooFar { low: 10.0, high: 20.0 }));
    assert_eq!(truncated(f64::NEG_INFINITY, f64::INFINITY).check(1.0, 0.1), Ok(()));
}
