//! What is said of a measured friction curve: how often it falls and rises, what of it is not plausible, and where steady
//! sliding is unstable between the speeds of a grid.
//!
//! Stability is the sign of a slope, and the slope between noisy rows is that of the noise.

use stickslip_core::friction::measured_curve::{MeasuredCurve, Smoothing};
use stickslip_core::model::quantity::Quantity;
use stickslip_core::models::pad_on_disc::rigid_disc::stability::SpeedRange;
use stickslip_sampler::grid::Grid;
use stickslip_sampler::inputs::Marginal;
use stickslip_sampler::special_functions::normal;

use crate::job::random::RandomInputSet;
use crate::units::significant;

/// A curve that falls in more ranges of speed than this is taken for a noisy one.
const MOST_FALLS: usize = 2;

/// Highest speed of a curve that is plausible, m/s: that under the pads of a fast train.
const FASTEST: f64 = 60.0;

/// Largest share of curves without friction at some speed that is plausible.
const MOST_VANISHING: f64 = 0.01;

/// Most ranges of speed in a message.
const MOST_LISTED: usize = 8;

/// What to do about a noisy curve.
fn remedy(curve: &MeasuredCurve) -> &'static str {
    match curve.smoothing() {
        None => {
            "Smooth it, with smoothing = \"spline\" in [model.friction], or fit a friction law to the rows, as law = \"stribeck\""
        }
        Some(_) => {
            "It is smoothed already; give the mean of several tests at fewer speeds, or fit a friction law to the rows, as law = \"stribeck\""
        }
    }
}

/// How long a curve is, how far a smoothed one is from its rows, and how often it falls and rises.
pub fn described(curve: &MeasuredCurve) -> String {
    let (speeds, [falls, rises]) = (curve.speeds(), curve.falls_and_rises());
    let [first, last] = [0, speeds.len() - 1].map(|row| significant(speeds[row]));
    let smoothing = curve.smoothing().map_or(String::new(), |Smoothing { residual, parameters, .. }| {
        format!(
            ", smoothed by a spline with {parameters:.1} free parameters, from which they differ by {} (root mean square)",
            significant(*residual)
        )
    });
    format!(
        "{} rows from {first} to {last} m/s{smoothing}; from row to row it falls {} and rises {}",
        speeds.len(),
        times(falls),
        times(rises)
    )
}

fn times(count: usize) -> String {
    match count {
        0 => "never".to_owned(),
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        count => format!("{count} times"),
    }
}

/// Warnings about a curve of a job that slides at `fastest` at most, m/s.
pub fn doubts(curve: &MeasuredCurve, fastest: f64) -> Vec<String> {
    wrong_unit(curve, fastest).or_else(|| beyond(curve, fastest)).into_iter().chain(noise(curve)).collect()
}

/// A warning about curves of a job that are shifted so far down that they are at or below 0 at one of their rows.
pub fn vanishing(
    curve: &MeasuredCurve,
    quantities: &[Quantity],
    grid: &Grid,
    random: &RandomInputSet,
) -> Option<String> {
    let place = |path: &str| quantities.iter().position(|quantity| quantity.path == path);
    let (band, at_rest) = (place("friction.band")?, place("friction.static_coefficient")?);
    let ([shift, _], [at_rest, _]) = (grid.extremes_of(band), grid.extremes_of(at_rest));
    let rows = curve.speeds().iter().zip(curve.coefficients()).zip(curve.deviations()?);
    let limits = rows.filter(|(_, deviation)| **deviation > 0.0).map(|((&speed, coefficient), deviation)| {
        let scaled = coefficient * at_rest / curve.at_rest();
        (-scaled / deviation, speed)
    });
    let (limit, speed) = limits.reduce(|first, next| if next.0 > first.0 { next } else { first })?;
    let position = random.position(band).filter(|&position| random.marginals[position] == Marginal::Normal);
    let std = position.map_or(0.0, |i| random.relative_stds.iter().map(|stds| stds[i]).fold(0.0, f64::max));
    let share = if std > 0.0 {
        normal::upper_tail((shift - limit) / std)
    } else if shift <= limit {
        1.0
    } else {
        0.0
    };
    (share > MOST_VANISHING).then(|| {
        let (limit, speed, std) = (significant(limit), significant(speed), significant(std));
        let which = if share < 1.0 {
            format!("{:.1} % of the curves that friction.band draws with std = {std} are", 100.0 * share)
        } else {
            format!("the curve with friction.band = {} is", significant(shift))
        };
        format!(
            "{which} not plausible: with a friction.band of {limit} or less the friction coefficient is at or below 0 at {speed} m/s (usually in less than 1 %). A sample whose motion meets such a speed is outside the model, see criterion.outside_physics. Give friction.band closer to 0, with a smaller std, or check the column std of friction.table"
        )
    })
}

/// A warning about speeds at which nothing was measured.
fn beyond(curve: &MeasuredCurve, fastest: f64) -> Option<String> {
    let last = curve.speeds().last().copied().filter(|last| fastest > last * (1.0 + 1e-9))?;
    let unit = if fastest > FASTEST { "Are the speeds of the job in m/s? " } else { "" };
    let (last, fastest) = (significant(last), significant(fastest));
    Some(format!(
        "friction.table ends at {last} m/s, and the job slides at up to {fastest} m/s: beyond its last row friction counts as constant, which makes steady sliding stable there. {unit}Give rows up to that speed, or lower speeds"
    ))
}

/// A warning about speeds that are probably not in m/s.
fn wrong_unit(curve: &MeasuredCurve, fastest: f64) -> Option<String> {
    let speeds = curve.speeds();
    let last = speeds.last().copied().filter(|last| *last > FASTEST);
    let first = speeds.iter().copied().find(|speed| *speed > 0.0).filter(|first| *first > fastest);
    let (speed, why) = match (last, first) {
        (Some(last), _) => {
            (last, format!("it reaches {} m/s, and curves of brakes end at {FASTEST} m/s at most", significant(last)))
        }
        (None, Some(first)) => {
            let (first_row, fastest) = (significant(first), significant(fastest));
            let why = format!(
                "its first row above rest is at {first_row} m/s, and the job slides at {fastest} m/s at most, where nothing was measured"
            );
            (first, why)
        }
        (None, None) => return None,
    };
    // A row at less is one of metres: the first of a coarse curve.
    Some(if speed < 1.0 {
        format!("friction.table says nothing of the speeds of the job: {why}")
    } else {
        let (in_m_s, in_mm_s) = (significant(1e-3 * speed), significant(speed));
        format!("friction.table is not plausible: {why}; did you mean {in_m_s} m/s ({in_mm_s} mm/s)?")
    })
}

/// A warning about a curve that falls again and again.
fn noise(curve: &MeasuredCurve) -> Option<String> {
    let [falls, rises] = curve.falls_and_rises();
    (falls > MOST_FALLS).then(|| {
        format!(
            "friction.table falls {} and rises {} between its {} rows, which is probably noise (usually it falls at most twice). Stability is the sign of a slope, and slopes between such rows are those of the noise. {}",
            times(falls),
            times(rises),
            curve.speeds().len(),
            remedy(curve)
        )
    })
}

/// Where steady sliding is unstable on a measured curve, with the expected values of a cell of a job.
pub struct UnstableSpeeds {
    /// The axis of speeds and its unit.
    pub axis: &'static str,
    pub unit: &'static str,
    /// For which disc this holds, if there are several; empty, or with a space before it.
    pub on: &'static str,
    /// The cell.
    pub cell: u64,
    pub ranges: Vec<SpeedRange>,
}

impl UnstableSpeeds {
    /// What `check` says of a curve and of these speeds, in lines.
    pub fn remarks(&self, curve: &MeasuredCurve) -> String {
        let unstable = match self.ranges[..] {
            [] => "stable at every speed".to_owned(),
            ref ranges => format!("unstable at {} {} {}", self.axis, listed(ranges), self.unit),
        };
        format!(
            "# friction curve: {}\n# steady sliding{} with the other values of cell {}: {unstable}\n",
            described(curve),
            self.on,
            self.cell
        )
    }

    /// A warning about ranges that no value of the axis shows.
    pub fn doubt(&self, curve: &MeasuredCurve, values: &[f64]) -> Option<String> {
        let between = between(&self.ranges, values);
        let (what, them) = match between.len() {
            0 => return None,
            1 => ("a range of speed".to_owned(), "it"),
            count => (format!("{count} ranges of speed"), "them"),
        };
        Some(format!(
            "steady sliding{} is unstable in {what} between two values of axes.{axis}, so that no cell shows {them}: {} {} (with the other values of cell {}). The measured curve falls there between its rows. If that is no noise, give axes.{axis} values there. {}",
            self.on,
            listed(&between),
            self.unit,
            self.cell,
            remedy(curve),
            axis = self.axis
        ))
    }
}

/// The ranges that lie between two neighbouring values.
fn between(ranges: &[SpeedRange], values: &[f64]) -> Vec<SpeedRange> {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let is_between = |range: &SpeedRange| {
        let shows = |value: &f64| range.from < *value && *value < range.to;
        range.from >= least && range.to <= most && !values.iter().any(shows)
    };
    ranges.iter().copied().filter(is_between).collect()
}

/// The first ranges, in words.
fn listed(ranges: &[SpeedRange]) -> String {
    let shown = ranges.iter().take(MOST_LISTED);
    let shown: Vec<String> =
        shown.map(|range| format!("{} to {}", significant(range.from), significant(range.to))).collect();
    let more = match ranges.len() - shown.len() {
        0 => String::new(),
        more => format!(" and {more} more, up to {}", ranges.last().map_or(String::new(), |last| significant(last.to))),
    };
    shown.join(", ") + &more
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(speeds: &[f64], coefficients: &[f64]) -> MeasuredCurve {
        MeasuredCurve::new(speeds, coefficients, None).unwrap()
    }

    #[test]
    fn a_curve_is_noisy_if_it_falls_more_than_twice() {
        let speeds = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5];
        let wavy = curve(&speeds, &[0.5, 0.4, 0.41, 0.3, 0.31, 0.32]);
        assert_eq!(doubts(&wavy, 0.5), Vec::<String>::new());
        assert!(described(&wavy).ends_with("it falls twice and rises twice"), "{}", described(&wavy));
        let noisy = doubts(&curve(&speeds, &[0.5, 0.4, 0.41, 0.3, 0.31, 0.3]), 0.5);
        assert!(noisy.len() == 1 && noisy[0].contains("falls 3 times and rises twice between its 6 rows"), "{noisy:?}");
    }

    #[test]
    fn a_smoothed_curve_says_what_it_leaves_of_its_rows() {
        let speeds = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5];
        let rows = [0.45, 0.36, 0.34, 0.29, 0.30, 0.27];
        let said = described(&MeasuredCurve::smoothed(&speeds, &rows, None).unwrap());
        for text in ["from 0 to 2.500 m/s, smoothed", " 2.0 free parameters", " by 0.010", "falls once and rises never"]
        {
            assert!(said.contains(text), "{text:?} is not in: {said}");
        }
    }

    #[test]
    fn speeds_in_millimetres_are_recognised() {
        let far = doubts(&curve(&[0.0, 50.0, 950.0], &[0.5, 0.4, 0.3]), 2.0);
        assert!(far.len() == 1 && far[0].ends_with("did you mean 0.9500 m/s (950.0 mm/s)?"), "{far:?}");
        let coarse = doubts(&curve(&[0.0, 5.0, 50.0], &[0.5, 0.4, 0.3]), 2.0);
        assert!(coarse.len() == 1 && coarse[0].ends_with("did you mean 0.005000 m/s (5.000 mm/s)?"), "{coarse:?}");
        assert_eq!(doubts(&curve(&[0.0, 0.5, 50.0], &[0.5, 0.4, 0.3]), 2.0), Vec::<String>::new());
        let creep = doubts(&curve(&[0.0, 0.5, 50.0], &[0.5, 0.4, 0.3]), 0.3);
        assert!(creep.len() == 1 && creep[0].starts_with("friction.table says nothing of the speeds"), "{creep:?}");
    }

    #[test]
    fn speeds_beyond_the_rows_are_said_to_be_stable_by_assumption() {
        let table = curve(&[0.0, 0.5, 1.0], &[0.5, 0.4, 0.3]);
        assert_eq!(doubts(&table, 1.0), Vec::<String>::new());
        let fast = doubts(&table, 1.5);
        let said = "friction.table ends at 1.000 m/s, and the job slides at up to 1.500 m/s: beyond its last row friction counts as constant, which makes steady sliding stable there. Give rows";
        assert!(fast.len() == 1 && fast[0].starts_with(said), "{fast:?}");
        let millimetres = doubts(&table, 600.0);
        assert!(millimetres[0].contains("Are the speeds of the job in m/s?"), "{millimetres:?}");
    }

    #[test]
    fn ranges_that_a_value_lies_in_are_shown_by_it() {
        let range = |from: f64, to: f64| SpeedRange { from, to };
        let ranges = [range(0.0, 0.3), range(0.45, 0.5), range(0.58, 0.65), range(0.9, 1.1), range(1.3, 1.4)];
        let found = between(&ranges, &[0.2, 0.4, 0.6, 0.8, 1.0, 1.2]);
        assert_eq!(found, [range(0.45, 0.5)]);
        let speeds = UnstableSpeeds { axis: "belt_speed", unit: "m/s", on: "", cell: 4, ranges: ranges.to_vec() };
        let curve = curve(&[0.0, 1.0], &[0.5, 0.4]);
        let said = speeds.doubt(&curve, &[0.2, 0.4, 0.6, 0.8, 1.0, 1.2]).unwrap();
        assert!(said.contains("in a range of speed between two values of axes.belt_speed"), "{said}");
        assert!(said.contains("no cell shows it: 0.4500 to 0.5000 m/s (with the other values of cell 4)"), "{said}");
        assert_eq!(speeds.doubt(&curve, &[0.6]), None);
        assert!(between(&ranges, &[]).is_empty());
    }

    #[test]
    fn long_lists_of_ranges_are_cut() {
        let ranges: Vec<SpeedRange> =
            (0..10_u32).map(f64::from).map(|from| SpeedRange { from, to: from + 0.5 }).collect();
        let said = listed(&ranges);
        assert!(said.starts_with("0 to 0.5000, 1.000 to 1.500, "), "{said}");
        assert!(said.ends_with(" and 2 more, up to 9.500"), "{said}");
    }
}
