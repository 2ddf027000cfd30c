//! Where a function changes its sign, inside a bracket.

/// Halves the bracket `early..late` as long as its middle lies inside it and it is wider than `tolerance` times
/// `early`, `most` times at most; `is_early` is true for points before the change of sign. Returns the bracket.
pub(crate) fn bisect(
    (mut early, mut late): (f64, f64),
    most: usize,
    tolerance: f64,
    is_early: impl Fn(f64) -> bool,
) -> (f64, f64) {
    for _ in 0..most {
        let middle = 0.5 * (early + late);
        if middle <= early || middle >= late || late - early <= tolerance * early {
            break;
        }
        if is_early(middle) {
            early = middle;
        } else {
            late = middle;
        }
    }
    (early, late)
}

/// An end of a bracket: the point, and the value there.
pub(crate) type End = (f64, f64);

/// Where a value that is positive at `early` and not positive at `late` vanishes, on the side where it is not positive,
/// to `tolerance`; and the state there. See [`FalsePosition`].
///
/// `state_at` computes the state at a point, and `value` the value of a state; `state` is the one at `late`.
pub(crate) fn false_position<S: Copy>(
    early: End,
    late: End,
    mut state: S,
    tolerance: f64,
    state_at: impl Fn(f64) -> S,
    value: impl Fn(&S) -> f64,
) -> (f64, S) {
    let mut search = FalsePosition::new(early, late, tolerance);
    while let Some(point) = search.next_point() {
        let candidate = state_at(point);
        if search.add(point, value(&candidate)) {
            state = candidate;
        }
    }
    (search.late(), state)
}

/// A search for a change of sign whose caller finds the values, one after the other: the Illinois variant of the false
/// position, with bisection as its safeguard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FalsePosition {
    early: End,
    late: End,
    tolerance: f64,
    iteration: u32,
    moved: Option<Moved>,
}

impl FalsePosition {
    /// In a bracket at whose `early` end the value is positive, and at whose `late` end it is not.
    pub fn new(early: End, late: End, tolerance: f64) -> Self {
        Self { early, late, tolerance, iteration: 0, moved: None }
    }

    /// Where the value is needed next; `None` if the change of sign is located.
    pub fn next_point(&mut self) -> Option<f64> {
        let ((early, at_early), (late, at_late)) = (self.early, self.late);
        if self.iteration == MOST_POINTS || late - early <= self.tolerance || at_late == 0.0 {
            return None;
        }
        let secant = early + (late - early) * (at_early / (at_early - at_late));
        let middle = 0.5 * (early + late);
        let point = if self.iteration % 8 < 7 && secant > early && secant < late { secant } else { middle };
        self.iteration += 1;
        (point > early && point < late).then_some(point)
    }

    /// Adds a value. Returns whether the point is the late end of the bracket now.
    pub fn add(&mut self, point: f64, value: f64) -> bool {
        // An end that stays twice in a row counts half, or it would stay for ever.
        let moved = if value > 0.0 {
            self.early = (point, value);
            if self.moved == Some(Moved::Early) {
                self.late.1 *= 0.5;
            }
            Moved::Early
        } else {
            self.late = (point, value);
            if self.moved == Some(Moved::Late) {
                self.early.1 *= 0.5;
            }
            Moved::Late
        };
        self.moved = Some(moved);
        moved == Moved::Late
    }

    /// The late end of the bracket.
    pub fn late(&self) -> f64 {
        self.late.0
    }
}

/// Largest number of points of a search.
const MOST_POINTS: u32 = 100;

/// The end of the bracket that moved last.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Moved {
    Early,
    Late,
}

/// A point in a range at which a function with one maximum is not negative, where it is negative at both ends; by golden
/// section towards the maximum, near which values differ by no more than `unresolved`.
pub(crate) fn rise_to_zero((low, high): (f64, f64), unresolved: f64, value: impl Fn(f64) -> f64) -> Option<f64> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (low, high);
    let mut left = high - GOLDEN * (high - low);
    let mut right = low + GOLDEN * (high - low);
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..40 {
        if at_left >= 0.0 {
            return Some(left);
        }
        if at_right >= 0.0 {
            return Some(right);
        }
        // Closer to its maximum the function differs by less than it is resolved.
        if (at_left - at_right).abs() <= unresolved {
            break;
        }
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = value(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = value(right);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    type Curve = fn(f64) -> f64;

    #[test]
    fn a_change_of_sign_is_located_to_the_last_digits_on_its_later_side() {
        let curves: [(Curve, f64); 6] = [
            (libm::cos, std::f64::consts::FRAC_PI_2),
            (|t| 1.0 - t, 1.0),
            (|t| 1.0 - t * t * t * t * t * t * t * t, 1.0),
            // So steep beyond the root that secants alone get nowhere.
            (|t| 1.0 - libm::pow(t / 1.1, 90.0), 1.1),
            (|t| libm::exp(-30.0 * t) - libm::exp(-30.0), 1.0),
            (|t| if t < 1.3 { 1e9 } else { -1e-9 }, 1.3),
        ];
        for (index, (value, expected)) in curves.into_iter().enumerate() {
            let ends = ((0.0, value(0.0)), (2.0, value(2.0)));
            let (point, state) = false_position(ends.0, ends.1, 2.0, 2e-15, |point| point, |&state| value(state));
            assert!((point - expected).abs() < 1e-14, "{index}: {point}");
            assert_eq!(point, state, "the state is the one at the point");
            assert!(value(state) <= 0.0, "{index}: {}", value(state));
        }
    }

    #[test]
    fn a_root_far_from_either_end_of_a_curve_takes_few_steps() {
        // From either side secants alone would creep up to it.
        let curved: [Curve; 2] = [|t| 1.0 - t * t * t * t * t * t * t * t, |t| libm::exp(-5.0 * t) - libm::exp(-5.0)];
        for (index, value) in curved.into_iter().enumerate() {
            let steps = Cell::new(0);
            let state_at = |point| {
                steps.set(steps.get() + 1);
                point
            };
            let ends = ((0.0, value(0.0)), (2.0, value(2.0)));
            false_position(ends.0, ends.1, 2.0, 2e-15, state_at, |&state| value(state));
            assert!(steps.get() <= 22, "{index}: {}", steps.get());
        }
    }

    #[test]
    fn bisection_stops_at_its_tolerance_or_between_neighbouring_numbers() {
        let (early, late) = bisect((1.0, 2.0), 100, 1e-3, |x| x * x < 2.0);
        assert!(early * early < 2.0 && late * late >= 2.0 && late - early <= 1e-3 * early, "{early} {late}");
        let (early, late) = bisect((1.0, 2.0), 100, 0.0, |x| x * x < 2.0);
        assert_eq!(late.to_bits(), early.to_bits() + 1);
        assert_eq!(bisect((0.0, 8.0), 2, 0.0, |_| true), (6.0, 8.0));
    }
}
