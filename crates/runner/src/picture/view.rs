//! Which axes of a grid a picture shows: the two longest as an area, or one as a line; the others make slices.

use stickslip_core::parameters::scalar;

use crate::job::{Job, RandomInput, StartValue};

/// Largest number of slices that a plot draws, each as a panel.
pub const MOST_PANELS: usize = 60;

/// An axis of a grid, as a picture names it.
pub struct ViewAxis {
    /// Name, with its unit where it is not a pure number.
    pub name: String,
    /// The unit alone, with a space before it; empty for a pure number.
    unit: String,
    /// Its values.
    pub values: Vec<f64>,
    /// How many cells follow each other with the same value.
    stride: u64,
}

impl ViewAxis {
    /// Its name without the unit.
    pub fn key(&self) -> &str {
        self.name.split(',').next().unwrap_or_default()
    }

    /// Its unit, empty for a pure number.
    pub fn unit(&self) -> &str {
        self.unit.trim_start()
    }

    /// Its first and its last value.
    pub fn ends(&self) -> [f64; 2] {
        [self.values.first(), self.values.last()].map(|value| value.copied().unwrap_or(f64::NAN))
    }

    /// The position of a cell on the axis.
    pub fn position(&self, cell: u64) -> usize {
        (cell / self.stride % self.values.len() as u64) as usize
    }
}

/// The axes of a grid and those that pictures show.
pub struct GridView {
    /// All axes, slowest first.
    axes: Vec<ViewAxis>,
    /// The axis that runs upwards, if two are shown.
    vertical: Option<usize>,
    /// The axis that runs to the right; none in a grid of one cell.
    horizontal: Option<usize>,
    /// Places of the axes that every grid has: rotating speed and standard deviation.
    speed: usize,
    std: usize,
}

/// Most values of an axis that become curves of one drawing, and the least number of values of a curve.
const MOST_CURVES: usize = 6;
const LEAST_POINTS: usize = 10;

/// Whether two axes make some curves, and not a surface: one for each value of the first.
pub fn is_family(several: &ViewAxis, along: &ViewAxis) -> bool {
    several.values.len() <= MOST_CURVES && along.values.len() >= LEAST_POINTS
}

/// A slice of a grid: the cells that agree in all axes that are not shown.
pub struct Slice<'a> {
    view: &'a GridView,
    /// Its first cell.
    pub first: u64,
}

impl GridView {
    /// The view of a job's grid.
    pub fn new(job: &Job) -> Self {
        let grid = &job.grid;
        let units = job.criterion.given_start().unwrap_or_default().units;
        let unit_of = |name: &str| {
            let of_start = || StartValue::from_key(name).map_or("1", |number| number.unit(units));
            scalar(name).map_or_else(of_start, |scalar| scalar.unit)
        };
        let mut axes: Vec<(String, &str, Vec<f64>)> = grid
            .further()
            .map(|further| (further.name.clone(), unit_of(&further.name), further.axis.values().to_vec()))
            .collect();
        let speed = axes.len();
        axes.push(("rotating speed".to_owned(), "rad/s", grid.rotating_speed.values().to_vec()));
        axes.push(("relative std".to_owned(), "1", scatters(job)));
        axes.push(("preload".to_owned(), "1", grid.preload.values().to_vec()));
        axes.push(("static friction".to_owned(), "1", grid.static_friction.values().to_vec()));
        let mut stride = 1;
        let mut viewed: Vec<ViewAxis> = Vec::new();
        for (name, unit, values) in axes.into_iter().rev() {
            let length = values.len() as u64;
            let (name, unit) = match unit {
                "1" => (name, String::new()),
                unit => (format!("{name}, {unit}"), format!(" {unit}")),
            };
            viewed.push(ViewAxis { name, unit, values, stride });
            stride *= length;
        }
        viewed.reverse();
        let mut view = Self { axes: viewed, vertical: None, horizontal: None, speed, std: speed + 1 };
        view.choose();
        view
    }

    /// Chooses the two longest axes; of equally long ones those that vary fastest. Standard deviations are shown if
    /// at most one other axis varies.
    fn choose(&mut self) {
        let length = |axis: &usize| self.axes[*axis].values.len();
        let mut long: Vec<usize> = (0..self.axes.len()).rev().filter(|axis| length(axis) > 1).collect();
        if long.len() > 2 {
            long.retain(|&axis| axis != self.std);
        }
        long.sort_by_key(|axis| std::cmp::Reverse(length(axis)));
        long.truncate(2);
        // Upwards the slower one, but in the plane of displacement and speed the speed.
        long.sort_unstable();
        let is = |axis: usize, number: StartValue| self.axes[axis].name.starts_with(number.key());
        match long[..] {
            [x, u] if is(x, StartValue::Tangential) && is(u, StartValue::Velocity) => {
                (self.vertical, self.horizontal) = (Some(u), Some(x));
            }
            [slow, fast] => (self.vertical, self.horizontal) = (Some(slow), Some(fast)),
            [only] => self.horizontal = Some(only),
            _ => {}
        }
    }

    /// All axes, slowest first.
    pub fn axes(&self) -> &[ViewAxis] {
        &self.axes
    }

    /// Which axes run upwards and to the right.
    pub fn shown(&self) -> (Option<usize>, Option<usize>) {
        (self.vertical, self.horizontal)
    }

    /// The axis that runs upwards, if two are shown.
    pub fn vertical(&self) -> Option<&ViewAxis> {
        self.vertical.map(|axis| &self.axes[axis])
    }

    /// The axis that runs to the right; none in a grid of one cell.
    pub fn horizontal(&self) -> Option<&ViewAxis> {
        self.horizontal.map(|axis| &self.axes[axis])
    }

    /// The values of a cell on some axes, but its standard deviations: "15 rad/s", "pad.mass = 0.1 kg". Of axes with one
    /// value only the rotating speed is told.
    fn values_of(&self, cell: u64, is_wanted: impl Fn(usize) -> bool) -> Vec<String> {
        let value = |axis: usize| self.axes[axis].values[self.axes[axis].position(cell)];
        let mut values = Vec::new();
        if is_wanted(self.speed) {
            values.push(format!("{} rad/s", value(self.speed)));
        }
        for (i, axis) in self.axes.iter().enumerate() {
            if ![self.speed, self.std].contains(&i) && axis.values.len() > 1 && is_wanted(i) {
                values.push(format!("{} = {}{}", axis.key(), rounded(value(i)), axis.unit));
            }
        }
        values
    }

    /// Where a cell lies: "15 rad/s, preload = 0.1", with its standard deviations if they have an axis.
    pub fn place_of(&self, job: &Job, cell: u64) -> String {
        let values = self.values_of(cell, |_| true).join(", ");
        if self.axes[self.std].values.len() > 1 { format!("{values}; {}", scatter(job, cell)) } else { values }
    }

    /// The brake of a cell: its values on all axes but preload, static friction and standard deviations.
    pub fn brake_of(&self, cell: u64) -> String {
        // Preload and static friction are the last axes.
        self.values_of(cell, |axis| axis + 2 < self.axes.len()).join(", ")
    }

    fn is_shown(&self, axis: usize) -> bool {
        [self.vertical, self.horizontal].contains(&Some(axis))
    }

    /// The number of slices.
    pub fn slices(&self) -> usize {
        (0..self.axes.len()).filter(|&axis| !self.is_shown(axis)).map(|axis| self.axes[axis].values.len()).product()
    }

    /// A slice by its number, which must be below [`GridView::slices`].
    pub fn slice(&self, mut number: usize) -> Slice<'_> {
        let mut first = 0;
        for axis in (0..self.axes.len()).rev().filter(|&axis| !self.is_shown(axis)) {
            let length = self.axes[axis].values.len();
            first += (number % length) as u64 * self.axes[axis].stride;
            number /= length;
        }
        Slice { view: self, first }
    }

    /// The slice of a cell.
    pub fn slice_of(&self, cell: u64) -> Slice<'_> {
        let shown = [self.vertical(), self.horizontal()].into_iter().flatten();
        let within: u64 = shown.map(|axis| axis.position(cell) as u64 * axis.stride).sum();
        Slice { view: self, first: cell - within }
    }
}

impl Slice<'_> {
    /// The cell at positions upwards and to the right.
    pub fn cell(&self, up: usize, right: usize) -> u64 {
        let along = |axis: Option<&ViewAxis>, position: usize| axis.map_or(0, |axis| position as u64 * axis.stride);
        self.first + along(self.view.vertical(), up) + along(self.view.horizontal(), right)
    }

    /// The values that all of its cells share, as the end of a title: " at 15 rad/s, pad.mass = 0.1 kg; relative std:
    /// preload 0.2".
    pub fn title(&self, job: &Job) -> String {
        let view = self.view;
        let shared = view.values_of(self.first, |axis| !view.is_shown(axis));
        let at = if shared.is_empty() { String::new() } else { format!(" at {}", shared.join(", ")) };
        if view.is_shown(view.std) { at } else { format!("{at}; {}", scatter(job, self.first)) }
    }
}

/// A value of each entry of `relative_std`: of the first input in which they differ.
fn scatters(job: &Job) -> Vec<f64> {
    let input = job.random.first_varied();
    job.random.relative_stds.iter().map(|entry| input.map_or(0.0, |input| entry[input])).collect()
}

/// How much the inputs of a cell scatter.
pub fn scatter(job: &Job, cell: u64) -> String {
    let stds = &job.random.relative_stds[job.grid.relative_std_index(cell)];
    let (mut relative, mut absolute) = (Vec::new(), Vec::new());
    for (input, &std) in job.random.inputs.iter().zip(stds).filter(|(_, std)| **std > 0.0) {
        // The standard deviation of measured values has many digits.
        let std = (std * 1e6).round() / 1e6;
        match input {
            RandomInput::StaticFriction => relative.push(format!("friction {std}")),
            RandomInput::Start(number) => absolute.push(format!("{} {std}", number.key())),
            input => relative.push(format!("{} {std}", input.name())),
        }
    }
    let relative = if relative.is_empty() { "none".to_owned() } else { relative.join(", ") };
    if absolute.is_empty() {
        format!("relative std: {relative}")
    } else {
        format!("relative std: {relative}; std: {}", absolute.join(", "))
    }
}

/// A number rounded to six significant digits, as many as anyone reads.
pub fn round(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// A number with at most six digits, as short as possible.
pub fn rounded(value: f64) -> String {
    let rounded = round(value);
    if rounded == 0.0 || (1e-4..1e6).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// A number as a label of eight characters.
pub fn label(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e4).contains(&value.abs());
    if plain { format!("{value:>8.4}") } else { format!("{value:>8.2e}") }
}
