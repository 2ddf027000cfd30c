//! Lines and areas of a grid of values: where they lie above a level, and on it.
//!
//! Each cell of the grid, between four points, is divided into four triangles about its middle, which has the mean of
//! the four values; within a triangle values are linear. So there is one area above a level, and lines end only at the
//! edges of the grid and of gaps.

use std::collections::HashMap;

use crate::plot::canvas::Place;

/// Values at the points of a grid.
pub struct Field<'a> {
    /// Places of the columns and of the rows, in pixels.
    pub columns: &'a [f64],
    pub rows: &'a [f64],
    /// Row after row; none where nothing is known.
    pub values: &'a [Option<f64>],
}

/// A point with its value.
type Corner = (Place, f64);

impl Field<'_> {
    fn value(&self, row: usize, column: usize) -> Option<Corner> {
        let value = *self.values.get(row * self.columns.len() + column)?;
        Some(((self.columns[column], self.rows[row]), value?))
    }

    /// The corners of the cell above a point and to its right, all around.
    fn cell(&self, row: usize, column: usize) -> Option<[Corner; 4]> {
        Some([
            self.value(row, column)?,
            self.value(row, column + 1)?,
            self.value(row + 1, column + 1)?,
            self.value(row + 1, column)?,
        ])
    }

    fn cells(&self) -> impl Iterator<Item = (usize, usize)> {
        let columns = self.columns.len().saturating_sub(1);
        (0..self.rows.len().saturating_sub(1)).flat_map(move |row| (0..columns).map(move |column| (row, column)))
    }

    /// The area in which values are at least a level, as polygons that do not overlap.
    pub fn at_least(&self, level: f64) -> Vec<Vec<Place>> {
        let mut polygons = Vec::new();
        // Whole cells beside each other become one rectangle.
        let mut run: Option<(usize, usize, usize)> = None;
        let close = |run: &mut Option<(usize, usize, usize)>, polygons: &mut Vec<Vec<Place>>| {
            if let Some((row, from, to)) = run.take() {
                let (left, right) = (self.columns[from], self.columns[to]);
                let (low, high) = (self.rows[row], self.rows[row + 1]);
                polygons.push(vec![(left, low), (right, low), (right, high), (left, high)]);
            }
        };
        for (row, column) in self.cells() {
            let Some(corners) = self.cell(row, column) else {
                close(&mut run, &mut polygons);
                continue;
            };
            if corners.iter().all(|corner| corner.1 >= level) {
                match &mut run {
                    Some((of, _, to)) if *of == row && *to == column => *to = column + 1,
                    _ => {
                        close(&mut run, &mut polygons);
                        run = Some((row, column, column + 1));
                    }
                }
                continue;
            }
            close(&mut run, &mut polygons);
            let parts = triangles(corners).map(|triangle| part_at_least(&triangle, level));
            polygons.extend(parts.into_iter().filter(|part| part.len() > 2));
        }
        close(&mut run, &mut polygons);
        polygons
    }

    /// The lines on which values are at a level.
    pub fn on(&self, level: f64) -> Vec<Vec<Place>> {
        let mut segments = Vec::new();
        for (row, column) in self.cells() {
            let Some(corners) = self.cell(row, column) else { continue };
            for triangle in triangles(corners) {
                let cuts: Vec<Place> = (0..3)
                    .map(|i| (triangle[i], triangle[(i + 1) % 3]))
                    .filter(|(a, b)| (a.1 >= level) != (b.1 >= level))
                    .map(|(a, b)| cut(a, b, level))
                    .collect();
                if let [from, to] = cuts[..]
                    && from != to
                {
                    segments.push((from, to));
                }
            }
        }
        joined(&segments)
    }
}

fn triangles(corners: [Corner; 4]) -> [[Corner; 3]; 4] {
    let mean = |of: fn(&Corner) -> f64| 0.25 * corners.iter().map(of).sum::<f64>();
    let middle = ((mean(|corner| corner.0.0), mean(|corner| corner.0.1)), mean(|corner| corner.1));
    [0, 1, 2, 3].map(|i| [corners[i], corners[(i + 1) % 4], middle])
}

/// The place between two points at which the value is at a level; the same whichever comes first.
fn cut(a: Corner, b: Corner, level: f64) -> Place {
    let (a, b) = if a.1 <= b.1 { (a, b) } else { (b, a) };
    let share = (level - a.1) / (b.1 - a.1);
    (a.0.0 + share * (b.0.0 - a.0.0), a.0.1 + share * (b.0.1 - a.0.1))
}

/// The part of a triangle in which values are at least a level.
fn part_at_least(triangle: &[Corner; 3], level: f64) -> Vec<Place> {
    let mut part = Vec::with_capacity(4);
    for i in 0..3 {
        let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
        if a.1 >= level {
            part.push(a.0);
        }
        if (a.1 >= level) != (b.1 >= level) {
            part.push(cut(a, b, level));
        }
    }
    part
}

/// Segments joined at their ends to lines as long as possible.
fn joined(segments: &[(Place, Place)]) -> Vec<Vec<Place>> {
    let key = |place: Place| (place.0.to_bits(), place.1.to_bits());
    let mut at: HashMap<(u64, u64), Vec<usize>> = HashMap::new();
    for (i, (from, to)) in segments.iter().enumerate() {
        at.entry(key(*from)).or_default().push(i);
        at.entry(key(*to)).or_default().push(i);
    }
    let mut is_used = vec![false; segments.len()];
    let extend = |line: &mut Vec<Place>, is_used: &mut Vec<bool>| {
        while let Some(&end) = line.last() {
            let next = at.get(&key(end)).and_then(|touching| touching.iter().find(|&&i| !is_used[i]));
            let Some(&i) = next else { break };
            is_used[i] = true;
            let (from, to) = segments[i];
            line.push(if from == end { to } else { from });
        }
    };
    let mut lines = Vec::new();
    for i in 0..segments.len() {
        if is_used[i] {
            continue;
        }
        is_used[i] = true;
        let mut line = vec![segments[i].0, segments[i].1];
        extend(&mut line, &mut is_used);
        line.reverse();
        extend(&mut line, &mut is_used);
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid over 0 to `size` in both directions, with a value from the place.
    fn field(size: usize, value: impl Fn(f64, f64) -> Option<f64>) -> (Vec<f64>, Vec<Option<f64>>) {
        let places: Vec<f64> = (0..=size).map(|i| i as f64).collect();
        let values = places.iter().flat_map(|y| places.iter().map(|x| value(*x, *y)).collect::<Vec<_>>()).collect();
        (places, values)
    }

    fn area(polygons: &[Vec<Place>]) -> f64 {
        let of = |polygon: &Vec<Place>| {
            let next = polygon.iter().cycle().skip(1);
            0.5 * polygon.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>().abs()
        };
        polygons.iter().map(of).sum()
    }

    #[test]
    fn a_plane_is_cut_by_straight_lines() {
        let (places, values) = field(8, |x, y| Some(x + 0.5 * y));
        let field = Field { columns: &places, rows: &places, values: &values };
        for level in [0.7, 3.0, 6.3, 11.0] {
            let lines = field.on(level);
            assert_eq!(lines.len(), 1, "{level}");
            assert!(lines[0].iter().all(|(x, y)| (x + 0.5 * y - level).abs() < 1e-12));
            // Below the line lies a triangle, cut off by the edges.
            let triangle = |side: f64| if side > 0.0 { side * side } else { 0.0 };
            let below = triangle(level) - triangle(level - 8.0) - triangle(level - 4.0) + triangle(level - 12.0);
            assert!((area(&field.at_least(level)) - (64.0 - below)).abs() < 1e-9, "{level}");
        }
        assert!(field.on(13.0).is_empty() && field.at_least(13.0).is_empty());
        assert_eq!(area(&field.at_least(-1.0)), 64.0);
        assert_eq!(field.at_least(-1.0).len(), 8, "whole rows are rectangles");
    }

    #[test]
    fn an_island_has_a_closed_line() {
        let (places, values) = field(40, |x, y| Some(100.0 - (x - 20.0) * (x - 20.0) - (y - 20.0) * (y - 20.0)));
        let field = Field { columns: &places, rows: &places, values: &values };
        let lines = field.on(0.0);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        assert!((area(&field.at_least(0.0)) / (100.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
    }

    #[test]
    fn gaps_are_left_out() {
        let (places, values) = field(4, |x, y| (x, y).ne(&(2.0, 2.0)).then_some(x));
        let field = Field { columns: &places, rows: &places, values: &values };
        assert_eq!(area(&field.at_least(0.0)), 12.0);
        assert_eq!(field.on(1.5).len(), 2);
    }
}
