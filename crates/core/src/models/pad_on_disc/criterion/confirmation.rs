//! Finer steps for a motion whose verdict may depend on errors of the steps.
//!
//! A motion is doubtful if it grazed the disc's speed, or hovered about an unstable cycle; what counts as either shrinks with
//! the errors of the steps. A motion without a verdict is not simulated again.
//!
//! | steps divided by | a motion |
//! |---|---|
//! | 1 | that is doubtful is simulated again |
//! | 2 | that is still doubtful, or has another verdict than before, is simulated again |
//! | 4 | that has another verdict than before is undecided |

use crate::model::decision::Decision;
use crate::model::recorded::NOTHING;
use crate::model::verdict::Verdict;

/// By what the steps are divided at most.
const FINEST: f64 = 4.0;

/// The simulation of a sample among those with ever finer steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Confirmation {
    /// By what its steps are divided.
    pub divisor: f64,
    /// The verdict of the simulation before the present one.
    before: Option<Verdict>,
}

impl Confirmation {
    /// Of a sample that is simulated for the first time.
    pub const NONE: Self = Self { divisor: 1.0, before: None };

    /// The decision on a sample, unless it is to be simulated again with the `divisor` then.
    pub fn accept(&mut self, decision: Decision, is_doubtful: bool) -> Option<Decision> {
        let verdict = decision.verdict;
        if !matches!(verdict, Verdict::Stable | Verdict::Unstable) {
            return Some(decision);
        }
        let is_same = self.before.replace(verdict).is_none_or(|before| before == verdict);
        let is_finest = self.divisor >= FINEST;
        if is_same && (is_finest || !is_doubtful) {
            return Some(decision);
        }
        if is_finest {
            return Some(Decision { verdict: Verdict::Undecided, recorded: NOTHING, fed_by: None, ..decision });
        }
        self.divisor *= 2.0;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The verdict after simulations with these verdicts, all of them doubtful, and by what its steps are divided then.
    fn verdict_of(verdicts: [Verdict; 3]) -> (Verdict, f64) {
        let mut confirmation = Confirmation::NONE;
        for verdict in verdicts {
            if let Some(decision) = confirmation.accept(Decision::from(verdict), true) {
                return (decision.verdict, confirmation.divisor);
            }
        }
        (Verdict::Failed, 0.0)
    }

    #[test]
    fn what_is_not_doubtful_is_accepted_at_once() {
        for verdict in [Verdict::Stable, Verdict::Unstable] {
            let mut confirmation = Confirmation::NONE;
            assert_eq!(confirmation.accept(verdict.into(), false), Some(verdict.into()));
            assert_eq!(confirmation.divisor, 1.0);
        }
    }

    #[test]
    fn the_two_finest_simulations_have_to_agree() {
        use Verdict::{Stable, Unstable};
        assert_eq!(verdict_of([Stable, Unstable, Unstable]), (Unstable, 4.0));
        assert_eq!(verdict_of([Unstable, Stable, Stable]), (Stable, 4.0));
        assert_eq!(verdict_of([Stable, Stable, Unstable]), (Verdict::Undecided, 4.0));
        assert_eq!(verdict_of([Unstable, Unstable, Stable]), (Verdict::Undecided, 4.0));
    }

    #[test]
    fn a_sample_without_verdict_is_not_simulated_again() {
        for verdict in [Verdict::Undecided, Verdict::Failed] {
            assert_eq!(verdict_of([verdict; 3]), (verdict, 1.0));
        }
    }

    #[test]
    fn finer_steps_that_are_not_doubtful_decide_if_they_confirm_the_verdict() {
        for (second, divisor) in [(Verdict::Stable, 2.0), (Verdict::Unstable, 4.0)] {
            let mut confirmation = Confirmation::NONE;
            assert_eq!(confirmation.accept(Verdict::Stable.into(), true), None);
            let decision = confirmation.accept(second.into(), false);
            assert_eq!((decision.is_some(), confirmation.divisor), (divisor == 2.0, divisor));
        }
    }
}
