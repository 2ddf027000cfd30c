//! Units as lines of pieces: lists of numbers.
//!
//! Part, first sample, number of samples; stable, unstable, undecided and failed ones; the sum and the bins of the first
//! result that is recorded, each bin with its count; further sums; the sum and the bins of every further result up to the
//! last of which there are values.

use std::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeSeq;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::estimate::distribution::Distribution;

use crate::evaluate::unit::{FinishedUnit, Recorded};

/// Largest count in a piece, and largest number of a part or sample. Jobs have at most a tenth of that many samples in a
/// cell, and sums of such counts fit 64 bits.
const MOST_COUNTED: u64 = 1 << 53;

/// Bins of a distribution, each with its count.
type Bins = Vec<(u32, u64)>;

impl Serialize for FinishedUnit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let VerdictCounts { stable, unstable, undecided, failed } = self.counts;
        let [first, further @ ..] = &self.recorded;
        let bins = |values: &Distribution| values.bins().collect::<Bins>();
        let used = further.iter().rposition(|values| values.count() > 0).map_or(0, |last| last + 1);
        let mut list = serializer.serialize_seq(None)?;
        list.serialize_element(&self.part)?;
        list.serialize_element(&self.samples.start)?;
        list.serialize_element(&self.len())?;
        list.serialize_element(&[stable, unstable, undecided, failed])?;
        list.serialize_element(&first.sum())?;
        list.serialize_element(&bins(first))?;
        list.serialize_element(&self.sums)?;
        for values in &further[..used] {
            list.serialize_element(&values.sum())?;
            list.serialize_element(&bins(values))?;
        }
        list.end()
    }
}

impl<'de> Deserialize<'de> for FinishedUnit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Line)
    }
}

/// Reads a unit from a list.
struct Line;

impl<'de> Visitor<'de> for Line {
    type Value = FinishedUnit;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("the numbers of a unit")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<FinishedUnit, A::Error> {
        let [part, start, len] = [counted(&mut list)?, counted(&mut list)?, counted(&mut list)?];
        let [stable, unstable, undecided, failed] = next::<[u64; 4], A>(&mut list)?;
        for count in [stable, unstable, undecided, failed] {
            check(count)?;
        }
        let mut recorded = Recorded::default();
        let [first, further @ ..] = &mut recorded;
        *first = distribution(next(&mut list)?, next(&mut list)?)?;
        let sums = next(&mut list)?;
        for values in further {
            let Some(sum) = list.next_element()? else { break };
            *values = distribution(sum, next(&mut list)?)?;
        }
        let counts = VerdictCounts { stable, unstable, undecided, failed };
        Ok(FinishedUnit { part, samples: start..start + len, counts, recorded, sums })
    }
}

/// The next value of a list.
fn next<'de, T: Deserialize<'de>, A: SeqAccess<'de>>(list: &mut A) -> Result<T, A::Error> {
    list.next_element()?.ok_or_else(|| A::Error::custom("a number is missing"))
}

/// The next count of a list.
fn counted<'de, A: SeqAccess<'de>>(list: &mut A) -> Result<u64, A::Error> {
    check(next(list)?)
}

fn check<E: Error>(count: u64) -> Result<u64, E> {
    if count > MOST_COUNTED { Err(E::custom(format!("a count is above {MOST_COUNTED}"))) } else { Ok(count) }
}

/// A distribution from what is stored of it.
fn distribution<E: Error>(sum: i128, bins: Bins) -> Result<Distribution, E> {
    for &(bin, count) in &bins {
        check(count)?;
        if !Distribution::is_bin(bin) {
            return Err(E::custom("a bin of recorded values is out of range"));
        }
    }
    Ok(Distribution::from_parts(sum, bins))
}
