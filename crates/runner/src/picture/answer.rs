//! The result in a sentence or two: where the probability is surely small.

use std::collections::BTreeMap;

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
    // A target explains P already.
    let name = if job.target.is_none() { "; P is the probability of instability" } else { "" };
    let sure = format!("({}{name})", job.sampling.method.upper_ends(&job.sampling));
    let [one, five, fifty] = counts;
    let view = GridView::new(job);
    let first = job.target.map_or_else(String::new, |target| of_target(job, &view, &high, target));
    if total == 1 && job.target.is_some() {
        return first;
    }
    if total == 1 {
        let limit = LIMITS.into_iter().zip(counts).find(|(_, count)| *count == 1);
        let below = |(limit, _): (f64, usize)| format!("P is below {} {sure}.\n", percent(limit));
        return limit.map_or_else(
            || format!("The probability of instability P is not surely below {}.\n", percent(LIMITS[2])),
            below,
        );
    }
    let mut text = format!(
        "{first}P is below 1 % in {one} of {total} cells, below 5 % in {five}, below 50 % in {fifty} {sure}.\n"
    );
    let long = [view.vertical(), view.horizontal()].into_iter().flatten();
    if let Some((axis, ends)) =
        long.map(|axis| (axis, ends(axis, &high, &LIMITS))).find(|(_, ends)| ends.iter().any(Option::is_some))
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

/// Most slices, or combinations of the other axes, that get a line each.
const MOST_LINES: usize = 12;

/// Up to which value of the axis that runs upwards, or of the only one, the probability is surely below a target: for all
/// cells, and for each slice, or where there is one, each value to the right. What is said holds at the values that were computed.
fn of_target(job: &Job, view: &GridView, high: &[f64], target: f64) -> String {
    let below = format!("P < {}", percent(target));
    let sure = job.sampling.method.upper_ends(&job.sampling);
    let Some(axis) = view.vertical().or(view.horizontal()) else {
        let is_met = high.first().is_some_and(|high| *high < target);
        let found = if is_met { "is" } else { "is not surely" };
        return format!("Probability of instability P {found} below {} ({sure}).\n", percent(target));
    };
    let said = |end: Option<End>| end.map_or(format!("for no {}", axis.key()), |end| end.text(axis));
    let [all] = ends(axis, high, &[target])[..] else { return String::new() };
    let is_sliced = view.slices() > 1;
    let mut groups: BTreeMap<u64, Vec<(u64, f64)>> = BTreeMap::new();
    for (cell, high) in (0..).zip(high) {
        let group = if is_sliced { view.slice_of(cell).first } else { cell - axis.offset(cell) };
        groups.entry(group).or_default().push((cell, *high));
    }
    let several = if groups.len() > 1 { ", whatever the other axes" } else { "" };
    let mut text = format!(
        "Target: {below}, with P the probability of instability. {below} {}{several} ({sure}; at the values that were computed, not between them).\n",
        said(all)
    );
    if (2..=MOST_LINES).contains(&groups.len()) {
        let lines = groups.iter().map(|(first, cells)| {
            let place = if is_sliced { view.slice_of(*first).place(job) } else { view.others_of(job, *first, axis) };
            format!("At {place}: {below} {}.\n", said(end(axis, cells.iter().copied(), target)))
        });
        text.extend(lines);
    } else if groups.len() > MOST_LINES {
        let found = groups.values().filter(|cells| end(axis, cells.iter().copied(), target).is_some()).count();
        text += &format!(
            "Of {} {}, {found} have {below} from an end of the {} on; `stickslip limit` finds where each ends.\n",
            groups.len(),
            if is_sliced { "slices" } else { "combinations of the other axes" },
            axis.key()
        );
    }
    text
}

/// For each limit the longest part of the axis, from either end, in all cells of which the probability is below it.
fn ends(axis: &ViewAxis, high: &[f64], limits: &[f64]) -> Vec<Option<End>> {
    limits.iter().map(|&limit| end(axis, (0..).zip(high.iter().copied()), limit)).collect()
}

/// The longest part of the axis, from either end, in all of some cells of which the probability is below a limit.
fn end(axis: &ViewAxis, cells: impl Iterator<Item = (u64, f64)>, limit: f64) -> Option<End> {
    let mut worst = vec![f64::NEG_INFINITY; axis.values.len()];
    for (cell, high) in cells {
        let worst = &mut worst[axis.position(cell)];
        // No number is worse than any.
        *worst = if high.is_nan() { f64::INFINITY } else { worst.max(high) };
    }
    // A list of values need not rise.
    let mut rising: Vec<(f64, f64)> = axis.values.iter().copied().zip(worst).collect();
    rising.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let is_small = |(_, worst): &&(f64, f64)| *worst < limit;
    let first = rising.iter().take_while(is_small).count();
    let last = rising.iter().rev().take_while(is_small).count();
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
            "P is below 1 % in 4 of 12 cells, below 5 % in 6, below 50 % in 10 (upper ends of the 95 % intervals; P is the probability of instability).\n\
             P < 1 % for preload up to 0.1, P < 5 % for preload up to 0.2, P < 50 % for preload up to 0.3, whatever the other axes.\n"
        );
        assert!(!answer(&job, &cells(&[0.9; 12])).contains("whatever"));
        assert!(answer(&job, &cells(&[0.001; 12])).contains("\nP < 1 % for every preload, whatever the other axes.\n"));
        assert!(!answer(&job, &cells(&[f64::NAN; 12])).contains("whatever"), "what is not known is not small");
    }

    #[test]
    fn the_target_is_answered_first() {
        let of = |axes: &str, high: &[f64]| {
            let job = Job { target: Some(0.05), ..job(axes) };
            let text = answer(&job, &cells(high));
            text.split_once("P is below 1 %").map_or(text.clone(), |(first, _)| first.to_owned())
        };
        let axes = "rotating_speed = 15.0\npreload = [0.1, 0.2, 0.3]\nstatic_friction = 0.4";
        assert_eq!(
            of(axes, &[0.01, 0.03, 0.06]),
            "Target: P < 5 %, with P the probability of instability. P < 5 % for preload up to 0.2 (upper ends of the 95 % intervals; at the values that were computed, not between them).\n"
        );
        assert!(of(axes, &[0.06, 0.03, f64::NAN]).contains("P < 5 % for no preload ("));
        let two = "rotating_speed = [10.0, 15.0]\npreload = [0.1, 0.2, 0.3]\nstatic_friction = 0.4";
        let text = of(two, &[0.01, 0.06, 0.04, 0.01, 0.03, 0.04]);
        assert!(text.contains("P < 5 % for rotating speed from 15 rad/s, whatever the other axes ("), "{text}");
        assert!(text.contains("\nAt preload = 0.1: P < 5 % for every rotating speed.\n"), "{text}");
        let single = "rotating_speed = 15.0\npreload = 0.1\nstatic_friction = 0.4";
        assert!(of(single, &[0.04]).starts_with("Probability of instability P is below 5 % (upper"));
        assert!(of(single, &[0.06]).starts_with("Probability of instability P is not surely below 5 % (upper"));
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
        assert_eq!(
            answer(&job, &cells(&[0.04])),
            "P is below 5 % (upper ends of the 95 % intervals; P is the probability of instability).\n"
        );
        assert_eq!(answer(&job, &cells(&[0.7])), "The probability of instability P is not surely below 50 %.\n");
    }
}
