//! The search for rare events, and its first step: points tried with larger and larger scatter.

use rand::RngExt;
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::estimate::weighted::Event;
use crate::rare::points::{Integrand, Points};
use crate::rare::scatters::{Scatters, square};

/// The enlargements of the scatter that are tried are the powers of this number below the largest.
const ENLARGEMENT: f64 = 1.5;
const LARGEST: f64 = 12.0;

/// The mean of `g` at which the scatter is not enlarged any further.
const FREQUENT: f64 = 0.1;

/// Scatters beyond that one that are tried as well, unless it is that of the inputs: an island beside a region that becomes
/// frequent is met there.
const FURTHER: usize = 2;

/// How much is done to find a population.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Particles.
    pub particles: usize,
    /// Moves of each after a step: some 4 to see where the particles lie, 8 for their probability, as with fewer moves in
    /// ten dimensions it scatters by twice as much.
    pub moves: usize,
}

/// Points that were tried with larger and larger scatter.
#[derive(Debug, Clone, PartialEq)]
pub struct Explored {
    /// Those that may be unstable, and their `g`.
    pub points: Points,
    /// See above.
    pub values: Vec<f64>,
    /// Those with a limit state, stable ones too, and this of each, if it was asked for; below zero where the event happens.
    pub with_limit_state: Vec<(Vec<f64>, f64)>,
    /// The scatters, each with as many points.
    pub scatters: Scatters,
    /// The number of points.
    pub tried: u64,
    /// The probability that a sample has no verdict. Such points lead nowhere.
    pub without_verdict: f64,
    /// Whose `g` it is.
    pub event: Event,
}

impl Explored {
    /// What each point adds to the probability: `g phi / q` over the number of points.
    #[must_use]
    pub fn weights(&self) -> Vec<f64> {
        let weight = |(point, value): (&[f64], &f64)| {
            value * libm::exp(self.scatters.log_ratio(square(point), self.points.dimensions())) / self.tried as f64
        };
        self.points.iter().zip(&self.values).map(weight).collect()
    }

    /// The number of points that were tried without enlargement, and the sum of their `g`, if that was enough; else zeros.
    #[must_use]
    pub fn of_inputs(&self) -> [f64; 2] {
        match self.scatters.enlargements() {
            [_] => [self.tried as f64, self.values.iter().sum()],
            _ => [0.0; 2],
        }
    }
}

/// A search for regions of a rare event.
pub struct Search<'a> {
    dimensions: usize,
    effort: Effort,
    /// Values of `g` that were computed.
    evaluations: u64,
    /// What is looked for.
    event: Event,
    pub(super) generator: &'a mut Xoshiro256PlusPlus,
    integrand: &'a mut dyn Integrand,
}

impl<'a> Search<'a> {
    /// Begins.
    pub fn new(
        dimensions: usize,
        effort: Effort,
        generator: &'a mut Xoshiro256PlusPlus,
        integrand: &'a mut dyn Integrand,
    ) -> Self {
        Self { dimensions, effort, evaluations: 0, event: Event::Instability, generator, integrand }
    }

    /// The number of deviates.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    pub(super) fn event(&self) -> Event {
        self.event
    }

    pub(super) fn effort(&self) -> Effort {
        self.effort
    }

    /// Values of `g` that were computed. A limit state beside it is counted with it.
    #[must_use]
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Tries `count` points each with larger and larger scatter, until instability is frequent; or stability, if it is the
    /// rarer of both. `None` if it is stopped before.
    pub fn explore(&mut self, count: usize) -> Option<Explored> {
        self.explore_by(count, |search, points| Some((search.integrand.values(points)?, Vec::new())))
    }

    /// [`Search::explore`], and the limit states of the points.
    pub fn explore_limit_states(&mut self, count: usize) -> Option<Explored> {
        self.explore_by(count, Self::values_and_limit_states)
    }

    fn explore_by(
        &mut self,
        count: usize,
        evaluate: impl Fn(&mut Self, &Points) -> Option<(Vec<Option<f64>>, Vec<f64>)>,
    ) -> Option<Explored> {
        let dimensions = self.dimensions;
        self.event = Event::Instability;
        let mut scatters = Scatters::default();
        let (mut points, mut values, mut without) = (Points::new(dimensions), Vec::new(), Vec::new());
        let mut with_limit_state = Vec::new();
        let (mut scale, mut tried, mut further) = (1.0, 0, 0);
        while scale < LARGEST {
            scatters.add(scale);
            tried += count as u64;
            let mut drawn = Points::new(dimensions);
            drawn.push((0..count * dimensions).map(|_| scale * self.deviate()));
            self.evaluations += count as u64;
            let (of_instability, limit_states) = evaluate(self, &drawn)?;
            if tried == count as u64 && of_instability.iter().flatten().sum::<f64>() > 0.5 * count as f64 {
                self.event = Event::Stability;
            }
            let found = self.of_event(of_instability);
            for (point, value) in drawn.iter().zip(&found) {
                match *value {
                    None => without.push(square(point)),
                    Some(value) if value > 0.0 => {
                        points.push(point.iter().copied());
                        values.push(value);
                    }
                    Some(_) => {}
                }
            }
            let states = drawn.iter().zip(limit_states).filter(|(_, state)| !state.is_nan());
            with_limit_state.extend(states.map(|(point, state)| (point.to_vec(), self.event.limit_state(state))));
            if found.iter().flatten().sum::<f64>() >= FREQUENT * count as f64 {
                if scale == 1.0 || further == FURTHER {
                    break;
                }
                further += 1;
            }
            scale *= ENLARGEMENT;
        }
        let weight = |square: f64| libm::exp(scatters.log_ratio(square, dimensions));
        let without_verdict = without.into_iter().map(weight).sum::<f64>() / tried as f64;
        let event = self.event;
        Some(Explored { points, values, with_limit_state, scatters, tried, without_verdict, event })
    }

    pub(super) fn deviate(&mut self) -> f64 {
        self.generator.sample(StandardNormal)
    }

    /// `g` at points; `None` if it is stopped before.
    pub(super) fn evaluate(&mut self, points: &Points) -> Option<Vec<Option<f64>>> {
        self.evaluations += points.len() as u64;
        let values = self.integrand.values(points)?;
        Some(self.of_event(values))
    }

    /// `g` at points, and their limit states, none where there are none; `None` if it is stopped before.
    pub(super) fn evaluate_limit_states(&mut self, points: &Points) -> Option<(Vec<Option<f64>>, Vec<f64>)> {
        self.evaluations += points.len() as u64;
        let (values, states) = self.values_and_limit_states(points)?;
        Some((self.of_event(values), states.into_iter().map(|state| self.event.limit_state(state)).collect()))
    }

    /// The same, of instability.
    fn values_and_limit_states(&mut self, points: &Points) -> Option<(Vec<Option<f64>>, Vec<f64>)> {
        let values = self.integrand.values(points)?;
        let mut states = self.integrand.limit_states(points, &values).unwrap_or_else(|| vec![f64::NAN; points.len()]);
        // What has no verdict leads nowhere.
        states.iter_mut().zip(&values).filter(|(_, value)| value.is_none()).for_each(|(state, _)| *state = f64::NAN);
        Some((values, states))
    }

    /// `g` of the event, from that of instability.
    fn of_event(&self, mut values: Vec<Option<f64>>) -> Vec<Option<f64>> {
        values.iter_mut().flatten().for_each(|value| *value = self.event.value(*value));
        values
    }

    /// How many limit states there are beside that of the whole event.
    pub(super) fn branches(&mut self) -> usize {
        self.integrand.branches()
    }

    /// Which of them is asked for.
    pub(super) fn select(&mut self, branch: Option<usize>) {
        self.integrand.select(branch);
    }

    /// The limit states of all of them at each point, not a number where one has none; `None` if it is stopped before.
    pub(super) fn branch_states(&mut self, points: &Points) -> Option<Vec<Vec<f64>>> {
        self.evaluations += points.len() as u64;
        self.integrand.branch_states(points)
    }

    /// Whether the event has limit states.
    pub(super) fn has_limit_states(&mut self) -> bool {
        self.integrand.limit_states(&Points::new(self.dimensions), &[]).is_some()
    }
}
