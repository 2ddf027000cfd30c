//! A rectangle with two axes.

use crate::picture::scale::{Scale, superscript};
use crate::plot::canvas::{BLACK, Canvas, GREY, Pen, Place, Side, width_of};

/// Sizes of text: labels of ticks, and titles.
pub const SMALL: u32 = 10;
pub const NORMAL: u32 = 11;

/// Size of notes below the panels.
pub const OF_NOTES: u32 = 9;

/// Length of ticks, and the space between them and their labels.
const TICK: f64 = 4.0;
const GAP: f64 = 3.0;

/// Space of an axis with its labels and title: at the left of a panel, and below it.
pub const LEFT: f64 = 52.0;
pub const BELOW: f64 = 36.0;

/// Space above a panel for its heading.
pub const ABOVE: f64 = 24.0;

/// Distance of notes below the panels.
const NOTE: f64 = 11.0;

/// Space at the right of the last panel.
pub const RIGHT: f64 = 14.0;

/// Least width of a panel.
const LEAST_WIDTH: f64 = 150.0;

/// Least distance of ticks, in pixels.
const TICK_DISTANCE: (f64, f64) = (46.0, 28.0);

const FRAME: Pen = Pen::new(BLACK, 0.8);

/// An axis: its scale, what it is, and its unit, empty for a pure number.
#[derive(Debug, Clone)]
pub struct Axis {
    pub scale: Scale,
    pub title: String,
    pub unit: String,
}

impl Axis {
    /// Its title with the unit, and the power of ten that its labels leave out.
    fn heading(&self, power: i32) -> String {
        if let Some(prefix) = prefix(&self.unit, power) {
            return format!("{} ({prefix}{})", self.title, self.unit);
        }
        let factor = if power == 0 { String::new() } else { format!("10{}", superscript(power)) };
        let unit = [factor.as_str(), self.unit.as_str()].into_iter().filter(|part| !part.is_empty());
        let unit: Vec<&str> = unit.collect();
        if unit.is_empty() { self.title.clone() } else { format!("{} ({})", self.title, unit.join(" ")) }
    }
}

/// The prefix of a unit that stands for a power of ten, of units that have no prefix yet.
fn prefix(unit: &str, power: i32) -> Option<&'static str> {
    let first = unit.split(['/', ' ', '^']).next().unwrap_or_default();
    let prefixes = [(-9, "n"), (-6, "µ"), (-3, "m"), (3, "k"), (6, "M"), (9, "G")];
    let found = prefixes.into_iter().find(|(of, _)| *of == power).map(|(_, prefix)| prefix);
    found.filter(|_| ["N", "Hz", "Pa", "J", "W", "V", "m", "s"].contains(&first) && !unit.contains('^'))
}

/// Where a panel lies, without its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Panel {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Panel {
    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// Where shares of the width and of the height lie, counted from the lower left corner.
    pub fn place(&self, right: f64, up: f64) -> Place {
        (self.left + right * self.width, self.bottom() - up * self.height)
    }

    /// Whether a place lies inside.
    pub fn contains(&self, (x, y): Place) -> bool {
        (self.left..=self.right()).contains(&x) && (self.top..=self.bottom()).contains(&y)
    }

    /// A rectangle as a polygon, as far as it lies inside.
    pub fn rectangle(&self, (left, top): Place, (right, bottom): Place) -> Vec<Place> {
        let (left, right) = (left.max(self.left), right.min(self.right()));
        let (top, bottom) = (top.max(self.top), bottom.min(self.bottom()));
        vec![(left, top), (right, top), (right, bottom), (left, bottom)]
    }

    /// Draws a line around it.
    pub fn outline(&self, canvas: &mut Canvas) {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)];
        canvas.lines(&corners.map(|(right, up)| self.place(right, up)), FRAME);
    }

    /// Draws the frame, the ticks, their labels and the titles.
    pub fn frame(&self, canvas: &mut Canvas, horizontal: &Axis, vertical: &Axis) {
        self.outline(canvas);
        self.axis_below(canvas, horizontal);
        self.axis_beside(canvas, vertical);
    }

    /// Draws the ticks of the horizontal axis, their labels and its title.
    pub fn axis_below(&self, canvas: &mut Canvas, horizontal: &Axis) {
        let (ticks, power) = horizontal.scale.ticks(most(self.width, TICK_DISTANCE.0));
        for tick in ticks {
            let at = self.place(horizontal.scale.at(tick.value), 0.0);
            canvas.line(at, (at.0, at.1 + TICK), FRAME);
            let below = (at.0, at.1 + TICK + GAP + f64::from(SMALL) * 0.8);
            canvas.text(below, &tick.label, SMALL, Side::Middle, 0.0, BLACK);
        }
        let below = (self.left + 0.5 * self.width, self.bottom() + BELOW - 4.0);
        title(canvas, below, &horizontal.heading(power), self.width + LEFT, 0.0);
    }

    /// Draws the ticks of the vertical axis, their labels and its title.
    pub fn axis_beside(&self, canvas: &mut Canvas, vertical: &Axis) {
        let (ticks, power) = vertical.scale.ticks(most(self.height, TICK_DISTANCE.1));
        for tick in ticks {
            let at = self.place(0.0, vertical.scale.at(tick.value));
            canvas.line(at, (at.0 - TICK, at.1), FRAME);
            let beside = (at.0 - TICK - GAP, at.1 + 0.35 * f64::from(SMALL));
            canvas.text(beside, &tick.label, SMALL, Side::Left, 0.0, BLACK);
        }
        let beside = (self.left - left_of(vertical, self.height) + f64::from(NORMAL), self.top + 0.5 * self.height);
        title(canvas, beside, &vertical.heading(power), self.height + BELOW, -90.0);
    }
}

/// Space around the panels of a figure, and their shape.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Space above each panel, at the right of them all, and below them all.
    pub above: f64,
    pub right: f64,
    pub below: f64,
    /// Height of a panel over its width.
    pub aspect: f64,
    /// Most panels beside each other.
    pub most_columns: usize,
}

/// Where the panels of a figure lie, and its height.
pub struct Arrangement {
    pub panels: Vec<Panel>,
    pub height: f64,
}

impl Layout {
    /// Arranges panels in rows, as many beside each other as fit in the width.
    pub fn arrange(&self, count: usize, width: f64) -> Arrangement {
        let inside = width - self.right;
        let fits = ((inside / (LEFT + LEAST_WIDTH)).floor() as usize).clamp(1, self.most_columns);
        let columns = fits.min(count.max(1));
        let panel_width = inside / columns as f64 - LEFT;
        let panel_height = self.aspect * panel_width;
        let step = self.above + panel_height + BELOW;
        let panels = (0..count).map(|i| Panel {
            left: LEFT + (i % columns) as f64 * (LEFT + panel_width),
            top: self.above + (i / columns) as f64 * step,
            width: panel_width,
            height: panel_height,
        });
        Arrangement { panels: panels.collect(), height: count.div_ceil(columns) as f64 * step + self.below }
    }
}

/// A figure of one panel, with notes below it, while it is drawn.
pub struct OnePanel {
    pub canvas: Canvas,
    pub panel: Panel,
    notes: Vec<String>,
    height: f64,
    below: f64,
}

impl OnePanel {
    /// A figure this wide in pixels, whose panel has a height of `aspect` times its width; `between` is left free between
    /// the panel and the notes.
    pub fn new(width: f64, aspect: f64, between: f64, notes: &[String]) -> Self {
        let notes = in_lines(notes, width);
        let below = between + space_of(&notes);
        let panel =
            Panel { left: LEFT, top: ABOVE, width: width - RIGHT - LEFT, height: aspect * (width - RIGHT - LEFT) };
        let height = ABOVE + panel.height + BELOW + below;
        Self { canvas: Canvas::new(width, height), panel, notes, height, below }
    }

    /// The top of what is left free.
    pub fn between(&self) -> f64 {
        self.height - self.below
    }

    /// Draws the frame over what was drawn, the title above it and the notes below.
    pub fn finish(mut self, across: &Axis, up: &Axis, title: &str) -> Canvas {
        self.panel.frame(&mut self.canvas, across, up);
        heading(&mut self.canvas, &self.panel, title);
        write_notes(&mut self.canvas, &self.notes, self.height);
        self.canvas
    }
}

/// Writes the title of a slice of a grid above its panel, in two lines where it is long.
pub fn heading(canvas: &mut Canvas, panel: &Panel, title: &str) {
    let title = title.trim_start_matches([' ', ';']).trim_start_matches("at ");
    let middle = panel.left + 0.5 * panel.width;
    let length = panel.width + 0.8 * LEFT;
    let size = (7..=SMALL).rev().find(|&size| width_of(title, size) <= length);
    match (size, title.split_once("; ")) {
        (None, Some((first, second))) => {
            let fits = |size: &u32| width_of(first, *size).max(width_of(second, *size)) <= length;
            two_lines(canvas, panel, [first, second], (4..=8).rev().find(fits).unwrap_or(4));
        }
        (size, _) => canvas.text((middle, panel.top - 6.0), title, size.unwrap_or(7), Side::Middle, 0.0, BLACK),
    }
}

/// A text in lines that fit in a width where its words allow it.
pub fn wrapped(text: &str, width: f64, size: u32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if width_of(&format!("{line} {word}"), size) <= width => *line = format!("{line} {word}"),
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Writes two lines above a panel.
pub fn two_lines(canvas: &mut Canvas, panel: &Panel, lines: [&str; 2], size: u32) {
    for (line, above) in lines.into_iter().zip([14.0, 4.0]) {
        canvas.text((panel.left + 0.5 * panel.width, panel.top - above), line, size, Side::Middle, 0.0, BLACK);
    }
}

/// Space for notes below the panels.
pub fn space_of(notes: &[String]) -> f64 {
    14.0 + NOTE * notes.len().saturating_sub(1) as f64
}

/// Notes in lines that fit in a figure, each of which ends with a full stop.
pub fn in_lines(notes: &[String], width: f64) -> Vec<String> {
    let ended = |note: &String| if note.ends_with(['.', '?', '!']) { note.clone() } else { format!("{note}.") };
    notes.iter().flat_map(|note| wrapped(&ended(note), width - 2.0 * RIGHT, OF_NOTES)).collect()
}

/// Writes notes at the bottom of a figure, from its left edge: a narrow window shows this one first.
pub fn write_notes(canvas: &mut Canvas, notes: &[String], height: f64) {
    for (i, note) in notes.iter().rev().enumerate() {
        canvas.text((RIGHT, height - 4.0 - NOTE * i as f64), note, OF_NOTES, Side::Right, 0.0, GREY);
    }
}

/// The number of ticks that fit a length.
fn most(length: f64, distance: f64) -> usize {
    (length / distance).max(2.0) as usize
}

/// The space at the left of a panel of this height for its vertical axis: more than [`LEFT`] where labels are long.
pub fn left_of(vertical: &Axis, height: f64) -> f64 {
    let (ticks, _) = vertical.scale.ticks(most(height, TICK_DISTANCE.1));
    let longest = ticks.iter().map(|tick| width_of(&tick.label, SMALL)).fold(0.0, f64::max);
    // Digits are wider than letters are on average.
    (1.12 * longest + TICK + GAP + f64::from(NORMAL) + GAP).max(LEFT)
}

/// A title about a place, in a smaller font where it is long.
fn title(canvas: &mut Canvas, at: Place, text: &str, length: f64, turn: f64) {
    let size = (5..=NORMAL).rev().find(|&size| width_of(text, size) <= length).unwrap_or(5);
    canvas.text(at, text, size, Side::Middle, turn, BLACK);
}
