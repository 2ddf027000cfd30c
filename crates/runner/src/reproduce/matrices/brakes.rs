//! Brakes of finite elements, from files.

use std::f64::consts::{PI, TAU};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use stickslip_core::models::matrices::branches::{Branches, Followed, Line, Target};
use stickslip_core::models::matrices::full::along::Along;
use stickslip_core::models::matrices::full::band::{Band, KrylovLimit};
use stickslip_core::models::matrices::full::quadratic::{Coefficients, Point, SparseQuadratic};
use stickslip_core::models::matrices::model::MatrixModel;
use stickslip_core::models::matrices::pair::Pair;
use stickslip_core::models::matrices::problem::Solver;
use stickslip_core::models::matrices::terms::Matrix;
use stickslip_core::numerics::eigenvalues::Eigenvalue;

use super::entry::{Entry, Kind};
use super::model::Parts;
use crate::failure::Failure;
use crate::matrix_files;

const GRAEBNER: &str = "N. Graebner, V. Mehrmann, S. Quraishi, C. Schroeder, U. von Wagner, ZAMM 96 (2016) 1388, doi 10.1002/zamm.201500217";
const NLEVP: &str = "NLEVP disk_brake100 (T. Betcke and others), by LAPACK";
const ARPACK: &str = "the same matrices by ARPACK and a sparse LU factorisation";
const OWN: &str = "jobs/own-brake, by ARPACK and a sparse LU factorisation";
const OTHER: &str = "another model of the same description (jobs/own-brake/README.md)";
const OF_SPEED: &str = "C = D1 + DR/Omega + Omega DG, K = K1 + KR + Omega^2 KGEO";
const OF_SPEED_DENSE: &str = "C = D1 + DR/Omega + Omega DG, K = K1 + KR";
const OF_FACTOR: &str = "C = D1 + DR/Omega + Omega DG + D4/1600, K = K1 + s KR + Omega^2 KGEO, Omega = 4 pi rad/s";
const OF_FRICTION: &str = "C = 20 M + 5e-7 (K0 + E K_lining), K = K0 + E K_lining + k K_contact + mu k K_friction";

/// A file that is not there.
pub struct Missing(pub PathBuf);

/// Entries, or why there are none.
type Found = Result<Result<Vec<Entry>, Missing>, Failure>;

/// Matrices of a file.
fn read<const N: usize>(path: PathBuf, names: [&str; N]) -> Result<Result<[Arc<Matrix>; N], Missing>, Failure> {
    if !path.is_file() {
        return Ok(Err(Missing(path)));
    }
    let read = |name: &str| matrix_files::read(&path, Some(name)).map(|read| Arc::new(read.matrix));
    let matrices: Vec<Arc<Matrix>> = names
        .into_iter()
        .map(read)
        .collect::<Result<_, _>>()
        .map_err(|error| Failure::InputOutput(error.to_string()))?;
    let wrong = |_| Failure::Internal(format!("{} has other matrices than {}", path.display(), names.join(", ")));
    matrices.try_into().map(Ok).map_err(wrong)
}

/// Pairs are looked for this near to given frequencies, relative to them, with damping ratios up to this magnitude.
const AROUND: f64 = 2e-3;
const MOST_DAMPING: f64 = 0.02;

/// Halvings of an interval that is searched: it shrinks by 1e-9.
const HALVINGS: usize = 30;

/// The pair whose eigenvalue is nearest to one that is given.
fn nearest(point: &Point<'_>, given: Eigenvalue) -> Result<Pair, Failure> {
    let band = Band {
        low: given.im * (1.0 - AROUND),
        high: given.im * (1.0 + AROUND),
        least_damping: -MOST_DAMPING,
        most_damping: MOST_DAMPING,
    };
    let found = point.pairs_in(band, KrylovLimit::default()).map_err(wrong)?;
    let distance = |pair: &Pair| libm::hypot(pair.eigenvalue.re - given.re, pair.eigenvalue.im - given.im);
    let nearest = found.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.ok_or_else(|| Failure::Internal(format!("no eigenvalue near {given} was found")))
}

fn wrong(error: impl Display) -> Failure {
    Failure::Internal(format!("a model of the gallery: {error}"))
}

/// Real and imaginary part of an eigenvalue beside those of others, each given to so many units of its last digit.
fn parts_of(what: &str, theirs: [(f64, f64); 2], ours: Eigenvalue, kind: Kind, texts: [&'static str; 2]) -> [Entry; 2] {
    let [re, im] = theirs;
    let entry = |name: &str, (value, digit): (f64, f64), ours: f64| Entry {
        quantity: format!("{what}: {name}"),
        theirs: value,
        ours,
        tolerance: (digit / value).abs() * 0.5 + 1e-12,
        kind,
        formula: texts[0],
        source: texts[1],
    };
    [entry("Re, 1/s", re, ours.re), entry("Im, rad/s", im, ours.im)]
}

/// `disk_brake100` of NLEVP.
pub fn dense(folder: &Path) -> Found {
    let names = ["M", "D1", "DG", "DR", "K1", "KR"];
    let [m, d1, dg, dr, k1, kr] = match read(folder.join("tu-brake/disk_brake100.mat"), names)? {
        Ok(matrices) => matrices,
        Err(missing) => return Ok(Err(missing)),
    };
    let parts = Parts {
        mass: m,
        damping: vec![(d1, "1"), (dr, "factor / speed"), (dg, "speed")],
        stiffness: vec![(k1, "1"), (kr, "factor")],
        parameters: vec![("factor", 1.0), ("speed", TAU)],
        band: [0.0, f64::INFINITY],
        solver: Solver::Dense,
    };
    let model = parts.model()?;
    let mut entries = Vec::new();
    for (name, speed, re, im) in [
        ("2 pi", TAU, 0.001_065_24, 0.000_702),
        ("4 pi", 2.0 * TAU, 0.001_059_20, 0.000_712),
        ("8 pi", 4.0 * TAU, 0.001_046_98, 0.000_730),
    ] {
        let modes = model.modes(&[1.0, speed], &model.regions()).map_err(wrong)?;
        let unstable = modes.iter().map(|mode| mode.eigenvalue).max_by(|a, b| a.re.total_cmp(&b.re));
        let what = format!("Omega {name}, the unstable pair");
        let theirs = [(re, 1e-8), (im, 1e-6)];
        entries.extend(parts_of(&what, theirs, unstable.unwrap_or_default(), Kind::Computed, [OF_SPEED_DENSE, NLEVP]));
    }
    let factor = first_unstable(&model, [0.05, 0.15])?;
    entries.push(Entry {
        quantity: "Omega 2 pi, factor on DR and KR: critical value".to_owned(),
        theirs: 0.083_579_467_1,
        ours: factor,
        // The eigenvalue there is far smaller than the matrices, whose rounding leaves six digits.
        tolerance: 1e-6,
        kind: Kind::Computed,
        formula: OF_SPEED_DENSE,
        source: NLEVP,
    });
    Ok(Ok(entries))
}

/// Between a stable and an unstable value of the factor, where all eigenvalues show the first unstable one.
fn first_unstable(model: &MatrixModel, within: [f64; 2]) -> Result<f64, Failure> {
    let regions = model.regions();
    let [mut stable, mut unstable] = within;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (stable + unstable);
        let eigenvalues = model.eigenvalues(&[middle, TAU], &regions).map_err(wrong)?;
        let is_unstable = eigenvalues.iter().any(|value| regions.iter().any(|region| region.contains(*value)));
        *(if is_unstable { &mut unstable } else { &mut stable }) = middle;
    }
    Ok(0.5 * (stable + unstable))
}

/// An eigenvalue at a speed: its real and imaginary part with a unit of the last digit of each.
type Given = (f64, &'static str, [(f64, f64); 2]);

/// As the logs of the authors print them.
const PRINTED: [Given; 5] = [
    (2.0 * PI, "2 pi", [(-2.462, 1e-3), (3338.0, 1.0)]),
    (40.0 * PI, "40 pi", [(-9.215, 1e-3), (1413.0, 1.0)]),
    (40.0 * PI, "40 pi", [(-3.809, 1e-3), (3576.0, 1.0)]),
    (40.0 * PI, "40 pi", [(-6.673, 1e-3), (9836.0, 1.0)]),
    (40.0 * PI, "40 pi", [(63.93, 1e-2), (17040.0, 10.0)]),
];

/// Computed from the same matrices.
const COMPUTED: [[(f64, f64); 2]; 4] = [
    [(-10.173_152, 1e-6), (1_413.564_00, 1e-5)],
    [(-2.914_258, 1e-6), (3_337.093_30, 1e-5)],
    [(-13.587_414, 1e-6), (16_346.094_52, 1e-5)],
    [(75.347_507, 1e-6), (17_459.938_57, 1e-5)],
];

/// The brake of TU Berlin.
pub fn of_tu_berlin(folder: &Path) -> Found {
    let names = ["M", "D1", "DG", "DR", "D4", "K1", "KR", "KGEO"];
    let [m, d1, dg, dr, d4, k1, kr, kgeo] = match read(folder.join("tu-brake/tu-brake.mat"), names)? {
        Ok(matrices) => matrices,
        Err(missing) => return Ok(Err(missing)),
    };
    let matrices = SparseQuadratic::new(&m, &[d1, dr, dg, d4].map(own), &[k1, kr, kgeo].map(own)).map_err(wrong)?;
    // D4, damping by shims, belongs to the critical value alone.
    let coefficients = |factor: f64, speed: f64, shims: f64| Coefficients {
        damping: vec![1.0, 1.0 / speed, speed, shims / 1600.0],
        stiffness: vec![1.0, factor, speed * speed],
    };
    let mut entries = Vec::new();
    let mut add = |speed: f64, name: &str, given: [(f64, f64); 2], kind: Kind, source: &'static str| {
        let near = Eigenvalue::new(given[0].0, given[1].0);
        let point = matrices.at(&coefficients(1.0, speed, 0.0)).map_err(wrong)?;
        let what = format!("Omega {name}, {:.0} Hz", near.im / TAU);
        entries.extend(parts_of(&what, given, nearest(&point, near)?.eigenvalue, kind, [OF_SPEED, source]));
        Ok::<(), Failure>(())
    };
    for (speed, name, given) in PRINTED {
        add(speed, name, given, Kind::Printed, GRAEBNER)?;
    }
    for given in COMPUTED {
        add(4.0 * PI, "4 pi", given, Kind::Computed, ARPACK)?;
    }
    let (factor, frequency) = critical_factor(&matrices, &coefficients(0.0, 4.0 * PI, 1.0))?;
    for (what, theirs, ours, tolerance) in [
        ("critical factor s on KR", 1.960_231_048_3, factor, 1e-9),
        ("  its frequency, Hz", 2762.0966, frequency, 1e-7),
    ] {
        entries.push(Entry {
            quantity: what.to_owned(),
            theirs,
            ours,
            tolerance,
            kind: Kind::Computed,
            formula: OF_FACTOR,
            source: ARPACK,
        });
    }
    Ok(Ok(entries))
}

/// Where the pair of 2.76 kHz of this brake grows over the factor on KR, and its frequency in Hz there.
fn critical_factor(matrices: &SparseQuadratic, without: &Coefficients) -> Result<(f64, f64), Failure> {
    const WITHIN: [f64; 2] = [1.9, 2.0];
    let from: Vec<f64> = without.damping.iter().chain(&without.stiffness).copied().collect();
    let mut direction = vec![0.0; from.len()];
    direction[without.damping.len() + 1] = 1.0;
    let path = Line { from, direction };
    let along = Along { matrices, path: &path, limit: KrylovLimit::default() };
    let start = nearest(&along.point(WITHIN[0]).map_err(wrong)?, Eigenvalue::new(0.0, TAU * 2762.0))?;
    let branches: &dyn Branches = &along;
    let start = Followed::new(WITHIN[0], start, &*branches.at(WITHIN[0]).map_err(wrong)?);
    let critical = branches.critical(Target::DampingRatio(0.0), &start, WITHIN).map_err(wrong)?;
    Ok((critical.at.p, critical.at.pair.eigenvalue.im / TAU))
}

/// A matrix of its own.
fn own(shared: Arc<Matrix>) -> Matrix {
    Arc::unwrap_or_clone(shared)
}

/// The brake of our own.
pub fn of_our_own(folder: &Path) -> Found {
    let names = ["M", "K0", "K_lining", "K_contact", "K_friction"];
    let [m, k0, k_lining, k_contact, k_friction] = match read(folder.join("own-brake/own-brake.mat"), names)? {
        Ok(matrices) => matrices,
        Err(missing) => return Ok(Err(missing)),
    };
    let brake = Parts {
        mass: m.clone(),
        damping: vec![(m, "20"), (k0.clone(), "5e-7"), (k_lining.clone(), "5e-7 * lining")],
        stiffness: vec![(k0, "1"), (k_lining, "lining"), (k_contact, "contact"), (k_friction, "friction * contact")],
        parameters: vec![("friction", 0.3), ("lining", 8e9), ("contact", 5e12)],
        band: [12_000.0, 13_500.0],
        solver: Solver::Sparse,
    };
    let (friction, frequency) = brake.critical([0.27, 0.3])?;
    let numbers = [
        ("critical friction, pair of 12.7 kHz", 0.282_710_234_738, friction, 1e-9, Kind::Computed, OWN),
        ("  its frequency, Hz", 12_743.435_350_3, frequency, 1e-9, Kind::Computed, OWN),
        ("critical friction, other model", 0.286_210_919_4, friction, 1e-9, Kind::OtherModel, OTHER),
        ("  its frequency, Hz", 12_808.69, frequency, 1e-6, Kind::OtherModel, OTHER),
    ];
    let entry = |(what, theirs, ours, tolerance, kind, source): (&str, f64, f64, f64, Kind, &'static str)| Entry {
        quantity: what.to_owned(),
        theirs,
        ours,
        tolerance,
        kind,
        formula: OF_FRICTION,
        source,
    };
    Ok(Ok(numbers.map(entry).into()))
}
