//! The cells of a run in which nothing scatters, such as a basin of attraction: each has one verdict.

use stickslip_core::model::Model;

use crate::picture::panels::drawn_slices;
use crate::picture::view::{GridView, Slice, ViewAxis};
use crate::plot::axes::{axis_of_cells, edges_of};
use crate::plot::canvas::{Canvas, Place};
use crate::plot::panel::{ABOVE, Arrangement, Axis, LEFT, Layout, Panel, RIGHT, heading};
use crate::plot::regions::{Region, Regions};
use crate::plot::values::Values;

/// Height of a panel over its width: with two axes, and with one.
const ASPECT: f64 = 0.78;
const STRIP: f64 = 0.2;

/// Space between the panels and the legend, and below it.
const BEFORE: f64 = 10.0;
const AFTER: f64 = 4.0;

/// A figure of a run in which nothing scatters, this wide in pixels; none for a single cell.
pub fn figure(values: &Values, view: &GridView, width: f64) -> Option<Canvas> {
    let horizontal = view.horizontal()?;
    let axes = Axes { across: axis_of_cells(horizontal), up: view.vertical().map(axis_of_cells) };
    let aspect = if axes.up.is_some() { ASPECT } else { STRIP };
    let slices = drawn_slices(view);
    let layout = Layout { above: ABOVE, right: RIGHT, below: 0.0, aspect, most_columns: usize::MAX };
    let Arrangement { panels, height } = layout.arrange(slices.len(), width);
    let regions: Vec<Regions> = panels
        .iter()
        .zip(&slices)
        .map(|(panel, &number)| regions(values, panel, &view.slice(number), &axes, [view.vertical(), Some(horizontal)]))
        .collect();
    let legend = Regions::legend(&regions, names(values.job.model()), width - LEFT - RIGHT);
    let mut canvas = Canvas::new(width, height + BEFORE + legend.height() + AFTER);
    for (&number, (panel, regions)) in slices.iter().zip(panels.iter().zip(&regions)) {
        regions.draw(&mut canvas);
        panel.outline(&mut canvas);
        panel.axis_below(&mut canvas, &axes.across);
        if let Some(up) = &axes.up {
            panel.axis_beside(&mut canvas, up);
        }
        heading(&mut canvas, panel, &view.slice(number).title(&values.job));
    }
    legend.draw(&mut canvas, (LEFT, height + BEFORE));
    Some(canvas)
}

/// The axes of all panels.
struct Axes {
    across: Axis,
    /// None over one axis.
    up: Option<Axis>,
}

/// What the regions are called.
pub fn names(model: &dyn Model) -> [&'static str; 5] {
    let [stable, unstable] = model.verdict_names();
    [stable, unstable, "undecided", "failed", "samples differ"]
}

/// The cells of a slice.
fn regions(
    values: &Values,
    panel: &Panel,
    slice: &Slice<'_>,
    axes: &Axes,
    [vertical, horizontal]: [Option<&ViewAxis>; 2],
) -> Regions {
    let along = |of: Option<&ViewAxis>, place: &dyn Fn(f64) -> f64| {
        of.map_or_else(Vec::new, |axis| edges(&axis.values.iter().map(|&value| place(value)).collect::<Vec<f64>>()))
    };
    let columns = along(horizontal, &|value| panel.place(axes.across.scale.at(value), 0.0).0);
    let rows = match &axes.up {
        Some(up) => along(vertical, &|value| panel.place(0.0, up.scale.at(value)).1),
        None => vec![[panel.bottom(), panel.top]],
    };
    let mut regions = Regions::default();
    for (up, [low, high]) in rows.iter().enumerate() {
        let region = |right: usize| of_cell(values, slice.cell(up, right) as usize);
        let mut first = 0;
        for right in 0..columns.len() {
            // Cells beside each other with one verdict become one rectangle.
            if right + 1 < columns.len() && region(right + 1) == region(right) {
                continue;
            }
            let corners: [Place; 2] = [(columns[first][0], low.min(*high)), (columns[right][1], low.max(*high))];
            let left = corners[0].0.min(corners[1].0);
            let end = corners[0].0.max(corners[1].0);
            regions.add(region(right), panel.rectangle((left, corners[0].1), (end, corners[1].1)));
            first = right + 1;
        }
    }
    regions
}

/// The edges of cells about their places.
fn edges(places: &[f64]) -> Vec<[f64; 2]> {
    (0..places.len()).map(|i| edges_of(places, i)).collect()
}

/// The verdict of a cell.
pub fn of_cell(values: &Values, cell: usize) -> Region {
    let Values { samples, unstable, undecided, failed, .. } = values;
    region(values.probability[cell], [samples, unstable, undecided, failed].map(|counts| counts[cell]))
}

/// The region that the counts of a cell show: all of its samples, and those that are unstable, undecided and failed.
fn region(probability: Option<f64>, [samples, unstable, undecided, failed]: [u64; 4]) -> Region {
    match samples {
        // Without samples, the probability is integrated.
        0 => match probability {
            Some(0.0) => Region::Stable,
            Some(1.0) => Region::Unstable,
            _ => Region::Open,
        },
        all if all == unstable => Region::Unstable,
        all if all == undecided => Region::Undecided,
        all if all == failed => Region::Failed,
        _ if unstable + undecided + failed == 0 => Region::Stable,
        _ => Region::Open,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_verdict_of_all_its_samples() {
        for (counts, expected) in [
            ([1, 0, 0, 0], Region::Stable),
            ([3, 3, 0, 0], Region::Unstable),
            ([1, 0, 1, 0], Region::Undecided),
            ([2, 0, 0, 2], Region::Failed),
            ([2, 1, 0, 0], Region::Open),
        ] {
            assert_eq!(region(None, counts), expected, "{counts:?}");
        }
        let integrated = |p| region(p, [0; 4]);
        assert_eq!([Some(0.0), Some(1.0), Some(0.5)].map(integrated), [Region::Stable, Region::Unstable, Region::Open]);
    }

    #[test]
    fn cells_end_half_way_to_their_neighbours() {
        assert_eq!(edges(&[1.0, 2.0, 4.0]), [[0.5, 1.5], [1.5, 3.0], [3.0, 5.0]]);
        assert_eq!(edges(&[4.0, 2.0]), [[5.0, 3.0], [3.0, 1.0]]);
    }
}
