//! Coverage of the intervals of `fit`, by simulation: the share of 500 synthetic sets of tests whose intervals contain
//! the truth. Each case is a line with the share for the expected static friction, for its standard deviation and for a
//! predicted probability, and how many sets were refused because they do not determine the parameters.
//!
//! `make coverage` runs it. Sets are seeded.

#![allow(clippy::print_stdout, clippy::disallowed_methods, reason = "a table for people")]
#![allow(clippy::unwrap_used, reason = "a table that cannot be made should say so and stop")]

use rand::{RngExt as _, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::fit::{FitModel, FitValues, TestData, fit};
use stickslip_sampler::inputs::{InputDistribution, Marginal, PairLaw, PairParameter};
use stickslip_sampler::integrate::pair::Pair;
use stickslip_sampler::special_functions::normal;

/// Sets of each case.
const SETS: u64 = 500;

/// How tests are made.
struct Case {
    name: &'static str,
    marginal: Marginal,
    preload_std: f64,
    correlation: f64,
    preloads: &'static [f64],
    /// Rotating speeds of verdicts; of onset speeds the lowest to which the speed is lowered.
    speeds: &'static [f64],
    /// Tests in each condition.
    each: u64,
    has_onsets: bool,
}

const CASES: [Case; 4] = [
    Case {
        name: "240 verdicts at 6 speeds, friction scatters",
        marginal: Marginal::Normal,
        preload_std: 0.0,
        correlation: 0.0,
        preloads: &[0.1],
        speeds: &[13.0, 14.0, 15.0, 16.0, 17.0, 18.0],
        each: 40,
        has_onsets: false,
    },
    Case {
        name: "150 verdicts, two speeds of five between none and all",
        marginal: Marginal::Normal,
        preload_std: 0.0,
        correlation: 0.0,
        preloads: &[0.1],
        speeds: &[12.0, 14.0, 16.0, 18.0, 20.0],
        each: 30,
        has_onsets: false,
    },
    Case {
        name: "300 verdicts at 3 preloads, both scatter, correlated",
        marginal: Marginal::Normal,
        preload_std: 0.1,
        correlation: 0.3,
        preloads: &[0.07, 0.1, 0.14],
        speeds: &[13.0, 15.0, 17.0, 19.0],
        each: 25,
        has_onsets: false,
    },
    Case {
        name: "24 onset speeds, some censored, both scatter, lognormal",
        marginal: Marginal::Lognormal,
        preload_std: 0.1,
        correlation: 0.0,
        preloads: &[0.07, 0.1, 0.14],
        speeds: &[13.0],
        each: 8,
        has_onsets: true,
    },
];

/// The truth.
const FRICTION: f64 = 0.4;
const FRICTION_STD: f64 = 0.08;

/// Where the probability is predicted.
const PREDICTED: [f64; 2] = [18.0, 0.1];

fn brake(rotating_speed: f64, preload: f64, static_friction: f64) -> PadOnDisc {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", rotating_speed).unwrap();
    parameters.set("operating_point.preload", preload).unwrap();
    parameters.set("friction.static_coefficient", static_friction).unwrap();
    PadOnDisc::new(parameters).unwrap()
}

impl Case {
    fn tests(&self, seed: u64) -> TestData {
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut deviate = || normal::quantile(generator.random_range(1e-15..1.0));
        let preload_of = |nominal: f64| InputDistribution::relative(&self.marginal, nominal, self.preload_std);
        let friction_of = InputDistribution::relative(&self.marginal, FRICTION, FRICTION_STD);
        let rest = (1.0 - self.correlation * self.correlation).sqrt();
        let mut data = TestData::default();
        for &nominal in self.preloads {
            for &speed in self.speeds {
                let at_speed = brake(speed, nominal, FRICTION).stability_boundary();
                for _ in 0..self.each {
                    let (first, second) = (deviate(), deviate());
                    let preload = if self.preload_std > 0.0 { preload_of(nominal).value(first) } else { nominal };
                    let friction = friction_of.value(self.correlation * first + rest * second);
                    let is_unstable = friction > at_speed.critical_second(preload);
                    if !self.has_onsets || !is_unstable {
                        data.add_verdict(nominal, &at_speed, is_unstable, 1);
                        continue;
                    }
                    let onset = brake(speed, preload, friction).unstable_speeds().last().unwrap().to;
                    let ends = [onset * (1.0 - 1e-5), onset * (1.0 + 1e-5)];
                    let boundaries = ends.map(|speed| brake(speed, nominal, FRICTION).stability_boundary());
                    data.add_onset(nominal, boundaries, ends);
                }
            }
        }
        data
    }

    fn model(&self) -> FitModel {
        let values =
            FitValues { expected: [1.0, 0.45], relative_std: [self.preload_std, 0.1], correlation: self.correlation };
        let names = ["preload", "static_friction"].map(str::to_owned);
        FitModel { names, marginals: [self.marginal.clone(), self.marginal.clone()], values }
    }

    fn predicted(&self) -> f64 {
        let [speed, preload] = PREDICTED;
        let preload = if self.preload_std > 0.0 {
            InputDistribution::relative(&self.marginal, preload, self.preload_std)
        } else {
            InputDistribution::fixed(preload)
        };
        let friction = InputDistribution::relative(&self.marginal, FRICTION, FRICTION_STD);
        let boundary = brake(speed, 0.1, FRICTION).stability_boundary();
        Pair::new(preload, friction).probability(&boundary, &PairLaw::correlated(self.correlation), 1e-12)
    }
}

fn main() {
    println!("Coverage of 95 % intervals of fit: the share of {SETS} sets of tests whose intervals contain the truth");
    println!("{:<58} {:>8} {:>8} {:>8} {:>8}", "", "f_s", "std", "P", "refused");
    let [speed, preload] = PREDICTED;
    for case in &CASES {
        let truth = case.predicted();
        let at = brake(speed, preload, FRICTION).stability_boundary();
        let (model, mut covered, mut given) = (case.model(), [0_u32; 3], 0_u32);
        for seed in 0..SETS {
            let data = case.tests(seed);
            let estimated = [PairParameter::Expected(1), PairParameter::RelativeStd(1)];
            let Ok(fit) = fit(&model, &data, &estimated, 0.95) else { continue };
            given += 1;
            let prediction = fit.predict(preload, &at);
            let ends =
                |i: usize| (fit.parameters[i].low.unwrap_or(0.0), fit.parameters[i].high.unwrap_or(f64::INFINITY));
            let intervals = [ends(0), ends(1), (prediction.low, prediction.high)];
            for (covered, ((low, high), truth)) in
                covered.iter_mut().zip(intervals.into_iter().zip([FRICTION, FRICTION_STD, truth]))
            {
                *covered += u32::from(low <= truth && truth <= high);
            }
        }
        let [friction, std, probability] = covered.map(|covered| f64::from(covered) / f64::from(given));
        let refused = SETS - u64::from(given);
        println!("{:<58} {friction:>8.3} {std:>8.3} {probability:>8.3} {refused:>8}", case.name);
    }
}
