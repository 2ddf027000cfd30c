//! The probability of instability over one input, where its unstable values are known.

use stickslip_core::model::critical_values::UnstableValues;

use crate::inputs::{DeviateLaw, End, InputDistribution};
use crate::integrate::closed_form::ExactProbability;
use crate::special_functions::normal;

/// Deviates beyond this carry a probability below 1e-18.
const DEVIATE_LIMIT: f64 = 9.0;

/// Around the value of an input that does not scatter, relative to it.
const AROUND: f64 = 1e-9;

/// Between which values of an input nearly all samples lie: all but 2e-19 of them. About one that does not scatter it is a
/// little wider than a point.
#[must_use]
pub fn reach(input: &InputDistribution, law: DeviateLaw) -> [f64; 2] {
    let [a, b] = [-DEVIATE_LIMIT, DEVIATE_LIMIT].map(|deviate| input.value(law.mean + law.std * deviate));
    let around = if a == b { AROUND * if a == 0.0 { 1.0 } else { a.abs() } } else { 0.0 };
    [a.min(b) - around, a.max(b) + around]
}

/// The deviates at which a search for unstable values begins.
const PLACES: [f64; 13] = [-DEVIATE_LIMIT, -6.5, -4.5, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.5, 6.5, DEVIATE_LIMIT];

/// Places nearer to others than this part of the way to their own neighbours are left out.
const NEAR: f64 = 0.4;

/// Values, in rising order, between which a search for unstable values begins, over the reaches of all these inputs: so many
/// that none of the intervals between them has most of the probability of an input.
#[must_use]
pub fn places(inputs: &[(InputDistribution, DeviateLaw)]) -> Vec<f64> {
    let reaches = inputs.iter().map(|(input, law)| reach(input, *law));
    let [low, high] =
        reaches.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], reach| [low.min(reach[0]), high.max(reach[1])]);
    let mut places = vec![low, high];
    for (input, law) in inputs {
        let mut own = PLACES.map(|deviate| input.value(law.mean + law.std * deviate));
        own.sort_by(f64::total_cmp);
        for three in own.windows(3) {
            let near = NEAR * (three[1] - three[0]).min(three[2] - three[1]);
            let next = places.partition_point(|place| *place < three[1]);
            let is_free = |place: Option<&f64>| place.is_none_or(|place| (place - three[1]).abs() > near);
            if is_free(places.get(next)) && is_free(next.checked_sub(1).map(|before| &places[before])) {
                places.insert(next, three[1]);
            }
        }
    }
    places
}

/// The probability that an input has one of its unstable values, which were looked for within its reach. The error bound
/// covers values that are possibly unstable.
#[must_use]
pub fn probability(input: &InputDistribution, law: DeviateLaw, unstable: &UnstableValues) -> ExactProbability {
    let reach = reach(input, law);
    // A sum of nothing is -0.
    let of = |set: &[[f64; 2]]| 0.0 + set.iter().map(|interval| share(input, law, *interval, reach)).sum::<f64>();
    let (low, high) = (of(&unstable.surely), of(&unstable.possibly));
    let value = (0.5 * (low + high)).clamp(0.0, 1.0);
    ExactProbability { value, error_bound: 0.5 * (high - low).abs() + 4.0 * f64::EPSILON * value }
}

/// The probability of an interval of values; one that ends where the input's reach does has all values beyond.
fn share(input: &InputDistribution, law: DeviateLaw, [from, to]: [f64; 2], reach: [f64; 2]) -> f64 {
    let from = if from <= reach[0] { f64::NEG_INFINITY } else { from };
    let to = if to >= reach[1] { f64::INFINITY } else { to };
    let argument = |value: f64, end: End| match value.is_finite() {
        true => (input.deviate(value, end) - law.mean) / law.std,
        false => value,
    };
    // More of an input with a negative expected value has a smaller deviate.
    let is_rising = input.value(1.0) >= input.value(-1.0);
    let [least, most] = if is_rising {
        [argument(from, End::Least), argument(to, End::Greatest)]
    } else {
        let beyond = |argument: f64| if argument.is_infinite() { -argument } else { argument };
        [beyond(argument(to, End::Least)), beyond(argument(from, End::Greatest))]
    };
    if least >= most {
        0.0
    } else if least > 0.0 {
        normal::upper_tail(least) - normal::upper_tail(most)
    } else {
        normal::upper_tail(-most) - normal::upper_tail(-least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::Marginal;

    const FREE: DeviateLaw = DeviateLaw { mean: 0.0, std: 1.0 };

    fn unstable(set: &[[f64; 2]]) -> UnstableValues {
        UnstableValues { surely: set.to_vec(), possibly: set.to_vec() }
    }

    #[test]
    fn a_normal_input_has_its_tails() {
        for expected in [2.0, -2.0] {
            let input = InputDistribution::absolute(&Marginal::Normal, expected, 0.5);
            let [low, high] = reach(&input, FREE);
            assert!((low - (expected - 4.5)).abs() < 1e-12 && (high - (expected + 4.5)).abs() < 1e-12);
            let above = probability(&input, FREE, &unstable(&[[expected + 2.5, high]])).value;
            assert!((above / normal::upper_tail(5.0) - 1.0).abs() < 1e-12, "{above}");
            let between = probability(&input, FREE, &unstable(&[[expected - 0.5, expected + 1.0]])).value;
            assert!((between - (normal::upper_tail(-2.0) - normal::upper_tail(1.0))).abs() < 1e-15);
            assert_eq!(probability(&input, FREE, &unstable(&[[low, high]])).value, 1.0);
            let none = probability(&input, FREE, &UnstableValues::default()).value;
            assert!(none == 0.0 && none.is_sign_positive(), "{none}");
        }
        // Relative to a negative expected value, larger deviates are smaller values.
        let input = InputDistribution::relative(&Marginal::Normal, -2.0, 0.25);
        let above = probability(&input, FREE, &unstable(&[[-1.0, reach(&input, FREE)[1]]])).value;
        assert!((above / normal::upper_tail(2.0) - 1.0).abs() < 1e-12, "{above}");
        let below = probability(&input, FREE, &unstable(&[[reach(&input, FREE)[0], -3.0]])).value;
        assert!((below / normal::upper_tail(2.0) - 1.0).abs() < 1e-12, "{below}");
    }

    #[test]
    fn what_is_known_of_others_moves_and_narrows_it() {
        let input = InputDistribution::relative(&Marginal::Lognormal, 1.0, 0.3);
        let law = DeviateLaw { mean: 0.6, std: 0.8 };
        let critical = input.value(2.0);
        let found = probability(&input, law, &unstable(&[[critical, reach(&input, law)[1]]])).value;
        assert!((found / normal::upper_tail(1.4 / 0.8) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_possibly_unstable_is_the_error() {
        let input = InputDistribution::absolute(&Marginal::Normal, 0.0, 1.0);
        let set = UnstableValues { surely: vec![[1.0, 9.0]], possibly: vec![[0.9, 9.0]] };
        let ExactProbability { value, error_bound } = probability(&input, FREE, &set);
        let ends = [1.0, 0.9].map(normal::upper_tail);
        assert!((value - 0.5 * (ends[0] + ends[1])).abs() < 1e-15);
        assert!((error_bound - 0.5 * (ends[1] - ends[0])).abs() < 1e-14);
    }

    #[test]
    fn an_input_that_does_not_scatter_is_unstable_or_not() {
        let input = InputDistribution::fixed(2.0);
        let [low, high] = reach(&input, FREE);
        assert!(low < 2.0 && high > 2.0 && high - low < 1e-8);
        assert_eq!(probability(&input, FREE, &unstable(&[[1.0, 3.0]])).value, 1.0);
        assert_eq!(probability(&input, FREE, &unstable(&[[2.5, 3.0]])).value, 0.0);
    }
}
