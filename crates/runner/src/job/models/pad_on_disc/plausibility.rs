//! Values that are admissible but were probably meant in another unit.
//!
//! The limits of the parameters exclude what cannot be computed. The ranges here are narrower: they hold every brake
//! from a bicycle's to a train's, and what lies outside is warned of.

use std::f64::consts::{PI, TAU};

use stickslip_core::model::quantity::Quantity;
use stickslip_core::models::pad_on_disc::flexible_disc::error::FlexibleError;
use stickslip_core::models::pad_on_disc::flexible_disc::mode_count::ModeCheck;
use stickslip_core::models::pad_on_disc::parameters::{Parameters, SCALARS, Scalar};
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{LARGEST_ROTATION, PadOnDisc};
use stickslip_sampler::grid::Grid;

use super::measured_friction;
use super::preload_force::PRELOAD;
use crate::units;

/// The plausible values of one parameter.
struct Rule {
    /// Of the parameter; a section's name alone is a rule for all parameters of the section.
    key: &'static str,
    least: f64,
    most: f64,
    /// Units in which the value may have been meant, with their size in the unit of the parameter.
    units: &'static [(f64, &'static str)],
}

const MILLIMETRES: &[(f64, &str)] = &[(1e-3, "mm")];
const PER_CENT: &[(f64, &str)] = &[(1e-2, "per cent")];

/// The first rule that fits a key is its rule.
#[rustfmt::skip]
static RULES: [Rule; 19] = [
    Rule { key: "disc.density", least: 500.0, most: 25e3, units: &[(1e3, "g/cm^3")] },
    Rule { key: "disc.youngs_modulus", least: 1e9, most: 1.5e12, units: &[(1e9, "GPa"), (1e6, "MPa")] },
    Rule { key: "disc.thickness", least: 5e-4, most: 0.15, units: MILLIMETRES },
    Rule { key: "disc.inner_radius", least: 5e-3, most: 1.0, units: MILLIMETRES },
    Rule { key: "disc.outer_radius", least: 0.015, most: 1.5, units: MILLIMETRES },
    Rule { key: "disc.transverse_damping_ratio", least: 0.0, most: 0.3, units: PER_CENT },
    Rule { key: "pad.mass", least: 1e-3, most: 20.0, units: &[(1e-3, "g")] },
    Rule { key: "pad.moment_of_inertia", least: 1e-8, most: 1.0, units: &[(1e-6, "kg mm^2"), (1e-9, "g mm^2")] },
    Rule { key: "pad.inner_radius", least: 5e-3, most: 1.5, units: MILLIMETRES },
    Rule { key: "pad.effective_radius", least: 5e-3, most: 1.5, units: MILLIMETRES },
    Rule { key: "pad.half_angle", least: 0.02, most: 1.6, units: &[(PI / 180.0, "degrees")] },
    Rule { key: "pad.moment_arm", least: 0.0, most: 0.1, units: MILLIMETRES },
    Rule { key: "stiffness.calliper_angular", least: 50.0, most: 1e9, units: &[(1e3, "kN m/rad")] },
    Rule { key: "stiffness", least: 1e5, most: 1e11, units: &[(1e3, "N/mm"), (1e6, "kN/mm")] },
    Rule { key: "friction.static_coefficient", least: 0.0, most: 1.5, units: PER_CENT },
    Rule { key: "friction.kinetic_coefficient", least: 0.0, most: 1.5, units: PER_CENT },
    Rule { key: "friction.viscous", least: 0.0, most: 1.0, units: &[] },
    Rule { key: "friction.stribeck_velocity", least: 1e-4, most: 30.0, units: &[(1e-3, "mm/s")] },
    Rule { key: "operating_point.rotating_speed", least: 1e-3, most: 1e3, units: &[(TAU / 60.0, "rpm")] },
];

impl Rule {
    fn for_key(key: &str) -> Option<&'static Self> {
        RULES.iter().find(|rule| key == rule.key || key.split_once('.').is_some_and(|(section, _)| section == rule.key))
    }

    fn allows(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }

    /// What the value is in the unit of the parameter if it was meant in another one, as the end of a message.
    fn likely(&self, value: f64) -> String {
        let likely = self.units.iter().find(|(size, _)| self.allows(value * size));
        likely.map_or(String::new(), |(size, unit)| {
            format!("; did you mean {} ({} {unit})?", written(value * size), written(value))
        })
    }
}

/// Largest contact force that is plausible, N: that of the disc brakes of heavy lorries.
const LARGEST_FORCE: f64 = 250e3;

/// A number with at most six digits.
fn written(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e6).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// What a user may have meant by a value of a parameter that was refused, as the end of a message.
pub fn hint(key: &str, value: f64, parameters: &Parameters) -> String {
    if key == "operating_point.preload" && value > 1.0 {
        let of_thickness = 1e-3 * value / parameters.disc.thickness;
        if of_thickness <= 1.0 {
            let mm = written(value);
            return format!(
                ". Preload has no unit: it is the displacement of the calliper over the thickness of the disc, {} mm here. Write {} for {mm} mm; a force of {mm} N is preload_force = {mm} in its place",
                written(1e3 * parameters.disc.thickness),
                written(of_thickness)
            );
        }
        return format!(
            ". Preload is the displacement of the calliper over the thickness of the disc, not a force: preload 1 presses with {} N here, N = h Delta k_en k_y / (k_en + k_y); write {} for {force} N, or give preload_force = {force} in its place",
            written(1.0 / parameters.preload_of(1.0)),
            written(parameters.preload_of(value)),
            force = written(value)
        );
    }
    Rule::for_key(key).map_or(String::new(), |rule| rule.likely(value))
}

fn warning(name: &str, value: f64, scalar: &Scalar) -> Option<String> {
    let rule = Rule::for_key(scalar.key).filter(|rule| !rule.allows(value))?;
    let unit = if scalar.unit == "1" { String::new() } else { format!(" {}", scalar.unit) };
    let (least, most) = (written(rule.least), written(rule.most));
    let hint = rule.likely(value);
    Some(format!("{name} = {}{unit} is not plausible (usually {least} to {most}{unit}){hint}", written(value)))
}

/// Warnings about the parameters of a brake.
pub fn of_parameters(parameters: &Parameters) -> Vec<String> {
    let given = SCALARS.iter().filter(|scalar| scalar.is_given(parameters));
    let mut warnings: Vec<String> =
        given.filter_map(|scalar| warning(scalar.key, scalar.value(parameters), scalar)).collect();
    warnings.extend(of_disc(parameters));
    let point = &parameters.operating_point;
    warnings.extend(of_force(point.preload, parameters));
    warnings.extend(of_rotation(PadOnDisc::new(parameters.clone()).iter()));
    warnings.extend(of_curve(parameters, point.rotating_speed));
    warnings
}

/// Warnings about a measured friction curve of a brake whose disc turns at `fastest` at most, rad/s.
fn of_curve(parameters: &Parameters, fastest: f64) -> Vec<String> {
    let curve = parameters.friction.law.table();
    curve.map_or_else(Vec::new, |curve| measured_friction::doubts(curve, fastest * parameters.effective_radius()))
}

/// A warning about a preload that presses too much with these parameters; on a disc that is no plate the thickness is what is
/// wrong.
fn of_force(preload: f64, parameters: &Parameters) -> Option<String> {
    let force = preload / parameters.preload_of(1.0);
    let thickness = parameters.disc.thickness;
    (force > LARGEST_FORCE && of_disc(parameters).is_none()).then(|| {
        format!(
            "the preload {preload} presses with {}, which is not plausible (usually at most {}). Preload is the displacement of the calliper over the thickness of the disc, {} mm here: {preload} mm would be {}",
            units::force(force),
            units::force(LARGEST_FORCE),
            written(1e3 * thickness),
            written(1e-3 * preload / thickness),
            preload = written(preload)
        )
    })
}

/// A warning about brakes whose pad friction turns too far on a rigid disc. A flexible disc has no steady sliding then.
pub fn of_rotation<'a>(brakes: impl Iterator<Item = &'a PadOnDisc>) -> Option<String> {
    let angles = brakes.map(|brake| brake.sliding_equilibrium().angle);
    let angle = angles.max_by(|one, other| one.abs().total_cmp(&other.abs()))?;
    (angle.abs() > LARGEST_ROTATION).then(|| FlexibleError::Rotated { angle }.to_string())
}

/// A warning about a disc that is no plate.
fn of_disc(parameters: &Parameters) -> Option<String> {
    let disc = &parameters.disc;
    let width = disc.outer_radius - disc.inner_radius;
    (disc.thickness > width).then(|| {
        format!(
            "disc.thickness = {} m is more than the width of the ring, outer_radius - inner_radius = {} m: the theory of thin plates does not hold for such a disc",
            written(disc.thickness),
            written(width)
        )
    })
}

/// Warnings about the parameters and axes of a job.
pub fn of_job(parameters: &Parameters, quantities: &[Quantity], grid: &Grid) -> Vec<String> {
    let mut warnings = Vec::new();
    for scalar in &SCALARS {
        let Some(place) = quantities.iter().position(|quantity| quantity.path == scalar.key) else { continue };
        let values = match grid.axis_of(place) {
            Some(axis) => {
                let mut ends =
                    axis.extremes().map(|value| (format!("axes.{}", quantities[place].name), value)).to_vec();
                ends.dedup();
                ends
            }
            None if !scalar.is_given(parameters) => continue,
            None => vec![(scalar.key.to_owned(), scalar.value(parameters))],
        };
        warnings.extend(values.into_iter().filter_map(|(name, value)| warning(&name, value, scalar)));
    }
    warnings.extend(of_disc(parameters));
    let place = |key: &str| quantities.iter().position(|quantity| quantity.path == key);
    if let Some(place) = place(PRELOAD) {
        let [_, most] = grid.extremes_of(place);
        warnings.extend(of_force(most, parameters));
    }
    if let Some(place) = place("operating_point.rotating_speed") {
        let [_, fastest] = grid.extremes_of(place);
        warnings.extend(of_curve(parameters, fastest));
    }
    warnings
}

/// What to say of the most modes of the disc that a model may keep where they are too few.
pub fn of_modes(check: ModeCheck) -> String {
    format!(
        "{check}. There are no more than {} disc modes to choose, so an error remains in results: here {:.2} % of the growth rate, or of the pad's damping rate where that is larger",
        check.count,
        100.0 * check.growth_error
    )
}

/// A warning about a start near the equilibrium that is far from it.
pub fn of_displacement(name: &str, displacement: f64) -> Option<String> {
    (displacement > 10.0).then(|| {
        format!(
            "{name} = {displacement} starts the motion at {displacement} times the displacement of the equilibrium itself, which is not near it; 0.01 is usual"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_preset_is_plausible() {
        assert_eq!(of_parameters(&Parameters::sui_ding_2018()), Vec::<String>::new());
    }

    #[test]
    fn every_rule_has_a_parameter_and_admissible_values() {
        for rule in &RULES {
            let mut scalars = SCALARS.iter().filter(|scalar| scalar.key == rule.key || scalar.section() == rule.key);
            let scalar = scalars.next().unwrap();
            assert!(rule.least < rule.most && scalar.limits.contain(rule.most), "{}", rule.key);
        }
    }

    #[test]
    fn values_of_the_preset_in_other_units_are_recognised() {
        let preset = Parameters::sui_ding_2018();
        for (key, value, likely) in [
            ("disc.youngs_modulus", 210.0, "2.1e11 (210 GPa)"),
            ("disc.youngs_modulus", 210e3, "2.1e11 (210000 MPa)"),
            ("disc.density", 7.8, "7800 (7.8 g/cm^3)"),
            ("disc.thickness", 20.0, "0.02 (20 mm)"),
            ("pad.mass", 300.0, "0.3 (300 g)"),
            ("pad.effective_radius", 115.0, "0.115 (115 mm)"),
            ("pad.half_angle", 30.0, "0.523599 (30 degrees)"),
            ("stiffness.contact_normal", 38_160.0, "3.816e7 (38160 N/mm)"),
            ("stiffness.contact_normal", 38.16, "3.816e7 (38.16 kN/mm)"),
            ("stiffness.calliper_angular", 24.72, "24720 (24.72 kN m/rad)"),
            ("friction.static_coefficient", 39.0, "0.39 (39 per cent)"),
            ("operating_point.rotating_speed", 1500.0, "157.08 (1500 rpm)"),
        ] {
            assert_eq!(hint(key, value, &preset), format!("; did you mean {likely}?"), "{key} = {value}");
            let scalar = SCALARS.iter().find(|scalar| scalar.key == key).unwrap();
            assert!(warning(key, value, scalar).unwrap().contains(likely));
        }
    }

    #[test]
    fn a_preload_in_millimetres_is_recognised_by_its_force() {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.operating_point.preload = 0.8;
        let said = of_parameters(&parameters);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].starts_with("the preload 0.8 presses with 280.8 kN, which is not"), "{said:?}");
        assert!(
            said[0].contains("at most 250.0 kN") && said[0].ends_with("20 mm here: 0.8 mm would be 0.04"),
            "{said:?}"
        );
        // What makes the force is the thickness.
        parameters.operating_point.preload = 0.3;
        parameters.disc.thickness = 0.1;
        let said = of_parameters(&parameters);
        assert!(said.len() == 1 && said[0].starts_with("disc.thickness = 0.1 m is more"), "{said:?}");
    }

    #[test]
    fn a_pad_that_friction_turns_too_far_is_warned_of() {
        let mut parameters = Parameters::sui_ding_2018();
        let softer = |angle: f64, parameters: &mut Parameters| {
            let own = PadOnDisc::new(parameters.clone()).unwrap().sliding_equilibrium().angle;
            parameters.stiffness.calliper_angular *= own / angle;
            of_parameters(parameters).into_iter().filter(|said| said.contains("turned")).collect::<Vec<_>>()
        };
        assert_eq!(softer(0.249, &mut parameters), Vec::<String>::new());
        let said = softer(0.251, &mut parameters);
        assert!(said.len() == 1 && said[0].starts_with("the pad is turned by 0.251 rad in steady sliding"), "{said:?}");
        assert!(said[0].contains("up to 0.25 rad") && said[0].contains("stiffness.calliper_angular"), "{said:?}");
    }

    #[test]
    fn a_force_is_no_preload() {
        let preset = Parameters::sui_ding_2018();
        // k_en k_y / (k_en + k_y) = 1.754877e7 N/m and h = 0.02 m.
        let said = hint("operating_point.preload", 5000.0, &preset);
        assert!(
            said.contains("preload 1 presses with 350975 N") && said.contains("write 0.014246 for 5000 N"),
            "{said}"
        );
        assert_eq!(hint("operating_point.preload", -0.1, &preset), "");
    }
}
