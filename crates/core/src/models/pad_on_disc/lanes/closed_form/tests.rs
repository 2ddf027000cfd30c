use super::*;
use crate::friction::measured_curve::{MeasuredCurve, SharedCurve};
use crate::models::pad_on_disc::parameters::{SCALARS, scalar};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, uniform_draws};

/// A brake that differs in some parameters, with samples.
struct Case {
    form: VaryingClosedForm,
    preloads: Vec<f64>,
    static_frictions: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

/// Brakes that differ in these parameters by up to `spread` of their shared value.
fn case(keys: &[&str], spread: f64, samples: usize, seed: u64, changes: &[(&str, f64)]) -> Case {
    case_of(PadOnDisc::preset_with(changes), keys, spread, samples, seed)
}

fn case_of(shared: PadOnDisc, keys: &[&str], spread: f64, samples: usize, seed: u64) -> Case {
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
        let verdict = boundary.verdict(preload, static_friction);
        let is_clear = [1.0 - 1e-12, 1.0 + 1e-12]
            .iter()
            .all(|factor| boundary.verdict(factor * preload, static_friction) == verdict);
        is_clear.then_some(verdict)
    }
}

const OF_THE_FORM: [&str; 13] = [
    "disc.thickness",
    "disc.outer_radius",
    "pad.effective_radius",
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

/// Brakes with every law, falling and rising again.
fn laws() -> Vec<PadOnDisc> {
    let curve = |deviations: Option<&[f64]>| {
        let curve = MeasuredCurve::new(&[0.0, 0.5, 1.5, 2.5, 4.0], &[0.39, 0.3, 0.27, 0.26, 0.29], deviations);
        LawKind::Table(SharedCurve::new(curve.unwrap()))
    };
    let laws = [
        (LawKind::Stribeck, 1.0, 0.02),
        (LawKind::Stribeck, 2.0, 0.0),
        (LawKind::Stribeck, 1.4, 0.01),
        (LawKind::Rational, 1.0, 0.0),
        (LawKind::Rational, 1.0, 0.01),
        (curve(None), 1.0, 0.0),
        (curve(Some(&[0.02, 0.01, 0.01, 0.02, 0.03])), 1.0, 0.0),
    ];
    let brake = |(law, exponent, viscous): (LawKind, f64, f64)| {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.friction.law = law;
        parameters.friction.stribeck_exponent = exponent;
        parameters.friction.viscous = viscous;
        if law.table().is_some() {
            parameters.friction.kinetic_coefficient = 0.0;
        }
        PadOnDisc::new(parameters).unwrap()
    };
    laws.into_iter().map(brake).collect()
}

#[test]
fn every_law_has_the_verdicts_of_its_own_boundary() {
    for (number, shared) in laws().into_iter().enumerate() {
        let is_table = shared.parameters().friction.law.table().is_some();
        let mut keys = vec!["damping.tangential", "operating_point.rotating_speed", "stiffness.contact_normal"];
        keys.extend(if is_table { ["friction.band"] } else { ["friction.stribeck_velocity"] });
        let mut case = case_of(shared, &keys, 0.6, 3000, number as u64 + 40);
        if is_table {
            let mut draw = uniform_draws(9);
            case.columns[3] = (0..3000).map(|_| 4.0 * draw() - 2.0).collect();
        }
        let mut seen = VerdictCounts::default();
        for (sample, verdict) in case.verdicts(&case.form).into_iter().enumerate() {
            assert!(case.expected(sample).is_none_or(|expected| expected == verdict), "law {number}, sample {sample}");
            seen += verdict.into();
        }
        assert!(seen.stable.min(seen.unstable) > 300, "law {number}: {seen:?}");
    }
}

#[test]
fn a_curve_without_friction_at_its_speed_is_outside_physics() {
    let (rows, deviations) = ([0.45, 0.38, 0.3, 0.28], [0.02, 0.05, 0.08, 0.08]);
    let curve = SharedCurve::new(MeasuredCurve::new(&[0.0, 0.5, 2.0, 5.0], &rows, Some(&deviations)).unwrap());
    let mut parameters = Parameters::sui_ding_2018();
    parameters.friction.law = LawKind::Table(curve);
    parameters.friction.kinetic_coefficient = 0.0;
    parameters.operating_point.rotating_speed = 4.0;
    let brake = PadOnDisc::new(parameters).unwrap();
    let speed = brake.speed_under_pad(4.0);
    // A band below -10 is not admissible.
    let mut case = case_of(brake, &["friction.band"], 0.0, 500, 1);
    case.columns[0] = (0..500).map(|i| -0.02 * f64::from(i)).collect();
    // At 0.54 m/s the curve falls the more the further it is shifted down.
    let limit = -0.39 / 0.45 * curve.coefficient(speed) / curve.deviation(speed);
    let verdicts = case.verdicts(&case.form);
    for (sample, &verdict) in verdicts.iter().enumerate() {
        let expected = if case.columns[0][sample] < limit { Verdict::Stable } else { Verdict::Unstable };
        assert_eq!(verdict, expected, "z = {}", case.columns[0][sample]);
        assert!(case.expected(sample).is_none_or(|expected| expected == verdict), "sample {sample}");
    }
    assert!(verdicts.contains(&Verdict::Stable) && verdicts.contains(&Verdict::Unstable));
}
