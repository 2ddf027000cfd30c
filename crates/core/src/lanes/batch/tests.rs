use super::*;
use crate::criterion::settings::TimeDomainSettings;
use crate::criterion::time_domain::DiscModel;
use crate::lanes::flexible::LANES as FLEXIBLE_LANES;
use crate::lanes::rigid::LANES;
use crate::motion::start::Start;
use crate::rigid_disc::pad_on_disc::PadOnDisc;
use crate::verdict::Verdict;

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
            let bits =
                |decision: &Decision| (decision.verdict, decision.time.to_bits(), decision.amplitude.map(f64::to_bits));
            assert_eq!(bits(found), bits(expected), "{set:?} {inputs:?} {found:?} {expected:?}");
        }
    }
    let mut seen = [0; 4];
    expected.iter().for_each(|decision| seen[decision.verdict as usize] += 1);
    seen
}

#[test]
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
fn outcomes_are_pinned() {
    // Regression values, the same on every architecture: an FNV-1a hash of every verdict, time and amplitude.
    let settings = TimeDomainSettings { record_amplitude: true, start: Start::Rest, ..Default::default() };
    let hashes = [DiscModel::Rigid, DiscModel::Flexible { modes: 5 }].map(|disc| {
        let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 15.0)]);
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for decision in criterion.decide_all(&inputs(40)) {
            for word in [decision.verdict as u64, decision.time.to_bits(), decision.amplitude.map_or(0, f64::to_bits)] {
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
