//! The terms of a model given by matrices: a matrix from a file or written in the job, times a factor.

use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use faer::sparse::{SparseColMat, Triplet};
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use stickslip_core::models::matrices::factor::Factor;
use stickslip_core::models::matrices::terms::Parameter;
use toml::Spanned;
use toml_edit::{DocumentMut, Item, TableLike, Value};

use crate::job::diagnosis::Complaint;
use crate::job::model::written;
use crate::job::reduction::Reduction;
use crate::matrix_files::{self, ReadMatrix};

/// A matrix times a factor: `{ file = "brake.mat", matrix = "K1", factor = "friction / speed" }`, or `matrix = [[2, -1], [-1,
/// 2]]` without a file.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct TermSpec {
    /// The file with the matrix, beside the job.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<String>")]
    file: Option<Spanned<String>>,
    /// Its name in a file that has several, or its rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<MatrixSpec>")]
    matrix: Option<Spanned<MatrixSpec>>,
    /// Its factor: a product of numbers and powers of parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 1))]
    factor: Option<FactorSpec>,
    /// The digest of a matrix from a file, by which a run refuses to go on with another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
}

/// How a term is written, for messages.
const A_TERM: &str =
    "a matrix as { file = \"brake.mat\", matrix = \"K\", factor = \"friction\" } or { matrix = [[2, -1], [-1, 2]] }";

// Derived code would also read a list as the values of the keys in their order.
impl<'de> Deserialize<'de> for TermSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Table;
        impl<'de> Visitor<'de> for Table {
            type Value = TermSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(A_TERM)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TermSpec, A::Error> {
                TermSpec::deserialize(MapAccessDeserializer::new(map))
            }
        }
        deserializer.deserialize_any(Table)
    }
}

impl Serialize for TermSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

/// A matrix by its name in a file, or by its rows.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "it must be the name of a matrix in its file, or rows of numbers, [[2, -1], [-1, 2]]")]
enum MatrixSpec {
    /// The name.
    Name(String),
    /// The rows.
    Rows(Vec<Vec<f64>>),
}

/// A factor as a number or a product.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
enum FactorSpec {
    /// A number.
    Number(f64),
    /// A product.
    Text(String),
}

/// Terms: a list, or a single one.
#[derive(Debug, Default, Serialize)]
pub struct TermsSpec(pub Vec<Spanned<TermSpec>>);

impl<'de> Deserialize<'de> for TermsSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Terms;
        impl<'de> Visitor<'de> for Terms {
            type Value = TermsSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{A_TERM}, or a list of such")
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TermsSpec, A::Error> {
                let term = TermSpec::deserialize(MapAccessDeserializer::new(map))?;
                Ok(TermsSpec(vec![written(term)]))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut terms: A) -> Result<TermsSpec, A::Error> {
                let mut all = Vec::new();
                while let Some(term) = terms.next_element()? {
                    if all.len() == MOST_TERMS {
                        return Err(A::Error::custom(format!("more than {MOST_TERMS} terms are too many")));
                    }
                    all.push(term);
                }
                Ok(TermsSpec(all))
            }
        }
        deserializer.deserialize_any(Terms)
    }
}

const MOST_TERMS: usize = 1000;

/// A term that was read.
pub struct Term {
    pub head: Head,
    pub read: ReadMatrix,
    pub file: Option<FileTerm>,
}

/// A term without its matrix.
pub struct Head {
    /// Its key below `model`: `mass`, `stiffness[1]`.
    pub key: String,
    pub span: Range<usize>,
    pub factor: Factor,
}

impl Head {
    pub fn complaint(&self, message: &str) -> Complaint {
        Complaint::at(self.span.clone(), format!("model.{}: {message}", self.key))
    }
}

/// Where a matrix came from.
#[derive(Debug, Clone)]
pub struct FileTerm {
    file: String,
    matrix: Option<MatrixSpec>,
    path: PathBuf,
    pub digest: String,
}

impl FileTerm {
    /// Whether this is what a term names.
    pub fn is_of(&self, spec: &TermSpec) -> bool {
        spec.file.as_ref().map(Spanned::get_ref) == Some(&self.file)
            && spec.matrix.as_ref().map(Spanned::get_ref) == self.matrix.as_ref()
            && spec.digest.as_ref().is_none_or(|digest| *digest == self.digest)
    }
}

impl TermSpec {
    /// The term as the identity of a job has it: its file by name and digest, wherever that lies.
    pub fn identified(&self, files: &[FileTerm]) -> Self {
        let digest = files.iter().find(|file| file.is_of(self)).map(|file| file.digest.clone());
        let name = self.file.as_ref().map(Spanned::get_ref).map(|file| {
            Path::new(file).file_name().map_or_else(|| file.clone(), |name| name.to_string_lossy().into_owned())
        });
        Self { digest, file: name.map(written), ..self.clone() }
    }

    /// Where its file stands in the job, or else its rows.
    fn span(&self) -> Option<Range<usize>> {
        self.file.as_ref().map(Spanned::span).or_else(|| self.matrix.as_ref().map(Spanned::span))
    }
}

/// Reads terms, each matrix of a file once.
pub struct Reader<'a> {
    folder: Option<&'a Path>,
    parameters: Vec<&'a str>,
    /// By file and name.
    known: HashMap<(String, Option<String>), ReadMatrix>,
    /// What was said of files that cannot be read.
    said: HashSet<String>,
}

impl<'a> Reader<'a> {
    /// For files beside the job, if they are not left out, and factors in these parameters.
    pub fn new(folder: Option<&'a Path>, parameters: &'a [Parameter]) -> Self {
        let parameters = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        Self { folder, parameters, known: HashMap::new(), said: HashSet::new() }
    }

    /// Reads a term: its matrix and its factor.
    ///
    /// # Errors
    /// What is wrong with it; nothing if that was said of another term with the same file.
    pub fn read(&mut self, key: &str, spec: &Spanned<TermSpec>) -> Result<Term, Option<Complaint>> {
        let span = spec.get_ref().span().unwrap_or_else(|| spec.span());
        let complain = |message: String| Some(Complaint::at(span.clone(), format!("model.{key}: {message}")));
        let TermSpec { file, matrix, factor, digest } = spec.get_ref();
        let (file, matrix) = (file.as_ref().map(Spanned::get_ref), matrix.as_ref().map(Spanned::get_ref));
        let factor = match factor {
            None => Factor::number(1.0),
            Some(FactorSpec::Number(number)) if number.is_finite() => Factor::number(*number),
            Some(FactorSpec::Number(number)) => return Err(complain(format!("factor = {number} is no finite number"))),
            Some(FactorSpec::Text(text)) => Factor::parse(text, &self.parameters).map_err(|error| {
                let known = match &self.parameters[..] {
                    [] => "there are no parameters; declare them in [model.parameters]".to_owned(),
                    names => format!("[model.parameters] has {}; declare others there", names.join(", ")),
                };
                complain(format!("factor = \"{text}\": {error} ({known})"))
            })?,
        };
        let head = |factor| Head { key: key.to_owned(), span: span.clone(), factor };
        match (file, matrix) {
        (Some(name), None | Some(MatrixSpec::Name(_))) => {
            let Some(folder) = self.folder else {
                let digest = digest.clone().ok_or_else(|| complain("the term has no digest".to_owned()))?;
                let file = FileTerm { file: name.clone(), matrix: matrix.cloned(), path: name.into(), digest };
                return Ok(Term { head: head(factor), read: stand_in().map_err(complain)?, file: Some(file) });
            };
            let path = folder.join(name);
            let wanted = match matrix {
                Some(MatrixSpec::Name(name)) => Some(name.clone()),
                _ => None,
            };
            let read = match self.known.entry((name.clone(), wanted)) {
                Entry::Occupied(known) => known.get().clone(),
                Entry::Vacant(new) => {
                    let read = matrix_files::read(&path, new.key().1.as_deref());
                    let said = &mut self.said;
                    let read = read.map_err(|error| {
                        let message = error.to_string();
                        complain(message.clone()).filter(|_| said.insert(message))
                    });
                    new.insert(read?).clone()
                }
            };
            let found = digest_of(&read);
            if let Some(digest) = digest.as_ref().filter(|digest| **digest != found) {
                return Err(complain(format!(
                    "the matrix in {} is another than the one of this job: its digest is {found}, not {digest}; bring back the file as it was, or submit a new job",
                    path.display()
                )));
            }
            let path = std::path::absolute(&path).unwrap_or(path);
            let file = FileTerm { file: name.clone(), matrix: matrix.cloned(), path, digest: found };
            Ok(Term { head: head(factor), read, file: Some(file) })
        }
        (None, Some(MatrixSpec::Rows(rows))) => {
            let read = of_rows(rows).map_err(complain)?;
            let read = if self.folder.is_some() { read } else { stand_in().map_err(complain)? };
            Ok(Term { read, head: head(factor), file: None })
        }
        (Some(_), Some(MatrixSpec::Rows(_))) => {
            Err(complain("a file is given beside the rows of a matrix; remove one of the two".to_owned()))
        }
        (None, Some(MatrixSpec::Name(name))) => Err(complain(format!(
            "matrix = \"{name}\" is a name, but there is no file; give file = \"...\", or rows: matrix = [[2, -1], [-1, 2]]"
        ))),
        (None, None) => Err(complain(
            "there is no matrix; give file = \"brake.mat\" and its name in it, matrix = \"K\", or rows: matrix = [[2, -1], [-1, 2]]".to_owned(),
        )),
    }
    }
}

/// What stands for each matrix where files are left out: all of one size, and fit for any place in a model.
fn stand_in() -> Result<ReadMatrix, String> {
    of_rows(&[vec![1.0]])
}

/// A matrix by its rows.
fn of_rows(rows: &[Vec<f64>]) -> Result<ReadMatrix, String> {
    let size = rows.len();
    let mut triplets = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        if row.len() != size {
            return Err(format!(
                "row {} of the matrix has {} values, but there are {size} rows; a matrix here is square",
                i + 1,
                row.len()
            ));
        }
        for (j, value) in row.iter().enumerate() {
            if !value.is_finite() {
                return Err(format!(
                    "row {}, column {} of the matrix is {value}; it must be a finite number",
                    i + 1,
                    j + 1
                ));
            }
            if *value != 0.0 {
                triplets.push(Triplet::new(i, j, *value));
            }
        }
    }
    if size == 0 {
        return Err("the matrix has no rows".to_owned());
    }
    let matrix = SparseColMat::try_new_from_triplets(size, size, &triplets)
        .map_err(|error| format!("the matrix is too large: {error:?}"))?;
    Ok(ReadMatrix::of_rows(matrix))
}

/// The digest of a matrix: of its size, of its entries column by column, and of what decides its place among the others of
/// the model, where its file says that.
fn digest_of(read: &ReadMatrix) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut add = |value: u64| {
        hasher.update(&value.to_le_bytes());
    };
    let matrix = &read.matrix;
    [matrix.nrows() as u64, matrix.compute_nnz() as u64].into_iter().for_each(&mut add);
    for entry in matrix.triplet_iter() {
        [entry.row as u64, entry.col as u64, entry.val.to_bits()].into_iter().for_each(&mut add);
    }
    let places = read.degrees_of_freedom.as_deref().unwrap_or_default();
    [u64::from(read.has_size), places.len() as u64].into_iter().for_each(&mut add);
    for (node, direction) in places {
        [node.cast_unsigned(), u64::from(*direction)].into_iter().for_each(&mut add);
    }
    read.constrained.iter().for_each(|row| add(*row as u64));
    hasher.finalize().to_hex()[..32].to_owned()
}

/// A line for each file that has matrices which no term names.
pub fn unused_matrices(files: &[FileTerm]) -> String {
    let paths: BTreeSet<&PathBuf> = files.iter().map(|file| &file.path).collect();
    let line = |path: &PathBuf| {
        let is_used = |name: &String| {
            let mut own = files.iter().filter(|file| file.path == *path);
            own.any(|file| file.matrix.as_ref().is_none_or(|matrix| *matrix == MatrixSpec::Name(name.clone())))
        };
        // That the file can be read is known by now, but for a change since.
        let mut names = matrix_files::names(path).unwrap_or_default();
        names.retain(|name| !is_used(name));
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        (!names.is_empty()).then(|| format!("# {file} also has {}, which no term names\n", names.join(", ")))
    };
    paths.into_iter().filter_map(line).collect()
}

/// Shows each term of a written job with its key and its number among those of the key.
fn for_each_written(document: &mut DocumentMut, mut show: impl FnMut(&str, usize, &mut dyn TableLike)) {
    let Some(model) = document.get_mut("model").and_then(Item::as_table_like_mut) else { return };
    for key in ["mass", "damping", "stiffness"] {
        let Some(item) = model.get_mut(key) else { continue };
        if let Some(terms) = item.as_array_mut() {
            let terms = terms.iter_mut().filter_map(Value::as_inline_table_mut);
            terms.enumerate().for_each(|(number, term)| show(key, number, term));
        } else if let Some(terms) = item.as_array_of_tables_mut() {
            terms.iter_mut().enumerate().for_each(|(number, term)| show(key, number, term));
        } else if let Some(term) = item.as_table_like_mut() {
            show(key, 0, term);
        }
    }
}

/// The text of a job that decides its samples on the full matrices and records nothing of them, whatever else it says.
pub fn with_full_matrices(text: &str) -> String {
    let Ok(mut document) = text.parse::<DocumentMut>() else { return text.to_owned() };
    if let Some(criterion) = document.get_mut("criterion").and_then(Item::as_table_like_mut) {
        criterion.insert("matrices", toml_edit::value("full"));
        criterion.remove("record");
    }
    document.to_string()
}

/// The text of a job whose matrices are those of a file: M, C1, C2, ..., K1, K2, ..., in the order of its terms, with their factors.
/// What the reduction costs stands beside them.
///
/// # Errors
/// Matrices that cannot be read from the file, of which the job has the digests.
pub fn with_reduced_matrices(text: &str, path: &Path, reduction: &Reduction) -> Result<String, String> {
    let Ok(mut document) = text.parse::<DocumentMut>() else { return Ok(text.to_owned()) };
    let mut unread = None;
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    for_each_written(&mut document, |key, number, term| {
        let name = match key {
            "mass" => "M".to_owned(),
            "damping" => format!("C{}", number + 1),
            _ => format!("K{}", number + 1),
        };
        for (key, value) in [("file", &*file), ("matrix", &name)] {
            term.insert(key, toml_edit::value(value));
        }
        term.remove("digest");
        // With another reduction beside it, the job is refused.
        match matrix_files::read(path, Some(&name)) {
            Ok(read) => {
                term.insert("digest", toml_edit::value(digest_of(&read)));
            }
            Err(problem) => unread = Some(problem.to_string()),
        }
    });
    if let Some(why) = unread {
        return Err(why);
    }
    if let Some(criterion) = document.get_mut("criterion").and_then(Item::as_table_like_mut) {
        criterion.remove("matrices");
    }
    if let Some(model) = document.get_mut("model").and_then(Item::as_table_like_mut)
        && let Ok(table) = toml::to_string(reduction)
        && let Ok(table) = table.parse::<DocumentMut>()
    {
        model.insert("reduction", Item::Table(table.as_table().clone()));
    }
    Ok(document.to_string())
}

/// Writes where the matrices of a job are, and their digests, into its text; a comment that says so.
pub fn freeze(document: &mut DocumentMut, files: &[FileTerm]) -> String {
    for_each_written(document, |_, _, term| locate(term, files));
    if files.is_empty() {
        return String::new();
    }
    "# model: the matrices are read from their files again, and must have these digests\n".to_owned()
}

/// Writes into a term where its file is and what it must be.
fn locate(term: &mut dyn TableLike, files: &[FileTerm]) {
    let text = |key: &str| term.get(key).and_then(Item::as_str);
    let named = |file: &FileTerm| match &file.matrix {
        Some(MatrixSpec::Name(name)) => text("matrix") == Some(name),
        _ => text("matrix").is_none(),
    };
    let file = files.iter().find(|file| text("file") == Some(&file.file) && named(file));
    if let Some(file) = file {
        term.insert("file", toml_edit::value(file.path.to_string_lossy().into_owned()));
        term.insert("digest", toml_edit::value(file.digest.clone()));
    }
}
