//! `reduce`: the matrices of a job on a basis of few vectors, and what that costs.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::fs;
use std::io::{self, Read as _};
use std::path::Path;
use std::slice;
use std::sync::Arc;

use nalgebra::DMatrix;
use stickslip_core::model::Columns;
use stickslip_core::models::matrices::error::Error;
use stickslip_core::models::matrices::full::audit::missing;
use stickslip_core::models::matrices::full::band::{Band, KrylovLimit};
use stickslip_core::models::matrices::full::has_common_instructions;
use stickslip_core::models::matrices::full::quadratic::Coefficients;
use stickslip_core::models::matrices::full::reduction::{Recipe, Reduced, Reduction as Basis};
use stickslip_core::models::matrices::model::MatrixModel;
use stickslip_core::models::matrices::problem::Problem;
use stickslip_core::models::matrices::quadratic::DenseQuadratic;
use stickslip_core::models::matrices::region::{Region, excess};
use stickslip_core::numerics::eigenvalues::Eigenvalue;
use stickslip_sampler::draw::deviates::Points;

use super::kept_beside::KeptBeside;
use super::modes::JobModes;
use super::named_job::read_job;
use crate::cli::ReduceArguments;
use crate::evaluate::remembering::Asked;
use crate::evaluate::samples::Drawing;
use crate::export::mat;
use crate::failure::Failure;
use crate::files::bounded::{holds, open_regular};
use crate::files::publish::publish_first;
use crate::job::reduction::Reduction;
use crate::job::{Job, JobSource, with_full_matrices, with_reduced_matrices};
use crate::output::{counted, note, output_file, result, shown, warn};
use crate::store::searches::digest_of_searches;
use crate::version::VERSION;

/// Standard deviations from the expected value at which eigenvectors are taken of random inputs.
const DEVIATES: [f64; 2] = [-3.0, 3.0];

/// Modes fill up a basis to this multiple of the band's upper end.
const MODES_UP_TO: f64 = 2.0;

/// A mode of the full matrices is missing if no reduced eigenvalue is as near as this, relative to it.
const TOLERANCE: f64 = 0.01;

/// What is said, and written into the job, of a reduction whose last digits are not those of most processors. Its job has
/// digests of the matrices, so it is another job than that of a reduction elsewhere.
const OTHER_DIGITS: &str = "reduced on a processor that lacks AVX2 or FMA: the last digits of the matrices, and with them the identity of the job, are others than on processors with both; to go on with its runs elsewhere, take the job and its matrices along, and do not reduce again";

/// `stickslip reduce`.
pub fn reduce(arguments: &ReduceArguments) -> Result<(), Failure> {
    let ReduceArguments { job: path, vectors, audit, out } = arguments;
    let source = read_job(path)?;
    let job = JobSource { text: with_full_matrices(&source.text), ..source.clone() }.job()?;
    let model = JobModes::new(&job)?.model;
    let Problem::Sparse(matrices) = model.problem() else {
        return Err(Failure::Internal("a job with full matrices has sparse ones".to_owned()));
    };
    let size = matrices.size();
    if job.reduction().is_some() {
        let message =
            format!("{}: its matrices are reduced already; reduce the job that it was made from", path.display());
        return Err(Failure::Usage(message));
    }
    let vectors = *vectors as usize;
    if vectors >= size {
        let message = format!("--vectors {vectors}: the model has {size} degrees of freedom; give fewer vectors");
        return Err(Failure::Usage(message));
    }
    let stem = path.file_stem().map_or_else(|| "job".into(), |stem| stem.to_string_lossy().into_owned());
    let named = out.clone().unwrap_or_else(|| format!("{stem}-{vectors}.toml").into());
    let (directory, name) = output_file(&named)?;
    let is_there = |path: &Path| {
        Failure::Usage(format!("{} is there already; remove it, or name another file with --out", path.display()))
    };
    if directory.join(&name).exists() {
        return Err(is_there(&named));
    }
    let mat_name = format!("{}.mat", name.strip_suffix(".toml").unwrap_or(&name));
    let mat_path = named.with_file_name(&mat_name);
    // It may be the only copy of a user's matrices. One of this program is compared in the end: a reduction that was ended
    // between its two files goes on.
    let is_foreign = match open_regular(&directory.join(&mat_name)) {
        Ok(mut file) => first_bytes(&mut file, mat::OWN.len()) != mat::OWN.as_bytes(),
        Err(error) => error.kind() != io::ErrorKind::NotFound,
    };
    if is_foreign {
        return Err(is_there(&mat_path));
    }
    let failed = |error: Error| Failure::Job(format!("{}: {error}", path.display()));

    let points = points(&job, model);
    let regions = model.regions();
    let band = Band::about(&Region {
        lowest: regions.iter().map(|region| region.lowest).fold(f64::INFINITY, f64::min),
        highest: regions.iter().map(|region| region.highest).fold(0.0, f64::max),
        damping_ratio: model.criterion().damping_ratio,
    });
    let split =
        |values: &Vec<f64>| Coefficients::split(&model.matrices().coefficients(values), matrices.damping_terms());
    let recipe = Recipe { points: points.iter().map(split).collect(), band, vectors, modes_up_to: MODES_UP_TO };
    note(format_args!(
        "eigenvectors of {size} degrees of freedom at {}",
        counted(points.len() as u128, "parameter point", "parameter points")
    ));
    let what = [("vectors", vectors.to_string()), ("audit", audit.to_string()), ("version", VERSION.to_owned())];
    let what = digest_of_searches("reduction", &job.experiment_hash(), &what);
    let kept = KeptBeside::read(&(directory.clone(), name.clone()), what)?;
    let keeper = Some(kept.keeper());
    let reduction = kept_basis(&Asked::new(keeper, (0, 0)), [size, vectors], || {
        matrices.reduction(&recipe, KrylovLimit::default())
    });
    let reduction = reduction.map_err(failed)?;
    let reduced = matrices.reduced(&reduction.basis);
    let found = Audit::new(&job, model, &reduced, *audit, &Asked::new(keeper, (0, 1))).map_err(failed)?.found(size);
    let text = described(&reduction, &points) + &found.text();

    let mut mat = Vec::new();
    mat::write_matrices(&named_matrices(&reduced), &mut mat)
        .map_err(|error| Failure::writing(&directory.join(&mat_name), error))?;
    let other_digits = (!has_common_instructions()).then_some(OTHER_DIGITS);
    let head: String = text.lines().chain(other_digits).map(|line| format!("# {line}\n")).collect();
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let head = format!("# The job {file}, its matrices reduced by stickslip {VERSION}:\n{head}\n");
    // Of two reductions with one name, the second finds other matrices or the job of the first.
    let is_first = publish_first(&directory, &mat_name, &mat)?;
    let path_of_matrices = directory.join(&mat_name);
    if !is_first && !holds(&path_of_matrices, &mat) {
        return Err(is_there(&mat_path));
    }
    let job_text = with_reduced_matrices(&source.text, &path_of_matrices, &found)
        .map_err(|why| Failure::InputOutput(format!("{}: {why}", mat_path.display())))?;
    let job_text = format!("{head}{job_text}");
    if !publish_first(&directory, &name, job_text.as_bytes())? {
        return Err(Failure::Usage(format!("{} appeared meanwhile; name another file", named.display())));
    }
    kept.forget();
    warn(found.warnings().into_iter().chain(other_digits.map(str::to_owned)));
    result(&format!("{text}{}\n{}\n", shown(&named), shown(&mat_path)))
}

/// The first bytes of a file, as many as there are.
fn first_bytes(file: &mut fs::File, count: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let read = file.take(count as u64).read_to_end(&mut bytes);
    if read.is_ok() { bytes } else { Vec::new() }
}

/// A basis of so many degrees of freedom and at most so many vectors, which is kept.
fn kept_basis(
    asked: &Asked<'_>,
    [size, vectors]: [usize; 2],
    find: impl FnOnce() -> Result<Basis, Error>,
) -> Result<Basis, Error> {
    const COUNTS: usize = 3;
    let read = |numbers: &[f64]| {
        let (counts, entries) = numbers.split_first_chunk::<COUNTS>()?;
        let sound = |count: &f64| count.fract() == 0.0 && (0.0..=vectors as f64).contains(count);
        let [from_pairs, from_statics, from_modes] =
            counts.iter().all(sound).then(|| counts.map(|count| count as usize))?;
        let entries = entries.get(..size * (from_pairs + from_statics + from_modes))?;
        let basis = DMatrix::from_column_slice(size, entries.len() / size, entries);
        entries.iter().all(|entry| entry.is_finite()).then_some(Basis { basis, from_pairs, from_statics, from_modes })
    };
    let write = |found: &Basis| {
        let counts = [found.from_pairs, found.from_statics, found.from_modes].map(|count| count as f64);
        let mut numbers = [&counts[..], found.basis.as_slice()].concat();
        numbers.resize(COUNTS + size * vectors, 0.0);
        numbers
    };
    asked.ask(COUNTS + size * vectors, read, write, find)
}

/// More eigenvalues than any model has.
const MOST: f64 = 1e9;

/// Eigenvalues, which are kept: first how many there are.
fn kept_eigenvalues(
    asked: &Asked<'_>,
    find: impl Fn() -> Result<Vec<Eigenvalue>, Error>,
) -> Result<Vec<Eigenvalue>, Error> {
    let mut found = None;
    let count =
        |numbers: &[f64]| numbers.first().filter(|count| (0.0..MOST).contains(*count)).map(|count| *count as usize);
    let count = asked.ask(1, count, |count| vec![*count as f64], || Ok(found.insert(find()?).len()))?;
    let read = |numbers: &[f64]| {
        let values = numbers.chunks_exact(2).map(|parts| Eigenvalue::new(parts[0], parts[1])).collect();
        numbers.iter().all(|part| part.is_finite()).then_some(values)
    };
    let write = |values: &Vec<Eigenvalue>| values.iter().flat_map(|value| [value.re, value.im]).collect();
    asked.ask(2 * count, read, write, || found.map_or_else(find, Ok))
}

/// The values of the parameters at which eigenvectors are taken: the expected ones, and each parameter that an axis or its
/// scatter varies at both ends.
fn points(job: &Job, model: &MatrixModel) -> Vec<Vec<f64>> {
    let parameters = &model.matrices().parameters;
    let expected = job.grid.cell(0).expected[..parameters.len()].to_vec();
    let mut points = vec![expected.clone()];
    for (place, parameter) in parameters.iter().enumerate() {
        let mut values = job.grid.extremes_of(place).to_vec();
        if let Some(position) = job.random.position(place) {
            let mut cell = job.grid.cell(0);
            values = values
                .into_iter()
                .flat_map(|value| {
                    cell.expected[place] = value;
                    let input = job.distribution(position, &cell);
                    DEVIATES.map(|deviate| input.value(deviate))
                })
                .collect();
        }
        let ends = [
            values.iter().copied().fold(f64::INFINITY, f64::min),
            values.into_iter().fold(f64::NEG_INFINITY, f64::max),
        ];
        for end in ends.map(|end| end.clamp(parameter.range.minimum, parameter.range.maximum)) {
            let mut point = expected.clone();
            point[place] = end;
            let is_sound = model.matrices().coefficients(&point).iter().all(|value| value.is_finite());
            if is_sound && !points.contains(&point) {
                points.push(point);
            }
        }
    }
    points
}

/// The reduced matrices with the names that the reduced job gives them: M, C1, C2, ..., K1, K2, ...
fn named_matrices(reduced: &Reduced) -> Vec<(String, &DMatrix<f64>)> {
    let numbered = |letter: char, matrices: &'_ [DMatrix<f64>]| -> Vec<String> {
        (1..=matrices.len()).map(|number| format!("{letter}{number}")).collect()
    };
    let names = [vec!["M".to_owned()], numbered('C', &reduced.damping), numbered('K', &reduced.stiffness)].concat();
    let matrices = std::iter::once(&reduced.mass).chain(&reduced.damping).chain(&reduced.stiffness);
    names.into_iter().zip(matrices).collect()
}

/// What the basis was made of.
fn described(basis: &Basis, points: &[Vec<f64>]) -> String {
    let Basis { basis, from_pairs, from_statics, from_modes } = basis;
    format!(
        "{} vectors: {from_pairs} from eigenvectors at {}, {from_statics} from static answers to friction, {from_modes} from modes\n",
        basis.ncols(),
        counted(points.len() as u128, "parameter point", "parameter points"),
    )
}

/// The reduced matrices against the full ones, at samples of the first cell.
struct Audit {
    samples: u64,
    /// Samples whose verdicts differ.
    different: u64,
    /// The largest difference of the least damping ratios in the bands.
    difference: f64,
    /// Frequencies of full modes that the reduced matrices lack, Hz, to four digits.
    missing: BTreeSet<String>,
}

impl Audit {
    /// Compares at as many samples.
    fn new(job: &Job, model: &MatrixModel, reduced: &Reduced, samples: u64, asked: &Asked<'_>) -> Result<Self, Error> {
        let mut audit = Self { samples, different: 0, difference: 0.0, missing: BTreeSet::new() };
        let cell = job.grid.cell(0);
        let count = model.matrices().parameters.len();
        let expected = model.matrices().coefficients(&cell.expected[..count]);
        let dense = DenseQuadratic::new(&reduced.mass, &reduced.damping, &reduced.stiffness, &expected)
            .map_err(|_| Error::Request("the reduced mass matrix is not positive definite"))?;
        let problems = [model.problem(), &Problem::Dense(Arc::new(dense))];
        let (varying, regions) = (job.varying(), model.regions());
        let mut drawing = Drawing::new(job, &cell, 0, 0..samples, Points::Random);
        while let Some(drawn) = drawing.next_chunk(samples as usize) {
            let columns = drawn.columns();
            let columns = Columns::new(drawn.len(), &columns);
            for sample in 0..drawn.len() {
                let values = columns.complete(sample, &cell.expected, &varying);
                audit.compare(problems, &regions, &model.matrices().coefficients(&values[..count]), asked)?;
            }
        }
        Ok(audit)
    }

    /// Compares the full problem with the reduced one at these coefficients.
    fn compare(
        &mut self,
        [full, reduced]: [&Problem; 2],
        regions: &[Region],
        coefficients: &[f64],
        asked: &Asked<'_>,
    ) -> Result<(), Error> {
        let mut verdicts = [false; 2];
        for region in regions {
            let of = |problem: &Problem| problem.eigenvalues(coefficients, slice::from_ref(region));
            let (mut full, reduced) = (kept_eigenvalues(asked, || of(full))?, of(reduced)?);
            full.retain(|value| region.has_frequency_of(*value));
            let lost = missing(&full, &reduced, TOLERANCE).into_iter();
            self.missing.extend(lost.map(|index| format!("{:.4e}", full[index].im / TAU)));
            for (verdict, values) in verdicts.iter_mut().zip([&full, &reduced]) {
                *verdict |= values.iter().any(|value| region.contains(*value));
            }
            let least = [&full, &reduced].map(|values| {
                let excess = values.iter().map(|value| excess(slice::from_ref(region), *value));
                excess.fold(f64::INFINITY, f64::min)
            });
            if least.iter().all(|excess| excess.is_finite()) {
                self.difference = self.difference.max((least[0] - least[1]).abs());
            }
        }
        self.different += u64::from(verdicts[0] != verdicts[1]);
        Ok(())
    }

    fn found(self, degrees_of_freedom: usize) -> Reduction {
        let mut missing: Vec<f64> = self.missing.iter().filter_map(|frequency| frequency.parse().ok()).collect();
        missing.sort_by(f64::total_cmp);
        Reduction {
            degrees_of_freedom: degrees_of_freedom as u64,
            audited: self.samples,
            differed: self.different,
            // To two digits.
            damping_ratio_difference: format!("{:.1e}", self.difference).parse().unwrap_or(self.difference),
            missing,
        }
    }
}
