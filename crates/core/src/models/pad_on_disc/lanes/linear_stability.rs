//! Linear stability of many brakes at once.

use crate::model::IsStopped;
use crate::model::decision::Decision;
use crate::models::pad_on_disc::criterion::coupled_eigenvalues::decision;
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::flexible_disc::geometry::DiscGeometry;
use crate::models::pad_on_disc::flexible_disc::linear_stability::LinearStability;
use crate::models::pad_on_disc::flexible_disc::nyquist::{Batch, decide};
use crate::models::pad_on_disc::lanes::dispatch::{InstructionSet, dispatch};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

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
    /// [`FlexibleBrake::by_eigenvalues`] says of each, at a hundredth of the cost for most. Brakes of this one's
    /// geometry (radii, Poisson's ratio and the pad's angle) are decided many at once; others cost as much as their
    /// modes.
    #[must_use]
    pub fn linear_stability_of(&self, samples: &[OwnBrake]) -> Vec<Result<LinearStability, FlexibleError>> {
        self.linear_stability_with(samples, InstructionSet::widest(), &|| false).unwrap_or_default()
    }

    /// Whether steady sliding is linearly stable, and what feeds it where it is not. The same as the sign of
    /// [`FlexibleBrake::growth_rate`], at a hundredth of the cost: by the critical products of the sample's box, next to
    /// these by the response, and by eigenvalues only where both leave it open.
    ///
    /// # Errors
    /// As [`FlexibleBrake::growth_rate`].
    pub fn linear_stability(&self, inputs: RandomInputs) -> Result<LinearStability, FlexibleError> {
        self.linear_stability_until(inputs, &|| false)
    }

    /// [`FlexibleBrake::linear_stability`], in a shorter way as soon as it `is_stopped`: without the critical products,
    /// which take some hundred eigenvalues where they are not known yet.
    ///
    /// # Errors
    /// As [`FlexibleBrake::growth_rate`].
    pub fn linear_stability_until(
        &self,
        inputs: RandomInputs,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<LinearStability, FlexibleError> {
        if let Some(stability) = self.by_lattice(inputs, is_stopped) {
            return Ok(stability);
        }
        let own = OwnBrake { brake: self.brake().clone(), inputs };
        self.linear_stability_of(&[own]).pop().unwrap_or_else(|| self.by_eigenvalues(inputs))
    }

    /// Decides samples by the coupled eigenvalues, as [`FlexibleBrake::decide_with`] does; `None` if it is stopped before.
    #[must_use]
    pub fn decide_own(&self, samples: &[OwnBrake], is_stopped: IsStopped<'_>) -> Option<Vec<Decision>> {
        let decide = |(sample, stability): (&OwnBrake, Result<LinearStability, FlexibleError>)| {
            decision(&sample.brake, sample.inputs, || stability)
        };
        let found = self.linear_stability_with(samples, InstructionSet::widest(), is_stopped)?;
        Some(samples.iter().zip(found).map(decide).collect())
    }

    /// [`FlexibleBrake::linear_stability_of`] by the lanes of `set`; `None` if it is stopped before.
    ///
    /// # Panics
    /// If this processor does not have `set`.
    #[must_use]
    #[doc(hidden)]
    pub fn linear_stability_with(
        &self,
        samples: &[OwnBrake],
        set: InstructionSet,
        is_stopped: IsStopped<'_>,
    ) -> Option<Vec<Result<LinearStability, FlexibleError>>> {
        assert!(InstructionSet::available().contains(&set), "this processor has no {set:?}");
        let geometry = &*self.equations.geometry;
        let mut batch = Batch::<LANES>::new(geometry);
        let mut decided = Vec::with_capacity(samples.len());
        for samples in samples.chunks(LANES) {
            let is_mine = |sample: &OwnBrake| geometry.is_of(sample.brake.parameters());
            for (lane, sample) in samples.iter().enumerate().filter(|(_, sample)| is_mine(sample)) {
                batch.set(lane, geometry, &sample.brake, sample.inputs);
            }
            decide_batch(set, geometry, &mut batch);
            for (OwnBrake { brake, inputs }, finding) in samples.iter().zip(batch.findings) {
                // Eigenvalues of a disc of its own take a tenth of a second.
                if is_stopped() {
                    return None;
                }
                decided.push(match finding.stability().filter(|_| geometry.is_of(brake.parameters())) {
                    Some(stability) => Ok(stability),
                    None => self.with_brake(brake.clone()).and_then(|brake| brake.by_eigenvalues(*inputs)),
                });
            }
        }
        Some(decided)
    }
}

/// Decides the samples of a batch by the lanes of `set`.
fn decide_batch(set: InstructionSet, geometry: &DiscGeometry, batch: &mut Batch<LANES>) {
    dispatch!(set, decide, geometry: &DiscGeometry, batch: &mut Batch<LANES>);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
    use crate::models::pad_on_disc::rigid_disc::pad_on_disc::uniform_draws;
    use crate::numerics::root_location::bisect;

    /// Brakes near the preset or far from it. Every third has hardly any damping in its disc, and turns up to a
    /// thousand times as fast: some of these flutter, and others outrun their waves.
    fn samples(count: usize, spread: f64, draw: &mut impl FnMut() -> f64) -> Vec<OwnBrake> {
        let sample = |index: usize| {
            let mut around = |value: f64, spread: f64| value * libm::exp(spread * (2.0 * draw() - 1.0));
            let kinetic = around(0.25, spread);
            let (damping, speed) = if index % 3 == 2 { (around(2e-5, 3.0), around(500.0, 3.5)) } else { (0.02, 15.0) };
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
                ("disc.transverse_damping_ratio", around(damping, spread)),
                ("pad.moment_arm", around(0.008, spread)),
                ("operating_point.rotating_speed", around(speed, spread)),
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
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn many_brakes_are_decided_as_by_their_eigenvalues() {
        let mut draw = uniform_draws(17);
        for (modes, count, spread) in [(5, 1203, 0.35), (5, 600, 1.2), (8, 200, 0.5)] {
            let [stable, tangential, other, _] = compare(modes, &samples(count, spread, &mut draw));
            assert!(stable > 30 && tangential > 20 && other > 5, "{modes} {spread}: {stable} {tangential} {other}");
        }
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn samples_next_to_the_critical_product_are_decided_as_by_their_eigenvalues() {
        let mut left_open = 0;
        for speed in [12.0, 15.4, 22.0] {
            let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]);
            let flexible = FlexibleBrake::with_modes(brake, 5).unwrap();
            for i in 0..8 {
                let preload = 0.06 + 0.03 * f64::from(i);
                let at = |static_friction: f64| RandomInputs { preload, static_friction };
                let is_stable =
                    |friction: f64| flexible.by_eigenvalues(at(friction)).unwrap() == LinearStability::Stable;
                let (critical, _) = bisect((0.25, 2.0), 30, 1e-7, is_stable);
                for beside in -25..25 {
                    let inputs = at(0.25 + (critical - 0.25) * (1.0 + 1e-4 * (f64::from(beside) + 0.5)));
                    assert_eq!(flexible.linear_stability(inputs), flexible.by_eigenvalues(inputs), "{inputs:?}");
                    left_open += usize::from(flexible.by_lattice(inputs, &|| false).is_none());
                }
            }
        }
        assert!(left_open > 600, "{left_open} of 1200 samples are next to the critical products of their box");
    }

    #[test]
    #[ignore = "some minutes; run it after a change of the bounds"]
    fn a_hundred_thousand_brakes_are_decided_as_by_their_eigenvalues() {
        let mut draw = uniform_draws(23);
        for (modes, count, spread) in [(5, 60_000, 0.35), (5, 60_000, 1.2), (8, 6000, 1.2), (14, 1000, 1.0)] {
            let counts = compare(modes, &samples(count, spread, &mut draw));
            assert!(counts[..3].iter().all(|kind| *kind > 100), "{modes} modes, spread {spread}: {counts:?}");
        }
    }

    #[test]
    fn no_further_disc_is_decided_once_it_is_stopped() {
        let base = FlexibleBrake::new(PadOnDisc::preset_with(&[])).unwrap();
        let brake = PadOnDisc::preset_with(&[("disc.poissons_ratio", 0.28)]);
        let sample = OwnBrake { brake, inputs: RandomInputs { preload: 0.05, static_friction: 0.39 } };
        let asked = std::cell::Cell::new(0);
        let is_stopped = || {
            asked.set(asked.get() + 1);
            asked.get() == 3
        };
        assert!(base.decide_own(&vec![sample.clone(); 20], &is_stopped).is_none());
        assert_eq!(asked.get(), 3, "it is asked before each disc");
        assert_eq!(base.decide_own(&[sample], &|| false).map(|decided| decided.len()), Some(1));
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
        // As text, in which what is no number equals itself.
        for set in InstructionSet::available() {
            assert_eq!(
                format!("{:?}", base.linear_stability_with(&samples, set, &|| false)),
                format!("{:?}", Some(&expected)),
                "{set:?}"
            );
        }
        for (sample, expected) in samples.iter().zip(expected) {
            let alone = base.linear_stability_of(std::slice::from_ref(sample));
            assert_eq!(format!("{alone:?}"), format!("[{expected:?}]"));
        }
    }
}
