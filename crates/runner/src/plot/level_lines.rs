//! Lines over two axes on which the probability passes a level: the one rule by which plots and reports find them.
//!
//! Between the cells the [`deviate`] of the probability is interpolated, over the scales of the axes.

use crate::picture::scale::Scale;
use crate::picture::view::{GridView, Slice};
use crate::plot::area::drawn_values;
use crate::plot::contours::Field;
use crate::plot::levels::deviate;

/// The lines of a slice at a level, as values on the axis to the right and on the axis upwards; none without two axes, and
/// none where these have [too few values](GridView::is_coarse) to say what is between them.
pub fn level_lines(probability: &[Option<f64>], view: &GridView, slice: &Slice<'_>, level: f64) -> Vec<Vec<[f64; 2]>> {
    let (Some(vertical), Some(horizontal)) = (view.vertical(), view.horizontal()) else { return Vec::new() };
    if view.is_coarse() {
        return Vec::new();
    }
    let [right, up] = [horizontal, vertical].map(|axis| drawn_values(axis.values.len()));
    let [across, along] = [horizontal, vertical].map(|axis| Scale::for_values(&axis.values));
    let columns: Vec<f64> = right.iter().map(|&at| across.at(horizontal.values[at])).collect();
    let rows: Vec<f64> = up.iter().map(|&at| along.at(vertical.values[at])).collect();
    let cells = up.iter().flat_map(|&up| right.iter().map(move |&right| slice.cell(up, right) as usize));
    let values: Vec<Option<f64>> = cells.map(|cell| probability[cell].map(deviate)).collect();
    let field = Field { columns: &columns, rows: &rows, values: &values };
    let in_values = |line: Vec<(f64, f64)>| line.into_iter().map(|(x, y)| [across.value(x), along.value(y)]).collect();
    field.on(deviate(level)).into_iter().map(in_values).collect()
}

#[cfg(test)]
mod tests {
    use stickslip_sampler::special_functions::normal;

    use super::*;
    use crate::job::JobSource;

    /// P = Phi(4 x + log10 y - 3), which is a plane in deviates over one linear and one logarithmic axis.
    #[test]
    fn lines_are_exact_where_deviates_are_a_plane() {
        let text = "name = \"j\"\n[axes]\nrotating_speed = { from = 1, to = 100, points = 9, scale = \"log\" }\npreload = { from = 0.1, to = 0.9, points = 6 }\n[random]\ninputs = [\"preload\"]\nrelative_std = 0.1\n[criterion]\nkind = \"eigenvalue\"\n[sampling]\nseed = 1\n";
        let job = JobSource { path: "job.toml".into(), text: text.to_owned() }.job().unwrap();
        let view = GridView::new(&job);
        let (vertical, horizontal) = (view.vertical().unwrap(), view.horizontal().unwrap());
        let plane = |x: f64, y: f64| 4.0 * x + libm::log10(y) - 3.0;
        let probability: Vec<Option<f64>> = (0..job.cells())
            .map(|cell| plane(horizontal.values[horizontal.position(cell)], vertical.values[vertical.position(cell)]))
            .map(|deviate| Some(normal::upper_tail(-deviate)))
            .collect();
        for level in [0.05, 0.5, 0.9] {
            let lines = level_lines(&probability, &view, &view.slice(0), level);
            assert_eq!(lines.len(), 1, "{level}");
            let off = |[x, y]: &[f64; 2]| (plane(*x, *y) - deviate(level)).abs();
            assert!(lines[0].len() > 5 && lines[0].iter().all(|point| off(point) < 1e-9), "{level}: {:?}", lines[0]);
        }
    }
}
