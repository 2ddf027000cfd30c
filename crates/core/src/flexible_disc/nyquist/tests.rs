use super::*;
use crate::flexible_disc::brake::FlexibleBrake;
use crate::flexible_disc::linear_stability::LinearStability;
use crate::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs, uniform_draws};

#[test]
#[ignore = "measurement"]
fn explore() {
    let base = FlexibleBrake::with_modes(PadOnDisc::preset_with(&[]), 5).unwrap();
    let geometry = &base.equations.geometry;
    let mut batch = Batch::<8>::new(geometry);
    let mut draw = uniform_draws(9);
    let mut normal = || (0..12).map(|_| draw()).sum::<f64>() - 6.0;
    let (mut open, mut wrong, mut n, mut unstable) = (0, 0, 0, 0);
    for _ in 0..500 {
        let mut samples = Vec::new();
        for lane in 0..8 {
            let mut around = |v: f64| v * (1.0 + 0.2 * normal()).max(0.05);
            let kinetic = around(0.25);
            let changes = [
                ("friction.kinetic_coefficient", kinetic),
                ("friction.static_coefficient", kinetic + 0.1),
                ("friction.stribeck_velocity", around(0.72)),
                ("damping.tangential", around(369.0)),
                ("stiffness.contact_normal", around(3.816e7)),
                ("disc.youngs_modulus", around(2.1e11)),
                ("disc.thickness", around(0.02)),
                ("operating_point.rotating_speed", around(15.0)),
            ];
            let inputs = RandomInputs { preload: around(0.1), static_friction: around(0.39) };
            let brake = PadOnDisc::preset_with(&changes);
            batch.set(lane, geometry, &brake, inputs);
            samples.push((brake, inputs));
        }
        decide(geometry, &mut batch);
        for (lane, (brake, inputs)) in samples.into_iter().enumerate() {
            n += 1;
            let exact = base.with_brake(brake).unwrap().by_eigenvalues(inputs).unwrap();
            unstable += u32::from(exact != LinearStability::Stable);
            match (batch.findings[lane], exact) {
                (Finding::Open, _) => open += 1,
                (Finding::Stable, LinearStability::Stable) => {}
                (
                    Finding::FedByFriction,
                    LinearStability::Unstable { fed_by: crate::degree_of_freedom::DegreeOfFreedom::Tangential },
                ) => {}
                _ => wrong += 1,
            }
        }
    }
    println!("{n} samples, {unstable} unstable, {open} open, {wrong} wrong");
}
