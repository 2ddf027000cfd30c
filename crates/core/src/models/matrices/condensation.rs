//! Motions without mass, which follow the others at once, are condensed.

use std::sync::Arc;

use faer::sparse::Triplet;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use thiserror::Error;

use super::factor::Factor;
use super::terms::{Matrices, Matrix, Term};

/// A motion has no mass if it has less than this share of what its degrees of freedom have by themselves.
const NO_MASS: f64 = 1e-8;

/// The others of its node have at least this share: where the masses of motions have no gap between them, nothing is condensed.
const MASS: f64 = 1e-5;

/// A stiffness holds a motion if it holds it by more than this share of its entries.
const HELD: f64 = 1e-12;

/// Forces are alike if they differ by less than this share.
const ALIKE: f64 = 1e-9;

/// Steps for each eigenvalue of a mass, of which a few are enough.
const SWEEPS: usize = 60;

/// Degrees of freedom that are condensed together, and that have mass together where the mass is looked into.
const MOST: usize = 1000;

/// A model without the motions that have no mass.
///
/// They span the null space of M. With `q = Q [a; m]` and m for them, the rows of m are `sum_i f_i (A_i,ma a + A_i,mm m) = 0`
/// over the terms of K, and of C with `a'` and `m'`. Where `A_i,ma = A_i,mm X` and `A_i,am = Y A_i,mm` with the same X and Y for
/// all terms, `m = -X a` solves them whatever the factors are, and of a term there is left `A_i,aa - A_i,am X`. The eigenvalues
/// that are lost are those of m alone: infinite ones, and real ones where damping acts on m.
#[derive(Debug, Clone)]
pub struct Condensed {
    /// The model in a.
    pub matrices: Matrices,
    /// `Q [I; -X]`: the displacements of all degrees of freedom, a column for each that is left.
    pub displacements: Matrix,
}

/// Why motions without mass cannot be condensed. Degrees of freedom are counted from 0.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CondensationError {
    /// No stiffness holds them, or one that pushes them away.
    #[error("the stiffness of the expected values does not hold them")]
    NotHeld {
        /// One that moves.
        place: usize,
    },
    /// Terms act on them in different proportions.
    #[error("the forces on them do not keep their proportions when the factors of terms change")]
    Changing {
        /// One on which they act.
        place: usize,
        /// The terms that act in different proportions, among those of C and then of K.
        terms: Vec<usize>,
    },
    /// Too many hang together.
    #[error("{count} of them hang together, and the limit is {MOST}")]
    TooMany {
        /// One of them.
        place: usize,
        /// How many.
        count: usize,
    },
    /// There is not enough memory for what is left.
    #[error("there is not enough memory for the matrices that are left")]
    Memory,
}

/// The model without motions that have no mass; none where all have mass, or where M is not positive semidefinite.
///
/// # Errors
/// [`CondensationError`], where what such motions do depends on the parameters, or on more than the others.
pub fn condensed(matrices: &Matrices) -> Result<Option<Condensed>, CondensationError> {
    let basis = Basis::new(&matrices.mass);
    let massless = basis.columns.len() - basis.kept;
    if massless == 0 {
        return Ok(None);
    }
    let terms: Vec<&Term> = matrices.damping.iter().chain(&matrices.stiffness).collect();
    let mut entries: Vec<Vec<Entry>> = terms.iter().map(|term| basis.entries(&term.matrix)).collect();
    let between = entries.iter().flatten().filter(|(row, column, _)| *row >= basis.kept && *column >= basis.kept);
    let between = between.map(|(row, column, _)| (row - basis.kept, column - basis.kept));
    let groups = groups(massless, between);
    let mut group_of = vec![0; massless];
    for (number, group) in groups.iter().enumerate() {
        group.iter().for_each(|place| group_of[*place] = number);
    }
    let mut acting: Vec<Vec<(usize, Entry)>> = vec![Vec::new(); groups.len()];
    for (number, own) in entries.iter_mut().enumerate() {
        own.retain(|entry| {
            let Some(place) = [entry.0, entry.1].into_iter().find(|place| *place >= basis.kept) else { return true };
            acting[group_of[place - basis.kept]].push((number, *entry));
            false
        });
    }
    let stiffness_from = matrices.damping.len();
    let coefficients = matrices.coefficients(&matrices.expected());
    let all_stiffness: Vec<(usize, f64)> = coefficients.into_iter().enumerate().skip(stiffness_from).collect();
    let mut following = Vec::new();
    for (group, acting) in groups.iter().zip(acting) {
        let members: Vec<usize> = group.iter().map(|place| place + basis.kept).collect();
        let place = basis.place(members[0]);
        if members.len() > MOST {
            return Err(CondensationError::TooMany { place, count: members.len() });
        }
        let forces = Forces::new(&members, &acting, basis.kept);
        let Some([x, y]) = forces.sum(&all_stiffness).followed() else {
            return Err(CondensationError::NotHeld { place });
        };
        let alike = alike(&terms, stiffness_from, forces.terms());
        for together in &alike {
            let blocks = forces.sum(together);
            if !blocks.is_followed(&x, &y) {
                let terms = alike.iter().map(|group| group[0].0).collect();
                return Err(CondensationError::Changing { place, terms });
            }
            let term = together[0].0;
            let change = &blocks.before * &x;
            let places = (0..change.nrows()).flat_map(|i| (0..change.ncols()).map(move |j| (i, j)));
            let changes = places.map(|(i, j)| (forces.rows[i], forces.columns[j], -change[(i, j)]));
            entries[term].extend(changes);
        }
        for (i, member) in members.iter().enumerate() {
            following.extend(forces.columns.iter().enumerate().map(|(j, column)| (*member, *column, -x[(i, j)])));
        }
    }
    let mut entries = entries.into_iter();
    let rebuilt = |(term, entries): (&Term, Vec<Entry>)| {
        built(basis.kept, basis.kept, &entries)
            .map(|matrix| Term { matrix: Arc::new(matrix), factor: term.factor.clone() })
    };
    let damping = matrices.damping.iter().zip(entries.by_ref()).map(rebuilt).collect::<Result<_, _>>()?;
    let stiffness = matrices.stiffness.iter().zip(entries).map(rebuilt).collect::<Result<_, _>>()?;
    let mut mass = basis.entries(&matrices.mass);
    mass.retain(|(row, column, _)| *row < basis.kept && *column < basis.kept);
    let mass = Arc::new(built(basis.kept, basis.kept, &mass)?);
    let displacements = basis.displacements(&following)?;
    let matrices = Matrices { mass, damping, stiffness, parameters: matrices.parameters.clone() };
    Ok(Some(Condensed { matrices, displacements }))
}

/// A row, a column and a value.
type Entry = (usize, usize, f64);

fn built(rows: usize, columns: usize, entries: &[Entry]) -> Result<Matrix, CondensationError> {
    let triplets: Vec<Triplet<usize, usize, f64>> =
        entries.iter().map(|&(row, column, value)| Triplet::new(row, column, value)).collect();
    Matrix::try_new_from_triplets(rows, columns, &triplets).map_err(|_| CondensationError::Memory)
}

/// Coordinates in which what has no mass stands last.
struct Basis {
    /// The displacements for each coordinate: degrees of freedom with their values.
    columns: Vec<Vec<(usize, f64)>>,
    /// How many coordinates have mass.
    kept: usize,
    /// For each degree of freedom the coordinates that move it.
    rows: Vec<Vec<(usize, f64)>>,
}

impl Basis {
    fn new(mass: &Matrix) -> Self {
        let size = mass.nrows();
        let entries = || mass.triplet_iter().filter(|entry| *entry.val != 0.0).map(|entry| (entry.row, entry.col));
        let groups = groups(size, entries());
        let mut has_entries = vec![false; size];
        entries().for_each(|(row, _)| has_entries[row] = true);
        let (mut columns, mut without) = (Vec::new(), Vec::new());
        for group in groups {
            if group.len() == 1 && !has_entries[group[0]] {
                without.push(vec![(group[0], 1.0)]);
                continue;
            }
            let vectors = Some(&group).filter(|group| group.len() <= MOST).and_then(|group| separated(mass, group));
            let Some((vectors, masses)) = vectors else {
                columns.extend(group.iter().map(|place| vec![(*place, 1.0)]));
                continue;
            };
            for (vector, mass) in vectors.column_iter().zip(&masses) {
                let column = group.iter().copied().zip(vector.iter().copied()).collect();
                if *mass > NO_MASS { columns.push(column) } else { without.push(column) }
            }
        }
        let kept = columns.len();
        columns.append(&mut without);
        let mut rows = vec![Vec::new(); size];
        for (coordinate, column) in columns.iter().enumerate() {
            column.iter().for_each(|&(place, value)| rows[place].push((coordinate, value)));
        }
        Self { columns, kept, rows }
    }

    /// The entries of a matrix in these coordinates.
    fn entries(&self, matrix: &Matrix) -> Vec<Entry> {
        let mut entries = Vec::new();
        for entry in matrix.triplet_iter().filter(|entry| *entry.val != 0.0) {
            for (row, left) in &self.rows[entry.row] {
                entries.extend(
                    self.rows[entry.col].iter().map(|(column, right)| (*row, *column, left * entry.val * right)),
                );
            }
        }
        entries
    }

    /// The degree of freedom that a coordinate moves most.
    fn place(&self, coordinate: usize) -> usize {
        let most = |a: (usize, f64), b: &(usize, f64)| if b.1.abs() > a.1.abs() { *b } else { a };
        self.columns[coordinate].iter().fold((0, 0.0), most).0
    }

    /// The displacements for the coordinates that are kept, with those of the others that follow them.
    fn displacements(&self, following: &[Entry]) -> Result<Matrix, CondensationError> {
        let own = (0..self.kept).map(|coordinate| (coordinate, coordinate, 1.0));
        let mut entries = Vec::new();
        for (coordinate, column, share) in own.chain(following.iter().copied()) {
            entries.extend(self.columns[coordinate].iter().map(|(place, value)| (*place, column, value * share)));
        }
        built(self.rows.len(), self.kept, &entries)
    }
}

/// The motions of a group of degrees of freedom, as columns with their masses, if some have none and the others do.
fn separated(mass: &Matrix, group: &[usize]) -> Option<(DMatrix<f64>, Vec<f64>)> {
    let own = DMatrix::from_fn(group.len(), group.len(), |i, j| mass.get(group[i], group[j]).copied().unwrap_or(0.0));
    let (scaled, scales) = by_its_diagonal(&own)?;
    if is_definite(&scaled, NO_MASS) {
        return None;
    }
    let decomposed = SymmetricEigen::try_new(scaled, f64::EPSILON, SWEEPS * group.len())?;
    let values = &decomposed.eigenvalues;
    if values.iter().any(|value| *value < -NO_MASS || (NO_MASS..MASS).contains(value)) {
        return None;
    }
    Some((DMatrix::from_diagonal(&scales) * &decomposed.eigenvectors, values.iter().copied().collect()))
}

/// A symmetric matrix scaled to ones on the diagonal, with the scales of its rows; none where the diagonal is not positive.
fn by_its_diagonal(matrix: &DMatrix<f64>) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let diagonal = matrix.diagonal();
    if !diagonal.iter().all(|value| *value > 0.0) {
        return None;
    }
    let scales = diagonal.map(|value| 1.0 / value.sqrt());
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * scales[i] * scales[j]);
    Some((scaled, scales))
}

/// Whether all pivots of a symmetric matrix with ones on its diagonal are larger than this.
fn is_definite(scaled: &DMatrix<f64>, least: f64) -> bool {
    let factorised = scaled.clone().cholesky();
    factorised.is_some_and(|factor| factor.l_dirty().diagonal().iter().all(|value| value * value > least))
}

/// Places from 0 that pairs join, each group in order and by its first place.
fn groups(size: usize, pairs: impl Iterator<Item = (usize, usize)>) -> Vec<Vec<usize>> {
    let mut first: Vec<usize> = (0..size).collect();
    let find = |first: &mut [usize], mut place: usize| {
        while first[place] != place {
            first[place] = first[first[place]];
            place = first[place];
        }
        place
    };
    for (a, b) in pairs {
        let (a, b) = (find(&mut first, a), find(&mut first, b));
        first[a.max(b)] = a.min(b);
    }
    let mut number = vec![usize::MAX; size];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for place in 0..size {
        let own = find(&mut first, place);
        if own == place {
            number[place] = groups.len();
            groups.push(Vec::new());
        }
        groups[number[own]].push(place);
    }
    groups
}

/// What acts on a group of coordinates without mass and by it.
struct Forces<'a> {
    members: &'a [usize],
    acting: &'a [(usize, Entry)],
    /// The coordinates with mass on which it acts.
    rows: Vec<usize>,
    /// Those that act on it.
    columns: Vec<usize>,
}

/// Its forces on itself, those of others on it, and its own on others.
struct Blocks {
    own: DMatrix<f64>,
    after: DMatrix<f64>,
    before: DMatrix<f64>,
    /// The largest of what they are summed from.
    largest: f64,
}

impl<'a> Forces<'a> {
    fn new(members: &'a [usize], acting: &'a [(usize, Entry)], kept: usize) -> Self {
        let with_mass = |place: fn(&Entry) -> usize| {
            let mut places: Vec<usize> =
                acting.iter().map(|(_, entry)| place(entry)).filter(|place| *place < kept).collect();
            places.sort_unstable();
            places.dedup();
            places
        };
        Self { members, acting, rows: with_mass(|entry| entry.0), columns: with_mass(|entry| entry.1) }
    }

    fn terms(&self) -> Vec<usize> {
        let mut terms: Vec<usize> = self.acting.iter().map(|(term, _)| *term).collect();
        terms.sort_unstable();
        terms.dedup();
        terms
    }

    /// The sum of terms, each times a number.
    fn sum(&self, of: &[(usize, f64)]) -> Blocks {
        let size = self.members.len();
        let mut blocks = Blocks {
            own: DMatrix::zeros(size, size),
            after: DMatrix::zeros(size, self.columns.len()),
            before: DMatrix::zeros(self.rows.len(), size),
            largest: 0.0,
        };
        let place = |places: &[usize], own: usize| places.binary_search(&own);
        for (term, (row, column, value)) in self.acting {
            let Some((_, times)) = of.iter().find(|(own, _)| own == term) else { continue };
            let value = value * times;
            blocks.largest = blocks.largest.max(value.abs());
            match (place(self.members, *row), place(self.members, *column)) {
                (Ok(i), Ok(j)) => blocks.own[(i, j)] += value,
                (Ok(i), Err(_)) => {
                    if let Ok(j) = place(&self.columns, *column) {
                        blocks.after[(i, j)] += value;
                    }
                }
                (Err(_), Ok(j)) => {
                    if let Ok(i) = place(&self.rows, *row) {
                        blocks.before[(i, j)] += value;
                    }
                }
                (Err(_), Err(_)) => {}
            }
        }
        blocks
    }
}

impl Blocks {
    /// X and Y, if the symmetric part of what acts on itself is finite and positive definite.
    fn followed(&self) -> Option<[DMatrix<f64>; 2]> {
        if !self.own.iter().all(|value| value.is_finite()) {
            return None;
        }
        let symmetric = (&self.own + self.own.transpose()) * 0.5;
        if !is_definite(&by_its_diagonal(&symmetric)?.0, HELD) {
            return None;
        }
        let x = self.own.clone().lu().solve(&self.after)?;
        let y = self.own.transpose().lu().solve(&self.before.transpose())?.transpose();
        Some([x, y])
    }

    /// Whether the group follows the others by X, and acts on them by Y.
    fn is_followed(&self, x: &DMatrix<f64>, y: &DMatrix<f64>) -> bool {
        let size = |matrix: &DMatrix<f64>| matrix.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let is_small = |left: DMatrix<f64>, by: &DMatrix<f64>| size(&left) <= ALIKE * self.largest * (1.0 + size(by));
        is_small(&self.own * x - &self.after, x) && is_small(y * &self.own - &self.before, y)
    }
}

/// Terms of one kind whose factors differ by a number alone, each with that number over that of the first. Those with the
/// factor 0 are left out.
fn alike(terms: &[&Term], stiffness_from: usize, of: Vec<usize>) -> Vec<Vec<(usize, f64)>> {
    let mut groups: Vec<Vec<(usize, f64)>> = Vec::new();
    for term in of.into_iter().filter(|term| terms[*term].factor != Factor::number(0.0)) {
        let ratio = |first: usize| {
            let is_alike = (first < stiffness_from) == (term < stiffness_from);
            terms[term].factor.over(&terms[first].factor).filter(|_| is_alike)
        };
        let found = groups.iter_mut().find_map(|group| ratio(group[0].0).map(|ratio| (group, ratio)));
        match found {
            Some((group, ratio)) => group.push((term, ratio)),
            None => groups.push(vec![(term, 1.0)]),
        }
    }
    groups
}

#[cfg(test)]
mod tests;
