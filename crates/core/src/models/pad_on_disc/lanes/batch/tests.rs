use super::*;
use crate::friction::law::LawKind;
use crate::friction::measured_curve::{MeasuredCurve, SharedCurve};
use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use crate::models::pad_on_disc::criterion::time_domain::DiscModel;
use crate::models::pad_on_disc::lanes::flexible::LANES as FLEXIBLE_LANES;
use crate::models::pad_on_disc::lanes::rigid::LANES;
use crate::models::pad_on_disc::motion::start::Start;
use crate::models::pad_on_disc::parameters::{Parameters, scalar};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, uniform_draws};

/// Inputs all over the plane, in no order: deep in either region, near the boundary, outside physics.
fn inputs(count: usize) -> Vec<RandomInputs> {
    let mut state = 88_172_645_463_325_252_u64;
    let mut draw = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count).map(|_| RandomInputs { preload: 0.4 * draw() - 0.01, static_friction: 0.2 + 0.4 * draw() }).collect()
}

fn criterion(disc: &DiscModel, settings: TimeDomainSettings, changes: &[(&str, f64)]) -> TimeDomain {
    TimeDomain::new(&PadOnDisc::preset_with(changes), disc, settings).unwrap()
}

#[track_caller]
fn assert_lanes_agree(criterion: &TimeDomain, inputs: &[RandomInputs]) -> [usize; 4] {
    let expected: Vec<Decision> = inputs.iter().map(|&inputs| criterion.decide(inputs)).collect();
    for set in InstructionSet::available() {
        let found = criterion.decide_all_with(inputs, set);
        for ((inputs, expected), found) in inputs.iter().zip(&expected).zip(&found) {
            let bits = |decision: &Decision| {
                (decision.verdict, decision.time.to_bits(), decision.recorded[0].map(f64::to_bits))
            };
            assert_eq!(bits(found), bits(expected), "{set:?} {inputs:?} {found:?} {expected:?}");
        }
    }
    let mut seen = [0; 4];
    expected.iter().for_each(|decision| seen[decision.verdict as usize] += 1);
    seen
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn every_lane_has_the_bits_of_the_scalar_code() {
    for (disc, count) in [(DiscModel::Rigid, 3000), (DiscModel::Flexible { modes: 5 }, 500)] {
        for start in [Start::NearEquilibrium, Start::Rest, Start::LimitCycle] {
            for record_amplitude in [false, true] {
                // The settled amplitude keeps its bits only if every step did.
                let settings = TimeDomainSettings { start, record_amplitude, ..Default::default() };
                let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 15.0)]);
                let count = if record_amplitude { count / 5 } else { count };
                let seen = assert_lanes_agree(&criterion, &inputs(count));
                assert!(seen[0] > count / 10 && seen[1] > count / 10, "{seen:?}");
            }
        }
    }
}

#[test]
fn lanes_agree_at_the_horizon_and_in_breakdown_too() {
    for disc in [DiscModel::Rigid, DiscModel::Flexible { modes: 4 }] {
        let settings = TimeDomainSettings { horizon: 4.0, start: Start::Rest, ..Default::default() };
        let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 25.0)]);
        let mut inputs = inputs(300);
        for i in (0..300).step_by(17) {
            inputs[i] = RandomInputs { preload: 0.1 * i as f64, static_friction: f64::NAN };
        }
        let seen = assert_lanes_agree(&criterion, &inputs);
        assert!(seen[Verdict::Undecided as usize] > 10 && seen[Verdict::Failed as usize] > 10, "{seen:?}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn other_discs_patches_and_exponents_agree_as_well() {
    let settings = TimeDomainSettings::default();
    for changes in [
        // A soft contact with a wide pad, which tilts far.
        [("stiffness.calliper_angular", 1.2e3), ("pad.half_angle", 1.2)],
        [("friction.stribeck_exponent", 2.0), ("operating_point.rotating_speed", 9.0)],
        [("disc.inner_radius", 0.03), ("operating_point.rotating_speed", 12.0)],
    ] {
        for disc in [DiscModel::Rigid, DiscModel::Flexible { modes: 7 }] {
            assert_lanes_agree(&criterion(&disc, settings, &changes), &inputs(60));
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn motions_that_meet_no_friction_have_the_bits_of_the_scalar_code() {
    let (rows, deviations) = ([0.45, 0.38, 0.3, 0.28], [0.02, 0.05, 0.08, 0.08]);
    let curve = MeasuredCurve::new(&[0.0, 0.5, 2.0, 5.0], &rows, Some(&deviations)).unwrap();
    let mut parameters = Parameters::sui_ding_2018();
    parameters.friction.use_table(SharedCurve::new(curve));
    parameters.friction.band = -2.5;
    parameters.operating_point.rotating_speed = 6.0;
    let brake = PadOnDisc::new(parameters).unwrap();
    for (disc, count) in [(DiscModel::Rigid, 400), (DiscModel::Flexible { modes: 5 }, 60)] {
        let settings = TimeDomainSettings { start: Start::Rest, ..Default::default() };
        let criterion = TimeDomain::new(&brake, &disc, settings).unwrap();
        let inputs = inputs(count);
        let seen = assert_lanes_agree(&criterion, &inputs);
        assert!(seen[0] > count / 10 && seen[1] > count / 20, "{seen:?}");
        let inside = inputs.iter().filter(|inputs| !brake.is_outside_physics(**inputs));
        let outside = inside.filter(|inputs| criterion.meets_no_friction(**inputs));
        assert!(outside.count() > count / 20);
    }
}

#[test]
fn outcomes_are_pinned() {
    // Regression values, the same on every architecture: an FNV-1a hash of every verdict, time and amplitude.
    let settings = TimeDomainSettings { record_amplitude: true, start: Start::Rest, ..Default::default() };
    let hashes = [DiscModel::Rigid, DiscModel::Flexible { modes: 5 }].map(|disc| {
        let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 15.0)]);
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for decision in criterion.decide_all(&inputs(40)) {
            for word in [decision.verdict as u64, decision.time.to_bits(), decision.recorded[0].map_or(0, f64::to_bits)]
            {
                for byte in word.to_le_bytes() {
                    hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
                }
            }
        }
        hash
    });
    assert_eq!(hashes, [17_903_389_124_153_164_030, 1_000_063_740_259_384_411]);
}

#[test]
fn the_list_may_be_of_any_length() {
    let criterion =
        criterion(&DiscModel::Rigid, TimeDomainSettings::default(), &[("operating_point.rotating_speed", 15.0)]);
    for count in [0, 1, 2, LANES - 1, LANES, LANES + 1, 3 * LANES + 7] {
        assert_lanes_agree(&criterion, &inputs(count));
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn lanes_agree_where_the_pad_lifts_off() {
    // Thrown back from the calliper, the pad leaves the disc in part before it comes to rest or to stick-slip.
    let settings = TimeDomainSettings { displacement: 150.0, record_amplitude: true, ..Default::default() };
    let disc = DiscModel::Flexible { modes: 5 };
    let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 20.0)]);
    let inputs: Vec<RandomInputs> = (0..FLEXIBLE_LANES)
        .map(|i| RandomInputs { preload: 0.05 + 0.01 * i as f64, static_friction: 0.3 + 0.01 * i as f64 })
        .collect();
    for &inputs in inputs.iter().step_by(5) {
        let trajectory = criterion.trajectory(inputs, 3.0).unwrap();
        let lifts_off = trajectory.moments.iter().any(|moment| !moment.sticks && moment.contact_share < 0.9);
        assert!(lifts_off, "{inputs:?}");
    }
    let seen = assert_lanes_agree(&criterion, &inputs);
    assert!(
        seen[Verdict::Unstable as usize] > 3,
        "their settled amplitude keeps its bits only if every step did: {seen:?}"
    );
}

/// A queue of samples that may each have a brake of their own, and their decisions. It stops after some of them.
struct Listed<'q> {
    samples: std::vec::IntoIter<QueuedSample<'q>>,
    decisions: Vec<Option<Decision>>,
    stops_after: usize,
}

impl<'q> Listed<'q> {
    fn new(samples: Vec<QueuedSample<'q>>) -> Self {
        Self { decisions: vec![None; samples.len()], samples: samples.into_iter(), stops_after: usize::MAX }
    }
}

impl<'q> SampleQueue<'q> for Listed<'q> {
    fn next(&mut self) -> Option<QueuedSample<'q>> {
        self.samples.next()
    }

    fn decided(&mut self, ticket: u64, decision: Decision) {
        assert_eq!(self.decisions[ticket as usize].replace(decision), None, "each sample is decided once");
    }

    fn is_stopped(&self) -> bool {
        self.decisions.iter().flatten().count() >= self.stops_after
    }
}

fn bits(decision: &Decision) -> (Verdict, u64, Option<u64>) {
    (decision.verdict, decision.time.to_bits(), decision.recorded[0].map(f64::to_bits))
}

#[track_caller]
fn assert_queue_agrees(samples: &[QueuedSample<'_>]) -> [usize; 4] {
    let expected: Vec<Decision> = samples.iter().map(|sample| sample.clone().decide()).collect();
    for set in InstructionSet::available() {
        let mut queue = Listed::new(samples.to_vec());
        decide_queue_with(&mut queue, set);
        for (sample, (expected, found)) in samples.iter().zip(expected.iter().zip(&queue.decisions)) {
            let found = found.as_ref().expect("every sample is decided");
            assert_eq!(bits(found), bits(expected), "{set:?} {sample:?} {found:?} {expected:?}");
        }
    }
    let mut seen = [0; 4];
    expected.iter().for_each(|decision| seen[decision.verdict as usize] += 1);
    seen
}

/// Parameters that leave the geometry of disc and pad alone.
const SCATTERING: [&str; 14] = [
    "disc.thickness",
    "disc.youngs_modulus",
    "disc.density",
    "disc.transverse_damping_ratio",
    "pad.mass",
    "stiffness.contact_normal",
    "stiffness.calliper_normal",
    "stiffness.contact_tangential_2",
    "stiffness.calliper_tangential",
    "stiffness.calliper_angular",
    "damping.tangential",
    "friction.kinetic_coefficient",
    "friction.stribeck_velocity",
    "operating_point.rotating_speed",
];

/// Brakes with all of these and their inputs scattering, around the brake of a criterion.
fn brakes<'q>(criterion: &'q TimeDomain, keys: &[&str], count: u64) -> Vec<QueuedSample<'q>> {
    let starts = [Start::NearEquilibrium, Start::Rest, Start::LimitCycle];
    let mut draw = uniform_draws(count);
    let mut sample = |ticket: u64| {
        let mut around = |value: f64| value * (0.75 + 0.5 * draw());
        let mut parameters = criterion.brake.parameters().clone();
        for key in keys {
            let value = scalar(key).unwrap().value(&parameters);
            parameters.set(key, around(value)).unwrap();
        }
        let inputs = RandomInputs { preload: around(0.12), static_friction: around(0.36) };
        parameters.friction.static_coefficient = inputs.static_friction.max(parameters.friction.kinetic_coefficient);
        let brake = (!ticket.is_multiple_of(5)).then(|| PadOnDisc::new(parameters).unwrap());
        QueuedSample { ticket, criterion, brake, inputs, start: starts[(ticket % 3) as usize] }
    };
    (0..count).map(&mut sample).collect()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn every_lane_has_the_bits_of_its_own_brake() {
    for (disc, count) in [(DiscModel::Rigid, 600), (DiscModel::Flexible { modes: 5 }, 90)] {
        let settings = TimeDomainSettings { horizon: 300.0, record_amplitude: true, ..Default::default() };
        let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 18.0)]);
        let seen = assert_queue_agrees(&brakes(&criterion, &SCATTERING, count));
        assert!(seen[0] > 15 && seen[1] > 15, "{seen:?}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn every_friction_law_has_the_bits_of_the_scalar_code() {
    let table = || {
        let rows = [0.0, 0.3, 0.8, 1.5, 3.0, 6.0];
        let curve = MeasuredCurve::new(&rows, &[0.45, 0.40, 0.33, 0.28, 0.29, 0.31], Some(&[0.02; 6])).unwrap();
        LawKind::Table(SharedCurve::new(curve))
    };
    let laws: [(LawKind, &[(&str, f64)]); 6] = [
        (LawKind::Stribeck, &[("friction.stribeck_exponent", 1.0), ("friction.viscous", 0.002)]),
        (LawKind::Stribeck, &[("friction.stribeck_exponent", 2.0)]),
        (LawKind::Stribeck, &[("friction.stribeck_exponent", 0.7)]),
        (LawKind::Stribeck, &[("friction.stribeck_exponent", 1.6), ("friction.viscous", 0.002)]),
        (LawKind::Rational, &[]),
        (table(), &[]),
    ];
    for (law, changes) in laws {
        for (disc, count) in [(DiscModel::Rigid, 130), (DiscModel::Flexible { modes: 5 }, 24)] {
            let mut parameters = PadOnDisc::preset_with(changes).parameters().clone();
            parameters.friction.law = law;
            parameters.operating_point.rotating_speed = 14.0;
            let brake = PadOnDisc::new(parameters).unwrap();
            let settings = TimeDomainSettings { horizon: 200.0, ..Default::default() };
            let criterion = TimeDomain::new(&brake, &disc, settings).unwrap();
            let keys = ["stiffness.calliper_tangential", "damping.tangential", "operating_point.rotating_speed"];
            let samples = brakes(&criterion, &keys, count);
            assert_queue_agrees(&samples);
            if let LawKind::Stribeck = law
                && criterion.brake.friction_law().exponent == 1.6
            {
                let keys = ["friction.stribeck_exponent", "friction.viscous", "friction.stribeck_velocity"];
                assert_queue_agrees(&brakes(&criterion, &keys, count));
            }
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn discs_of_another_geometry_are_simulated_one_by_one_in_the_same_queue() {
    let settings = TimeDomainSettings { horizon: 100.0, ..Default::default() };
    let criterion = criterion(&DiscModel::Flexible { modes: 5 }, settings, &[("operating_point.rotating_speed", 18.0)]);
    let keys = ["pad.half_angle", "disc.inner_radius", "damping.tangential"];
    assert_queue_agrees(&brakes(&criterion, &keys, 12));
}

#[test]
fn criteria_of_several_speeds_share_lanes() {
    for (disc, count) in [(DiscModel::Rigid, 300), (DiscModel::Flexible { modes: 5 }, 45)] {
        let at =
            |speed: f64| criterion(&disc, TimeDomainSettings::default(), &[("operating_point.rotating_speed", speed)]);
        let criteria = [at(12.0), at(18.0), at(25.0)];
        let samples = (0_u64..).zip(inputs(count));
        let samples: Vec<QueuedSample<'_>> =
            samples.map(|(ticket, inputs)| QueuedSample::new(ticket, &criteria[ticket as usize % 3], inputs)).collect();
        assert_queue_agrees(&samples);
    }
}

#[test]
fn a_queue_that_stops_drops_what_is_not_decided() {
    let settings = TimeDomainSettings { start: Start::Rest, ..Default::default() };
    let criterion = criterion(&DiscModel::Rigid, settings, &[("operating_point.rotating_speed", 20.0)]);
    let samples = (0_u64..).zip(inputs(4000));
    let samples = samples.map(|(ticket, inputs)| QueuedSample::new(ticket, &criterion, inputs)).collect();
    let mut queue = Listed { stops_after: 300, ..Listed::new(samples) };
    decide_queue(&mut queue);
    let decided = queue.decisions.iter().flatten().count();
    assert!((300..2000).contains(&decided), "{decided}");
}

#[test]
fn what_is_stopped_has_no_decision_or_the_right_one() {
    for (disc, count, questions) in [(DiscModel::Rigid, 300, 310), (DiscModel::Flexible { modes: 5 }, 40, 60)] {
        let settings = TimeDomainSettings { start: Start::Rest, ..Default::default() };
        let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 15.0)]);
        let inputs = inputs(count);
        let expected = criterion.decide_all(&inputs);
        for questions in [0, 1, questions / 2, questions] {
            let asked = Cell::new(0);
            let found = criterion.decide_until(&inputs, &|| {
                asked.set(asked.get() + 1);
                asked.get() > questions
            });
            assert_eq!(found.len(), count);
            let missing = found.iter().filter(|decision| decision.is_none()).count();
            assert!(missing > 0 && (questions > 1 || missing == count), "{questions} questions: {missing} missing");
            for (found, expected) in found.iter().zip(&expected) {
                assert!(found.is_none_or(|found| found == *expected), "{found:?} {expected:?}");
            }
        }
        let all = criterion.decide_until(&inputs, &|| false);
        assert!(all.iter().zip(&expected).all(|(found, expected)| *found == Some(*expected)));
    }
}
