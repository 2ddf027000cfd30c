//! Where stick-slip on a flexible disc ends, errors of the steps move that end by up to 5e-3 of the speed. Verdicts there
//! come from finer steps.

use std::cell::Cell;

use super::*;
use crate::models::pad_on_disc::parameters::Parameters;

/// A brake of `benches/validity` whose end of stick-slip moves, and the speed at which it ends with steps of an eighth
/// of the length, rad/s. Regression values; those with steps of a quarter differ by less than 1e-5.
struct Brake {
    changed: &'static [(&'static str, f64)],
    end: f64,
}

/// With the steps in use, stick-slip of these ends 3.2e-4, 1.7e-3 and 5.0e-3 below that speed: the first is drawn to the
/// disc by steep friction or not, the others touch its speed.
const BRAKES: [Brake; 3] = [
    Brake {
        changed: &[
            ("disc.youngs_modulus", 62318922841.94136),
            ("disc.thickness", 0.025234977766119052),
            ("disc.transverse_damping_ratio", 0.01917450040538814),
            ("stiffness.calliper_tangential", 73389884.2034025),
            ("stiffness.calliper_normal", 30597877.92120189),
            ("stiffness.calliper_angular", 20120.887952575747),
            ("stiffness.contact_normal", 20548281.896178626),
            ("stiffness.contact_tangential_1", 7207388.922081382),
            ("stiffness.contact_tangential_2", 40285222.49589124),
            ("damping.tangential", 353.780749080371),
            ("damping.normal", 109.07206623553805),
            ("damping.angular", 0.25590644302732884),
            ("friction.static_coefficient", 0.8681843600289015),
            ("friction.kinetic_coefficient", 0.39305095222602926),
            ("friction.stribeck_velocity", 0.34687632032260907),
            ("operating_point.preload", 0.11648855919087256),
        ],
        end: 242.6129,
    },
    Brake {
        changed: &[
            ("disc.youngs_modulus", 45565777002.159485),
            ("disc.thickness", 0.015467905260256602),
            ("disc.transverse_damping_ratio", 0.028745335439593952),
            ("stiffness.calliper_tangential", 54217041.82587817),
            ("stiffness.calliper_normal", 45884800.41574256),
            ("stiffness.calliper_angular", 28017.709543054003),
            ("stiffness.contact_normal", 15799201.0391888),
            ("stiffness.contact_tangential_1", 17027669.98259344),
            ("stiffness.contact_tangential_2", 11670989.066629872),
            ("damping.tangential", 126.86993725452272),
            ("damping.normal", 69.3896644390686),
            ("damping.angular", 0.05203399884462619),
            ("friction.static_coefficient", 0.37415973470251335),
            ("friction.kinetic_coefficient", 0.1534539368356786),
            ("friction.stribeck_velocity", 0.12067812898968953),
            ("friction.stribeck_exponent", 2.0),
            ("operating_point.preload", 0.11347650847884161),
        ],
        end: 23.72774,
    },
    Brake {
        changed: &[
            ("disc.youngs_modulus", 105326570457.49652),
            ("disc.thickness", 0.02148509417608816),
            ("disc.transverse_damping_ratio", 0.01707581145796948),
            ("stiffness.calliper_tangential", 17455763.3678562),
            ("stiffness.calliper_normal", 24602946.091526154),
            ("stiffness.calliper_angular", 17486.856228671833),
            ("stiffness.contact_normal", 51207789.1596778),
            ("stiffness.contact_tangential_1", 63386183.716129914),
            ("stiffness.contact_tangential_2", 56597377.1570284),
            ("damping.tangential", 19.552929297300103),
            ("damping.normal", 180.6348377693248),
            ("damping.angular", 0.19512248375091604),
            ("friction.static_coefficient", 0.3087112201431449),
            ("friction.kinetic_coefficient", 0.15607654237910976),
            ("friction.stribeck_velocity", 0.05358092557829669),
            ("friction.stribeck_exponent", 0.7),
            ("operating_point.preload", 0.02118883830222099),
        ],
        end: 33.2382,
    },
];

/// Relative distances from the end.
const DISTANCES: [f64; 10] = [-1e-2, -3e-3, -1e-3, -3e-4, -1e-4, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2];

impl Brake {
    fn at(&self, speed: f64) -> (TimeDomain, RandomInputs) {
        let mut parameters = Parameters::sui_ding_2018();
        for (key, value) in self.changed {
            parameters.set(key, *value).unwrap();
        }
        parameters.operating_point.rotating_speed = speed;
        let inputs = RandomInputs {
            preload: parameters.operating_point.preload,
            static_friction: parameters.friction.static_coefficient,
        };
        let settings = TimeDomainSettings { start: Start::LimitCycle, ..Default::default() };
        (TimeDomain::new(&PadOnDisc::new(parameters).unwrap(), &FLEXIBLE, settings).unwrap(), inputs)
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn verdicts_on_flexible_discs_are_right_or_undecided_about_the_end_of_stick_slip() {
    let mut decided = 0;
    for brake in &BRAKES {
        for distance in DISTANCES {
            let (criterion, inputs) = brake.at(brake.end * (1.0 + distance));
            let right = if distance < 0.0 { Verdict::Unstable } else { Verdict::Stable };
            let decision = criterion.decide(inputs);
            let context = format!("{} rad/s, {distance:e} from the end", brake.end);
            assert!([right, Verdict::Undecided].contains(&decision.verdict), "{context}: {decision:?}");
            decided += u32::from(decision.verdict == right);
            assert_eq!(criterion.decide_all(&[inputs; 20]), vec![decision; 20], "{context}");
            if distance.abs() == 1e-4 {
                let finer = criterion.with_steps_divided_by(4.0).decide(inputs).verdict;
                assert!([right, Verdict::Undecided].contains(&finer), "{context}: {finer:?} with finer steps");
            }
        }
    }
    assert!(decided >= 27, "{decided} of 30 decided");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn what_is_stopped_while_it_is_simulated_again_has_no_decision_or_the_right_one() {
    let (criterion, inputs) = BRAKES[1].at(BRAKES[1].end * 1.0005);
    let samples: Vec<RandomInputs> = (0..5)
        .map(|i| RandomInputs { static_friction: inputs.static_friction * (1.0 + 1e-5 * f64::from(i)), ..inputs })
        .collect();
    let expected = criterion.decide_all(&samples);
    let (mut most, mut questions) = (0, 0);
    while most < samples.len() {
        let asked = Cell::new(0);
        let found = criterion.decide_until(&samples, &|| {
            asked.set(asked.get() + 1);
            asked.get() > questions
        });
        for (found, expected) in found.iter().zip(&expected) {
            assert!(found.is_none_or(|found| found == *expected), "{questions} questions: {found:?} {expected:?}");
        }
        most = found.iter().flatten().count();
        questions += 1;
    }
    assert!(questions > 20, "{questions} questions");
}
