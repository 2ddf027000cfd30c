//! The result in a sentence or two: where the probability is surely small.

use stickslip_sampler::estimate::interval::Estimate;

use crate::job::Job;
use crate::picture::view::{GridView, ViewAxis, rounded};

/// Probabilities that the answer asks for.
const LIMITS: [f64; 3] = [0.01, 0.05, 0.5];

/// Where the probability is surely below the limits, by the upper ends of its intervals: in how many cells, and up to
/// which value of an axis in all cells. Without scatter, in how many cells steady sliding is kept.
pub fn answer(job: &Job, cells: &[Estimate]) -> String {
    let total = cells.len();
    if job.random.scatters_nothing() {
        let stable = cells.iter().filter(|cell| cell.probability == Some(0.0)).count();
        return format!("Nothing scatters; {stable} of {total} cells are stable.\n");
    }
    let high: Vec<f64> = cells.iter().map(|cell| cell.probability.map_or(f64::NAN, |_| cell.high)).collect();
    let counts = LIMITS.map(|limit| high.iter().filter(|high| **high < limit).count());
    let sure = format!("({})", job.sampling.method.upper_ends(&job.sampling));
    let [one, five, fifty] = counts;
    if total == 1 {
        let limit = LIMITS.into_iter().zip(counts).find(|(_, count)| *count == 1);
        let below = |(limit, _): (f64, usize)| format!("P is below {} {sure}.\n", percent(limit));
        return limit.map_or_else(|| format!("P is not surely below {}.\n", percent(LIMITS[2])), below);
    }
    let mut text =
        format!("P is below 1 % in {one} of {total} cells, below 5 % in {five}, below 50 % in {fifty} {sure}.\n");
    let view = GridView::new(job);
    let long = [view.vertical(), view.horizontal()].into_iter().flatten();
    if let Some((axis, ends)) =
        long.map(|axis| (axis, ends(axis, &high))).find(|(_, ends)| ends.iter().any(Option::is_some))
    {
        // What is below a limit everywhere is below the larger ones too.
        let needed = 1 + ends.iter().position(|end| *end == Some(End::Everywhere)).unwrap_or(ends.len() - 1);
        let parts: Vec<String> = LIMITS
            .into_iter()
            .zip(ends)
            .take(needed)
            .filter_map(|(limit, end)| end.map(|end| format!("P < {} {}", percent(limit), end.text(axis))))
            .collect();
        text += &format!("{}, whatever the other axes.\n", parts.join(", "));
    }
    text
}

/// The part of an axis, from one of its ends, in all cells of which the probability is small.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    Everywhere,
    UpTo(f64),
    From(f64),
}

impl End {
    fn text(self, axis: &ViewAxis) -> String {
        let number = |value: f64| format!("{} {}", rounded(value), axis.unit()).trim_end().to_owned();
        match self {
            Self::Everywhere => format!("for every {}", axis.key()),
            Self::UpTo(value) => format!("for {} up to {}", axis.key(), number(value)),
            Self::From(value) => format!("for {} from {}", axis.key(), number(value)),
        }
    }
}

/// For each limit the longest part of the axis, from either end, in all cells of which the probability is below it.
fn ends(axis: &ViewAxis, high: &[f64]) -> [Option<End>; LIMITS.len()] {
    let mut worst = vec![f64::NEG_INFINITY; axis.values.len()];
    for (cell, high) in high.iter().enumerate() {
        let worst = &mut worst[axis.position(cell as u64)];
        // No number is worse than any.
        *worst = if high.is_nan() { f64::INFINITY } else { worst.max(*high) };
    }
    // A list of values need not rise.
    let mut rising: Vec<(f64, f64)> = axis.values.iter().copied().zip(worst).collect();
    rising.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    LIMITS.map(|limit| {
        let is_small = |(_, worst): &&(f64, f64)| *worst < limit;
        let (first, last) =
            (rising.iter().take_while(is_small).count(), rising.iter().rev().take_while(is_small).count());
        let length = rising.len();
        if first == length {
            Some(End::Everywhere)
        } else if first == 0 && last == 0 {
            None
        } else if first >= last {
            Some(End::UpTo(rising[first - 1].0))
        } else {
            Some(End::From(rising[length - last].0))
        }
    })
}

fn percent(limit: f64) -> String {
    format!("{} %", rounded(100.0 * limit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::JobSource;

    fn job(axes: &str) -> Job {
        let text = format!(
            "name = \"answer\"\n[axes]\n{axes}\n[random]\ninputs = [\"preload\"]\nrelative_std = 0.2\n[criterion]\nkind = \"eigenvalue\"\n[sampling]\nsamples = 10\nseed = 1\n"
        );
        JobSource { path: "job.toml".into(), text }.job().unwrap()
    }

    fn cells(high: &[f64]) -> Vec<Estimate> {
        let estimate =
            |high: &f64| Estimate { probability: (!high.is_nan()).then_some(0.5 * high), low: 0.0, high: *high };
        high.iter().map(estimate).collect()
    }

    #[test]
    fn the_answer_says_up_to_where_the_probability_is_small() {
        let job = job("rotating_speed = 15.0\npreload = [0.1, 0.2, 0.3, 0.4]\nstatic_friction = [0.3, 0.4, 0.5]");
        let high = [0.0, 0.001, 0.004, 0.001, 0.02, 0.03, 0.1, 0.2, 0.49, 0.3, 0.6, 0.9];
        assert_eq!(
            answer(&job, &cells(&high)),
            "P is below 1 % in 4 of 12 cells, below 5 % in 6, below 50 % in 10 (upper ends of the 95 % intervals).\n\
             P < 1 % for preload up to 0.1, P < 5 % for preload up to 0.2, P < 50 % for preload up to 0.3, whatever the other axes.\n"
        );
        assert!(!answer(&job, &cells(&[0.9; 12])).contains("whatever"));
        assert!(answer(&job, &cells(&[0.001; 12])).contains("\nP < 1 % for every preload, whatever the other axes.\n"));
        assert!(!answer(&job, &cells(&[f64::NAN; 12])).contains("whatever"), "what is not known is not small");
    }

    #[test]
    fn the_probability_may_be_small_from_a_value_on() {
        let job = job("rotating_speed = [10.0, 20.0, 30.0]\npreload = 0.1\nstatic_friction = 0.4");
        assert!(answer(&job, &cells(&[0.9, 0.03, 0.002])).contains(
            "P < 1 % for rotating speed from 30 rad/s, P < 5 % for rotating speed from 20 rad/s, P < 50 % for rotating speed from 20 rad/s, whatever the other axes."
        ));
    }

    #[test]
    fn values_of_an_axis_need_not_rise() {
        let job = job("rotating_speed = [30.0, 10.0, 20.0]\npreload = 0.1\nstatic_friction = 0.4");
        let text = answer(&job, &cells(&[0.002, 0.9, 0.03]));
        assert!(
            text.contains("P < 1 % for rotating speed from 30 rad/s, P < 5 % for rotating speed from 20 rad/s"),
            "{text}"
        );
    }

    #[test]
    fn a_single_cell_has_its_own_sentence() {
        let job = job("rotating_speed = 15.0\npreload = 0.1\nstatic_friction = 0.4");
        assert_eq!(answer(&job, &cells(&[0.04])), "P is below 5 % (upper ends of the 95 % intervals).\n");
        assert_eq!(answer(&job, &cells(&[0.7])), "P is not surely below 50 %.\n");
    }
}
