//! What is recorded of the samples of models given by matrices: damping ratio, growth rate and frequency of their least
//! stable pair.

#![allow(clippy::disallowed_methods, reason = "expected values are computed as a textbook writes them")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::f64::consts::TAU;

use crate::common::{Place, Table, submitted, texts};

const NAMES: [&str; 3] = ["damping_ratio", "growth_rate", "frequency"];

/// The columns of a result in a surface, with the share of samples below it.
const QUANTILES: [(&str, f64); 3] = [("p05", 0.05), ("p50", 0.5), ("p95", 0.95)];

/// Three masses with unequal damping, and friction that couples two of them.
fn three_masses(random: &str, sampling: &str) -> String {
    format!(
        "name = \"three\"\n[model]\nkind = \"matrices\"\nmass = {{ matrix = [[1, 0, 0], [0, 2, 0], [0, 0, 1.5]] }}\n\
         damping = {{ matrix = [[0.3, -0.1, 0], [-0.1, 0.2, 0], [0, 0, 0.1]], factor = \"damping\" }}\n\
         stiffness = [{{ matrix = [[90, -20, -5], [-20, 150, -10], [-5, -10, 200]] }}, \
         {{ matrix = [[0, -40, 0], [30, 0, 0], [0, 0, 0]], factor = \"friction\" }}]\n\
         [model.parameters]\nfriction = 1.0\ndamping = 1.0\n[axes]\nfriction = [-1.5, 0.0, 1.0, 1.6, 3.0]\n\
         [random]\n{random}\n[criterion]\nkind = \"complex-eigenvalue\"\nbands = [[0.0, 0.9], [1.0, 1.5], [1.5, 3.0]]\n\
         record = [\"frequency\", \"damping_ratio\", \"growth_rate\"]\n[sampling]\nseed = 5\n{sampling}\n"
    )
}

/// Friction, band, and damping ratio, growth rate and frequency of NumPy 2: the eigenvalue with `v.imag >= 0` in the band
/// (in any of them for band 0) with the least `-v.real / abs(v)` among `numpy.linalg.eigvals` of
/// `[[0, I], [-M^-1 K, -M^-1 C]]`. The first band has no pair.
const NUMPY: [[f64; 5]; 14] = [
    [-1.5, 0.0, -0.189_857_922_324_836_5, 1.787_067_328_574_410_3, 1.470_823_197_180_664],
    [-1.5, 2.0, -0.189_857_922_324_836_5, 1.787_067_328_574_410_3, 1.470_823_197_180_664],
    [-1.5, 3.0, 0.002_846_927_746_739_462, -0.032_937_843_970_837_66, 1.841_353_172_596_718_7],
    [0.0, 0.0, 0.002_899_248_525_122_641, -0.033_570_798_409_577_44, 1.842_869_284_430_982_6],
    [0.0, 2.0, 0.005_584_230_853_030_667, -0.045_284_759_006_709_81, 1.290_630_895_579_370_2],
    [0.0, 3.0, 0.002_899_248_525_122_641, -0.033_570_798_409_577_44, 1.842_869_284_430_982_6],
    [1.0, 0.0, -0.079_950_807_148_517_43, 0.724_713_383_220_444_2, 1.438_040_348_314_414_6],
    [1.0, 2.0, -0.079_950_807_148_517_43, 0.724_713_383_220_444_2, 1.438_040_348_314_414_6],
    [1.0, 3.0, 0.002_854_313_459_679_585, -0.033_027_802_638_679_216, 1.841_604_543_731_940_6],
    [1.6, 0.0, -0.180_149_570_901_888_93, 1.687_123_341_249_427, 1.466_120_188_704_061_8],
    [1.6, 2.0, -0.180_149_570_901_888_93, 1.687_123_341_249_427, 1.466_120_188_704_061_8],
    [1.6, 3.0, 0.002_831_029_432_655_531, -0.032_739_189_798_965_51, 1.840_525_904_958_245_2],
    [3.0, 0.0, -0.334_583_205_950_354_3, 3.454_700_340_709_602, 1.548_624_346_802_250_3],
    [3.0, 3.0, -0.334_583_205_950_354_3, 3.454_700_340_709_602, 1.548_624_346_802_250_3],
];

#[test]
fn the_least_stable_pair_of_each_band_is_that_of_numpy() {
    let place = Place::new();
    let job = three_masses("inputs = [\"damping\"]\nrelative_std = 0.0", "samples = 3");
    let table = submitted(&place, "three", &job);
    let mut with_pairs = 0;
    for (cell, (&friction, &band)) in table.column("friction").iter().zip(table.column("band")).enumerate() {
        let expected = NUMPY.iter().find(|row| row[0] == friction && row[1] == band);
        with_pairs += usize::from(expected.is_some());
        place.run(&format!("samples three --cell {cell} --out samples.parquet")).done();
        let samples = Table::read(&place.path("samples.parquet"));
        for (place, name) in NAMES.iter().enumerate() {
            let of_surface = |kind: &str| table.column(&format!("{name}_{kind}"))[cell];
            let sample = samples.column(name)[1];
            match expected.map(|row| row[2 + place]) {
                Some(value) => {
                    assert!((sample - value).abs() < 1e-13, "{name} {friction} {band}: {sample} {value}");
                    assert!((of_surface("mean") - value).abs() < 1e-10, "{name} {friction} {band}");
                    QUANTILES.iter().for_each(|(kind, _)| {
                        assert!((of_surface(kind) / value - 1.0).abs() < 1.0 / 2000.0, "{name} {friction} {band}");
                    });
                }
                None => assert!(sample.is_nan() && of_surface("mean").is_nan() && of_surface("p50").is_nan()),
            }
        }
    }
    assert_eq!(with_pairs, NUMPY.len());
    // What `replay` shows of a sample, and the report of a cell.
    let shown = place.run("replay three --cell 8 --sample 0 --json").done().stdout;
    let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
    let row = NUMPY.iter().find(|row| row[0] == table.column("friction")[8] && row[1] == 0.0).unwrap();
    assert!((shown["damping_ratio"].as_f64().unwrap() - row[2]).abs() < 1e-13, "{shown}");
    place.run("report three --out three.html").done();
    let report = std::fs::read_to_string(place.path("three.html")).unwrap();
    assert!(report.contains("\"name\":\"growth rate\"") && report.contains("\"unit\":\"1/s\""));
}

/// Two masses `x'' + c x' + [[k, 1 - D], [1, k]] x = 0`: with `s` a root of `s^2 = 1 - D`, their pairs are those of
/// `lambda^2 + c lambda + k + s = 0` and `k - s`.
#[test]
fn mean_and_quantiles_are_those_of_the_samples_which_have_their_closed_form() {
    const C: f64 = 0.05;
    let bands = [[0.0, 0.25], [0.25, 0.4]];
    let place = Place::new();
    let job = format!(
        "name = \"two\"\n[model]\nkind = \"matrices\"\nmass = {{ matrix = [[1, 0], [0, 1]] }}\n\
         damping = {{ matrix = [[{C}, 0], [0, {C}]] }}\nstiffness = [{{ matrix = [[1, 0], [0, 1]], factor = \"k\" }}, \
         {{ matrix = [[0, 1], [1, 0]] }}, {{ matrix = [[0, -1], [0, 0]], factor = \"D\" }}]\n\
         [model.parameters]\nk = 2.5\nD = {{ value = 0.9, range = [0.0, 1.4] }}\n\
         [random]\ninputs = [\"D\", \"k\"]\nrelative_std = 0.3\n\
         [criterion]\nkind = \"complex-eigenvalue\"\nbands = [[0.0, 0.25], [0.25, 0.4]]\n\
         record = [\"damping_ratio\", \"growth_rate\", \"frequency\"]\n[sampling]\nsamples = 700\nseed = 2\n"
    );
    let table = submitted(&place, "two", &job);
    for (cell, &band) in table.column("band").iter().enumerate() {
        place.run(&format!("samples two --cell {cell}")).done();
        let samples = Table::read(&place.path(&format!("two/samples-{cell}.parquet")));
        let (k, d) = (samples.column("k"), samples.column("D"));
        let outside = samples.column("outside_physics");
        let recorded = NAMES.map(|name| samples.column(name));
        let mut values: [Vec<f64>; 3] = Default::default();
        for sample in 0..700 {
            let pairs = pairs(C, k[sample], d[sample]);
            let in_band = |pair: &&[f64; 3]| {
                let has = |own: usize| bands[own][0] <= pair[2] && pair[2] <= bands[own][1];
                if band == 0.0 { has(0) || has(1) } else { has(band as usize - 1) }
            };
            let least = pairs.iter().filter(in_band).min_by(|a, b| a[0].total_cmp(&b[0]));
            match least.filter(|_| outside[sample] == 0.0) {
                None => assert!(recorded.iter().all(|column| column[sample].is_nan()), "{cell} {sample}"),
                Some(pair) => {
                    for (result, column) in recorded.iter().enumerate() {
                        let difference = (column[sample] - pair[result]).abs();
                        // Where the two pairs nearly meet, rounding moves them by its root.
                        assert!(difference < 1e-11, "{cell} {sample} {}: {difference:e}", NAMES[result]);
                        values[result].push(column[sample]);
                    }
                }
            }
        }
        let count = values[0].len();
        assert!(outside.contains(&1.0) && count > 50 && count < 700, "{count}");
        for (values, name) in values.iter_mut().zip(NAMES) {
            values.sort_by(f64::total_cmp);
            let mean = values.iter().sum::<f64>() / count as f64;
            assert!((table.column(&format!("{name}_mean"))[cell] - mean).abs() < 1e-10, "{name}");
            for (kind, share) in QUANTILES {
                let expected = values[(share * count as f64).ceil() as usize - 1];
                let found = table.column(&format!("{name}_{kind}"))[cell];
                assert!((found / expected - 1.0).abs() < 1.0 / 2000.0, "{name}_{kind}: {found} {expected}");
            }
        }
    }
}

/// Damping ratio, growth rate and frequency of the pairs of two masses that are not below the real axis.
fn pairs(c: f64, k: f64, d: f64) -> Vec<[f64; 3]> {
    let figures = |re: f64, im: f64| [-re / (re * re + im * im).sqrt(), re, im / TAU];
    if d <= 1.0 {
        let of = |kappa: f64| {
            let square = kappa - 0.25 * c * c;
            if square >= 0.0 {
                return vec![figures(-0.5 * c, square.sqrt())];
            }
            [1.0, -1.0].map(|sign| figures(-0.5 * c + sign * (-square).sqrt(), 0.0)).to_vec()
        };
        let s = (1.0 - d).sqrt();
        return [of(k + s), of(k - s)].concat();
    }
    // The roots of c^2 / 4 - k -+ i r.
    let (re, im) = (0.25 * c * c - k, (d - 1.0).sqrt());
    let size = (re * re + im * im).sqrt();
    let (x, y) = ((0.5 * (size + re)).sqrt(), (0.5 * (size - re)).sqrt());
    vec![figures(-0.5 * c + x, y), figures(-0.5 * c - x, y)]
}

#[test]
fn threads_shards_and_kills_do_not_change_a_byte() {
    let place = Place::new();
    let random = "inputs = [\"friction\", \"damping\"]\nrelative_std = { friction = 0.2, damping = 0.4 }\n\
        distribution = { damping = \"lognormal\" }";
    place.write("job.toml", &three_masses(random, "samples = 24_500"));
    place.run("submit job.toml --threads 1 --out whole").done();
    place.run("submit job.toml --threads 3 --out 3").done();
    assert!(place.surface("whole") == place.surface("3"));
    for step in 0..5 {
        place.run(&format!("submit job.toml --out shards --shard {}/5", step * 3 % 5 + 1)).done();
    }
    place.run("merge shards").done();
    assert!(place.surface("whole") == place.surface("shards"));
    place.assert_survives_kills("whole", &[150, 300, 200, 350, 250], 2);
    place.run("samples whole --cell 9 --threads 1").done();
    place.run("samples killed --cell 9 --threads 2 --out again.parquet").done();
    let read = |name: &str| std::fs::read(place.path(name)).unwrap();
    assert!(read("whole/samples-9.parquet") == read("again.parquet"));
    // Samples without what is recorded are the same.
    let plain = three_masses(random, "samples = 24_500").replace("record = [", "# record = [");
    let (plain, recorded) = (submitted(&place, "plain", &plain), Table::read(&place.path("whole/surface.parquet")));
    assert!(plain.names().iter().all(|name| plain.column(name) == recorded.column(name)));
    assert_eq!(recorded.names().len(), plain.names().len() + 12);
}

#[test]
fn what_cannot_record_says_so() {
    let place = Place::new();
    let two = "inputs = [\"friction\", \"damping\"]\nrelative_std = 0.1";
    let refused = "records nothing of its samples; remove criterion.record";
    for (random, sampling, change, texts) in [
        (two, "method = \"importance\"", ["", ""], &[refused][..]),
        (two, "method = \"subset\"", ["", ""], &[refused]),
        (two, "method = \"conditional\"", ["", ""], &[refused]),
        ("inputs = [\"friction\"]\nrelative_std = 0.1", "method = \"exact\"", ["", ""], &[refused]),
        (two, "", ["[\"frequency\"", "[\"frequencies\""], &["frequencies", "did you mean `frequency`?"]),
        (two, "", ["record =", "matrices = \"full\"\nrecord ="], &["criterion.record needs all pairs", "reduce"]),
        (two, "", ["damping = 1.0", "damping = 1.0\ngrowth_rate = 2.0"], &["model.parameters.growth_rate", "column"]),
    ] {
        let mut job = three_masses(random, sampling);
        if !change[0].is_empty() {
            job = job.replacen(change[0], change[1], 1);
        }
        place.write("job.toml", &job);
        place.run("check job.toml").refused(65, texts);
    }
    // A part of them, in any order and twice, is the same job.
    let job = three_masses(two, "samples = 100");
    let hash = |record: &str| {
        let text = job.replace("[\"frequency\", \"damping_ratio\", \"growth_rate\"]", record);
        let table = submitted(&place, &format!("r{}", record.len()), &text);
        assert_eq!(table.names().iter().filter(|name| name.ends_with("_p95")).count(), 2);
        table.footer.iter().find(|(key, _)| key == "stickslip:job_hash").unwrap().1.clone()
    };
    let [a, b] = ["[\"frequency\", \"growth_rate\"]", "[\"growth_rate\", \"frequency\", \"growth_rate\"]"].map(hash);
    assert_eq!(a, b);
}

/// An oscillator with the damping ratio c / (2 sqrt(k m)), which is lognormal if c and k are.
const OSCILLATOR: &str = r#"
name = "oscillator"
[model]
kind = "matrices"
mass = { matrix = [[4.0]] }
damping = { matrix = [[1.0]], factor = "c" }
stiffness = { matrix = [[1.0]], factor = "k" }
[model.parameters]
c = 0.4
k = 100.0
unused = 1.0
[random]
inputs = ["c", "k", "unused"]
relative_std = { c = 0.2, k = 0.5, unused = 0.1 }
distribution = "lognormal"
[criterion]
kind = "complex-eigenvalue"
record = ["damping_ratio", "frequency"]
[sampling]
samples = 40_000
sensitivity = true
seed = 3
"#;

#[test]
fn sobol_indices_of_recorded_results_are_those_of_a_product() {
    let place = Place::new();
    let table = submitted(&place, "oscillator", OSCILLATOR);
    let index = |result: &str, kind: &str| {
        let name = format!("{result}_{kind}");
        [table.column(&name)[0], table.column(&format!("{name}_error"))[0]]
    };
    // The logarithms have the variances ln(1 + std^2), and the product of a power of each its own.
    let variance = |std: f64, power: f64| power * power * libm::log1p(std * std);
    let [of_c, of_k] = [variance(0.2, 1.0), variance(0.5, 0.5)].map(libm::expm1);
    let whole = (1.0 + of_c) * (1.0 + of_k) - 1.0;
    for (input, own, other) in [("c", of_c, of_k), ("k", of_k, of_c)] {
        for (kind, expected) in [("first_order", own / whole), ("total", 1.0 - other / whole)] {
            let [value, error] = index("damping_ratio", &format!("{kind}_{input}"));
            assert!(
                (value - expected).abs() < 4.0 * error && error < 0.02,
                "{kind} {input}: {value} {error} {expected}"
            );
        }
    }
    // The undamped frequency is that of k alone, up to the square of the damping ratio.
    let [of_k, _] = index("frequency", "first_order_k");
    assert!((of_k - 1.0).abs() < 1e-3, "{of_k}");
    for result in ["damping_ratio", "frequency"] {
        assert_eq!(index(result, "first_order_unused"), [0.0, 0.0]);
        assert_eq!(index(result, "total_unused"), [0.0, 0.0]);
        assert_eq!(table.column(&format!("{result}_n_left_out_c")), [0.0]);
    }
    // No sample is unstable, so that the verdict has none; those of the result are drawn.
    place
        .run("plot oscillator --of sobol")
        .refused(65, &["in each all samples agree", "see --result damping_ratio and --result frequency"]);
    let files = place.run("plot oscillator --of sobol --result damping_ratio").done().stdout;
    assert_eq!(files, "oscillator/sobol-damping_ratio.svg\noscillator/sobol-damping_ratio.png\n");
    let picture = std::fs::read_to_string(place.path("oscillator/sobol-damping_ratio.svg")).unwrap();
    assert!(picture.contains("Share of the variance of the damping ratio"), "{picture}");
    place.run("plot oscillator --of sobol --result damping").refused(64, &["there are damping_ratio, frequency"]);
}

#[test]
fn sobol_indices_of_recorded_results_are_those_of_any_pieces() {
    let place = Place::new();
    submitted(&place, "whole", OSCILLATOR);
    place.write("job.toml", OSCILLATOR);
    for shard in 1..4 {
        place.run(&format!("submit job.toml --out shards --shard {shard}/3")).done();
    }
    place.run("merge shards").done();
    assert!(place.surface("whole") == place.surface("shards"));
    place.run("verify whole").done();
}

#[test]
fn a_report_has_indices_and_modes_of_matrices() {
    let place = Place::new();
    submitted(&place, "oscillator", &OSCILLATOR.replace("40_000", "200"));
    place.run("report oscillator").done();
    let page = std::fs::read_to_string(place.path("oscillator/report.html")).unwrap();
    for part in ["id=\"modes\"", "id=\"squeal-frequencies\"", "\"of\":\"damping ratio\"", "\"of\":\"frequency\""] {
        assert!(page.contains(part), "{part}");
    }
}

/// Brakes far from the preset, each with the keys of its friction law, and whether every speed below the critical one is
/// unstable.
const BRAKES: [(&str, bool); 5] = [
    ("", true),
    ("[model.friction]\nstribeck_exponent = 0.6\n", true),
    // With an exponent above 1 very slow sliding is stable again.
    ("[model.friction]\nstribeck_exponent = 2.5\nstribeck_velocity = 0.9\n", false),
    ("[model.friction]\nlaw = \"rational\"\n", true),
    ("[model.friction]\nviscous = 0.004\n[model.damping]\ntangential = 40.0\n", true),
];

#[test]
fn growth_rates_critical_speeds_and_critical_preloads_agree_with_every_verdict() {
    let place = Place::new();
    let (mut unstable, mut never, mut seen) = (0, 0, 0);
    for (number, (friction, is_unstable_below)) in BRAKES.into_iter().enumerate() {
        let job = format!(
            "name = \"brake\"\n{friction}[axes]\npreload = [0.01, 0.1, 0.6]\nstatic_friction = [0.26, 0.45]\n\
             rotating_speed = [0.3, 6.0, 15.0]\n[random]\ninputs = [\"preload\", \"static_friction\", \
             \"damping.tangential\", \"pad.mass\", \"stiffness.contact_normal\"]\nrelative_std = 0.35\n\
             [criterion]\nkind = \"eigenvalue\"\nrecord = [\"critical_preload\", \"growth_rate\", \"critical_speed\"]\n\
             [sampling]\nsamples = 300\nseed = {number}\n"
        );
        let run = format!("b{number}");
        let surface = submitted(&place, &run, &job);
        for (cell, speed) in surface.column("rotating_speed_rad_s").iter().enumerate() {
            place.run(&format!("samples {run} --cell {cell} --out samples.parquet")).done();
            let samples = Table::read(&place.path("samples.parquet"));
            let [rates, speeds, preloads, drawn, outside] =
                ["growth_rate", "critical_speed", "critical_preload", "preload", "outside_physics"]
                    .map(|name| samples.column(name).to_vec());
            for (sample, verdict) in texts(&place.path("samples.parquet"), "verdict").into_iter().flatten().enumerate()
            {
                if outside[sample] == 1.0 || verdict == "failed" {
                    assert!(rates[sample].is_nan() && speeds[sample].is_nan(), "{run} {cell} {sample}");
                    continue;
                }
                let is_unstable = verdict == "unstable";
                seen += 1;
                unstable += usize::from(is_unstable);
                never += usize::from(speeds[sample] == 0.0);
                let all = (rates[sample], speeds[sample], preloads[sample]);
                assert_eq!(rates[sample] > 0.0, is_unstable, "{run} {cell} {sample}: {all:?}");
                // No number: none is large enough.
                assert_eq!(drawn[sample] > preloads[sample], is_unstable, "{run} {cell} {sample}: {all:?}");
                let is_below = *speed < speeds[sample];
                assert!(is_below == is_unstable || (is_below && !is_unstable_below), "{run} {cell} {sample}: {all:?}");
            }
        }
        // A quotient whose divisor may vanish has no mean.
        let has_mean = |name: &str| surface.names().contains(&format!("{name}_mean"));
        assert_eq!(["growth_rate", "critical_speed", "critical_preload"].map(has_mean), [true, true, false]);
        // The run keeps the distribution of these very samples.
        let cell = surface.column("rotating_speed_rad_s").len() - 1;
        let samples = Table::read(&place.path("samples.parquet"));
        for name in ["growth_rate", "critical_speed", "critical_preload"] {
            let mut values: Vec<f64> = samples.column(name).iter().copied().filter(|value| !value.is_nan()).collect();
            values.sort_by(f64::total_cmp);
            for (kind, share) in QUANTILES {
                let expected = values[((share * values.len() as f64).ceil() as usize).max(1) - 1];
                let found = surface.column(&format!("{name}_{kind}"))[cell];
                assert!((found - expected).abs() <= 6e-4 * expected.abs(), "{run} {name} {kind}: {found} {expected}");
            }
        }
    }
    assert!(unstable > 3000 && seen - unstable > 3000 && never > 100, "{unstable} of {seen}, {never}");
}

#[test]
fn the_growth_rate_with_a_flexible_disc_agrees_with_every_verdict() {
    let place = Place::new();
    let job = "name = \"coupled\"\n[axes]\npreload = [0.02, 0.12]\nstatic_friction = 0.39\nrotating_speed = [8.0, 15.0]\n\
        [random]\ninputs = [\"preload\", \"static_friction\", \"pad.mass\"]\nrelative_std = 0.2\n\
        [criterion]\nkind = \"coupled-eigenvalue\"\nrecord = [\"growth_rate\"]\n[sampling]\nsamples = 250\nseed = 2\n";
    let surface = submitted(&place, "coupled", job);
    let (mut unstable, mut stable) = (0, 0);
    for cell in 0..surface.column("preload").len() {
        place.run(&format!("samples coupled --cell {cell} --out samples.parquet")).done();
        let samples = Table::read(&place.path("samples.parquet"));
        let (rates, outside) = (samples.column("growth_rate"), samples.column("outside_physics"));
        for (sample, verdict) in texts(&place.path("samples.parquet"), "verdict")
            .into_iter()
            .flatten()
            .enumerate()
            .filter(|(i, _)| outside[*i] == 0.0)
        {
            assert_eq!(rates[sample] > 0.0, verdict == "unstable", "{cell} {sample}: {}", rates[sample]);
            *(if rates[sample] > 0.0 { &mut unstable } else { &mut stable }) += 1;
        }
    }
    assert!(unstable > 200 && stable > 200, "{unstable} {stable}");
}

#[test]
fn critical_speeds_and_forces_on_a_belt_have_their_closed_form() {
    let place = Place::new();
    let job = "name = \"belt\"\n[model]\nkind = \"belt-oscillator\"\nmass = 2.0\nstiffness = 50.0\ndamping = 0.3\n\
        normal_force = 3.0\nbelt_speed = 0.7\n[model.friction]\nstatic_coefficient = 0.9\nkinetic_coefficient = 0.4\n\
        stribeck_velocity = 0.5\n[random]\ninputs = [\"normal_force\", \"damping\"]\nrelative_std = 0.3\n\
        [criterion]\nkind = \"eigenvalue\"\nrecord = [\"critical_normal_force\", \"critical_speed\", \"growth_rate\"]\n\
        [sampling]\nsamples = 500\nseed = 4\n";
    submitted(&place, "belt", job);
    place.run("samples belt --cell 0 --out samples.parquet").done();
    let samples = Table::read(&place.path("samples.parquet"));
    let column = |name: &str| samples.column(name);
    let [forces, dampings, speeds, critical, rates, outside] =
        ["normal_force", "damping", "critical_speed", "critical_normal_force", "growth_rate", "outside_physics"]
            .map(column);
    // Three at most are recorded at once; another run with the same seed has the same samples.
    let names = "\"critical_normal_force\", \"critical_speed\", \"growth_rate\"";
    submitted(&place, "again", &job.replace(names, "\"frequency\""));
    place.run("samples again --cell 0 --out again.parquet").done();
    let again = Table::read(&place.path("again.parquet"));
    assert_eq!(again.column("normal_force"), forces);
    let frequencies = again.column("frequency");
    let mut compared = 0;
    for sample in (0..forces.len()).filter(|&sample| outside[sample] == 0.0 && dampings[sample] > 0.0) {
        // -N mu'(V) = N (f_s - f_c) / v_s exp(-V / v_s) = c where steady sliding loses its stability.
        let (force, damping) = (forces[sample], dampings[sample]);
        let speed = (0.5 * (force * 0.5 / (0.5 * damping)).ln()).max(0.0);
        let needed = damping * 0.5 * (0.7_f64 / 0.5).exp() / 0.5;
        let rate = 0.5 * (force * 0.5 / 0.5 * (-0.7_f64 / 0.5).exp() - damping) / 2.0;
        let frequency = (50.0_f64 / 2.0 - rate * rate).sqrt() / TAU;
        let pairs = [
            (speeds[sample], speed),
            (critical[sample], needed),
            (rates[sample], rate),
            (frequencies[sample], frequency),
        ];
        for (found, expected) in pairs {
            assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{sample}: {found} {expected}");
        }
        compared += 1;
    }
    assert!(compared > 450, "{compared}");
}

/// Without scatter every sample is the brake that `analyse` looks at; with it, no stable brake above the end of stick-slip
/// has a cycle.
#[test]
fn limit_cycles_of_samples_are_those_that_analyse_finds() {
    let place = Place::new();
    let job = |std: f64| {
        format!(
            "name = \"cycles\"\n[axes]\npreload = 0.1\nstatic_friction = 0.39\nrotating_speed = [10.0, 20.0, 40.0]\n\
             [random]\ninputs = [\"preload\"]\nrelative_std = {std}\n[criterion]\nkind = \"eigenvalue\"\n\
             record = [\"cycle_velocity\", \"cycle_amplitude\", \"cycle_frequency\"]\n[sampling]\nsamples = 40\n"
        )
    };
    let surface = submitted(&place, "still", &job(0.0));
    for (cell, speed) in [10.0, 20.0].into_iter().enumerate() {
        let said = place.run(&format!("analyse --set operating_point.rotating_speed={speed} --json")).done().stdout;
        let cycle = &serde_json::from_str::<serde_json::Value>(&said).unwrap()["limit_cycle"];
        let number = |key: &str| cycle[key].as_f64().unwrap();
        let amplitude = 0.5e-3 * (number("x_max_mm") - number("x_min_mm"));
        for (name, expected) in [("cycle_amplitude", amplitude), ("cycle_frequency", number("frequency_hz"))] {
            let found = surface.column(&format!("{name}_mean"))[cell];
            assert!((found / expected - 1.0).abs() < 1e-6, "{speed} {name}: {found} {expected}");
        }
        // Somewhat slower than a harmonic motion of this amplitude, as it sticks.
        let harmonic = TAU * number("frequency_hz") * amplitude / 2.0_f64.sqrt();
        let velocity = surface.column("cycle_velocity_mean")[cell];
        assert!((0.9..1.3).contains(&(velocity / harmonic)), "{speed}: {velocity} {harmonic}");
    }
    assert!(surface.column("cycle_velocity_p50")[2].is_nan(), "stick-slip ends at 30.197 rad/s");
    let scattered = submitted(&place, "scattered", &job(0.2));
    let [p05, p95] = ["p05", "p95"].map(|kind| scattered.column(&format!("cycle_amplitude_{kind}"))[0]);
    let middle = surface.column("cycle_amplitude_p50")[0];
    assert!(p05 < middle && middle < p95, "{p05} {middle} {p95}");
}

#[test]
fn results_that_a_criterion_does_not_have_are_refused() {
    let place = Place::new();
    let job = |criterion: &str| {
        format!(
            "name = \"x\"\n[axes]\npreload = 0.1\nstatic_friction = 0.39\nrotating_speed = 15.0\n[random]\n\
             inputs = [\"preload\"]\nrelative_std = 0.1\n[criterion]\n{criterion}\n[sampling]\nsamples = 10\n"
        )
    };
    for (criterion, texts) in [
        (
            "kind = \"eigenvalue\"\nrecord = [\"amplitude\"]",
            ["\"amplitude\" is no result of kind = \"eigenvalue\"", "critical_speed"],
        ),
        (
            "kind = \"coupled-eigenvalue\"\nrecord = [\"growth_rate\", \"critical_speed\"]",
            ["\"critical_speed\" is no result", "there are \"growth_rate\", \"frequency\""],
        ),
        (
            "kind = \"time-domain\"\ndisc = \"rigid\"\nrecord = [\"growth_rate\"]",
            ["\"growth_rate\" is no result", "there is \"amplitude\""],
        ),
        (
            "kind = \"eigenvalue\"\nrecord = [\"growth_rate\", \"frequency\", \"frequency\", \"critical_speed\", \"cycle_velocity\"]",
            ["criterion.record has 4 results", "a run records 3 at most"],
        ),
        ("kind = \"eigenvalue\"\nrecord = [\"critical_sped\"]", ["critical_sped", "did you mean `critical_speed`?"]),
    ] {
        place.write("job.toml", &job(criterion));
        place.run("check job.toml").refused(65, &texts);
    }
}
