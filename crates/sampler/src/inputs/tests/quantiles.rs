//! Quantiles against independent ones.

use super::*;

/// Compares the inputs at `DEVIATES` with quantiles at `Phi(z)` computed by mpmath 1.3 to 60 digits, those at -3,
/// 0.5 and 2 also with scipy.stats of SciPy 1.17.1, which has fewer.
fn assert_quantiles(marginal: &Marginal, relative_std: f64, quantiles: [f64; 9]) {
    for (z, quantile) in DEVIATES.into_iter().zip(quantiles) {
        let value = marginal.value(EXPECTED, relative_std, z);
        assert!((value - quantile).abs() < 1e-15 * f64::max(1.0, quantile), "{marginal:?}, {z}: {value}");
    }
}

#[test]
fn normal_inputs_are_the_plain_formula() {
    for z in DEVIATES {
        assert_eq!(Marginal::Normal.value(EXPECTED, 0.25, z), EXPECTED * (1.0 + 0.25 * z));
    }
}

#[test]
fn quantiles_agree_with_independent_ones() {
    assert_quantiles(
        &Marginal::Lognormal,
        0.25,
        [
            0.05277665810715353,
            0.18076039992555734,
            0.29577935413774864,
            0.3691534312664431,
            0.37835557505667944,
            0.4279236392727117,
            0.619105554484107,
            1.657653771038709,
            2.712429060699983,
        ],
    );
    assert_quantiles(
        &Marginal::Uniform,
        0.25,
        [
            0.2211250462620347,
            0.22158097419731948,
            0.27471084359795445,
            0.37654815164471706,
            0.39,
            0.454666428580412,
            0.5511910987774028,
            0.5588749534047457,
            0.5588749537379654,
        ],
    );
    assert_quantiles(
        &truncated(-2.0, 3.0),
        0.25,
        [
            0.1950000000000011,
            0.19732296717838843,
            0.2998495449526639,
            0.3831101485812436,
            0.39261538214760017,
            0.4404428139254967,
            0.5835734162074699,
            0.6824999788183126,
            0.6824999999999867,
        ],
    );
    assert_quantiles(
        &truncated(f64::NEG_INFINITY, 1.0),
        0.25,
        [
            -0.3920713020737859,
            0.09240731015397476,
            0.28176787294971434,
            0.3620448178644518,
            0.3704830655987281,
            0.4101233869186256,
            0.48007022652292575,
            0.4874999996655344,
            0.4874999999999998,
        ],
    );
    // Truncated to one tail of the normal distribution, where the other probability is 1 up to rounding.
    assert_quantiles(
        &truncated(4.0, 6.0),
        0.25,
        [
            0.78,
            0.7800311659633633,
            0.7839676991245881,
            0.7939974993475779,
            0.7957069736537863,
            0.8063276682627708,
            0.85985003784252,
            0.9749994986098935,
            0.9749999999996839,
        ],
    );
    assert_quantiles(
        &truncated(-6.0, -5.5),
        0.25,
        [
            -0.19499999999999984,
            -0.19461462661839307,
            -0.17308299281818565,
            -0.15844538280214185,
            -0.1571902473694312,
            -0.1521679558766739,
            -0.14662472257839987,
            -0.14625000001607974,
            -0.14625000000000002,
        ],
    );
}

#[test]
fn quantiles_of_further_distributions_agree_with_independent_ones() {
    let cases: [(Marginal, f64, [f64; 9]); 9] = [
        (
            Marginal::Weibull,
            0.25,
            [
                0.00019178857327447772,
                0.09973364062729106,
                0.2901855402255347,
                0.38398521522931467,
                0.39401979386210867,
                0.44264434311281264,
                0.5725070003260075,
                0.8326283496068296,
                0.9344057764334726,
            ],
        ),
        (
            Marginal::Weibull,
            2.0,
            [
                2.1434369968198635e-29,
                1.1576318679914862e-06,
                0.008825842507485913,
                0.09201204223190741,
                0.1141867518114551,
                0.302411207075624,
                2.6044622483300626,
                59.873161218677474,
                157.19058943444827,
            ],
        ),
        (
            Marginal::Gumbel,
            0.25,
            [
                0.07581151488126496,
                0.202575010292838,
                0.29972296834406037,
                0.3653836620082749,
                0.37398228506365755,
                0.4219200846674361,
                0.6328460945670364,
                1.922538073002961,
                3.007856645258011,
            ],
        ),
        (
            SYMMETRIC,
            0.25,
            [
                0.15117475850274886,
                0.163584005413196,
                0.2857057802992958,
                0.380290745728492,
                0.39,
                0.44121816122221996,
                0.5778819353257376,
                0.6288146411992122,
                0.6288252414972512,
            ],
        ),
        (
            Marginal::Triangular { mode: 0.125 },
            0.25,
            [
                0.22562919393265887,
                0.23132294690614136,
                0.287867704836964,
                0.3627027119744498,
                0.37402849263438454,
                0.43620498213745734,
                0.6021085115345908,
                0.663938471387412,
                0.6639513396611654,
            ],
        ),
        (
            Marginal::Triangular { mode: 0.0 },
            0.25,
            [
                0.2521141776686234,
                0.2523934696546108,
                0.2863449681340024,
                0.36184518841705976,
                0.37327164466275353,
                0.436000824941775,
                0.6033790813800769,
                0.6657586516847112,
                0.6657716343453696,
            ],
        ),
        (
            Marginal::Triangular { mode: 1.0 },
            0.25,
            [
                0.11422836565463042,
                0.12942652716603248,
                0.27899454464302137,
                0.3948369959631801,
                0.4067283553372465,
                0.45820200317200366,
                0.5231533705258715,
                0.5278858221273222,
                0.5278858223313767,
            ],
        ),
        (
            BETA,
            0.25,
            [
                0.1950000520321038,
                0.2052741692420509,
                0.2882993421904864,
                0.36976181444704076,
                0.38027318732241105,
                0.43569253833130606,
                0.6029466817575065,
                0.7756787619837028,
                0.7797975790792432,
            ],
        ),
        (
            Marginal::Beta { low: 0.0, high: 1.25 },
            0.25,
            [
                3.136020305124639e-07,
                0.042845682205752626,
                0.2870492265147697,
                0.4124689318541278,
                0.4227181741584998,
                0.46047239589255745,
                0.4871660899351069,
                0.4874999999999998,
                0.4875,
            ],
        ),
    ];
    for (marginal, relative_std, quantiles) in cases {
        assert_quantiles(&marginal, relative_std, quantiles);
    }
    // Nearly all values are at the ends: the spacing of p matters most here.
    let two_ends = Marginal::Beta { low: 0.5, high: 1.5 };
    for (z, quantile) in DEVIATES.into_iter().zip([
        0.195,
        0.195,
        0.195,
        0.20162276258100584,
        0.39,
        0.584999999974467,
        0.585,
        0.585,
        0.585,
    ]) {
        assert!((two_ends.value(EXPECTED, 0.49, z) - quantile).abs() < 5e-15, "{z}");
    }
    // scipy.stats.beta.ppf and isf of SciPy 1.17.1, which has 12 digits for shapes as large as these.
    for (z, quantile) in DEVIATES.into_iter().zip([
        0.38688827993012886,
        0.3888310434435598,
        0.3896099996751588,
        0.3899608712489171,
        0.3899998699996437,
        0.3901949027313502,
        0.39078038954574906,
        0.39234451319353686,
        0.39312809949447197,
    ]) {
        assert!((BETA.value(EXPECTED, 0.001, z) - quantile).abs() < 1e-13, "{z}");
    }
}

#[test]
fn small_values_are_accurate() {
    // Relative errors; quantiles by mpmath 1.4 with 60 digits.
    for (marginal, z, quantile) in [
        (Marginal::Weibull, -8.0, 2.1434369968198635e-29),
        (Marginal::Weibull, -3.0, 1.1576318679914862e-06),
        (Marginal::Weibull, 8.0, 157.19058943444827),
        (Marginal::Weibull, -20.0, 1.460255460368273e-164),
    ] {
        let value = marginal.value(EXPECTED, 2.0, z);
        assert!((value / quantile - 1.0).abs() < 3e-14, "{marginal:?}, {z}: {value}");
    }
}

#[test]
fn weibull_shapes_agree_with_high_precision() {
    // mpmath 1.4: the root of the same equation with 60 digits. The two sides of the series' end are among them.
    for (relative_std, shape) in [
        (1e-6, 7.796_972_454_841_823e-7),
        (0.01, 0.007_841_282_818_305_445),
        (0.062, 0.050_019_749_250_366_87),
        (0.0625, 0.050436513314900935),
        (0.25, 0.220_156_998_299_055_06),
        (1.0, 1.0),
        (2.0, 1.842_663_915_697_497),
        (10.0, 4.288_040_383_764_877),
    ] {
        let computed = weibull::inverse_shape(relative_std);
        assert!((computed / shape - 1.0).abs() < 3e-14, "{relative_std}: {computed}");
    }
    assert_eq!(weibull::inverse_shape(0.0), 0.0);
}

#[test]
fn small_values_of_a_uniform_input_down_to_zero_are_accurate() {
    // EXPECTED * 2 * scipy.stats.norm.cdf(z), SciPy 1.17.1.
    for (z, quantile) in [
        (-8.2, 9.375094203333874e-17),
        (-6.0, 7.695383631294018e-10),
        (-3.0, 0.001052920464671473),
        (-1.5, 0.0521096169897093),
        (-0.5, 0.24065928020626978),
    ] {
        let value = Marginal::Uniform.value(EXPECTED, WIDEST_UNIFORM, z);
        assert!((value / quantile - 1.0).abs() < 1e-13, "{z}: {value}");
    }
}

#[test]
fn measured_values_have_their_own_distribution() {
    let measured = Marginal::Empirical(Empirical::new(&MEASURED).unwrap());
    // 0.39 numpy.quantile(values / mean, scipy.special.ndtr(z), method="hazen"), NumPy 2.4.6 and SciPy 1.17.1.
    assert_quantiles(
        &measured,
        0.0,
        [
            0.288941605839416,
            0.288941605839416,
            0.30110877301189887,
            0.36309408780756186,
            0.36864963503649634,
            0.4184671532846715,
            0.577883211678832,
            0.577883211678832,
            0.577883211678832,
        ],
    );
    let (mean, std) = measured.moments(EXPECTED, 0.0);
    assert_eq!(mean, EXPECTED);
    assert!((std / EXPECTED - 0.21849602247385227).abs() < 1e-15, "{std}");
    // Mean and variance over p, on a grid that contains every corner.
    let points = 7 * 4096;
    let inputs: Vec<f64> = (0..points)
        .map(|i| measured.value(1.0, 0.0, normal::quantile((f64::from(i) + 0.5) / f64::from(points))))
        .collect();
    let mean = inputs.iter().sum::<f64>() / f64::from(points);
    let variance = inputs.iter().map(|x| (x - 1.0) * (x - 1.0)).sum::<f64>() / f64::from(points);
    assert!((mean - 1.0).abs() < 1e-12, "{mean}");
    assert!((variance.sqrt() - 0.21849602247385227).abs() < 1e-7, "{variance}");
    // The order of the values has no effect.
    let mut sorted = MEASURED;
    sorted.sort_by(f64::total_cmp);
    assert_eq!(measured, Marginal::Empirical(Empirical::new(&sorted).unwrap()));
}
