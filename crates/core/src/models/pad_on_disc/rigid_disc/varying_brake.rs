//! A brake with parameters that differ from sample to sample.

use crate::models::pad_on_disc::parameters::{Parameters, Scalar};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// A brake of which some parameters, beside preload and static friction, differ from sample to sample.
///
/// What all samples share is validated once. A sample's own brake takes a copy of the parameters and some arithmetic:
/// no key is looked up, and nothing is allocated.
///
/// ```
/// use stickslip_core::models::pad_on_disc::parameters::{Parameters, scalar};
/// use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
/// use stickslip_core::models::pad_on_disc::rigid_disc::varying_brake::VaryingBrake;
/// let shared = PadOnDisc::new(Parameters::sui_ding_2018())?;
/// let varying = VaryingBrake::new(shared, scalar("pad.mass").into_iter().collect());
/// let inputs = RandomInputs { preload: 0.1, static_friction: 0.39 };
/// assert_eq!(varying.brake(inputs, |_| 0.12).map(|brake| brake.parameters().pad.mass), Some(0.12));
/// assert!(varying.brake(inputs, |_| -0.12).is_none());
/// # Ok::<(), stickslip_core::models::pad_on_disc::parameters::ParameterError>(())
/// ```
#[derive(Debug, Clone)]
pub struct VaryingBrake {
    shared: PadOnDisc,
    scalars: Vec<&'static Scalar>,
}

impl VaryingBrake {
    /// For samples that differ from `shared` in `scalars`.
    #[must_use]
    pub fn new(shared: PadOnDisc, scalars: Vec<&'static Scalar>) -> Self {
        Self { shared, scalars }
    }

    /// The brake with the values that all samples share, and expected values of the others.
    #[must_use]
    pub fn shared(&self) -> &PadOnDisc {
        &self.shared
    }

    /// The parameters that differ.
    #[must_use]
    pub fn scalars(&self) -> &[&'static Scalar] {
        &self.scalars
    }

    /// The brake of one sample, `value(i)` being its value of scalar `i`; `None` if a value is not admissible, such as
    /// a stiffness below zero.
    ///
    /// No brake can be made with friction that rises with speed. Where the sample's static friction is below its
    /// kinetic friction, the brake has the latter; criteria take the sample's own from its `inputs`.
    #[must_use]
    pub fn brake(&self, inputs: RandomInputs, value: impl Fn(usize) -> f64) -> Option<PadOnDisc> {
        let mut parameters: Parameters = self.shared.parameters().clone();
        for (i, scalar) in self.scalars.iter().enumerate() {
            let value = value(i);
            if !scalar.limits.contain(value) {
                return None;
            }
            scalar.assign(&mut parameters, value);
        }
        let friction = &mut parameters.friction;
        friction.static_coefficient = inputs.static_friction.max(friction.kinetic_coefficient);
        if friction.static_coefficient > HIGHEST_FRICTION {
            return None;
        }
        parameters.check_relations().ok()?;
        PadOnDisc::of_admissible(parameters).ok()
    }
}

/// The highest admissible static friction coefficient, see `friction.static_coefficient`.
pub(crate) const HIGHEST_FRICTION: f64 = 5.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::pad_on_disc::parameters::{SCALARS, scalar};
    use crate::models::pad_on_disc::rigid_disc::pad_on_disc::uniform_draws;

    #[test]
    fn a_sample_has_the_brake_of_its_parameters() {
        let mut draw = uniform_draws(3);
        let shared = PadOnDisc::preset_with(&[]);
        let scalars: Vec<&Scalar> = SCALARS.iter().filter(|s| s.key != "friction.static_coefficient").collect();
        let varying = VaryingBrake::new(shared.clone(), scalars.clone());
        let (mut made, mut refused) = (0, 0);
        for _ in 0..2000 {
            let values: Vec<f64> = scalars
                .iter()
                .map(|scalar| scalar.value(shared.parameters()) * (1.0 + 0.6 * (draw() + draw() - 1.0)))
                .collect();
            let inputs = RandomInputs { preload: 0.1, static_friction: 0.5 * draw() };
            let mut parameters = Parameters::sui_ding_2018();
            let admissible = scalars.iter().zip(&values).all(|(s, value)| parameters.set(s.key, *value).is_ok());
            let friction = &mut parameters.friction;
            friction.static_coefficient = inputs.static_friction.max(friction.kinetic_coefficient);
            let expected = admissible.then(|| PadOnDisc::new(parameters).ok()).flatten();
            assert_eq!(varying.brake(inputs, |i| values[i]), expected);
            if expected.is_some() { made += 1 } else { refused += 1 }
        }
        assert!(made > 300 && refused > 300, "{made} {refused}");
    }

    #[test]
    fn values_out_of_range_and_contradictions_make_no_brake() {
        let inputs = RandomInputs { preload: 0.1, static_friction: 0.39 };
        for (key, value) in [
            ("pad.mass", 0.0),
            ("pad.mass", f64::NAN),
            ("disc.poissons_ratio", 0.5),
            ("disc.inner_radius", 0.2),
            ("pad.inner_radius", 0.05),
            ("stiffness.contact_normal", f64::INFINITY),
        ] {
            let varying = VaryingBrake::new(PadOnDisc::preset_with(&[]), vec![scalar(key).unwrap()]);
            assert!(varying.brake(inputs, |_| value).is_none(), "{key} = {value}");
        }
        let varying = VaryingBrake::new(PadOnDisc::preset_with(&[]), Vec::new());
        assert!(varying.brake(RandomInputs { static_friction: 5.1, ..inputs }, |_| 0.0).is_none());
        let limits = scalar("friction.static_coefficient").unwrap().limits;
        assert_eq!(limits.maximum, HIGHEST_FRICTION);
    }
}
