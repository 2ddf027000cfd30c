//! Where a function that begins at zero reaches a level.

/// Most evaluations.
const MOST: usize = 60;

/// How near to the level is near enough, relative to it.
const NEAR: f64 = 1e-4;

/// What `f` says beside its value where that reaches `level`; it is about proportional to its argument. `None` if it does
/// not reach it up to `farthest`. The first place to look at is `first`.
pub(super) fn reached<T>(level: f64, first: f64, farthest: f64, mut f: impl FnMut(f64) -> (f64, T)) -> Option<T> {
    let (mut below, mut above) = ((0.0, 0.0), None::<(f64, f64)>);
    let mut at = first.min(farthest);
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
        at = match above {
            // At most three times as far.
            None => (at * (level / value.max(level / 3.0)).clamp(1.2, 3.0)).min(farthest),
            Some(above) => {
                let share = ((level - below.1) / (above.1 - below.1)).clamp(0.05, 0.95);
                let next = below.0 + share * (above.0 - below.0);
                if above.0 - below.0 <= 1e-9 * above.0 {
                    return Some(what);
                }
                next
            }
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
}
