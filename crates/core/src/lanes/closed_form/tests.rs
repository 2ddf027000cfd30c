use super::*;
use crate::parameters::{SCALARS, scalar};
use crate::rigid_disc::pad_on_disc::{PadOnDisc, uniform_draws};

/// A brake that differs in some parameters, with samples.
struct Case {
    form: VaryingClosedForm,
    preloads: Vec<f64>,
    static_frictions: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

/// Brakes that differ in these parameters by up to `spread` of their shared value.
fn case(keys: &[&str], spread: f64, samples: usize, seed: u64, changes: &[(&str, f64)]) -> Case {
    let shared = PadOnDisc::preset_with(changes);
    let scalars: Vec<&Scalar> = keys.iter().map(|key| scalar(key).unwrap()).collect();
    let mut draw = uniform_draws(seed);
    let mut around = |value: f64| value * (1.0 + spread * (2.0 * draw() - 1.0));
    let mut column = |value: f64| (0..samples).map(|_| around(value)).collect::<Vec<f64>>();
    let (preloads, static_frictions) = (column(0.1), column(0.39));
    let columns = scalars.iter().map(|scalar| column(scalar.value(shared.parameters()))).collect();
    Case { form: VaryingClosedForm::new(VaryingBrake::new(shared, scalars)), preloads, static_frictions, columns }
}

impl Case {
    fn verdicts(&self, form: &VaryingClosedForm) -> Vec<Verdict> {
        let columns: Vec<&[f64]> = self.columns.iter().map(Vec::as_slice).collect();
        let mut verdicts = Vec::new();
        form.decide(&self.preloads, &self.static_frictions, &columns, &mut verdicts);
        verdicts
    }

    /// The verdict of the sample's own boundary of stability, if it is clear of rounding.
    fn expected(&self, sample: usize) -> Option<Verdict> {
        let (preload, static_friction) = (self.preloads[sample], self.static_frictions[sample]);
        let inputs = RandomInputs { preload, static_friction };
        let Some(brake) = self.form.brake().brake(inputs, |i| self.columns[i][sample]) else {
            return Some(Verdict::Failed);
        };
        let boundary = brake.stability_boundary();
        let product = preload * (static_friction - brake.friction_law().kinetic_coefficient);
        let distance = (product / boundary.critical_product() - 1.0).abs();
        (distance > 1e-13).then(|| boundary.verdict(preload, static_friction))
    }
}

const OF_THE_FORM: [&str; 12] = [
    "disc.thickness",
    "disc.outer_radius",
    "stiffness.contact_normal",
    "stiffness.calliper_normal",
    "stiffness.contact_tangential_1",
    "stiffness.contact_tangential_2",
    "damping.tangential",
    "friction.kinetic_coefficient",
    "friction.stribeck_velocity",
    "friction.stribeck_exponent",
    "operating_point.rotating_speed",
    "pad.mass",
];

#[test]
fn every_sample_has_the_verdict_of_its_own_boundary() {
    let everything: Vec<&str> =
        SCALARS.iter().map(|scalar| scalar.key).filter(|key| *key != "friction.static_coefficient").collect();
    let mut seen = VerdictCounts::default();
    for (number, keys) in [&OF_THE_FORM[..4], &OF_THE_FORM[4..8], &OF_THE_FORM[8..], &OF_THE_FORM, &everything, &[]]
        .into_iter()
        .enumerate()
    {
        for (spread, exponent) in [(0.2, 1.0), (0.5, 2.0), (1.5, 1.0), (0.9, 0.6)] {
            let case = case(keys, spread, 1500, number as u64 + 7, &[("friction.stribeck_exponent", exponent)]);
            for (sample, verdict) in case.verdicts(&case.form).into_iter().enumerate() {
                let expected = case.expected(sample);
                assert!(expected.is_none_or(|expected| expected == verdict), "{keys:?}, sample {sample}");
                seen += verdict.into();
            }
        }
    }
    assert!(seen.stable.min(seen.unstable).min(seen.failed) > 1000, "{seen:?}");
}

#[test]
fn a_sample_has_the_same_verdict_alone_and_on_every_instruction_set() {
    let case = case(&OF_THE_FORM, 0.4, 777, 5, &[]);
    let verdicts = case.verdicts(&case.form);
    let columns: Vec<&[f64]> = case.columns.iter().map(Vec::as_slice).collect();
    for set in InstructionSet::available() {
        let form = case.form.clone().with_instruction_set(set);
        assert_eq!(case.verdicts(&form), verdicts, "{set:?}");
        let counts = form.count(&case.preloads, &case.static_frictions, &columns);
        assert_eq!(counts, verdicts.iter().fold(VerdictCounts::default(), |sum, &verdict| sum + verdict.into()));
    }
    for sample in 0..777 {
        let one = |column: &Vec<f64>| vec![column[sample]];
        let alone = Case {
            form: case.form.clone(),
            preloads: one(&case.preloads),
            static_frictions: one(&case.static_frictions),
            columns: case.columns.iter().map(one).collect(),
        };
        assert_eq!(alone.verdicts(&alone.form), [verdicts[sample]]);
    }
}

#[test]
fn what_is_not_admissible_fails_and_what_is_outside_physics_is_stable() {
    let keys = ["damping.tangential", "disc.inner_radius", "disc.poissons_ratio"];
    let at = |values: [f64; 3], preload: f64, static_friction: f64| {
        let mut case = case(&keys, 0.0, 1, 1, &[]);
        case.columns = values.iter().map(|value| vec![*value]).collect();
        (case.preloads, case.static_frictions) = (vec![preload], vec![static_friction]);
        case.verdicts(&case.form)[0]
    };
    let usual = [300.0, 0.064, 0.3];
    assert_eq!(at(usual, 0.2, 0.45), Verdict::Unstable);
    assert_eq!(at(usual, -0.2, 0.05), Verdict::Stable);
    assert_eq!(at(usual, 0.2, 0.2), Verdict::Stable);
    assert_eq!(at([0.0, 0.064, 0.3], 0.2, 0.45), Verdict::Unstable);
    for values in [[-1.0, 0.064, 0.3], [300.0, 0.2, 0.3], [300.0, 0.064, 0.5], [f64::NAN, 0.064, 0.3]] {
        assert_eq!(at(values, 0.2, 0.45), Verdict::Failed, "{values:?}");
    }
    assert_eq!(at(usual, 0.2, 5.5), Verdict::Failed);
}
