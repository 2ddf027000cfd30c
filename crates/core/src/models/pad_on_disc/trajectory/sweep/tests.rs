use super::*;
use crate::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use crate::models::pad_on_disc::criterion::time_domain::DiscModel;
use crate::models::pad_on_disc::motion::start::Start;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

const NOMINAL: RandomInputs = RandomInputs { preload: 0.1, static_friction: 0.39 };

fn criterion(speed: f64, disc: &DiscModel, start: Start) -> TimeDomain {
    let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]);
    TimeDomain::new(&brake, disc, TimeDomainSettings { start, ..Default::default() }).unwrap()
}

#[test]
fn a_sweep_down_jumps_at_the_critical_speed_and_a_sweep_up_at_the_saddle_node() {
    // The paper's bifurcation diagram: hysteresis between 15.56 and 30.
    let at = |speed: f64| criterion(speed, &DiscModel::Rigid, Start::NearEquilibrium);
    let speeds: Vec<f64> = (0..=60).map(|i| 40.0 - 0.5 * f64::from(i)).collect();
    let down: Vec<TimeDomain> = speeds.iter().map(|&speed| at(speed)).collect();
    let up: Vec<TimeDomain> = speeds.iter().rev().map(|&speed| at(speed)).collect();
    let jump = |points: &[SweepPoint], sticks: bool| {
        points.iter().find(|point| (point.stick_fraction > 0.0) == sticks).map(|point| point.rotating_speed).unwrap()
    };
    let down = jump(&sweep(&down, NOMINAL, 600.0).unwrap(), true);
    let up = jump(&sweep(&up, NOMINAL, 600.0).unwrap(), false);
    // The first step of the sweep beyond the boundary, or the next: near it growth takes its time.
    assert!((14.5..=15.5).contains(&down), "{down}");
    // A step of the speed disturbs the motion, and so close below the saddle-node little is enough.
    assert!((30.0..=30.5).contains(&up), "{up}");
}
