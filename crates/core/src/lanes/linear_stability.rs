//! Linear stability of many brakes at once.

use crate::flexible_disc::brake::FlexibleBrake;
use crate::flexible_disc::error::FlexibleError;
use crate::flexible_disc::geometry::DiscGeometry;
use crate::flexible_disc::linear_stability::LinearStability;
use crate::flexible_disc::nyquist::{Batch, decide};
use crate::lanes::dispatch::{InstructionSet, dispatch};
use crate::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// Samples in one pass: one register of the widest instruction set.
const LANES: usize = 8;

/// A sample with a brake of its own.
#[derive(Debug, Clone)]
pub struct OwnBrake {
    /// Everything but preload and static friction.
    pub brake: PadOnDisc,
    /// Preload and static friction.
    pub inputs: RandomInputs,
}

impl FlexibleBrake {
    /// The linear stability of samples that each have a brake of their own, with as many modes as this one has: what
    /// [`FlexibleBrake::by_eigenvalues`] says of each, at a hundredth of the cost for most. Brakes of this one's geometry
    /// (radii, Poisson's ratio and the pad's angle) are decided many at once; others cost as much as their modes.
    #[must_use]
    pub fn linear_stability_of(&self, samples: &[OwnBrake]) -> Vec<Result<LinearStability, FlexibleError>> {
        self.linear_stability_with(samples, InstructionSet::widest())
    }

    /// [`FlexibleBrake::linear_stability_of`] by the lanes of `set`.
    ///
    /// # Panics
    /// If this processor does not have `set`.
    #[must_use]
    #[doc(hidden)]
    pub fn linear_stability_with(
        &self,
        samples: &[OwnBrake],
        set: InstructionSet,
    ) -> Vec<Result<LinearStability, FlexibleError>> {
        assert!(InstructionSet::available().contains(&set), "this processor has no {set:?}");
        let geometry = &*self.equations.geometry;
        let mut batch = Batch::<LANES>::new(geometry);
        let mut decided = Vec::with_capacity(samples.len());
        for samples in samples.chunks(LANES) {
            let is_mine = |sample: &OwnBrake| geometry.is_of(sample.brake.parameters());
            for (lane, sample) in samples.iter().enumerate().filter(|(_, sample)| is_mine(sample)) {
                batch.set(lane, geometry, &sample.brake, sample.inputs);
            }
            let batch = &mut batch;
            dispatch!(set, decide, geometry: &DiscGeometry, batch: &mut Batch<LANES>);
            decided.extend(samples.iter().zip(batch.findings).map(|(OwnBrake { brake, inputs }, finding)| {
                match finding.stability().filter(|_| geometry.is_of(brake.parameters())) {
                    Some(stability) => Ok(stability),
                    None => self.with_brake(brake.clone())?.by_eigenvalues(*inputs),
                }
            }));
        }
        decided
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::degree_of_freedom::DegreeOfFreedom;
    use crate::rigid_disc::pad_on_disc::uniform_draws;

    /// Brakes near the preset or far from it, some of which flutter or turn faster than their waves.
    fn samples(count: usize, spread: f64, draw: &mut impl FnMut() -> f64) -> Vec<OwnBrake> {
        let sample = |_| {
            let mut around = |value: f64, spread: f64| value * libm::exp(spread * (2.0 * draw() - 1.0));
            let kinetic = around(0.25, spread);
            let changes = [
                ("friction.kinetic_coefficient", kinetic),
                ("friction.static_coefficient", 1.5 * kinetic),
                ("friction.stribeck_velocity", around(0.72, spread)),
                ("damping.tangential", around(369.0, spread)),
                ("damping.normal", around(106.1, spread)),
                ("damping.angular", around(0.08882, spread)),
                ("stiffness.contact_normal", around(3.816e7, spread)),
                ("stiffness.calliper_tangential", around(3.249e7, spread)),
                ("disc.youngs_modulus", around(2.1e11, spread)),
                ("disc.thickness", around(0.02, 0.6 * spread)),
                ("disc.transverse_damping_ratio", around(0.02, 3.0 * spread)),
                ("pad.moment_arm", around(0.008, spread)),
                ("operating_point.rotating_speed", around(15.0, 1.5 * spread)),
            ];
            let inputs = RandomInputs { preload: around(0.1, spread), static_friction: around(0.39, spread) };
            OwnBrake { brake: PadOnDisc::preset_with(&changes), inputs }
        };
        (0..count).map(sample).collect()
    }

    /// Compares with the eigenvalues. Returns the numbers of stable samples, of those fed by falling friction, of those
    /// fed by something else, and of failed ones.
    fn compare(modes: usize, samples: &[OwnBrake]) -> [u32; 4] {
        let base = FlexibleBrake::with_modes(PadOnDisc::preset_with(&[]), modes).unwrap();
        let decided = base.linear_stability_of(samples);
        let mut counts = [0; 4];
        for (OwnBrake { brake, inputs }, decided) in samples.iter().zip(decided) {
            let exact = base.with_brake(brake.clone()).unwrap().by_eigenvalues(*inputs);
            assert_eq!(decided, exact, "{:?} {inputs:?}", brake.parameters());
            counts[match exact {
                Ok(LinearStability::Stable) => 0,
                Ok(LinearStability::Unstable { fed_by: DegreeOfFreedom::Tangential }) => 1,
                Ok(LinearStability::Unstable { .. }) => 2,
                Err(_) => 3,
            }] += 1;
        }
        counts
    }

    #[test]
    fn many_brakes_are_decided_as_by_their_eigenvalues() {
        let mut draw = uniform_draws(17);
        for (modes, count, spread) in [(5, 1203, 0.35), (5, 600, 1.2), (8, 200, 0.5)] {
            let [stable, tangential, other, _] = compare(modes, &samples(count, spread, &mut draw));
            assert!(stable > 30 && tangential > 30, "{spread}: {stable} {tangential} {other}");
            assert!(spread < 1.0 || other > 5, "{spread}: {stable} {tangential} {other}");
        }
    }

    #[test]
    #[ignore = "some minutes; run it after a change of the bounds"]
    fn a_hundred_thousand_brakes_are_decided_as_by_their_eigenvalues() {
        let mut draw = uniform_draws(23);
        for (modes, count, spread) in [(5, 60_000, 0.35), (5, 60_000, 1.2), (8, 6000, 1.2), (14, 1000, 1.0)] {
            println!("{modes} modes, spread {spread}: {:?}", compare(modes, &samples(count, spread, &mut draw)));
        }
    }

    #[test]
    fn instruction_sets_and_neighbours_change_nothing() {
        let base = FlexibleBrake::new(PadOnDisc::preset_with(&[])).unwrap();
        let mut samples = samples(43, 0.5, &mut uniform_draws(29));
        // Nothing to press together, no number, and another geometry.
        samples[4].inputs.preload = -0.1;
        samples[5].inputs.static_friction = f64::NAN;
        samples[9].brake = PadOnDisc::preset_with(&[("disc.poissons_ratio", 0.28)]);
        let expected = base.linear_stability_of(&samples);
        assert!(matches!(expected[4], Err(FlexibleError::NotPressed { .. })));
        assert!(expected[5].is_err() && expected[9].is_ok());
        for set in InstructionSet::available() {
            assert_eq!(base.linear_stability_with(&samples, set), expected, "{set:?}");
        }
        for (sample, expected) in samples.iter().zip(expected) {
            assert_eq!(base.linear_stability_of(std::slice::from_ref(sample)), [expected]);
        }
    }
}

#[cfg(test)]
mod measurement {
    use super::*;
    use crate::rigid_disc::pad_on_disc::uniform_draws;

    #[test]
    #[ignore = "measurement"]
    fn cost() {
        let base = FlexibleBrake::with_modes(PadOnDisc::preset_with(&[]), 5).unwrap();
        let geometry = &*base.equations.geometry;
        let mut draw = uniform_draws(9);
        let mut normal = || (0..12).map(|_| draw()).sum::<f64>() - 6.0;
        let samples: Vec<OwnBrake> = (0..4000)
            .map(|_| {
                let mut around = |v: f64| v * (1.0 + 0.2 * normal()).max(0.05);
                let kinetic = around(0.25);
                let changes = [
                    ("friction.kinetic_coefficient", kinetic),
                    ("friction.static_coefficient", kinetic + 0.1),
                    ("friction.stribeck_velocity", around(0.72)),
                    ("damping.tangential", around(369.0)),
                    ("stiffness.contact_normal", around(3.816e7)),
                    ("disc.youngs_modulus", around(2.1e11)),
                    ("operating_point.rotating_speed", around(15.0)),
                ];
                let inputs = RandomInputs { preload: around(0.1), static_friction: around(0.39) };
                OwnBrake { brake: PadOnDisc::preset_with(&changes), inputs }
            })
            .collect();
        for set in InstructionSet::available() {
            let mut batch = Batch::<LANES>::new(geometry);
            let mut open = 0;
            let mut setting = 0.0;
            let mut deciding = 0.0;
            for samples in samples.chunks(LANES) {
                let start = std::time::Instant::now();
                for (lane, sample) in samples.iter().enumerate() {
                    batch.set(lane, geometry, &sample.brake, sample.inputs);
                }
                setting += start.elapsed().as_secs_f64();
                let start = std::time::Instant::now();
                let batch = &mut batch;
                dispatch!(set, decide, geometry: &DiscGeometry, batch: &mut Batch<LANES>);
                deciding += start.elapsed().as_secs_f64();
                open += batch.findings.iter().filter(|f| f.stability().is_none()).count();
            }
            let start = std::time::Instant::now();
            std::hint::black_box(base.linear_stability_with(&samples, set));
            let all = start.elapsed().as_secs_f64();
            let per = 1e6 / samples.len() as f64;
            println!(
                "{set:?}: set {:.3} us, decide {:.3} us, all {:.3} us, open {open}",
                setting * per,
                deciding * per,
                all * per
            );
        }
    }
}
