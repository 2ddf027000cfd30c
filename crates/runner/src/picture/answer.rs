//! The result in a sentence or two: from where to where the probability goes, and where it is surely small.

use std::collections::BTreeMap;

use stickslip_sampler::estimate::interval::Estimate;

use crate::job::Job;
use crate::output::counted;
use crate::picture::asked_cell::KnownCell;
use crate::picture::title::capitalised;
use crate::picture::view::{GridView, ViewAxis, probability, rounded};

/// Probabilities that the answer asks for.
const LIMITS: [f64; 3] = [0.01, 0.05, 0.5];

/// What holds in the cell that is asked about, if one is, and in all cells, if there are several: a sentence a line.
pub fn answer(job: &Job, cells: &[Estimate], asked: Option<&KnownCell>) -> String {
    let asked = asked.zip(job.asked_cell()).map(|(known, cell)| known.sentences(job, cell));
    let mut text: String = asked.into_iter().flatten().map(|sentence| sentence + "\n").collect();
    if cells.len() > 1 {
        text += &of_all(job, cells);
    }
    text
}

/// Up to which value of an axis the probability is surely below the target of the job, by the upper ends of its intervals.
/// Without a target, the range of the probability and the same for the limits. Without scatter, in how many cells steady
/// sliding is kept.
fn of_all(job: &Job, cells: &[Estimate]) -> String {
    let total = cells.len();
    if job.random.scatters_nothing() {
        let stable = cells.iter().filter(|cell| cell.probability == Some(0.0)).count();
        return format!("Nothing scatters; {stable} of {total} cells are stable.\n");
    }
    let high: Vec<f64> = cells.iter().map(|cell| cell.probability.map_or(f64::NAN, |_| cell.high)).collect();
    let view = GridView::new(job);
    if let Some(target) = job.target {
        return of_target(job, &view, &high, target);
    }
    let mut text = range(cells);
    let long = [view.vertical(), view.horizontal()].into_iter().flatten();
    let of_limits = |axis: &ViewAxis| LIMITS.map(|limit| (limit, part(axis, (0..).zip(high.iter().copied()), limit)));
    let is_found = |(_, parts): &(_, [(f64, Part); 3])| parts.iter().any(|(_, part)| part.is_from_an_end());
    if let Some((axis, parts)) = long.map(|axis| (axis, of_limits(axis))).find(is_found) {
        // What is below a limit everywhere is below the larger ones too.
        let needed = 1 + parts.iter().position(|(_, part)| *part == Part::Everywhere).unwrap_or(parts.len() - 1);
        let found = parts.into_iter().take(needed).filter(|(_, part)| part.is_from_an_end());
        let said: Vec<String> = found.map(|(limit, part)| part.text(axis, &below(limit), None)).collect();
        let sure = job.sampling.method.upper_ends(&job.sampling);
        text += &format!("{}{} ({sure}).\n", said.join(", "), whatever(others(&view, axis).as_deref()));
    }
    text
}

/// The smallest and the largest probability.
fn range(cells: &[Estimate]) -> String {
    const NAME: &str = "P, the probability of instability";
    let known = || cells.iter().filter_map(|cell| cell.probability);
    let (Some(least), Some(largest)) = (known().reduce(f64::min), known().reduce(f64::max)) else {
        return format!("{NAME}, is not known of any cell.\n");
    };
    let [least, largest] = [least, largest].map(probability);
    let range = if least == largest { least } else { format!("{least} to {largest}") };
    format!("{NAME}: {range} in {}.\n", counted(known().count() as u128, "cell", "cells"))
}

/// The axes of several values beside one: "rotating speed and static friction".
fn others(view: &GridView, axis: &ViewAxis) -> Option<String> {
    let others: Vec<&str> = view.others(axis).map(ViewAxis::key).collect();
    match others.split_last()? {
        (last, []) => Some((*last).to_owned()),
        (last, first) => Some(format!("{} and {last}", first.join(", "))),
    }
}

/// That what is said of an axis holds for all values of the others.
fn whatever(others: Option<&str>) -> String {
    others.map_or(String::new(), |others| format!(", whatever the {others}"))
}

/// The part of an axis in all cells of which the probability is small.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    Everywhere,
    UpTo(f64),
    From(f64),
    /// Some values, but neither the first nor the last.
    Inside,
    Nowhere,
}

impl Part {
    fn is_from_an_end(self) -> bool {
        matches!(self, Self::Everywhere | Self::UpTo(_) | Self::From(_))
    }

    /// The words for it, where `below` says that the probability is small; the names of other axes are given where nothing
    /// else says that it is for all of their values.
    fn text(self, axis: &ViewAxis, below: &str, others: Option<&str>) -> String {
        let number = |value: f64| format!("{} {}", rounded(value), axis.unit()).trim_end().to_owned();
        let key = axis.key();
        let part = match self {
            Self::Everywhere => format!("for every {key}"),
            Self::UpTo(value) => format!("for {key} up to {}", number(value)),
            Self::From(value) => format!("for {key} from {}", number(value)),
            Self::Inside => format!("for some {key} only, neither the first nor the last"),
            Self::Nowhere => {
                let all = others.map_or(String::new(), |others| format!(" for every {others}"));
                return format!("no {key} has {below}{all}");
            }
        };
        format!("{below} {part}{}", whatever(others))
    }
}

fn below(limit: f64) -> String {
    format!("P < {} %", rounded(100.0 * limit))
}

/// Most slices, or combinations of the other axes, that get a line each.
const MOST_LINES: usize = 12;

/// Up to which value of the axis that runs upwards, or of the only one, the probability is surely below a target: for all
/// cells, and for each slice, or where there is one, each value to the right. What is said holds at the values that were computed.
fn of_target(job: &Job, view: &GridView, high: &[f64], target: f64) -> String {
    let below = below(target);
    let sure = job.sampling.method.upper_ends(&job.sampling);
    let Some(axis) = view.vertical().or(view.horizontal()) else { return String::new() };
    let all = part(axis, (0..).zip(high.iter().copied()), target);
    let others = others(view, axis);
    let is_sliced = view.slices() > 1;
    let mut groups: BTreeMap<u64, Vec<(u64, f64)>> = BTreeMap::new();
    for (cell, high) in (0..).zip(high) {
        let group = if is_sliced { view.slice_of(cell).first } else { cell - axis.offset(cell) };
        groups.entry(group).or_default().push((cell, *high));
    }
    let mut text = format!(
        "Target: {below}, with P the probability of instability. {} ({sure}; at the values that were computed, not between them).\n",
        capitalised(&all.text(axis, &below, others.as_deref()))
    );
    if (2..=MOST_LINES).contains(&groups.len()) {
        // In a slice a value of the axis stands for all values of the axis to the right.
        let right = view.horizontal().filter(|_| is_sliced && view.vertical().is_some()).map(ViewAxis::key);
        let lines = groups.iter().map(|(first, cells)| {
            let part = part(axis, cells.iter().copied(), target);
            let right = right.filter(|_| part == Part::Nowhere);
            let place = if is_sliced { view.slice_of(*first).place(job) } else { view.others_of(job, *first, axis) };
            format!("At {place}: {}.\n", part.text(axis, &below, right))
        });
        text.extend(lines);
    } else if groups.len() > MOST_LINES {
        let is_found = |cells: &&Vec<(u64, f64)>| part(axis, cells.iter().copied(), target).is_from_an_end();
        let found = groups.values().filter(is_found).count();
        text += &format!(
            "Of {} {}, {found} have {below} from an end of the {} on; `stickslip limit` finds where each ends.\n",
            groups.len(),
            if is_sliced { "slices" } else { "combinations of the other axes" },
            axis.key()
        );
    }
    text
}

/// The longest part of the axis, from either end, in all of some cells of which the probability is below a limit.
fn part(axis: &ViewAxis, cells: impl Iterator<Item = (u64, f64)>, limit: f64) -> Part {
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
        Part::Everywhere
    } else if first == 0 && last == 0 {
        if rising.iter().any(|value| is_small(&value)) { Part::Inside } else { Part::Nowhere }
    } else if first >= last {
        Part::UpTo(rising[first - 1].0)
    } else {
        Part::From(rising[length - last].0)
    }
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
            answer(&job, &cells(&high), None),
            "P, the probability of instability: 0.0000 to 0.4500 in 12 cells.\n\
             P < 1 % for preload up to 0.1, P < 5 % for preload up to 0.2, P < 50 % for preload up to 0.3, whatever the static friction (upper ends of the 95 % intervals).\n"
        );
        assert!(!answer(&job, &cells(&[0.9; 12]), None).contains("whatever"));
        assert_eq!(
            answer(&job, &cells(&[0.004; 12]), None),
            "P, the probability of instability: 0.0020 in 12 cells.\n\
             P < 1 % for every preload, whatever the static friction (upper ends of the 95 % intervals).\n"
        );
        assert_eq!(
            answer(&job, &cells(&[f64::NAN; 12]), None),
            "P, the probability of instability, is not known of any cell.\n",
            "what is not known is not small"
        );
    }

    #[test]
    fn the_target_is_answered_first() {
        let of = |axes: &str, high: &[f64]| {
            let job = Job { target: Some(0.05), ..job(axes) };
            answer(&job, &cells(high), None)
        };
        let axes = "rotating_speed = 15.0\npreload = [0.1, 0.2, 0.3]\nstatic_friction = 0.4";
        assert_eq!(
            of(axes, &[0.01, 0.03, 0.06]),
            "Target: P < 5 %, with P the probability of instability. P < 5 % for preload up to 0.2 (upper ends of the 95 % intervals; at the values that were computed, not between them).\n"
        );
        let inside = of(axes, &[0.06, 0.03, f64::NAN]);
        assert!(inside.contains(". P < 5 % for some preload only, neither the first nor the last ("), "{inside}");
        assert!(of(axes, &[0.06, 0.07, f64::NAN]).contains(". No preload has P < 5 % ("));
        let two = "rotating_speed = [10.0, 15.0]\npreload = [0.1, 0.2, 0.3]\nstatic_friction = 0.4";
        let text = of(two, &[0.01, 0.06, 0.04, 0.01, 0.03, 0.04]);
        assert!(text.contains("P < 5 % for rotating speed from 15 rad/s, whatever the preload ("), "{text}");
        assert!(text.contains("\nAt preload = 0.1: P < 5 % for every rotating speed.\n"), "{text}");
        let text = of(two, &[0.01, 0.06, 0.04, 0.06, 0.03, 0.07]);
        assert!(text.contains(". No rotating speed has P < 5 % for every preload ("), "{text}");
        let three = "rotating_speed = [10.0, 15.0]\npreload = [0.1, 0.2]\nstatic_friction = [0.3, 0.4]";
        let text = of(three, &[0.01; 8]);
        assert!(
            text.contains("P < 5 % for every preload, whatever the rotating speed and static friction ("),
            "{text}"
        );
    }

    #[test]
    fn the_probability_may_be_small_from_a_value_on() {
        let job = job("rotating_speed = [10.0, 20.0, 30.0]\npreload = 0.1\nstatic_friction = 0.4");
        assert!(answer(&job, &cells(&[0.9, 0.03, 0.002]), None).contains(
            "P < 1 % for rotating speed from 30 rad/s, P < 5 % for rotating speed from 20 rad/s, P < 50 % for rotating speed from 20 rad/s (upper ends of the 95 % intervals).\n"
        ));
    }

    #[test]
    fn values_of_an_axis_need_not_rise() {
        let job = job("rotating_speed = [30.0, 10.0, 20.0]\npreload = 0.1\nstatic_friction = 0.4");
        let text = answer(&job, &cells(&[0.002, 0.9, 0.03]), None);
        assert!(
            text.contains("P < 1 % for rotating speed from 30 rad/s, P < 5 % for rotating speed from 20 rad/s"),
            "{text}"
        );
    }

    #[test]
    fn the_cell_that_is_asked_about_comes_first_and_a_single_one_alone() {
        let known = KnownCell {
            estimate: cells(&[0.04])[0],
            samples: 10,
            unstable: 1,
            without_verdict: 0,
            outside: 0,
            plain: None,
            unaudited: None,
            distrust: 0,
        };
        let single = job("rotating_speed = 15.0\npreload = 0.1\nstatic_friction = 0.4");
        let own = "P, the probability of instability, is 0.0200 (95 % interval: 0.0000 to 0.0400).\n\
                   It rests on 10 samples, 1 of them unstable (method = \"monte-carlo\").\n";
        assert_eq!(answer(&single, &cells(&[0.04]), Some(&known)), format!("At 15 rad/s: {own}"));
        let several = job("rotating_speed = 15.0\npreload = [0.1, 0.2]\nstatic_friction = 0.4");
        let all = answer(&several, &cells(&[0.04, 0.2]), None);
        assert!(all.starts_with("P, the probability of instability: 0.0200 to 0.1000 in 2 cells.\n"), "{all}");
        let asked = Job { operating_point: Some(0), ..several };
        assert_eq!(
            answer(&asked, &cells(&[0.04, 0.2]), Some(&known)),
            format!("At 15 rad/s, preload = 0.1: {own}{all}")
        );
    }
}
