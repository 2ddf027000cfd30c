//! Models given by matrices, as a user runs them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::sync::Arc;

use faer::sparse::{SparseColMat, Triplet};
use stickslip_core::model::quantity::Limits;
use stickslip_core::model::verdict::Verdict;
use stickslip_core::model::{Columns, Model};
use stickslip_core::models::matrices::factor::Factor;
use stickslip_core::models::matrices::model::{ComplexEigenvalue, MatrixModel};
use stickslip_core::models::matrices::problem::Solver;
use stickslip_core::models::matrices::terms::{Matrices, Matrix, Parameter, Term};

use crate::common::{Place, Table, repository, submitted};
use crate::published_models::OF_ZERO;

/// Two masses of Hoffmann, Fischer, Allgaier and Gaul (2002) with further keys of the model and the criterion.
fn two_masses(damping: &str, rest: &str) -> String {
    format!(
        "name = \"two\"\n[model]\nkind = \"matrices\"\nmass = {{ matrix = [[1, 0], [0, 1]] }}\n{damping}\nstiffness = [{{ matrix = \
         [[2, 1], [1, 2]] }}, {{ matrix = [[0, -1.3333333333333333], [0, 0]], factor = \"friction\" }}]\n\
         [model.parameters]\nfriction = 0.7\n{rest}"
    )
}

const SCATTER: &str = "[random]\ninputs = [\"friction\"]\nrelative_std = 0.1\n";
const CRITERION: &str = "[criterion]\nkind = \"complex-eigenvalue\"\n";

/// The share of a normal friction with 10 % scatter above a critical value.
fn above(critical: f64, mean: f64) -> f64 {
    stickslip_sampler::special_functions::normal::upper_tail((critical - mean) / (0.1 * mean))
}

/// Without damping they flutter above 3/4; with c1 = c2 = c above `D = k12 + c^2 (k11 + k22) / (2 k12)`, from the Hurwitz
/// condition of the quartic (fourth digit: its exact root is compared in the core).
#[test]
fn two_masses_flutter_as_their_formula_says() {
    let place = Place::new();
    let rest = format!(
        "[axes]\nfriction = [0.6, 0.7, 0.75, 0.8]\n{SCATTER}{CRITERION}[sampling]\nsamples = 20_000\nseed = 3\n"
    );
    let table = submitted(&place, "two", &two_masses("", &rest));
    for (mean, p) in table.column("friction").iter().zip(table.column("p_unstable")) {
        assert!((p - above(0.75, *mean)).abs() < 0.012, "{mean} {p}");
    }
    // The report says nothing of a preset that the model does not have.
    place.run("report two --out two.html").done();
    assert!(!std::fs::read_to_string(place.path("two.html")).unwrap().contains("preset sui-ding"));
    // Rare events of it, by the damping ratio as a limit state.
    let rest =
        format!("[axes]\nfriction = [0.5]\n{SCATTER}{CRITERION}[sampling]\nmethod = \"importance\"\nsamples = 4096\n");
    let damped = two_masses("damping = { matrix = [[0.001, 0], [0, 0.001]] }", &rest);
    let table = submitted(&place, "rare", &damped);
    let (p, expected) = (table.column("p_unstable")[0], above(0.75, 0.5));
    assert!((p / expected - 1.0).abs() < 0.05, "{p:e} {expected:e}");
}

/// A stiffness of the wrong sign lets a motion go away without swinging, and a pair may flutter below the band: no verdict
/// counts them.
#[test]
fn a_brake_that_is_unstable_outside_of_its_band_is_said_to_be() {
    let place = Place::new();
    let said = |stiffness: &str, friction: f64, band: &str| {
        let rest = format!("[axes]\nfriction = [{friction}]\n{SCATTER}{CRITERION}frequency = {band}\n");
        let model = two_masses("damping = { matrix = [[0.01, 0], [0, 0.01]] }", &rest);
        let model =
            model.replace("[[2, 1], [1, 2]]", stiffness).replace("friction = 0.7", &format!("friction = {friction}"));
        place.write("two.toml", &model);
        place.run("check two.toml").done().stderr
    };
    // With little friction K has nearly the eigenvalues of [[-2, 1], [1, 2]], whose square is 5: one motion grows, and the
    // other swings with 0.238 Hz.
    let divergence = said("[[-2, 1], [1, 2]]", 0.01, "[0.1, 1.0]");
    let words =
        "a motion of the expected brake is unstable outside of the band, at 0 Hz (it goes away without swinging)";
    assert!(divergence.contains(words), "{divergence}");
    // Above its critical friction a pair flutters: lambda^2 = -2 +- i 0.2^(1/2) but for the damping, which is 0.2265 Hz.
    let flutter = said("[[2, 1], [1, 2]]", 0.9, "[0.3, 1.0]");
    assert!(
        flutter.contains("a motion of the expected brake is unstable outside of the band, at 0.2265 Hz"),
        "{flutter}"
    );
    for (friction, band) in [(0.9, "[0.1, 1.0]"), (0.5, "[0.3, 1.0]")] {
        let quiet = said("[[2, 1], [1, 2]]", friction, band);
        assert!(!quiet.contains("unstable outside"), "{quiet}");
    }
    // Without a band there are no units to doubt.
    let all = said("[[-2, 0], [0, -1]]", 0.01, "[0.0, inf]");
    assert!(!all.contains("are the units right?") && !all.contains("warning"), "{all}");
}

/// Hulten's brake as Sinou and Jezequel (2007) have it flutters above 0.2893671 with damping of 2 %.
#[test]
fn a_drum_brake_has_its_published_critical_friction() {
    let place = Place::new();
    let job = std::fs::read_to_string(repository().join("jobs/hulten.toml")).unwrap();
    let job = job.replace("friction = { from = 0.15, to = 0.40, points = 26 }", "friction = [0.25, 0.2893671]");
    let job = job.replace("inputs = [\"friction\", \"damping_1\", \"damping_2\"]", "inputs = [\"friction\"]");
    let job = job.replace("{ friction = 0.1, damping_1 = 0.3, damping_2 = 0.3 }", "0.1");
    let table = submitted(&place, "hulten", &job);
    for (mean, p) in table.column("friction").iter().zip(table.column("p_unstable")) {
        assert!((p - above(0.289_367_1, *mean)).abs() < 0.02, "{mean} {p}");
    }
}

/// The dense brake of 100 degrees of freedom from a MAT file: a factor of 0.0835794671 on both terms of friction is critical
/// at 2 pi rad/s (computed independently with LAPACK). Threads and bands change nothing.
#[test]
fn a_brake_from_a_file_has_its_critical_friction_with_any_threads() {
    let place = Place::new();
    let file = repository().join("jobs/tu-brake/disk_brake100.mat");
    let file = file.to_str().unwrap();
    let term =
        |matrix: &str, factor: &str| format!("{{ file = {file:?}, matrix = \"{matrix}\", factor = \"{factor}\" }}");
    let job = |bands: &str, inputs: &str| {
        format!(
            "name = \"disk\"\n[model]\nkind = \"matrices\"\nmass = {{ file = {file:?}, matrix = \"M\" }}\ndamping = [{}, {}, {}]\n\
             stiffness = [{}, {}]\n[model.parameters]\ns = 0.0835794671\nspeed = 6.283185307179586\n[random]\n{inputs}\n\
             {CRITERION}{bands}\n[sampling]\nsamples = 300\nseed = 2\n",
            term("D1", "1"),
            term("DR", "s / speed"),
            term("DG", "speed"),
            term("K1", "1"),
            term("KR", "s"),
        )
    };
    let one = "inputs = [\"s\"]\nrelative_std = 0.05";
    let table = submitted(&place, "disk", &job("", one));
    let p = table.column("p_unstable")[0];
    assert!((p - 0.5).abs() < 0.1, "{p}");
    place.write("bands.toml", &job("bands = [[0.0, 0.0001], [0.0001, 0.001]]", one));
    for threads in [1, 2] {
        place.run(&format!("submit bands.toml --out run{threads} --threads {threads}")).done();
    }
    assert_eq!(place.surface("run1"), place.surface("run2"));
    let bands = Table::read(&place.path("run1/surface.parquet"));
    assert_eq!(bands.column("band"), [0.0, 1.0, 2.0]);
    let p = bands.column("p_unstable");
    assert!(p[0] > 0.3 && p[1] > 0.3 && p[2] == 0.0, "the pair has less than 0.0001 Hz: {p:?}");
}

/// Pairs of close modes that friction couples, two rad/s apart, with scattering friction and damping.
fn flutter(pairs: usize, criterion: &str, sampling: &str) -> String {
    let size = 2 * pairs;
    let matrix = |entry: &dyn Fn(usize, usize) -> f64| {
        let row = |i: usize| format!("[{}]", (0..size).map(|j| entry(i, j).to_string()).collect::<Vec<_>>().join(", "));
        format!("[{}]", (0..size).map(row).collect::<Vec<_>>().join(", "))
    };
    let frequency = |i: usize| 10.0 + 2.0 * (i / 2) as f64 + 0.05 * (i % 2) as f64;
    let coupling = |i: usize, j: usize| match (i / 2 == j / 2, i < j) {
        (true, true) => 1.0 + 0.03 * (i / 2) as f64,
        (true, false) if i != j => -1.0,
        // Pairs are not alone.
        (false, true) if i + 3 > j => 0.02,
        _ => 0.0,
    };
    format!(
        "name = \"flutter\"\n[model]\nkind = \"matrices\"\nmass = {{ matrix = {} }}\n\
         damping = [{{ matrix = {}, factor = \"c\" }}]\n\
         stiffness = [{{ matrix = {} }}, {{ matrix = {}, factor = \"mu\" }}]\n\
         [model.parameters]\nc = 0.01\nmu = 0.5\n[random]\ninputs = [\"mu\", \"c\"]\n\
         relative_std = {{ mu = 0.15, c = 0.3 }}\n[criterion]\nkind = \"complex-eigenvalue\"\n{criterion}\n\
         [sampling]\nseed = 4\n{sampling}\n",
        matrix(&|i, j| if i == j { 1.0 } else { 0.0 }),
        matrix(&|i, j| if i == j { 1.0 } else { 0.0 }),
        matrix(&|i, j| if i == j { frequency(i) * frequency(i) } else { 0.0 }),
        matrix(&coupling)
    )
}

/// A cell of a band has the samples of a job with this band alone, and the verdicts of these: so a brake that is unstable in
/// one is unstable in any.
#[test]
fn cells_that_differ_by_band_alone_have_the_same_samples() {
    let place = Place::new();
    // In Hz; one overlaps the others, and one has no mode.
    let bands = [[1.5, 1.8], [1.8, 2.0], [1.9, 5.0], [0.1, 0.2]];
    let list = |bands: &[[f64; 2]]| format!("bands = {bands:?}");
    for (pairs, sampling, record) in [
        (2, "samples = 600", ""),
        (10, "samples = 600", ""),
        (10, "samples = 512\nmethod = \"sobol\"", ""),
        (10, "samples = 300", "\nrecord = [\"damping_ratio\"]"),
    ] {
        place.write("all.toml", &flutter(pairs, &format!("{}{record}", list(&bands)), sampling));
        for threads in [1, 2] {
            place.run(&format!("submit all.toml --out all{threads} --threads {threads} --overwrite")).done();
        }
        assert_eq!(place.surface("all1"), place.surface("all2"));
        let all = Table::read(&place.path("all1/surface.parquet"));
        let unstable = all.column("n_unstable");
        for (band, own) in bands.into_iter().zip(&unstable[1..]) {
            let alone = format!("frequency = {band:?}{record}");
            place.write("one.toml", &flutter(pairs, &alone, sampling));
            place.run("submit one.toml --out one --overwrite").done();
            let one = Table::read(&place.path("one/surface.parquet"));
            assert_eq!(one.column("n_unstable"), [*own], "{pairs} {sampling} {band:?}");
        }
        let (most, sum) = (unstable[1..].iter().copied().fold(0.0, f64::max), unstable[1..].iter().sum::<f64>());
        assert!(most > 20.0 && (most..=sum).contains(&unstable[0]) && unstable[4] == 0.0, "{pairs} {unstable:?}");
    }
    // Also where another axis is slower.
    let over = |criterion: &str| {
        let text = flutter(10, criterion, "samples = 300");
        text.replace("[random]", "[axes]\nmu = [0.4, 0.5]\n[random]")
    };
    place.write("axis.toml", &over(&list(&bands)));
    place.write("axis-one.toml", &over(&format!("frequency = {:?}", bands[2])));
    let [all, one] = ["axis", "axis-one"].map(|name| {
        place.run(&format!("submit {name}.toml --out {name}")).done();
        Table::read(&place.path(&format!("{name}/surface.parquet")))
    });
    let rows = |table: &Table, band: Option<f64>| {
        let bands = band.map(|_| table.column("band"));
        let of_band = |row: &usize| bands.is_none_or(|bands| Some(bands[*row]) == band);
        let values = [table.column("mu"), table.column("n_unstable")];
        (0..values[0].len()).filter(of_band).map(|row| values.map(|column| column[row])).collect::<Vec<_>>()
    };
    assert_eq!(rows(&all, Some(3.0)), rows(&one, None));
    // Runs with other bands share the samples of the bands that both have.
    place.write("fewer.toml", &flutter(10, &list(&bands[..2]), "samples = 300"));
    place.write("more.toml", &flutter(10, &list(&bands), "samples = 300"));
    for name in ["fewer", "more"] {
        place.run(&format!("submit {name}.toml --out {name}")).done();
    }
    let compared = place.run("compare fewer more --out compared.parquet").done();
    assert!(!compared.stderr.contains("cannot be paired"), "{}", compared.stderr);
}

/// The verdicts of LAPACK, and of mpmath where rounding could matter, on 500 random models (tests/data/matrices/fates.py): at
/// the expected values, where all eigenvalues decide, and with a stiffness 2 % off, from which the series comes.
#[test]
fn verdicts_are_those_of_lapack() {
    let folder = repository().join("tests/data/matrices");
    let matrices: Vec<serde_json::Value> =
        serde_json::from_str(&std::fs::read_to_string(folder.join("fates.json")).unwrap()).unwrap();
    let rows =
        csv::ReaderBuilder::new().comment(Some(b'#')).from_path(folder.join("fates.csv")).unwrap().into_records();
    let mut unstable = 0;
    for (case, row) in matrices.iter().zip(rows) {
        let row = row.unwrap();
        let number = |place: usize| row[place].parse::<f64>().unwrap();
        let size = number(2) as usize;
        let matrix = |name: &str| -> Arc<Matrix> {
            let entries = case[name].as_array().unwrap().iter().enumerate();
            let entries: Vec<_> =
                entries.map(|(i, value)| Triplet::new(i / size, i % size, value.as_f64().unwrap())).collect();
            Arc::new(SparseColMat::try_new_from_triplets(size, size, &entries).unwrap())
        };
        let one = Factor::number(1.0);
        let parameter = Parameter {
            name: "s".to_owned(),
            value: 1.0,
            unit: "1".to_owned(),
            label: "s".to_owned(),
            range: Limits::ANY,
        };
        let model = Matrices {
            mass: matrix("m"),
            damping: vec![Term { matrix: matrix("c"), factor: one }],
            stiffness: vec![Term { matrix: matrix("k"), factor: Factor::parse("s", &["s"]).unwrap() }],
            parameters: vec![parameter],
        };
        let criterion = ComplexEigenvalue {
            bands: vec![[number(3), number(4)]],
            damping_ratio: number(5),
            counts_rigid_body_motions: false,
        };
        let model = MatrixModel::new(Arc::new(model), criterion, Solver::Dense).unwrap();
        let expected = if &row[6] == "1" { Verdict::Unstable } else { Verdict::Stable };
        unstable += usize::from(expected == Verdict::Unstable);
        let sample: &[f64] = &[1.0];
        for (mean, varying, columns) in [(1.0, &[][..], &[][..]), (0.98, &[0][..], &[sample][..])] {
            let shared = model.configure(&[mean], varying, None).unwrap();
            let decided = shared.decide(&Columns::new(1, columns), &[0], &|| false).unwrap();
            assert_eq!(decided[0].verdict, expected, "{row:?}, expected stiffness {mean}");
        }
    }
    assert_eq!((matrices.len(), unstable), (500, 229));
}

/// The same model in the files of other programs (tests/data/matrices/make.py): matrices with nodes and directions come in
/// other numbers of rows, with those that are held, or with those of friction alone.
#[test]
fn files_of_other_programs_give_the_same_probabilities() {
    let place = Place::new();
    let folder = repository().join("tests/data/matrices");
    let named = |file: &str, names: [&str; 4]| names.map(|name| (file.to_owned(), Some(name.to_owned())));
    let single = |files: [&str; 4]| files.map(|file| (file.to_owned(), None));
    let names = ["M", "C", "K", "KF"];
    let mut expected: Option<Vec<f64>> = None;
    for terms in [
        named("scipy-compressed.mat", names),
        named("octave-v7.mat", names),
        named("numpy-compressed.npz", names),
        named("nastran-wide.pch", ["MAAX", "BAAX", "KAAX", "K2PP"]),
        single(["scipy-M.mtx", "scipy-C.mtx", "scipy-K.mtx", "scipy-KF.mtx"]),
        single(["scipy-M-csc.npz", "scipy-C-dia.npz", "numpy-K.npy", "scipy-KF-coo.npz"]),
        single(["abaqus_MASS2.mtx", "abaqus_DMPV2.mtx", "abaqus_STIF2.mtx", "abaqus_STIF3.mtx"]),
        single(["ansys-M.matrix", "scipy-C.mtx", "ansys-K.matrix", "ansys-KF.matrix"]),
        [("MASS", true), ("VISCOUS DAMPING", true), ("STIFFNESS", true), ("", false)].map(|(name, is_substructure)| {
            let file = if is_substructure { "abaqus-substructure.mtx" } else { "abaqus_STIF3.mtx" };
            (file.to_owned(), is_substructure.then(|| name.to_owned()))
        }),
    ] {
        let [mass, damping, stiffness, friction] = terms.map(|(file, name)| {
            let path = folder.join(file);
            let name = name.map(|name| format!(", matrix = \"{name}\"")).unwrap_or_default();
            format!("file = {:?}{name}", path.to_str().unwrap())
        });
        let job = format!(
            "name = \"alike\"\n[model]\nkind = \"matrices\"\nmass = {{ {mass} }}\ndamping = {{ {damping} }}\nstiffness = \
             [{{ {stiffness} }}, {{ {friction}, factor = \"friction\" }}]\n[model.parameters]\nfriction = 1.0\n[axes]\n\
             friction = [10, 14, 18]\n{SCATTER}{CRITERION}[sampling]\nsamples = 2000\nseed = 5\n"
        );
        let table = submitted(&place, "alike", &job);
        std::fs::remove_dir_all(place.path("alike")).unwrap();
        let found = table.column("p_unstable").to_vec();
        assert!(found.iter().any(|p| *p > 0.0 && *p < 1.0), "{found:?}");
        assert_eq!(expected.get_or_insert(found.clone()), &found, "{mass}");
    }
}

/// A joint without mass between two masses on springs in a row, which is at rest between them: frequencies of
/// `K = [[1.5, -0.5], [-0.5, 1.5]]`, 1 and the root of 2 in rad/s. A mass beside its node, which has no inertia of its own
/// about itself, on two springs: the root of the stiffness of both in a row, with the lever between them.
#[test]
fn what_has_no_mass_follows_the_rest() {
    let place = Place::new();
    for (mass, stiffness, frequencies) in [
        ("[[1, 0, 0], [0, 0, 0], [0, 0, 1]]", "[[2, -1, 0], [-1, 2, -1], [0, -1, 2]]", "0.1592, 0.2251"),
        // u + 0.5 w moves the mass: k = 1 / (1 / 4 + 0.25 / 2).
        ("[[1, 0.5], [0.5, 0.25]]", "[[4, 0], [0, 2]]", "0.2599"),
    ] {
        let job = format!(
            "name = \"massless\"\n[model]\nkind = \"matrices\"\nmass = {{ matrix = {mass} }}\nstiffness = {{ matrix = \
             {stiffness} }}\n[random]\ninputs = []\n[criterion]\nkind = \"complex-eigenvalue\"\n"
        );
        place.write("job.toml", &job);
        let check = place.run("check job.toml").done();
        let shown = format!("the first frequencies of the expected brake in Hz: {frequencies}\n");
        assert!(check.stdout.contains(&shown), "{}", check.stdout);
    }
}

/// Matrices of Nastran say nodes and directions, and so does what is said of them.
#[test]
fn degrees_of_freedom_have_their_names_in_what_is_said() {
    let place = Place::new();
    let card = |name: &str, entries: &[(u32, u32, f64)]| {
        let mut text = format!("DMIG,{name},0,6,2,0\n");
        for (node, direction, value) in entries {
            text += &format!("DMIG,{name},{node},{direction},,{node},{direction},{value:.1}\n");
        }
        text
    };
    let job = "name = \"two\"\n[model]\nkind = \"matrices\"\nmass = { file = \"two.pch\", matrix = \"MAAX\" }\nstiffness = \
               { file = \"two.pch\", matrix = \"KAAX\" }\n[criterion]\nkind = \"complex-eigenvalue\"\n";
    place.write("job.toml", job);
    let write = |mass: &[(u32, u32, f64)], stiffness: &[(u32, u32, f64)]| {
        let rest = card("BAAX", &[(7, 1, 0.5)]);
        place.write("two.pch", &format!("{}{}{rest}", card("MAAX", mass), card("KAAX", stiffness)));
    };
    write(&[(7, 1, 1.0)], &[(7, 1, 4.0), (9, 3, 4.0)]);
    let condensed = place.run("check job.toml").done();
    assert!(condensed.stdout.contains("# 1 of 2 motions have no mass and follow the others"), "{}", condensed.stdout);
    write(&[(7, 1, 1.0)], &[(7, 1, 4.0), (9, 3, 0.0)]);
    place.run("check job.toml").refused(
        65,
        &[
            "some degrees of freedom have no mass (one is number 2, node 9 in direction 3)",
            "1 degree of freedom has neither mass nor stiffness",
        ],
    );
    write(&[(7, 1, 1.0), (9, 3, 1.0)], &[(7, 1, 4.0)]);
    let check = place.run("check job.toml").done();
    let said = format!("{}{}", check.stdout, check.stderr);
    for text in [
        "1 degree of freedom has no stiffness (the first is number 2, node 9 in direction 3)",
        "one triangle is stored of stiffness[0], which loses friction",
        "# model.mass, model.stiffness[0]: the file has one triangle of a symmetric matrix",
        "# two.pch also has BAAX, which no term names",
    ] {
        assert!(said.contains(text), "{said}");
    }
}

/// One random input: the integral between critical values, and limits of it, have the digits of the formula.
#[test]
fn probabilities_over_one_input_are_exact() {
    let place = Place::new();
    let rest = format!("[axes]\nfriction = [0.45, 0.6, 0.75]\n{SCATTER}{CRITERION}[sampling]\nmethod = \"exact\"\n");
    let table = submitted(&place, "exact", &two_masses("", &rest));
    for (mean, p) in table.column("friction").iter().zip(table.column("p_unstable")) {
        let expected = above(0.75, *mean);
        assert!((p / expected - 1.0).abs() < 1e-6, "{mean} {p:e} {expected:e}");
    }
    // P = 1e-9 where (0.75 - m) / (0.1 m) = 5.9978.
    let found = place.run("limit exact.toml --of friction --probability 1e-9 --json").done();
    let found: serde_json::Value = serde_json::from_str(&found.stdout).unwrap();
    let limit = found.pointer("/limits/0/limit").and_then(serde_json::Value::as_f64);
    let limit = limit.unwrap_or_else(|| panic!("{found}"));
    assert!((above(0.75, limit) / 1e-9 - 1.0).abs() < 1e-3, "{limit}");
    // Two inputs are one too many.
    let two = two_masses("", &rest)
        .replace("[\"friction\"]", "[\"friction\", \"other\"]")
        .replace("friction = 0.7", "friction = 0.7\nother = 1.0");
    place.write("two.toml", &two);
    place
        .run("check two.toml")
        .refused(65, &["integrates over one random input; random.inputs lists 2", "conditional"]);
}

/// What makes no difference has no critical values: all samples are alike.
#[test]
fn a_random_input_that_stands_in_no_factor_changes_nothing() {
    let place = Place::new();
    for method in ["method = \"exact\"", "samples = 64"] {
        for (damping, expected) in [("0.001", 0.0), ("-0.001", 1.0)] {
            let damping = format!("damping = {{ matrix = [[{damping}, 0], [0, {damping}]] }}");
            let job = two_masses(&damping, &format!("other = 1.0\n{SCATTER}{CRITERION}[sampling]\n{method}\n"));
            let table = submitted(&place, "alike", &job.replace("[\"friction\"]", "[\"other\"]"));
            assert_eq!(table.column("p_unstable"), [expected], "{method}");
            std::fs::remove_dir_all(place.path("alike")).unwrap();
        }
    }
}

/// Several random inputs: the others are drawn, and the friction is integrated over at each sample.
#[test]
fn conditional_probabilities_agree_with_samples() {
    let place = Place::new();
    let job = |sampling: &str| {
        format!(
            "name = \"three\"\n[model]\nkind = \"matrices\"\nmass = {{ matrix = [[1, 0], [0, 1]] }}\n\
             damping = {{ matrix = [[0.04, 0], [0, 0.06]], factor = \"damping\" }}\n\
             stiffness = [{{ matrix = [[2, 1], [1, 2]], factor = \"spring\" }}, {{ matrix = [[0, -1.3333333333333333], [0, 0]], factor = \"friction\" }}]\n\
             [model.parameters]\nfriction = 0.6\nspring = 1.0\ndamping = 1.0\n\
             [random]\ninputs = [\"friction\", \"spring\", \"damping\"]\nrelative_std = 0.1\ncorrelation = [[\"friction\", \"spring\", 0.3]]\n\
             {CRITERION}[sampling]\n{sampling}seed = 5\n"
        )
    };
    let integrated = submitted(&place, "integrated", &job("method = \"conditional\"\nsamples = 1024\n"));
    let sampled = submitted(&place, "sampled", &job("samples = 400_000\n"));
    let [low, high] = ["p_low", "p_high"].map(|end| [&integrated, &sampled].map(|table| table.column(end)[0]));
    assert!(low[0] < high[1] && low[1] < high[0], "{low:?} {high:?}");
}

/// The brake of TU Berlin with its 4669 degrees of freedom: s_crit = 1.9602310483, so that P = 0.0106914289 (independent
/// figures, by two other solvers); reduced, and reduced too far.
#[test]
fn the_full_matrices_of_a_brake_give_its_probability_and_reduced_ones_nearly() {
    let place = Place::new();
    let job = std::fs::read_to_string(repository().join("jobs/tu-brake.toml")).unwrap();
    let matrices = repository().join("jobs/tu-brake/tu-brake.mat");
    let job = job.replace("tu-brake/tu-brake.mat", matrices.to_str().unwrap());
    assert!(job.contains("damping_ratio = 0.0"));
    let job = job.replace("damping_ratio = 0.0", OF_ZERO);
    // A sample of the full matrices takes a second or two.
    let job = job.replace("method = \"exact\" ", "audit = 2\nmethod = \"exact\" ");
    assert!(job.contains("audit = 2"));
    let full = submitted(&place, "full", &job);
    let p = full.column("p_unstable")[0];
    assert!((p - 0.010_691_428_9).abs() < 1e-9, "{p}");

    let done = place.run("reduce full.toml --audit 2").done();
    let page = std::fs::read_to_string(repository().join("docs/how-to/matrices.md")).unwrap();
    let vectors =
        "100 vectors: 84 from eigenvectors at 3 parameter points, 8 from static answers to friction, 8 from modes";
    assert!(done.stdout.starts_with(vectors) && page.contains(vectors), "{}", done.stdout);
    assert!(
        done.stdout.contains("2 samples:\n  0 verdicts differ (with 95 % confidence at most 84.2 % of all)"),
        "{}",
        done.stdout
    );
    assert!(done.stdout.contains("no mode of the bands is missing"), "{}", done.stdout);
    let submitted = place.run("submit full-100.toml --out reduced").done();
    assert!(submitted.stdout.contains("0 of 2 verdicts differ"), "{}", submitted.stdout);
    let table = Table::read(&place.path("reduced/surface.parquet"));
    assert_eq!([table.column("n_reduction_audited")[0], table.column("n_reduction_differed")[0]], [2.0, 0.0]);
    // 1 - 0.025^(1/2), of Clopper and Pearson.
    assert!((table.column("p_reduction")[0] - 0.841_886_1).abs() < 1e-6);
    let reduced = table.column("p_unstable")[0];
    assert!((reduced - p).abs() < 1e-7, "{reduced} {p}");
    place.run("reduce full.toml").refused(64, &["full-100.toml is there already", "--out"]);

    let poor = place.run("reduce full.toml --vectors 4 --audit 1 --out poor.toml").done();
    assert!(poor.stderr.contains("the basis misses modes of the bands"), "{}{}", poor.stdout, poor.stderr);
    place.run("reduce poor.toml --vectors 2").refused(64, &["its matrices are reduced already", "made from"]);
    let checked = place.run("check poor.toml").done();
    assert!(checked.stderr.contains("the basis misses modes of the bands"), "{}", checked.stderr);
    let impossible = std::fs::read_to_string(place.path("poor.toml")).unwrap().replace("audited = 1", "audited = 0");
    let impossible = impossible.replace("differed = 0", "differed = 1");
    place.write("impossible.toml", &impossible);
    place.run("check impossible.toml").refused(65, &["model.reduction.differed", "0 samples were audited"]);
    place.write("whole.toml", &job.replace("matrices = \"full\"", ""));
    place.run("check whole.toml").refused(65, &["4669 degrees of freedom are too many", "stickslip reduce"]);
    place.write("open.toml", &job.replace("frequency = [1000.0, 3000.0]", ""));
    place.run("check open.toml").refused(65, &["looks for eigenvalues in a band", "criterion.frequency"]);

    // The matrices of another reduction are neither replaced nor taken for those of a job.
    let others = std::fs::read(place.path("full-100.mat")).unwrap();
    for name in ["poor.mat", "third.mat"] {
        std::fs::write(place.path(name), &others).unwrap();
    }
    place.run("check poor.toml").refused(65, &["poor.mat is another than the one of this job"]);
    let third = place.run("reduce full.toml --vectors 4 --audit 0 --out third.toml");
    third.refused(64, &["third.mat is there already", "--out"]);
    assert!(std::fs::read(place.path("third.mat")).unwrap() == others && !place.path("third.toml").exists());
}

#[test]
fn reduced_matrices_that_decide_otherwise_end_with_the_code_of_an_audit() {
    let place = Place::new();
    let reduction =
        "[model.reduction]\ndegrees_of_freedom = 4000\naudited = 20\ndiffered = 7\ndamping_ratio_difference = 0.08\n";
    let job = two_masses("", &format!("{reduction}{SCATTER}{CRITERION}[sampling]\nmethod = \"exact\"\n"));
    let asked = "[axes]\nfriction = [0.3, 0.5]\n[limit]\nof = \"friction\"\nprobability = 0.01\n[target]\nprobability = 0.1\nat = { friction = 0.5 }\n";
    place.write("reduced.toml", &format!("{job}{asked}"));
    let why = "7 of 20 verdicts differ on the full matrices; reduce them with more --vectors";
    let failed = place.run("submit reduced.toml").refused(70, &["its matrices are reduced", why]);
    for words in [
        "Target P < 10 %: open, as verdicts differ on the full matrices.",
        "no region of more than",
        "was missed by the reduced matrices",
    ] {
        assert!(failed.stdout.contains(words), "{}", failed.stdout);
    }
    assert!(place.path("runs/two/surface.parquet").exists() && place.path("runs/two/limits.parquet").exists());
    let said = place.run("submit reduced.toml --json").refused(70, &[why]).stdout;
    let said: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert!(said["decision"]["met"].is_null(), "{said}");
    place.run("limit reduced.toml").refused(70, &["the matrices are reduced", why]);
    let sound = format!("{job}{asked}").replace("differed = 7", "differed = 0").replace("\"two\"", "\"sound\"");
    place.write("sound.toml", &sound);
    assert!(place.run("submit sound.toml").done().stdout.contains("Target P < 10 %: met"));
}

#[test]
fn a_reduction_replaces_no_file() {
    let place = Place::new();
    place.write("job.toml", &two_masses("", &format!("{SCATTER}{CRITERION}frequency = [0.01, 10.0]\n")));
    for name in ["brake.toml", "brake.mat"] {
        let path = place.write(name, "mine");
        let refused = place.run("reduce job.toml --vectors 1 --out brake.toml");
        refused.refused(64, &[&format!("{name} is there already"), "remove it, or name another file with --out"]);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
        std::fs::remove_file(path).unwrap();
    }
}

#[test]
fn a_run_goes_on_with_its_own_matrices_alone() {
    let place = Place::new();
    let file = |coupling: f64| {
        let text = format!("%%MatrixMarket matrix coordinate real general\n2 2 1\n1 2 {coupling}\n");
        place.write("friction.mtx", &text);
    };
    file(-1.5);
    let rest = format!("{SCATTER}{CRITERION}[sampling]\nsamples = 2000\n");
    let job = two_masses("", &rest).replace("matrix = [[0, -1.3333333333333333], [0, 0]]", "file = \"friction.mtx\"");
    let table = submitted(&place, "run", &job);
    assert!((table.column("p_unstable")[0] - above(1.0 / 1.5, 0.7)).abs() < 0.04);
    let surface = place.surface("run");
    let lose =
        || ["surface.parquet", "digests.json"].map(|name| std::fs::remove_file(place.path("run").join(name)).unwrap());
    lose();
    place.run("resume run").done();
    assert_eq!(place.surface("run"), surface);
    lose();
    file(-1.25);
    place.run("resume run").refused(65, &["model.stiffness[1]", "friction.mtx is another than the one of this job"]);
    file(-1.5);
    place.run("resume run").done();
    assert_eq!(place.surface("run"), surface);
}

/// A matrix of friction as a file of Matrix Market.
fn friction_file(coupling: f64) -> String {
    format!("%%MatrixMarket matrix coordinate real general\n2 2 1\n1 2 {coupling}\n")
}

/// A job of three cells whose friction is in `friction.mtx`.
fn job_of_file(criterion: &str, sampling: &str) -> String {
    let rest =
        format!("[axes]\nfriction = [0.5, 0.55, 0.6]\n{SCATTER}{CRITERION}{criterion}\n[sampling]\n{sampling}\n");
    let damping = "damping = { matrix = [[0.001, 0], [0, 0.001]] }";
    two_masses(damping, &rest).replace("matrix = [[0, -1.3333333333333333], [0, 0]]", "file = \"friction.mtx\"")
}

/// Three runs with the friction of one file, which was moved after them to `now`: `run`, `apart`, which draws other samples,
/// and `paired`, which decides the same ones by another threshold. With what the commands say of them before.
fn runs_of_a_moved_file(sampling: &str) -> (Place, Vec<Vec<u8>>) {
    let place = Place::new();
    place.write("friction.mtx", &friction_file(-1.5));
    submitted(&place, "run", &job_of_file("", sampling));
    submitted(&place, "apart", &job_of_file("damping_ratio = -0.001", &format!("{sampling}\nseed = 7")));
    submitted(&place, "paired", &job_of_file("damping_ratio = -0.001", sampling));
    let said = said_of_runs(&place);
    std::fs::create_dir(place.path("now")).unwrap();
    std::fs::rename(place.path("friction.mtx"), place.path("now/friction.mtx")).unwrap();
    (place, said)
}

/// What is read of `run`: what commands print and write.
fn said_of_runs(place: &Place) -> Vec<Vec<u8>> {
    let printed = |words: &str| place.run(words).done().stdout.into_bytes();
    let mut said: Vec<Vec<u8>> = [
        "status run",
        "status run --json",
        "export run --format csv --out run.csv",
        "plot run --out run.svg",
        "compare run apart",
        "plot run --against apart --out difference.svg",
        "verify run",
    ]
    .map(printed)
    .to_vec();
    said.extend(["run.csv", "run.svg", "difference.svg"].map(|name| std::fs::read(place.path(name)).unwrap()));
    said
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_run_whose_matrices_were_moved_is_read_as_before_and_goes_on_from_where_they_are() {
    for sampling in ["samples = 2000", "method = \"exact\"", "method = \"importance\"\nsamples = 4096"] {
        let (place, before) = runs_of_a_moved_file(sampling);
        let surface = place.surface("run");
        assert!(said_of_runs(&place) == before, "{sampling}");
        let said = ["friction.mtx", "No such file", "run/job.toml is as it was written", "`--out run`"];
        place.run("resume run").refused(65, &said);
        place.run("plot run --of modes").refused(65, &said);
        let verified = place.run("verify run").done();
        assert!(said.iter().all(|text| verified.stderr.contains(text)), "{}", verified.stderr);
        // What is damaged is found, and written again from the pieces where there are some.
        let mut damaged = surface.clone();
        damaged[surface.len() / 2] ^= 1;
        std::fs::write(place.path("run/surface.parquet"), damaged).unwrap();
        let verified = place.run("verify run");
        if sampling.contains("exact") {
            verified.refused(74, &["damaged: surface.parquet"]);
            std::fs::write(place.path("run/surface.parquet"), &surface).unwrap();
        } else {
            assert!(verified.done().stdout.contains("it is written again from the pieces"));
        }
        assert!(place.surface("run") == surface);
        // Other matrices are those of another job, under whatever name.
        place.write("friction.mtx", &friction_file(-1.25));
        assert!(said_of_runs(&place) == before, "{sampling}");
        place.run("submit run.toml --out run").refused(65, &["friction.mtx is another than the one of this job"]);
        std::fs::remove_file(place.path("friction.mtx")).unwrap();
        place.write("moved.toml", &job_of_file("", sampling).replace("friction.mtx", "now/friction.mtx"));
        let moved = place.run("submit moved.toml --out run").done();
        assert!(moved.stderr.contains("job.toml is refused; it is written again"), "{}", moved.stderr);
        assert!(place.surface("run") == surface);
        let verified = place.run("verify run").done();
        assert!(!verified.stderr.contains("friction.mtx"), "{}", verified.stderr);
    }
}

#[test]
fn a_job_is_kept_apart_from_a_run_whose_matrices_were_moved_and_names_its_own_that_are_gone() {
    let place = Place::new();
    place.write("friction.mtx", &friction_file(-1.5));
    let job = job_of_file("", "samples = 1000");
    let before = submitted(&place, "run", &job).digest();
    std::fs::create_dir(place.path("now")).unwrap();
    std::fs::rename(place.path("friction.mtx"), place.path("now/friction.mtx")).unwrap();
    // Its own are gone: nothing is begun, and the file is named.
    place
        .run("submit run.toml --out run --apart")
        .refused(65, &["run.toml:", "model.stiffness[1]", "friction.mtx", "No such file"]);
    let here = job.replace("friction.mtx", "now/friction.mtx");
    place.write("other.toml", &here.replace("samples = 1000", "samples = 1000\nseed = 7"));
    let apart = place.run("submit other.toml --out run --apart").done();
    assert!(apart.stderr.contains("run holds a run of another job; this one goes to run-"), "{}", apart.stderr);
    // The same job goes on where it is.
    place.write("same.toml", &here);
    let same = place.run("submit same.toml --out run --apart").done();
    assert!(!same.stderr.contains("another job"), "{}", same.stderr);
    assert_eq!(Table::read(&place.path("run/surface.parquet")).digest(), before);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn what_needs_the_matrices_is_left_out_where_they_were_moved() {
    let (place, _) = runs_of_a_moved_file("samples = 2000");
    let report = place.run("report run paired --out run.html").done();
    for said in [": the matrices of the model cannot be read as they were", "cannot be paired"] {
        assert!(report.stderr.contains(said), "{said}: {}", report.stderr);
    }
    let page = std::fs::read_to_string(place.path("run.html")).unwrap();
    assert!(
        page.contains("Warning: the matrices of the model cannot be read as they were")
            && !page.contains("id=\"modes\"")
    );
    let compared = place.run("compare run paired --json").done();
    assert!(!page.contains("degrees of freedom") && !page.contains("first frequencies"), "{page}");
    let why =
        "cannot be paired: the matrices of the model cannot be read as they were, though they share random numbers";
    assert!(compared.stderr.contains(why) && compared.stdout.contains("\"dependent\""), "{compared:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_job_that_names_files_is_written_again_and_is_not_damaged_where_its_digest_is_lost() {
    let (place, before) = runs_of_a_moved_file("samples = 2000");
    std::fs::remove_file(place.path("run/digests.json")).unwrap();
    let refused = place.run("resume run").refused(65, &["No such file", "run/job.toml can be read", "`--out run`"]);
    assert!(!refused.stderr.contains("damaged"), "{}", refused.stderr);
    let verified = place.run("verify run").done().stdout;
    assert!(verified.contains("digests.json: none") && verified.contains("job.toml: sound\n"), "{verified}");
    assert!(said_of_runs(&place) == before);
    let path = place.path("run/job.toml");
    for is_lost in [false, true] {
        if is_lost {
            std::fs::remove_file(&path).unwrap();
        } else {
            std::fs::write(&path, std::fs::read_to_string(&path).unwrap().replacen("2000", "2001", 1)).unwrap();
        }
        let verified = place.run("verify run").done();
        assert!(verified.stdout.contains("the surface holds what it was"), "{}", verified.stdout);
        assert!(verified.stderr.contains("friction.mtx"), "{}", verified.stderr);
        assert!(said_of_runs(&place) == before);
    }
    // The surface does not say where the files were.
    std::fs::rename(place.path("now/friction.mtx"), place.path("friction.mtx")).unwrap();
    place.run("resume run").refused(65, &["friction.mtx", "`--out run`"]);
    let again = place.run("submit run.toml --out run").done();
    assert!(again.stderr.contains("job.toml is refused; it is written again"), "{}", again.stderr);
    place.run("resume run").done();
}

#[test]
fn what_is_wrong_with_matrices_is_said_in_words_of_their_makers() {
    let place = Place::new();
    let rest = format!("{SCATTER}{CRITERION}");
    let whole = two_masses("", &rest);
    std::fs::write(place.path("new.mat"), [b"\x89HDF\r\n\x1a\n".as_slice(), &[0; 200]].concat()).unwrap();
    for (wrong, right, texts) in [
        (
            "factor = \"friction\"",
            "factor = \"frction\"",
            &["there is no parameter `frction`", "[model.parameters] has friction; declare others there"][..],
        ),
        ("[[2, 1], [1, 2]]", "[[2, 1], [1]]", &["row 2 of the matrix has 1 values", "square"]),
        (
            "[[2, 1], [1, 2]]",
            "[[2]]",
            &["model.stiffness[0]: the matrix has 1 rows", "rows: mass 2, stiffness[0] 1, stiffness[1] 2"],
        ),
        (
            "[[1, 0], [0, 1]]",
            "[[1, 0], [0, 0]]",
            &["some degrees of freedom have no mass (one is number 2)", "(stiffness[0], stiffness[1])", "a small mass"],
        ),
        ("[[1, 0], [0, 1]]", "[[1, 0], [0, -1]]", &["the mass of degree of freedom number 2 is -1"]),
        ("[[1, 0], [0, 1]]", "[[1, 2], [2, 1]]", &["not positive definite"]),
        ("[[1, 0], [0, 1]]", "[[1, 1], [0, 1]]", &["not symmetric"]),
        (
            "[[2, 1], [1, 2]]",
            "[[1e36, 1], [1, 2]]",
            &["1 entry on the diagonal is 1e30 or more (the first is number 1)", "constrained degrees of freedom"],
        ),
        ("matrix = [[2, 1], [1, 2]]", "file = \"no.mat\", matrix = \"K\"", &["no.mat", "No such file"]),
        (
            "friction = 0.7",
            "friction = { value = 0.7, label = \"a\\u0001\" }",
            &["model.parameters.friction.label has the character U+0001", "leave control characters out"],
        ),
        (
            "friction = 0.7",
            "friction = { value = 0.7, unit = \"\\uFFFF\" }",
            &["model.parameters.friction.unit has the character U+FFFF"],
        ),
        ("matrix = [[2, 1], [1, 2]]", "file = \"new.mat\", matrix = \"K\"", &["7.3", "-v7"]),
        ("kind = \"complex-eigenvalue\"", "kind = \"eigenvalue\"", &["complex-eigenvalue"]),
        ("kind = \"complex-eigenvalue\"", "kind = \"complex-eigenvalue\"\nfrequency = [3000, 1000]", &["is no band"]),
        (
            "inputs = [\"friction\"]\nrelative_std = 0.1\n[criterion]",
            "inputs = [\"friction\",\n \"band\"]\nrelative_std = 0.1\n[criterion]\nbands = [[0, 1], [1, 2]]",
            &["job.toml:11:2: random.inputs: band (", "cannot scatter", "from 0 to 2", "for example axes.band = [0]"],
        ),
    ] {
        assert!(whole.contains(wrong));
        place.write("job.toml", &whole.replace(wrong, right));
        place.run("check job.toml").refused(65, texts);
    }
    let divided = whole.replace("factor = \"friction\"", "factor = \"friction / width\"");
    place.write("job.toml", &divided.replace("friction = 0.7", "friction = 0.7\nwidth = 0"));
    place.run("check job.toml").refused(65, &["the factor \"friction / width\" is inf at friction = 0.7, width = 0"]);
    let symmetric = whole.replace(", { matrix = [[0, -1.3333333333333333], [0, 0]], factor = \"friction\" }", "");
    place.write("job.toml", &symmetric);
    let check = place.run("check job.toml").done();
    let said = format!("{}{}", check.stdout, check.stderr);
    assert!(said.contains("there is no friction in it") && said.contains("stands in no factor"), "{said}");
}

/// The modes of Hulten's brake at one point: verdict, derivatives by differences of two points, and the critical values that
/// the Routh-Hurwitz condition gives.
#[test]
fn modes_have_their_derivatives_and_critical_values() {
    let place = Place::new();
    let text = std::fs::read_to_string(repository().join("jobs/hulten.toml")).unwrap();
    let kind = "kind = \"complex-eigenvalue\"";
    place.write("of-zero.toml", &text.replace(kind, &format!("{kind}\n{OF_ZERO}")));
    let job = place.path("of-zero.toml").display().to_string();
    let analysed = |friction: f64| -> serde_json::Value {
        let printed = place.run(&format!("analyse {job} --set friction={friction} --json")).done().stdout;
        serde_json::from_str(&printed).unwrap()
    };
    let number = |value: &serde_json::Value, path: &str| value.pointer(path).unwrap().as_f64().unwrap();
    let (here, less, more) = (analysed(0.28), analysed(0.279), analysed(0.281));
    assert_eq!(here["stable"], true);
    assert_eq!(here["modes"].as_array().unwrap().len(), 2);
    for mode in 0..2 {
        for quantity in ["damping_ratio", "frequency_hz", "growth_rate_per_s"] {
            let at = format!("/modes/{mode}/{quantity}");
            let difference = (number(&more, &at) - number(&less, &at)) / 0.002;
            let derivative = number(&here, &format!("/modes/{mode}/derivatives/friction/{quantity}"));
            assert!((derivative / difference - 1.0).abs() < 0.02, "{at}: {derivative} {difference}");
        }
    }
    assert!((number(&here, "/critical_values/friction/above") - 0.289_367_125_522_81).abs() < 1e-10);
    assert!(here.pointer("/critical_values/friction/below").unwrap().is_null());
    let unstable = analysed(0.3);
    assert_eq!(unstable["stable"], false);
    assert!((number(&unstable, "/critical_values/friction/below") - 0.289_367_125_522_81).abs() < 1e-10);
    let text = place.run(&format!("analyse --job {job} --cell 16")).done().stdout;
    assert!(text.starts_with("hulten at damping_1 0.02, damping_2 0.02, friction 0.31: UNSTABLE"), "{text}");
    assert!(text.contains("friction   0.31   0.289367 "), "{text}");
    let analyse = |change: &str| place.run(&format!("analyse {job} --set {change}"));
    analyse("fricton=0.3").refused(64, &["--set fricton=0.3", "did you mean friction?", "damping_1"]);
    analyse("friction").refused(64, &["NAME=VALUE"]);
    analyse("friction=0,3").refused(64, &["decimal comma"]);
}

/// Modes of a job and frequencies of its unstable samples as pictures: the same bytes with any threads.
#[test]
fn modes_and_frequencies_of_unstable_samples_are_drawn() {
    let place = Place::new();
    let text = std::fs::read_to_string(repository().join("jobs/hulten.toml")).unwrap();
    place.write("brake.toml", &text);
    let drawn = |line: &str, file: &str| {
        place.run(line).done();
        std::fs::read_to_string(place.path(file)).unwrap()
    };
    let printed = place.run("plot brake.toml --of modes --threads 1").done().stdout;
    assert_eq!(printed, "brake-modes.svg\nbrake-modes.png\n");
    let modes = std::fs::read_to_string(place.path("brake-modes.svg")).unwrap();
    for text in ["Frequency (Hz)", "Damping ratio ζ", ">friction<", "expected, unstable", "1000 samples, relative std"]
    {
        assert!(modes.contains(text), "{text}");
    }
    assert_eq!(drawn("plot brake.toml --of modes --threads 3 --out three.svg", "three.svg"), modes);
    // Each of two panels has a stable line for each mode and the unstable part of one, wider.
    let lines = |colour: &str, width: &str| {
        let of = |line: &&str| {
            line.contains(&format!("stroke=\"{colour}\"")) && line.contains(&format!("stroke-width=\"{width}\""))
        };
        modes.split("<path").filter_map(|path| path.split('>').next()).filter(of).count()
    };
    assert_eq!([lines("#0072b2", "1.2"), lines("#d55e00", "2.6")], [4, 2]);
    let over = drawn("plot brake.toml --of modes --along damping_2 --columns 1 --out d.svg", "d.svg");
    assert!(over.contains(">damping_2 (10⁻³)<") && over.contains("friction = 0.27"));
    let line = "plot brake.toml --of squeal-frequencies --cell 16";
    let bars = drawn(&format!("{line} --threads 1 --out one.svg"), "one.svg");
    assert!(bars.contains("of 10,000 samples unstable, P = 0.80"), "{bars}");
    assert_eq!(drawn(&format!("{line} --threads 3 --out three.svg"), "three.svg"), bars);
    place
        .run("plot brake.toml --of modes --along dampng_2")
        .refused(64, &["--along dampng_2", "did you mean damping_2?"]);
    place.run("plot brake.toml --along friction").refused(64, &["--along", "--of modes"]);
    let pad = repository().join("jobs/fig14a.toml");
    place.run(&format!("plot {} --of modes", pad.display())).refused(64, &["fig14a", "not given by matrices"]);
}
