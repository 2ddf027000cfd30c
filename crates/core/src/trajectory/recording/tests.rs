use super::*;
use crate::criterion::time_domain::DiscModel;
use crate::motion::start::Start;
use crate::rigid_disc::pad_on_disc::PadOnDisc;

const NOMINAL: RandomInputs = RandomInputs { preload: 0.1, static_friction: 0.39 };

fn criterion(speed: f64, disc: &DiscModel, start: Start) -> TimeDomain {
    let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]);
    TimeDomain::new(&brake, disc, TimeDomainSettings { start, ..Default::default() }).unwrap()
}

#[test]
fn settled_motions_on_a_rigid_disc_are_those_of_the_table() {
    // Physics notes, section 7.
    let table = [
        (10.0, 3.56373, 0.014309, 0.003465, 0.3756),
        (15.56, 3.21741, 0.015334, 0.002579, 0.2556),
        (20.0, 3.10909, 0.016207, 0.001879, 0.1873),
    ];
    for (speed, period, largest, smallest, stick) in table {
        let criterion = criterion(speed, &DiscModel::Rigid, Start::Rest);
        let settled = criterion.trajectory(NOMINAL, 200.0).unwrap().settled.unwrap();
        assert!((settled.period.unwrap() - period).abs() < 1e-4, "{settled:?}");
        assert!((settled.tangential_max - largest).abs() < 1e-6, "{settled:?}");
        assert!((settled.tangential_min - smallest).abs() < 1e-6, "{settled:?}");
        assert!((settled.stick_fraction - stick).abs() < 1e-4, "{settled:?}");
        assert!(settled.tangential_mean > smallest && settled.tangential_mean < largest);
    }
}

#[test]
fn a_motion_above_both_boundaries_settles_to_steady_sliding() {
    for disc in [DiscModel::Rigid, DiscModel::Flexible { modes: 5 }] {
        let trajectory = criterion(35.0, &disc, Start::Rest).trajectory(NOMINAL, 2000.0).unwrap();
        let settled = trajectory.settled.unwrap();
        assert_eq!((settled.period, settled.stick_fraction), (None, 0.0), "{settled:?}");
        // The paper prints 8.15e-3; the flexible disc takes 3 % of the force.
        assert!((settled.tangential_mean / 8.15e-3 - 1.0).abs() < 0.035, "{settled:?}");
        assert_eq!(trajectory.verdict, Verdict::Stable);
        let last = trajectory.moments.last().unwrap();
        assert!((last.friction_coefficient - 0.25).abs() < 5e-3, "{last:?}");
        assert!((last.friction_force / last.contact_force - last.friction_coefficient).abs() < 1e-12);
    }
}

#[test]
fn stick_means_that_nothing_slides_and_friction_stays_below_the_static() {
    for disc in [DiscModel::Rigid, DiscModel::Flexible { modes: 5 }] {
        let trajectory = criterion(10.0, &disc, Start::Rest).trajectory(NOMINAL, 100.0).unwrap();
        let stuck = trajectory.moments.iter().filter(|moment| moment.sticks).count();
        assert!(stuck > trajectory.moments.len() / 5);
        for moment in &trajectory.moments {
            assert_eq!(moment.sticks, moment.sliding_speed == 0.0, "{moment:?}");
            assert!(moment.friction_coefficient <= 0.39 + 1e-9 && moment.friction_coefficient > 0.0, "{moment:?}");
            assert!(moment.contact_share > 1.0 - 1e-12);
        }
    }
}

#[test]
fn the_angle_on_a_rigid_disc_follows_its_own_equation() {
    // Compared with the flexible model on a disc so stiff that it does not move, and a pad so heavy to turn that it
    // stays level; what is left are the same equations in another program.
    let mut parameters = crate::parameters::Parameters::sui_ding_2018();
    for (key, value) in [("operating_point.rotating_speed", 10.0), ("disc.youngs_modulus", 2.1e11)] {
        parameters.set(key, value).unwrap();
    }
    let brake = PadOnDisc::new(parameters).unwrap();
    let settings = TimeDomainSettings { start: Start::Rest, ..Default::default() };
    let rigid = TimeDomain::new(&brake, &DiscModel::Rigid, settings).unwrap().trajectory(NOMINAL, 300.0).unwrap();
    let flexible = TimeDomain::new(&brake, &DiscModel::Flexible { modes: 5 }, settings)
        .unwrap()
        .trajectory(NOMINAL, 300.0)
        .unwrap();
    let range = |trajectory: &Trajectory| {
        let late = trajectory.moments.iter().filter(|moment| moment.time > 200.0).map(|moment| moment.angle.0);
        (late.clone().fold(f64::INFINITY, f64::min), late.fold(f64::NEG_INFINITY, f64::max))
    };
    let ((a, b), (c, d)) = (range(&rigid), range(&flexible));
    assert!((b - a) / (d - c) > 0.85 && (b - a) / (d - c) < 1.15, "{a} {b} {c} {d}");
}

#[test]
fn a_pad_that_is_not_pressed_has_no_trajectory() {
    for disc in [DiscModel::Rigid, DiscModel::Flexible { modes: 5 }] {
        let inputs = RandomInputs { preload: 0.0, ..NOMINAL };
        let error = criterion(10.0, &disc, Start::Rest).trajectory(inputs, 10.0).unwrap_err();
        assert!(matches!(error, TimeDomainError::Brake(FlexibleError::NotPressed { .. })), "{error}");
    }
}
