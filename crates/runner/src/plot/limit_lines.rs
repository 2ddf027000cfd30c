//! Lines of the limits of a run over the two axes that are shown.

use crate::picture::view::{GridView, Slice, rounded};
use crate::plot::levels::label;
use crate::tables::limits::{FinishedLimit, FinishedLimits};

/// The limits at a target that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitLine {
    /// The probability that is passed on it.
    pub target: f64,
    /// Whether the probability rises there, as the axis of the limits grows.
    rises: bool,
    /// Values on the axis to the right and on the axis upwards.
    pub points: Vec<[f64; 2]>,
}

/// The lines in a slice; none if the limits do not lie along one of the axes that are shown.
///
/// A line goes from limit to limit along the other axis as long as the probability passes the target there in the same
/// sense: one that ends leaves a gap.
pub fn lines(limits: &FinishedLimits, view: &GridView, slice: &Slice<'_>) -> Vec<LimitLine> {
    let (Some(vertical), Some(horizontal)) = (view.vertical(), view.horizontal()) else { return Vec::new() };
    let is_upwards = vertical.name_in_job == limits.of;
    if !is_upwards && horizontal.name_in_job != limits.of {
        return Vec::new();
    }
    let other = if is_upwards { horizontal } else { vertical };
    let mut found = Vec::new();
    for target in targets(limits) {
        let mut open: Vec<LimitLine> = Vec::new();
        for (position, &at) in other.values.iter().enumerate() {
            let cell = if is_upwards { slice.cell(0, position) } else { slice.cell(position, 0) };
            let is_here = |row: &&FinishedLimit| row.cell == cell && row.target == target;
            let here = limits.rows.iter().filter(is_here).filter_map(|row| Some((row.rises, row.value?)));
            let here: Vec<(bool, f64)> = here.collect();
            let point = |value: f64| if is_upwards { [at, value] } else { [value, at] };
            let last = |line: &LimitLine| line.points.last().map_or(f64::NAN, |point| point[usize::from(is_upwards)]);
            let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
            for (number, line) in open.iter().enumerate() {
                let in_its_sense = here.iter().enumerate().filter(|(_, (rises, _))| *rises == line.rises);
                pairs.extend(in_its_sense.map(|(place, (_, value))| ((value - last(line)).abs(), number, place)));
            }
            // The nearest ones belong together first.
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut ended: Vec<Option<LimitLine>> = open.drain(..).map(Some).collect();
            let mut next: Vec<Option<LimitLine>> = vec![None; here.len()];
            for (_, number, place) in pairs {
                if next[place].is_none()
                    && let Some(mut line) = ended[number].take()
                {
                    line.points.push(point(here[place].1));
                    next[place] = Some(line);
                }
            }
            found.extend(ended.into_iter().flatten());
            let begun = |rises: bool, value: f64| LimitLine { target, rises, points: vec![point(value)] };
            open = next
                .into_iter()
                .zip(&here)
                .map(|(line, &(rises, value))| line.unwrap_or_else(|| begun(rises, value)))
                .collect();
        }
        found.extend(open);
    }
    found
}

/// A target as a label, a small power of ten as such.
pub fn target_label(target: f64) -> String {
    let decade = libm::log10(target);
    let is_decade = (decade - decade.round()).abs() < 1e-12;
    format!("P = {}", if is_decade { label(target) } else { rounded(target) })
}

/// The targets of limits, each once.
fn targets(limits: &FinishedLimits) -> Vec<f64> {
    let mut targets: Vec<f64> = Vec::new();
    for row in &limits.rows {
        if !targets.contains(&row.target) {
            targets.push(row.target);
        }
    }
    targets
}

/// What the lines are, for a note.
pub fn note(limits: &FinishedLimits) -> String {
    let targets: Vec<String> = targets(limits).into_iter().map(rounded).collect();
    let contradicted = match limits.contradicted() {
        0 => String::new(),
        some => format!("; plain samples contradict {some} of {}", limits.rows.len()),
    };
    format!("red: limits of {} at P = {}{contradicted}", limits.of.replace('_', " "), targets.join(", "))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::job::JobSource;

    #[test]
    fn lines_follow_branches_and_leave_gaps_where_these_end() {
        let text = "name = \"j\"\n[axes]\nrotating_speed = { from = 1, to = 20, points = 20 }\npreload = { from = 0.1, to = 0.8, points = 8 }\n[criterion]\nkind = \"eigenvalue\"\n";
        let job = JobSource { path: PathBuf::from("job.toml"), text: text.to_owned() }.job().unwrap();
        let view = GridView::new(&job);
        let horizontal = view.horizontal().unwrap();
        let mut rows = Vec::new();
        // At positions on the preload axis: nothing, an island, a second one beside it, and only that.
        let limits: [&[(&str, f64)]; 8] = [
            &[],
            &[("rises", 4.0), ("falls", 5.0)],
            &[("rises", 3.0), ("falls", 6.0)],
            &[("rises", 3.5), ("falls", 5.5), ("rises", 15.0), ("falls", 16.0)],
            &[("rises", 14.0), ("falls", 17.0)],
            &[],
            &[("falls", 9.0)],
            &[("falls", 8.0)],
        ];
        for (position, limits) in limits.iter().enumerate() {
            let row = |state: &str, value| FinishedLimit {
                cell: position as u64,
                target: 0.01,
                rises: state == "rises",
                value,
                is_contradicted: false,
            };
            rows.extend(limits.iter().map(|&(state, value)| row(state, Some(value))));
            if limits.is_empty() {
                rows.push(row("within", None));
            }
        }
        let mut found = FinishedLimits { of: "rotating_speed".to_owned(), rows };
        let drawn = lines(&found, &view, &view.slice(0));
        let speeds: Vec<Vec<f64>> =
            drawn.iter().map(|line| line.points.iter().map(|point| point[1]).collect()).collect();
        assert_eq!(
            speeds,
            [vec![4.0, 3.0, 3.5], vec![5.0, 6.0, 5.5], vec![15.0, 14.0], vec![16.0, 17.0], vec![9.0, 8.0]]
        );
        assert_eq!(drawn[4].points[0][0], horizontal.values[6]);
        found.of = "static_friction".to_owned();
        assert!(lines(&found, &view, &view.slice(0)).is_empty());
    }

    #[test]
    fn targets_are_written_as_they_are() {
        assert_eq!([0.01, 1e-5, 3e-5, 0.025].map(target_label), ["P = 0.01", "P = 10⁻⁵", "P = 3e-5", "P = 0.025"]);
    }
}
