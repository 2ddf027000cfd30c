//! Which axes of a grid a picture shows: the two longest as an area, or one as a line; the others make slices.

use stickslip_core::model::quantity::Role;

use crate::job::Job;
use crate::picture::title::title;

/// The least number of values of an axis between which a picture interpolates.
const LEAST_VALUES: usize = 5;

/// An axis of a grid, as a picture names it.
pub struct ViewAxis {
    /// Name, with its unit where it is not a pure number.
    pub name: String,
    /// The unit alone, with a space before it; empty for a pure number.
    unit: String,
    /// Its values.
    pub values: Vec<f64>,
    /// The quantity; `None` for the standard deviations.
    pub quantity: Option<usize>,
    /// Its name in a job.
    pub name_in_job: String,
    /// Its name in plots.
    pub title: String,
    /// Whether cells are always described with it, even where it has one value.
    is_always_given: bool,
    /// Whether it is the rate of change of the axis before it.
    is_rate: bool,
    /// How many cells follow each other with the same value.
    stride: u64,
}

impl ViewAxis {
    /// The axis of standard deviations, with a value of each entry of `relative_std`: of the first input in which they
    /// differ.
    fn of_scatter(job: &Job) -> Self {
        let input = job.random.first_varied();
        Self {
            name: "relative std".to_owned(),
            unit: String::new(),
            values: job.random.relative_stds.iter().map(|entry| input.map_or(0.0, |input| entry[input])).collect(),
            quantity: None,
            name_in_job: "relative_std".to_owned(),
            title: "Relative standard deviation σ".to_owned(),
            is_always_given: false,
            is_rate: false,
            stride: 1,
        }
    }

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

    /// How many cells lie between a cell and the one with the first value of this axis.
    pub fn offset(&self, cell: u64) -> u64 {
        self.position(cell) as u64 * self.stride
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
    /// Place of the axis of standard deviations.
    std: usize,
    /// The quantities of the pair.
    pair: Option<[usize; 2]>,
    /// Axes of which one value alone is shown, with its position.
    held: Vec<(usize, usize)>,
    /// What stands above the picture, in place of what the cells of a slice share.
    title: Option<String>,
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
        let mut axes: Vec<ViewAxis> = Vec::new();
        for axis in &grid.axes {
            let quantity = job.quantity(axis.quantity);
            let (name, unit) = match &*quantity.unit {
                "1" => (quantity.label.to_string(), String::new()),
                unit => (format!("{}, {unit}", quantity.label), format!(" {unit}")),
            };
            axes.push(ViewAxis {
                name,
                unit,
                values: axis.axis.values().to_vec(),
                quantity: Some(axis.quantity),
                name_in_job: quantity.name.to_string(),
                title: title(quantity),
                is_always_given: quantity.is_always_shown && quantity.role == Role::Configuration,
                is_rate: quantity.is_rate,
                stride: 1,
            });
        }
        let std = grid.slower_than_scatter;
        axes.insert(std, ViewAxis::of_scatter(job));
        let mut stride = 1;
        for axis in axes.iter_mut().rev() {
            axis.stride = stride;
            stride *= axis.values.len() as u64;
        }
        let mut view = Self {
            axes,
            vertical: None,
            horizontal: None,
            std,
            pair: job.model().pair(),
            held: Vec::new(),
            title: None,
        };
        view.choose();
        view
    }

    /// Shows one value of an axis alone.
    ///
    /// # Errors
    /// No such axis, and a value that it does not have: with those there are.
    pub fn hold(&mut self, name: &str, value: f64) -> Result<(), String> {
        let is_it = |axis: &&ViewAxis| axis.name_in_job == name || axis.key() == name;
        let Some(index) = self.axes.iter().position(|axis| is_it(&axis)) else {
            let names: Vec<&str> =
                self.axes.iter().filter(|axis| axis.values.len() > 1).map(|axis| &*axis.name_in_job).collect();
            return Err(format!("{name} is no axis of the run, whose axes are {}", names.join(", ")));
        };
        let values = &self.axes[index].values;
        let is_near = |of: &f64| (of - value).abs() <= 1e-9 * value.abs();
        let Some(position) = values.iter().position(is_near) else {
            let nearest = values.iter().min_by(|a, b| (*a - value).abs().total_cmp(&(*b - value).abs()));
            let nearest = nearest.map_or_else(String::new, |nearest| format!("; the nearest is {nearest}"));
            return Err(format!("{name} has no value {value} in the run{nearest}"));
        };
        if let Some((_, other)) = self.held.iter().find(|(axis, _)| *axis == index) {
            let other = values[*other];
            return Err(format!("{name} is given twice, as {other} and as {value}; give one value of each axis"));
        }
        self.held.push((index, position));
        (self.vertical, self.horizontal) = (None, None);
        self.choose();
        Ok(())
    }

    /// The same under a title.
    #[must_use]
    pub fn titled(self, title: Option<String>) -> Self {
        Self { title, ..self }
    }

    /// Chooses the two longest axes; of equally long ones those that vary fastest. Standard deviations are shown if
    /// at most one other axis varies.
    fn choose(&mut self) {
        let length = |axis: &usize| if self.is_held(*axis) { 1 } else { self.axes[*axis].values.len() };
        let mut long: Vec<usize> = (0..self.axes.len()).rev().filter(|axis| length(axis) > 1).collect();
        if long.len() > 2 {
            long.retain(|&axis| axis != self.std);
        }
        long.sort_by_key(|axis| std::cmp::Reverse(length(axis)));
        long.truncate(2);
        // Upwards the slower one, but in a phase plane the rate.
        long.sort_unstable();
        let place = |axis: usize| self.axes[axis].quantity;
        let is_rate_of = |u: usize, x: usize| self.axes[u].is_rate && place(u) == place(x).map(|place| place + 1);
        match long[..] {
            [x, u] if is_rate_of(u, x) => (self.vertical, self.horizontal) = (Some(u), Some(x)),
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

    /// The axes of several values but one.
    pub fn others(&self, but: &ViewAxis) -> impl Iterator<Item = &ViewAxis> {
        let but = but.stride;
        self.axes.iter().filter(move |axis| axis.values.len() > 1 && axis.stride != but)
    }

    /// The values of a cell on some axes, but its standard deviations: "15 rad/s", "pad.mass = 0.1 kg". Of axes with
    /// one value only those that are always given are among them.
    fn values_of(&self, cell: u64, is_wanted: impl Fn(usize) -> bool) -> Vec<String> {
        let wanted = || self.axes.iter().enumerate().filter(|(i, _)| *i != self.std && is_wanted(*i));
        let value = |axis: &ViewAxis| axis.values[axis.position(cell)];
        let given = wanted().filter(|(_, axis)| axis.is_always_given);
        let given = given.map(|(_, axis)| match &*axis.unit {
            "" => format!("{} = {}", axis.key(), value(axis)),
            unit => format!("{}{unit}", value(axis)),
        });
        let others = wanted().filter(|(_, axis)| !axis.is_always_given && axis.values.len() > 1);
        let others = others.map(|(_, axis)| format!("{} = {}{}", axis.key(), rounded(value(axis)), axis.unit));
        given.chain(others).collect()
    }

    /// Values that are always given and that all cells share: "15 rad/s".
    pub fn fixed(&self) -> Vec<String> {
        self.values_of(0, |axis| self.axes[axis].is_always_given && self.axes[axis].values.len() == 1)
    }

    /// Where a cell lies: "15 rad/s, preload = 0.1", with its standard deviations if they have an axis.
    pub fn place_of(&self, job: &Job, cell: u64) -> String {
        let values = self.values_of(cell, |_| true).join(", ");
        if self.axes[self.std].values.len() > 1 { format!("{values}; {}", scatter(job, cell)) } else { values }
    }

    /// Where a cell lies on the axes of several values but one: "10 rad/s, static friction = 0.4".
    pub fn others_of(&self, job: &Job, cell: u64, but: &ViewAxis) -> String {
        self.values_and_scatter(job, cell, |axis| self.axes[axis].stride != but.stride)
    }

    /// The values of a cell on axes of several values, with its standard deviations if they are one of these.
    fn values_and_scatter(&self, job: &Job, cell: u64, is_wanted: impl Fn(usize) -> bool) -> String {
        let is_wanted = |axis: usize| self.axes[axis].values.len() > 1 && is_wanted(axis);
        let values = self.values_of(cell, is_wanted).join(", ");
        match (is_wanted(self.std), values.is_empty()) {
            (false, _) => values,
            (true, true) => scatter(job, cell),
            (true, false) => format!("{values}; {}", scatter(job, cell)),
        }
    }

    /// The configuration of a cell: its values on all axes but those of the pair and of standard deviations.
    pub fn configuration_of(&self, cell: u64) -> String {
        let is_of_pair = |axis: usize| {
            let quantity = self.axes[axis].quantity;
            self.pair.iter().flatten().any(|&place| quantity == Some(place))
        };
        self.values_of(cell, |axis| !is_of_pair(axis)).join(", ")
    }

    /// Whether one of two axes that are shown has so few values that a picture should not say what is between them.
    pub fn is_coarse(&self) -> bool {
        let shown = [self.vertical(), self.horizontal()].into_iter().flatten();
        self.vertical.is_some() && shown.map(|axis| axis.values.len()).min().is_some_and(|least| least < LEAST_VALUES)
    }

    fn is_held(&self, axis: usize) -> bool {
        self.held.iter().any(|(held, _)| *held == axis)
    }

    /// The axes whose combinations are the slices.
    fn sliced(&self) -> impl DoubleEndedIterator<Item = usize> {
        (0..self.axes.len()).filter(|&axis| !self.is_shown(axis) && !self.is_held(axis))
    }

    /// The same axes, of which the last has another value in the next slice.
    pub fn sliced_axes(&self) -> impl Iterator<Item = &ViewAxis> {
        self.sliced().map(|axis| &self.axes[axis])
    }

    fn is_shown(&self, axis: usize) -> bool {
        [self.vertical, self.horizontal].contains(&Some(axis))
    }

    /// The number of slices.
    pub fn slices(&self) -> usize {
        self.sliced().map(|axis| self.axes[axis].values.len()).product()
    }

    /// A slice by its number, which must be below [`GridView::slices`].
    pub fn slice(&self, mut number: usize) -> Slice<'_> {
        let mut first = self.held.iter().map(|&(axis, position)| position as u64 * self.axes[axis].stride).sum();
        for axis in self.sliced().rev() {
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

    /// The values that all of its cells share and others do not: "15 rad/s, pad.mass = 0.1 kg".
    pub fn place(&self, job: &Job) -> String {
        self.view.values_and_scatter(job, self.first, |axis| !self.view.is_shown(axis))
    }

    /// The values that all of its cells share, as the end of a title: " at 15 rad/s, pad.mass = 0.1 kg; relative std:
    /// preload 0.2".
    pub fn title(&self, job: &Job) -> String {
        let view = self.view;
        let shared = view.values_of(self.first, |axis| !view.is_shown(axis));
        let at = if shared.is_empty() { String::new() } else { format!(" at {}", shared.join(", ")) };
        if let Some(title) = &view.title {
            return if view.slices() == 1 { title.clone() } else { format!("{title}{at}") };
        }
        if view.is_shown(view.std) { at } else { format!("{at}; {}", scatter(job, self.first)) }
    }
}

/// How much the inputs of a cell scatter.
pub fn scatter(job: &Job, cell: u64) -> String {
    scatter_of_entry(job, job.grid.cell(cell).scatter)
}

/// How much the inputs scatter with an entry of `relative_std`.
pub fn scatter_of_entry(job: &Job, entry: usize) -> String {
    let stds = &job.random.relative_stds[entry];
    let (mut relative, mut absolute) = (Vec::new(), Vec::new());
    for (position, &std) in stds.iter().enumerate().filter(|(_, std)| **std > 0.0) {
        // The standard deviation of measured values has many digits.
        let std = (std * 1e6).round() / 1e6;
        let quantity = job.quantity(job.random.inputs[position]);
        // The last word of the name of an input is enough.
        let of_input = || quantity.label.rsplit(' ').next().unwrap_or(&quantity.label);
        let name = if quantity.role == Role::Input { of_input() } else { &quantity.name };
        if job.random.is_absolute(position) { &mut absolute } else { &mut relative }.push(format!("{name} {std}"));
    }
    match (relative.join(", "), absolute.join(", ")) {
        (relative, absolute) if relative.is_empty() && absolute.is_empty() => "relative std: none".to_owned(),
        (relative, absolute) if absolute.is_empty() => format!("relative std: {relative}"),
        (relative, absolute) if relative.is_empty() => format!("std: {absolute}"),
        (relative, absolute) => format!("relative std: {relative}; std: {absolute}"),
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

/// A probability with four decimals, or with two digits and an exponent where those would show little of it.
pub fn probability(value: f64) -> String {
    if value == 0.0 || value >= 1e-3 { format!("{value:.4}") } else { format!("{value:.1e}") }
}

/// The same with as many more digits as it takes to lie on the same side of a limit as the number itself: 0.04999 is
/// below 0.05, and 0.0500 is not.
pub fn probability_beside(value: f64, limit: Option<f64>) -> String {
    let keeps_its_side = |text: &String| {
        let shown: f64 = text.parse().unwrap_or(value);
        limit.is_none_or(|limit| (shown < limit) == (value < limit))
    };
    let with_more = |digits: usize| match value >= 1e-3 {
        true => format!("{value:.*}", digits + 3),
        false => format!("{value:.digits$e}"),
    };
    let mut all = std::iter::once(probability(value)).chain((2..16).map(with_more));
    all.find(keeps_its_side).unwrap_or_else(|| value.to_string())
}
