//! Spans against the verdicts of single samples.

use stickslip_core::friction::measured_curve::{MeasuredCurve, SharedCurve};
use stickslip_core::model::verdict::Verdict;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

use super::*;

/// What a sample counts as at an expected value, decided as a run decides it.
fn counted(sample: &Sample, varied: usize, outside: OutsidePhysics, value: f64) -> (bool, bool) {
    let least = sample.boundary.least_second;
    let (preload, friction) =
        if varied == 0 { (value * sample.ratio, sample.other) } else { (sample.other, value * sample.ratio) };
    let is_outside = RandomInputs { preload, static_friction: friction }.are_outside_physics(least);
    let fails = (is_outside && outside == OutsidePhysics::WithoutVerdict) || friction > sample.most_second;
    (!fails && sample.boundary.verdict(preload, friction) == Verdict::Unstable, fails)
}

fn boundaries() -> Vec<PairBoundary> {
    let preset = |changes: &[(&str, f64)]| {
        let mut parameters = Parameters::sui_ding_2018();
        changes.iter().for_each(|(key, value)| parameters.set(key, *value).unwrap());
        PadOnDisc::new(parameters).unwrap().stability_boundary()
    };
    let curve =
        MeasuredCurve::new(&[0.0, 1.0, 2.0, 4.0], &[0.4, 0.3, 0.35, 0.45], Some(&[0.03, 0.01, 0.05, 0.02])).unwrap();
    let curve = SharedCurve::new(curve);
    let mut found = vec![
        preset(&[]),
        preset(&[("friction.viscous", 0.01)]),
        preset(&[("damping.tangential", 0.0)]),
        preset(&[("friction.kinetic_coefficient", 0.0)]),
    ];
    for band in [-8.0, -3.0, 0.0, 3.0, 8.0] {
        for speed in [3.0, 10.0, 20.0] {
            let mut parameters = Parameters::sui_ding_2018();
            parameters.friction.use_table(curve);
            parameters.set("friction.band", band).unwrap();
            parameters.set("operating_point.rotating_speed", speed).unwrap();
            found.push(PadOnDisc::new(parameters).unwrap().stability_boundary());
        }
    }
    found
}

#[test]
fn spans_are_where_single_samples_are_unstable_or_fail() {
    let (mut unstable, mut failed, mut below) = (0, 0, 0);
    for boundary in boundaries() {
        below += u32::from(!boundary.is_unstable_above());
        for ratio in [-0.4, 0.0, 0.3, 1.0, 1.7] {
            for (varied, others) in [(0, [-0.2, 0.0, 0.1, 0.26, 0.39, 0.8]), (1, [-0.1, 0.0, 0.01, 0.1, 0.3, 2.0])] {
                for other in others {
                    for most_second in [0.7, f64::INFINITY] {
                        for outside in [OutsidePhysics::Stable, OutsidePhysics::WithoutVerdict] {
                            let sample = Sample { boundary, ratio, other, most_second };
                            let spans = Spans::new(&sample, varied, outside);
                            for i in 0..300 {
                                let value = 0.003_137 + 0.005_113 * f64::from(i);
                                let within = |[from, to]: Span| from < value && value < to;
                                let fails = spans.without_verdict.iter().filter(|&&span| within(span)).count();
                                assert!(fails <= 1, "{sample:?}: {spans:?}");
                                let expected = counted(&sample, varied, outside, value);
                                assert_eq!(
                                    (within(spans.unstable), fails == 1),
                                    expected,
                                    "{varied} {outside:?} {value}: {sample:?}, {spans:?}"
                                );
                                unstable += u32::from(expected.0);
                                failed += u32::from(expected.1);
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(unstable > 5000 && failed > 5000 && below > 0, "{unstable} {failed} {below}");
}
