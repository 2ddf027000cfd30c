//! Where a function that begins at zero reaches a level.

/// Most evaluations.
const MOST: usize = 60;

/// How near to the level is near enough, relative to it.
const NEAR: f64 = 1e-4;

/// Where the function steps over the level, the step is located to this, relative to its argument.
const NARROW: f64 = 1e-6;

/// What `f` says beside its value where that reaches `level`; it is about proportional to its argument. `None` if it does
/// not reach it up to `farthest`. The first place to look at is `first`.
pub(super) fn reached<T>(level: f64, first: f64, farthest: f64, mut f: impl FnMut(f64) -> (f64, T)) -> Option<T> {
    let (mut below, mut above) = ((0.0, 0.0), None::<(f64, f64)>);
    let (mut before, mut at) = ((0.0, 0.0), first.min(farthest));
    for _ in 0..MOST {
        let (value, what) = f(at);
        if (value - level).abs() <= NEAR * level {
            return Some(what);
        }
        if value < level {
            if at >= farthest {
                return None;
            }
            below = (at, value);
        } else {
            above = Some((at, value));
        }
        // Along the secant through the last two points, if that leads to where the level may be.
        let secant = at + (level - value) * (at - before.0) / (value - before.1);
        // Where they hardly come nearer, there may be a step.
        let comes_nearer = (value - level).abs() <= 0.5 * (before.1 - level).abs();
        before = (at, value);
        at = match above {
            None if secant > at => secant.clamp(1.001 * at, 3.0 * at).min(farthest),
            None => (3.0 * at).min(farthest),
            Some(above) if above.0 - below.0 <= NARROW * above.0 => return Some(what),
            Some(above) if comes_nearer && secant > below.0 && secant < above.0 => secant,
            Some(above) => 0.5 * (below.0 + above.0),
        };
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_reached_of_curved_functions_and_of_steps() {
        for first in [1e-3, 1.0, 50.0] {
            let square = reached(2.0, first, 100.0, |at| (at * at, at)).unwrap();
            assert!((square - 2.0_f64.sqrt()).abs() < 1e-3, "{square}");
            let root = reached(2.0, first, 100.0, |at| (at.sqrt(), at)).unwrap();
            assert!((root - 4.0).abs() < 1e-2, "{root}");
            let step = reached(2.0, first, 100.0, |at| (if at < 7.0 { 0.1 } else { 9.0 }, at)).unwrap();
            assert!((step - 7.0).abs() < 1e-2, "{step}");
            assert_eq!(reached(2.0, first, 100.0, |at| (at / 100.0, at)), None);
        }
    }

    #[test]
    fn a_level_takes_few_evaluations() {
        let count = |f: &dyn Fn(f64) -> f64, first: f64| {
            let mut count = 0;
            let at = |at: f64| {
                count += 1;
                (f(at), at)
            };
            assert!(reached(2.0, first, 100.0, at).is_some());
            count
        };
        assert!(count(&|at| at + 0.05 * at * at, 1.5) <= 5);
        assert!(count(&|at| at - 0.05 * at * at, 2.5) <= 5);
        assert!(count(&|at| if at < 1.7 { at } else { 40.0 * at }, 1.5) <= 30);
    }
}
