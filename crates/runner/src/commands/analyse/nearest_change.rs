//! Where the verdict changes next to a value.

use std::fmt;

use serde_json::{Value, json};
use stickslip_core::model::critical_values::UnstableValues;

use crate::picture::view::rounded;

/// The largest distance of two values between which the verdict changes, in parts of their sizes, that are told as one.
const LOCATED: f64 = 1e-6;

/// The nearest place on one side at which a verdict changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Nearest {
    /// It changes nowhere.
    Nowhere,
    /// Here.
    At(f64),
    /// Nothing is known between these two.
    Between([f64; 2]),
}

impl Nearest {
    /// Below and above a value, from the unstable values within some ends.
    pub fn on_both_sides(unstable: &UnstableValues, value: f64, within: [f64; 2]) -> [Self; 2] {
        // Where stable ends, or what is not known begins, and where unstable begins, and the other way round.
        let mut changes: Vec<Self> = Vec::new();
        for [low, high] in &unstable.possibly {
            let surely = unstable.surely.iter().filter(|[start, end]| low <= start && end <= high);
            let mut from = *low;
            for [start, end] in surely {
                changes.push(Self::between([from, *start]));
                from = *end;
            }
            changes.push(Self::between([from, *high]));
        }
        changes.retain(|change| !matches!(change, Self::At(at) if *at <= within[0] || within[1] <= *at));
        let is_below = |change: &&Self| match change {
            Self::Nowhere => false,
            Self::At(at) => *at <= value,
            Self::Between([from, _]) => *from < value,
        };
        let is_above = |change: &&Self| match change {
            Self::Nowhere => false,
            Self::At(at) => *at > value,
            Self::Between([_, to]) => *to > value,
        };
        [changes.iter().rfind(is_below), changes.iter().find(is_above)]
            .map(|found| found.copied().unwrap_or(Self::Nowhere))
    }

    fn between([from, to]: [f64; 2]) -> Self {
        let is_located = to - from <= LOCATED * from.abs().max(to.abs());
        if is_located { Self::At(0.5 * (from + to)) } else { Self::Between([from, to]) }
    }

    /// A number, two, or null.
    pub fn json(self) -> Value {
        match self {
            Self::Nowhere => Value::Null,
            Self::At(at) => json!(at),
            Self::Between(ends) => json!(ends),
        }
    }
}

impl fmt::Display for Nearest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nowhere => f.write_str("none"),
            Self::At(at) => f.write_str(&rounded(*at)),
            Self::Between([from, to]) => write!(f, "not known from {} to {}", rounded(*from), rounded(*to)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_change_is_told_only_where_nothing_before_it_is_unknown() {
        let of = |surely: &[[f64; 2]], possibly: &[[f64; 2]], value: f64| {
            let unstable = UnstableValues { surely: surely.to_vec(), possibly: possibly.to_vec() };
            Nearest::on_both_sides(&unstable, value, [0.0, 10.0])
        };
        use Nearest::{At, Between, Nowhere};
        assert_eq!(of(&[], &[], 1.0), [Nowhere, Nowhere]);
        assert_eq!(of(&[[0.0, 10.0]], &[[0.0, 10.0]], 1.0), [Nowhere, Nowhere]);
        assert_eq!(of(&[[2.0, 3.0]], &[[2.0, 3.0]], 2.5), [At(2.0), At(3.0)]);
        assert_eq!(of(&[[2.0, 3.0], [4.0, 10.0]], &[[2.0, 3.0], [4.0, 10.0]], 1.0), [Nowhere, At(2.0)]);
        let hole = of(&[[2.0, 3.0]], &[[2.0, 3.5]], 1.0);
        assert_eq!(hole, [Nowhere, At(2.0)]);
        assert_eq!(of(&[[2.0, 3.0]], &[[2.0, 3.5]], 2.5), [At(2.0), Between([3.0, 3.5])]);
        assert_eq!(of(&[[2.0, 3.0]], &[[1.2, 3.0]], 1.0), [Nowhere, Between([1.2, 2.0])]);
        assert_eq!(of(&[], &[[4.0, 6.0]], 5.0), [Between([4.0, 6.0]); 2]);
        assert_eq!(of(&[[2.0, 3.0]], &[[2.0 - 1e-9, 3.0 + 1e-9]], 2.5), [At(2.0 - 5e-10), At(3.0 + 5e-10)]);
    }
}
