//! Points in the space of deviates, and what is known of them.

use crate::special_functions::normal;

/// Points in the space of deviates, one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    dimensions: usize,
    coordinates: Vec<f64>,
}

impl Points {
    /// No points yet.
    #[must_use]
    pub fn new(dimensions: usize) -> Self {
        Self { dimensions, coordinates: Vec::new() }
    }

    /// The number of deviates of a point, at least one.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.coordinates.len() / self.dimensions.max(1)
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.coordinates.is_empty()
    }

    /// Adds a point.
    pub fn push(&mut self, point: impl IntoIterator<Item = f64>) {
        self.coordinates.extend(point);
    }

    /// The points.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> + Clone {
        self.coordinates.chunks_exact(self.dimensions.max(1))
    }

    /// A point.
    #[must_use]
    pub fn get(&self, point: usize) -> &[f64] {
        &self.coordinates[point * self.dimensions..][..self.dimensions]
    }

    /// Puts another point in the place of one.
    pub(super) fn replace(&mut self, point: usize, by: &[f64]) {
        self.coordinates[point * self.dimensions..][..self.dimensions].copy_from_slice(by);
    }
}

/// What a rare event is the mean of.
///
/// A closure that returns `g` at points is one without a limit state.
pub trait Integrand {
    /// `g` at points, from 0 to 1 each, `None` without a verdict; the outer `None` if it is stopped before.
    fn values(&mut self, points: &Points) -> Option<Vec<Option<f64>>>;

    /// A limit state at points with these `g`: a continuous function of the deviates, with a gradient nearly everywhere,
    /// that is below zero where `g` is above 1/2. Not a number where there is none; `None` if there is none anywhere.
    fn limit_states(&mut self, points: &Points, values: &[Option<f64>]) -> Option<Vec<f64>> {
        let _ = (points, values);
        None
    }

    /// How many limit states there are beside that one, each with a part of the event, so that regions behind it are found.
    fn branches(&mut self) -> usize {
        0
    }

    /// Which of them [`limit_states`](Self::limit_states) returns from now on; the one of the whole event for `None`.
    fn select(&mut self, branch: Option<usize>) {
        let _ = branch;
    }

    /// All of them at each point, which are found together: not a number where one has none. `None` if it is stopped
    /// before, or if there are none.
    fn branch_states(&mut self, points: &Points) -> Option<Vec<Vec<f64>>> {
        let _ = points;
        None
    }
}

impl<F: FnMut(&Points) -> Option<Vec<Option<f64>>>> Integrand for F {
    fn values(&mut self, points: &Points) -> Option<Vec<Option<f64>>> {
        self(points)
    }
}

/// The largest limit state of a conditional probability, beyond that of the smallest number.
const FARTHEST: f64 = 40.0;

/// A conditional probability that is a continuous function of the deviates, by a closure that returns it at points. Its limit
/// state is `-z`, where a standard normal deviate is below `z` with this probability; from -40, where it is 1, to 40, where
/// it is 0.
pub struct ConditionalProbability<F>(pub F);

impl<F: FnMut(&Points) -> Option<Vec<Option<f64>>>> Integrand for ConditionalProbability<F> {
    fn values(&mut self, points: &Points) -> Option<Vec<Option<f64>>> {
        self.0(points)
    }

    fn limit_states(&mut self, _: &Points, values: &[Option<f64>]) -> Option<Vec<f64>> {
        let limit_state = |value: &Option<f64>| match *value {
            None => f64::NAN,
            Some(g) if g <= 0.0 => FARTHEST,
            Some(g) if g >= 1.0 => -FARTHEST,
            Some(g) => -normal::quantile(g),
        };
        Some(values.iter().map(limit_state).collect())
    }
}

/// A limit state, by a closure that returns it at a point: `g` is 1 where it is below zero. Where it is not a number there is
/// no verdict.
pub struct LimitState<S>(pub S);

impl<S: FnMut(&[f64]) -> f64> Integrand for LimitState<S> {
    fn values(&mut self, points: &Points) -> Option<Vec<Option<f64>>> {
        let value = |state: f64| (!state.is_nan()).then_some(if state < 0.0 { 1.0 } else { 0.0 });
        Some(points.iter().map(|point| value(self.0(point))).collect())
    }

    fn limit_states(&mut self, points: &Points, _: &[Option<f64>]) -> Option<Vec<f64>> {
        Some(points.iter().map(&mut self.0).collect())
    }
}

/// Limit states of branches, by a closure that returns all of them at a point: `g` is 1 where one of them is below zero. The
/// limit state of the whole is the least.
pub struct LimitBranches<S> {
    states: S,
    count: usize,
    selected: Option<usize>,
}

impl<S: FnMut(&[f64]) -> Vec<f64>> LimitBranches<S> {
    /// So many branches.
    #[must_use]
    pub fn new(count: usize, states: S) -> Self {
        Self { states, count, selected: None }
    }

    fn state(&mut self, point: &[f64], branch: Option<usize>) -> f64 {
        let states = (self.states)(point);
        match branch {
            Some(branch) => states.get(branch).copied().unwrap_or(f64::NAN),
            None => states.into_iter().fold(f64::INFINITY, f64::min),
        }
    }
}

impl<S: FnMut(&[f64]) -> Vec<f64>> Integrand for LimitBranches<S> {
    fn values(&mut self, points: &Points) -> Option<Vec<Option<f64>>> {
        let value = |state: f64| Some(if state < 0.0 { 1.0 } else { 0.0 });
        Some(points.iter().map(|point| value(self.state(point, None))).collect())
    }

    fn limit_states(&mut self, points: &Points, _: &[Option<f64>]) -> Option<Vec<f64>> {
        let selected = self.selected;
        Some(points.iter().map(|point| self.state(point, selected)).collect())
    }

    fn branches(&mut self) -> usize {
        self.count
    }

    fn select(&mut self, branch: Option<usize>) {
        self.selected = branch;
    }

    fn branch_states(&mut self, points: &Points) -> Option<Vec<Vec<f64>>> {
        Some(points.iter().map(&mut self.states).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_states_of_probabilities_are_ordered_from_one_to_zero() {
        let probabilities = [1.0, 1.0 - f64::EPSILON, 0.5, 1e-9, 5e-324, 0.0].map(Some);
        let mut points = Points::new(1);
        (0..6).for_each(|i| points.push([f64::from(i)]));
        let mut integrand = ConditionalProbability(|_: &Points| Some(probabilities.to_vec()));
        let states = integrand.limit_states(&points, &probabilities).unwrap();
        assert!(states.is_sorted() && states[0] == -40.0 && states[2] == 0.0 && states[5] == 40.0, "{states:?}");
        assert!((states[3] - 5.997_807_015_007_687).abs() < 1e-12, "{states:?}");
        assert!(integrand.limit_states(&points, &[None]).unwrap()[0].is_nan());
    }

    #[test]
    fn the_limit_state_of_all_branches_is_the_least() {
        let mut integrand = LimitBranches::new(2, |u: &[f64]| vec![3.0 - u[0], 2.0 + u[0]]);
        let mut points = Points::new(1);
        [0.0, 3.5, -2.5].iter().for_each(|u| points.push([*u]));
        assert_eq!(integrand.values(&points).unwrap(), [0.0, 1.0, 1.0].map(Some));
        assert_eq!(integrand.limit_states(&points, &[]).unwrap(), [2.0, -0.5, -0.5]);
        assert_eq!(integrand.branch_states(&points).unwrap(), [[3.0, 2.0], [-0.5, 5.5], [5.5, -0.5]]);
        integrand.select(Some(1));
        assert_eq!(integrand.limit_states(&points, &[]).unwrap(), [2.0, 5.5, -0.5]);
        assert_eq!((integrand.branches(), integrand.values(&points).unwrap()[2]), (2, Some(1.0)));
    }
}
